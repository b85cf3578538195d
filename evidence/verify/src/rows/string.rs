//! Drill strings: the wave of a blow down shank, rods and couplings, against characteristics.
//!
//! The contact's penalty is soft enough for the mesh. Its front, `1 - exp(-t KC/Z)` with `1/Z = 1/Zp + 1/Zs`, is the
//! only one; all later steps have its shape.

use crate::rows::mesh::{self, SPEED};
use crate::rows::row::{Row, Rows};
use hammer::Drill;
use hammer::{Body, Error, Machine, Parameters, Segment};
use serde::Deserialize;

/// A wave front and its resolution.
#[derive(Clone, Copy)]
struct Front {
    /// Its width, `c Z/KC`, m.
    width: f64,
    /// Spans in that width.
    spans: f64,
    /// Damping time, s.
    damping: f64,
}

impl Front {
    /// Width over which damping spreads it in a time, `c sqrt(beta t)`, over its own width.
    fn spread(&self, p: &Parameters, time: f64) -> f64 {
        p.wave_speed() * (self.damping * time).sqrt() / self.width
    }

    /// Amplitude of the front at the mesh's shortest wave, `k = pi/h`, after damping.
    fn ripple(&self, p: &Parameters, time: f64) -> f64 {
        let phase = std::f64::consts::PI * self.spans;
        let rate = p.wave_speed() * phase / self.width;
        (-0.5 * self.damping * rate * rate * time).exp() / (1.0 + phase * phase)
    }
}

/// A piston strikes a string at rest on elastic rock, without loads.
fn scene(piston: Segment, drill: Drill, bit: Segment, front: Front) -> Parameters {
    let mut p = mesh::bare(1);
    (p.mesh.degree, p.material.damping_time) = (5, front.damping);
    p.drill = drill;
    p.piston.segments.set(&[piston]);
    p.bit.segments.set(&[bit]);
    let [a, b] = [piston.area, drill.shank.area].map(|area| p.impedance_of(area));
    p.contact.stiffness = p.wave_speed() * a * b / (a + b) / front.width;
    let spans = |body| {
        let sections = p.sections(body);
        let of = |s: &Segment| (s.length * front.spans / front.width).ceil() as usize;
        sections.as_slice().iter().map(of).sum()
    };
    (p.piston.elements, p.bit.elements) = (spans(Body::Piston), spans(Body::Bit));
    p
}

/// The span in the middle of a rod (from 1), between its sleeves, and the distance of its middle from the struck
/// face, m.
fn station(p: &Parameters, rod: usize) -> (usize, f64) {
    let Drill { rods, shank, rod: part, coupling, .. } = p.drill;
    let last = if rod == rods { 0.25 } else { 0.0 };
    let place = shank.length + part.length * (rod as f64 - 0.5) + last * coupling.length;
    let nodes = p.sections(Body::Bit).nodes(p.bit.elements);
    let span = nodes.windows(2).position(|ends| ends[1] > place).unwrap_or(0);
    (span, 0.5 * (nodes[span] + nodes[span + 1]))
}

/// Compression there, N; for a rod that does not exist, at the tip.
fn force(m: &Machine, rod: usize) -> f64 {
    match rod {
        0 => m.kinematics().rock_force,
        _ => {
            -m.profile().bit_stress[station(m.parameters(), rod).0] * m.parameters().drill.rod.area
        }
    }
}

/// A string solved by characteristics (`oracles/data/strings.py`), lengths in m, areas in m2.
#[derive(Deserialize)]
struct Solved {
    rods: usize,
    piston: [f64; 2],
    shank: [f64; 2],
    rod: [f64; 2],
    coupling: [f64; 2],
    bit: [f64; 2],
    felt: Vec<Spell>,
}

/// A time of constant compression, N, in the middle of a rod, or at the tip (rod 0): its middle, s after the impact,
/// and the distance in time to the steps before and after, s.
#[derive(Deserialize)]
struct Spell {
    rod: usize,
    time: f64,
    force: f64,
    apart: f64,
}

const CHARACTERISTICS: &str = include_str!("../../../oracles/data/strings.json");
const FINE: Front = Front { width: 0.028, spans: 1.4, damping: 2e-8 };
const STEPS: &str = "steps that have passed contact and rock, (1 + x + x^2/2) exp(-x) of all that the piston can press, x the distance of the nearest over the front; more by damping's spread s, exp(s^2/2); and the mesh's ripple, 1/(1 + (k w)^2) at k = pi/h, damped";

/// See [`STEPS`].
fn steps_left(p: &Parameters, spell: &Spell) -> f64 {
    let spread = FINE.spread(p, spell.time);
    let x = spell.apart * p.wave_speed() / FINE.width;
    let left = (1.0 + x + 0.5 * x * x) * (-x + 0.5 * spread * spread).exp();
    let most = p.impedance_of(p.piston.segments[0].area) * SPEED;
    most * (left + FINE.ripple(p, spell.time))
}

/// Compression in the rods and at the tip of drawn strings on rigid rock.
///
/// # Errors
/// Those of the engine.
///
/// # Panics
/// The stored numbers cannot be read.
pub fn characteristics() -> Result<Vec<Row>, Error> {
    let strings: Vec<Solved> = serde_json::from_str(CHARACTERISTICS).expect("committed numbers");
    let mut list = Vec::new();
    for solved in strings {
        let part = |[length, area]: [f64; 2]| Segment { length, area };
        let [shank, rod, coupling] = [solved.shank, solved.rod, solved.coupling].map(part);
        let drill =
            Drill { rods: solved.rods, shank, rod, coupling, ..Parameters::default().drill };
        let mut p = scene(part(solved.piston), drill, part(solved.bit), FINE);
        // As stiff as the mesh can resolve: its front is as wide as the contact's.
        p.rock.stiffness = p.material.youngs_modulus * solved.bit[1] / FINE.width;
        p.rock.unloading_ratio = 1.0 + 1e-6;
        let mut m = Machine::new(&p, &mesh::no_inputs(), 0.0)?;
        let case = format!("drawn string of {} rods", solved.rods);
        let mut rows = Rows::new(case, "elwaspatid 2.0.1, characteristics", STEPS);
        for spell in &solved.felt {
            m.advance(mesh::strike() + spell.time)?;
            let place = match spell.rod {
                0 => "at the tip".into(),
                rod => format!("in rod {rod}"),
            };
            let name = format!("compression {place} at {:.0} us, N", 1e6 * spell.time);
            rows.add(name, spell.force, force(&m, spell.rod), steps_left(&p, spell));
        }
        list.append(&mut rows.list);
    }
    Ok(list)
}
