// The table: what is now, this trial's numbers with interval and n, the walk's and the paper's.

import { plain } from "./tiles.js";

const SHOWN = [
  ["d_c", "d<sub>c</sub>, along the wall in contact"], ["d_nc", "d<sub>nc</sub>, out of contact"],
  ["delta_r_h", "Δr<sub>h</sub>, how far from the wall"], ["v_w", "v<sub>w</sub>, speed along the wall"],
  ["r_h_over_R", "r<sub>h</sub>/R, most frequent"], ["r_c_over_R", "r<sub>c</sub>/R, most frequent"],
  ["psi_b_negative_peak", "ψ<sub>b</sub>, clockwise peak"], ["psi_b_positive_peak", "ψ<sub>b</sub>, counter-clockwise peak"],
  ["t_per", "t<sub>per</sub>, keeps its direction"], ["tau_h", "τ<sub>h</sub>, until the head finds the exit"],
  ["n_s", "n<sub>s</sub>, skips of the exit"], ["success", "success, attempts that are an escape"],
];
const units = (unit) => (unit === "1" ? "" : unit === "deg" ? "°" : unit);

// Rows that differ are written; returns what is written, to be given again.
export function fillNumbers(body, told, before) {
  const { quantities = {}, walk = {} } = told;
  const rows = SHOWN.filter(([name]) => quantities[name]).map(([name, words]) => {
    const { value, low, high, n, unit, paper, why } = quantities[name];
    const shown = units(unit);
    const interval = low === null || high === null ? "" : `${plain(low)} … ${plain(high)}`;
    const walked = walk[name]?.value ?? null;
    return [words, momentary(name, told), value === null ? null : plain(value, shown), interval, String(n), walked === null ? "–" : plain(walked, units(walk[name].unit)), plain(paper, shown), why];
  });
  const written = JSON.stringify(rows);
  if (written === before) return written;
  body.replaceChildren(...rows.map(([words, now, value, interval, n, walked, paper, why]) => {
    const row = document.createElement("tr");
    const cell = (text, name = "") => { const made = document.createElement("td"); made.textContent = text; made.className = name; row.append(made); return made; };
    const first = cell("");
    for (const [k, part] of words.split(/<sub>|<\/sub>/).entries()) {
      const piece = document.createElement(k % 2 ? "sub" : "span");
      piece.textContent = part;
      first.append(piece);
    }
    cell(now, "now");
    if (value === null) cell(why, "why").colSpan = 2;
    else { cell(value); cell(interval); }
    cell(n); cell(walked, "walked"); cell(paper);
    return row;
  }));
  return written;
}

// What a quantity is at this moment, where that means something.
function momentary(name, told) {
  const now = told.now ?? {}, R = told.geometry?.chambers[0]?.R_mm, { forecast } = told;
  const share = (r) => (R && r !== null && r !== undefined ? (r / R).toFixed(3) : "");
  if (name === "tau_h" && forecast && forecast.median !== null) return `${forecast.median} s to go (${forecast.low} … ${forecast.high})`;
  if (!now.where?.startsWith("chamber")) return "";
  if (name === "r_h_over_R") return share(now.r_h);
  if (name === "r_c_over_R") return share(now.r_c);
  if (name === "v_w" && now.v_b !== null && now.v_b !== undefined) return plain(Number(Math.abs(now.v_b).toFixed(2)), "mm/s");
  const side = { psi_b_negative_peak: -1, psi_b_positive_peak: 1 }[name];
  return side && Math.sign(now.psi_b ?? 0) === side ? plain(now.psi_b, "°") : "";
}
