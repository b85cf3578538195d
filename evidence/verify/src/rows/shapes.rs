//! Effect of a piston's shape: Lundberg's efficiency, and stepped bodies by characteristics.
//!
//! Efficiency is the work of a blow's wave on a line of loading, over the piston's energy, in a bit so long that no
//! reflection returns before the end. A uniform piston reaches 0.8145 (Lundberg 1973, Int. J. Rock Mech. Min. Sci.
//! 10:381); a wave that grows exponentially tends to 1 (Lundberg and Collet 2010, Int. J. Impact Eng. 37:901).

use crate::rows::mesh::{self, SPEED};
use crate::rows::row::{Row, Rows};
use crate::scene::sharp;
use hammer::{Error, Machine, Parameters, Segment};
use oracles::closed::BEST_PULSE;
use oracles::waves::Waves;

/// Spans of a piston; length of the bit over the piston's.
const SPANS: usize = 32;
const ROD: f64 = 3.0;
/// `KC Lp / (E A)`: the contact's front is half a span wide.
const CONTACT: f64 = 64.0;
const FRONT: &str = "twice the front's delay Z/(2 KC) over T1: power at the tip is at most Z v0^2, 2 in units of the energy a transit";

/// A piston of sections of equal length with these areas, over the bit's, on a long bit and a line of loading.
fn scene(shape: &[f64], b: f64) -> Parameters {
    let mut p = mesh::bare(SPANS);
    let length = p.piston.length;
    p.mesh.degree = 5;
    let part =
        |ratio| Segment { length: length / shape.len() as f64, area: ratio * p.cross_section };
    p.piston.segments.set(&shape.iter().map(part).collect::<Vec<_>>());
    p.bit.length = ROD * length;
    p.bit.elements = (ROD * SPANS as f64) as usize;
    p.contact.stiffness = CONTACT * mesh::stretch(&p) / length;
    p.rock.stiffness = 0.5 * b * mesh::stretch(&p) / length;
    p
}

/// The wave arrives at the tip after one transit of the bit; its reflection returns there after three.
fn end(p: &Parameters) -> f64 {
    mesh::strike() + 3.0 * p.timescales().bit_transit
}

/// The line of loading stores `F^2 / (2 KR)` at the largest force, here over the piston's energy.
fn held(p: &Parameters, largest: f64) -> f64 {
    largest.powi(2) / p.rock.stiffness / (p.piston_mass() * SPEED * SPEED)
}

/// The engine's efficiency.
fn efficiency(p: &Parameters) -> Result<f64, Error> {
    let mut m = Machine::new(p, &mesh::no_inputs(), 0.0)?;
    m.advance(end(p))?;
    Ok(held(p, m.peaks().rock_force()))
}

/// The efficiency of exact waves, which are constant between fronts, with one step in each section.
fn exact(p: &Parameters) -> f64 {
    let mut waves = Waves::new(sharp(p, &mesh::no_inputs()), p.piston.segments.len() as u32);
    waves.advance(end(p));
    held(p, waves.peak)
}

/// Areas that grow upward by a factor from section to section, over the bit's; the lowest is the first.
fn growing(sections: usize, factor: f64, lowest: f64) -> Vec<f64> {
    (0..sections).rev().map(|k| lowest * factor.powi(k as i32)).collect()
}

/// Lundberg's efficiency of a uniform piston, and of pistons with a growing wave.
pub fn efficiencies() -> Result<Vec<Row>, Error> {
    let [best, share] = BEST_PULSE;
    let delay = 0.5 / CONTACT;
    let name = "efficiency of one blow";
    let mut rows = Rows::new(format!("uniform piston, b = {best}"), "Lundberg 1973", FRONT);
    rows.add(name, share, efficiency(&scene(&[1.0], best))?, 2.0 * delay);
    let mut list = rows.list;
    for (sections, factor, lowest, b) in [(6, 1.15, 0.7, best), (8, 1.15, 0.6, 2.0)] {
        let shape = growing(sections, factor, lowest);
        let case = format!("{sections} sections, each {factor} times the next below, b = {b}");
        let mut rows = Rows::new(case, "characteristics in stepped bars", FRONT);
        let p = scene(&shape, b);
        rows.add(name, exact(&p), efficiency(&p)?, 2.0 * delay);
        list.append(&mut rows.list);
    }
    Ok(list)
}

/// Results of elwaspatid's characteristics (`oracles/data/stepped_impact.py`).
#[derive(serde::Deserialize)]
struct Stepped {
    plateaus: Vec<Plateau>,
    impulse: f64,
}

/// A time of constant contact force, N, in s after the impact.
#[derive(serde::Deserialize)]
struct Plateau {
    from: f64,
    to: f64,
    force: f64,
}

const CHARACTERISTICS: &str = include_str!("../../../oracles/data/stepped_impact.json");
const RATTLE: &str = "the faces rattle on the penalty: the way F/KC, as far as the mesh's highest mode has not damped it, over half a plateau, times Z1 Z2/(Z1 + Z2); impulse: the last force over the front's width, by damping and penalty";

/// A stepped piston on a stepped bit: the mean force of each plateau over its middle half, and the
/// impulse of the contact.
///
/// # Panics
/// The committed numbers cannot be read.
pub fn stepped_impact() -> Result<Vec<Row>, Error> {
    let exact: Stepped = serde_json::from_str(CHARACTERISTICS).expect("committed numbers");
    let area = |width: f64| std::f64::consts::FRAC_PI_4 * width * width;
    let mut p = mesh::bare(200);
    p.mesh.degree = 5;
    p.bit.elements = 160;
    let part = |(length, width)| Segment { length, area: area(width) };
    p.piston.segments.set(&[(0.20, 0.060), (0.15, 0.045)].map(part));
    p.bit.segments.set(&[(0.15, 0.050), (0.10, 0.080)].map(part));
    (p.contact.stiffness, p.material.damping_time, p.rock.stiffness) = (1e12, 2e-9, 1.0);
    let mut m = Machine::new(&p, &mesh::no_inputs(), 0.0)?;
    let mut impulse = |at: f64| -> Result<f64, Error> {
        m.advance(mesh::strike() + at)?;
        Ok(m.impulses().contact)
    };
    let [beta, stiffness] = [p.material.damping_time, p.contact.stiffness];
    let highest = std::f64::consts::PI * p.wave_speed() * p.piston.elements as f64 / 0.35;
    let [striker, struck] = [0.045, 0.050].map(|width| p.impedance_of(area(width)));
    let series = striker * struck / (striker + struck);
    let source = "elwaspatid 2.0.1, characteristics";
    let mut rows = Rows::new("stepped piston on stepped bit, degree 5", source, RATTLE);
    for Plateau { from, to, force } in exact.plateaus {
        let (quarter, middle) = (0.25 * (to - from), 0.5 * (from + to));
        let begun = impulse(from + quarter)?;
        let mean = (impulse(to - quarter)? - begun) / (2.0 * quarter);
        let left = (-0.5 * beta * highest * highest * quarter).exp();
        let tolerance = series * force / stiffness * left / (2.0 * quarter);
        rows.add(format!("force at {:.0} us, N", 1e6 * middle), force, mean, tolerance);
    }
    let (end, last) = (1.353e-4, 432e3);
    let width = (beta * end).sqrt() + struck / stiffness;
    rows.add("impulse, N s", exact.impulse, impulse(end + 2e-5)?, 0.5 * last * width);
    Ok(rows.list)
}
