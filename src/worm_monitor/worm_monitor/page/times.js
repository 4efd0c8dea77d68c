// Distances and angles over time: three plots on one axis, with one cursor.

import * as plot from "./plots.js";
import { clock, plain } from "./tiles.js";

const [T, R_H, R_C, R_T, THETA, PSI_B, PSI_H, CONTACT] = [0, 1, 2, 3, 4, 5, 6, 7];
const id = (name) => document.getElementById(name);

export class Times {
  // `mark` asks for a drawing; `pick` is told the time that is clicked at.
  constructor(mark, pick) {
    this.mark = mark;
    this.span = 0;
    this.middle = null; // null: the window follows the trial
    this.cursor = this.pin = null;
    this.places = {};
    for (const button of id("spans").children) button.onclick = () => this.choose(Number(button.dataset.span));
    for (const name of ["radii", "theta", "psi"]) {
      const canvas = id(name);
      const at = ({ clientX }) => this.places[name]?.at(clientX - canvas.getBoundingClientRect().left) ?? null;
      canvas.onpointermove = (event) => { this.cursor = at(event); mark(); };
      canvas.onpointerleave = () => { this.cursor = this.pin; mark(); };
      canvas.onclick = (event) => { if (at(event) !== null) { this.hold(at(event)); pick(this.pin); } };
    }
  }

  choose(span) {
    this.span = span;
    this.middle = span && this.pin !== null ? this.pin : null;
    for (const button of id("spans").children) button.setAttribute("aria-pressed", String(Number(button.dataset.span) === span));
    this.mark();
  }

  // Keep the cursor at a time; null lets it go, and the window follows the trial again.
  hold(seconds) {
    this.cursor = this.pin = seconds;
    if (seconds === null) this.middle = null;
    this.mark();
  }

  // Hold the cursor at a time, and move the window to it.
  jump(seconds) {
    this.hold(seconds);
    if (this.span) this.middle = seconds;
  }

  inView(rows) {
    if (!rows.length) return [[], [0, 1], Infinity];
    const newest = rows[rows.length - 1][T];
    const last = this.middle === null ? newest : Math.min(newest, Math.max(this.middle + this.span / 2, rows[0][T] + this.span));
    const first = this.span ? Math.max(rows[0][T], last - this.span) : rows[0][T];
    let end = rows.length;
    while (end > 0 && rows[end - 1][T] > last) end -= 1;
    let k = end;
    while (k > 0 && rows[k - 1][T] >= first) k -= 1;
    const steps = rows.slice(-50).map((row, j, all) => (j ? row[T] - all[j - 1][T] : Infinity)).sort((a, b) => a - b);
    return [rows.slice(k, end), [first, Math.max(last, first + 5)], 3 * (steps[Math.floor(steps.length / 2)] ?? 1)];
  }

  draw({ rows: all, geometry }) {
    const [rows, range, gap] = this.inView(all);
    const chamber = geometry?.chambers[0];
    const high = chamber ? 1.08 * chamber.R_mm : 1.08 * Math.max(1, ...rows.map((row) => row[R_H] ?? 0));
    const xformat = minutes(range);
    const radii = plot.axes(id("radii"), range, [0, high], { label: "r, mm from the centre", xformat });
    const { ink } = radii;
    plot.bands(radii, rows, CONTACT, gap);
    if (chamber) plot.level(radii, chamber.R_mm, ink.wall, []);
    plot.line(radii, rows, R_T, ink.tail, { gap });
    plot.line(radii, rows, R_C, ink.centroid, { gap });
    plot.line(radii, rows, R_H, ink.head, { gap });
    const turns = [-180, -90, 0, 90, 180];
    const theta = plot.axes(id("theta"), range, [-180, 180], { label: "θₕ, degrees; exit at 0", yticks: turns, xformat });
    plot.level(theta, 0, ink.exit);
    plot.line(theta, rows, THETA, ink.head, { gap, wrap: 360 });
    const psi = plot.axes(id("psi"), range, [-180, 180], { label: "ψ, degrees", yticks: turns, xformat });
    plot.line(psi, rows, PSI_H, ink.head, { gap, wrap: 360, width: 0.8 });
    plot.line(psi, rows, PSI_B, ink.body, { gap, wrap: 360, width: 1.5 });
    this.places = { radii, theta, psi };
    for (const place of Object.values(this.places)) place.label();
    this.drawCursor(rows, range, gap);
  }

  drawCursor(rows, [first, last], gap) {
    const text = id("cursor");
    id("release").hidden = this.pin === null;
    text.textContent = "";
    if (this.cursor === null || !rows.length) return;
    if (this.pin !== null && this.pin !== this.cursor) this.upright(this.pin, "line");
    if (this.cursor < first || this.cursor > last) return;
    this.upright(this.cursor, "ink");
    let nearest = rows[0];
    for (const row of rows) if (Math.abs(row[T] - this.cursor) < Math.abs(nearest[T] - this.cursor)) nearest = row;
    if (Math.abs(nearest[T] - this.cursor) > gap) { text.textContent = `${clock(this.cursor)}  nothing measured`; return; }
    const value = (column, digits = 0) => plain(nearest[column] === null ? null : Number(nearest[column].toFixed(digits)));
    text.textContent = `${clock(nearest[T])}  r ${value(R_H, 2)}, ${value(R_C, 2)}, ${value(R_T, 2)} mm; θ_h ${value(THETA)}°; ψ_b ${value(PSI_B)}°`;
  }

  upright(seconds, colour) {
    for (const place of Object.values(this.places)) plot.upright(place, seconds, place.ink[colour]);
  }
}

// Seconds of a short window, minutes and seconds of one that goes on for minutes.
function minutes([, last]) {
  if (last < 300) return (seconds) => plain(Number(seconds.toPrecision(6)));
  return (seconds) => `${Math.floor(seconds / 60)}:${String(Math.round(seconds % 60)).padStart(2, "0")}`;
}
