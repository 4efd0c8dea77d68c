// The picture and what was found in it: the pose is that of the same frame, or none is drawn.

const HEAD = "#0072B2", CENTROID = "#D55E00", TAIL = "#009E73";
const WALL = "#E69F00", EXIT = "#CC79A7", MIDLINE = "#F0E442";
const PALE = 0.45;

export class Picture {
  constructor(canvas, closeup) {
    this.canvas = canvas;
    this.closeup = closeup;
    this.shown = null;
    this.isNearEnough = false;
  }

  // Decode a message: four bytes with the length of a head in JSON, the head, a JPEG.
  async show(buffer) {
    const length = new DataView(buffer).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    const image = await createImageBitmap(new Blob([new Uint8Array(buffer, 4 + length)], { type: "image/jpeg" }));
    if (this.shown) this.shown.image.close();
    this.shown = { image, ...head };
    return head;
  }

  draw(geometry) {
    if (!this.shown) return;
    const { image, scale, pose } = this.shown;
    this.fit(image);
    const pen = this.canvas.getContext("2d");
    const size = this.canvas.width / image.width;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.drawImage(image, 0, 0, this.canvas.width, this.canvas.height);
    const whole = size * scale;
    const unit = this.canvas.width / this.canvas.clientWidth;
    pen.setTransform(whole, 0, 0, whole, whole / 2, whole / 2);
    rig(pen, geometry, unit / whole);
    body(pen, pose, unit / whole, 3.4);
    bar(pen, geometry, this.canvas, whole, unit);
    this.near(image, scale, pose, geometry);
  }

  fit(image) {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const room = this.canvas.parentElement.clientWidth;
    const tallest = window.innerWidth > 760 ? 330 : 300;
    const high = Math.min(tallest, (room * image.height) / image.width);
    const wide = (high * image.width) / image.height;
    const [width, height] = [Math.round(wide * ratio), Math.round(high * ratio)];
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
      this.canvas.style.width = `${wide}px`;
      this.canvas.style.height = `${high}px`;
    }
    const beside = room - wide >= 156;
    // On a phone the picture of one chamber is as large as a close-up would be.
    this.isNearEnough = !beside && image.width < 1.6 * image.height;
    this.closeup.style.height = beside ? `${high}px` : `${tallest - 184}px`;
  }

  // The worm from near: the whole body as large as it fits.
  near(image, scale, pose, geometry) {
    const canvas = this.closeup;
    const place = pose && pose.centroid[0] !== null ? pose.centroid : null;
    canvas.hidden = !place || this.isNearEnough;
    if (canvas.hidden) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const [wide, high] = [canvas.clientWidth, canvas.clientHeight].map((size) => Math.round(size * ratio));
    if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
    const pen = canvas.getContext("2d");
    const middle = ["head", "tail"].every((end) => pose[end][0] !== null)
      ? [0, 1].map((k) => (pose.head[k] + pose.tail[k]) / 2) : place;
    const across = [0, 1].map((k) => Math.max(...us_and_vs(pose)[k].map((at) => Math.abs(at - middle[k])), 12) * 2.5);
    const zoom = Math.min(wide / across[0], high / across[1], 6 * ratio);
    const shift = [wide / 2 - middle[0] * zoom, high / 2 - middle[1] * zoom];
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.fillStyle = "#000"; pen.fillRect(0, 0, wide, high);
    pen.setTransform(zoom / scale, 0, 0, zoom / scale, shift[0] - zoom / 2, shift[1] - zoom / 2);
    pen.drawImage(image, 0, 0);
    pen.setTransform(zoom, 0, 0, zoom, ...shift);
    rig(pen, geometry, ratio / zoom);
    body(pen, pose, ratio / zoom, 4);
  }
}

// Where the body is: across and down, without what was not seen.
function us_and_vs(pose) {
  const seen = pose.midline.map((line) => line.filter((at) => at !== null));
  return seen[0].length ? seen : pose.centroid.map((at) => [at]);
}

function rig(pen, geometry, px) {
  if (!geometry) return;
  for (const { u, v, radius_px: radius, exit_rad: exit, W_mm: W, R_mm: R } of geometry.chambers) {
    pen.lineWidth = 1.4 * px; pen.strokeStyle = WALL;
    const half = W ? Math.asin(Math.min(1, W / (2 * R))) : 0;
    pen.beginPath(); pen.arc(u, v, radius, -exit + half, -exit - half + 2 * Math.PI); pen.stroke();
    if (!W) continue;
    pen.lineWidth = 3 * px; pen.strokeStyle = EXIT;
    pen.beginPath();
    for (const side of [-half, half]) pen.lineTo(u + radius * Math.cos(exit + side), v - radius * Math.sin(exit + side));
    pen.stroke();
  }
}

function body(pen, pose, px, dot) {
  if (!pose) return;
  pen.globalAlpha = pose.status === "tracked" ? 1 : PALE;
  const [us, vs] = pose.midline;
  pen.lineWidth = 1.5 * px; pen.strokeStyle = MIDLINE;
  pen.beginPath();
  let drawing = false;
  us.forEach((u, k) => {
    if (u === null || vs[k] === null) { drawing = false; return; }
    if (drawing) pen.lineTo(u, vs[k]); else pen.moveTo(u, vs[k]);
    drawing = true;
  });
  pen.stroke();
  for (const [name, colour] of [["tail", TAIL], ["centroid", CENTROID], ["head", HEAD]]) {
    const [u, v] = pose[name];
    if (u === null || v === null) continue;
    const filled = name === "centroid" || pose.sure;
    pen.beginPath(); pen.arc(u, v, (name === "head" ? dot * 1.25 : dot) * px, 0, 7);
    pen.fillStyle = pen.strokeStyle = colour; pen.lineWidth = 2 * px;
    if (filled) pen.fill(); else pen.stroke();
    if (filled) { pen.strokeStyle = "#fff"; pen.lineWidth = 0.8 * px; pen.stroke(); }
  }
  pen.globalAlpha = 1;
}

function bar(pen, geometry, canvas, whole, unit) {
  const scale = geometry?.chambers[0]?.px_per_mm;
  if (!scale) return;
  const room = canvas.width / whole / scale / 5;
  const mm = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50].filter((length) => length <= room).pop();
  if (!mm) return;
  const long = mm * scale * whole, x = 10 * unit, y = canvas.height - 10 * unit;
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.font = `600 ${11 * unit}px system-ui, sans-serif`; pen.textBaseline = "bottom"; pen.textAlign = "left";
  for (const [colour, width] of [["#000", 4.5], ["#fff", 2.5]]) {
    pen.strokeStyle = colour; pen.lineWidth = width * unit;
    pen.beginPath(); pen.moveTo(x, y); pen.lineTo(x + long, y); pen.stroke();
  }
  pen.lineWidth = 3 * unit; pen.strokeStyle = "#000"; pen.fillStyle = "#fff"; pen.lineJoin = "round";
  pen.strokeText(`${mm} mm`, x, y - 4 * unit); pen.fillText(`${mm} mm`, x, y - 4 * unit);
}
