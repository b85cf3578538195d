// The colours of the style sheet, light or dark, as canvases need them.

/** Colours by the name of their custom property, without dashes. */
const palette = {};

function readPalette() {
  const style = getComputedStyle(document.documentElement);
  for (const name of [
    "ink", "paper", "muted", "grid", "ghost", "piston", "bit", "rock", "ground", "casing", "steel", "air",
    "tension", "compression", "ff", "dfc", "fc", "bc", "ss",
  ]) palette[name] = style.getPropertyValue(`--${name}`).trim();
}

/** Calls back whenever the colours have changed. */
function followPalette(changed) {
  readPalette();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    readPalette();
    changed();
  });
}

/** The three numbers of a colour written #rrggbb. */
const channels = (colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));

/** 201 colours [red, green, blue], for stresses from -1 to 1 times the largest. */
function stressColours(neutral = palette.steel) {
  const [middle, red, blue] = [neutral, palette.tension, palette.compression].map(channels);
  return Array.from({ length: 201 }, (_, i) => {
    const part = (i - 100) / 100, ends = part > 0 ? red : blue;
    // Small stresses show too, since the colour grows faster than the stress.
    const weight = Math.abs(part) ** 0.7;
    return middle.map((from, k) => Math.round(from + weight * (ends[k] - from)));
  });
}

/** The index of a stress in these colours. */
const shade = (part) => 100 + Math.round(100 * Math.max(-1, Math.min(1, part)));

/** Fits a canvas to its element, at the screen's resolution. Returns width, height and scale. */
function fit(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas.place ?? canvas;
  const scale = canvas.scale ?? (window.devicePixelRatio || 1);
  const size = [Math.round(width * scale), Math.round(height * scale)];
  if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
  canvas.getContext("2d").setTransform(scale, 0, 0, scale, 0, 0);
  return [width, height, scale];
}
