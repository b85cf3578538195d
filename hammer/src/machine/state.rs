//! The dynamic state of a scene: everything that a restart needs and cannot recompute.

use super::blows::MAX_STEP_BLOWS;
use super::exchange::Exchange;
use super::{History, Machine, ROUNDED};
use crate::air::Air;
use crate::allowance::Allowance;
use crate::energy::peaks::PeakSearch;
use crate::error::{CorruptState, Error};
use crate::motion::state::{Anchor, MotionState};
use crate::numerics::instant::Double;
use crate::quantities::inputs::Input;
use crate::quantities::parameters::{Parameters, Source};
use crate::scene::graph::Group;
use serde::{Deserialize, Serialize};

/// Dynamic state of a scene, to be stored, serialised and [restored](crate::Machine::restore).
///
/// ```
/// let mut hammer = hammer::Scene::default().machine()?;
/// hammer.advance(0.1)?;
/// let state = hammer.state();
/// hammer.advance(0.2)?;
/// let later = *hammer.kinematics();
///
/// hammer.restore(&state)?;
/// assert_eq!(hammer.time(), 0.1);
/// hammer.advance(0.2)?;
/// assert_eq!(*hammer.kinematics(), later); // identical to the last binary digit
/// # Ok::<(), hammer::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Parameters, with the present tunable values.
    pub(crate) parameters: Parameters,
    /// The motion at the last event.
    pub(crate) motion: MotionState,
    /// Sums, counts and records since the start.
    pub(crate) history: History,
    /// State of the exchange of inputs with the host.
    pub(crate) exchange: Exchange,
}

impl State {
    /// Number of the stored layout. It is raised whenever a field is added, dropped, moved or changes its meaning.
    pub const FORMAT: u32 = 7;

    /// Parameters, with the present tunable values.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Present value of an input.
    pub(crate) fn input(&self, input: Input) -> f64 {
        let acting = || self.motion.inputs.of(input).at(self.motion.now);
        self.exchange.value(input).unwrap_or_else(acting)
    }

    /// The state without the parts that depend on the host's communication steps. It is equal for runs that were
    /// divided into different steps.
    #[must_use]
    pub fn without_step(mut self) -> Self {
        self.history.peaks = PeakSearch::default();
        self.history.blows.step.clear();
        self.history.recorder.iter_mut().for_each(|recorder| recorder.collected = None);
        self.exchange = Exchange::default();
        self
    }

    /// The state with another present, `time` (s), after the last event and before the next. The motion itself stays
    /// the same.
    #[must_use]
    pub fn looked_at(&self, time: f64) -> Self {
        let mut state = self.clone();
        state.motion.now = state.motion.epoch.until(time);
        state.motion.time = time;
        state
    }
}

/// Relative rounding by which the host's time of an event may differ from the event's own.
const TIME_ROUNDING: f64 = 1e-12;

impl State {
    /// Refuses a corrupt state. Its bytes may come from anywhere, and reading them must not start an endless search.
    ///
    /// # Errors
    /// [`Error::Corrupt`].
    pub(crate) fn check(&self) -> Result<(), Error> {
        let Self { motion, parameters, history, .. } = self;
        let is_finite =
            motion.is_finite() && history.peaks.start.is_finite() && self.exchange.is_sound();
        // Some instants are stored rounded.
        let rounding = TIME_ROUNDING * (1.0 + motion.time.abs());
        let later = |instant: Double| motion.epoch.until(instant.value()) > rounding;
        let mut instants = history.blows.instants().chain([history.zeno.burst_start]);
        let lag = motion.epoch.until(motion.time) - motion.now;
        // Only the anchor of a lone piston may lie before the epoch.
        let ahead = |a: &Anchor| {
            a.start().0 > a.at || a.at > 0.0 || a.at != 0.0 && a.group != Group::PISTON
        };
        let strange = |a: &Anchor| a.driven.slow.iter().any(|(index, _)| *index >= a.z.len());
        // Only varying loads need a series, which is renewed when it ends.
        let still = motion.loads.iter().all(|load| load.is_constant());
        let ended = |reach: f64| still || reach <= 0.0 || reach < motion.now;
        let series = |a: &Anchor| a.driven.reach.is_some_and(ended);
        let is_air = parameters.drive.source == Source::Air;
        let sound = |air: &Air| {
            air.window.is_none() == air.vented.is_some()
                && (motion.mode.vented && !air.shut) == air.vented.is_some()
                && air.is_sound(motion.now)
        };
        let no_air = motion.air.is_some() != is_air || !motion.air.as_deref().is_none_or(sound);
        let checks = [
            (!is_finite, CorruptState::NotFinite),
            (instants.any(later) || motion.now < 0.0 || lag.abs() > rounding, CorruptState::Times),
            (!(0.0..=motion.now).contains(&history.peaks.start), CorruptState::Step),
            (motion.anchors.iter().any(ahead), CorruptState::Ahead),
            (motion.anchors.iter().any(strange), CorruptState::Coordinates),
            (motion.anchors.iter().any(series), CorruptState::Series),
            (no_air, CorruptState::Air),
            (!motion.line.is_sound(parameters, motion.mode, motion.now), CorruptState::Series),
            (history.blows.step.len() > MAX_STEP_BLOWS, CorruptState::Blows),
            (history.counters.are_too_many() || history.zeno.is_overrun(), CorruptState::Counts),
        ];
        match checks.into_iter().find(|(is_so, _)| *is_so) {
            Some((_, what)) => Err(Error::Corrupt { what }),
            None => Ok(()),
        }
    }
}

impl Machine {
    /// The whole dynamic state.
    pub fn state(&self) -> State {
        let mut history = self.history.clone();
        history.counters.basis_changes = self.motion.basis_changes;
        let (parameters, motion) = (*self.parameters(), self.motion.state.clone());
        State { parameters, motion, history, exchange: self.exchange.clone() }
    }

    /// Continues from a state of a scene with the same parameters and dimensions. The motion is identical to the last
    /// binary digit.
    ///
    /// The search is repeated from the last event to the present. If it finds an event there, the state was altered,
    /// since an unaltered one would have ended at that event.
    ///
    /// # Errors
    ///
    /// The state belongs to other parameters or dimensions, or is corrupt; [`Error::Overwork`] or
    /// [`Error::Cancelled`] of that search. Nothing is changed then.
    pub fn restore(&mut self, state: &State) -> Result<(), Error> {
        state.check()?;
        let (before, failure) = (self.state(), self.failure.take());
        let allowance = Allowance::of_seconds(state.parameters.work_limit);
        let restored = self.adopt(state).and_then(|()| allowance.within(|| self.search_again()));
        if restored.is_err() {
            self.adopt(&before)?;
            self.failure = failure;
        }
        restored
    }

    /// Replaces the state without checks.
    fn adopt(&mut self, state: &State) -> Result<(), Error> {
        let counters = &state.history.counters;
        self.motion.restore(&state.parameters, &state.motion, counters.basis_changes)?;
        self.history.clone_from(&state.history);
        self.exchange = state.exchange.clone();
        self.restart_search();
        Ok(())
    }

    /// Repeats the search of a replaced state up to the present.
    fn search_again(&mut self) -> Result<(), Error> {
        let (now, reach) = (self.motion.state.now, self.motion.reach());
        if reach < now - ROUNDED {
            return Err(Error::Corrupt { what: CorruptState::Series });
        }
        self.search.budget.begin_step(&self.motion, &self.search.work);
        match self.search.next(&mut self.motion, now.min(reach))? {
            Some((at, _)) if at < now => Err(Error::Corrupt { what: CorruptState::Passed }),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::machine::blows::Blow;
    use crate::machine::zeno::MAX_BURST;
    use crate::numerics::poly::Poly;
    use crate::quantities::parameters::InputValues;

    /// The expected outcome of an alteration.
    type Case<Outcome, T> = (Outcome, fn(&mut T));

    /// A state in the flight after the first blow, in the middle of a step.
    fn flying(source: Source) -> State {
        let mut parameters = Parameters::default();
        parameters.drive.source = source;
        let mut machine = Machine::new(&parameters, &InputValues::default(), 0.0).expect("a scene");
        for time in [0.0301, 0.0302] {
            machine.advance(time).expect("a step");
        }
        let state = machine.state();
        assert!(0.0 < state.history.peaks.start && state.history.peaks.start < state.motion.now);
        assert_eq!((state.check(), state.motion.anchors.len()), (Ok(()), 2));
        state
    }

    fn refused(state: &State, alter: impl Fn(&mut State)) -> Option<CorruptState> {
        let mut altered = state.clone();
        alter(&mut altered);
        match altered.check() {
            Err(Error::Corrupt { what }) => Some(what),
            other => other.map(|()| None).expect("no other error"),
        }
    }

    /// Alterations that no run can produce are refused by name. Values just within the bounds are accepted.
    #[test]
    fn each_part_of_a_state_is_refused_beyond_its_own_bounds() {
        use CorruptState as Is;
        let cases: [Case<Option<Is>, State>; 29] = [
            (Some(Is::NotFinite), |s| s.motion.psi = f64::NAN),
            (Some(Is::NotFinite), |s| s.history.peaks.start = f64::NAN),
            (None, |s| s.motion.time += 0.5 * TIME_ROUNDING),
            (Some(Is::Times), |s| s.motion.time += 2.0 * TIME_ROUNDING),
            (Some(Is::Times), |s| s.motion.time -= 2.0 * TIME_ROUNDING),
            (Some(Is::Times), |s| {
                s.motion.now = -1e-9;
                s.motion.time = s.motion.epoch.value() - 1e-9;
            }),
            (None, |s| s.history.zeno.burst_start = s.motion.epoch),
            (Some(Is::Times), |s| s.history.zeno.burst_start.move_by(1.0)),
            (Some(Is::Times), |s| s.history.blows.opened = Some(Double::new(s.motion.time + 1.0))),
            (None, |s| s.history.peaks.start = 0.0),
            (None, |s| s.history.peaks.start = s.motion.now),
            (Some(Is::Step), |s| s.history.peaks.start = -1e-9),
            (Some(Is::Step), |s| s.history.peaks.start = s.motion.now + 1e-9),
            (None, |s| s.motion.anchors[1].at -= 1e-6),
            (Some(Is::Ahead), |s| s.motion.anchors[1].at = 1e-6),
            (None, |s| s.motion.anchors[0].began = Some((-1e-6, Vec::new()))),
            (Some(Is::Ahead), |s| s.motion.anchors[0].began = Some((1e-6, Vec::new()))),
            (Some(Is::Ahead), |s| s.motion.anchors[0].at = -1e-6),
            (None, |s| slow(s, -1)),
            (Some(Is::Coordinates), |s| slow(s, 0)),
            (Some(Is::Series), |s| s.motion.anchors[0].driven.reach = Some(1.0)),
            (None, |s| series(s, 1.0)),
            (Some(Is::Series), |s| series(s, -1.0)),
            (Some(Is::Series), |s| series(s, 0.5 * s.motion.now)),
            (None, |s| s.history.blows.step.resize(MAX_STEP_BLOWS, Blow::default())),
            (Some(Is::Blows), |s| s.history.blows.step.resize(MAX_STEP_BLOWS + 1, Blow::default())),
            (None, |s| s.history.counters.events = 1 << 53),
            (Some(Is::Counts), |s| s.history.counters.events = (1 << 53) + 1),
            (Some(Is::Counts), |s| s.history.zeno.burst = MAX_BURST),
        ];
        let state = flying(Source::Relay);
        for (index, (what, alter)) in cases.into_iter().enumerate() {
            assert_eq!(refused(&state, alter), what, "{index}");
        }
    }

    /// Adds a quasi-static series for the coordinate that is `after` places behind the last one.
    fn slow(state: &mut State, after: isize) {
        let anchor = &mut state.motion.anchors[0];
        let coordinate = anchor.z.len().saturating_add_signed(after);
        anchor.driven.slow.push((coordinate, Poly::default()));
    }

    /// Adds a varying load's series that is valid up to this instant, s.
    fn series(state: &mut State, reach: f64) {
        state.motion.loads[0].0[1] = 1.0;
        state.motion.anchors[0].driven.reach = Some(reach);
    }

    #[test]
    fn a_state_of_the_air_is_refused_beyond_its_own_bounds() {
        let air: [Case<bool, (Air, f64)>; 15] = [
            (true, |(air, now)| air.window.as_mut().expect("a window").reach = *now),
            (false, |(air, now)| air.window.as_mut().expect("a window").reach = 0.5 * *now),
            (false, |(air, _)| {
                let window = air.window.as_mut().expect("a window");
                window.reach = 1.5 * window.length;
            }),
            (false, |(air, _)| air.window.as_mut().expect("a window").place[1] = f64::NAN),
            (false, |(air, _)| air.window.as_mut().expect("a window").push[1][0] = f64::NAN),
            (false, |(air, _)| air.window.as_mut().expect("a window").length = f64::INFINITY),
            (false, |(air, _)| air.content[2] = 0.0),
            (false, |(air, _)| air.content[0] = f64::INFINITY),
            (false, |(air, _)| air.sums.mass = f64::NAN),
            (false, |(air, _)| air.sums.enthalpy = f64::NAN),
            (false, |(air, _)| air.sums.work = f64::NAN),
            (false, |(air, _)| air.energy_start = f64::NAN),
            (false, |(air, _)| air.window = None),
            (false, |(air, _)| air.vented = Some([0.0; 2])),
            (false, |(air, _)| (air.window, air.vented) = (None, Some([0.0; 2]))),
        ];
        let (relay, aired) = (flying(Source::Relay), flying(Source::Air));
        let expected = |is_sound: bool| (!is_sound).then_some(CorruptState::Air);
        for (index, (is_sound, alter)) in air.into_iter().enumerate() {
            let alter = |s: &mut State| {
                let mut altered = (*s.motion.air.take().expect("air"), s.motion.now);
                alter(&mut altered);
                s.motion.air = Some(Box::new(altered.0));
            };
            assert_eq!(refused(&aired, alter), expected(is_sound), "air {index}");
        }
        // The mode alone says vented; the drive needs air and there is none; there is air but no drive uses it.
        assert_eq!(refused(&aired, |s| s.motion.mode.vented = true), expected(false));
        assert_eq!(refused(&aired, |s| s.motion.air = None), expected(false));
        let air = aired.motion.air.clone();
        assert_eq!(refused(&relay, |s| s.motion.air.clone_from(&air)), expected(false));
    }
}
