// The numbers in the texts of the explanation, in the units of the texts: predictions from the scene, by the formulas
// that the texts name, and results of the engine.

const soundOf = (values) => Math.sqrt(valueOf(values, "material.youngs_modulus") / valueOf(values, "material.density"));
const valueOf = (values, name) => values[name] ?? description.variables[name].start;
const workOf = (mean) => mean.energy_rock_dissipated + mean.energy_viscous;
/** Share of the energy from drive, feed and weight that stays in the rock. */
const shareOf = (mean) => workOf(mean) / (mean.energy_drive + mean.energy_feed + mean.energy_gravity);
/** Energy of the piston that rebounds from a blow, J. */
const reboundOf = (mean, mass) => 0.5 * mass * mean.rebound_speed ** 2;

/** Samples of one period, from blow to blow: [first, last]. */
function periodOf({ time, impact, period }) {
  return [time.findIndex((t) => t >= impact), time.findLastIndex((t) => t <= impact + period)];
}

/** The integral of one column over another between two samples. */
function areaUnder(y, x, [first, last]) {
  let sum = 0;
  for (let i = first; i < last; i++) sum += 0.5 * (y[i] + y[i + 1]) * (x[i + 1] - x[i]);
  return sum;
}

function told(page, found, place) {
  const { values, mean: { mean }, cycle } = found, of = (name) => valueOf(values, name);
  const mass = of("material.density") * of("piston.segment[1].length") * of("piston.segment[1].area");
  const numbers = {
    mass, speed: mean.blow_speed, energy: mean.blow_energy, times: mean.blow_frequency,
        height: mean.blow_speed ** 2 / (2 * of("gravity")),
    bar: (of("supply_pressure") - ATMOSPHERE) / BAR, air: 60 * mean.air_flow, drive: mean.energy_drive,
        work: workOf(mean),
    share: (100 * workOf(mean)) / mean.blow_energy,
  };
  return Object.assign(numbers, TOLD[page.screen](numbers, { page, found, place, mean, cycle, of, mass }));
}

/** Further numbers in the text of each screen. */
const TOLD = [
  (_, { cycle }) => ({
    rise: 1e3 * (cycle.relative_position[periodOf(cycle)[0]] - Math.min(...cycle.relative_position)),
  }),
  (_, { cycle, of }) => {
    const ends = periodOf(cycle), way = cycle.piston_position.map((x, i) => x - cycle.casing_position[i]);
    const over = (name) => cycle[name].map((p) => p - ATMOSPHERE);
    const above = of("drive.area_drive") * areaUnder(over(CHAMBERS[0]), way, ends),
        below = -of("drive.area_return") * areaUnder(over(CHAMBERS[1]), way, ends);
    return { above, below, both: above + below, face_above: 1e4 * of("drive.area_drive"),
        face_below: 1e4 * of("drive.area_return") };
  },
  ({ speed }, { found: { values }, cycle, of }) => {
    const wave = soundOf(values), area = of("piston.segment[1].area"), long = of("bit.segment[1].length");
    const at = (time) => cycle.time.findIndex((t) => t >= cycle.impact + time), flat = [at(2e-5), at(7e-5)],
        shock = 0.5 * speed * area * of("material.density") * wave;
    // A front has a width; it is taken to be where the stress is half, at the middle element's upper edge.
    const middle = 0.5 * of("bit.elements"),
        stress = cycle.stress[1].map((row) => -0.5 * area * (row[middle - 1] + row[middle]));
    const next = stress.findIndex((force, i) => i > at(0) && force > 0.5 * shock),
        part = (0.5 * shock - stress[next - 1]) / (stress[next] - stress[next - 1]);
    return {
      wave, shock: 1e-3 * shock,
          contact: (1e-3 * areaUnder(cycle.contact_force, cycle.time, flat)) /
          (cycle.time[flat[1]] - cycle.time[flat[0]]), half: 500 * long, arrives: (5e5 * long) / wave,
      felt: 1e6 * (cycle.time[next - 1] + part * (cycle.time[next] - cycle.time[next - 1]) - cycle.impact),
    };
  },
  (_, { cycle, of }) => ({ loop: areaUnder(cycle.rock_force, cycle.bit_tip_position, periodOf(cycle)),
      steeper: of("rock.unloading_ratio") }),
  (_, { place, mean, mass }) => {
    const feed = mean.energy_feed + mean.energy_gravity, rebound = reboundOf(mean, mass);
    const given = mean.energy_drive + feed + rebound, gone = workOf(mean) + mean.energy_damping + rebound;
    return { stiffer: place, feed, rebound, damping: mean.energy_damping, given, gone, kept: 100 * shareOf(mean),
        peak: 1e-3 * mean.rock_force_peak };
  },
  ({ work, times }, { page, mean, of }) => {
    const area = (Math.PI / 4) * of("hole.diameter") ** 2, [easy, hard] = page.rocks(),
        rate = (energy) => (3600 * work * times) / (area * energy);
    return {
      power: 1e-3 * work * times, diameter: 1e3 * of("hole.diameter"), metre: 1e-6 * area * of("rock.specific_energy"),
          predicted: rate(of("rock.specific_energy")), rate: 3600 * mean.rop,
      low: rate(hard), high: rate(easy), hard: Number((1e-6 * hard).toPrecision(2)),
          easy: Number((1e-6 * easy).toPrecision(2)),
    };
  },
  (_, { page, found: { hammer }, place, mean, of, mass }) => {
    // The force that turns the piston round pushes the casing up: the impulse of each blow times the frequency.
    const { blow_speed, rebound_speed, blow_frequency } = hammer.mean,
        push = 1e-3 * mass * (blow_speed + rebound_speed) * blow_frequency;
    const weight = 1e-3 * (of("casing.mass") + mass) * of("gravity");
    return { feed: 1e-3 * place, rate: 3600 * mean.rop, held_rate: 3600 * hammer.mean.rop,
        part: (100 * mean.rop) / hammer.mean.rop, push, weight, least: push - weight,
        held: 1e-3 * page.hammer.feed_force };
  },
  (_, { found: { hammer, loose }, place, mean, of }) => {
    const bit = of("bit.segment[1].length") + of("bit.segment[2].length"),
        long = of("drill.shank.length") + place * of("drill.rod.length") + bit;
    return {
      rods: place, long, tight: 100 * shareOf(mean), loose: 100 * shareOf(loose.mean), down: 100 * shareOf(hammer.mean),
      slack: 1e3 * LOOSE["drill.joint.slack"],
    };
  },
];
