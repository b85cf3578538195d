//! Outputs of a machine, computed on demand and cached for the present instant.

use super::Machine;
use super::blows::{Blow, PATIENCE};
use super::journal::Counters;
use super::outputs::{Kinematics, Profile};
use crate::air::{Air, Places};
use crate::energy::interval::Interval;
use crate::energy::ledger::{Energies, Impulses};
use crate::energy::peaks::Peaks;
use crate::error::Error;
use crate::laws::event::Event;
use crate::laws::mode::Relay;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::Source;
use crate::quantities::warnings;
#[cfg(feature = "internals")]
use crate::{modal::track::Track, search::signal::Signal};
use std::collections::VecDeque;
use std::sync::OnceLock;

/// Number of first blows after which the means are representative of the hammer.
const FIRST: u64 = 3;

/// Outputs already computed for the present instant.
#[derive(Debug, Default)]
pub(super) struct Views {
    pub(super) kinematics: OnceLock<Kinematics>,
    pub(super) ledger: OnceLock<(Energies, Impulses)>,
    pub(super) powers: OnceLock<Energies>,
    pub(super) peaks: OnceLock<Result<Peaks, Error>>,
}

/// Longest time before the first blow of a hammer that is not stalled, s.
const LONGEST_START: f64 = 1.0;

impl Views {
    /// Forgets all outputs without overwriting them, since the values are large.
    pub(super) fn forget(&mut self) {
        drop((self.kinematics.take(), self.ledger.take(), self.powers.take(), self.peaks.take()));
    }
}

impl Machine {
    /// Motion and forces now.
    pub fn kinematics(&self) -> &Kinematics {
        self.views.kinematics.get_or_init(|| Kinematics::of(&self.motion))
    }

    /// Displacements and velocities along the bodies now.
    pub fn profile(&self) -> Profile {
        Profile::of(&self.motion)
    }

    /// Does the long part of reading energies and impulses, which an interrupt may end. Later reads then cost nothing.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn prepare_ledger(&self) -> Result<(), Error> {
        if self.views.ledger.get().is_some() {
            return Ok(());
        }
        self.history.ledger.prepare()?;
        let damped = self.motion.model.is_damped();
        self.motion
            .tracks
            .iter()
            .filter(|_| damped)
            .try_for_each(|track| track.system.prepare_damping_form())
    }

    /// The energy ledger now.
    pub fn energies(&self) -> Energies {
        self.ledger_now().0
    }

    /// Rates of the energies now, W.
    pub fn powers(&self) -> Energies {
        *self.views.powers.get_or_init(|| Energies::rates(&self.motion))
    }

    /// Length of hole drilled so far, m. Each part of the work counts with the specific energy of its time.
    pub fn drilled_length(&self) -> f64 {
        let work: f64 = self.present_stretch().given.iter().sum();
        self.history.blows.drilled[0] + work / self.parameters().work_per_length()
    }

    /// `psi`: viscous work of the present drilling cycle so far, J; 0 outside the viscous part of a cycle.
    pub fn viscous_work_of_cycle(&self) -> f64 {
        self.motion.state.psi + self.present_stretch().given[1]
    }

    fn present_stretch(&self) -> Interval {
        let tracks = self.motion.present();
        Interval::whole(&self.motion, &tracks, self.motion.state.now)
    }

    /// Impulses since the start.
    pub fn impulses(&self) -> Impulses {
        self.ledger_now().1
    }

    fn ledger_now(&self) -> (Energies, Impulses) {
        *self.views.ledger.get_or_init(|| self.history.ledger.evaluated().now(&self.motion))
    }

    /// Largest forces over the last communication step; NaN where [`Self::prepare_peaks`] fails.
    pub fn peaks(&self) -> Peaks {
        self.searched_peaks().unwrap_or(Peaks::UNKNOWN)
    }

    /// Searches the largest forces. An interrupt may end the search.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::Overwork`] if the forces ring too long in one step.
    pub fn prepare_peaks(&self) -> Result<(), Error> {
        self.searched_peaks().map(drop)
    }

    fn searched_peaks(&self) -> Result<Peaks, Error> {
        if let Some(searched) = self.views.peaks.get() {
            return searched.clone();
        }
        let peaks = self.history.peaks.now(&self.motion);
        // If an interrupt ends the search early, a later read starts it again.
        if peaks == Err(Error::Cancelled) {
            peaks
        } else {
            self.views.peaks.get_or_init(|| peaks).clone()
        }
    }

    /// The blows of the last communication step in order, at most the last [`MAX_STEP_BLOWS`](crate::MAX_STEP_BLOWS).
    /// Each is the value of [`blow`](Self::blow) right after it.
    pub fn step_blows(&self) -> &VecDeque<Blow> {
        &self.history.blows.step
    }

    /// Seconds of work that the last step was charged, in the units of `work_limit`.
    #[cfg(feature = "internals")]
    pub fn seconds_charged(&self) -> f64 {
        self.search.budget.paid.get() as f64 / crate::allowance::PER_SECOND as f64
    }

    /// The counts since the start.
    pub fn counters(&self) -> Counters {
        let work = &self.search.work;
        Counters {
            basis_changes: self.motion.basis_changes,
            guard_evaluations: work.evaluations,
            samples: work.samples,
            windows: work.windows,
            scans: work.scans,
            ..self.history.counters
        }
    }

    /// The last blow; `None` before the first.
    pub fn blow(&self) -> Option<&Blow> {
        self.history.blows.milestones[1].map(|_| &self.history.blows.last)
    }

    /// Duration of the last complete collision, whether it was a blow or not, s; 0 before the first.
    pub fn contact_duration(&self) -> f64 {
        self.history.blows.last.contact_duration
    }

    /// True if the drive acts but strikes no more, for one of two reasons. Either the piston rests on the bit and,
    /// under the present loads, neither can the contact open nor the drive switch, so that the model never leaves this
    /// state. Or there was no blow for [`PATIENCE`] times as long as the wait for the last one; before the first blow,
    /// for [`LONGEST_START`].
    pub fn stalled(&self) -> bool {
        let never = |event: Event| self.search.never(&self.motion, event.rank());
        let switches = self.parameters().drive.source.switches();
        if self.mode().closed()
            && switches
            && never(Event::OPENING)
            && never(Event::Relay(Relay::Drive))
        {
            return true;
        }
        let blows = &self.history.blows;
        let patience = blows.way.wait().map_or(LONGEST_START, |wait| PATIENCE * wait);
        let waited = self.time() - blows.way.began.value().max(blows.acts_since.value());
        let force = || self.kinematics().applied_drive_force;
        waited > patience && if switches { !self.mode().vented } else { force() != 0.0 }
    }

    /// The tracks at the last event and the signals tracked from it, for comparisons.
    #[cfg(feature = "internals")]
    #[doc(hidden)]
    pub fn tracked(&self) -> (Vec<Track>, Vec<(Event, Signal)>) {
        let tracks = 0..self.motion.tracks.len();
        (tracks.map(|i| self.motion.at_anchor(i)).collect(), self.search.tracked().collect())
    }

    /// How many numbers are stored for energies and peaks that have not been read.
    #[cfg(test)]
    pub(crate) fn stored(&self) -> [usize; 2] {
        [self.history.ledger.size, self.history.peaks.size]
    }

    /// A warning if the last blow was faster than steel withstands.
    pub fn too_fast(&self) -> Option<String> {
        warnings::fast(self.blow()?.speed)
    }

    /// A warning if the hole grew faster than the bit advanced, from the first blow to the last, or if the last blow
    /// buried the inserts.
    pub fn outrun(&self) -> Option<String> {
        let blow = self.blow().filter(|_| self.counters().blows > FIRST)?;
        warnings::buried(blow.rop_mean, blow.tip_rate_mean, blow.penetration)
    }

    /// Warnings about this scene with its present inputs, its last blow, and the exchange with the host.
    pub fn warnings(&self) -> Vec<String> {
        let parameters = self.motion.parameters();
        let inputs = Inputs(Input::ALL.map(|input| Poly::constant(self.input(input))));
        let mut list = warnings::warnings(parameters);
        list.extend(warnings::idle(parameters, &inputs));
        list.extend(self.too_fast());
        list.extend(self.outrun());
        list.extend(self.exchange_warning());
        list
    }

    /// How far the piston has moved since the start, relative to the body that the drive pushes against, m.
    pub fn swept(&self) -> f64 {
        self.kinematics().relative.displacement - self.motion.state.began
    }

    /// The piston's mean relative speed over the last communication step, m/s, for a source whose work is compared.
    pub fn step_speed(&self) -> f64 {
        self.exchange.speed()
    }

    /// Pressures at the piston, with their rates (Pa, Pa/s), if a line of the drive's impedance ends there: the
    /// pressure of its wave minus the part that the impedance takes. Zeros if nothing reads pressures, and for a
    /// chamber without an area.
    pub fn line_pressures(&self) -> [[f64; 2]; 2] {
        let (drive, relative, state) =
            (self.parameters().drive, self.kinematics().relative, &self.motion.state);
        let chambers = [
            (Input::DrivePressure, drive.area_drive, -1.0),
            (Input::ReturnPressure, drive.area_return, 1.0),
        ];
        chambers.map(|(input, area, sign)| {
            if drive.source != Source::Pressure || area == 0.0 {
                return [0.0; 2];
            }
            let [wave, rate] = state.inputs.of(input).derivatives_at(state.now);
            let part = sign * drive.impedance / area;
            [wave + part * relative.velocity, rate + part * relative.acceleration]
        })
    }

    /// True if the input is added to a chamber's line pressure: its derivative by the input is then 1, otherwise 0.
    pub fn line_pressure_per(&self, input: Input, chamber: usize) -> bool {
        let drive = self.parameters().drive;
        let own =
            [(Input::DrivePressure, drive.area_drive), (Input::ReturnPressure, drive.area_return)];
        drive.source == Source::Pressure && own[chamber].0 == input && own[chamber].1 != 0.0
    }

    /// Present pressures in the drive and the return chamber, with their rates (Pa, Pa/s), for
    /// [`Source::Air`]; zeros for any other source.
    pub fn chamber_pressures(&self) -> [[f64; 2]; 2] {
        let state = &self.motion.state;
        let Some((air, motion)) = self.air() else { return [[0.0; 2]; 2] };
        if air.vented.is_some() {
            let [value, rate] = state.inputs.of(Input::ExhaustPressure).derivatives_at(state.now);
            return [[value, rate]; 2];
        }
        let outside = self.motion.outside(state.now);
        let pressures = air.pressures(self.parameters(), motion[0], state.now);
        let rates = air.rates(self.parameters(), outside, motion, state.now);
        [0, 1].map(|i| [pressures[i], rates[i]])
    }

    /// Present derivative of `applied_drive_force` with respect to an input, N per its unit, at fixed state.
    pub fn force_per(&self, input: Input) -> f64 {
        if self.has_vented_air() { 0.0 } else { self.parameters().drive.force_per(input) }
    }

    /// Present derivative of both chambers' pressures with respect to an input. Vented chambers are at the exhaust's
    /// pressure.
    pub fn chamber_pressure_per(&self, input: Input) -> f64 {
        f64::from(self.has_vented_air() && input == Input::ExhaustPressure)
    }

    fn has_vented_air(&self) -> bool {
        self.motion.air().is_some_and(|air| air.vented.is_some())
    }

    /// The air, with the piston's present positions and their rates.
    fn air(&self) -> Option<(&Air, [Places; 2])> {
        let (now, air) = (self.kinematics(), self.motion.air()?);
        let places = [now.relative.displacement, now.over_struck.displacement];
        Some((air, [places, [now.relative.velocity, now.over_struck.velocity]]))
    }

    /// Mass of air taken from the supply since the start, with its rate (kg, kg/s).
    pub fn air_mass(&self) -> [f64; 2] {
        let Some((air, motion)) = self.air() else { return [0.0; 2] };
        let now = self.motion.state.now;
        let [.., rate] = air.rates(self.parameters(), self.motion.outside(now), motion, now);
        [air.sums_at(motion[0], now).mass, rate]
    }

    /// Work of the air in both chambers since the start, `int p_d dV_d + int p_r dV_r`, J.
    pub fn air_work(&self) -> f64 {
        let now = self.motion.state.now;
        self.air().map_or(0.0, |(air, [places, _])| air.sums_at(places, now).work)
    }

    /// Error of the air's balance, J: enthalpy that came into the chambers since the start, minus their work and the
    /// energy that they gained.
    pub fn air_residual(&self) -> f64 {
        let now = self.motion.state.now;
        self.air().map_or(0.0, |(air, [places, _])| air.residual(self.parameters(), places, now))
    }
}
