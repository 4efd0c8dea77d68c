// Plots of what the trial's numbers say: correlation, lengths, distributions, the forecast.

import * as plot from "./plots.js";
import { plain } from "./tiles.js";

const POINTS = 60;
const BINS_A_MEAN = 2; // as in the report

export function drawCorrelation(canvas, { correlation, model_correlation: walk, quantities }) {
  if (!correlation?.lag.length || !correlation.c.some((c) => c !== null)) { plot.nothing(canvas, "no pairs of moments yet"); return; }
  const far = Math.max(10, ...correlation.lag.filter((lag, k) => correlation.c[k] !== null));
  const place = plot.axes(canvas, [0, far], [-1, 1.05], { label: "" });
  plot.level(place, 0, place.ink.soft, [2, 3]);
  plot.points(place, correlation.lag, correlation.c, correlation.error, place.ink.head);
  const t_per = quantities?.t_per?.value;
  if (t_per) plot.curve(place, correlation.lag, correlation.lag.map((lag) => Math.exp(-lag / t_per)), place.ink.soft, { dash: [5, 4] });
  if (walk) plot.curve(place, walk.lag, walk.c, place.ink.exit);
}

const exponential = (xs, mean) => xs.map((x) => Math.exp(-x / mean) / mean);

// Densities of lengths on a logarithmic axis, where an exponential law is a straight line:
// the trial's own mean dashed, the walk's in its colour, the paper's dotted.
export function drawLengths(canvas, told, kinds) {
  const known = kinds.map(([number, colour]) => {
    const histogram = told[`P_${number}`];
    if (!histogram?.counts.some((n) => n)) return null;
    const { value = null, paper = null } = told.quantities?.[number] ?? {};
    const bin = histogram.edges[1] - histogram.edges[0];
    const bins = plot.density(histogram, Math.max(1, Math.round((value ?? paper ?? 2) / BINS_A_MEAN / bin)));
    return { bins, mean: value, paper, walk: told.walk?.[number]?.value ?? null, colour };
  }).filter(Boolean);
  if (!known.length) { plot.nothing(canvas, "none has closed yet"); return; }
  const all = known.flatMap(({ bins }) => bins).filter(({ p }) => p > 0);
  const far = Math.max(...all.map(({ high }) => high), ...known.map(({ paper }) => 3 * (paper ?? 0)));
  const most = Math.max(...all.map(({ p }) => p), ...known.map(({ mean }) => (mean ? 1 / mean : 0)));
  const floor = 10 ** Math.floor(Math.log10(Math.min(...all.map(({ p }) => p))));
  const place = plot.axes(canvas, [0, far], [floor, 10 ** Math.ceil(Math.log10(most * 1.05))], { log: true });
  const xs = Array.from({ length: POINTS }, (_, k) => (far * k) / (POINTS - 1));
  for (const { bins, mean, paper, walk, colour } of known) {
    plot.steps(place, bins, place.ink[colour], true);
    if (paper) plot.curve(place, xs, exponential(xs, paper), place.ink[colour], { dash: [1, 4], width: 1.2 });
    if (walk) plot.curve(place, xs, exponential(xs, walk), place.ink.exit, { width: 1 });
    if (mean) plot.curve(place, xs, exponential(xs, mean), place.ink[colour], { dash: [6, 4], width: 1.3 });
  }
}

export function drawRadius(canvas, told) {
  const known = [["P_r_t", "tail"], ["P_r_c", "centroid"], ["P_r_h", "head"]].filter(([name]) => told[name]?.counts.some((n) => n));
  if (!known.length) { plot.nothing(canvas, "no distances yet"); return; }
  const R = told.geometry?.chambers[0]?.R_mm ?? 1;
  const drawn = known.map(([name, colour]) => {
    const size = told[name].unit === "mm" ? R : 1;
    const scaled = { edges: told[name].edges.map((edge) => edge / size), counts: told[name].counts };
    return [plot.density(scaled, Math.max(1, Math.round(0.025 / (scaled.edges[1] - scaled.edges[0])))), colour];
  });
  const most = Math.max(...drawn.flatMap(([bins]) => bins.map(({ p }) => p)));
  const place = plot.axes(canvas, [0, 1.05], [0, 1.08 * most]);
  plot.upright(place, 1, place.ink.wall);
  for (const [bins, colour] of drawn) plot.steps(place, bins, place.ink[colour]);
}

export function drawAngle(canvas, { P_psi_b: histogram, quantities }) {
  if (!histogram?.counts.some((n) => n)) { plot.nothing(canvas, "no angles yet"); return; }
  const bins = plot.density(histogram, Math.max(1, Math.round(6 / (histogram.edges[1] - histogram.edges[0]))));
  const place = plot.axes(canvas, [-180, 180], [0, 1.08 * Math.max(...bins.map(({ p }) => p))]);
  plot.upright(place, 0, place.ink.line);
  plot.steps(place, bins, place.ink.body);
  for (const name of ["psi_b_negative_peak", "psi_b_positive_peak"]) {
    const { value = null, paper = null } = quantities?.[name] ?? {};
    if (paper !== null) plot.upright(place, paper, place.ink.soft, [1, 4]);
    if (value !== null) plot.upright(place, value, place.ink.body, [6, 4]);
  }
}

// When the head finds the exit: from now on, by this trial's own mean, and by the walk's.
export function drawForecast(canvas, { forecast, quantities, walk }) {
  const own = quantities?.tau_h, walked = walk?.tau_h;
  const rows = [];
  if (forecast && forecast.median !== null) rows.push(["from now", forecast.median, forecast.low, forecast.high, "head"]);
  if (own && own.value !== null) rows.push(["trial ⟨τₕ⟩", own.value, own.low, own.high, "ink"]);
  if (walked && walked.value !== null) rows.push(["walk ⟨τₕ⟩", walked.value, walked.low, walked.high, "exit"]);
  if (!rows.length) { plot.nothing(canvas, "no forecast: the head is in no chamber"); return; }
  const ends = rows.flatMap(([, ...numbers]) => numbers.slice(0, 3)).filter((number) => number > 0);
  const range = [10 ** Math.floor(Math.log10(Math.min(1, ...ends))), 10 ** Math.ceil(Math.log10(Math.max(...ends)))];
  const place = plot.lanes(canvas, range, rows.map(([name]) => name));
  rows.forEach(([, value, low, high, colour], k) => plot.span(place, k, value, low, high, place.ink[colour], `${plain(value)} s`));
}
