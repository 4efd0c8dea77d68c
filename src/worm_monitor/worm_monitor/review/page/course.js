// The course of a trial over time: its plots with what is doubtful and exchanged, and one cursor.

import * as plot from "./plots.js";
import { plain } from "./tiles.js";
import { bands, nearest, rowsWithin, trace } from "./traces.js";

export const PLOTS = ["radius", "theta", "psi", "certainty"];
export const LEAST_S = 0.5;
const MINUTES_FROM_S = 300;
const TURNS = [-180, -90, 0, 90, 180];
const byTime = (stretches) => stretches.map(({ row, last }) => [row, last]).sort((a, b) => a[0] - b[0]);

export class Course {
  // `data` are the columns by frame; canvases go by the names of the plots, and `whole`.
  constructor(trial, data, canvasOf) {
    this.trial = trial;
    this.data = data;
    this.canvasOf = canvasOf;
    this.doubts = byTime(trial.doubtful);
    this.last = Math.max(data.t[trial.frames - 1], LEAST_S);
    this.R = trial.geometries[0]?.chambers[0]?.R_mm;
    this.high = 1.25 * (this.R ?? data.r.reduce((most, r) => (r > most ? r : most), 1));
    const steps = Array.from(data.t.subarray(1, 200), (t, k) => t - data.t[k]).sort((a, b) => a - b);
    this.gap = 3.5 * (steps[steps.length >> 1] ?? 1);
    this.places = {};
    this.drawn = {};
  }

  // Draw all but the cursor: `marked` is a stretch of rows, or null.
  draw(range, curves, marked) {
    const style = getComputedStyle(document.documentElement);
    const tint = (name) => style.getPropertyValue(`--${name}`).trim();
    const { trial, data: { t }, gap, R } = this;
    const axes = (name, y, options) => timeAxes(this.canvasOf(name), range, y, options);
    this.places = {
      radius: axes("radius", [0, this.high], { label: "r, mm from the centre" }),
      theta: axes("theta", [-180, 180], { label: "θₕ, degrees; exit at 0", yticks: TURNS }),
      psi: axes("psi", [-180, 180], { label: "ψ_b, degrees", yticks: TURNS }),
      certainty: axes("certainty", [0.45, 1.22], { label: "head certainty", yticks: [0.5, trial.sure, 1] }),
    };
    const { radius, theta, psi, certainty } = this.places, { ink } = radius;
    for (const place of Object.values(this.places)) {
      bands(place, t, curves.exchanged, tint("exchanged"));
      if (marked) bands(place, t, [marked], tint("marked"));
    }
    const [begin, end] = rowsWithin(t, range), rows = [Math.max(0, begin - 1), Math.min(t.length, end + 1)];
    bands(radius, t, curves.contacts, ink.contact);
    if (R) plot.level(radius, R, ink.wall, []);
    trace(radius, t, curves.other, rows, ink.tail, { gap, width: 0.8 });
    trace(radius, t, curves.r, rows, ink.head, { gap });
    plot.level(theta, 0, ink.exit);
    trace(theta, t, curves.theta, rows, ink.head, { gap, wrap: 360 });
    trace(psi, t, curves.psi, rows, ink.body, { gap, wrap: 360 });
    bands(certainty, t, this.doubts, tint("doubt"), [0.93, 1], 2);
    plot.level(certainty, trial.sure, ink.soft, [2, 3]);
    trace(certainty, t, curves.certainty, rows, ink.head, { gap });
    for (const place of Object.values(this.places)) place.label();
    this.drawWhole(range, curves, tint("doubt"));
    for (const name of Object.keys(this.places)) this.keep(name);
  }

  // The whole trial in a strip, with the part that is shown below.
  drawWhole(range, curves, doubt) {
    const { data: { t }, last } = this, { left, right, ink } = this.places.radius;
    const [pen, , height] = plot.ready(this.canvasOf("whole"));
    const place = {
      pen, ink, left, right, top: 2, bottom: height - 2,
      px: (at) => left + (at / last) * (right - left), at: (px) => ((px - left) / (right - left)) * last,
    };
    pen.strokeStyle = ink.line; pen.strokeRect(left + 0.5, 2.5, right - left - 1, height - 5);
    bands(place, t, curves.contacts, ink.contact, [0, 0.5]);
    bands(place, t, curves.exchanged, ink.tail, [0.5, 0.72]);
    bands(place, t, this.doubts, doubt, [0.75, 1], 2);
    const [begin, end] = range.map(place.px);
    pen.strokeStyle = ink.ink; pen.lineWidth = 1.5; pen.strokeRect(begin + 0.75, 1.5, Math.max(2, end - begin - 1.5), height - 3);
    this.places.whole = place;
  }

  // Keep a plot as it is without the cursor: the curves are not drawn anew for each frame.
  keep(name) {
    const canvas = this.canvasOf(name), { width, height } = canvas;
    this.drawn[name] = width && height ? new OffscreenCanvas(width, height) : null; // none while it is not laid out
    this.drawn[name]?.getContext("2d").drawImage(canvas, 0, 0);
  }

  drawCursor(row) {
    for (const [name, place] of Object.entries(this.places)) {
      if (!this.drawn[name]) continue;
      const [pen] = plot.ready(this.canvasOf(name));
      pen.save();
      pen.setTransform(1, 0, 0, 1, 0, 0);
      pen.drawImage(this.drawn[name], 0, 0);
      pen.restore();
      plot.upright(place, this.data.t[row], place.ink.ink);
    }
  }

  // The row of the frame that is next to a place on a plot.
  rowAt(name, clientX) {
    return nearest(this.data.t, this.places[name].at(clientX - this.canvasOf(name).getBoundingClientRect().left));
  }
}

// Axes over seconds, which say minutes where they are many.
function timeAxes(canvas, range, y, options) {
  const [unit, name] = range[1] - range[0] > MINUTES_FROM_S ? [60, "min"] : [1, "s"];
  const xformat = (value) => plain(Number(value.toFixed(2)), name);
  const place = plot.axes(canvas, range.map((t) => t / unit), y, { xformat, ...options });
  return { ...place, px: (t) => place.px(t / unit), at: (px) => place.at(px) * unit };
}
