//! The long-run response of a hammer, whether it repeats or not.
//!
//! Blows are simulated. If they nearly repeat, the simulation goes on until they repeat to [`CLOSED`], and the answer
//! is the mean of the last ones. Otherwise several simulations, whose slightly different starts drift apart, are
//! averaged ([`Means`]) until the requested error is reached. An unstable cycle is never found in this way. If there
//! are several stable motions, the answer is the one to which the scene's own start leads.

use crate::error::Error;
use crate::interrupt::in_threads;
use crate::laws::event::Event;
use crate::machine::blows::Blow;
use crate::machine::{Machine, Observer};
use crate::means::averages::{Averages, Means};
use crate::numerics::display::digits;
use crate::scene::Scene;

/// Kind of a hammer's long-run response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It repeats after this number of blows.
    Cycle(usize),
    /// It does not repeat.
    Irregular,
    /// It comes to rest, or makes no blow.
    Stalled,
}

/// A long-run response.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Steady {
    /// The kind of the response.
    pub kind: Kind,
    /// Means over blows.
    pub mean: Averages,
    /// Standard errors of the means; 0 if the motion repeats.
    pub error: Averages,
    /// Standard deviations from blow to blow.
    pub spread: Averages,
    /// Number of blows in the means.
    pub blows: usize,
    /// True if the requested error was reached.
    pub reached: bool,
    /// The irregular motion that a [second start](Wanted::second) leads to.
    pub elsewhere: Option<Box<Self>>,
}

/// How to search for a long-run response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Largest allowed standard error of each mean, relative to the mean; infinite for a mean that does not matter.
    pub error: Averages,
    /// Most blows that are simulated.
    pub blows: usize,
    /// If a hammer makes no blow for this time, it has stalled, s.
    pub limit: f64,
    /// Longest cycle that is searched for, in blows; 0 for no search. More than [`MOST_REPEATING`] has no effect.
    pub repeating: usize,
    /// Threads that simulate. The answer does not depend on their number.
    pub threads: usize,
    /// True to try a second start if the motion repeats. A motion that is irregular from most starts may repeat from a
    /// few.
    pub second: bool,
}

impl Default for Wanted {
    fn default() -> Self {
        let error = Averages::of_rates(0.01);
        Self { error, blows: 20_000, limit: 10.0, repeating: 8, threads: 1, second: false }
    }
}

/// Number of simulations for a mean, and the fewest blows of each. With fewer, the error is too uncertain to end the
/// search.
const MEMBERS: usize = 4;
const FEWEST: usize = 300;
/// Number of blows before the search for a cycle.
const SETTLED: usize = 40;
/// Number of blows that must repeat, in addition to two rounds of the cycle.
const WINDOW: usize = 8;
/// The longest cycle that can be recognised in the first [`SETTLED`] blows, in blows.
pub const MOST_REPEATING: usize = (SETTLED - WINDOW) / 2;
/// Least and largest factor by which simulations grow before the error is evaluated again, and a safety factor for the
/// number of blows that the error suggests. If the error were evaluated more often, the search would stop when it
/// happens to be underestimated.
const GROWTH: [f64; 3] = [1.5, 4.0, 1.2];
/// Blows nearly repeat if their speeds and periods differ by at most this share.
const NEAR: f64 = 5e-3;
/// Blows repeat if they differ by at most this share. Rounding contributes 1e-11. If the transient decays by a factor
/// `r` per blow, the remaining change is `r / (1 - r)` times the last difference.
const CLOSED: f64 = 1e-9;
/// If blows repeat to this share after fewer rounds than to [`CLOSED`], they have not settled yet.
const ALIKE: f64 = 1e-6;
/// Number of further blows in which a motion that nearly repeats may come to repeat. If it takes longer, it is
/// averaged.
const FOLLOWED: usize = 200;
/// If the transient's factor over [`SETTLED`] blows is above this, the motion does not come to repeat in [`FOLLOWED`]
/// blows. To get from [`NEAR`] to [`CLOSED`] in that time, the factor must be below 4.6e-2.
const SLOWEST: f64 = 0.5;
/// Each simulation's piston starts faster than that of the previous one by this, m/s.
const APART: f64 = 0.03;
/// Longest step between two blows, s.
const STEP: f64 = 0.25;
/// If a blow came soon after another, the machine may seem stalled for up to this time afterwards, s.
const CERTAIN: f64 = 1.0;

/// A simulation whose blows are collected.
pub trait Simulation {
    /// The error with which it fails.
    type Error;

    /// Continues for some time and adds the blows that have a period. Returns false if no more blows will follow.
    ///
    /// # Errors
    /// Those of the simulation.
    fn go_on(&mut self, blows: &mut Vec<Blow>) -> Result<bool, Self::Error>;
}

/// Waits for the blows of a machine.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    /// Longest wait, s.
    pub limit: f64,
    /// Time of the last blow or of the start, s.
    last: f64,
}

impl Waiting {
    /// Waits from now on. The machine records its blows from now on.
    pub fn new(machine: &mut Machine, limit: f64) -> Self {
        machine.take_blows();
        Self { limit, last: machine.time() }
    }

    /// Adds the new blows that have a period. Returns false if there are none and either the machine has certainly
    /// [stalled](Machine::stalled) or the wait was too long.
    pub fn collect(&mut self, machine: &mut Machine, blows: &mut Vec<Blow>) -> bool {
        let new = machine.take_blows();
        blows.extend(new.iter().filter(|blow| blow.period > 0.0));
        if let Some(blow) = new.last() {
            self.last = blow.time;
            return true;
        }
        let waited = machine.time() - self.last;
        waited <= self.limit && !(waited > CERTAIN && machine.stalled())
    }
}

/// The long-run response of a scene. `progress` is called with the number of blows and the present errors
/// ([`Means::error_ratio`]); it ends the search by returning false.
///
/// ```
/// use hammer::means::{Kind, Wanted, steady};
///
/// let mut scene = hammer::Scene::default();
/// scene.parameters.fidelity = hammer::Fidelity::Rigid;
/// let found = steady(&scene, &Wanted::default(), &mut |_blows, _error| true)?;
/// assert!(matches!(found.kind, Kind::Cycle(_)) && found.error.rop() == 0.0);
/// assert!(found.mean.rop() > 0.0 && found.mean.get("blow_energy") > 0.0);
/// # Ok::<(), hammer::Error>(())
/// ```
///
/// # Errors
/// Those of the scene and of the engine.
pub fn steady(
    scene: &Scene,
    wanted: &Wanted,
    progress: &mut dyn FnMut(usize, f64) -> bool,
) -> Result<Steady, Error> {
    let apart = |number: usize| Alone::new(scene, number, wanted.limit);
    let mut found = search(apart(0)?, Some(&apart), wanted, progress)?;
    if wanted.second && matches!(found.kind, Kind::Cycle(_)) {
        let other = match elsewhere(scene, &found, wanted, progress) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            // The caller did not request this start, so its errors are not reported.
            other => other.ok().flatten(),
        };
        found.elsewhere = other.map(Box::new);
    }
    Ok(found)
}

/// The response of a repeating scene if it starts from half the gap with the piston rising. `None` if that motion
/// nearly repeats too.
fn elsewhere(
    scene: &Scene,
    found: &Steady,
    wanted: &Wanted,
    progress: &mut dyn FnMut(usize, f64) -> bool,
) -> Result<Option<Steady>, Error> {
    let mut other = *scene;
    other.parameters.contact.initial_gap *= 0.5;
    other.parameters.piston.initial_velocity = -0.5 * found.mean.speed();
    let mut member = Member::new(Alone::new(&other, 0, wanted.limit)?);
    member.strike(SETTLED)?;
    if member.list.len() < SETTLED || repeats(&member.list, wanted.repeating, NEAR).is_some() {
        return Ok(None);
    }
    let other = steady(&other, &Wanted { second: false, ..*wanted }, progress)?;
    Ok(Some(other).filter(|other| other.kind == Kind::Irregular))
}

/// The long-run response of a single simulation, for instance of a hammer with a controller. If its blows repeat, the
/// result is as that of [`steady`].
///
/// # Errors
/// Those of the simulation.
pub fn steady_of<S: Simulation + Send>(
    simulation: S,
    wanted: &Wanted,
    progress: &mut dyn FnMut(usize, f64) -> bool,
) -> Result<Steady, S::Error>
where
    S::Error: Send,
{
    search(simulation, None, wanted, progress)
}

/// Makes simulation number `n`, which starts slightly differently from the others.
type Create<'a, S> = &'a dyn Fn(usize) -> Result<S, <S as Simulation>::Error>;

fn search<S: Simulation + Send>(
    first: S,
    others: Option<Create<'_, S>>,
    wanted: &Wanted,
    progress: &mut dyn FnMut(usize, f64) -> bool,
) -> Result<Steady, S::Error>
where
    S::Error: Send,
{
    let mut members = vec![Member::new(first)];
    // Number of simulations, and most and fewest blows of each.
    let count = others.map_or(1, |_| MEMBERS.min(wanted.blows / SETTLED).max(1));
    let most = (wanted.blows / count).max(SETTLED);
    let fewest = FEWEST.min(most);
    let (mut next, mut growth) = (SETTLED, GROWTH[0]);
    loop {
        grow(&mut members, next, wanted)?;
        if members.iter().any(|member| member.list.len() < next) {
            return Ok(Steady::of(Kind::Stalled, Means::default(), true));
        }
        if let Some(blows) = followed(&mut members[0], wanted)? {
            let means = Means::exact(last(&members[0].list, blows));
            return Ok(Steady::of(Kind::Cycle(blows), means, true));
        }
        if next >= fewest {
            let means = Means::of(&distinct(&members, next));
            let (ratio, total) = (means.error_ratio(&wanted.error), next * members.len());
            let reached = ratio <= 1.0;
            if reached || !progress(total, ratio) || next >= most {
                return Ok(Steady::of(Kind::Irregular, means, reached));
            }
            growth = (GROWTH[2] * ratio * ratio).clamp(GROWTH[0], GROWTH[1]);
        }
        // One simulation is enough to find a cycle; only a mean needs several.
        let end = if next < fewest { fewest } else { most };
        next = ((growth * next as f64) as usize).min(end);
        if let Some(create) = others.filter(|_| next >= fewest) {
            for k in members.len()..count {
                members.push(Member::new(create(k)?));
            }
        }
    }
}

/// The first `count` blows of each simulation that differs from the others. Simulations of a stable motion reach the
/// same blows even before these repeat. They then count as one.
fn distinct<S>(members: &[Member<S>], count: usize) -> Vec<&[Blow]> {
    let mut different: Vec<&[Blow]> = Vec::new();
    for member in members {
        let list = &member.list[..count];
        let alike = |other: &&[Blow]| last(other, 3).iter().zip(last(list, 3)).all(within(CLOSED));
        if !different.iter().any(alike) {
            different.push(list);
        }
    }
    different
}

impl Steady {
    /// A warning if the motion repeats from the given start but not from the second one.
    pub fn depends_on_its_start(&self) -> Option<String> {
        let other = self.elsewhere.as_ref()?;
        let in_words = |of: &Self| {
            let [frequency, rate] = [of.mean.get("blow_frequency"), 3600.0 * of.mean.rop()];
            format!("{} Hz, {} m/h", digits(frequency), digits(rate))
        };
        Some(format!(
            "where this hammer settles depends on its start: it repeats ({}), and from another start it is irregular ({})",
            in_words(self),
            in_words(other)
        ))
    }

    fn of(kind: Kind, means: Means, reached: bool) -> Self {
        let Means { mean, error, spread, blows } = means;
        Self { kind, mean, error, spread, blows, reached, elsewhere: None }
    }
}

/// A machine that nobody else steps.
struct Alone {
    machine: Machine,
    waiting: Waiting,
}

impl Alone {
    fn new(scene: &Scene, number: usize, limit: f64) -> Result<Self, Error> {
        let mut scene = *scene;
        scene.parameters.piston.initial_velocity += APART * number as f64;
        let mut machine = scene.machine()?;
        Ok(Self { waiting: Waiting::new(&mut machine, limit), machine })
    }
}

/// Ends a step at the first blow after this number.
struct UntilBlow(u64);

impl Observer for UntilBlow {
    fn after(&mut self, machine: &Machine, _: Event) -> bool {
        machine.counters().blows > self.0
    }
}

impl Simulation for Alone {
    type Error = Error;

    fn go_on(&mut self, blows: &mut Vec<Blow>) -> Result<bool, Error> {
        let (to, blows_before) = (self.machine.time() + STEP, self.machine.counters().blows);
        self.machine.advance_observed(to, &mut UntilBlow(blows_before))?;
        Ok(self.waiting.collect(&mut self.machine, blows))
    }
}

/// One of the simulations, and its blows.
struct Member<S> {
    simulation: S,
    list: Vec<Blow>,
}

impl<S: Simulation> Member<S> {
    fn new(simulation: S) -> Self {
        Self { simulation, list: Vec::new() }
    }

    /// Simulates up to a number of blows, or until no more follow.
    fn strike(&mut self, count: usize) -> Result<(), S::Error> {
        while self.list.len() < count && self.simulation.go_on(&mut self.list)? {}
        Ok(())
    }
}

/// Simulates all members up to a number of blows.
fn grow<S: Simulation + Send>(
    members: &mut [Member<S>],
    count: usize,
    wanted: &Wanted,
) -> Result<(), S::Error>
where
    S::Error: Send,
{
    let work = |member: &mut Member<S>| member.strike(count);
    in_threads(members.iter_mut().collect(), wanted.threads, work).into_iter().collect()
}

/// The relative difference of two blows: the larger of the differences of their speeds and periods.
fn difference(a: &Blow, b: &Blow) -> f64 {
    let of = |a: f64, b: f64| if a == b { 0.0 } else { (a - b).abs() / b.abs() };
    of(a.period, b.period).max(of(a.speed, b.speed))
}

/// True if two blows differ by at most this share.
fn within(part: f64) -> impl Fn((&Blow, &Blow)) -> bool {
    move |(a, b)| difference(a, b) <= part
}

/// The length of the shortest cycle with which the last blows repeat, with relative differences of at most `part`;
/// `None` if they do not repeat.
fn repeats(list: &[Blow], most: usize, part: f64) -> Option<usize> {
    (1..=most.min(MOST_REPEATING)).find(|k| off(list, *k) <= part)
}

/// The largest difference of the last blows from the blows one `cycle` before.
fn off(list: &[Blow], cycle: usize) -> f64 {
    let recent = last(list, WINDOW + 2 * cycle);
    let pairs = recent.iter().zip(recent.iter().skip(cycle));
    pairs.map(|(a, b)| difference(a, b)).fold(0.0, f64::max)
}

/// Continues a simulation whose blows nearly repeat until they repeat. Returns the length of the cycle; `None` if they
/// never do, or come no closer to it.
fn followed<S: Simulation>(
    member: &mut Member<S>,
    wanted: &Wanted,
) -> Result<Option<usize>, S::Error> {
    let end = member.list.len() + FOLLOWED;
    let (mut look, mut before) = (member.list.len(), f64::INFINITY);
    while let Some(cycle) = repeats(&member.list, wanted.repeating, NEAR) {
        let found = repeats(&member.list, wanted.repeating, CLOSED);
        // A transient of alternating sign closes over two rounds sooner than over one.
        let settled = found == repeats(&member.list, wanted.repeating, ALIKE);
        let count = member.list.len() + 1;
        if found.is_some() && settled {
            return Ok(found);
        }
        if count > look {
            let now = off(&member.list, cycle);
            if now > SLOWEST * before {
                break;
            }
            (look, before) = (look + SETTLED, now);
        }
        if count > end {
            break;
        }
        member.strike(count)?;
        if member.list.len() < count {
            break;
        }
    }
    Ok(None)
}

fn last<T>(list: &[T], count: usize) -> &[T] {
    &list[list.len().saturating_sub(count)..]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities::parameters::Fidelity;

    fn rigid() -> Scene {
        let mut scene = Scene::default();
        scene.parameters.fidelity = Fidelity::Rigid;
        scene
    }

    fn simulated(scene: &Scene, count: usize) -> Result<Vec<Member<Alone>>, Error> {
        let member = |k| Ok(Member::new(Alone::new(scene, k, 10.0)?));
        let mut members: Vec<_> = (0..4).map(member).collect::<Result<_, Error>>()?;
        grow(&mut members, count, &Wanted { threads: 2, ..Wanted::default() })?;
        Ok(members)
    }

    /// Speeds that alternate between `10 + part` and `10` have a cycle of one blow to a larger share, and of two blows
    /// to any share.
    #[test]
    fn blows_repeat_after_as_few_as_they_agree() {
        let part = 1e-6;
        let speed = |k: u8| 10.0 * (1.0 + part * f64::from(k % 2));
        let list: Vec<Blow> =
            (0..40).map(|k| Blow { period: 1.0, speed: speed(k), ..Blow::default() }).collect();
        assert_eq!(repeats(&list, 8, 2.0 * part), Some(1));
        assert_eq!(repeats(&list, 8, 0.5 * part), Some(2));
        assert_eq!(repeats(&list, 1, 0.5 * part), None);
        assert_eq!(repeats(&list, 0, 1.0), None);
    }

    /// Without feed the rigid reference never repeats, and simulations from slightly different starts become different.
    /// With feed, all four reach the same cycle.
    #[test]
    fn simulations_of_a_mean_are_different_ones_or_count_once() -> Result<(), Error> {
        let mut scene = rigid();
        assert_eq!(distinct(&simulated(&scene, 60)?, 60).len(), 1);
        scene.inputs.feed_force = 0.0;
        let members = simulated(&scene, 60)?;
        assert_eq!(distinct(&members, 60).len(), 4);
        // They differ from the first blow on, if only slightly.
        assert!(members[1..].iter().all(|other| other.list[0] != members[0].list[0]));
        Ok(())
    }

    /// The rigid reference without feed repeats from its own start but not from half its gap. With its feed it repeats
    /// from both.
    #[test]
    fn a_second_start_finds_an_irregular_motion_and_no_other() -> Result<(), Error> {
        let wanted = Wanted { second: true, error: Averages::of_rates(0.1), ..Wanted::default() };
        let (mut scene, mut on) = (rigid(), |_, _| true);
        let mut found = steady(&scene, &wanted, &mut on)?;
        assert_eq!((found.kind, found.depends_on_its_start()), (Kind::Cycle(1), None));
        scene.inputs.feed_force = 0.0;
        let other = elsewhere(&scene, &found, &wanted, &mut on)?.expect("an irregular motion");
        assert_eq!(other.kind, Kind::Irregular);
        found.elsewhere = Some(Box::new(other));
        assert!(found.depends_on_its_start().is_some_and(|text| text.contains("it is irregular")));
        Ok(())
    }
}
