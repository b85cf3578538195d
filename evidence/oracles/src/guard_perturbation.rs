//! What rounding makes of a guard: the value that is compared with a level is a sum of terms, and
//! is off by a few units in the last place of these, whatever it comes to itself. A guard can
//! therefore neither be located nor told from a near miss to better than that.
//!
//! The terms are those of any arithmetic that moves a body by its static shape and oscillations
//! about it: the places themselves, and how far and how fast the state swings. Bodies that stand
//! still in equilibrium have none of the latter, and a level at which they rest is met exactly.

use crate::law::{Chuck, Memory, Mode, Quantity, Rock, State};
use crate::linear::Real;
use crate::model::Model;
use crate::perturb::RELATIVE;

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

/// Gap, tip, speed of the tip, relative position, bit in casing.
const COUNT: usize = 5;

fn place(quantity: Quantity) -> Option<usize> {
    match quantity {
        Quantity::Gap => Some(0),
        Quantity::Tip => Some(1),
        Quantity::TipSpeed => Some(2),
        Quantity::Relative => Some(3),
        Quantity::Chuck => Some(4),
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

/// Sizes of the terms of each quantity.
fn sizes<T: Real>(
    model: &Model<T>,
    (mode, memory): (Mode, &Memory<T>),
    load: &[T],
    state: &State<T>,
) -> [f64; COUNT] {
    let (n, bit, casing) = (model.nodes(), model.bit, model.tip + 1);
    let mut left = vec![T::default(); n];
    model.imbalance(mode, load, &state.u, &state.v, &mut left);
    let rock = match mode.rock {
        Rock::FF => 0.0,
        Rock::DFC | Rock::FC => 1.0 / model.scene.rock.stiffness,
        Rock::BC | Rock::SS => 1.0 / (model.scene.rock.ratio * model.scene.rock.stiffness),
    };
    let size = |x: T| x.to_f64().abs();
    // Displacements and speeds that the imbalance of a body, or of those that are tied, and its motion swing by.
    let swing = |nodes: std::ops::Range<usize>, springs: f64| -> [f64; 2] {
        let bars: f64 = nodes
            .clone()
            .take(nodes.len().saturating_sub(1))
            .map(|i| size(model.bars.off[i]))
            .filter(|k| *k > 0.0)
            .map(|k| 1.0 / k)
            .sum();
        let yields = bars + springs;
        let mass: f64 = nodes.clone().map(|i| size(model.mass.diagonal[i])).sum();
        let force: f64 = nodes.clone().map(|i| size(left[i])).sum();
        let speed = nodes.map(|i| size(state.v[i])).fold(0.0, f64::max);
        let time = (mass * yields).sqrt();
        if time == 0.0 {
            return [0.0, speed];
        }
        [force * yields + speed * time, speed + force * yields / time]
    };
    let chuck = model.scene.casing.as_ref().filter(|_| mode.chuck != Chuck::Open);
    let end = if chuck.is_some() { n } else { casing };
    let springs = rock + chuck.map_or(0.0, |chuck| 1.0 / chuck.stiffness);
    let (above, below) = if mode.closed {
        let both = swing(0..end, springs + 1.0 / model.contact_stiffness.to_f64());
        (both, both)
    } else {
        (swing(0..bit, 0.0), swing(bit..end, springs))
    };
    let around = if chuck.is_some() { below } else { swing(casing..n, 0.0) };
    let ends = |i: usize| size(state.u[i]);
    let gap = ends(bit - 1) + ends(bit) + model.scene.gap + above[0] + below[0];
    let foot = size(model.foot(mode, memory));
    let tip = ends(model.tip) + foot + below[0];
    let means: f64 = (0..n).map(|i| size(model.relative[i]) * size(state.u[i])).sum();
    let [_, stroke] = model.scene.drive.relay();
    let beside = if casing < n { around } else { below };
    let relative = means + model.scene.gap + stroke + above[0] + beside[0];
    let hangs = model
        .scene
        .casing
        .as_ref()
        .map_or(0.0, |chuck| ends(bit) + ends(n - 1) + chuck.travel + below[0] + around[0]);
    [gap, tip, below[1], relative, hangs]
}
