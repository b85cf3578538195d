//! Advances a machine and checks it on the way: bounded work, signs, monotone losses, balanced energy and momentum.

use crate::comparison::bodies;
use hammer::RockMode;
use hammer::{Body, Energies, Error, Input, InputValues, Machine, Parameters, Source};

/// How negative a force may be where a guard cannot decide: `k` times the displacement and `c` times the velocity
/// below which a crossing does not count. `meeting` is the stiffness of the contact, N/m.
fn force_floor(p: &Parameters, meeting: f64) -> [f64; 2] {
    let [displacement, velocity] = p.resolutions();
    let rock = &p.rock;
    // Twice: for the guard's level, and for the rounding of the state.
    [
        2.0 * meeting * displacement,
        2.0 * (rock.unloading_ratio * rock.stiffness * displacement + rock.viscosity * velocity),
    ]
}

/// Relative rounding at an event, which multiplies the state by two bases, with rows of `2 n` products.
fn rounding(p: &Parameters) -> f64 {
    let modes = match p.fidelity {
        hammer::Fidelity::Rigid => 2,
        hammer::Fidelity::Elastic => bodies::unknowns(p),
    };
    8.0 * modes as f64 * f64::EPSILON
}

/// Rounding of the energy balance. At each event ([`rounding`]) each product has an error relative to the energy in
/// play: the ledger's turnover, each load times the positions whose difference is its displacement, and each spring's
/// force times the positions whose difference is its length. The dashpot's work is a difference of waves `CR / Z`
/// times as large.
fn energy_bound(p: &Parameters, meeting: f64, events: u64, energies: &Energies, reach: f64) -> f64 {
    let mismatch = 1.0 + p.rock.viscosity / bodies::least_impedance(p);
    let play = energies.turnover() + reach;
    let rounding = rounding(p) * play * mismatch;
    // A transition may also be late by the resolution of its guard. At the start of drilling, the tip's distance from
    // the loading line is `gamma` times that from the unloading line.
    let [late, _] = p.resolutions();
    let chuck = if p.has_casing() { p.chuck.stiffness } else { 0.0 };
    let rock = p.rock.unloading_ratio.powi(2) * p.rock.stiffness;
    let springs = meeting + rock + chuck;
    (rounding + springs * late * late) * (events + 1) as f64
}

/// Why a monitored run was stopped.
#[derive(Debug, thiserror::Error)]
pub enum Violation {
    /// The engine returned an error.
    #[error(transparent)]
    Engine(#[from] Error),
    /// A number that must not occur.
    #[error("{what} at t = {time} s: {value:e}, allowed {allowed:e}")]
    Wrong {
        /// Its meaning.
        what: &'static str,
        /// When.
        time: f64,
        /// The number.
        value: f64,
        /// The allowed number.
        allowed: f64,
    },
}

/// A monitored machine.
pub struct Monitored {
    /// The machine.
    pub machine: Machine,
    allowed: u64,
    /// Stiffness through which the bodies meet, N/m. For stepped rigid bodies the engine follows waves to find it.
    meeting: f64,
    /// Of the casing at the start, m.
    place: f64,
    /// The largest position of a body, or displacement of the static shape that oscillation is measured from, m.
    place_scale: f64,
    play: f64,
    reach: f64,
    push: f64,
    losses: [f64; 4],
}

impl Monitored {
    /// A scene that may take `allowed` samples.
    pub fn new(p: &Parameters, inputs: &InputValues, allowed: u64) -> Result<Self, Violation> {
        let mut machine = Machine::new(p, inputs, 0.0)?;
        machine.keep_journal(true);
        let losses = [f64::NEG_INFINITY; 4];
        let place = machine.kinematics().casing.displacement;
        let (meeting, [place_scale, play, reach, push]) = (p.meeting_stiffness(), [0.0; 4]);
        Ok(Self { machine, allowed, meeting, place, place_scale, play, reach, push, losses })
    }

    /// Advances by `span` in `slices`, and checks after each.
    ///
    /// # Errors
    /// The first violation.
    pub fn run(&mut self, span: f64, slices: u32) -> Result<(), Violation> {
        let from = self.machine.time();
        for k in 1..=slices {
            self.machine.advance(from + span * f64::from(k) / f64::from(slices))?;
            self.observe()?;
        }
        self.momentum()
    }

    /// Internal forces cancel in pairs, so the momentum of all bodies (of a bare hammer, whose drive pushes against an
    /// outside holder, that of what is struck) is the impulse of feed, gravity, rock and string. Each event makes two
    /// roundings of these sums, and a basis loses up to 1e5 of them at a transition. The impulse of a spring is also
    /// rounded as its length is, for as long as it acts, and that of a dashpot as its shortening is: both are
    /// differences of the largest positions.
    fn momentum(&self) -> Result<(), Violation> {
        let (m, p) = (&self.machine, self.machine.parameters());
        let (k, sums, time) = (m.kinematics(), m.impulses(), m.time());
        // The string takes the impulse of its end's motion, which for an elastic casing is not an output, and neither
        // is the impulse of a pressure on the bit.
        let is_hidden = p.casing.impedance > 0.0 && p.is_elastic(Body::Casing);
        if is_hidden || !matches!(p.drive.source, Source::Relay | Source::Force) {
            return Ok(());
        }
        let mut terms = vec![
            m.input(Input::FeedForce) * time,
            p.bit_mass() * p.gravity * time,
            -p.bit_mass() * k.bit.velocity,
            -sums.rock,
        ];
        if p.has_casing() {
            let piston = p.piston.initial_velocity + p.gravity * time - k.piston.velocity;
            terms.push(p.piston_mass() * piston);
            terms.push(p.casing_mass() * (p.gravity * time - k.casing.velocity));
            terms.push(-p.casing.impedance * (k.casing.displacement - self.place));
        } else {
            terms.push(sums.contact);
        }
        let (value, scale) =
            terms.iter().fold((0.0, 0.0), |(sum, size), x| (sum + x, size + x.abs()));
        let events = m.counters().events as f64;
        let springs = self.meeting + p.rock.unloading_ratio * p.rock.stiffness;
        let lengths = (springs * time + p.rock.viscosity) * self.place_scale;
        let allowed =
            1e5 * f64::EPSILON * (10.0 + events) * scale + rounding(p) * (1.0 + events) * lengths;
        let what = "momentum that nothing gave";
        if value.abs() > allowed {
            Err(Violation::Wrong { what, time, value, allowed })
        } else {
            Ok(())
        }
    }

    /// Checks the present instant.
    ///
    /// # Errors
    /// The first violation.
    pub fn observe(&mut self) -> Result<(), Violation> {
        let time = self.machine.time();
        let counters = self.machine.counters();
        let wrong = |what, value, allowed| Err(Violation::Wrong { what, time, value, allowed });
        if counters.samples > self.allowed {
            return wrong("samples", counters.samples as f64, self.allowed as f64);
        }
        let (k, e) = (*self.machine.kinematics(), self.machine.energies());
        let p = *self.machine.parameters();
        let (meeting, floor) = (self.meeting, force_floor(&p, self.meeting));
        // The rounding of a guard's value is that of its amplitudes, which may cancel.
        let reach = f64::EPSILON * (k.piston.displacement.abs() + k.bit.displacement.abs());
        if k.contact_force < -floor[0] - 64.0 * meeting * reach {
            return wrong("contact force", k.contact_force, -floor[0]);
        }
        let free = self.machine.mode().rock == RockMode::FreeFlight;
        if !free && k.rock_force < -floor[1] {
            return wrong("rock force", k.rock_force, -floor[1]);
        }
        let input = |i| self.machine.input(i).abs();
        let load = k.applied_drive_force.abs() + input(Input::FeedForce);
        let weight = (p.piston_mass() + p.bit_mass()) * p.gravity.abs();
        let way = k.piston.displacement.abs() + k.bit.displacement.abs() + p.contact.initial_gap;
        // The largest observed so far, since energy may have left.
        let loads = load + weight;
        // Oscillation is measured from the static shape, which is displaced by the compliance of springs and bars;
        // the position is their difference.
        let bars = bodies::compliance(&p);
        let yielded = loads * (1.0 / p.rock.stiffness + 1.0 / meeting + bars);
        self.place_scale = self.place_scale.max(way + yielded);
        // A spring's length is a difference of rounded positions, measured from the hole.
        let (before, hole) = (self.reach, k.tip_depth);
        let piston = k.piston.displacement - p.contact.initial_gap - hole;
        self.reach = piston.abs() + (k.bit.displacement - hole).abs();
        let peaks = self.machine.peaks();
        self.push = self.push.max(peaks.rock_force());
        let springs = (peaks.contact_force() + peaks.rock_force()) * before.max(self.reach);
        self.play = self.play.max(loads * (way + yielded) + springs + e.turnover());
        let bound = energy_bound(&p, meeting, counters.events, &e, self.play);
        let losses = [k.tip_depth, e.rock_dissipated, e.viscous, e.damping];
        // A hole never becomes shallower, except by the resolution of the turn that sets its depth: a tip may creep
        // back at less than the resolution of its speed.
        let creep = p.resolutions()[1] * time * self.push;
        let slack = [1e-13 + 8.0 * reach, bound + creep, bound, bound];
        let names = ["hole depth falls", "rock loss falls", "viscous loss falls", "damping falls"];
        for i in 0..4 {
            if losses[i] < self.losses[i] - slack[i] {
                return wrong(names[i], losses[i] - self.losses[i], -slack[i]);
            }
            self.losses[i] = self.losses[i].max(losses[i]);
        }
        if e.residual.is_nan() || e.residual.abs() > bound {
            return wrong("energy residual", e.residual, bound);
        }
        Ok(())
    }
}
