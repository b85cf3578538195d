// A pen that draws an SVG with the methods of a canvas's context, and files of figures.

/** A context by which text is measured. */
const measuring = document.createElement("canvas").getContext("2d");

/** Canvas and context at once, as large as a place on the page. */
class SvgPen {
  constructor(place) {
    Object.assign(this, { place, parts: [], path: "", dash: [], turn: "", kept: [], clips: 0, open: 0 });
    Object.assign(this, { globalAlpha: 1, lineWidth: 1, fillStyle: "#000", strokeStyle: "#000", font: "12px sans-serif",
        textAlign: "left", textBaseline: "alphabetic" });
  }

  getContext() {
    return this;
  }

  /** Shows what is drawn in its place. */
  show() {
    this.place.innerHTML = String(this);
  }

  put(element, paint, more = "") {
    const alpha = this.globalAlpha < 1 ? ` opacity="${this.globalAlpha}"` : "",
        turn = this.turn && ` transform="${this.turn}"`;
    this.parts.push(`<${element} ${paint}${alpha}${turn}${more ? `>${more}</${element.split(" ")[0]}>` : "/>"}`);
  }

  get stroking() {
    const dash = this.dash.length ? ` stroke-dasharray="${this.dash}"` : "";
    return `fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}" stroke-linejoin="round"${dash}`;
  }

  beginPath() {
    this.path = "";
  }

  moveTo(...at) {
    this.path += `M${at.map(short)}`;
  }

  lineTo(...at) {
    this.path += `${this.path ? "L" : "M"}${at.map(short)}`;
  }

  rect(x, y, width, height) {
    this.path += `M${[x, y].map(short)}h${short(width)}v${short(height)}h${short(-width)}z`;
  }

  arc(x, y, radius) {
    this.ellipse(x, y, radius, radius, 0, 0, 2 * Math.PI);
  }

  /** From an angle to a larger one, at most once round. */
  ellipse(x, y, wide, high, _, from, to) {
    const at = (angle) => [x + wide * Math.cos(angle), y + high * Math.sin(angle)].map(short),
        size = [wide, high].map(short);
    const half = 0.5 * (from + to);
    this.path += `M${at(from)}A${size} 0 0 1 ${at(half)}A${size} 0 0 1 ${at(to)}`;
  }

  fill() {
    this.put(`path d="${this.path}"`, `fill="${this.fillStyle}"`);
  }

  stroke() {
    this.put(`path d="${this.path}"`, this.stroking);
  }

  fillRect(x, y, width, height) {
    this.put(`rect ${box(x, y, width, height)}`, `fill="${this.fillStyle}"`);
  }

  strokeRect(x, y, width, height) {
    this.put(`rect ${box(x, y, width, height)}`, this.stroking);
  }

  clearRect() {}

  drawImage(canvas, x, y, width, height) {
    this.parts.push(`<image ${box(x, y, width, height)} preserveAspectRatio="none" href="${canvas.toDataURL()}"/>`);
  }

  setLineDash(dash) {
    this.dash = dash;
  }

  /** What a figure begins with. */
  setTransform() {
    this.parts = [];
  }

  measureText(words) {
    measuring.font = this.font;
    return measuring.measureText(words);
  }

  text(words, x, y, room, paint) {
    const anchor = { left: "start", center: "middle", right: "end" }[this.textAlign];
    const base = { middle: "central", bottom: "text-after-edge" }[this.textBaseline] ?? "auto";
    const squeezed = room !== undefined && this.measureText(words).width > room
        ? ` textLength="${short(room)}" lengthAdjust="spacingAndGlyphs"` : "";
    const [, weight, size, family] = /^(\d+ )?([\d.]+px) (.*)$/.exec(this.font);
    const face =
      `font-family="${family.replace(/"/g, "'")}" font-size="${size}" ` +
      `font-weight="${(weight ?? "400").trim()}"`;
    const style = `${face} text-anchor="${anchor}" dominant-baseline="${base}"${squeezed}`;
    this.put(`text x="${short(x)}" y="${short(y)}" ${style}`, paint,
        words.replace(/&/g, "&amp;").replace(/</g, "&lt;"));
  }

  fillText(words, x, y, room) {
    this.text(words, x, y, room, `fill="${this.fillStyle}"`);
  }

  strokeText(words, x, y, room) {
    this.text(words, x, y, room, this.stroking);
  }

  save() {
    const { turn, open, globalAlpha, lineWidth, fillStyle, strokeStyle } = this;
    this.kept.push({ turn, open, globalAlpha, lineWidth, fillStyle, strokeStyle });
  }

  restore() {
    const before = this.kept.pop();
    for (; this.open > before.open; this.open--) this.parts.push("</g>");
    Object.assign(this, before);
  }

  clip() {
    this.clips += 1;
    this.open += 1;
    this.parts.push(
      `<clipPath id="c${this.clips}"><path d="${this.path}"/></clipPath>` +
        `<g clip-path="url(#c${this.clips})">`,
    );
  }

  translate(x, y) {
    this.turn += ` translate(${short(x)} ${short(y)})`;
  }

  rotate(angle) {
    this.turn += ` rotate(${short((180 * angle) / Math.PI)})`;
  }

  toString() {
    const { clientWidth: width, clientHeight: height } = this.place,
        size = `viewBox="0 0 ${width} ${height}" width="${width}" height="${height}"`;
    return `<svg xmlns="http://www.w3.org/2000/svg" ${size}>` +
      `<rect width="100%" height="100%" fill="${palette.paper}"/>${this.parts.join("")}</svg>\n`;
  }
}

/** What figures are drawn with, on whatever pen. */
class Drawing {
  constructor(pen) {
    this.pen = pen;
  }

  text(words, x, y, align = "center", room = undefined, fillStyle = palette.ink) {
    Object.assign(this.pen, { fillStyle, textAlign: align, textBaseline: "middle" });
    this.pen.fillText(words, x, y, room);
  }

  line(points, stroke, width = 2.5, dash = []) {
    const { pen } = this;
    Object.assign(pen, { strokeStyle: stroke, lineWidth: width });
    pen.setLineDash(dash);
    pen.beginPath();
    points.forEach(([x, y]) => pen.lineTo(x, y));
    pen.stroke();
    pen.setLineDash([]);
  }

  /** Words that run upward. */
  upright(words, x, y, room = undefined) {
    const { pen } = this;
    pen.save();
    pen.translate(x, y);
    pen.rotate(-Math.PI / 2);
    this.text(words, 0, 0, "center", room);
    pen.restore();
  }

  /** Words with an edge of paper, which are read over anything. */
  edged(words, x, y, room = undefined) {
    Object.assign(this.pen, { lineWidth: 4, strokeStyle: palette.paper, fillStyle: palette.ink });
    this.pen.strokeText(words, x, y, room);
    this.pen.fillText(words, x, y, room);
  }

  dot(x, y, fill = palette.ink, size = 6) {
    const { pen } = this;
    pen.fillStyle = fill;
    pen.beginPath();
    pen.arc(x, y, size, 0, 2 * Math.PI);
    pen.fill();
  }

  block(left, right, from, to, fill) {
    this.pen.fillStyle = fill;
    this.pen.fillRect(left, Math.min(from, to), right - left, Math.abs(to - from));
  }

}

const short = (number) => Number(number.toFixed(2));
const box = (...numbers) => ["x", "y", "width", "height"].map((name, i) => `${name}="${short(numbers[i])}"`).join(" ");

/** Saves a figure, as large as its place, that `draw` draws on a canvas: as SVG, or as PNG of twice the pixels. */
function saveFigure(name, kind, { clientWidth, clientHeight }, draw) {
  if (kind === "svg") {
    const pen = new SvgPen({ clientWidth, clientHeight });
    draw(pen);
    return save(`${name}.svg`, String(pen), "image/svg+xml");
  }
  const [width, height] = [2 * clientWidth, 2 * clientHeight], canvas = Object.assign(document.createElement("canvas"),
      { width, height }), pen = canvas.getContext("2d");
  pen.scale(2, 2);
  draw({ clientWidth, clientHeight, width, height, scale: 2, getContext: () => pen });
  pen.setTransform(1, 0, 0, 1, 0, 0);
  // Empty areas get the colour of paper.
  Object.assign(pen, { globalCompositeOperation: "destination-over", fillStyle: palette.paper });
  pen.fillRect(0, 0, width, height);
  return canvas.toBlob((blob) => save(`${name}.png`, blob, "image/png"));
}

/** A picture drawn on another canvas than its own, once. */
function drawnOn(picture, canvas, draw) {
  const { canvas: own, pen } = picture;
  Object.assign(picture, { canvas, pen: canvas.getContext("2d") });
  draw();
  Object.assign(picture, { canvas: own, pen });
}
