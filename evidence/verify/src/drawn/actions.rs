//! Actions on a drawn scene while it runs: inputs as polynomials of orders 0 to 4, at a few instants or at every
//! communication point of a master, and retuning at any instant or at an event.

use hammer::{Error, Input, InputValues, Machine, Parameters, Source};
use oracles::scene::{self, Schedule};
use proptest::prelude::*;
use serde::{Deserialize, Serialize};

/// Factors on the five tunables.
pub type Factors = [f64; 5];

/// An action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Action {
    /// Sets an input to this value and these derivatives.
    Set(Input, Vec<f64>),
    /// Sets the tunable parameters to their start values times these factors.
    Retune(Factors),
}

/// A master that sets an input at every communication point to `mean + amplitude sin(omega t)`
/// and its true derivatives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Master {
    /// The input.
    pub input: Input,
    /// Mean and amplitude (N or Pa), and `omega` times the communication step.
    pub wave: [f64; 3],
    /// Highest derivative.
    pub order: usize,
    /// Communication points.
    pub points: usize,
}

/// All actions on a scene. Times are shares of its duration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Actions {
    /// Actions at these times.
    pub list: Vec<(f64, Action)>,
    /// Actions of a master.
    pub master: Option<Master>,
    /// Factors for retuning at an event; which event (modulo their number), and how long after it, s.
    pub at_event: Option<(usize, f64, Factors)>,
}

/// Parameters with the tunable ones times factors. For `gamma`, `gamma - 1` is scaled.
pub fn tuned(p: &Parameters, factors: &Factors) -> Parameters {
    let [stiffness, ratio, viscosity, barrier, amplitude] = *factors;
    let mut tuned = *p;
    tuned.rock.stiffness *= stiffness;
    tuned.rock.unloading_ratio = 1.0 + ratio * (p.rock.unloading_ratio - 1.0);
    tuned.rock.viscosity *= viscosity;
    tuned.rock.energy_barrier *= barrier;
    tuned.drive.amplitude *= amplitude;
    tuned
}

impl Master {
    /// Its values at a time, s.
    fn at(&self, time: f64, step: f64) -> Vec<f64> {
        let [mean, amplitude, rate] = self.wave;
        let (rate, quarter) = (rate / step, std::f64::consts::FRAC_PI_2);
        let derivative = |k: usize| {
            let wave = (rate * time + k as f64 * quarter).sin();
            amplitude * rate.powi(k as i32) * wave
        };
        (0..=self.order).map(|k| derivative(k) + if k == 0 { mean } else { 0.0 }).collect()
    }
}

impl Actions {
    /// Largest force of the inputs, approximately, N.
    pub fn force(&self, p: &Parameters) -> f64 {
        let area = p.drive.area_drive.max(p.drive.area_return).max(p.drive.anvil_area);
        let of = |input: &Input, value: f64| match input {
            Input::FeedForce | Input::DriveForce => value.abs(),
            _ => area * value.abs(),
        };
        let listed = self.list.iter().map(|(_, action)| match action {
            Action::Set(input, derivatives) => of(input, derivatives[0]),
            Action::Retune(factors) => factors[4] * p.drive.amplitude,
        });
        let [mean, amplitude, _] = self.master.as_ref().map_or([0.0; 3], |master| master.wave);
        let input = self.master.as_ref().map_or(Input::FeedForce, |master| master.input);
        listed.fold(of(&input, mean.abs() + amplitude.abs()), f64::max)
    }
}

impl Actions {
    /// The actions with their instants, s, ascending, up to the end of the scene.
    ///
    /// # Errors
    /// Those of the engine on the way to the event at which the scene is retuned.
    pub fn schedule(
        &self,
        start: &Parameters,
        inputs: &InputValues,
        end: f64,
    ) -> Result<Vec<(f64, Action)>, Error> {
        let mut schedule: Vec<(f64, Action)> =
            self.list.iter().map(|(part, action)| (part * end, action.clone())).collect();
        if let Some(master) = &self.master {
            let step = end / master.points as f64;
            schedule.extend((0..master.points).map(|i| {
                let time = step * i as f64;
                (time, Action::Set(master.input, master.at(time, step)))
            }));
        }
        schedule.iter_mut().for_each(|(_, action)| action.keep_to_bounds());
        schedule.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((which, after, factors)) = self.at_event {
            let mut machine = Machine::new(start, inputs, 0.0)?;
            machine.keep_journal(true);
            follow(&mut machine, start, &schedule, end)?;
            // Not at the start, before which nothing can be retuned.
            let mut journal = machine.take_journal();
            journal.retain(|record| record.time > 0.0);
            if !journal.is_empty() {
                let time = journal[which % journal.len()].time + after;
                schedule.push((time, Action::Retune(factors)));
                schedule.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
        }
        schedule.retain(|(time, _)| *time < end);
        Ok(schedule)
    }
}

impl Action {
    /// Drops derivatives from the first one on that is too steep for an input.
    fn keep_to_bounds(&mut self) {
        if let Self::Set(input, derivatives) = self {
            let allowed = derivatives.iter().enumerate();
            let count = allowed.take_while(|(k, value)| input.check(*k, **value).is_ok()).count();
            derivatives.truncate(count);
        }
    }
}

/// Performs an action on a machine whose scene began with `start`.
pub fn perform(machine: &mut Machine, start: &Parameters, action: &Action) -> Result<(), Error> {
    match action {
        Action::Set(input, derivatives) => machine.set_input(*input, derivatives),
        Action::Retune(factors) => machine.retune(&tuned(start, factors)),
    }
}

/// Advances a machine to `end` and performs the actions that are due. Those at the start come before any event there:
/// a guard that rests at its level is tracked under the new inputs.
pub fn follow(
    machine: &mut Machine,
    start: &Parameters,
    schedule: &[(f64, Action)],
    end: f64,
) -> Result<(), Error> {
    let from = machine.time();
    for (time, action) in schedule.iter().filter(|(time, _)| (from..end).contains(time)) {
        if *time > machine.time() {
            machine.advance(*time)?;
        }
        perform(machine, start, action)?;
    }
    machine.advance(end)
}

/// The same actions in the oracles' terms.
pub fn translated_actions(start: &Parameters, schedule: &[(f64, Action)]) -> Schedule {
    let input = |input: &Input| match input {
        Input::FeedForce => scene::Input::Feed,
        Input::DriveForce => scene::Input::Force,
        Input::DrivePressure => scene::Input::DrivePressure,
        Input::ReturnPressure => scene::Input::ReturnPressure,
        Input::SupplyPressure => scene::Input::Supply,
        Input::ExhaustPressure => scene::Input::Exhaust,
    };
    let translated = |action: &Action| match action {
        Action::Set(which, derivatives) => scene::Action::Set(input(which), derivatives.clone()),
        Action::Retune(factors) => {
            let p = tuned(start, factors);
            scene::Action::Retune(crate::scene::rock_law(&p), Some(p.drive.amplitude))
        }
    };
    schedule.iter().map(|(time, action)| (*time, translated(action))).collect()
}

fn factor() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![1 => Just(1.0), 2 => (-2.0..2f64).prop_map(f64::exp)]
}

fn factors() -> impl Strategy<Value = Factors> {
    (factor(), factor(), factor(), factor(), factor()).prop_map(|(a, b, c, d, e)| [a, b, c, d, e])
}

fn input(source: Source) -> impl Strategy<Value = Input> {
    let driving = match source {
        Source::Force => vec![Input::DriveForce],
        Source::Pressure => vec![Input::DrivePressure, Input::ReturnPressure],
        _ => vec![Input::FeedForce],
    };
    prop_oneof![Just(Input::FeedForce), prop::sample::select(driving)]
}

/// Size of an input: a force, or the pressure of that force on 1e-3 m2.
fn size(input: Input, force: f64) -> f64 {
    match input {
        Input::FeedForce | Input::DriveForce => force,
        _ => 1e3 * force,
    }
}

fn setting(source: Source, unit: f64) -> impl Strategy<Value = Action> {
    let signed = (0.0..5f64, any::<bool>())
        .prop_map(|(x, s)| if s { -(10f64.powf(x)) } else { 10f64.powf(x) });
    // An input that is set once lasts to the end, tens of units away, and must not grow without bound.
    let rate = (-3.0..-0.5f64).prop_map(move |x| 10f64.powf(x) / unit);
    let terms = prop::collection::vec(-1.0..1f64, 0..5);
    (input(source), signed, rate, terms).prop_map(|(input, force, rate, terms)| {
        let value = size(input, force);
        let mut scale = value;
        let derivatives = terms.iter().map(|x| {
            scale *= rate;
            scale * x
        });
        Action::Set(input, std::iter::once(value).chain(derivatives).collect())
    })
}

/// An outside pressure of air jumps, or ramps by at most a share of itself.
fn outside(unit: f64) -> impl Strategy<Value = Action> {
    let supply = (Just(Input::SupplyPressure), 5.0..7f64);
    let exhaust = (Just(Input::ExhaustPressure), 4.0..6f64);
    let slope = prop_oneof![Just(0.0), -5e-3..2e-2f64];
    (prop_oneof![supply, exhaust], slope).prop_map(move |((input, size), slope)| {
        let pressure = 10f64.powf(size);
        Action::Set(input, vec![pressure, slope * pressure / unit])
    })
}

fn master(source: Source) -> impl Strategy<Value = Master> {
    (input(source), 0.0..5f64, 0.0..1f64, -3.0..0.3f64, 0usize..5, 5usize..60).prop_map(
        |(input, force, part, rate, order, points)| {
            let mean = size(input, 10f64.powf(force));
            Master { input, wave: [mean, part * mean, 10f64.powf(rate)], order, points }
        },
    )
}

/// Possible actions on a scene with this drive and unit of time.
pub fn actions(source: Source, unit: f64) -> impl Strategy<Value = Actions> {
    let of_air = if source == Source::Air { 2 } else { 0 };
    let action = prop_oneof![
        2 => setting(source, unit),
        of_air => outside(unit),
        1 => factors().prop_map(Action::Retune),
    ];
    let list = prop_oneof![
        2 => Just(Vec::new()),
        3 => prop::collection::vec((0.0..1f64, action), 1..6),
    ];
    let after = prop_oneof![Just(0.0), Just(1e-12), (-9.0..-5f64).prop_map(|x| 10f64.powf(x))];
    let at_event = prop::option::weighted(0.3, (0usize..50, after, factors()));
    (list, prop::option::weighted(0.4, master(source)), at_event)
        .prop_map(|(list, master, at_event)| Actions { list, master, at_event })
}
