//! The polynomial solutions of a system under polynomial loads.
//!
//! `y' = B y + b f(t)` has `sum_j S_j f^(j)(t)` with `S_j = -B^-(j+1) b`; what is left of a state
//! moves by `exp(B t)`. The engine divides it otherwise where a load varies quickly beside a slow
//! coordinate: there this division loses digits, and a tangent says so.

use crate::modal::model::{Channel, Model, Span};
use crate::modal::system::{CHANNELS, System};
use crate::numerics::kernel;
use crate::numerics::matrix2::Matrix2;
use crate::numerics::poly::Poly;

/// Orders of load derivatives, from the value on.
pub(crate) const ORDERS: usize = crate::MAX_INPUT_ORDER + 1;

/// `S_j` of each channel, and how each moves the translation.
#[derive(Debug)]
pub(crate) struct Statics {
    pub shapes: [Vec<Vec<f64>>; CHANNELS],
    pub gains: [f64; CHANNELS],
}

/// Modal loads of unit channel values on a span's bodies.
pub(crate) fn unit_loads(model: &Model, span: Span) -> [Vec<f64>; CHANNELS] {
    let (p, b) = (&model.piston, &model.bit);
    let range = model.range(span);
    let place = |piston: &[f64], bit: &[f64]| [piston, bit].concat()[range.clone()].to_vec();
    let none = |n: usize| vec![0.0; n];
    let first = |n: usize, value: f64| {
        let mut v = none(n);
        v[0] = value;
        v
    };
    let (mp, mb) = (p.mass.sqrt(), b.mass.sqrt());
    let mut loads: [Vec<f64>; CHANNELS] = Default::default();
    loads[Channel::Drive as usize] = place(&first(p.len(), 1.0 / mp), &none(b.len()));
    loads[Channel::Feed as usize] = place(&none(p.len()), &b.top);
    loads[Channel::Gravity as usize] = place(&first(p.len(), mp), &first(b.len(), mb));
    loads
}

impl Statics {
    pub(crate) fn new(model: &Model, span: Span, system: &System) -> Self {
        let (n, generators) = (system.blocks(), generators(system));
        let mut gains = [0.0; CHANNELS];
        let shapes = std::array::from_fn(|channel| {
            let load = &unit_loads(model, span)[channel];
            let body_state = [vec![0.0; load.len()], load.clone()].concat();
            let mut b = vec![0.0; 2 * n];
            system.to_modal(&body_state, &mut b);
            if system.rigid {
                gains[channel] = b[n];
            }
            let order = |_| {
                b = solve(system, &generators, &b);
                b.iter().map(|x| -x).collect()
            };
            (0..ORDERS).map(order).collect()
        });
        Self { shapes, gains }
    }

    /// `y += sign sum_j S_j f^(j)(t)`.
    pub(crate) fn add(&self, loads: &[Poly; CHANNELS], t: f64, sign: f64, y: &mut [f64]) {
        for (shapes, load) in self.shapes.iter().zip(loads) {
            let mut derivative = *load;
            for shape in shapes {
                let factor = sign * derivative.at(t);
                if factor != 0.0 {
                    kernel::add(y, factor, shape);
                }
                if derivative.is_constant() {
                    break;
                }
                derivative = derivative.derivative();
            }
        }
    }
}

/// The blocks of a system; of a translation, `s^2`.
pub(crate) fn generators(system: &System) -> Vec<Matrix2> {
    (0..system.modes())
        .map(|i| {
            let translation = system.rigid && i == 0;
            if translation { [0.0, 1.0, 0.0, 0.0] } else { system.block(i) }
        })
        .collect()
}

/// `B^-1 y`, zero for the translation.
pub(crate) fn solve(system: &System, generators: &[Matrix2], y: &[f64]) -> Vec<f64> {
    let n = system.blocks();
    let mut x = vec![0.0; 2 * n];
    for (i, b) in generators.iter().enumerate().skip(usize::from(system.rigid)) {
        let det = b[0] * b[3] - b[1] * b[2];
        x[i] = (b[3] * y[i] - b[1] * y[n + i]) / det;
        x[n + i] = (b[0] * y[n + i] - b[2] * y[i]) / det;
    }
    x
}
