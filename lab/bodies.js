// Piston and bit of the scene: uniform, or a list of sections.

const BODIES = ["piston", "bit"];

/** The sections of a body, top to bottom: [length, area] each. */
function sectionsOf(scene, body) {
  const count = scene.variable(`${body}.segments`) ? scene.get(`${body}.segments`) : 0;
  if (count === 0) return [[scene.get(`${body}.length`), scene.get("cross_section")]];
  return Array.from({ length: count }, (_, i) => sectionNames(body, i + 1).map((name) => scene.get(name)));
}

function sectionNames(body, number) {
  return ["length", "area"].map((what) => `${body}.segment[${number}].${what}`);
}

/** What the drawing needs: lengths, and for each element of the mesh its ends and its area. */
function measure(scene, cycle) {
  return BODIES.map((body, index) => {
    const sections = sectionsOf(scene, body);
    const length = sections.reduce((sum, [part]) => sum + part, 0);
    const count = cycle.stress[index][0]?.length ?? 0;
    const ends = Array.from({ length: count + 1 }, (_, i) => (i / count) * length);
    const areaAt = (place) => {
      let bottom = 0;
      return (sections.find(([part]) => place < (bottom += part)) ?? sections.at(-1))[1];
    };
    const areas = Array.from({ length: count }, (_, i) => areaAt(0.5 * (ends[i] + ends[i + 1])));
    return { length, ends, areas };
  });
}

/** Cuts a body into equal sections of its present length and section, or makes it uniform. */
function cut(scene, body, count) {
  const sections = sectionsOf(scene, body);
  const length = sections.reduce((sum, [part]) => sum + part, 0);
  for (let number = 1; scene.variable(sectionNames(body, number)[0]); number++) {
    const [ofLength, ofArea] = sectionNames(body, number);
    // Existing sections stay; new ones are like the last one, and the whole length is kept.
    const own = sections.length > 1 && number <= Math.min(sections.length, count);
    const [part, area] = own ? sections[number - 1] : [length / count, sections.at(-1)[1]];
    const read = number <= count;
    scene.set(ofLength, read ? Number(part.toPrecision(6)) : scene.variable(ofLength).start);
    scene.set(ofArea, read ? area : scene.variable(ofArea).start);
  }
  scene.set(`${body}.segments`, count);
}
