// The curves of a trial as they are once head and tail are exchanged as asked for.

import { runs } from "./traces.js";

function swapped(trial, data, rowOf, pairs) {
  const found = new Uint8Array(trial.frames);
  for (const [first, last] of pairs) {
    for (let row = rowOf(first); row < found.length && (last === null || data.frame[row] <= last); row += 1) found[row] = 1;
  }
  return found;
}

// What is wished is exchanged in the end, what is changed is not so in the results yet.
export function exchanged(trial, data, entries, rowOf) {
  const swaps = entries.filter(({ what }) => what === "swap_head").map((entry) => [entry.first_frame, entry.last_frame]);
  const before = swapped(trial, data, rowOf, trial.applied);
  const wished = swapped(trial, data, rowOf, swaps);
  const changed = wished.map((is, k) => is ^ before[k]);
  const either = (name) => data[name].map((value, k) => (changed[k] ? data[`${name}_exchanged`][k] : value));
  return {
    wished, changed, r: either("r"), theta: either("theta"), psi: either("psi"),
    other: data.r_exchanged.map((value, k) => (changed[k] ? data.r[k] : value)),
    certainty: data.certainty.map((value, k) => (changed[k] ? NaN : value)),
    contacts: runs(trial.frames, (k) => data.contact[k] === 1 && !changed[k]),
    exchanged: runs(trial.frames, (k) => wished[k]),
  };
}
