// Plots of all frames of a trial: however many there are, no peak is left out.

import { within } from "./plots.js";

// Rows [from, to) whose times are in a range; `ts` ascends.
export function rowsWithin(ts, [begin, end]) {
  return [firstAfter(ts, begin), firstAfter(ts, end)];
}

export function firstAfter(ts, t) {
  let low = 0, high = ts.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (ts[middle] < t) low = middle + 1; else high = middle;
  }
  return low;
}

export function nearest(ts, t) {
  const k = Math.min(ts.length - 1, firstAfter(ts, t));
  return k > 0 && t - ts[k - 1] < ts[k] - t ? k - 1 : k;
}

// A line through rows [from, to): of all that fall on one pixel the first, least, greatest and last.
// Broken where there is no number, time passes, or an angle comes round.
export function trace(place, ts, values, [from, to], colour, { gap = Infinity, wrap = 0, width = 1.2 } = {}) {
  within(place, (pen) => {
    pen.strokeStyle = colour; pen.lineWidth = width; pen.lineJoin = "round";
    pen.beginPath();
    let x = 0, low = 0, high = 0, last = 0, t = 0, drawing = false;
    const end = () => {
      if (!drawing) return;
      if (low < high) { pen.lineTo(x, place.py(low)); pen.lineTo(x, place.py(high)); }
      pen.lineTo(x + 0.5, place.py(last));
    };
    for (let k = from; k < to; k += 1) {
      const value = values[k];
      if (Number.isNaN(value)) { end(); drawing = false; continue; }
      const at = place.px(ts[k]);
      const broken = !drawing || ts[k] - t > gap || (wrap && Math.abs(value - last) > wrap / 2);
      if (broken || at - x >= 1) {
        end();
        if (broken) pen.moveTo(at, place.py(value)); else pen.lineTo(at, place.py(value));
        x = at; low = high = value; drawing = true;
      } else {
        low = Math.min(low, value); high = Math.max(high, value);
      }
      last = value; t = ts[k];
    }
    end();
    pen.stroke();
  });
}

// Runs [first, last] of rows for which something is true.
export function runs(count, isTrue) {
  const found = [];
  for (let k = 0; k < count; k += 1) {
    if (!isTrue(k)) continue;
    const first = k;
    while (k + 1 < count && isTrue(k + 1)) k += 1;
    found.push([first, k]);
  }
  return found;
}

// Runs as bands, none so narrow that it is not seen; `part` is their part of the height, from the top.
export function bands(place, ts, those, colour, part = [0, 1], least = 1) {
  within(place, (pen) => {
    pen.fillStyle = colour;
    const tall = place.bottom - place.top;
    let drawn = -Infinity;
    for (const [first, last] of those) {
      const begin = Math.max(place.px(ts[first]), drawn), end = place.px(ts[Math.min(last + 1, ts.length - 1)]);
      if (end < place.left || end <= drawn) continue;
      if (begin > place.right) break;
      const wide = Math.max(least, end - begin);
      pen.fillRect(begin, place.top + part[0] * tall, wide, (part[1] - part[0]) * tall);
      drawn = begin + wide;
    }
  });
}
