// The page: a trial frame by frame, and which end of the worm is the head put right.

import { Course, LEAST_S, PLOTS } from "./course.js";
import { Picture } from "./picture.js";
import { clock, plain, tiles } from "./tiles.js";
import { exchanged } from "./exchanged.js";
import { list, words } from "./lists.js";

const LOOK_EVERY_MS = 2000;
const DRAG_PX = 4;
const LONG_STEP = 30;
const id = (name) => document.getElementById(name);
const picture = new Picture(id("picture"), id("closeup"));
let trial = null, data = {}, curves = {}, course = null;
let kept = { version: null, entries: [], refused: "", damaged: "" };
const view = { row: 0, shown: null, range: [0, 1], span: 0, mark: null, place: -1, dirty: false, stale: true, reading: false };

async function open() {
  trial = await (await fetch("trial")).json();
  const all = new Float32Array(await (await fetch("columns")).arrayBuffer());
  trial.columns.forEach((name, k) => { data[name] = all.subarray(k * trial.frames, (k + 1) * trial.frames); });
  course = new Course(trial, data, id);
  id("name").textContent = trial.name;
  document.title = `${trial.name}: review`;
  id("by").value = trial.by;
  id("command").textContent = trial.command;
  id("stands").textContent = trial.stands_for;
  fillLists();
  choose(0);
  wire();
  take(await (await fetch("corrections")).json());
  go(0);
  setInterval(look, LOOK_EVERY_MS);
}

// --- what is exchanged ---

function take(told) {
  kept = told;
  curves = exchanged(trial, data, told.entries, rowOf);
  showCorrections();
  fillDoubts();
  pose();
  markCurves();
}

async function look() {
  if (document.hidden) return;
  try {
    const told = await (await fetch("corrections")).json();
    link("");
    if (["version", "damaged", "never"].some((key) => told[key] !== kept[key])) take(told);
  } catch {
    link("no connection: `worm review` has ended");
  }
}

async function change(asked) {
  try {
    const answer = await fetch("corrections", {
      method: "POST", headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ based_on: kept.version, ...asked }),
    });
    take(await answer.json());
    return !kept.refused;
  } catch {
    link("no connection: nothing was changed");
    return false;
  }
}

function link(text) {
  id("link").textContent = text;
  id("link").classList.toggle("gone", Boolean(text));
}

async function exchange() {
  const [first, last] = ["first", "last"].map((name) => Number(id(name).value));
  if (!(id("first").value.trim() && id("last").value.trim())) { refuse("say from which frame to which: [ and ], or drag over a plot"); return; }
  if (await change({ add: { first, last, by: id("by").value, note: id("note").value } })) {
    id("note").value = "";
    select(null);
  }
}

function refuse(text) {
  id("refused").textContent = text;
  id("refused").hidden = !text;
}

// --- which frame is shown ---

const timeOf = (row) => Math.round(1000 * data.t[row]) / 1000; // columns have seven digits

const rowOf = (frame) => {
  let low = 0, high = trial.frames;
  while (low < high) { const k = (low + high) >> 1; if (data.frame[k] < frame) low = k + 1; else high = k; }
  return low;
};

function go(row) {
  view.row = Math.min(trial.frames - 1, Math.max(0, row));
  const t = data.t[view.row], [begin, end] = view.range;
  if (t < begin || t > end) centre();
  mark();
  read();
}

// Read pictures one at a time: of many that were asked for meanwhile the last.
async function read() {
  if (view.reading) return;
  view.reading = true;
  try {
    while (view.shown?.row !== view.row) {
      const buffer = await (await fetch(`frame?row=${view.row}`)).arrayBuffer();
      view.shown = await picture.show(buffer);
      pose();
      mark();
    }
  } catch {
    link("no connection: `worm review` has ended");
  } finally {
    view.reading = false;
  }
}

function pose() {
  if (!view.shown) return;
  const { pose: found, row } = view.shown;
  picture.shown.pose = curves.changed?.[row] ? { ...found, head: found.tail, tail: found.head, sure: true } : found;
}

function centre() {
  const half = (view.range[1] - view.range[0]) / 2, t = data.t[view.row];
  show(t - half, t + half);
}

function show(begin, end) {
  const last = Math.max(data.t[trial.frames - 1], LEAST_S);
  const long = Math.min(Math.max(end - begin, LEAST_S), last);
  const from = Math.min(Math.max(0, begin), last - long);
  view.range = [from, from + long];
  view.span = long >= last ? 0 : long;
  for (const button of id("spans").children) button.setAttribute("aria-pressed", String(Math.abs(Number(button.dataset.span) - view.span) < 0.01));
  markCurves();
}

function choose(span) {
  const t = data.t[view.row];
  if (span) show(t - span / 2, t + span / 2);
  else show(0, Infinity);
}

function zoom(by) {
  const t = data.t[view.row], half = (by * (view.range[1] - view.range[0])) / 2;
  show(t - half, t + half);
}

function select(rows) {
  view.mark = rows;
  id("first").value = rows ? data.frame[rows[0]] : "";
  id("last").value = rows ? data.frame[rows[1]] : "";
  refuse("");
  markCurves();
}

function selectTyped() {
  const [first, last] = ["first", "last"].map((name) => id(name).value.trim());
  const rows = [first, last].map((frame) => Math.min(trial.frames - 1, rowOf(Number(frame))));
  view.mark = first && last && rows[0] <= rows[1] ? rows : null;
  markCurves();
}

function setEnd(which) {
  id(which).value = data.frame[view.row];
  const other = which === "first" ? "last" : "first";
  const wrong = id(other).value && (which === "first" ? data.frame[view.row] > Number(id("last").value) : data.frame[view.row] < Number(id("first").value));
  if (wrong) id(other).value = "";
  refuse("");
  selectTyped();
}

// Show a stretch with what is around it, and mark what could be exchanged there.
function visit(stretch) {
  const [begin, end] = [data.t[stretch.row], data.t[stretch.last]];
  const room = Math.max(2, end - begin);
  select([stretch.from ?? stretch.row, stretch.to ?? stretch.last]);
  show(begin - room, end + room);
  go(stretch.row);
}

function nextDoubt(by) {
  if (!trial.doubtful.length) return;
  view.place = Math.min(trial.doubtful.length - 1, Math.max(0, view.place + by));
  visit(trial.doubtful[view.place]);
  id("doubtful").children[view.place].scrollIntoView({ block: "nearest" });
}

// --- what is drawn ---

function markCurves() {
  view.stale = true;
  mark();
}

function mark() {
  if (view.dirty) return;
  view.dirty = true;
  requestAnimationFrame(() => { view.dirty = false; draw(); });
}

function draw() {
  drawHead();
  if (view.shown) {
    const { frame, t, geometry, why_blank } = view.shown;
    picture.draw(trial.geometries[geometry]);
    id("stamp").textContent = `${t.toFixed(2)} s, frame ${frame}${curves.changed?.[view.shown.row] ? ", exchanged" : ""}`;
    id("blank").textContent = why_blank ? `No picture: ${why_blank}` : "";
    id("blank").hidden = !why_blank;
  }
  if (!curves.r) return;
  if (view.stale) { view.stale = false; course.draw(view.range, curves, view.mark); }
  course.drawCursor(view.row);
  drawReadout();
}

function drawHead() {
  const { row } = view, at = (name, digits, unit) => {
    const value = (curves[name] ?? data[name])[row];
    return Number.isNaN(value) ? "–" : plain(Number(value.toFixed(digits)), unit);
  };
  id("clock").textContent = clock(timeOf(row));
  if (document.activeElement !== id("frame")) id("frame").value = data.frame[row];
  const changed = Boolean(curves.changed?.[row]), info = view.shown?.row === row ? view.shown : null;
  const outcome = id("outcome");
  if (info) {
    outcome.textContent = info.status === "tracked" ? "tracked" : `${info.has_pose ? "" : "LOST: "}${words(info.status)}. ${info.reason}`;
    outcome.classList.toggle("lost", !info.has_pose);
  }
  const contact = { 0: "no", 1: "yes" }[data.contact[row]] ?? "–";
  const doubtful = data.certainty[row] < trial.sure;
  tiles(id("tiles"), [
    ["frame", `${data.frame[row]} of ${data.frame[trial.frames - 1]}`, "wide"],
    ["where", info ? words(info.where) : "–", "wide"],
    ["contact", changed ? "after the replay" : contact, !changed && contact === "yes" ? "on wide" : "wide"],
    ["head certainty", changed ? "set by a person" : at("certainty", 2), !changed && doubtful ? "wrong wide" : "wide"],
    ["r_h", at("r", 2, "mm")], ["θ_h", at("theta", 0, "°")], ["ψ_b", at("psi", 0, "°")],
  ]);
  for (const [name, rows] of [["events", trial.events], ["doubtful", trial.doubtful]]) {
    const items = id(name).children;
    for (let k = 0; k < items.length; k += 1) {
      const of = rows[items[k].dataset.of];
      const is = of && of.row <= row && row <= Math.max(of.last, of.row);
      if (items[k].hasAttribute("aria-current") !== Boolean(is)) {
        if (is) items[k].setAttribute("aria-current", "true"); else items[k].removeAttribute("aria-current");
      }
    }
  }
}

function drawReadout() {
  const value = (name, digits) => { const is = curves[name][view.row]; return Number.isNaN(is) ? "–" : plain(Number(is.toFixed(digits))); };
  id("cursor").textContent = `${clock(timeOf(view.row))}  r_h ${value("r", 2)} mm; θ_h ${value("theta", 0)}°; ψ_b ${value("psi", 0)}°`;
}

// --- lists ---

function fillLists() {
  const kinds = [...new Set(trial.events.map(({ kind }) => kind))].sort();
  id("kind").append(...kinds.map((kind) => new Option(kind, kind)));
  fillEvents();
  fillDoubts();
}

// Whether what is exchanged on the page answers a doubt.
function settled({ turns, row, last, from, to }) {
  const { changed } = curves;
  return Boolean(changed && (turns ? changed[row] ^ changed[last] : changed[from] && changed[to]));
}

function fillDoubts() {
  id("doubts").textContent = trial.doubtful.length ? `${trial.doubtful.length}, the worst first` : "";
  list(id("doubtful"), trial.doubtful.map((stretch, k) => ({
    of: k, cells: [["time", clock(timeOf(stretch.row)).slice(1)], ["span", `${settled(stretch) ? "✓ " : ""}${stretch.text}`, settled(stretch) ? "settled" : "", framesOf(stretch)]],
    go: () => { view.place = k; visit(stretch); },
  })), "no frame is in doubt");
}

const framesOf = ({ row, last }) => (last > row ? `frames ${data.frame[row]} to ${data.frame[last]}` : `frame ${data.frame[row]}`);

function fillEvents() {
  const kind = id("kind").value;
  const chosen = trial.events.map((event, k) => [event, k]).filter(([event]) => !kind || event.kind === kind);
  id("count").textContent = chosen.length || "";
  list(id("events"), chosen.map(([event, k]) => ({
    of: k, cells: [["time", clock(timeOf(event.row)).slice(1)], ["span", event.kind, event.kind], ["span", event.text]],
    go: () => go(event.row),
  })), "nothing happened");
}

function showCorrections() {
  refuse(kept.refused || kept.damaged);
  const free = !kept.damaged && !kept.never;
  for (const name of ["exchange", "replay", "stands", "begin", "end"]) id(name).hidden = Boolean(kept.never);
  for (const field of id("exchange").elements) field.disabled = !free;
  list(id("entries"), kept.entries.map((entry, k) => ({
    cells: [["span", `${entry.frames}`, "", `${entry.by}, ${entry.at.replace("T", " ").replace("Z", " UTC")}${entry.note ? `: ${entry.note}` : ""}`]],
    go: () => {
      const row = rowOf(entry.first_frame);
      visit({ row, last: Math.min(trial.frames - 1, rowOf(entry.last_frame ?? entry.first_frame)) });
      select(null);
    },
    action: entry.what === "swap_head" && free ? ["Undo", () => change({ remove: k })] : null,
  })), kept.damaged ? "" : "none yet");
  const differ = curves.changed.reduce((sum, is) => sum + is, 0);
  id("saved").textContent = kept.entries.length ? "saved in corrections.json" : "";
  const effect = id("effect");
  effect.classList.toggle("pending", differ > 0);
  effect.textContent = kept.never
    ? `Nothing can be corrected here: ${kept.never}.`
    : differ ? `${differ} frame${differ === 1 ? " is" : "s are"} shown exchanged in picture and plots. Tables, contacts and numbers change only with a replay, into a directory of its own:`
    : kept.entries.some(({ what }) => what === "swap_head")
      ? "These results were made with these corrections. To make them again:"
      : "A correction is shown at once. Tables, contacts and numbers change only with a replay, into a directory of its own:";
}

// --- keys, mouse, buttons ---

const KEYS = {
  ArrowLeft: (event) => go(view.row - (event.shiftKey ? LONG_STEP : 1)),
  ArrowRight: (event) => go(view.row + (event.shiftKey ? LONG_STEP : 1)),
  Home: () => go(0), End: () => go(trial.frames - 1),
  n: () => nextDoubt(1), p: () => nextDoubt(-1),
  "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), "−": () => zoom(2),
  "[": () => setEnd("first"), "]": () => setEnd("last"), x: exchange,
};

function wire() {
  for (const button of document.querySelectorAll("[data-step]")) button.onclick = () => go(view.row + Number(button.dataset.step));
  for (const button of id("spans").children) button.onclick = () => choose(Number(button.dataset.span));
  id("begin").onclick = () => setEnd("first");
  id("end").onclick = () => setEnd("last");
  for (const name of ["first", "last"]) id(name).oninput = selectTyped;
  id("frame").onchange = ({ target }) => { if (/^\d+$/.test(target.value.trim())) go(rowOf(Number(target.value))); target.blur(); };
  id("kind").onchange = () => { fillEvents(); mark(); };
  id("exchange").onsubmit = (event) => { event.preventDefault(); exchange(); };
  id("copy").onclick = copy;
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT)$/.test(event.target.tagName)) return;
    const act = KEYS[event.key];
    if (act) { event.preventDefault(); act(event); }
  });
  for (const name of PLOTS) drag(id(name), name);
  const whole = id("whole");
  whole.onpointerdown = (event) => { whole.setPointerCapture(event.pointerId); toPoint(event); };
  whole.onpointermove = (event) => { if (event.buttons) toPoint(event); };
  window.addEventListener("resize", markCurves);
  new ResizeObserver(markCurves).observe(document.querySelector(".time"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", markCurves);
}

function toPoint({ clientX }) {
  go(course.rowAt("whole", clientX));
  centre();
}

// A click on a plot goes to its frame; a drag marks a stretch.
function drag(canvas, name) {
  let began = null;
  const row = ({ clientX }) => course.rowAt(name, clientX);
  canvas.onpointerdown = (event) => { began = { x: event.clientX, row: row(event), far: false }; canvas.setPointerCapture(event.pointerId); };
  canvas.onpointermove = (event) => {
    if (!began) return;
    began.far ||= Math.abs(event.clientX - began.x) > DRAG_PX;
    if (began.far) select([began.row, row(event)].sort((a, b) => a - b));
  };
  canvas.onpointerup = (event) => {
    if (began && !began.far) go(row(event));
    began = null;
  };
  canvas.onpointercancel = () => { began = null; };
}

async function copy() {
  try {
    await navigator.clipboard.writeText(trial.command);
    id("copy").textContent = "Copied";
  } catch { // only a page of this machine may: then it is marked, to be copied by hand
    getSelection().selectAllChildren(id("command"));
    id("copy").textContent = "Marked";
  }
}

open();
