//! The effect of rounding on a guard. The value that is compared with a level is a sum of terms, and has an error of a few units in the last place of these terms, however small it is itself. A guard can be located, and distinguished from a near miss, only to that accuracy.
//!
//! The terms are those of any arithmetic that divides a motion into a static shape and oscillations about it: the
//! positions, and the amplitudes and speeds of the oscillations. Bodies at rest in equilibrium do not oscillate, and
//! a level at which they rest is met exactly.
//!
//! A body that only the drill string's dashpot `Zs` holds approaches its steady speed `F / Zs` as `exp(-Zs t / M)`.
//! Its position is the asymptote less `(F / Zs - v) M / Zs`, which is metres on a weak string. Both are rounded, and
//! the position is their difference.

use crate::law::{MAX_JOINTS, Memory, Mode, Quantity, Rock, Side, State};
use crate::linear::Real;
use crate::model::Model;
use crate::perturb::{self, RELATIVE};

/// A guard is meaningful only if its resolution exceeds this many roundings: those of a sum of some twenty terms,
/// times sixteen.
const UNRESOLVED: f64 = 16.0 * 20.0 * f64::EPSILON;

/// How the guards of a run are perturbed.
#[derive(Clone, Copy, Debug)]
pub struct GuardPerturbation {
    /// Seed of the signs, which are drawn again in every mode.
    pub seed: u64,
    /// Factor of the resolutions.
    pub coarser: f64,
    /// True if a guard that has risen when an input changes is decided under the loads that raised it; false if it
    /// begins again. Both are right.
    pub settles: bool,
}

/// The perturbation of each quantity, and the least height of its guards.
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
    /// The perturbation of a quantity, and the height of a guard on it whose resolution is `height`.
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
    /// The perturbation in a state that moves under a load, after so many events.
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

/// Perturbs the positions of bodies that only the string brakes, by their rounding.
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

/// For each body: the displacement (m) and speed (m/s) by which its group swings, from the imbalance of its forces
/// and from its motion; and its distance from where the string alone would stop it, m.
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
    // Elastic connections between the bodies.
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
        // The dashpot's force differs from that at the steady speed by the sum of all forces.
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
