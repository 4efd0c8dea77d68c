// The page: takes what the monitor sends, and draws what has changed.

import * as plot from "./plots.js";
import { Picture } from "./picture.js";
import { clock, plain, tiles } from "./tiles.js";

const DRAW_EVERY_MS = 250;
const MOST_EVENTS = 400;
const [T, R_H, R_C, R_T, THETA, PSI_B, PSI_H, CONTACT] = [0, 1, 2, 3, 4, 5, 6, 7];
const SHOWN = [
  ["d_c", "d<sub>c</sub>, along the wall in contact"], ["d_nc", "d<sub>nc</sub>, out of contact"],
  ["delta_r_h", "Δr<sub>h</sub>, how far from the wall"], ["v_w", "v<sub>w</sub>, speed along the wall"],
  ["r_h_over_R", "r<sub>h</sub>/R, most frequent"], ["r_c_over_R", "r<sub>c</sub>/R, most frequent"],
  ["psi_b_negative_peak", "ψ<sub>b</sub>, clockwise peak"], ["psi_b_positive_peak", "ψ<sub>b</sub>, counter-clockwise peak"],
  ["t_per", "t<sub>per</sub>, keeps its direction"], ["tau_h", "τ<sub>h</sub>, until the head finds the exit"],
  ["n_s", "n<sub>s</sub>, skips of the exit"],
];
const id = (name) => document.getElementById(name);
const told = { rows: [], events: [] };
const picture = new Picture(id("picture"), id("closeup"));
const view = { span: 0, cursor: null, dirty: new Set(), drawn: 0, note: null };
let socket = null, heard = 0, places = {};

function connect() {
  const address = new URL("socket", location.href);
  address.protocol = "ws:";
  socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) => {
    heard = performance.now();
    if (typeof data === "string") take(JSON.parse(data));
    else showPicture(data);
  };
  socket.onopen = () => link("connected", false);
  socket.onclose = () => {
    if (told.now?.ended) {
      link("the trial has ended: its report has the final numbers", false);
      mark("head");
    } else link("no connection: what is shown is the last that came", true);
    for (const name of ["swap", "pause", "step"]) id(name).disabled = true;
    setTimeout(connect, 1500);
  };
}

function link(text, gone) {
  id("link").textContent = text;
  id("link").classList.toggle("gone", gone);
}

function ask(what, value) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ do: what, value }));
}

async function showPicture(data) {
  try {
    const head = await picture.show(data);
    const { pose } = head;
    id("stamp").textContent = pose ? `${head.t.toFixed(2)} s, frame ${pose.frame}` : "its pose is not given yet";
    mark("picture");
  } finally {
    requestAnimationFrame(() => {
      if (socket?.readyState === WebSocket.OPEN) socket.send('{"shown": true}');
    });
  }
}

function take(news) {
  if (news.all) told.events = [];
  if (news.rows) {
    told.rows = news.anew ? news.rows : told.rows.concat(news.rows);
    mark("time");
  }
  if (news.events) {
    told.events = told.events.concat(news.events).slice(-MOST_EVENTS);
    mark("events");
  }
  for (const [name, value] of Object.entries(news)) {
    if (["rows", "anew", "events", "all"].includes(name)) continue;
    told[name] = value;
    if (name === "correlation" || name === "model_correlation") mark("correlation");
    else if (name === "P_d_c" || name === "P_d_nc") mark("lengths");
    else if (name.startsWith("P_r_")) mark("radius");
    else if (name === "P_psi_b") mark("angle");
    else if (name === "quantities") { mark("numbers"); mark("lengths"); mark("correlation"); }
    else if (name === "forecast") mark("numbers");
    else mark("head");
    if (name === "now" && !view.dirty.has("numbers")) mark("numbers");
    if (name === "geometry") { mark("picture"); mark("time"); }
  }
}

function mark(what) {
  view.dirty.add(what);
}

function draw(now) {
  requestAnimationFrame(draw);
  if (heard && socket?.readyState === WebSocket.OPEN && now - heard > 3000) link(`nothing has come for ${Math.round((now - heard) / 1000)} s`, true);
  else if (socket?.readyState === WebSocket.OPEN) link("connected", false);
  if (view.dirty.has("picture")) { view.dirty.delete("picture"); picture.draw(told.geometry); }
  if (now - view.drawn < DRAW_EVERY_MS || !view.dirty.size) return;
  view.drawn = now;
  for (const what of view.dirty) DRAWERS[what]();
  view.dirty.clear();
}

const DRAWERS = {
  picture: () => picture.draw(told.geometry),
  head: drawHead, time: drawTime, events: drawEvents, numbers: drawNumbers,
  correlation: drawCorrelation, lengths: drawLengths, radius: drawRadius, angle: drawAngle,
};

const milliseconds = (seconds) => (seconds === undefined ? "–" : seconds < 1 ? `${Math.round(1000 * seconds)} ms` : `${seconds.toFixed(1)} s`);

function drops() {
  const values = told.health?.image_source?.values ?? {};
  return ["frames skipped", "frames lost"].reduce((sum, key) => sum + Number(values[key] ?? 0), 0);
}

function drawHead() {
  const now = told.now ?? {};
  const chambers = told.geometry?.chambers ?? [];
  const here = chambers.find((chamber) => chamber.name === now.where) ?? chambers[0] ?? {};
  const kind = id("kind");
  kind.textContent = now.ended ? "ENDED" : now.replay ? "REPLAY" : now.replay === false ? "LIVE" : "…";
  kind.classList.toggle("live", now.replay === false && !now.ended);
  id("clock").textContent = now.t === undefined ? "–" : clock(now.t);
  const outcome = id("outcome");
  if (now.status !== undefined) {
    outcome.textContent = now.status === "tracked" ? "tracked" : `${now.has_pose ? "" : "LOST: "}${now.status.replaceAll("_", " ")}. ${now.reason}`;
    outcome.classList.toggle("lost", !now.has_pose);
  }
  if (now.status === undefined && now.taken) outcome.textContent = `${now.taken} frames in: told once it is clear which end is the head`;
  const source = told.health?.image_source;
  id("complaint").textContent = source?.level ? source.message : "";
  const lost = drops(), speed = now.v_b;
  const turns = speed === null || speed === undefined ? "–" : Math.abs(speed) < 0.02 ? "still" : `${speed > 0 ? "CCW" : "CW"} ${Math.abs(speed).toFixed(2)} mm/s`;
  const contact = now.contact === true ? "yes" : now.contact === false ? "no" : "–";
  const certain = now.has_pose ? now.certainty?.toFixed(2) ?? "–" : "LOST";
  tiles(id("tiles"), [
    ["contact", contact, now.contact ? "on" : ""],
    ["direction", turns, "wide"],
    ["where", plain(now.where?.replace("_", " "))],
    ["head certainty", certain, now.has_pose === false || now.sure === false ? "wrong" : ""],
    ["R", plain(here.R_mm, "mm")],
    ["W", plain(here.W_mm, "mm")],
    ["scale", plain(here.px_per_mm, "px/mm")],
    ["frames", plain(now.taken)],
    ["in / done", `${plain(now.fps_in)} / ${plain(now.fps_done)} /s`, "wide"],
    ["dropped", String(lost), lost ? "wrong" : ""],
    ["latency", now.replay || now.latency_s === null ? "–" : milliseconds(now.latency_s), now.latency_s > 1 ? "wrong" : ""],
    ...recording(source?.values ?? {}),
    ["last frame", now.age_s === null || now.age_s === undefined ? "–" : `${now.age_s.toFixed(1)} s ago`, !now.replay && now.age_s > 1 ? "wrong" : ""],
  ]);
  id("swap").disabled = !now.can_swap;
  id("player").hidden = !(now.replay && now.can_pause);
  id("note").hidden = !now.can_note;
  id("pause").disabled = false;
  id("pause").textContent = now.paused ? "Play" : "Pause";
  id("step").disabled = !now.paused;
  const rate = id("rate");
  if (document.activeElement !== rate && now.rate !== null && now.rate !== undefined) {
    const known = [...rate.options].some((option) => Number(option.value) === now.rate);
    if (!known) rate.add(new Option(`${now.rate} ×`, String(now.rate)));
    rate.value = String(now.rate);
  }
}

// What is recorded, and how long its disk lasts; nothing where nothing is.
function recording(values) {
  const minutes = values["disk lasts (minutes)"];
  if (minutes === undefined) return [];
  return [
    ["recorded", `${values["record (MB)"]} MB`, "wide"],
    ["disk lasts", Number(minutes) < 600 ? `${minutes} min` : `${Math.round(minutes / 60)} h`, Number(minutes) < 10 ? "wrong" : ""],
  ];
}

function inView() {
  const { rows } = told;
  if (!rows.length) return [[], [0, 1], Infinity];
  const last = rows[rows.length - 1][T];
  const first = view.span ? Math.max(rows[0][T], last - view.span) : rows[0][T];
  let k = rows.length;
  while (k > 0 && rows[k - 1][T] >= first) k -= 1;
  const seen = rows.slice(k);
  const steps = rows.slice(-50).map((row, j, all) => (j ? row[T] - all[j - 1][T] : Infinity)).sort((a, b) => a - b);
  return [seen, [first, Math.max(last, first + 5)], 3 * (steps[Math.floor(steps.length / 2)] ?? 1)];
}

function drawTime() {
  const [rows, range, gap] = inView();
  const chamber = told.geometry?.chambers[0];
  const high = chamber ? 1.08 * chamber.R_mm : 1.08 * Math.max(1, ...rows.map((row) => row[R_H] ?? 0));
  const radii = plot.axes(id("radii"), range, [0, high], { label: "r, mm from the centre" });
  const { ink } = radii;
  plot.bands(radii, rows, CONTACT, gap);
  if (chamber) plot.level(radii, chamber.R_mm, ink.wall, []);
  plot.line(radii, rows, R_T, ink.tail, { gap });
  plot.line(radii, rows, R_C, ink.centroid, { gap });
  plot.line(radii, rows, R_H, ink.head, { gap });
  const turns = [-180, -90, 0, 90, 180];
  const theta = plot.axes(id("theta"), range, [-180, 180], { label: "θₕ, degrees; exit at 0", yticks: turns });
  plot.level(theta, 0, ink.exit);
  plot.line(theta, rows, THETA, ink.head, { gap, wrap: 360 });
  const psi = plot.axes(id("psi"), range, [-180, 180], { label: "ψ, degrees", yticks: turns });
  plot.line(psi, rows, PSI_H, ink.head, { gap, wrap: 360, width: 0.8 });
  plot.line(psi, rows, PSI_B, ink.body, { gap, wrap: 360, width: 1.5 });
  places = { radii, theta, psi };
  for (const place of Object.values(places)) place.label();
  drawCursor(rows);
}

function drawCursor(rows) {
  if (view.cursor === null || !rows.length) { id("cursor").textContent = ""; return; }
  for (const place of Object.values(places)) plot.upright(place, view.cursor, place.ink.ink);
  let nearest = rows[0];
  for (const row of rows) if (Math.abs(row[T] - view.cursor) < Math.abs(nearest[T] - view.cursor)) nearest = row;
  const value = (column, unit) => plain(nearest[column] === null ? null : Number(nearest[column].toFixed(unit === "mm" ? 2 : 0)));
  id("cursor").textContent = `${clock(nearest[T])}  r ${value(R_H, "mm")}, ${value(R_C, "mm")}, ${value(R_T, "mm")} mm; θ_h ${value(THETA)}°; ψ_b ${value(PSI_B)}°`;
}

function drawEvents() {
  const list = id("events");
  const atEnd = list.scrollTop < 8;
  id("count").textContent = told.events.length === MOST_EVENTS ? `the last ${MOST_EVENTS}` : told.events.length || "";
  list.replaceChildren(...told.events.toSorted((a, b) => (b.t ?? -1) - (a.t ?? -1)).map((event) => {
    const item = document.createElement("li");
    item.tabIndex = 0;
    const time = document.createElement("time"), kind = document.createElement("span"), text = document.createElement("span");
    time.textContent = event.t === null ? "" : clock(event.t).slice(1);
    kind.textContent = event.kind; kind.className = event.kind;
    text.textContent = event.text;
    item.append(time, kind, text);
    item.onclick = () => jump(event.t);
    item.onkeydown = ({ key }) => { if (key === "Enter") jump(event.t); };
    return item;
  }));
  if (atEnd) list.scrollTop = 0;
}

function jump(seconds) {
  if (seconds === null) return;
  view.cursor = seconds;
  const last = told.rows.at(-1)?.[T] ?? 0;
  if (view.span && seconds < last - view.span) choose(0);
  mark("time");
}

function drawNumbers() {
  const body = id("numbers");
  const { quantities = {}, forecast } = told;
  const rows = SHOWN.filter(([name]) => quantities[name]).map(([name, words]) => {
    const { value, low, high, n, unit, paper, why } = quantities[name];
    const shown = unit === "1" ? "" : unit === "deg" ? "°" : unit;
    const now = momentary(name, forecast);
    const interval = low === null || high === null ? "" : `${plain(low)} … ${plain(high)}`;
    return [words, now, value === null ? null : plain(value, shown), interval, String(n), plain(paper, shown), why];
  });
  const written = JSON.stringify(rows);
  if (written === view.numbers) return;
  view.numbers = written;
  body.replaceChildren(...rows.map(([words, now, value, interval, n, paper, why]) => {
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
    cell(n, "n"); cell(paper);
    return row;
  }));
}

// What a quantity is at this moment, where that means something.
function momentary(name, forecast) {
  const now = told.now ?? {}, R = told.geometry?.chambers[0]?.R_mm;
  const share = (r) => (R && r !== null && r !== undefined ? (r / R).toFixed(3) : "");
  if (name === "tau_h" && forecast && forecast.median !== null) return `${forecast.median} s to go (${forecast.low} … ${forecast.high})`;
  if (!now.where?.startsWith("chamber")) return "";
  if (name === "r_h_over_R") return share(now.r_h);
  if (name === "r_c_over_R") return share(now.r_c);
  if (name === "v_w" && now.v_b !== null && now.v_b !== undefined) return plain(Number(Math.abs(now.v_b).toFixed(2)), "mm/s");
  const side = { psi_b_negative_peak: -1, psi_b_positive_peak: 1 }[name];
  return side && Math.sign(now.psi_b ?? 0) === side ? plain(now.psi_b, "°") : "";
}

function drawCorrelation() {
  const canvas = id("correlation"), { correlation, model_correlation: walk, quantities } = told;
  if (!correlation?.lag.length || !correlation.c.some((c) => c !== null)) { plot.nothing(canvas, "no pairs of moments yet"); return; }
  const far = Math.max(10, ...correlation.lag.filter((lag, k) => correlation.c[k] !== null));
  const place = plot.axes(canvas, [0, far], [-1, 1.05], { label: "" });
  plot.level(place, 0, place.ink.soft, [2, 3]);
  plot.points(place, correlation.lag, correlation.c, correlation.error, place.ink.head);
  const t_per = quantities?.t_per?.value;
  if (t_per) plot.curve(place, correlation.lag, correlation.lag.map((lag) => Math.exp(-lag / t_per)), place.ink.soft, { dash: [5, 4] });
  if (walk) plot.curve(place, walk.lag, walk.c, place.ink.exit);
}

function drawLengths() {
  const canvas = id("lengths");
  const known = [["P_d_c", "d_c", "head"], ["P_d_nc", "d_nc", "centroid"]].map(([name, number, colour]) => {
    const histogram = told[name];
    if (!histogram || !histogram.counts.some((n) => n)) return null;
    const wide = histogram.edges.at(-1) - histogram.edges[0];
    const bins = plot.density(histogram, Math.max(1, Math.round((histogram.counts.length * Math.max(0.5, wide / 16)) / wide)));
    return { bins, mean: told.quantities?.[number]?.value ?? null, colour };
  }).filter(Boolean);
  if (!known.length) { plot.nothing(canvas, "no contact has closed yet"); return; }
  const all = known.flatMap(({ bins }) => bins).filter(({ p }) => p > 0);
  const far = Math.max(...all.map(({ high }) => high));
  const least = Math.min(...all.map(({ p }) => p)), most = Math.max(...all.map(({ p }) => p));
  const floor = 10 ** Math.floor(Math.log10(least));
  const place = plot.axes(canvas, [0, far], [floor, 10 ** Math.ceil(Math.log10(most * 1.05))], { log: true });
  for (const { bins, mean, colour } of known) {
    plot.steps(place, bins, place.ink[colour], floor);
    if (!mean) continue;
    const weight = bins.reduce((sum, { low, high }) => sum + (Math.exp(-low / mean) - Math.exp(-high / mean)), 0);
    const xs = Array.from({ length: 60 }, (_, k) => (far * k) / 59);
    plot.curve(place, xs, xs.map((x) => Math.exp(-x / mean) / mean / weight), place.ink[colour], { dash: [5, 4], width: 1.1 });
  }
}

function drawRadius() {
  const canvas = id("radius");
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

function drawAngle() {
  const canvas = id("angle"), histogram = told.P_psi_b;
  if (!histogram?.counts.some((n) => n)) { plot.nothing(canvas, "no angles yet"); return; }
  const bins = plot.density(histogram, Math.max(1, Math.round(6 / (histogram.edges[1] - histogram.edges[0]))));
  const place = plot.axes(canvas, [-180, 180], [0, 1.08 * Math.max(...bins.map(({ p }) => p))]);
  plot.upright(place, 0, place.ink.line);
  plot.steps(place, bins, place.ink.body);
}

function choose(span) {
  view.span = span;
  for (const button of id("spans").children) button.setAttribute("aria-pressed", String(Number(button.dataset.span) === span));
  mark("time");
}

function wire() {
  id("swap").onclick = () => ask("swap_head");
  id("pause").onclick = () => ask(told.now?.paused ? "resume" : "pause");
  id("step").onclick = () => ask("play_next");
  id("rate").onchange = ({ target }) => ask("rate", Number(target.value));
  for (const button of id("spans").children) button.onclick = () => choose(Number(button.dataset.span));
  id("text").onfocus = () => { view.note = { ...told.now }; };
  id("note").onsubmit = (event) => {
    event.preventDefault();
    const text = id("text").value.trim(), at = view.note ?? told.now ?? {};
    if (text) ask("note", `${at.t?.toFixed(2) ?? "?"} s, frame ${at.frame ?? "?"}: ${text}`);
    id("text").value = "";
    view.note = null;
    id("text").blur();
  };
  for (const name of ["radii", "theta", "psi"]) {
    const canvas = id(name);
    const point = ({ clientX }) => {
      if (!places[name]) return;
      view.cursor = places[name].at(clientX - canvas.getBoundingClientRect().left);
      mark("time");
    };
    canvas.onpointermove = point;
    canvas.onpointerdown = point;
    canvas.onpointerleave = () => { view.cursor = null; mark("time"); };
  }
  const again = () => Object.keys(DRAWERS).forEach(mark);
  window.addEventListener("resize", again);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  again();
}

wire();
connect();
requestAnimationFrame(draw);
