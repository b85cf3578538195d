//! What the shape of a piston does: Lundberg's efficiency, and a drill test.
//!
//! Efficiency is the work that the wave of one blow does on a line of loading, over the
//! piston's energy, in a bit so long that nothing of it returns before it is over. A uniform
//! piston reaches 0.8145 (Lundberg 1973, Int. J. Rock Mech. Min. Sci. 10:381), a wave that
//! grows exponentially tends to 1 (Lundberg and Collet 2010, Int. J. Impact Eng. 37:901).

use crate::mesh::{self, SPEED};
use crate::row::{Row, Rows};
use hammer::{Error, Machine, Parameters, Segment};
use oracles::closed::BEST_PULSE;
use oracles::lattice::of_piston;

/// Spans a piston, and lengths of the bit over the piston's.
const SPANS: usize = 32;
const ROD: f64 = 3.0;
/// `KC Lp / (E A)`: the contact's front is half a span wide.
const CONTACT: f64 = 64.0;
const FRONT: &str = "twice the front's delay Z/(2 KC) over T1: power at the tip is at most Z v0^2, 2 in units of the energy a transit";

/// A piston of equal lengths with these areas, over the bit's, on a long bit and a line of
/// loading.
fn scene(shape: &[f64], b: f64) -> Parameters {
    let mut p = mesh::bare(SPANS);
    let length = p.piston.length;
    p.mesh.degree = 5;
    p.piston.segments = shape.len();
    for (segment, ratio) in p.piston.segment.iter_mut().zip(shape) {
        *segment = Segment { length: length / shape.len() as f64, area: ratio * p.cross_section };
    }
    p.bit.length = ROD * length;
    p.bit.elements = (ROD * SPANS as f64) as usize;
    p.contact.stiffness = CONTACT * mesh::stretch(&p) / length;
    p.rock.stiffness = 0.5 * b * mesh::stretch(&p) / length;
    p
}

/// The engine's efficiency: the line of loading holds `F^2 / (2 KR)` where the force is largest.
fn efficiency(p: &Parameters) -> Result<f64, Error> {
    let mut m = Machine::new(p, &mesh::no_inputs(), 0.0)?;
    // The wave is there after the bit's transit; what the tip throws back comes again after
    // three.
    m.advance(mesh::strike() + 3.0 * p.timescales().bit_transit)?;
    let work = 0.5 * m.peaks().rock_force.powi(2) / p.rock.stiffness;
    Ok(work / (0.5 * p.piston_mass() * SPEED * SPEED))
}

/// Areas that grow upward by a factor a section, over the bit's: the lowest is the first.
fn growing(sections: usize, factor: f64, lowest: f64) -> Vec<f64> {
    (0..sections).rev().map(|k| lowest * factor.powi(k as i32)).collect()
}

/// Lundberg's efficiency of a uniform piston and of pistons whose wave grows.
///
/// # Errors
/// Whatever the engine says.
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
        rows.add(name, of_piston(&shape, b), efficiency(&scene(&shape, b))?, 2.0 * delay);
        list.append(&mut rows.list);
    }
    Ok(list)
}

/// A drill test (Yang 2025, Int. J. Rock Mech. Min. Sci. 191:106125): a piston of 26.5 mm by
/// 260 mm strikes a bit of 30 mm by 265 mm at 10.66 m/s; the first wave was 200 MPa, read off a
/// figure to a tenth.
///
/// # Errors
/// Whatever the engine says.
pub fn drill_test() -> Result<Vec<Row>, Error> {
    let [striker, struck]: [f64; 2] =
        [0.0265, 0.030].map(|width: f64| std::f64::consts::FRAC_PI_4 * width * width);
    let mut p = scene(&[1.0], 1.0);
    (p.cross_section, p.piston.segment[0].area) = (struck, striker);
    (p.piston.segment[0].length, p.bit.length) = (0.26, 0.265);
    (p.bit.elements, p.piston.initial_velocity) = (SPANS, 10.66);
    // A front of a few spans, so that nothing rings on the plateau behind it.
    p.contact.stiffness = 0.125 * CONTACT * mesh::stretch(&p) / p.bit.length;
    p.rock.stiffness = Parameters::default().rock.stiffness;
    let mut m = Machine::new(&p, &mesh::no_inputs(), 0.0)?;
    m.advance(p.contact.initial_gap / 10.66 + 1.2 * p.timescales().bit_transit)?;
    let stress = m.kinematics().contact_force / struck;
    let why = "a tenth, to which the figure was read: a plausibility check, no validation";
    let mut rows = Rows::new("single insert on limestone", "Yang 2025, measured", why);
    rows.add("first wave in the bit, MPa", 200.0, 1e-6 * stress, 20.0);
    Ok(rows.list)
}
