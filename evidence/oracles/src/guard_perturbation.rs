//! What rounding makes of a guard: the value that is compared with a level is a sum of terms, and
//! is off by a few units in the last place of these, whatever it comes to itself. A guard can
//! therefore neither be located nor told from a near miss to better than that.
//!
//! The terms are those of any arithmetic that moves a body by its static shape and oscillations
//! about it: the places themselves, and how far and how fast the state swings. Bodies that stand
//! still in equilibrium have none of the latter, and a level at which they rest is met exactly.
//!
//! What nothing but the drill string's dashpot `Zs` holds comes to its steady speed `F / Zs` as
//! `exp(-Zs t / M)`: its place is where it would come to, less `(F / Zs - v) M / Zs` that is still to
//! come, metres on a weak string. Each of these is rounded, and their difference is the place.

use crate::law::{MAX_JOINTS, Memory, Mode, Quantity, Rock, Side, State};
use crate::linear::Real;
use crate::model::Model;
use crate::perturb::{self, RELATIVE};

/// Roundings of a guard that its resolution must exceed to mean anything: each of a sum of twenty
/// or so, sixteen times.
const UNRESOLVED: f64 = 16.0 * 20.0 * f64::EPSILON;

/// How a run's guards are perturbed_guards.
#[derive(Clone, Copy, Debug)]
pub struct GuardPerturbation {
    /// Which way each is off, anew in every mode.
    pub seed: u64,
    /// What they resolve, over what they ought to.
    pub coarser: f64,
    /// True if one that has risen when an input changes decides under the loads that raised it; else it
    /// begins anew. Either is right.
    pub settles: bool,
}

/// What a quantity is off by, and the least height of its guards.
#[derive(Clone, Copy, Debug, Default)]
pub struct PerturbedGuards {
    shifts: [f64; COUNT],
    heights: [f64; COUNT],
}

/// Gap, tip, speed of the tip, relative position, joints.
const COUNT: usize = 4 + MAX_JOINTS;

fn place(quantity: Quantity) -> Option<usize> {
    match quantity {
        Quantity::Gap => Some(0),
        Quantity::Tip => Some(1),
        Quantity::TipSpeed => Some(2),
        Quantity::Relative => Some(3),
        Quantity::Joint(i) => Some(4 + i),
        Quantity::Work => None,
    }
}

impl PerturbedGuards {
    /// What is added to a quantity, and the height of a guard on it that resolves `height`.
    pub fn of(
        &self,
        quantity: Quantity,
        height: f64,
        guard_perturbation: GuardPerturbation,
    ) -> (f64, f64) {
        place(quantity).map_or((0.0, height), |k| {
            (self.shifts[k], guard_perturbation.coarser * height.max(self.heights[k]))
        })
    }
}

impl GuardPerturbation {
    /// In a state that moves under a load, after so many events.
    pub fn at<T: Real>(
        self,
        model: &Model<T>,
        (mode, memory): (Mode, &Memory<T>),
        load: &[T],
        state: &State<T>,
        count: usize,
    ) -> PerturbedGuards {
        let sizes = sizes(model, (mode, memory), load, state);
        let mut signs = (self.seed + count as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        signs ^= signs >> 29;
        let shift = |k: usize| if (signs >> k) & 1 == 1 { sizes[k] } else { -sizes[k] };
        PerturbedGuards {
            shifts: std::array::from_fn(|k| RELATIVE * shift(k)),
            heights: sizes.map(|size| UNRESOLVED * size),
        }
    }
}

/// Makes the places of bodies that only the string brakes off by their rounding, by `seed` in another way.
pub fn round_braked<T: Real>(
    model: &Model<T>,
    mode: Mode,
    load: &[T],
    state: &mut State<T>,
    seed: u64,
) {
    let offs = swings(model, mode, load, state);
    let parts = perturb::parts(seed);
    for ((body, [_, _, braked]), part) in model.starts.windows(2).zip(offs).zip(parts) {
        let off = T::from(RELATIVE * part * braked);
        state.u[body[0]..body[1]].iter_mut().for_each(|u| *u = *u + off);
    }
}

/// Sizes of the terms of each quantity.
fn sizes<T: Real>(
    model: &Model<T>,
    (mode, memory): (Mode, &Memory<T>),
    load: &[T],
    state: &State<T>,
) -> [f64; COUNT] {
    let (n, bit) = (model.nodes(), model.bit);
    let (bodies, rods) = (model.starts.len() - 1, model.scene.bodies.len());
    let size = |x: T| x.to_f64().abs();
    let swings = swings(model, mode, load, state);
    let group = |body: usize| {
        let [far, speed, braked] = swings[body];
        [far + braked, speed]
    };
    let [above, struck, lowest, last] = [0, 1, rods - 1, bodies - 1].map(group);
    let ends = |i: usize| size(state.u[i]);
    let gap = ends(bit - 1) + ends(bit) + model.scene.gap + above[0] + struck[0];
    let foot = size(model.foot(mode, memory));
    let tip = ends(model.tip) + foot + lowest[0];
    let means: f64 = (0..n).map(|i| size(model.relative[i]) * size(state.u[i])).sum();
    let [_, stroke] = model.scene.drive.relay();
    let beside = if bodies > rods { last } else { struck };
    let relative = means + model.scene.gap + stroke + above[0] + beside[0];
    let mut sizes = [0.0; COUNT];
    sizes[..4].copy_from_slice(&[gap, tip, lowest[1], relative]);
    for (i, joint) in model.joints.iter().enumerate() {
        let faces: f64 = joint.nodes.map(ends).iter().sum();
        let [one, other] = joint.nodes.map(|node| group(body_of(model, node)));
        sizes[4 + i] = faces + joint.travel.to_f64() + one[0] + other[0];
    }
    sizes
}

fn body_of<T: Real>(model: &Model<T>, node: usize) -> usize {
    model.starts.partition_point(|&start| start <= node) - 1
}

/// Of each body, how far (m) and how fast (m/s) those that hold together with it swing by the imbalance of
/// their forces and their motion, and how far they are from where the string alone brakes them, m.
fn swings<T: Real>(model: &Model<T>, mode: Mode, load: &[T], state: &State<T>) -> Vec<[f64; 3]> {
    let (n, starts) = (model.nodes(), &model.starts);
    let (bodies, rods) = (starts.len() - 1, model.scene.bodies.len());
    let mut left = vec![T::default(); n];
    model.imbalance(mode, load, &state.u, &state.v, &mut left);
    let rock = match mode.rock {
        Rock::FF => 0.0,
        Rock::DFC | Rock::FC => 1.0 / model.scene.rock.stiffness,
        Rock::BC | Rock::SS => 1.0 / (model.scene.rock.ratio * model.scene.rock.stiffness),
    };
    let size = |x: T| x.to_f64().abs();
    // What holds bodies together, and yields.
    let contact = mode.closed.then_some(([0, 1], 1.0 / model.contact_stiffness.to_f64()));
    let joints = model.joints.iter().zip(mode.joints).filter(|(_, side)| *side != Side::Open);
    let joints = joints.map(|(joint, _)| {
        (joint.nodes.map(|node| body_of(model, node)), 1.0 / joint.stiffness.to_f64())
    });
    let held: Vec<_> = contact.into_iter().chain(joints).collect();
    let string = model.scene.casing.as_ref().map_or(0.0, |casing| casing.impedance);
    let group = |body: usize| -> [f64; 3] {
        let mut joined = vec![false; bodies];
        joined[body] = true;
        for _ in 0..bodies {
            for ([one, other], _) in &held {
                let both = joined[*one] || joined[*other];
                (joined[*one], joined[*other]) = (both, both);
            }
        }
        let nodes = (0..bodies).filter(|&i| joined[i]).flat_map(|i| starts[i]..starts[i + 1]);
        let bars = nodes.clone().filter(|&i| i + 1 < n).map(|i| size(model.bars.off[i]));
        let bars: f64 = bars.filter(|k| *k > 0.0).map(|k| 1.0 / k).sum();
        let springs = held.iter().filter(|([one, _], _)| joined[*one]).map(|(_, yields)| yields);
        let rock = if joined[rods - 1] { rock } else { 0.0 };
        let yields = bars + springs.sum::<f64>() + rock;
        let mass: f64 = nodes.clone().map(|i| size(model.mass.diagonal[i])).sum();
        let force: f64 = nodes.clone().map(|i| size(left[i])).sum();
        let speed = nodes.clone().map(|i| size(state.v[i])).fold(0.0, f64::max);
        // The dashpot's force lacks as much to that of the steady speed as all forces together.
        let braked = if string > 0.0 && rock == 0.0 && bodies > rods && joined[bodies - 1] {
            size(nodes.map(|i| left[i]).fold(T::default(), |sum, f| sum + f)) * mass
                / string.powi(2)
        } else {
            0.0
        };
        let time = (mass * yields).sqrt();
        if time == 0.0 {
            return [0.0, speed, braked];
        }
        [force * yields + speed * time, speed + force * yields / time, braked]
    };
    (0..bodies).map(group).collect()
}
