//! A hammer of the sample: its unknowns, its blows, and its fit to a sheet.

use super::table::{Scales, at};
use super::{Datasheet, EFFICIENCY, Quantity};
use crate::numerics::math;
use crate::quantities::air::ATMOSPHERE;
use nalgebra::{DMatrix, DVector, SVector};
use std::f64::consts::PI;

/// Number of unknowns. The first are logarithms: of pressure, bore, mass, stroke, and port over bore; and of three
/// factors relative to scaled presets, for the energy and the square of the frequency (effectiveness), for air, and for
/// frequency. Then come three exponents, with which air, energy and frequency depend on pressure in addition to the
/// presets' dependence. The last is the logarithm of the factor by which a hammer takes more air at low pressure.
pub(super) const COUNT: usize = 12;
/// Number of unknowns that are logarithms of dimensions and factors; they come first.
const LOGARITHMS: usize = 8;
pub(super) type Point = SVector<f64, COUNT>;
/// A residual beyond this many standard errors is an outlier. Its influence does not grow with its size.
const OUTLIER: f64 = 3.0;
/// Number of steps in which hammers are fitted to a sheet.
const STEPS: i32 = 10;
/// Square of the share of its speed that the piston of a liquid's hammer keeps in the rebound.
const RETURNED: f64 = 0.16;
/// Height to which a liquid under pressure lifts the piston, m, for a stroke of 1.
pub(super) const LIFT: f64 = 0.03;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fluid {
    Air,
    /// A drive at constant pressure, in closed form. A piston of mass `m` is lifted over `D` by the force `F`, then
    /// braked by it and thrown back. It keeps the share `e` of its speed `v` from the previous blow: `m v^2 (1 - e^2) /
    /// 2 = 2 F D`, `w^2 = (e v)^2 + 2 F D / m`, period `(2 w + v (1 - e)) m / F`.
    Liquid,
}

/// The blow of a member at a pressure, in SI units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blow {
    pub pressure: f64,
    pub bore: f64,
    pub mass: f64,
    pub energy: f64,
    pub frequency: f64,
    /// Flow of free air or of the liquid; and the part of it that goes through the chambers.
    pub flow: f64,
    pub driving: f64,
    pub height: f64,
}

impl Blow {
    pub fn speed(&self) -> f64 {
        (2.0 * self.energy / self.mass).sqrt()
    }

    pub fn power(&self) -> f64 {
        self.energy * self.frequency
    }

    /// Mean driving pressure over the supply's pressure.
    pub fn effectiveness(&self) -> f64 {
        self.energy / (self.pressure * 0.25 * PI * self.bore * self.bore * self.height)
    }

    /// The blow's value of a quantity; `None` for a quantity that is not a property of a blow.
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

/// How much of the low-pressure factor of the air applies at a pressure (Pa, above the exhaust's): 1 up to 6 bar, 0
/// from 10 bar on, and linear in the logarithm between.
pub(super) fn low(pressure: f64) -> f64 {
    (math::ln(10e5 / pressure) / math::ln(10.0 / 6.0)).clamp(0.0, 1.0)
}

/// The prior distribution of hammers: the median and the standard error of each unknown.
pub(super) struct Kind {
    pub fluid: Fluid,
    pub middle: Point,
    pub wide: Point,
}

impl Kind {
    /// The unknowns of a hammer that differs from the median by `off` standard errors.
    pub fn logs(&self, off: &Point) -> Point {
        self.middle + self.wide.component_mul(off)
    }

    /// The hammer's blow at a pressure, or at its own pressure if that is `None`.
    pub fn blow(&self, off: &Point, pressure: Option<f64>) -> Blow {
        let logs = self.logs(off);
        let own: [f64; LOGARITHMS] = std::array::from_fn(|k| math::exp(logs[k]));
        let [supply, bore, mass, stroke, port, effective, share, pace] = own;
        let pressure = pressure.unwrap_or(supply);
        let over = math::ln(pressure / supply);
        let [air, energetic, faster] = [8, 9, 10].map(|k| math::exp(logs[k] * over));
        let area = 0.25 * PI * bore * bore;
        let pace = pace * effective.sqrt();
        match self.fluid {
            Fluid::Air => {
                let scales = Scales { area, mass, stroke };
                let [energy, time, volume] = scales.of();
                let opening = math::ln(port * scales.opening());
                let numbers = at(math::ln(pressure / ATMOSPHERE), opening);
                let [e, f, q, h] = numbers.map(math::exp);
                let energy = energetic * effective * e * energy;
                let frequency = faster * pace * f / time;
                let driving = air * share * pace * q * volume / time;
                let flow = driving * math::exp(logs[11] * low(pressure));
                let height = h * stroke;
                Blow { pressure, bore, mass, energy, frequency, flow, driving, height }
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
                Blow { pressure, bore, mass, energy, frequency, flow, driving: flow, height }
            }
        }
    }

    /// The dimensions of a hammer. `height` is the stroke over the presets' stroke; `flow` is the area of a port.
    pub fn hammer(&self, off: &Point, pressure: Option<f64>) -> Blow {
        let logs = self.logs(off);
        let [supply, bore, mass, height, port, effective] =
            std::array::from_fn(|k| math::exp(logs[k]));
        // Greater effectiveness is represented by a larger area.
        let bore = bore * effective.sqrt();
        let flow = port * 0.25 * PI * bore * bore;
        let pressure = pressure.unwrap_or(supply);
        let [energy, frequency] = [f64::NAN; 2];
        Blow { pressure, bore, mass, energy, frequency, flow, driving: flow, height }
    }

    pub fn value(&self, row: &Row, off: &Point) -> f64 {
        self.blow(off, row.pressure).value(row.quantity).unwrap_or(row.given)
    }

    /// Fits hammers to the rows, each to its own noisy measurements. `noise` returns the noise of a member, a row and a
    /// step, in standard errors. This is an ensemble smoother (Emerick and Reynolds 2013): in each step the rows count
    /// twice as much as in the previous one, and all members are moved by one linear regression. A small change of the
    /// sheet can therefore not move a member to a distant hammer that fits as well, as separate searches could.
    pub fn move_to(
        &self,
        rows: &[Row],
        members: &mut [Point],
        noise: impl Fn(usize, &Row, i32) -> f64,
    ) {
        for step in 0..STEPS {
            let inflated = f64::from((1 << STEPS) - 1) / f64::from(1 << step);
            // Unknowns, followed by the residuals of the rows in standard errors.
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

/// A given or assumed number of a sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub quantity: Quantity,
    pub given: f64,
    /// Relative standard error.
    pub error: f64,
    /// Pressure to which the number belongs, Pa; `None` means the working pressure.
    pub pressure: Option<f64>,
    /// Row number in the table of air, from 1; 0 for a single number.
    pub series: usize,
    /// True if the number is assumed, not given.
    pub assumed: bool,
}

impl Row {
    /// A row for a given number, with the usual error of its quantity.
    fn new(quantity: Quantity, given: f64) -> Self {
        let error = quantity.entry().error;
        Self { quantity, given, error, pressure: None, series: 0, assumed: false }
    }

    /// Weight of a residual. The influence of an outlier does not grow with its size (Huber). In a table, where other
    /// rows may contradict it, it decreases (Cauchy).
    fn weight(&self, r: f64) -> f64 {
        match self.series {
            0 => (OUTLIER / r).min(1.0),
            _ => 1.0 / (1.0 + (r / OUTLIER) * (r / OUTLIER)),
        }
    }
}

impl Datasheet {
    pub(super) fn of_hammer(&self) -> impl Iterator<Item = Row> + '_ {
        let all = [Quantity::Pressure, Quantity::Bore, Quantity::PistonMass];
        all.into_iter().filter_map(|quantity| Some(Row::new(quantity, self.get(quantity)?)))
    }

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
        known.chain(table).chain(self.usual()).collect()
    }
}
