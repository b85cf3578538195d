//! How a parameter changes the scene: bodies, springs, loads, laws.
//!
//! A body enters the motion by the squared frequencies of its free modes, its mass and the
//! modes' amplitudes at its ends; nothing else of a parameter is felt. A tangent is carried
//! as `dx_i / a_i`, where `x_i = a_i q_i` is the motion of a mode at the body's upper end and
//! `a_i` its amplitude there: then displacements have the coefficients that they always had,
//! and a change of amplitude shows where forces act, `2 (d ln a_i)` times the force. Of a body
//! whose sections change one by one `reshape` has the like.

use crate::laws::mode::Relay;
use crate::laws::rock::Spring;
use crate::modal::model::Model;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::{Fidelity, Parameters, Rock, Source};
use crate::quantities::sections::Body;
use crate::tangent::reshape::Reshape;
use crate::tangent::seed::{Dimension, Parameter, Seed};
use std::sync::Arc;

/// The derivative of a scene by one parameter. Modes are the piston's, then the bit's.
#[derive(Clone, Debug)]
pub(crate) struct Change {
    /// Of the squared frequencies; empty if none.
    pub stiffness: Vec<f64>,
    /// Of `beta omega^2`; empty if none.
    pub damping: Vec<f64>,
    /// Of the logarithms of the end amplitudes; empty if none.
    pub amplitude: Vec<f64>,
    /// Of a body of several sections, by one of them.
    pub reshape: Option<Arc<Reshape>>,
    /// Of the masses of piston and bit.
    pub masses: [f64; 2],
    /// Of the stiffness through which the bodies meet.
    pub contact: f64,
    /// Of stiffness and viscosity of each spring.
    pub springs: [[f64; 2]; 4],
    /// Of the law's numbers.
    pub rock: Rock,
    /// Of `F0`, the two areas and `D1`.
    pub relay: f64,
    pub areas: [f64; 2],
    pub stroke: f64,
    /// Of `G`, `g0`, the piston's velocity at the start.
    pub gravity: f64,
    pub gap: f64,
    pub velocity: f64,
    /// Of the inputs, after the epoch.
    pub inputs: Inputs,
}

impl Change {
    pub(crate) fn of(seed: Seed, model: &Model) -> Self {
        let mut change = Self::none();
        match seed {
            Seed::State => {}
            Seed::Input(input, order) => {
                let mut derivatives = vec![0.0; order + 1];
                derivatives[order] = 1.0;
                change.inputs.0[input as usize] = Poly::taylor(&derivatives);
            }
            Seed::Parameter(parameter) => change.set(parameter, model),
        }
        for spring in Spring::ALL {
            let (rock, d) = (&model.parameters.rock, &change.rock);
            change.springs[spring as usize] = match spring {
                Spring::Free => [0.0; 2],
                Spring::Loading => [d.stiffness, 0.0],
                Spring::Viscous => [d.stiffness, d.viscosity],
                Spring::Unloading => {
                    let both = d.unloading_ratio * rock.stiffness;
                    [both + rock.unloading_ratio * d.stiffness, 0.0]
                }
            };
        }
        change
    }

    fn none() -> Self {
        Self {
            stiffness: Vec::new(),
            damping: Vec::new(),
            amplitude: Vec::new(),
            reshape: None,
            masses: [0.0; 2],
            contact: 0.0,
            springs: [[0.0; 2]; 4],
            rock: Rock {
                stiffness: 0.0,
                unloading_ratio: 0.0,
                viscosity: 0.0,
                energy_barrier: 0.0,
                standstill_speed: 0.0,
                standstill_penetration: 0.0,
                specific_energy: 0.0,
                reloading: crate::quantities::parameters::Reloading::Loading,
            },
            relay: 0.0,
            areas: [0.0; 2],
            stroke: 0.0,
            gravity: 0.0,
            gap: 0.0,
            velocity: 0.0,
            inputs: Inputs([Poly::default(); 4]),
        }
    }

    fn set(&mut self, parameter: Parameter, model: &Model) {
        let p = &model.parameters;
        // A body with sections of its own reads neither its length nor the common section.
        let uniform = [p.piston.segments == 0, p.bit.segments == 0].map(|u| f64::from(u8::from(u)));
        match parameter {
            Parameter::YoungsModulus => {
                self.bodies(model, [1.0 / p.material.youngs_modulus; 2], [0.0; 2]);
                self.meet(p, 1.0 / p.material.youngs_modulus);
            }
            Parameter::Density => {
                let rate = 1.0 / p.material.density;
                self.bodies(model, [-rate; 2], [rate; 2]);
            }
            Parameter::DampingTime => {
                let modes = model.piston.omega2.iter().chain(&model.bit.omega2);
                self.damping = modes.copied().collect();
            }
            Parameter::CrossSection => {
                let rate = 1.0 / p.cross_section;
                let rates = uniform.map(|u| u * rate);
                self.bodies(model, [0.0; 2], rates);
                self.meet(p, collided(p, rates, [0.0; 2]));
            }
            Parameter::PistonLength => {
                let rate = uniform[0] / p.piston.length;
                self.bodies(model, [-2.0 * rate, 0.0], [rate, 0.0]);
                self.meet(p, collided(p, [rate, 0.0], [uniform[0], 0.0]));
            }
            Parameter::BitLength => {
                let rate = uniform[1] / p.bit.length;
                self.bodies(model, [0.0, -2.0 * rate], [0.0, rate]);
                self.meet(p, collided(p, [0.0, rate], [0.0, uniform[1]]));
            }
            Parameter::PistonVelocity => self.velocity = 1.0,
            Parameter::ContactStiffness => {
                let part = model.contact / p.contact.stiffness;
                self.contact = part * part;
            }
            Parameter::InitialGap => self.gap = 1.0,
            Parameter::RockStiffness => self.rock.stiffness = 1.0,
            Parameter::UnloadingRatio => self.rock.unloading_ratio = 1.0,
            Parameter::RockViscosity => self.rock.viscosity = 1.0,
            Parameter::EnergyBarrier => self.rock.energy_barrier = 1.0,
            Parameter::StandstillSpeed => self.rock.standstill_speed = 1.0,
            Parameter::StandstillPenetration => self.rock.standstill_penetration = 1.0,
            Parameter::DriveAmplitude => self.relay = 1.0,
            Parameter::DriveStroke => self.stroke = 1.0,
            Parameter::AreaDrive => self.areas[0] = 1.0,
            Parameter::AreaReturn => self.areas[1] = 1.0,
            Parameter::Gravity => self.gravity = 1.0,
            Parameter::Section(body, place, dimension) => {
                if parameter.is_read(p) {
                    self.section(model, body, place as usize, dimension);
                }
            }
        }
    }

    /// One section of a body is made longer or thicker.
    fn section(&mut self, model: &Model, body: Body, index: usize, dimension: Dimension) {
        let p = &model.parameters;
        let sections = p.sections(body);
        let section = sections.as_slice()[index];
        let (own, other, square, longer) = match dimension {
            Dimension::Length => (section.length, section.area, -2.0, 1.0),
            Dimension::Area => (section.area, section.length, 0.0, 0.0),
        };
        let bar = if body == Body::Piston { &model.piston } else { &model.bit };
        let heavier = p.material.density * other / bar.mass;
        let only = |x: f64| if body == Body::Piston { [x, 0.0] } else { [0.0, x] };
        let made = Reshape::of(model, body, index, dimension).map(Arc::new);
        if let Some(reshape) = made.filter(|_| sections.as_slice().len() > 1) {
            self.masses = only(heavier * bar.mass);
            self.reshape = Some(reshape);
        } else {
            // All of the body is the one section, or it does not strain.
            self.bodies(model, only(square / own), only(heavier));
        }
        self.meet(p, collided(p, only(heavier), only(longer)));
    }

    /// Bars whose squared frequencies and masses change at these relative rates.
    fn bodies(&mut self, model: &Model, squares: [f64; 2], masses: [f64; 2]) {
        let beta = model.parameters.material.damping_time;
        for (body, (bar, square)) in
            [&model.piston, &model.bit].into_iter().zip(squares).enumerate()
        {
            self.masses[body] = masses[body] * bar.mass;
            self.stiffness.extend(bar.omega2.iter().map(|w2| square * w2));
            self.damping.extend(bar.omega2.iter().map(|w2| beta * square * w2));
            self.amplitude.extend(bar.omega2.iter().map(|_| -0.5 * masses[body]));
        }
        if masses == [0.0; 2] {
            self.amplitude.clear();
        }
        if squares == [0.0; 2] {
            (self.stiffness, self.damping) = Default::default();
        }
    }

    /// Rigid bodies' own compliance, of which `ln k` changes by `rate`.
    fn meet(&mut self, p: &Parameters, rate: f64) {
        if p.fidelity == Fidelity::Rigid {
            // m = 1 / (1/KC + 1/k), dm = m^2 / k^2 dk = m (1 - m / KC) d ln k.
            let m = p.meeting_stiffness();
            self.contact = m * (1.0 - m / p.contact.stiffness) * rate;
        }
    }

    /// Derivatives of the loads.
    pub(crate) fn loads(&self, p: &Parameters, inputs: &Inputs, relay: Relay) -> [Poly; 3] {
        let (d, drive) = (&self.inputs, &p.drive);
        let force = match drive.source {
            Source::Relay => Poly::constant(relay.sign() * self.relay),
            Source::Force => *d.of(Input::DriveForce),
            Source::Pressure => Poly::default()
                .plus(drive.area_drive, d.of(Input::DrivePressure))
                .plus(-drive.area_return, d.of(Input::ReturnPressure))
                .plus(self.areas[0], inputs.of(Input::DrivePressure))
                .plus(-self.areas[1], inputs.of(Input::ReturnPressure)),
            // Refused: `Tangents::from_here`.
            Source::Chambers => Poly::default(),
        };
        [force, *d.of(Input::FeedForce), Poly::constant(self.gravity)]
    }
}

/// `d ln k` of the rigid bodies' own compliance, `pi^2 mu / T^2`, where the logarithms of their
/// masses and their lengths change at these rates.
fn collided(p: &Parameters, masses: [f64; 2], lengths: [f64; 2]) -> f64 {
    if p.fidelity == Fidelity::Elastic {
        return 0.0;
    }
    let (mp, mb) = (p.piston_mass(), p.bit_mass());
    let rates = p.collision_rates().0;
    // mu / mp and mu / mb.
    let reduced = (mb * masses[0] + mp * masses[1]) / (mp + mb);
    reduced - 2.0 * (rates[0] * lengths[0] + rates[1] * lengths[1])
}
