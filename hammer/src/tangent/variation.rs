//! What a change of a parameter changes in the matrices of a span.

use crate::laws::event::Displacement;
use crate::laws::rock::Spring;
use crate::modal::model::{Channel, Model, Span};
use crate::modal::system::CHANNELS;
use crate::numerics::kernel::inner_product;
use crate::quantities::sections::Body;
use crate::tangent::change::Change;
use crate::tangent::reshape::Reshape;
use crate::tangent::statics::unit_loads;
use std::ops::Range;
use std::sync::Arc;

/// A spring and dashpot on `shape . q`, and how they change.
pub(crate) struct Hold {
    pub shape: Vec<f64>,
    /// Functional of the system that measures it.
    pub functional: usize,
    pub coefficients: [f64; 2],
    pub changes: [f64; 2],
}

/// A body of sections that changes by one of them.
pub(crate) struct Reshaped {
    pub reshape: Arc<Reshape>,
    /// Its modes in the span.
    pub range: Range<usize>,
    pub omega2: Vec<f64>,
    pub beta: f64,
}

/// What of a span's bodies changes; empty lists are zeros.
pub(crate) struct Variation {
    pub stiffness: Vec<f64>,
    pub damping: Vec<f64>,
    pub amplitude: Vec<f64>,
    pub reshaped: Option<Reshaped>,
    pub holds: Vec<Hold>,
    /// Changes of the modal loads of unit channel values.
    pub loads: [Vec<f64>; CHANNELS],
}

impl Variation {
    /// True if the matrix changes by outer products alone.
    pub(crate) fn is_slim(&self) -> bool {
        let same = self.stiffness.is_empty() && self.damping.is_empty();
        same && self.amplitude.is_empty() && self.reshaped.is_none()
    }

    /// Change of the accelerations at the state `[q | q']`.
    pub(crate) fn accelerations(&self, body_state: &[f64], out: &mut [f64]) {
        let (q, v) = body_state.split_at(out.len());
        out.fill(0.0);
        for (o, (d, q)) in out.iter_mut().zip(self.stiffness.iter().zip(q)) {
            *o -= d * q;
        }
        for (o, (d, v)) in out.iter_mut().zip(self.damping.iter().zip(v)) {
            *o -= d * v;
        }
        if let Some(reshaped) = &self.reshaped {
            reshaped.accelerations(&self.holds, q, v, out);
        }
        for hold in &self.holds {
            let (r, s) = (inner_product(&hold.shape, q), inner_product(&hold.shape, v));
            let change = hold.changes[0] * r + hold.changes[1] * s;
            let force = hold.coefficients[0] * r + hold.coefficients[1] * s;
            for (i, o) in out.iter_mut().enumerate() {
                let grown = self.amplitude.get(i).map_or(0.0, |g| 2.0 * g);
                *o -= hold.shape[i] * (change + grown * force);
            }
        }
    }
}

impl Reshaped {
    fn accelerations(&self, holds: &[Hold], q: &[f64], v: &[f64], out: &mut [f64]) {
        let bent: Vec<f64> = self.range.clone().map(|i| q[i] + self.beta * v[i]).collect();
        let mut pushed: Vec<f64> = bent.iter().zip(&self.omega2).map(|(x, w2)| -w2 * x).collect();
        for hold in holds {
            let (r, s) = (inner_product(&hold.shape, q), inner_product(&hold.shape, v));
            let force = hold.coefficients[0] * r + hold.coefficients[1] * s;
            let own = &hold.shape[self.range.clone()];
            pushed.iter_mut().zip(own).for_each(|(p, x)| *p -= force * x);
        }
        self.reshape.accelerations(&pushed, &bent, &mut out[self.range.clone()]);
    }
}

/// The changed body in a span that has it.
fn reshaped(model: &Model, span: Span, reshape: &Arc<Reshape>) -> Option<Reshaped> {
    let pistons = model.piston.len();
    let (bar, first) = match (reshape.body, span) {
        (Body::Piston, Span::Piston | Span::Both(_)) => (&model.piston, 0),
        (Body::Bit, Span::Bit(_)) => (&model.bit, 0),
        (Body::Bit, Span::Both(_)) => (&model.bit, pistons),
        (Body::Piston, Span::Bit(_)) | (Body::Bit, Span::Piston) => return None,
    };
    Some(Reshaped {
        reshape: reshape.clone(),
        range: first..first + bar.len(),
        omega2: bar.omega2.clone(),
        beta: model.parameters.material.damping_time,
    })
}

/// How a change is felt by the bodies and springs of a span.
pub(crate) fn variation(model: &Model, span: Span, change: &Change) -> Variation {
    let range = model.range(span);
    let cut = |x: &[f64]| if x.is_empty() { Vec::new() } else { x[range.clone()].to_vec() };
    let (p, b) = (&model.piston, &model.bit);
    let reshaped = change.reshape.as_ref().and_then(|reshape| reshaped(model, span, reshape));
    let place = |piston: &[f64], bit: &[f64]| cut(&[piston, bit].concat());
    let none = |n: usize| vec![0.0; n];
    let mut holds = Vec::new();
    if let (Span::Bit(spring) | Span::Both(spring), Some(functional)) =
        (span, span.share(Displacement::Tip))
        && spring != Spring::Free
    {
        let line = spring.coefficients(&model.parameters.rock);
        holds.push(Hold {
            shape: place(&none(p.len()), &b.bottom),
            functional,
            coefficients: [line.stiffness, line.viscosity],
            changes: change.springs[spring as usize],
        });
    }
    if let (Span::Both(_), Some(functional)) = (span, span.share(Displacement::Gap)) {
        let lower: Vec<f64> = p.bottom.iter().map(|x| -x).collect();
        holds.push(Hold {
            shape: place(&lower, &b.top),
            functional,
            coefficients: [model.contact, 0.0],
            changes: [change.contact, 0.0],
        });
    }
    let mut loads = unit_loads(model, span);
    loads[Channel::Gravity as usize].fill(0.0);
    let amplitude = cut(&change.amplitude);
    for load in &mut loads {
        for (i, x) in load.iter_mut().enumerate() {
            *x *= amplitude.get(i).map_or(0.0, |g| 2.0 * g);
        }
    }
    if let Some(reshaped) = &reshaped {
        for (channel, load) in unit_loads(model, span).iter().enumerate() {
            if channel != Channel::Gravity as usize {
                let (pushed, out) = (&load[reshaped.range.clone()], &mut loads[channel]);
                let none = vec![0.0; pushed.len()];
                reshaped.reshape.accelerations(pushed, &none, &mut out[reshaped.range.clone()]);
            }
        }
    }
    Variation {
        stiffness: cut(&change.stiffness),
        damping: cut(&change.damping),
        amplitude,
        reshaped,
        holds,
        loads,
    }
}
