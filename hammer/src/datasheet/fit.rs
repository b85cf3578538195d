//! Least squares over what is known, in logarithms: an error is a share of its number.

use super::assume::{Assumption, area};
use super::quantity::Quantity;
use super::relay::{Relay, Throw};
use super::response::Response;
use super::{Datasheet, DatasheetError, EFFICIENCY};
use crate::numerics::math;
use crate::quantities::air::ATMOSPHERE;
use crate::quantities::warnings::FASTEST;
use crate::scene::Scene;
use nalgebra::{DMatrix, DVector};

/// Error of a limit.
const CERTAIN: f64 = 0.01;
/// What a column has beside the others is nothing below this part of the largest.
const RANK: f64 = 1e-7;
const STEPS: usize = 100;

/// What a hammer is fitted by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unknowns {
    /// Driving force, N.
    pub force: f64,
    /// Stroke of the relay, m.
    pub lift: f64,
    /// Mass of the piston, kg.
    pub mass: f64,
    /// Mean driving pressure over the supply's.
    pub effectiveness: f64,
    /// Bore on which the pressure acts, m.
    pub bore: f64,
}

impl Unknowns {
    pub fn relay(&self, base: &Scene) -> Relay {
        let gravity = base.parameters.gravity;
        Relay { mass: self.mass, force: self.force, lift: self.lift, gravity }
    }

    fn moved(&self, by: &DVector<f64>) -> Self {
        let factor = |by: &f64| math::exp(by.clamp(-1.0, 1.0));
        let times = |x: f64, k: usize| x * by.get(k).map_or(1.0, factor);
        Self {
            force: times(self.force, 0),
            lift: times(self.lift, 1),
            mass: times(self.mass, 2),
            effectiveness: times(self.effectiveness, 3),
            bore: times(self.bore, 4),
        }
    }
}

/// What is fitted.
#[derive(Clone)]
pub(super) struct Fit<'a> {
    pub sheet: &'a Datasheet,
    base: &'a Scene,
    /// What had to be assumed.
    pub assumed: Vec<Assumption>,
    /// The fastest impact was too fast, and is held at [`FASTEST`].
    limited: bool,
}

impl<'a> Fit<'a> {
    /// Assumes what is missing, and looks whether it is enough.
    pub fn new(sheet: &'a Datasheet, base: &'a Scene) -> Result<Self, DatasheetError> {
        let mut fit = Self { sheet, base, assumed: Vec::new(), limited: false };
        let mut rank = fit.rank();
        for assumption in sheet.assumptions() {
            if rank == fit.columns() {
                break;
            }
            fit.assumed.push(assumption);
            let with = fit.rank();
            if with == rank {
                fit.assumed.pop();
            }
            rank = with;
        }
        if rank == fit.columns() {
            return Ok(fit);
        }
        let missing = match fit.get(Quantity::PistonMass).or(fit.mass_of_blow()) {
            None => "nothing says how heavy the piston is: give piston_mass, od or hole",
            Some(_) => {
                "nothing says the power of the blows: give power, or blow_energy and frequency, or \
                 pressure with air_flow or flow, or pressure and od of an air hammer"
            }
        };
        Err(DatasheetError::TooLittle(missing.into()))
    }

    /// What is given or assumed.
    fn get(&self, quantity: Quantity) -> Option<f64> {
        let assumed = self.assumed.iter().find(|row| row.quantity == quantity);
        self.sheet.get(quantity).or(assumed.map(|row| row.value))
    }

    fn mass_of_blow(&self) -> Option<f64> {
        let energy = self.sheet.get(Quantity::BlowEnergy)?;
        let speed = self.sheet.get(Quantity::ImpactSpeed)?;
        Some(2.0 * energy / (speed * speed))
    }

    /// Holds the impact at the fastest that steel stands, where that is left open and the blow is faster.
    pub fn limit(&mut self, throw: &Throw) -> bool {
        let held = !self.limited && !self.assumed.is_empty() && throw.speed > FASTEST;
        self.limited |= held;
        held
    }

    /// The blow that the sheet asks for, if it had to be held back.
    pub fn unlimited(&self, from: &Unknowns, response: &Response) -> Option<Throw> {
        let free = Self { limited: false, ..self.clone() };
        self.limited.then(|| Some(free.throw(&free.solve(*from, response).ok()?, response)))?
    }

    /// A first guess.
    pub fn start(&self) -> Unknowns {
        let get = |quantity| self.get(quantity);
        let mass = get(Quantity::PistonMass).or(self.mass_of_blow());
        let mass = mass.unwrap_or_else(|| self.base.parameters.piston_mass());
        let speed = get(Quantity::ImpactSpeed).unwrap_or(8.0);
        let of_power = get(Quantity::Power).zip(get(Quantity::Frequency)).map(|(p, f)| p / f);
        let energy = get(Quantity::BlowEnergy).or(of_power);
        let energy = energy.unwrap_or(0.5 * mass * speed * speed);
        let speed = (2.0 * energy / mass).sqrt();
        let effectiveness = get(Quantity::Effectiveness).unwrap_or(1.0);
        let bore = get(Quantity::Bore).unwrap_or(0.1);
        let pressed = get(Quantity::Pressure).filter(|_| self.sheet.has_pressure());
        let of_stroke = get(Quantity::Stroke).map(|stroke| energy / stroke);
        let force = match (get(Quantity::Frequency), pressed) {
            (Some(frequency), _) => 2.5 * mass * speed * frequency,
            (None, Some(pressure)) => effectiveness * pressure * area(bore),
            (None, None) => of_stroke.unwrap_or(self.base.parameters.drive.amplitude),
        };
        let force = force.max(1.5 * mass * self.base.parameters.gravity.abs());
        let energy = if get(Quantity::BlowEnergy).is_some() || of_stroke.is_none() {
            energy
        } else {
            force * get(Quantity::Stroke).unwrap_or_default()
        };
        Unknowns { force, lift: 0.42 * energy / force, mass, effectiveness, bore }
    }

    /// The blow of these unknowns.
    pub fn throw(&self, unknowns: &Unknowns, response: &Response) -> Throw {
        let none = Throw { energy: f64::NAN, speed: f64::NAN, height: f64::NAN, period: f64::NAN };
        unknowns.relay(self.base).throw(response.returned).unwrap_or(none)
    }

    /// Work per time that the rock is given over what a metre of hole takes.
    pub fn rate(&self, energy: f64, period: f64, share: f64) -> f64 {
        let mut p = self.base.parameters;
        p.hole.diameter = self.sheet.hole().map_or(p.hole.diameter, |(hole, _)| hole);
        share * energy / period / p.work_per_length()
    }

    /// What a number would be; `None` of what nothing follows for.
    pub fn value(&self, of: Quantity, unknowns: &Unknowns, response: &Response) -> Option<f64> {
        let throw = self.throw(unknowns, response);
        let period = throw.period * response.delay;
        let pressed = self.sheet.has_pressure();
        match of {
            Quantity::Pressure => pressed
                .then(|| unknowns.force / unknowns.effectiveness / area(unknowns.bore)),
            Quantity::Bore => pressed.then_some(unknowns.bore),
            Quantity::Effectiveness => pressed.then_some(unknowns.effectiveness),
            Quantity::Stroke => Some(throw.height),
            Quantity::PistonMass => Some(unknowns.mass),
            Quantity::BlowEnergy => Some(throw.energy),
            Quantity::Frequency => Some(1.0 / period),
            Quantity::ImpactSpeed => Some(throw.speed),
            Quantity::Power => Some(throw.energy / period),
            // Air works at the supply's pressure: `W = p V`, and takes more room when it is free.
            Quantity::AirFlow => {
                let pressure = self.sheet.get(Quantity::Pressure)?;
                Some(throw.energy / period * (1.0 / pressure + 1.0 / ATMOSPHERE))
            }
            Quantity::Flow => match self.sheet.get(Quantity::Pressure) {
                Some(pressure) => Some(throw.energy / period / (EFFICIENCY * pressure)),
                None => Some(area(self.sheet.get(Quantity::Bore)?) * throw.height / period),
            },
            Quantity::PistonLength
            | Quantity::BitMass
            | Quantity::OuterDiameter
            | Quantity::Length
            | Quantity::Hole
            | Quantity::Feed
            | Quantity::Pipe
            | Quantity::Rotation
            | Quantity::DampingRatio
            // It says the rock's specific energy, and nothing of the hammer.
            | Quantity::Rate => None,
        }
    }

    /// What is known or assumed less what would be, over its error.
    fn residuals(&self, unknowns: &Unknowns, response: &Response) -> DVector<f64> {
        let stated =
            self.sheet.known.iter().map(|(quantity, given)| (*quantity, *given, quantity.error()));
        let assumed = self.assumed.iter().map(|row| (row.quantity, row.value, row.error));
        let limit = self.limited.then_some((Quantity::ImpactSpeed, FASTEST, CERTAIN));
        let rows = stated.chain(assumed).chain(limit).filter_map(|(quantity, given, error)| {
            let value = self.value(quantity, unknowns, response)?;
            Some(math::ln(given / value) / error)
        });
        DVector::from_vec(rows.collect())
    }

    /// Force, stroke and mass, and with a pressure the effectiveness and the bore.
    fn columns(&self) -> usize {
        if self.sheet.has_pressure() { 5 } else { 3 }
    }

    fn jacobian(&self, at: &Unknowns, response: &Response) -> DMatrix<f64> {
        const BY: f64 = 1e-6;
        let columns: Vec<DVector<f64>> = (0..self.columns())
            .map(|k| {
                let along = |by: f64| {
                    let mut step = DVector::zeros(self.columns());
                    step[k] = by;
                    self.residuals(&at.moved(&step), response)
                };
                (along(BY) - along(-BY)) / (2.0 * BY)
            })
            .collect();
        DMatrix::from_columns(&columns)
    }

    /// How many unknowns the rows tell.
    fn rank(&self) -> usize {
        let jacobian = self.jacobian(&self.start(), &Response::GUESS);
        if jacobian.nrows() == 0 {
            return 0;
        }
        let upper = jacobian.col_piv_qr().r();
        let beside = (0..upper.nrows()).map(|k| upper[(k, k)].abs());
        let largest = beside.clone().fold(0.0, f64::max);
        beside.filter(|size| *size > RANK * largest).count()
    }

    /// Standard error of a number, as a share of it: what the errors of all rows leave open.
    pub fn error(&self, of: Quantity, at: &Unknowns, response: &Response) -> f64 {
        const BY: f64 = 1e-6;
        let along = |k: usize, by: f64| {
            let mut step = DVector::zeros(self.columns());
            step[k] = by;
            self.value(of, &at.moved(&step), response).map_or(f64::NAN, math::ln)
        };
        let slope = (0..self.columns()).map(|k| (along(k, BY) - along(k, -BY)) / (2.0 * BY));
        let mut slope = DVector::from_iterator(self.columns(), slope);
        let qr = self.jacobian(at, response).col_piv_qr();
        qr.p().permute_rows(&mut slope);
        let part = qr.r().transpose().solve_lower_triangular(&slope);
        part.map_or(f64::NAN, |part| part.norm())
    }

    /// The best unknowns for a response: Gauss and Newton's steps, halved until they help.
    pub fn solve(&self, from: Unknowns, response: &Response) -> Result<Unknowns, DatasheetError> {
        let mut best = from;
        let mut residuals = self.residuals(&best, response);
        for _ in 0..STEPS {
            // Not by singular values: nalgebra's take `hypot` from the C library.
            let qr = self.jacobian(&best, response).col_piv_qr();
            let mut right = -&residuals;
            qr.q_tr_mul(&mut right);
            let right = right.rows(0, self.columns());
            let Some(mut step) = qr.r().solve_upper_triangular(&right) else { break };
            qr.p().inv_permute_rows(&mut step);
            if step.norm() < 1e-10 {
                break;
            }
            let better = (0..40).find_map(|_| {
                let there = best.moved(&step);
                let new = self.residuals(&there, response);
                step *= 0.5;
                (new.norm() < residuals.norm()).then_some((there, new))
            });
            let Some((there, new)) = better else { break };
            (best, residuals) = (there, new);
        }
        if !residuals.norm().is_finite() {
            return Err(DatasheetError::Contradiction(format!(
                "{:.4} N cannot lift a piston of {:.4} kg",
                best.force, best.mass
            )));
        }
        Ok(best)
    }
}
