//! Taylor series of the linear system of a mode.
//!
//! With `u = sum U_k x^k`, `v = sum V_k x^k`, loads `sum L_k x^k` and `x = t / unit`,
//!
//! ```text
//! U_{k+1} = unit V_k / (k + 1)
//! V_{k+1} = unit M^-1 (L_k - K U_k - C V_k) / (k + 1)
//! psi_{k+1} = unit CR sum_{i+j=k} p'_i p'_j / (k + 1)
//! ```
//!
//! and the works of the loads alike. `unit` is about the reciprocal of the fastest frequency,
//! which keeps the coefficients far from overflow; a power of two, so that scaling is exact.

use crate::air::{Air, AirSeries, Content};
use crate::law::{Memory, Mode, Quantity, Rock, State};
use crate::linear::Real;
use crate::model::Model;
use crate::scene::Input;

/// Determines the length of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Order of the series.
    pub order: usize,
    /// Size of the last term kept, over the largest.
    pub tolerance: f64,
}

/// Tolerance of works over that of motion.
const WORKS: f64 = 1e5;

/// How often a step of the air may be shortened to a fifth, until its series converges.
const SHORTENINGS: usize = 12;

/// Works of the loads since the start, J, and the air in the chambers, which is integrated with them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Works<T> {
    /// Work of `F_A`, of its reaction, and of the return chamber on what the piston strikes.
    pub drive: T,
    /// Work of the feed, and of the holder of an air cylinder without a casing.
    pub feed: T,
    /// Content of the chambers; zero without air.
    pub air: Content<T>,
}

/// The inputs: rows of coefficients of `x^k` by [`Input`].
pub type Polynomials<T> = [Vec<T>; 6];

/// The series of a whole state about one instant.
#[derive(Clone, Debug)]
pub struct Series<T> {
    u: Vec<Vec<T>>,
    v: Vec<Vec<T>>,
    psi: Vec<T>,
    works: [Vec<T>; 2],
    /// Series of the air, if there is any.
    pub air: Option<AirSeries<T>>,
}

/// `sum c_k x^k`.
pub fn horner<T: Real>(c: &[T], x: T) -> T {
    c.iter().rev().fold(T::default(), |sum, &c| sum * x + c)
}

/// The same polynomial about `x`, by repeated synthetic division.
pub fn shifted<T: Real>(c: &[T], x: T) -> Vec<T> {
    let mut c = c.to_vec();
    for first in 0..c.len() {
        for k in (first..c.len() - 1).rev() {
            c[k] = c[k] + x * c[k + 1];
        }
    }
    c
}

/// Coefficient `k` of a product.
pub(crate) fn product<T: Real>(a: &[T], b: &[T], k: usize) -> T {
    let first = (k + 1).saturating_sub(b.len());
    (first..a.len().min(k + 1)).fold(T::default(), |sum, i| sum + a[i] * b[k - i])
}

/// Largest magnitude.
fn size<T: Real>(row: &[T]) -> f64 {
    row.iter().fold(0.0f64, |max, x| max.max(x.to_f64().abs()))
}

impl<T: Real> Series<T> {
    /// Expands about `state`.
    pub fn new(
        model: &Model<T>,
        (mode, memory): (Mode, &Memory<T>),
        (inputs, air): (&Polynomials<T>, Option<&Air<T>>),
        (state, works): (&State<T>, &Works<T>),
        order: usize,
        unit: f64,
    ) -> Self {
        let mut series = Self {
            u: vec![state.u.clone()],
            v: vec![state.v.clone()],
            psi: vec![state.psi],
            works: [vec![works.drive], vec![works.feed]],
            air: air.map(|air| {
                let air = air.under(inputs);
                AirSeries::new(air, model.scene.anvil_area, &works.air)
            }),
        };
        let [mut force, mut pressing] = match air {
            Some(_) => Default::default(),
            None => model.driving(mode, inputs),
        };
        let feed = &inputs[Input::Feed as usize];
        let nothing = vec![T::default(); model.nodes()];
        let (mut rate, mut load) = (nothing.clone(), model.standing(mode, memory));
        // Velocities of the points at which the loads act.
        let mut ways: [Vec<T>; 3] = std::array::from_fn(|_| Vec::new());
        for k in 0..order {
            let step = T::from(unit) / T::from((k + 1) as f64);
            if let Some(air) = &mut series.air {
                let gap = T::from(if k == 0 { model.scene.gap } else { 0.0 });
                let [u, v] = [&series.u[k], &series.v[k]];
                let places = [model.mean_difference(u), model.over(u)].map(|place| place - gap);
                let speeds = [model.mean_difference(v), model.over(v)];
                let [on_piston, on_bit] = air.grow(places, speeds, step);
                force.push(on_piston);
                pressing.push(on_bit);
            }
            if model.scene.impedance > 0.0 {
                // A line reacts to the piston's speed; without a casing it also acts on the struck body.
                let answer = model.line(mode, &series.v[k]);
                for (row, sign) in [(&mut force, 1.0), (&mut pressing, -1.0)] {
                    row.resize(row.len().max(k + 1), T::default());
                    if sign > 0.0 || model.scene.casing.is_none() {
                        row[k] = row[k] + T::from(sign) * answer;
                    }
                }
            }
            if k < force.len().max(feed.len()).max(pressing.len()) {
                let of = |row: &[T]| row.get(k).copied().unwrap_or_default();
                load[model.fed()] = load[model.fed()] + of(feed);
                model.push(&mut load, &[of(&force), of(&pressing)]);
            }
            model.acceleration(mode, &load, &series.u[k], &series.v[k], &mut rate);
            load.clone_from(&nothing);
            let v = &series.v[k];
            let along =
                |row: &[T]| row.iter().zip(v).fold(T::default(), |sum, (&d, &v)| sum + d * v);
            ways[0].push(along(&model.drive));
            ways[1].push(along(&model.anvil));
            ways[2].push(v[model.fed()]);
            let driven = product(&force, &ways[0], k) + product(&pressing, &ways[1], k);
            let mut works = [driven, product(feed, &ways[2], k)];
            if series.air.is_some() && model.scene.casing.is_none() {
                // The cylinder follows what the piston strikes, so its holder does work.
                let held = product(&force, &ways[1], k) + product(&pressing, &ways[1], k);
                works = [works[0] - held, works[1] + held];
            }
            for (row, work) in series.works.iter_mut().zip(works) {
                row.push(work * step);
            }
            series.u.push(v.iter().map(|&v| v * step).collect());
            series.psi.push(series.power(model, mode, k) * step);
            series.v.push(rate.iter().map(|&a| a * step).collect());
        }
        series
    }

    fn power(&self, model: &Model<T>, mode: Mode, k: usize) -> T {
        if mode.rock != Rock::DFC {
            return T::default();
        }
        let tip = model.tip;
        let sum = (0..=k).fold(T::default(), |sum, i| sum + self.v[i][tip] * self.v[k - i][tip]);
        sum * T::from(model.scene.rock.viscosity)
    }

    /// Length of the step, in units of time, after which the last two terms are below the tolerance. For works, whose
    /// series are products and fall more slowly, it is [`WORKS`] times larger, since no event but Q3 depends on them.
    pub fn reach(&self, accuracy: Accuracy) -> f64 {
        let last = self.u.len() - 1;
        let until = |tolerance: f64, row: &dyn Fn(usize) -> f64| {
            let scale = (0..=last).map(row).fold(f64::MIN_POSITIVE, f64::max);
            let end = |k: usize| {
                let size = (row(k) / scale).max(f64::MIN_POSITIVE);
                (tolerance / size).powf(1.0 / k as f64)
            };
            end(last - 1).min(end(last))
        };
        let works = WORKS * accuracy.tolerance;
        let motion = until(accuracy.tolerance, &|k| size(&self.u[k]))
            .min(until(accuracy.tolerance, &|k| size(&self.v[k])));
        // The unit of time does not fit the air's own rates, so its terms are compared with the largest within the
        // step.
        let contents = self.air.iter().flat_map(|air| &air.content);
        let motion = contents.fold(motion, |least, row| {
            (0..SHORTENINGS).fold(least, |step, _| {
                let term = |k: usize| row[k].to_f64().abs() * step.powi(k as i32);
                step * until(accuracy.tolerance, &term).min(1.0)
            })
        });
        let rows = self.works.iter().chain([&self.psi]);
        rows.fold(motion, |least, row| least.min(until(works, &|k| row[k].to_f64().abs())))
    }

    /// The state and the works after `x` units of time.
    pub fn at(&self, x: T) -> (State<T>, Works<T>) {
        let row = |rows: &[Vec<T>]| {
            let mut sum = vec![T::default(); rows[0].len()];
            for coefficients in rows.iter().rev() {
                for (s, &c) in sum.iter_mut().zip(coefficients) {
                    *s = *s * x + c;
                }
            }
            sum
        };
        let state = State { u: row(&self.u), v: row(&self.v), psi: horner(&self.psi, x) };
        let [drive, feed] = [0, 1].map(|i| horner(&self.works[i], x));
        let air = self.air.as_ref().map(|air| air.content.each_ref().map(|row| horner(row, x)));
        (state, Works { drive, feed, air: air.unwrap_or_default() })
    }

    /// The polynomial of a guarded quantity.
    pub fn quantity(&self, model: &Model<T>, quantity: Quantity) -> Vec<T> {
        let tip = model.tip;
        let mut c: Vec<T> = match quantity {
            Quantity::Gap => self.u.iter().map(|u| model.gap(u)).collect(),
            Quantity::Tip => self.u.iter().map(|u| u[tip]).collect(),
            Quantity::TipSpeed => self.v.iter().map(|v| v[tip]).collect(),
            Quantity::Relative => self.u.iter().map(|u| model.mean_difference(u)).collect(),
            Quantity::Work => self.psi.clone(),
            Quantity::Joint(i) => self.u.iter().map(|u| model.joints[i].apart(u)).collect(),
        };
        let gap = T::from(model.scene.gap);
        match quantity {
            Quantity::Gap => c[0] = c[0] + gap,
            Quantity::Relative => c[0] = c[0] - gap,
            _ => {}
        }
        c
    }
}
