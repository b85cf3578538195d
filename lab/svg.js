// A pen that draws an SVG: what a canvas's context does of what the figures ask of it.

class SvgPen {
  /** `measure` is a canvas's context, by which text is measured. */
  constructor(width, height, measure) {
    Object.assign(this, { width, height, measure, parts: [], path: "", dash: [], turn: "", kept: [], clips: 0, open: 0 });
    Object.assign(this, { globalAlpha: 1, lineWidth: 1, fillStyle: "#000", strokeStyle: "#000", font: "12px sans-serif", textAlign: "left", textBaseline: "alphabetic" });
  }

  put(element, paint, more = "") {
    const alpha = this.globalAlpha < 1 ? ` opacity="${this.globalAlpha}"` : "", turn = this.turn && ` transform="${this.turn}"`;
    this.parts.push(`<${element} ${paint}${alpha}${turn}${more ? `>${more}</${element.split(" ")[0]}>` : "/>"}`);
  }

  get filling() {
    return `fill="${this.fillStyle}"`;
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
    const at = (angle) => [x + wide * Math.cos(angle), y + high * Math.sin(angle)].map(short), size = [wide, high].map(short);
    const half = 0.5 * (from + to);
    this.path += `M${at(from)}A${size} 0 0 1 ${at(half)}A${size} 0 0 1 ${at(to)}`;
  }

  fill() {
    this.put(`path d="${this.path}"`, this.filling);
  }

  stroke() {
    this.put(`path d="${this.path}"`, this.stroking);
  }

  fillRect(x, y, width, height) {
    this.put(`rect ${box(x, y, width, height)}`, this.filling);
  }

  strokeRect(x, y, width, height) {
    this.put(`rect ${box(x, y, width, height)}`, this.stroking);
  }

  clearRect() {
    this.parts = [];
  }

  setLineDash(dash) {
    this.dash = dash;
  }

  setTransform() {}

  measureText(words) {
    this.measure.font = this.font;
    return this.measure.measureText(words);
  }

  text(words, x, y, room, paint) {
    const anchor = { left: "start", center: "middle", right: "end" }[this.textAlign];
    const base = { middle: "central", bottom: "text-after-edge" }[this.textBaseline] ?? "auto";
    const squeezed = room !== undefined && this.measureText(words).width > room ? ` textLength="${short(room)}" lengthAdjust="spacingAndGlyphs"` : "";
    const [, weight, size, family] = /^(\d+ )?([\d.]+px) (.*)$/.exec(this.font);
    const face = `font-family="${family.replace(/"/g, "'")}" font-size="${size}" font-weight="${(weight ?? "400").trim()}"`;
    const style = `${face} text-anchor="${anchor}" dominant-baseline="${base}"${squeezed}`;
    this.put(`text x="${short(x)}" y="${short(y)}" ${style}`, paint, words.replace(/&/g, "&amp;").replace(/</g, "&lt;"));
  }

  fillText(words, x, y, room) {
    this.text(words, x, y, room, this.filling);
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
    this.parts.push(`<clipPath id="c${this.clips}"><path d="${this.path}"/></clipPath><g clip-path="url(#c${this.clips})">`);
  }

  translate(x, y) {
    this.turn += ` translate(${short(x)} ${short(y)})`;
  }

  rotate(angle) {
    this.turn += ` rotate(${short((180 * angle) / Math.PI)})`;
  }

  toString() {
    const size = `viewBox="0 0 ${this.width} ${this.height}" width="${this.width}" height="${this.height}"`;
    return `<svg xmlns="http://www.w3.org/2000/svg" ${size}><rect width="100%" height="100%" fill="${palette.paper}"/>${this.parts.join("")}</svg>\n`;
  }
}

const short = (number) => Number(number.toFixed(2));
const box = (...numbers) => ["x", "y", "width", "height"].map((name, i) => `${name}="${short(numbers[i])}"`).join(" ");
