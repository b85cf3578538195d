//! Least squares over what is known, in logarithms: an error is a share of its number.

use super::quantity::Quantity;
use super::relay::{Relay, Throw};
use super::response::Response;
use super::{Datasheet, DatasheetError};
use crate::numerics::math;
use crate::sensitivity::Scene;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// Atmosphere, Pa.
const ATMOSPHERE: f64 = 101_325.0;
/// Effectiveness where nothing else tells it, and its standard error in logarithms.
pub(super) const EFFECTIVE: f64 = 0.5;
const UNSURE: f64 = 0.2;
/// Error of what is known for certain.
const CERTAIN: f64 = 1e-4;
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
}

impl Unknowns {
    pub fn relay(&self, own: &Scene) -> Relay {
        let gravity = own.parameters.gravity;
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
        }
    }
}

/// What is fitted.
pub(super) struct Fit<'a> {
    pub sheet: &'a Datasheet,
    own: &'a Scene,
    /// The effectiveness is assumed: nothing else tells it.
    pub assumed: bool,
}

impl<'a> Fit<'a> {
    /// Looks whether enough is known.
    pub fn new(sheet: &'a Datasheet, own: &'a Scene) -> Result<Self, DatasheetError> {
        let mut fit = Self { sheet, own, assumed: false };
        if fit.is_enough() {
            return Ok(fit);
        }
        fit.assumed = fit.has_pressure() && sheet.get(Quantity::Effectiveness).is_none();
        if fit.assumed && fit.is_enough() {
            return Ok(fit);
        }
        let mass = sheet.get(Quantity::PistonMass).or(fit.mass_of_blow());
        let missing = match mass {
            None => "piston_mass is missing: give it, or blow_energy and impact_speed",
            Some(_) => {
                "give blow_energy and frequency, or pressure, bore and stroke: what is known \
                        leaves driving force and stroke open"
            }
        };
        Err(DatasheetError::TooLittle(missing.into()))
    }

    pub fn has_pressure(&self) -> bool {
        self.sheet.get(Quantity::Pressure).is_some() && self.sheet.get(Quantity::Bore).is_some()
    }

    fn mass_of_blow(&self) -> Option<f64> {
        let energy = self.sheet.get(Quantity::BlowEnergy)?;
        let speed = self.sheet.get(Quantity::ImpactSpeed)?;
        Some(2.0 * energy / (speed * speed))
    }

    /// Area on which the pressure acts, m2.
    pub fn area(&self) -> Option<f64> {
        self.sheet.get(Quantity::Bore).map(|bore| 0.25 * PI * bore * bore)
    }

    /// A first guess.
    pub fn start(&self) -> Unknowns {
        let get = |quantity| self.sheet.get(quantity);
        let mass = get(Quantity::PistonMass).or(self.mass_of_blow());
        let mass = mass.unwrap_or_else(|| self.own.parameters.piston_mass());
        let speed = get(Quantity::ImpactSpeed).unwrap_or(8.0);
        let of_power = get(Quantity::Power).zip(get(Quantity::Frequency)).map(|(p, f)| p / f);
        let energy = get(Quantity::BlowEnergy).or(of_power);
        let energy = energy.unwrap_or(0.5 * mass * speed * speed);
        let speed = (2.0 * energy / mass).sqrt();
        let pressed = get(Quantity::Pressure).zip(self.area());
        let effectiveness = self.sheet.get(Quantity::Effectiveness).unwrap_or(EFFECTIVE);
        let of_stroke = get(Quantity::Stroke).map(|stroke| energy / stroke);
        let force = match (get(Quantity::Frequency), pressed) {
            (Some(frequency), _) => 2.5 * mass * speed * frequency,
            (None, Some((pressure, area))) => effectiveness * pressure * area,
            (None, None) => of_stroke.unwrap_or(self.own.parameters.drive.amplitude),
        };
        let force = force.max(1.5 * mass * self.own.parameters.gravity.abs());
        let energy = if get(Quantity::BlowEnergy).is_some() || of_stroke.is_none() {
            energy
        } else {
            force * get(Quantity::Stroke).unwrap_or_default()
        };
        Unknowns { force, lift: 0.42 * energy / force, mass, effectiveness }
    }

    /// The blow of these unknowns.
    pub fn throw(&self, unknowns: &Unknowns, response: &Response) -> Throw {
        let none = Throw { energy: f64::NAN, speed: f64::NAN, height: f64::NAN, period: f64::NAN };
        unknowns.relay(self.own).throw(response.rebound).unwrap_or(none)
    }

    /// Work per time that the rock is given over what a metre of hole takes.
    pub fn rate(&self, energy: f64, period: f64, share: f64) -> f64 {
        let mut p = self.own.parameters;
        p.hole.diameter = self.sheet.get(Quantity::BitDiameter).unwrap_or(p.hole.diameter);
        share * energy / period / p.work_per_length()
    }

    /// What a number would be; `None` of what nothing follows for.
    pub fn value(&self, of: Quantity, unknowns: &Unknowns, response: &Response) -> Option<f64> {
        let throw = self.throw(unknowns, response);
        let period = throw.period * response.delay;
        let swept = |area: f64| area * throw.height / period;
        match of {
            Quantity::Pressure => Some(unknowns.force / unknowns.effectiveness / self.area()?),
            Quantity::Bore => None,
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
            Quantity::OilFlow => Some(swept(self.area()?)),
            Quantity::Effectiveness
            | Quantity::PistonLength
            | Quantity::BitMass
            | Quantity::BitDiameter
            | Quantity::DampingRatio
            // It says the rock's specific energy, and nothing of the hammer.
            | Quantity::Rate => None,
        }
    }

    /// What is known less what would be, over its error.
    fn residuals(&self, unknowns: &Unknowns, response: &Response) -> DVector<f64> {
        let known = self.sheet.known.iter().filter_map(|(quantity, given)| {
            let value = self.value(*quantity, unknowns, response)?;
            Some(math::ln(given / value) / quantity.error())
        });
        let drive = self.sheet.get(Quantity::Effectiveness).map(|value| (value, CERTAIN));
        let drive = drive.or(self.assumed.then_some((EFFECTIVE, UNSURE)));
        let drive = drive.filter(|_| self.has_pressure());
        let drive = drive.map(|(value, error)| math::ln(value / unknowns.effectiveness) / error);
        DVector::from_vec(known.chain(drive).collect())
    }

    /// Force, stroke and mass, and with pressure and bore the effectiveness.
    fn columns(&self) -> usize {
        if self.has_pressure() { 4 } else { 3 }
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

    fn is_enough(&self) -> bool {
        let jacobian = self.jacobian(&self.start(), &Response::GUESS);
        if jacobian.nrows() < self.columns() {
            return false;
        }
        let beside = jacobian.col_piv_qr().r().diagonal().abs();
        beside.min() > RANK * beside.max()
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
                "{:.4} N do not lift a piston of {:.4} kg",
                best.force, best.mass
            )));
        }
        Ok(best)
    }
}
