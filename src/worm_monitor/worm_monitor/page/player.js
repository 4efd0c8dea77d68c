// The player of a recording: pause, rate, frame by frame; forward to a time, back to a past frame.

import { clock } from "./tiles.js";

const id = (name) => document.getElementById(name);

export class Player {
  // `ask` the graph for something; `show` a picture; `forget` the time that was looked at.
  constructor({ ask, show, forget }) {
    Object.assign(this, { ask, show, forget });
    this.now = {};
    this.last = null; // the newest picture
    this.owed = false; // whether it is still to be shown, and acknowledged
    this.looked = null; // time of the past frame that is shown
    this.frame = null; // number of the frame that is shown
    this.sought = null;
    this.dragged = false;
    this.looks = 0;
    id("pause").onclick = () => ask(this.now.paused ? "resume" : "pause");
    id("step").onclick = () => { this.back(); ask("play_next"); };
    id("rate").onchange = ({ target }) => ask("rate", Number(target.value));
    id("back").onclick = () => { this.back(); forget(); };
    const line = id("timeline");
    line.oninput = () => { this.dragged = true; this.position(Number(line.value)); };
    line.onchange = () => {
      this.dragged = false;
      const seconds = Number(line.value);
      if (seconds > (this.now.t ?? 0)) this.seek(seconds);
      else this.look(seconds);
    };
  }

  // All that comes is of another connection.
  forgetFrames() {
    this.looks += 1;
    this.last = this.looked = this.frame = this.sought = null;
    this.owed = false;
    this.tell();
  }

  // A picture has come: it is shown, unless a past one is looked at.
  newest(data) {
    this.last = data;
    this.owed = this.looked !== null;
    if (!this.owed) this.put(data);
  }

  async put(data, isPast = false) {
    const head = await this.show(data, isPast);
    this.frame = head?.pose?.frame ?? null;
    return head;
  }

  // Play to a time that is still to come, leaving nothing out.
  seek(seconds) {
    this.back();
    this.sought = seconds;
    this.ask("seek", seconds);
  }

  // Show the frame of a time that has been played.
  async look(seconds) {
    const data = await this.past(seconds);
    if (!data) return;
    this.looked = seconds;
    const head = await this.put(data, true);
    if (this.looked !== null) this.looked = head.t;
    this.tell();
  }

  // While the player is paused the last frame is shown, which may have come too soon after others.
  async catchUp() {
    if (!this.now.paused || this.looked !== null || this.frame === null || this.frame === this.now.frame) return;
    this.frame = this.now.frame;
    const data = await this.past(this.now.t);
    if (!data) return;
    this.last = data; // what comes back after a look at a past frame
    if (this.looked === null) this.put(data, true);
  }

  // The frame of a time, unless another one was asked for meanwhile.
  async past(seconds) {
    if (!this.now.can_look || this.now.ended) return null;
    const mine = (this.looks += 1);
    const answer = await fetch(new URL(`past?t=${Math.max(0, seconds)}`, location.href)).catch(() => null);
    if (mine !== this.looks || !answer) return null;
    if (!answer.ok) { id("position").textContent = await answer.text(); return null; }
    const data = await answer.arrayBuffer();
    return mine === this.looks ? data : null;
  }

  // Show the newest frame again.
  back() {
    this.looks += 1;
    if (this.looked === null) return;
    this.looked = null;
    if (this.last) this.put(this.last, !this.owed);
    this.owed = false;
    this.tell();
  }

  // Say whether a past frame is shown.
  tell() {
    const isPast = this.looked !== null;
    id("back").hidden = !isPast;
    id("picture").parentElement.classList.toggle("past", isPast);
    this.position();
  }

  position(dragged = null) {
    const { t = 0 } = this.now;
    const line = id("timeline");
    if (dragged === null && !this.dragged) line.value = String(this.looked ?? this.sought ?? t);
    const at = dragged === null ? "" : dragged > t ? `plays to ${clock(dragged)}` : `shows ${clock(dragged)}`;
    const going = this.now.seeking && this.sought !== null ? `plays to ${clock(this.sought)}, every frame` : "";
    id("position").textContent = at || going || `${this.looked === null ? "" : "past frame, "}${clock(this.looked ?? t)} of ${clock(Number(line.max))}`;
  }

  update(now, source) {
    this.now = now;
    if (!now.seeking) this.sought = null;
    id("player").hidden = !(now.replay && now.can_pause);
    id("pause").disabled = false;
    id("pause").textContent = now.paused ? "Play" : "Pause";
    id("step").disabled = !now.paused;
    const length = Number(source["to play (s)"] ?? 0), line = id("timeline");
    line.disabled = !(length > 0 && now.can_look);
    if (length > 0) line.max = String(length);
    const rate = id("rate");
    if (document.activeElement !== rate && now.rate !== null && now.rate !== undefined) {
      const known = [...rate.options].some((option) => Number(option.value) === now.rate);
      if (!known) rate.add(new Option(`${now.rate} ×`, String(now.rate)));
      rate.value = String(now.rate);
    }
    if (!this.dragged) this.position();
    this.catchUp();
  }
}
