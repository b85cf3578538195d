//! Splines of the engine against spectral elements of the oracles: a stepped hammer's first
//! blow, on meshes of either family, with the contact's front and the damping's resolved.
//!
//! Frequencies and end amplitudes of splines of degree `d` err like `h^(2 d)`, so does what is
//! seen of the motion while the events are the same. Spectral elements of degree 12, integrated
//! in double-double arithmetic, stand for the continuum; how far those of two fewer degrees are
//! from them bounds their own error.

use crate::row::{Row, Rows};
use crate::{mesh, scene};
use hammer::{Error, Machine, Parameters, Segment};
use oracles::dd::Dd;
use oracles::law::Quantity;
use oracles::linear::Real;
use oracles::run::Run;
use oracles::scene::Fidelity;
use oracles::taylor::Accuracy;

/// Order and last term of the reference's series.
const ACCURACY: Accuracy = Accuracy { order: 24, tolerance: 1e-18 };
/// Degrees of the spectral elements, one element a section.
const SPECTRAL: [usize; 2] = [12, 10];
/// Instants after the strike, over the time that waves take through both bodies.
const INSTANTS: [f64; 6] = [0.3, 0.6, 0.9, 1.3, 1.7, 2.1];
/// Spans a body of each degree studied.
pub const MESHES: [(usize, [usize; 3]); 4] =
    [(1, [20, 40, 80]), (2, [12, 24, 48]), (3, [10, 20, 40]), (5, [5, 7, 14])];

/// Three sections of piston on two of bit, which meet through a contact as soft as the front
/// of a few of its spans; nothing but the strike moves them.
fn hammer_of(degree: usize, spans: usize) -> Parameters {
    let mut p = mesh::bare(spans);
    let piston = [(0.06, 2.0e-3), (0.10, 3.2e-3), (0.05, 1.6e-3)];
    let bit = [(0.10, 1.9e-3), (0.06, 4.2e-3)];
    for (segment, (length, area)) in p.piston.segment.iter_mut().zip(piston) {
        *segment = Segment { length, area };
    }
    for (segment, (length, area)) in p.bit.segment.iter_mut().zip(bit) {
        *segment = Segment { length, area };
    }
    (p.piston.segments, p.bit.segments, p.mesh.degree) = (piston.len(), bit.len(), degree);
    p.material.damping_time = 2e-6;
    p.contact.stiffness = 4e9;
    p.rock.stiffness = 1.2e8;
    p
}

/// What is observed: displacements over 1 mm, velocities over 1 m/s.
type Observed = [f64; 7];

fn instants(p: &Parameters) -> Vec<f64> {
    let scales = p.timescales();
    let both = scales.piston_transit + scales.bit_transit;
    INSTANTS.iter().map(|part| mesh::strike() + part * both).collect()
}

fn of_engine(degree: usize, spans: usize) -> Result<Vec<Observed>, Error> {
    let p = hammer_of(degree, spans);
    let mut m = Machine::new(&p, &mesh::no_inputs(), 0.0)?;
    let observe = |time: f64| {
        m.advance(time)?;
        let k = m.kinematics();
        let places = [k.piston_position, k.bit_position, k.bit_tip_position, k.contact_gap];
        let speeds = [k.piston_velocity, k.bit_velocity, k.bit_tip_velocity];
        let places = places.map(|x| 1e3 * x);
        Ok([places.as_slice(), speeds.as_slice()].concat().try_into().expect("seven"))
    };
    instants(&p).into_iter().map(observe).collect()
}

/// The same of the oracle, on spectral elements of a degree.
fn of_oracle(degree: usize) -> Vec<Observed> {
    let p = hammer_of(1, 1);
    let mut scene = scene::finite_elements(&p, &mesh::no_inputs());
    scene.fidelity = Fidelity::Spectral(degree);
    let mut run = Run::<Dd>::new(&scene, ACCURACY);
    run.through(&instants(&p), &[]).expect("a short run");
    let (model, bit) = (&run.model, run.model.bit);
    let mean = |x: &[Dd], nodes: std::ops::Range<usize>| {
        let sum = nodes.fold(Dd::default(), |sum, i| sum + model.relative[i] * x[i]);
        sum.to_f64()
    };
    let see = |sample: &oracles::record::Sampled<Dd>| {
        let (u, v, n) = (&sample.state.u, &sample.state.v, model.nodes());
        let gap = model.quantity(Quantity::Gap, &sample.state).to_f64();
        // Weights of the bit's mean have the other sign.
        let places = [mean(u, 0..bit), -mean(u, bit..n), u[n - 1].to_f64(), gap];
        let speeds = [mean(v, 0..bit), -mean(v, bit..n), v[n - 1].to_f64()];
        let places = places.map(|x| 1e3 * x);
        [places.as_slice(), speeds.as_slice()].concat().try_into().expect("seven")
    };
    run.samples.iter().map(see).collect()
}

fn largest_difference(a: &[Observed], b: &[Observed]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

/// A degree's meshes, and how far each is from the spectral elements.
#[derive(Clone, Debug)]
pub struct Level {
    /// Degree of the splines.
    pub degree: usize,
    /// Spans a body.
    pub spans: [usize; 3],
    /// Largest difference over 1 mm and 1 m/s.
    pub errors: [f64; 3],
}

impl Level {
    /// Order between the two finest meshes.
    pub fn order(&self) -> f64 {
        (self.errors[1] / self.errors[2]).ln() / (self.spans[2] as f64 / self.spans[1] as f64).ln()
    }
}

/// All degrees, and how far spectral elements of two degrees are apart.
pub fn levels() -> Result<(Vec<Level>, f64), Error> {
    let [exact, lower] = SPECTRAL.map(of_oracle);
    let mut levels = Vec::new();
    for (degree, spans) in MESHES {
        let mut errors = [0.0; 3];
        for (error, spans) in errors.iter_mut().zip(spans) {
            *error = largest_difference(&of_engine(degree, spans)?, &exact);
        }
        levels.push(Level { degree, spans, errors });
    }
    Ok((levels, largest_difference(&exact, &lower)))
}

/// Orders beside theory, and the finest mesh of each degree beside the spectral elements.
pub fn rows() -> Result<Vec<Row>, Error> {
    let (levels, oracle_error) = levels()?;
    let why = "half the way to the next power, in h^2";
    let bound = "the error of the mesh before, falling by one order less than theory's; and how far spectral elements of degrees 12 and 10 are apart";
    let mut list = Vec::new();
    for level in &levels {
        let (theory, [_, spans, finest]) = (2.0 * level.degree as f64, level.spans);
        let case = format!("stepped hammer, degree {}, {spans} to {finest} spans", level.degree);
        let mut orders = Rows::new(case, "theory", why);
        orders.add("order observed", theory, level.order().min(theory), 1.0);
        let case = format!("stepped hammer, degree {}, {finest} spans", level.degree);
        let mut off = Rows::new(case, "spectral elements, double-double", bound);
        let fall = (spans as f64 / finest as f64).powf(theory - 1.0);
        let allowed = level.errors[1] * fall + oracle_error;
        off.add("largest difference over 1 mm and 1 m/s", 0.0, level.errors[2], allowed);
        list.extend(orders.list.into_iter().chain(off.list));
    }
    Ok(list)
}
