// The page: takes what the monitor sends, and draws what has changed.

import { drawAngle, drawCorrelation, drawForecast, drawLengths, drawRadius } from "./laws.js";
import { fillNumbers } from "./numbers.js";
import { Picture } from "./picture.js";
import { Player } from "./player.js";
import { clock, plain, tiles } from "./tiles.js";
import { Times } from "./times.js";

const DRAW_EVERY_MS = 250;
const MOST_EVENTS = 400;
const id = (name) => document.getElementById(name);
const told = { rows: [], events: [] };
const picture = new Picture(id("picture"), id("closeup"));
const view = { dirty: new Set(), drawn: 0, awaited: 0, note: null, numbers: "" };
const times = new Times(() => mark("time"), (seconds) => player.look(seconds));
const player = new Player({ ask, show, forget: () => times.hold(null) });
let socket = null, heard = 0;

function connect() {
  const address = new URL("socket", location.href);
  address.protocol = "ws:";
  socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) => {
    heard = performance.now();
    if (typeof data === "string") take(JSON.parse(data));
    else player.newest(data);
  };
  socket.onopen = () => {
    link("connected", false);
    id("stamp").textContent = ""; // it may be another trial
    player.forgetFrames();
  };
  socket.onclose = () => {
    if (told.now?.ended) {
      link("the trial has ended: its report has the final numbers", false);
      mark("head");
    } else link("no connection: what is shown is the last that came", true);
    for (const name of ["swap", "new_trial", "pause", "step", "timeline"]) id(name).disabled = true;
    setTimeout(connect, 1500);
  };
}

function link(text, gone) {
  if (id("link").textContent !== text) id("link").textContent = text;
  id("link").classList.toggle("gone", gone);
}

function say(message) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

function ask(what, value) {
  say({ do: what, value });
}

// Show a picture with its pose; one that has just come is acknowledged, and the next one sent.
async function show(data, isPast = false) {
  try {
    const head = await picture.show(data);
    const { pose } = head;
    id("stamp").textContent = pose ? `${head.t.toFixed(2)} s, frame ${pose.frame}` : "its pose is not given yet";
    mark("picture");
    return head;
  } finally {
    if (!isPast) requestAnimationFrame(() => say({ shown: true }));
  }
}

function take(news) {
  if (news.all) {
    for (const name of Object.keys(told)) delete told[name];
    Object.assign(told, { rows: [], events: [] });
    Object.keys(DRAWERS).forEach(mark);
  }
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
    for (const what of SHOWS[name] ?? ["head"]) mark(what);
  }
}

const SHOWS = {
  now: ["head", "numbers"], geometry: ["head", "picture", "time"],
  correlation: ["correlation"], model_correlation: ["correlation"],
  P_d_c: ["lengths"], P_d_nc: ["lengths"], P_delta_r_h: ["depths"],
  P_r_h: ["radius"], P_r_c: ["radius"], P_r_t: ["radius"], P_psi_b: ["angle"],
  quantities: ["numbers", "lengths", "depths", "correlation", "radius", "angle", "forecast"],
  forecast: ["numbers", "forecast"], walk: ["numbers", "lengths", "forecast"],
};

function mark(what) {
  view.dirty.add(what);
  if (what === "picture") requestAnimationFrame(drawPicture);
  else if (!view.awaited) view.awaited = setTimeout(requestAnimationFrame, view.drawn + DRAW_EVERY_MS - performance.now(), draw);
}

function drawPicture() {
  if (view.dirty.delete("picture")) picture.draw(told.geometry);
}

// A browser that draws nothing takes no processor's time from the tracker: a frame is asked for when something is new.
function draw() {
  view.drawn = performance.now();
  view.awaited = 0;
  for (const what of view.dirty) DRAWERS[what]();
  view.dirty.clear();
}

function tellSilence() {
  if (!heard || socket?.readyState !== WebSocket.OPEN) return;
  const silence = performance.now() - heard;
  if (silence > 3000) link(`nothing has come for ${Math.round(silence / 1000)} s`, true);
  else link("connected", false);
}

const DRAWERS = {
  picture: () => picture.draw(told.geometry),
  head: drawHead, events: drawEvents,
  time: () => times.draw(told),
  numbers: () => { view.numbers = fillNumbers(id("numbers"), told, view.numbers); },
  correlation: () => { drawCorrelation(id("correlation"), told); reason("correlation", "t_per"); },
  lengths: () => { drawLengths(id("lengths"), told, [["d_c", "head"], ["d_nc", "centroid"]]); reason("lengths", "d_c", "d_nc"); },
  depths: () => { drawLengths(id("depths"), told, [["delta_r_h", "tail"]]); reason("depths", "delta_r_h"); },
  radius: () => { drawRadius(id("radius"), told); reason("radius", "r_h_over_R", "r_c_over_R"); },
  angle: () => { drawAngle(id("angle"), told); reason("angle", "psi_b_negative_peak", "psi_b_positive_peak"); },
  forecast: () => { drawForecast(id("forecast"), told); chances(); reason("forecast", "tau_h"); },
};

const SHORT = { psi_b_negative_peak: "negative peak", psi_b_positive_peak: "positive peak", r_h_over_R: "head", r_c_over_R: "centroid" };

// How many items a plot's numbers rest on, or why there is no number: as the analysis says.
function reason(name, ...numbers) {
  const known = numbers.filter((number) => told.quantities?.[number]);
  const lines = known.map((number) => {
    const { value, n, why } = told.quantities[number];
    const which = known.length > 1 ? `${SHORT[number] ?? number}: ` : "";
    return value === null ? `${which}${why}` : `${which}n = ${n}`;
  });
  id(`${name}_why`).textContent = new Set(lines.map((line) => line.split(": ").slice(1).join())).size === 1 && lines.length > 1
    ? lines[0].slice(lines[0].indexOf(": ") + 2) : lines.join("; ");
}

function chances() {
  const { forecast } = told;
  const known = forecast?.within?.filter(([, share]) => share !== null) ?? [];
  id("chances").textContent = known.length ? known.map(([seconds, share]) => `${Math.round(100 * share)} % within ${seconds} s`).join(", ") : "when it will be found";
}

const milliseconds = (seconds) => (seconds === undefined ? "–" : seconds < 1 ? `${Math.round(1000 * seconds)} ms` : `${seconds.toFixed(1)} s`);

const perSecond = (rate) => (rate === null || rate === undefined ? "–" : rate.toFixed(rate < 99.95 ? 1 : 0));

function drops() {
  const values = told.health?.image_source?.values ?? {};
  return ["frames skipped", "frames lost"].reduce((sum, key) => sum + Number(values[key] ?? 0), 0);
}

function drawHead() {
  const now = told.now ?? {};
  const kind = id("kind");
  kind.textContent = now.ended ? "ENDED" : now.replay ? "REPLAY" : now.replay === false ? "LIVE" : "…";
  kind.classList.toggle("live", now.replay === false && !now.ended);
  id("trial").textContent = now.trial ?? "";
  document.title = now.trial ? `${kind.textContent} ${now.trial}` : "worm monitor";
  id("clock").textContent = now.t === undefined ? "–" : clock(now.t);
  const outcome = id("outcome");
  if (now.status !== undefined) {
    outcome.textContent = now.status === "tracked" ? "tracked" : `${now.has_pose ? "" : "LOST: "}${now.status.replaceAll("_", " ")}. ${now.reason}`;
    outcome.classList.toggle("lost", !now.has_pose);
  } else outcome.textContent = now.taken ? `${now.taken} frames in: told once it is clear which end is the head` : "waits for the first frame";
  const source = told.health?.image_source;
  id("complaint").textContent = source?.level ? source.message : "";
  tiles(id("tiles"), headTiles(now, source?.values ?? {}));
  id("swap").disabled = !now.can_swap;
  id("new_trial").disabled = false;
  id("note").hidden = !now.can_note;
  id("new_trial").hidden = !now.can_begin_anew;
  player.update(now, source?.values ?? {});
}

function headTiles(now, source) {
  const chambers = told.geometry?.chambers ?? [];
  const here = chambers.find((chamber) => chamber.name === now.where) ?? chambers[0] ?? {};
  const lost = drops(), speed = now.v_b;
  const turns = speed === null || speed === undefined ? "–" : Math.abs(speed) < 0.02 ? "still" : `${speed > 0 ? "CCW" : "CW"} ${Math.abs(speed).toFixed(2)} mm/s`;
  const certain = now.has_pose ? now.certainty?.toFixed(2) ?? "–" : now.has_pose === false ? "LOST" : "–";
  return [
    ["contact", now.contact === true ? "yes" : now.contact === false ? "no" : "–", now.contact ? "on" : ""],
    ["direction", turns, "wide"],
    ["where", plain(now.where?.replace("_", " "))],
    ["head certainty", certain, now.has_pose === false || now.sure === false ? "wrong" : ""],
    ["R, W", `${plain(here.R_mm)}, ${plain(here.W_mm, "mm")}`],
    ["scale", plain(here.px_per_mm, "px/mm")],
    ["frames", plain(now.taken)],
    ["fps in, done", `${perSecond(now.fps_in)}, ${perSecond(now.fps_done)}`],
    ["dropped", String(lost), lost ? "wrong" : ""],
    ...(now.replay ? [] : [["latency", now.latency_s === null ? "–" : milliseconds(now.latency_s), now.latency_s > 1 ? "wrong" : ""]]),
    ["last frame", now.age_s === null || now.age_s === undefined ? "–" : `${now.age_s.toFixed(1)} s ago`, !now.replay && now.age_s > 1 ? "wrong" : ""],
    ...(now.replay ? [] : recording(source)),
  ];
}

// What is recorded, and how long its disk lasts.
function recording(values) {
  const minutes = values["disk lasts (minutes)"];
  if (minutes === undefined) return [["recording", "no"]];
  return [
    ["recording", `${values["record (MB)"]} MB`],
    ["disk lasts", Number(minutes) < 600 ? `${minutes} min` : `${Math.round(minutes / 60)} h`, Number(minutes) < 10 ? "wrong" : ""],
  ];
}

function drawEvents() {
  const list = id("events");
  const atEnd = list.scrollTop < 8;
  id("count").textContent = told.events.length === MOST_EVENTS ? `the last ${MOST_EVENTS}` : told.events.length || "";
  list.replaceChildren(...told.events.toSorted((a, b) => (b.t ?? -1) - (a.t ?? -1)).map((event) => {
    const item = document.createElement("li");
    item.tabIndex = 0;
    const time = document.createElement("time"), kind = document.createElement("span"), text = document.createElement("span");
    time.textContent = event.t === null ? "" : clock(event.t).replace(/^00:/, "");
    kind.textContent = event.kind; kind.className = event.kind;
    text.textContent = event.text;
    item.append(time, kind, text);
    item.onclick = () => jump(event.t);
    item.onkeydown = ({ key }) => { if (key === "Enter") jump(event.t); };
    return item;
  }));
  if (atEnd) list.scrollTop = 0;
}

// Go to a time: the cursor of the plots and their window, and in a recording its frame.
function jump(seconds) {
  if (seconds === null) return;
  times.jump(seconds);
  player.look(seconds);
}

// What cannot be undone is asked for by two clicks within some seconds.
function twice(button, question, act) {
  const words = button.textContent;
  let asked = 0;
  const reset = () => { button.textContent = words; button.classList.remove("asked"); asked = 0; };
  return () => {
    clearTimeout(asked);
    if (asked) { reset(); act(); return; }
    button.textContent = question;
    button.classList.add("asked");
    asked = setTimeout(reset, 4000);
  };
}

function wire() {
  id("swap").onclick = () => ask("swap_head");
  id("new_trial").onclick = twice(id("new_trial"), "End this trial?", () => ask("new_trial"));
  id("release").onclick = () => { times.hold(null); player.back(); };
  id("text").onfocus = () => { view.note = { ...told.now }; };
  id("note").onsubmit = (event) => {
    event.preventDefault();
    const text = id("text").value.trim(), at = view.note ?? told.now ?? {};
    if (text) ask("note", `${at.t?.toFixed(2) ?? "?"} s, frame ${at.frame ?? "?"}: ${text}`);
    id("text").value = "";
    view.note = null;
    id("text").blur();
  };
  const again = () => Object.keys(DRAWERS).forEach(mark);
  window.addEventListener("resize", again);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  again();
}

wire();
connect();
setInterval(tellSilence, 500);
