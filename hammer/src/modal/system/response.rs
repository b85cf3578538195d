//! The response of a decomposed system to loads.
//!
//! A coordinate obeys `y' = B y + b f(t)` with a polynomial load `f`. The particular solution
//!
//! ```text
//! sum_j S_j f^(j)(t),     S_j = -B^-(j+1) b,
//! ```
//!
//! is exact. But if the load varies quickly compared with the coordinate, `|f'| > |B f|`, the terms of this solution
//! grow without bound and cancel in the motion. Digits are then lost; for creeping rock under an oscillating load, all
//! of them. Such a coordinate is *slow*. Like the translation, for which `B` is singular, it is represented by the
//! power series of its whole motion from the epoch,
//!
//! ```text
//! y(t) = sum_k y_k t^k,     (k + 1) y_(k+1) = B y_k + b f_k,
//! ```
//!
//! up to `|B| t = `[`SPAN`]. There the first omitted term after [`TERMS`] terms is still below rounding (`2^24 / 24!`
//! is 3e-17). Then the epoch is moved and the series renewed.

use crate::modal::system::driven::Driven;
use crate::modal::system::generator::Generator;
use crate::numerics::form::Form;
use crate::numerics::kernel;
use crate::numerics::math;
use crate::numerics::poly::{self, Poly, TERMS};
use crate::numerics::series::LOW;
use crate::scene::graph::CHANNELS;

/// Number of orders of a load's derivatives, of which the first is its value. A load is an input, or the air's force in
/// a window.
pub const ORDERS: usize = LOW;
const _: () = assert!(ORDERS > crate::MAX_INPUT_ORDER);
/// A coordinate is slow if `|B| tau` is below this, where `tau` is the time in which a load changes by its own size.
/// Its series is used up to the same `|B| t`. In the particular solution of a faster coordinate, each term is smaller
/// than the previous one by at least this factor.
const SPAN: f64 = 2.0;

/// The response of a decomposed system to loads.
#[derive(Debug)]
pub(crate) struct Response {
    /// `b` of each channel.
    drives: [Vec<f64>; CHANNELS],
    /// Norm of each channel's modal load.
    sizes: [f64; CHANNELS],
    /// `S_j` of each channel, one order after the other.
    statics: [Vec<f64>; CHANNELS],
    /// For each channel the acceleration of the translation, or its velocity if a dashpot brakes it.
    gains: [f64; CHANNELS],
    /// True if a dashpot brakes the translation.
    braked: bool,
}

/// For a channel's `b` and a damping form `Q`: the row `2 Q b`, its products with the shapes `S_j` of the load's
/// derivatives, and its repeated integrals.
#[derive(Debug)]
pub(crate) struct DampedDrive {
    pub(crate) row: Vec<f64>,
    pub(crate) statics: [[f64; ORDERS]; CHANNELS],
    pub(crate) integrals: Vec<Vec<f64>>,
}

impl Response {
    /// The response with `b` (`drives`) and the norm (`sizes`) of each channel's modal load.
    pub(crate) fn new(
        generator: &Generator,
        drives: [Vec<f64>; CHANNELS],
        sizes: [f64; CHANNELS],
    ) -> Self {
        let statics = std::array::from_fn(|channel| {
            let mut b: Vec<f64> = drives[channel].clone();
            let mut orders = Vec::with_capacity(ORDERS * b.len());
            for _ in 0..ORDERS {
                b = generator.solve(&b);
                orders.extend(b.iter().map(|x| -x));
            }
            orders
        });
        let gains = std::array::from_fn(|channel| match generator.polynomial() {
            0 => 0.0,
            1 => drives[channel][0],
            _ => drives[channel][generator.n],
        });
        Self { drives, sizes, statics, gains, braked: generator.braked }
    }

    /// The contribution of each channel's load to a damping form; `None` for a load that does not act on the system.
    pub(crate) fn damped_drives(
        &self,
        form: &Form,
        generator: &Generator,
    ) -> [Option<DampedDrive>; CHANNELS] {
        let damped_drive = |drive: &[f64]| {
            let row = form.gradient(drive);
            let mut integral = row.clone();
            let integrals = (0..ORDERS).map(|_| {
                integral = generator.integrate(&integral);
                integral.clone()
            });
            let integrals = integrals.collect();
            DampedDrive { statics: self.statics_of(&row), row, integrals }
        };
        std::array::from_fn(|k| (self.sizes[k] != 0.0).then(|| damped_drive(&self.drives[k])))
    }

    /// `b` of coordinate `k`, for each channel.
    pub(crate) fn drive(&self, k: usize) -> [f64; CHANNELS] {
        self.drives.each_ref().map(|b| b[k])
    }

    /// True if any of the loads that act on the system varies.
    pub(crate) fn varies(&self, loads: &[Poly; CHANNELS]) -> bool {
        self.sizes.iter().zip(loads).any(|(size, load)| *size > 0.0 && !load.is_constant())
    }

    /// True if the two sets of loads differ in one that acts on the system.
    pub(crate) fn differ(&self, one: &[Poly; CHANNELS], other: &[Poly; CHANNELS]) -> bool {
        self.sizes.iter().zip(one.iter().zip(other)).any(|(size, (a, b))| *size > 0.0 && a != b)
    }

    /// `c S_j` for each channel and each order `j`.
    pub(crate) fn statics_of(&self, c: &[f64]) -> [[f64; ORDERS]; CHANNELS] {
        std::array::from_fn(|channel| {
            std::array::from_fn(|j| {
                kernel::dot(c, &self.statics[channel][j * c.len()..][..c.len()])
            })
        })
    }

    /// Adds the polynomial `c . (y - z)`, without the translation. `statics` is [`Self::statics_of`] of `c`.
    pub(crate) fn add_poly(
        &self,
        c: &[f64],
        statics: &[[f64; ORDERS]; CHANNELS],
        loads: &[Poly; CHANNELS],
        driven: &Driven,
        sum: &mut Poly,
    ) {
        for (k, poly) in &driven.slow {
            sum.add(c[*k], poly);
        }
        let fast = (!driven.slow.is_empty()).then(|| driven.without_slow(c));
        let of_channels = self.sizes.iter().zip(loads).zip(statics.iter().zip(&self.statics));
        for ((_, load), (statics, shapes)) in of_channels.filter(|((size, _), _)| **size != 0.0) {
            let orders = orders(load);
            let mut apart = [0.0; ORDERS];
            let statics = match &fast {
                Some(c) if orders > 0 => {
                    kernel::products(c, shapes, &mut apart[..orders]);
                    &apart
                }
                _ => statics,
            };
            match orders {
                0 => {}
                1 => sum.0[0] += statics[0] * load.0[0],
                _ => poly::add_derivatives(sum, &statics[..orders], load),
            }
        }
    }

    /// Adds to `z` the part due to loads and translation at `t`.
    pub(crate) fn add(&self, loads: &[Poly; CHANNELS], driven: &Driven, t: f64, z: &mut [f64]) {
        self.add_statics(loads, t, 1.0, z);
        for (k, poly) in &driven.slow {
            z[*k] = poly.at(t);
        }
    }

    /// Removes the polynomial part from a state at the epoch. The rest moves by `exp(B t)`.
    pub(crate) fn take(
        &self,
        generator: &Generator,
        loads: &[Poly; CHANNELS],
        y: &mut [f64],
    ) -> Driven {
        let mut driven = self.take_translation(generator, loads, y);
        if let Some(limit) = self.slow_below(loads) {
            let (slow, fastest) = self.slow(generator, loads, limit, y);
            driven.reach = (fastest > 0.0).then_some(SPAN / fastest);
            driven.slow = slow;
        }
        self.add_statics(loads, 0.0, -1.0, y);
        for (k, _) in &driven.slow {
            y[*k] = 0.0;
        }
        driven
    }

    /// Removes the translation from a state at the epoch.
    pub(crate) fn take_translation(
        &self,
        generator: &Generator,
        loads: &[Poly; CHANNELS],
        y: &mut [f64],
    ) -> Driven {
        if !generator.rigid {
            return Driven::default();
        }
        let n = generator.n;
        let position = std::mem::take(&mut y[0]);
        let start = [position, if generator.braked { 0.0 } else { std::mem::take(&mut y[n]) }];
        Driven::translating(self.translation(start, loads))
    }

    /// For each channel, the coordinates at rest under a constant unit load.
    pub(crate) fn shapes(&self) -> [&[f64]; CHANNELS] {
        self.statics.each_ref().map(|orders| &orders[..orders.len() / ORDERS])
    }

    /// The uniform translation from its position and velocity at the start, under these loads.
    pub(crate) fn translation(&self, start: [f64; 2], loads: &[Poly; CHANNELS]) -> Poly {
        let mut p = Poly::default();
        (p.0[0], p.0[1]) = (start[0], if self.braked { 0.0 } else { start[1] });
        for (gain, load) in self.gains.iter().zip(loads).filter(|(gain, _)| **gain != 0.0) {
            let terms = load.0[..ORDERS].iter().enumerate();
            for (k, c) in terms.filter(|(_, c)| **c != 0.0) {
                let (power, factor) =
                    if self.braked { (k + 1, k + 1) } else { (k + 2, (k + 1) * (k + 2)) };
                p.0[power] += gain * c / factor as f64;
            }
        }
        p
    }

    /// The rate below which a coordinate is slow; `None` if no load varies.
    fn slow_below(&self, loads: &[Poly; CHANNELS]) -> Option<f64> {
        if loads.iter().all(Poly::is_constant) {
            return None;
        }
        let present: f64 =
            loads.iter().zip(&self.sizes).map(|(load, size)| size * load.0[0].abs()).sum();
        let (over, mut rate) = (1.0 / present, 0.0f64);
        for (load, size) in loads.iter().zip(&self.sizes).filter(|(_, size)| **size != 0.0) {
            let (mut factorial, mut power) = (1.0, 1.0);
            for (order, c) in load.0[..orders(load).max(1)].iter().enumerate().skip(1) {
                factorial *= order as f64;
                let part = size * (factorial * c).abs() * over;
                power *= rate;
                if part > power {
                    power = part;
                    let root = if order == 1 { part } else { math::rough_root(part, order as u64) };
                    rate = rate.max(root);
                }
            }
        }
        // If the loads are zero at present, the rate is infinite and every coordinate is slow.
        (rate > 0.0).then_some(SPAN * rate)
    }

    /// The coordinates with a rate below `limit`, each with its motion from `y` on, and the largest of their rates.
    fn slow(
        &self,
        generator: &Generator,
        loads: &[Poly; CHANNELS],
        limit: f64,
        y: &[f64],
    ) -> (Vec<(usize, Poly)>, f64) {
        let n = generator.n;
        let (mut slow, mut fastest) = (Vec::new(), 0.0f64);
        let fixed = usize::from(generator.rigid && !generator.braked);
        for (i, rates) in generator.rates.iter().enumerate().skip(fixed) {
            if rates[0].min(rates[1]) > limit {
                continue;
            }
            let pair = [i, n + i];
            let driven = pair.map(|k| self.is_driven(loads, k));
            let polys = generator.driven(i, [y[i], y[n + i]], |c, k| self.load(loads, pair[c], k));
            for c in 0..2 {
                let moves = if generator.is_diagonal(i) { driven[c] } else { driven != [false; 2] };
                if moves && rates[c] <= limit && !(generator.braked && [i, c] == [0, 0]) {
                    slow.push((pair[c], polys[c]));
                    fastest = fastest.max(rates[c]);
                }
            }
        }
        (slow, fastest)
    }

    /// True if a varying load acts on coordinate `k`.
    fn is_driven(&self, loads: &[Poly; CHANNELS], k: usize) -> bool {
        self.drives.iter().zip(loads).any(|(b, load)| b[k] != 0.0 && !load.is_constant())
    }

    /// Coefficient of `t^power` in the load `b f` on coordinate `k`.
    fn load(&self, loads: &[Poly; CHANNELS], k: usize, power: usize) -> f64 {
        self.drives.iter().zip(loads).map(|(b, load)| b[k] * load.0[power]).sum()
    }

    /// `y += sign sum_j S_j f^(j)(t)`.
    fn add_statics(&self, loads: &[Poly; CHANNELS], t: f64, sign: f64, y: &mut [f64]) {
        for ((statics, load), size) in self.statics.iter().zip(loads).zip(&self.sizes) {
            if *size == 0.0 {
                continue;
            }
            match orders(load) {
                0 => {}
                1 => kernel::add(y, sign * load.0[0], &statics[..y.len()]),
                orders => {
                    let mut derivatives: [f64; ORDERS] = load.derivatives_at(t);
                    derivatives.iter_mut().for_each(|derivative| *derivative *= sign);
                    kernel::add_columns(y, &derivatives[..orders], statics);
                }
            }
        }
    }
}

/// How many orders of a load's derivatives are not always zero. (Only a corrupt load has further coefficients; they are
/// ignored.)
fn orders(load: &Poly) -> usize {
    load.0[..ORDERS].iter().rposition(|c| *c != 0.0).map_or(0, |last| last + 1)
}

const _: () = assert!(TERMS > ORDERS + 1);
