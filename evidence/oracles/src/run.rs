//! The reference solution: Taylor series from event to event, through a script of actions.
//!
//! ```text
//! until the end:
//!     expand about x-; step as far as the series reaches, the next action or instant allows
//!     if a guard's polynomial crosses on the way: x- := its zero, transition
//!     else x- := the end of the step; there, the script's actions
//! ```
//!
//! In double-double arithmetic, rounding (2^-106) and truncation are the only errors, and events propagate them; two
//! runs with different orders and tolerances measure the result. In plain doubles the same algorithm shows what
//! double precision can know.

mod ahead;
mod breath;
mod ledger;

use crate::air::{Air, Flow, PRESSURES};
use crate::crossing::{Outcome, Zero, scan};
use crate::guard_perturbation::{GuardPerturbation, PerturbedGuards, round_braked};
use crate::law::{Event, Guard, Memory, Mode, Quantity, State};
use crate::linear::Real;
use crate::model::Model;
use crate::perturb;
use crate::record::{GivenUp, Passed, Sampled};
use crate::scene::{Action, Input, Scene};
use crate::taylor::{Accuracy, Polynomials, Series, Works, shifted};

/// Most transitions at one instant before the run is given up.
const SIMULTANEOUS: usize = 100;

/// Present place of a run.
#[derive(Clone, Debug)]
struct Place<T> {
    time: T,
    state: State<T>,
    works: Works<T>,
}

/// An integration under way.
#[derive(Clone)]
pub struct Run<T> {
    /// The model with the present tuning.
    pub model: Model<T>,
    accuracy: Accuracy,
    unit: f64,
    place: Place<T>,
    mode: Mode,
    memory: Memory<T>,
    /// Coefficients in powers of a unit of time, about the instant below.
    inputs: Polynomials<T>,
    since: T,
    /// The air, if it drives. Its pressures above the exhaust's are stored among the inputs.
    air: Option<Air<T>>,
    /// Sums over past modes: energy dissipated on the loading lines and in the dashpot, and energy added by retuning.
    lost: [T; 3],
    /// Stored energy, and gravity's potential, at the start.
    start: [T; 2],
    pending: Vec<Option<Place<T>>>,
    /// First instant at which an action found a guard undecided, s.
    dropped: f64,
    /// How guards are perturbed, if they are, and the perturbation in the present mode.
    guard_perturbation: Option<(GuardPerturbation, PerturbedGuards)>,
    /// Tip's position and `psi` at the start of the present mode or tuning.
    entered: [T; 2],
    /// The transitions so far.
    pub events: Vec<Passed<T>>,
    /// The states so far.
    pub samples: Vec<Sampled<T>>,
    /// Factor of the guards' resolutions.
    pub finer: f64,
    /// Series computed so far.
    pub steps: usize,
    /// Largest number of series.
    pub patience: usize,
}

impl<T: Real> Run<T> {
    /// A run at the start, at time 0.
    pub fn new(scene: &Scene, accuracy: Accuracy) -> Self {
        let model = Model::<T>::new(scene);
        let (state, mode, memory) = model.start();
        let zero = T::default();
        let vr = model.quantity(Quantity::Relative, &state);
        let air = Air::start(scene, vr);
        let mut works = Works::default();
        if let Some(air) = &air {
            works.air = air.filled([vr, model.over(&state.u) - T::from(scene.gap)]);
        }
        let place = Place { time: zero, state, works };
        let mut run = Self {
            unit: model.unit(),
            accuracy,
            place,
            mode,
            memory,
            inputs: scene.rows(),
            since: zero,
            air,
            lost: [zero; 3],
            start: [zero; 2],
            pending: Vec::new(),
            dropped: f64::INFINITY,
            guard_perturbation: None,
            entered: [zero; 2],
            events: Vec::new(),
            samples: Vec::new(),
            finer: 1.0,
            steps: 0,
            patience: usize::MAX,
            model,
        };
        run.flow_anew();
        run.start = [run.stored(), run.fallen(&run.place.state)];
        run.enter();
        run
    }

    /// The same run with guards perturbed by rounding.
    pub fn perturbed_guards(mut self, guard_perturbation: GuardPerturbation) -> Self {
        self.guard_perturbation = Some((guard_perturbation, PerturbedGuards::default()));
        self.perturb_guards();
        self
    }

    /// Perturbs the state by the rounding of a change of basis. Bodies at rest are not rounded.
    fn round_state(&mut self) {
        if let Some((guard_perturbation, _)) = self.guard_perturbation {
            let seed = guard_perturbation.seed + 8 * self.events.len() as u64;
            perturb::round(&mut self.place.state, seed);
        }
    }

    /// Draws new perturbations of the guards at the start of a mode, a tuning or an input, where bodies that the
    /// string brakes also have new asymptotes.
    fn perturb_guards(&mut self) {
        let Some((guard_perturbation, _)) = self.guard_perturbation else { return };
        let load = self.model.load_of(self.mode, &self.memory, &self.inputs_now());
        let about = (self.mode, &self.memory);
        let count = self.events.len();
        let seed = guard_perturbation.seed + 8 * count as u64;
        round_braked(&self.model, self.mode, &load, &mut self.place.state, seed);
        let perturbed = guard_perturbation.at(&self.model, about, &load, &self.place.state, count);
        self.guard_perturbation = Some((guard_perturbation, perturbed));
    }

    /// Unit of time, s: about the reciprocal of the fastest rate under the present tuning. A series reaches over some
    /// units.
    pub fn unit_time(&self) -> f64 {
        self.unit
    }

    /// Instant from which on the run is undecided, s: at the end or at an action, a guard had risen without exceeding
    /// its resolution. A solver that looks further ahead may decide it.
    pub fn near_miss(&self) -> f64 {
        let zeros = self.pending.iter().flatten().map(|place| place.time.to_f64());
        zeros.fold(self.dropped, f64::min)
    }

    fn tip(&self) -> T {
        self.place.state.u[self.model.tip]
    }

    fn guards(&self) -> Vec<Guard<T>> {
        let mut list = self.model.guards(self.mode, &self.memory);
        list.extend(self.air.iter().flat_map(Air::guards));
        list.iter_mut().for_each(|guard| guard.height *= self.finer);
        if let Some((guard_perturbation, perturbed_guards)) = &self.guard_perturbation {
            for guard in &mut list {
                let (shift, height) =
                    perturbed_guards.of(guard.quantity, guard.height, *guard_perturbation);
                guard.offset = guard.offset - T::from(shift);
                guard.height = height;
            }
        }
        list
    }

    /// Starts a mode or a tuning.
    fn enter(&mut self) {
        self.pending = vec![None; self.guards().len()];
        self.entered = [self.tip(), self.place.state.psi];
        self.unit = self.model.unit();
    }

    /// Integrates through all `instants` (ascending), samples at each, and performs the script's actions. A sample at
    /// the instant of an action is taken before it.
    ///
    /// # Errors
    /// See [`GivenUp`].
    pub fn through(&mut self, instants: &[f64], schedule: &[(f64, Action)]) -> Result<(), GivenUp> {
        let mut next = 0;
        while self.samples.len() < instants.len() {
            let target = instants[self.samples.len()];
            match schedule.get(next) {
                Some((time, action)) if *time < target => {
                    // All actions at one instant are performed before any event.
                    let together = next > 0 && schedule[next - 1].0 == *time;
                    if together || self.step(T::from(*time))? && !self.settle()? {
                        self.act(action);
                        next += 1;
                    }
                }
                // A rejected part of the run is removed with its samples.
                _ => {
                    if self.step(T::from(target))? {
                        self.sample(target);
                    }
                }
            }
        }
        Ok(())
    }

    fn series(&self) -> Series<T> {
        Series::new(
            &self.model,
            (self.mode, &self.memory),
            (&self.inputs_now(), self.air.as_ref()),
            (&self.place.state, &self.place.works),
            self.accuracy.order,
            self.unit,
        )
    }

    fn act(&mut self, action: &Action) {
        match action {
            Action::Set(input, _) if self.air.is_some() && PRESSURES.contains(input) => {}
            Action::Set(input, derivatives) => {
                self.rebase();
                let mut factor = T::from(1.0);
                let row = derivatives.iter().enumerate().map(|(k, &d)| {
                    if k > 0 {
                        factor = factor * T::from(self.unit) / T::from(k as f64);
                    }
                    factor * T::from(d)
                });
                self.inputs[*input as usize] = row.collect();
            }
            Action::Retune(law, amplitude) => {
                self.rebase();
                self.leave();
                let (before, unit) = (self.stored(), self.unit);
                self.model.retune(*law, *amplitude);
                self.lost[2] = self.lost[2] + self.stored() - before;
                self.enter();
                self.rescale(unit);
                self.round_state();
                self.perturb_guards();
                return;
            }
        }
        if matches!(action, Action::Set(Input::Supply | Input::Exhaust, _)) {
            self.flow_anew();
        }
        // Pending guards are decided again.
        self.pending.iter_mut().for_each(|pending| *pending = None);
        self.perturb_guards();
    }

    /// Expands the inputs about the present instant.
    fn rebase(&mut self) {
        self.inputs = self.inputs_now();
        self.since = self.place.time;
    }

    fn inputs_now(&self) -> Polynomials<T> {
        let x = (self.place.time - self.since) * T::from(1.0 / self.unit);
        self.inputs.each_ref().map(|row| shifted(row, x))
    }

    /// Rewrites the inputs' coefficients for the present unit of time.
    fn rescale(&mut self, from: f64) {
        let factor = T::from(self.unit / from);
        for row in &mut self.inputs {
            let mut power = T::from(1.0);
            for c in row {
                *c = *c * power;
                power = power * factor;
            }
        }
    }

    fn sample(&mut self, time: f64) {
        let (mode, state, memory) = (self.mode, &self.place.state, self.memory);
        let gap = self.model.quantity(Quantity::Gap, state);
        let contact =
            if mode.closed { -(self.model.contact_stiffness * gap) } else { T::default() };
        let forces = [contact, self.model.rock_force(mode, &memory, state)];
        let joints = self.model.joint_forces(mode, &state.u, &state.v);
        let energies = self.energies();
        let force = self.drive_force();
        let (pressures, taken) = (self.pressures(), self.place.works.air[4]);
        let state = state.clone();
        self.samples.push(Sampled {
            time,
            mode,
            memory,
            state,
            forces,
            joints,
            force,
            energies,
            pressures,
            taken,
        });
    }

    /// A port passes an edge, or venting begins or ends.
    fn turn(&mut self, event: Event) {
        let (places, inputs) = (self.places(), self.inputs_now());
        if let Some(air) = &mut self.air {
            *air = air.under(&inputs);
            match event {
                Event::Vent(vented) => air.vent(vented, places, &mut self.place.works.air),
                Event::End(inside) => air.end(inside, places, &mut self.place.works.air),
                Event::Port(..) | Event::Whole(..) => air.turn(event),
                _ => return,
            }
            self.flow_anew();
            self.pending = vec![None; self.guards().len()];
        }
    }

    /// One step or one transition; true if `target` was reached.
    fn step(&mut self, target: T) -> Result<bool, GivenUp> {
        if self.steps >= self.patience {
            return Err(GivenUp::Long(self.place.time.to_f64()));
        }
        self.steps += 1;
        let series = self.series();
        let remaining = (target - self.place.time) * T::from(1.0 / self.unit);
        let (reach, change) = self.stride(&series);
        let arrives = (remaining - reach).to_f64() <= 0.0;
        let x = if arrives { remaining } else { reach };
        if let Some(crossing) = self.first_crossing(&series, x.to_f64()) {
            let now = crossing.1.time;
            if let Some((guard, place)) = self.decided(Some(crossing), now) {
                self.pass(&guard, place)?;
                return Ok(false);
            }
        }
        let time = if arrives { target } else { self.place.time + x * T::from(self.unit) };
        let (state, works) = series.at(x);
        self.place = Place { time, state, works };
        self.breathe();
        if let Some(change) = change.filter(|_| !arrives) {
            self.flow_as(change);
        }
        Ok(arrives)
    }

    /// How far a series reaches, in units of time: to its accuracy, or to where an air flow changes its formula, with
    /// that change.
    fn stride(&self, series: &Series<T>) -> (T, Option<(usize, Flow)>) {
        let reach = series.reach(self.accuracy);
        match series.air.as_ref().and_then(|air| air.change(reach)) {
            Some((x, change)) => (x, Some(change)),
            None => (T::from(reach), None),
        }
    }

    /// The first transition of a step, if any. Otherwise records the pending guards.
    fn first_crossing(&mut self, series: &Series<T>, end: f64) -> Option<(Guard<T>, Place<T>)> {
        let mut first: Option<(Guard<T>, Place<T>)> = None;
        for (i, guard) in self.guards().into_iter().enumerate() {
            let mut c = series.quantity(&self.model, guard.quantity);
            c[0] = c[0] - guard.offset;
            c.iter_mut().for_each(|c| *c = T::from(guard.sign) * *c);
            let outcome = scan(&c, end, guard.height, self.pending[i].is_some());
            self.pending[i] = match outcome {
                Outcome::Clear => None,
                Outcome::Pending(Zero::Earlier) | Outcome::Crossed(Zero::Earlier) => {
                    self.pending[i].take()
                }
                Outcome::Pending(Zero::At(x)) | Outcome::Crossed(Zero::At(x)) => {
                    let (state, works) = series.at(x);
                    Some(Place { time: self.place.time + x * T::from(self.unit), state, works })
                }
            };
            if let (Outcome::Crossed(_), Some(place)) = (outcome, &self.pending[i]) {
                let one = (guard, place.clone());
                if first.as_ref().is_none_or(|first| ahead::precedes(&one, first)) {
                    first = Some(one);
                }
            }
        }
        first
    }

    fn pass(&mut self, guard: &Guard<T>, place: Place<T>) -> Result<(), GivenUp> {
        self.place = place;
        let time = self.place.time;
        self.samples.retain(|sample| T::from(sample.time) <= time);
        self.leave();
        let rate = self.rate(guard);
        let state = &mut self.place.state;
        self.model.transition(guard.event, &mut self.mode, &mut self.memory, state);
        self.events.push(Passed { time, event: guard.event, mode: self.mode, rate });
        let unit = self.unit;
        self.rebase();
        self.enter();
        self.rescale(unit);
        self.turn(guard.event);
        self.round_state();
        self.perturb_guards();
        let now = self.events.iter().rev().take_while(|e| e.time == time).count();
        if now > SIMULTANEOUS {
            return Err(GivenUp::Zeno(time.to_f64()));
        }
        Ok(())
    }

    /// Rate of a guard at the present place.
    fn rate(&self, guard: &Guard<T>) -> T {
        let state = &self.place.state;
        let v = &state.v;
        let rate = match guard.quantity {
            Quantity::Gap => self.model.gap(v),
            Quantity::Tip => v[self.model.tip],
            Quantity::Relative => self.model.mean_difference(v),
            Quantity::Work => self.model.power(self.mode, v),
            Quantity::Joint(i) => self.model.joints[i].apart(v),
            Quantity::TipSpeed => {
                let inputs = self.inputs_now();
                let about = (self.mode, &self.memory);
                let from = (state, &self.place.works);
                let given = (&inputs, self.air.as_ref());
                let series = Series::new(&self.model, about, given, from, 1, self.unit);
                series.quantity(&self.model, Quantity::TipSpeed)[1] * T::from(1.0 / self.unit)
            }
        };
        T::from(guard.sign) * rate
    }
}
