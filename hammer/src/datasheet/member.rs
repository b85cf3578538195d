//! One hammer of a sample: what it is, what it does, and how it is moved until it does what a sheet gives.

use super::table::{Scales, Table};
use super::{Datasheet, EFFICIENCY, Quantity};
use crate::numerics::math;
use crate::quantities::air::ATMOSPHERE;
use nalgebra::{DMatrix, DVector, SVector};
use std::f64::consts::PI;

/// Unknowns: logarithms of pressure, bore, mass, stroke, port over bore, and of the factors by which energy and
/// square of the frequency (effectiveness), air, and frequency are off those of hammers in proportion.
pub(super) const COUNT: usize = 8;
pub(super) type Point = SVector<f64, COUNT>;
/// A residual of so many errors counts as an outlier: it pulls no harder.
const OUTLIER: f64 = 3.0;
/// Steps in which hammers are moved to what a sheet gives.
const STEPS: i32 = 10;
/// Share of its speed with which a piston of a liquid's drive is thrown back, squared.
const RETURNED: f64 = 0.16;
/// Height to which a liquid lifts the piston under pressure, over the stroke, m.
pub(super) const LIFT: f64 = 0.03;

/// What drives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fluid {
    Air,
    /// At a constant pressure, in closed form: a piston of mass `m` is lifted over `D` by the force `F`, is braked
    /// by it and thrown back, with the share `e` of its speed `v` left from the blow before:
    /// `m v^2 (1 - e^2) / 2 = 2 F D`, `w^2 = (e v)^2 + 2 F D / m`, period `(2 w + v (1 - e)) m / F`.
    Liquid,
}

/// What a member does at a pressure, SI.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blow {
    pub pressure: f64,
    pub bore: f64,
    pub mass: f64,
    pub energy: f64,
    pub frequency: f64,
    /// Of free air, or of the liquid.
    pub flow: f64,
    pub height: f64,
}

impl Blow {
    pub fn speed(&self) -> f64 {
        (2.0 * self.energy / self.mass).sqrt()
    }

    pub fn power(&self) -> f64 {
        self.energy * self.frequency
    }

    /// Mean driving pressure over the supply's.
    pub fn effectiveness(&self) -> f64 {
        self.energy / (self.pressure * 0.25 * PI * self.bore * self.bore * self.height)
    }

    /// A number that a sheet may give; `None` of what says nothing of a blow.
    pub fn value(&self, of: Quantity) -> Option<f64> {
        match of {
            Quantity::Pressure => Some(self.pressure),
            Quantity::Bore => Some(self.bore),
            Quantity::Stroke => Some(self.height),
            Quantity::PistonMass => Some(self.mass),
            Quantity::BlowEnergy => Some(self.energy),
            Quantity::Frequency => Some(self.frequency),
            Quantity::ImpactSpeed => Some(self.speed()),
            Quantity::Power => Some(self.power()),
            Quantity::AirFlow | Quantity::Flow => Some(self.flow),
            Quantity::Effectiveness => Some(self.effectiveness()),
            _ => None,
        }
    }
}

/// What hammers are before anything is known of one: of each unknown a logarithm and its error.
pub(super) struct Kind {
    pub fluid: Fluid,
    pub middle: Point,
    pub wide: Point,
    pub table: &'static Table,
}

impl Kind {
    /// The logarithms of a hammer so many errors off the middle.
    pub fn logs(&self, off: &Point) -> Point {
        self.middle + self.wide.component_mul(off)
    }

    /// Its blow at a pressure, or at its own.
    pub fn blow(&self, off: &Point, pressure: Option<f64>) -> Blow {
        let own: [f64; COUNT] = self.logs(off).map(math::exp).into();
        let [supply, bore, mass, stroke, port, effective, share, pace] = own;
        let pressure = pressure.unwrap_or(supply);
        let area = 0.25 * PI * bore * bore;
        let pace = pace * effective.sqrt();
        match self.fluid {
            Fluid::Air => {
                let scales = Scales { area, mass, stroke };
                let [energy, time, volume] = scales.of();
                let opening = math::ln(port * scales.opening());
                let numbers = self.table.at(math::ln(pressure / ATMOSPHERE), opening);
                let [e, f, q, h] = numbers.map(math::exp);
                let (energy, frequency) = (effective * e * energy, pace * f / time);
                let flow = share * pace * q * volume / time;
                Blow { pressure, bore, mass, energy, frequency, flow, height: h * stroke }
            }
            Fluid::Liquid => {
                let (force, lift) = (effective * pressure * area, LIFT * stroke);
                let energy = 2.0 * force * lift / (1.0 - RETURNED);
                let speed = (2.0 * energy / mass).sqrt();
                let turned = (RETURNED * speed * speed + 2.0 * force * lift / mass).sqrt();
                let period = (2.0 * turned + speed * (1.0 - RETURNED.sqrt())) * mass / force;
                let frequency = pace / effective.sqrt() / period;
                let flow = share * energy * frequency / (EFFICIENCY * pressure);
                let height = energy / force;
                Blow { pressure, bore, mass, energy, frequency, flow, height }
            }
        }
    }

    /// What the hammer of a point is built of: `height` is the stroke over the presets', `flow` the area of a port.
    pub fn hammer(&self, off: &Point, pressure: Option<f64>) -> Blow {
        let own: [f64; COUNT] = self.logs(off).map(math::exp).into();
        let [supply, bore, mass, height, port, effective, ..] = own;
        // What acts better acts on more.
        let bore = bore * effective.sqrt();
        let flow = port * 0.25 * PI * bore * bore;
        let pressure = pressure.unwrap_or(supply);
        Blow { pressure, bore, mass, energy: f64::NAN, frequency: f64::NAN, flow, height }
    }

    /// The number of a row.
    pub fn value(&self, row: &Row, off: &Point) -> f64 {
        self.blow(off, row.pressure).value(row.quantity).unwrap_or(row.given)
    }

    /// Moves hammers to what the rows give, each up to its error, which every hammer's own measurements have (`noise`, in
    /// errors, of a member, a row and a step). By an ensemble smoother (Emerick and Reynolds 2013): rows are taken in
    /// parts, each twice that before, and all members are moved by one regression on how they differ. So none leaps to
    /// another hammer that fits as well where the sheet changes a little, as a search of its own for each would.
    pub fn move_to(
        &self,
        rows: &[Row],
        members: &mut [Point],
        noise: impl Fn(usize, &Row, i32) -> f64,
    ) {
        for step in 0..STEPS {
            let inflated = (2f64.powi(STEPS) - 1.0) / 2f64.powi(step);
            // Unknowns, and how far the rows are off, in errors.
            let states: Vec<DVector<f64>> = members
                .iter()
                .map(|off| {
                    let off_rows = rows
                        .iter()
                        .map(|row| math::ln(self.value(row, off) / row.given) / row.error);
                    DVector::from_iterator(COUNT + rows.len(), off.iter().copied().chain(off_rows))
                })
                .collect();
            let part = 1.0 / states.len() as f64;
            let mut mean = DVector::zeros(COUNT + rows.len());
            states.iter().for_each(|state| mean.axpy(part, state, 1.0));
            let mut spread = DMatrix::zeros(mean.len(), mean.len());
            for state in &states {
                let off = state - &mean;
                spread.ger(part, &off, &off, 1.0);
            }
            let mut of_rows = spread.view((COUNT, COUNT), (rows.len(), rows.len())).into_owned();
            let errors = DVector::from_fn(rows.len(), |k, _| {
                let off = mean[COUNT + k].abs() / (1.0 + of_rows[(k, k)]).sqrt();
                inflated / rows[k].weight(off)
            });
            of_rows += DMatrix::from_diagonal(&errors);
            let Some(factors) = of_rows.cholesky() else { return };
            for (member, (off, state)) in members.iter_mut().zip(&states).enumerate() {
                let mut wanted = DVector::from_fn(rows.len(), |k, _| {
                    noise(member, &rows[k], step) * errors[k].sqrt() - state[COUNT + k]
                });
                factors.solve_mut(&mut wanted);
                off.gemv(1.0, &spread.view((0, COUNT), (COUNT, rows.len())), &wanted, 1.0);
            }
        }
    }
}

/// A number of a sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub quantity: Quantity,
    pub given: f64,
    /// Standard error, as a share of it.
    pub error: f64,
    /// At another pressure than that which is worked at, Pa.
    pub pressure: Option<f64>,
    /// Which of several of its quantity.
    pub series: usize,
    /// Not given: what pistons do.
    pub assumed: bool,
}

impl Row {
    /// Of a number that is given, with its own error.
    fn new(quantity: Quantity, given: f64) -> Self {
        let error = quantity.error();
        Self { quantity, given, error, pressure: None, series: 0, assumed: false }
    }

    /// What is left of a residual's weight: beyond an outlier's it pulls no harder (Huber); in a table, of which the
    /// other rows stand against it, ever less (Cauchy).
    fn weight(&self, r: f64) -> f64 {
        match self.series {
            0 => (OUTLIER / r).min(1.0),
            _ => 1.0 / (1.0 + (r / OUTLIER) * (r / OUTLIER)),
        }
    }
}

impl Datasheet {
    /// What it gives of the hammer itself.
    pub(super) fn of_hammer(&self) -> impl Iterator<Item = Row> + '_ {
        let all = [Quantity::Pressure, Quantity::Bore, Quantity::PistonMass];
        all.into_iter().filter_map(|quantity| Some(Row::new(quantity, self.get(quantity)?)))
    }

    /// What it gives of a blow.
    pub(super) fn rows(&self) -> Vec<Row> {
        let air = self.fluid() == Fluid::Air;
        let known = self
            .known
            .iter()
            .filter(|(quantity, _)| quantity.of_blow() && (air || *quantity != Quantity::AirFlow));
        let known = known.map(|(quantity, given)| Row::new(*quantity, *given));
        let table = self.air.iter().enumerate();
        let table = table.map(|(series, [at, air])| Row {
            series: series + 1,
            pressure: Some(*at),
            ..Row::new(Quantity::AirFlow, *air)
        });
        known.chain(table).chain(self.usual_speed()).collect()
    }
}
