// Plots on a canvas. Of the libraries whose scripts come inside Python packages none runs where a
// page may have neither inline styles nor scripts from elsewhere, so these few lines are ours.

const FONT = "11px system-ui, sans-serif";
const LEFT = 38, RIGHT = 6, TOP = 6, BOTTOM = 17;

export function colours() {
  const style = getComputedStyle(document.documentElement);
  const names = ["ink", "soft", "line", "head", "centroid", "tail", "wall", "exit", "body", "contact", "ground"];
  return Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}

export function ready(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = FONT;
  return [pen, width, height];
}

export function ticks(low, high, most) {
  const raw = (high - low) / Math.max(1, most);
  if (!(raw > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * power).find((k) => k >= raw * 0.999);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k += 1) found.push(k * step);
  return found;
}

const plain = (value) => String(Number(value.toPrecision(4))).replace("-", "−");

// Axes of a plot: what maps numbers to places, with the frame and its ticks drawn.
export function axes(canvas, x, y, { label = "", log = false, yticks = null, xformat = plain } = {}) {
  const [pen, width, height] = ready(canvas);
  const ink = colours();
  const low = log ? Math.log10(y[0]) : y[0], high = log ? Math.log10(y[1]) : y[1];
  const right = width - RIGHT, bottom = height - BOTTOM;
  const place = {
    pen, ink, x, left: LEFT, right, top: TOP, bottom,
    px: (value) => LEFT + ((value - x[0]) / (x[1] - x[0] || 1)) * (right - LEFT),
    py: (value) => bottom - (((log ? Math.log10(value) : value) - low) / (high - low || 1)) * (bottom - TOP),
    at: (px) => x[0] + ((px - LEFT) / (right - LEFT)) * (x[1] - x[0]),
  };
  pen.lineWidth = 1;
  pen.textBaseline = "middle";
  pen.textAlign = "right";
  const marks = yticks || (log ? decades(y) : ticks(y[0], y[1], (bottom - TOP) / 28));
  for (const value of marks) {
    const at = Math.round(place.py(value)) + 0.5;
    pen.strokeStyle = ink.line;
    pen.beginPath(); pen.moveTo(LEFT, at); pen.lineTo(right, at); pen.stroke();
    pen.fillStyle = ink.soft;
    pen.fillText(log ? power(value) : plain(value), LEFT - 4, at);
  }
  pen.textAlign = "center";
  pen.textBaseline = "top";
  for (const value of ticks(x[0], x[1], (right - LEFT) / 64)) {
    const at = Math.min(Math.max(place.px(value), LEFT + 8), right - 12);
    pen.fillText(xformat(value), at, bottom + 4);
  }
  if (label) {
    place.label = () => {
      pen.textAlign = "left"; pen.textBaseline = "top"; pen.lineJoin = "round";
      pen.strokeStyle = ink.ground; pen.lineWidth = 4; pen.strokeText(label, LEFT + 5, TOP + 1);
      pen.fillStyle = ink.ink; pen.fillText(label, LEFT + 5, TOP + 1);
    };
  }
  return place;
}

function decades([low, high]) {
  const found = [];
  for (let k = Math.ceil(Math.log10(low) - 1e-9); 10 ** k <= high * 1.001; k += 1) found.push(10 ** k);
  return found;
}

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
function power(value) {
  const k = Math.round(Math.log10(value));
  return k === 0 ? "1" : `10${k < 0 ? "⁻" : ""}${[...String(Math.abs(k))].map((d) => SUPERSCRIPTS[d]).join("")}`;
}

export function within(place, draw) {
  const { pen, left, right, top, bottom } = place;
  pen.save();
  pen.beginPath(); pen.rect(left, top, right - left, bottom - top); pen.clip();
  draw(pen);
  pen.restore();
}

// A line through rows; broken where there is no number, time passes, or an angle comes round.
export function line(place, rows, column, colour, { gap = Infinity, wrap = 0, width = 1.3 } = {}) {
  within(place, (pen) => {
    pen.strokeStyle = colour; pen.lineWidth = width; pen.lineJoin = "round";
    pen.beginPath();
    let before = null;
    const every = Math.max(1, Math.floor(rows.length / (2 * (place.right - place.left))));
    for (let k = 0; k < rows.length; k += every) {
      const [t, value] = [rows[k][0], rows[k][column]];
      if (value === null || value === undefined) { before = null; continue; }
      const broken = before === null || t - before[0] > gap * every || (wrap && Math.abs(value - before[1]) > wrap / 2);
      if (broken) {
        pen.moveTo(place.px(t), place.py(value));
        pen.lineTo(place.px(t) + 0.6, place.py(value));
      } else pen.lineTo(place.px(t), place.py(value));
      before = [t, value];
    }
    pen.stroke();
  });
}

export function bands(place, rows, column, gap) {
  within(place, (pen) => {
    pen.fillStyle = place.ink.contact;
    let began = null, last = null;
    const end = () => {
      if (began !== null) pen.fillRect(place.px(began), place.top, Math.max(1, place.px(last) - place.px(began)), place.bottom - place.top);
      began = null;
    };
    for (const row of rows) {
      if (last !== null && row[0] - last > gap) end();
      last = row[0];
      if (row[column] === 1) began = began ?? row[0];
      else end();
    }
    end();
  });
}

export function level(place, value, colour, dash = [5, 4]) {
  within(place, (pen) => {
    pen.strokeStyle = colour; pen.setLineDash(dash); pen.lineWidth = 1.4;
    pen.beginPath(); pen.moveTo(place.left, place.py(value)); pen.lineTo(place.right, place.py(value)); pen.stroke();
  });
}

export function upright(place, value, colour, dash = []) {
  within(place, (pen) => {
    pen.strokeStyle = colour; pen.lineWidth = 1; pen.setLineDash(dash);
    pen.beginPath(); pen.moveTo(place.px(value), place.top); pen.lineTo(place.px(value), place.bottom); pen.stroke();
  });
}

export function curve(place, xs, ys, colour, { dash = [], width = 1.5 } = {}) {
  within(place, (pen) => {
    pen.strokeStyle = colour; pen.lineWidth = width; pen.setLineDash(dash);
    pen.beginPath();
    let drawing = false;
    xs.forEach((x, k) => {
      if (ys[k] === null || ys[k] === undefined) { drawing = false; return; }
      if (drawing) pen.lineTo(place.px(x), place.py(ys[k]));
      else pen.moveTo(place.px(x), place.py(ys[k]));
      drawing = true;
    });
    pen.stroke();
  });
}

export function points(place, xs, ys, errors, colour) {
  within(place, (pen) => {
    pen.strokeStyle = pen.fillStyle = colour; pen.lineWidth = 1;
    const every = Math.max(1, Math.floor(xs.length / ((place.right - place.left) / 5)));
    for (let k = 0; k < xs.length; k += every) {
      if (ys[k] === null) continue;
      const [x, y] = [place.px(xs[k]), place.py(ys[k])];
      pen.globalAlpha = errors && errors[k] === null ? 0.35 : 1; // too few pairs to tell its error
      if (errors && errors[k] !== null) {
        pen.beginPath(); pen.moveTo(x, place.py(ys[k] - errors[k])); pen.lineTo(x, place.py(ys[k] + errors[k])); pen.stroke();
      }
      pen.beginPath(); pen.arc(x, y, 1.8, 0, 7); pen.fill();
    }
  });
}

// Density of a histogram as steps; `together` puts so many bins into one.
export function density({ edges, counts }, together = 1) {
  const total = counts.reduce((sum, n) => sum + n, 0);
  const bins = [];
  for (let k = 0; k < counts.length; k += together) {
    const last = Math.min(k + together, counts.length);
    const n = counts.slice(k, last).reduce((sum, m) => sum + m, 0);
    bins.push({ low: edges[k], high: edges[last], n, p: n / total / (edges[last] - edges[k]) });
  }
  return total ? bins : [];
}

// Bins as steps; on a logarithmic axis an empty one is a gap.
export function steps(place, bins, colour, log = false) {
  within(place, (pen) => {
    pen.strokeStyle = colour; pen.lineWidth = 1.5;
    pen.beginPath();
    let drawing = false;
    for (const { low, high, p } of bins) {
      if (log && !p) { drawing = false; continue; }
      const y = place.py(p);
      if (drawing) pen.lineTo(place.px(low), y); else pen.moveTo(place.px(low), y);
      pen.lineTo(place.px(high), y);
      drawing = true;
    }
    pen.stroke();
  });
}

// Lanes with names above a logarithmic axis of seconds.
export function lanes(canvas, x, names) {
  const [pen, width, height] = ready(canvas);
  const ink = colours();
  const left = 66, right = width - 12, bottom = height - BOTTOM;
  const [low, high] = x.map(Math.log10);
  const place = {
    pen, ink, left, right, top: TOP, bottom,
    px: (value) => left + ((Math.log10(value) - low) / (high - low || 1)) * (right - left),
    py: (k) => TOP + ((k + 0.62) * (bottom - TOP)) / names.length,
  };
  pen.lineWidth = 1; pen.textBaseline = "top"; pen.textAlign = "center";
  for (const value of decades(x)) {
    const at = Math.round(place.px(value)) + 0.5;
    pen.strokeStyle = ink.line;
    pen.beginPath(); pen.moveTo(at, TOP); pen.lineTo(at, bottom); pen.stroke();
    pen.fillStyle = ink.soft;
    pen.fillText(value === x[1] ? `${plain(value)} s` : plain(value), Math.min(at, right - 8), bottom + 4);
  }
  pen.textAlign = "right"; pen.textBaseline = "middle"; pen.fillStyle = ink.ink;
  names.forEach((name, k) => pen.fillText(name, left - 6, place.py(k)));
  return place;
}

// A value with its interval in a lane, and its words above.
export function span(place, lane, value, low, high, colour, words) {
  const { pen } = place, y = place.py(lane);
  pen.strokeStyle = pen.fillStyle = colour; pen.lineWidth = 3;
  if (low > 0 && high > 0) {
    pen.globalAlpha = 0.55;
    pen.beginPath(); pen.moveTo(place.px(low), y); pen.lineTo(place.px(high), y); pen.stroke();
    pen.globalAlpha = 1;
  }
  const at = place.px(Math.max(value, 1e-9));
  pen.beginPath(); pen.arc(at, y, 4, 0, 7); pen.fill();
  pen.textAlign = at > (place.left + place.right) / 2 ? "right" : "left"; pen.textBaseline = "bottom";
  pen.fillText(words, at, y - 5);
}

export function nothing(canvas, text) {
  const [pen, width, height] = ready(canvas);
  pen.fillStyle = colours().soft; pen.textAlign = "center"; pen.textBaseline = "middle";
  pen.fillText(text, width / 2, height / 2);
}
