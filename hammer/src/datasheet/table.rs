//! The blows of air hammers in dimensionless numbers: one table for all sizes and strokes.
//!
//! Consider a rigid hammer that is scaled from the presets and whose cylinder is held. In units of the stroke `L`, the
//! bore's area `A`, the piston's mass `m` and the atmosphere's pressure `p0`, it depends on two numbers: the supply's
//! pressure, and the opening `s` of its ports of area `a`,
//!
//! ```text
//! s = (a / A) sqrt(R T m / (p0 A L)),   energy = p0 A L e,   frequency = f / sqrt(m L / (p0 A)),
//! free air = q A L / sqrt(m L / (p0 A)),   the piston turns h L above the bit
//! ```
//!
//! Gravity, some hundredths of the pressure's force, is that of one particular hammer. The table is a constant
//! (`nodes`), and a test simulates it again.

use super::nodes::NODES;
use crate::numerics::math;
use crate::quantities::air::ATMOSPHERE;
use crate::scene::Scene;

/// Nodes of the table: least and largest value, and number of nodes; first for pressures over the atmosphere's, then
/// for openings.
const PRESSURES: ([f64; 2], usize) = ([1.5, 40.0], 6);
const OPENINGS: ([f64; 2], usize) = ([0.15, 6.0], 7);
/// Gas constant of air, J/(kg K).
const GAS: f64 = 287.05;

/// Logarithms of `e`, `f`, `q` and `h`.
pub(super) type Logs = [f64; 4];

/// The dimensions with which a hammer is scaled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    /// Area of the bore, m2; mass of the piston, kg; stroke over the presets' stroke.
    pub area: f64,
    pub mass: f64,
    pub stroke: f64,
}

impl Scales {
    /// The hammer's units of energy, time and volume.
    pub fn of(&self) -> [f64; 3] {
        let Self { area, mass, stroke } = *self;
        [ATMOSPHERE * area * stroke, (mass * stroke / (ATMOSPHERE * area)).sqrt(), area * stroke]
    }

    /// The opening `s` of a port whose area is that of the bore.
    pub fn opening(&self) -> f64 {
        let Self { area, mass, stroke } = *self;
        (GAS * Scene::default().parameters.air.temperature * mass / (ATMOSPHERE * area * stroke))
            .sqrt()
    }
}

/// Interpolates at the logarithms of the pressure (over the atmosphere's) and of the opening: with cubics of continuous
/// slope between the nodes, and linearly outside.
pub(super) fn at(pressure: f64, opening: f64) -> Logs {
    let index = |(ends, count): ([f64; 2], usize), x: f64| {
        let [low, high] = ends.map(math::ln);
        (x - low) / (high - low) * (count - 1) as f64
    };
    let [u, v] = [index(PRESSURES, pressure), index(OPENINGS, opening)];
    std::array::from_fn(|number| {
        let row = |i: usize| spline(OPENINGS.1, v, |k| NODES[i * OPENINGS.1 + k][number]);
        spline(PRESSURES.1, u, row)
    })
}

/// Interpolates between values at 0, 1, 2 and so on.
fn spline(count: usize, x: f64, value: impl Fn(usize) -> f64) -> f64 {
    let last = count - 1;
    if x <= 0.0 {
        return value(0) + x * (value(1) - value(0));
    }
    if x >= last as f64 {
        return value(last) + (x - last as f64) * (value(last) - value(last - 1));
    }
    let i = (x as usize).min(last - 1);
    let (t, b, c) = (x - i as f64, value(i), value(i + 1));
    let a = if i == 0 { 2.0 * b - c } else { value(i - 1) };
    let d = if i + 2 > last { 2.0 * c - b } else { value(i + 2) };
    let bend = 2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a);
    b + 0.5 * t * (c - a + t * bend)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::datasheet::air::{AirBlow, FEED};
    use crate::means::{Kind, Wanted, steady};
    use crate::presets::AirHammer;
    use crate::quantities::parameters::Fidelity;

    /// `air.error` of the simulations, small enough for an accuracy of 1 %.
    const ERROR: f64 = 1e-4;
    /// Number of blows before the height is read; by then energies have settled to 1e-3.
    const SETTLED: u64 = 40;

    /// Value number `index` of a range of nodes.
    fn place((ends, count): ([f64; 2], usize), index: usize) -> f64 {
        let [low, high] = ends.map(math::ln);
        math::exp(low + (high - low) * index as f64 / (count - 1) as f64)
    }

    /// The rigid hammer of a node, simulated until its blows repeat. With small ports the first blows differ by up to 5
    /// %.
    fn node(pressure: f64, opening: f64) -> Logs {
        let hammer = |supply| {
            let feed = FEED * 0.105 * 0.105 * pressure * ATMOSPHERE;
            AirHammer { supply, ..AirHammer::in_proportion(0.105, 9.1, 0.115, feed) }
        };
        let scene = |supply| {
            let mut scene = hammer(supply).at(pressure * ATMOSPHERE);
            let p = &mut scene.parameters;
            p.fidelity = Fidelity::Rigid;
            p.air.error = ERROR;
            AirHammer::hold(p);
            scene
        };
        let p = scene(1e-4).parameters;
        let scales = Scales { area: p.drive.area_drive, mass: p.piston_mass(), stroke: 1.0 };
        let [energy, time, volume] = scales.of();
        let scene = scene(opening / scales.opening() * scales.area);
        let found = steady(&scene, &Wanted::default(), &mut |_, _| true).expect("blows");
        assert!(matches!(found.kind, Kind::Cycle(_)), "{pressure} {opening}: {:?}", found.kind);
        let mean = |name| found.mean.get(name);
        let height = AirBlow::after(&scene, SETTLED).expect("blows").height;
        let volumes = mean("air_flow") * time / volume;
        [mean("blow_energy") / energy, time * mean("blow_frequency"), volumes, height].map(math::ln)
    }

    /// The table equals one that is simulated now. The four numbers of a blow may differ by a few times the allowed
    /// error of the air, and by rounding to five decimals. If they differ by more, the test prints the new table.
    #[test]
    fn the_table_is_made_anew_by_its_hammers() {
        let places = (0..PRESSURES.1).flat_map(|i| (0..OPENINGS.1).map(move |k| [i, k]));
        let made = places.map(|[i, k]| node(place(PRESSURES, i), place(OPENINGS, k)));
        let made: Vec<Logs> = made.collect();
        let text = || {
            let row = |[a, b, c, d]: &Logs| format!("    [{a:.5}, {b:.5}, {c:.5}, {d:.5}],\n");
            made.iter().map(row).collect::<String>()
        };
        assert_eq!(made.len(), NODES.len());
        for (row, known) in made.iter().zip(&NODES) {
            let close = row.iter().zip(known).all(|(a, b)| (a - b).abs() < 5.0 * ERROR);
            assert!(close, "\n{}", text());
        }
    }

    /// Interpolation reproduces a straight line everywhere, and a parabola between inner nodes (Catmull and Rom: exact
    /// to second degree).
    #[test]
    fn the_spline_is_exact_for_lines_and_inside_for_parabolas() {
        for k in 0..60 {
            let x = -1.0 + 0.1 * f64::from(k);
            let line = |i: usize| {
                assert!(i < 5, "no value at {i}");
                3.0 - 2.0 * i as f64
            };
            assert!((spline(5, x, line) - (3.0 - 2.0 * x)).abs() < 1e-13);
            let square = |i: usize| (i * i) as f64;
            if (1.0..=3.0).contains(&x) {
                assert!((spline(5, x, square) - x * x).abs() < 1e-13, "{x}");
            }
        }
    }

    /// A hammer of another size, piston, stroke and pressure agrees with the table, up to gravity, which here is 0.03
    /// of the pressure's force, and to the interpolation between the nodes.
    #[test]
    fn a_hammer_of_another_size_is_the_table_s() {
        let mut hammer = AirHammer::in_proportion(0.15, 23.9, 0.165, 3e4);
        (hammer.supply, hammer.stroke) = (2.2e-4, 1.3);
        let mut scene = hammer.at(15e5);
        let p = &mut scene.parameters;
        p.fidelity = Fidelity::Rigid;
        AirHammer::hold(p);
        let p = scene.parameters;
        let area = p.drive.area_drive;
        let scales = Scales { area, mass: p.piston_mass(), stroke: 1.3 };
        let [energy, time, volume] = scales.of();
        let opening = math::ln(2.2e-4 / area * scales.opening());
        let [e, f, q, _] = at(math::ln(15e5 / ATMOSPHERE), opening).map(math::exp);
        let mean = steady(&scene, &Wanted::default(), &mut |_, _| true).expect("blows").mean;
        for (told, simulated) in [
            (e * energy, mean.get("blow_energy")),
            (f / time, mean.get("blow_frequency")),
            (q * volume / time, mean.get("air_flow")),
        ] {
            assert!((told / simulated - 1.0).abs() < 0.03, "{told} {simulated}");
        }
    }
}
