//! The long-run response of a hammer, whether it repeats or not.
//!
//! Blows are simulated until they repeat nearly: then the cycle is solved for from there
//! ([`find`](super::find)), and is the answer if it is stable and the simulation, followed further,
//! comes to it: another stable cycle may lie close by. Where blows do not repeat, several simulations from starts a little apart, which drift away from each
//! other, are averaged ([`Means`]) until the error asked for is reached.

use crate::energy::ledger::Energies;
use crate::error::Error;
use crate::interrupt::in_threads;
use crate::laws::event::{Displacement, Event};
use crate::machine::{Machine, Observer};
use crate::numerics::math;
use crate::periodic::averages::{Averages, Means, NUMBERS, Numbers};
use crate::periodic::error::CycleError;
use crate::periodic::find::{Cycle, Search, find_from};
use crate::scene::Scene;

/// What a hammer does in the long run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It repeats after so many returns of its drive.
    Cycle(usize),
    /// It does not repeat.
    Irregular,
    /// It comes to rest, or strikes no blow.
    Stalled,
}

/// A long-run response.
#[derive(Clone, Debug)]
pub struct Steady {
    /// What it does.
    pub kind: Kind,
    /// Means over blows.
    pub mean: Averages,
    /// Standard errors of these; 0 of a cycle.
    pub error: Averages,
    /// Standard deviations from blow to blow.
    pub spread: Averages,
    /// Blows that the means are of.
    pub blows: usize,
    /// True if the error asked for was reached.
    pub reached: bool,
    /// The cycle, if it is one.
    pub cycle: Option<Cycle>,
}

/// How a long-run response is sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Largest standard error of each mean, over the mean; infinity where any will do.
    pub error: Averages,
    /// Most blows simulated.
    pub blows: usize,
    /// Fewest blows of each simulation of a mean: of fewer, errors are known too badly to end by them.
    pub fewest: usize,
    /// Without a blow for so long it is stalled, s.
    pub limit: f64,
    /// Cycles are sought that close after so many returns at most; 0: none; [`MOST_RETURNS`] is the
    /// same as more.
    pub returns: usize,
    /// Simulations that a mean is of; the answer depends on it.
    pub members: usize,
    /// Threads that simulate them; the answer does not depend on it.
    pub threads: usize,
}

impl Default for Wanted {
    fn default() -> Self {
        let error = Averages::of_rates(0.01);
        let (blows, fewest) = (20_000, 300);
        Self { error, blows, fewest, limit: 10.0, returns: 8, members: 4, threads: 1 }
    }
}

/// Blows before a cycle is sought.
const SETTLED: usize = 40;
/// Most returns of a cycle that is sought: it is seen in the last of these blows, see [`repeats`].
pub const MOST_RETURNS: usize = (SETTLED - 8) / 2;
/// By how much a simulation grows at least and at most, before its error is looked at again, and what
/// is added to the blows that the error so far asks for. A look after every few blows would end where
/// the error happens to be estimated too small.
const GROWTH: [f64; 3] = [1.5, 4.0, 1.2];
/// Blows whose speeds and periods differ by this part at most repeat nearly.
const REPEATS: f64 = 5e-3;
/// Most cycles that are sought of one hammer.
const ATTEMPTS: usize = 4;
/// Multiples of the returns after which blows repeat nearly that are tried.
const MULTIPLES: usize = 4;
/// A cycle's rate must be that of the last blows to this part, or the motion is not followed to it.
const NEAR: f64 = 0.01;
/// A simulation has come to a cycle where its means are that cycle's to this part.
const MET: f64 = 1e-6;
/// A simulation that is not there yet is followed until the leading multiplier has left this part of
/// its distance, or for so many blows; it goes to the cycle if this part more is left at most.
const LEFT: f64 = 0.01;
const FOLLOWED: usize = 200;
const BESIDE: f64 = 0.1;
/// How much faster each simulation's piston starts than that of the one before, m/s.
const APART: f64 = 0.03;
/// How often a simulation without blows is asked whether it has stalled, s.
const STEP: f64 = 0.25;

/// The long-run response of a scene. `progress` hears of the number of blows and of the errors so far
/// ([`Means::excess`]), and ends the search by false.
///
/// # Errors
/// Those of the scene and of the engine.
pub fn steady(
    scene: &Scene,
    wanted: &Wanted,
    progress: &mut dyn FnMut(usize, f64) -> bool,
) -> Result<Steady, Error> {
    let mut members = vec![Member::new(scene, 0)?];
    // Simulations of a mean, and blows of each.
    let count = wanted.members.min(wanted.blows / SETTLED).max(1);
    let most = (wanted.blows / count).max(SETTLED);
    let fewest = wanted.fewest.min(most);
    let (mut next, mut attempts, mut growth) = (SETTLED, ATTEMPTS, GROWTH[0]);
    loop {
        grow(&mut members, next, wanted)?;
        if members.iter().any(|member| member.list.len() < next) {
            return Ok(Steady::of(Kind::Stalled, Means::default(), true));
        }
        if attempts > 0
            && let Some(returns) = repeats(&members[0].list, wanted.returns)
        {
            attempts -= 1;
            if let Some(cycle) = attracting(scene, returns, wanted.returns, &members[0])? {
                return Ok(cycle);
            }
        }
        if next >= fewest {
            let means = Means::of(&apart(&members));
            let (excess, total) = (means.excess(&wanted.error), next * members.len());
            let reached = excess <= 1.0;
            if reached || !progress(total, excess) || next >= most {
                return Ok(Steady::of(Kind::Irregular, means, reached));
            }
            growth = (GROWTH[2] * excess * excess).clamp(GROWTH[0], GROWTH[1]);
        }
        // One simulation shows a cycle as well as several; these are for a mean.
        let end = if next < fewest { fewest } else { most };
        next = ((growth * next as f64) as usize).min(end);
        if next >= fewest {
            for k in members.len()..count {
                members.push(Member::new(scene, k)?);
            }
        }
    }
}

/// The blows of the simulations that are each another one: where a motion forgets how it began without
/// repeating, all come to the same blows, and several say no more than one.
fn apart(members: &[Member]) -> Vec<&[Numbers]> {
    let mut different: Vec<&[Numbers]> = Vec::new();
    for member in members {
        let last = |list: &[Numbers]| list.last_chunk::<3>().copied();
        let alike = |other: &&[Numbers]| match (last(other), last(&member.list)) {
            (Some(one), Some(two)) => one.iter().zip(&two).all(|(a, b)| same(a, b)),
            _ => false,
        };
        if !different.iter().any(alike) {
            different.push(&member.list);
        }
    }
    different
}

impl Steady {
    fn of(kind: Kind, means: Means, reached: bool) -> Self {
        let Means { mean, error, spread, blows } = means;
        Self { kind, mean, error, spread, blows, reached, cycle: None }
    }
}

/// One of the simulations.
struct Member {
    machine: Machine,
    list: Vec<Numbers>,
    energies: Energies,
    drilled: f64,
    way: Way,
}

/// Stops at blows.
#[derive(Default)]
struct Way {
    struck: bool,
    rebound: f64,
}

impl Observer for Way {
    fn after(&mut self, machine: &Machine, event: Event) -> bool {
        let motion = machine.motion();
        if event == Event::OPENING {
            self.rebound = -motion.velocity(motion.tracks(), Displacement::PISTON, 0.0);
        }
        let now = motion.milestone().time.value();
        self.struck =
            event == Event::CLOSING && machine.blow().is_some_and(|blow| blow.time == now);
        self.struck
    }
}

impl Member {
    fn new(scene: &Scene, number: usize) -> Result<Self, Error> {
        let mut scene = *scene;
        scene.parameters.piston.initial_velocity += APART * number as f64;
        Ok(Self::from(scene.machine()?))
    }

    fn from(machine: Machine) -> Self {
        let energies = machine.energies();
        let drilled = machine.drilled_length();
        Self { machine, list: Vec::new(), energies, drilled, way: Way::default() }
    }

    /// Simulates up to a number of blows, or until there are no more.
    fn strike(&mut self, count: usize, limit: f64) -> Result<(), Error> {
        let machine = &mut self.machine;
        let (mut last, mut peaks) = (machine.time(), [0.0_f64; 2]);
        while self.list.len() < count {
            self.way.struck = false;
            machine.advance_observed(machine.time() + STEP, &mut self.way)?;
            machine.prepare_peaks()?;
            let now = machine.peaks();
            peaks = [peaks[0].max(now.contact_force()), peaks[1].max(now.rock_force())];
            if self.way.struck
                && let Some(blow) = machine.blow()
            {
                let mut numbers = [0.0; NUMBERS];
                numbers[..4].copy_from_slice(&[
                    blow.period,
                    blow.penetration,
                    blow.speed,
                    blow.energy,
                ]);
                let (e, f, drilled) = (machine.energies(), self.energies, machine.drilled_length());
                numbers[4..].copy_from_slice(&[
                    self.way.rebound,
                    peaks[0],
                    peaks[1],
                    e.drive - f.drive,
                    e.gravity - f.gravity,
                    e.feed - f.feed,
                    e.rock_dissipated - f.rock_dissipated,
                    e.viscous - f.viscous,
                    e.damping - f.damping,
                    drilled - self.drilled,
                    blow.air_flow * blow.period,
                ]);
                // The first blow has no period.
                if numbers[0] > 0.0 {
                    self.list.push(numbers);
                }
                (self.energies, self.drilled) = (e, drilled);
                (last, peaks) = (machine.time(), [0.0; 2]);
            } else if machine.stalled() || machine.time() - last > limit {
                break;
            }
        }
        Ok(())
    }
}

/// Simulates all members up to a number of blows.
fn grow(members: &mut [Member], count: usize, wanted: &Wanted) -> Result<(), Error> {
    let work = |member: &mut Member| member.strike(count, wanted.limit);
    in_threads(members.iter_mut().collect(), wanted.threads, work).into_iter().collect()
}

/// Whether two blows are nearly the same.
fn same(a: &Numbers, b: &Numbers) -> bool {
    [0, 2].iter().all(|k| (a[*k] - b[*k]).abs() <= REPEATS * b[*k].abs())
}

/// The number of blows after which the last ones repeat nearly, if they do.
fn repeats(list: &[Numbers], most: usize) -> Option<usize> {
    (1..=most.min(MOST_RETURNS)).find(|k| {
        let recent = &list[list.len() - (8 + 2 * k)..];
        recent.iter().zip(&recent[*k..]).all(|(a, b)| same(a, b))
    })
}

/// The cycle that a simulation is near, of so many returns or a multiple of them, if it is stable
/// and has its rate. A cycle that repels a little may have an attracting one close by, of twice as
/// many returns.
fn attracting(
    scene: &Scene,
    returns: usize,
    most: usize,
    member: &Member,
) -> Result<Option<Steady>, Error> {
    for multiple in (returns..=most).step_by(returns).take(MULTIPLES) {
        if let Some(cycle) = solved(scene, multiple, member)? {
            return Ok(Some(cycle));
        }
    }
    Ok(None)
}

fn solved(scene: &Scene, returns: usize, member: &Member) -> Result<Option<Steady>, Error> {
    let restored = || -> Result<Machine, Error> {
        let mut machine = scene.machine()?;
        machine.restore(&member.machine.state())?;
        Ok(machine)
    };
    let search = Search { returns, settle: 1, steps: 12, ..Search::default() };
    let cycle = match find_from(restored()?, scene, &search, &[]) {
        Ok(cycle) => cycle,
        Err(CycleError::Engine(error)) => return Err(error),
        Err(_) => return Ok(None),
    };
    let observed = Means::exact(&member.list[member.list.len() - 2 * returns..]).mean.tip_rate();
    let blows = cycle.response.strikes.len();
    let near = (cycle.response.tip_rate - observed).abs() <= NEAR * observed.abs();
    if !near || !cycle.is_stable() || blows == 0 {
        return Ok(None);
    }
    let mut machine = restored()?;
    machine.restore(&cycle.state)?;
    // The first blows have a part from before.
    let mut once = Member::from(machine);
    once.strike(3 * blows, search.limit)?;
    let means = Means::exact(last(&once.list, blows));
    let multiplier = cycle.multipliers.first().map_or(1.0, |m| math::norm(*m));
    let mut simulation = Member { list: member.list.clone(), ..Member::from(restored()?) };
    if !goes_to(&mut simulation, &means.mean, blows, multiplier)? {
        return Ok(None);
    }
    let found = Steady::of(Kind::Cycle(returns), means, true);
    Ok(Some(Steady { cycle: Some(cycle), ..found }))
}

/// The last blows.
fn last(list: &[Numbers], count: usize) -> &[Numbers] {
    &list[list.len().saturating_sub(count)..]
}

/// Whether a simulation comes to a stable cycle of so many blows and these means.
fn goes_to(
    simulation: &mut Member,
    cycle: &Averages,
    blows: usize,
    multiplier: f64,
) -> Result<bool, Error> {
    let off = |list: &[Numbers]| {
        let (means, known) = (Means::exact(last(list, blows)).mean.of_motion(), cycle.of_motion());
        means.iter().zip(known).map(|(mean, known)| (mean / known - 1.0).abs()).fold(0.0, f64::max)
    };
    let before = off(&simulation.list);
    if before <= MET {
        return Ok(true);
    }
    let most = (FOLLOWED / blows).max(1);
    let (mut cycles, mut left) = (0, 1.0);
    while cycles < most && left > LEFT {
        (cycles, left) = (cycles + 1, left * multiplier);
    }
    let count = simulation.list.len() + cycles * blows;
    simulation.strike(count, Search::default().limit)?;
    Ok(simulation.list.len() == count && off(&simulation.list) <= (BESIDE + left) * before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::periodic::find::find;
    use crate::quantities::parameters::Fidelity;

    fn rigid() -> Scene {
        let mut scene = Scene::default();
        scene.parameters.fidelity = Fidelity::Rigid;
        scene
    }

    fn simulated(scene: &Scene, count: usize) -> Result<Vec<Member>, Error> {
        let mut members: Vec<_> =
            (0..4).map(|k| Member::new(scene, k)).collect::<Result<_, _>>()?;
        grow(&mut members, count, &Wanted { threads: 2, ..Wanted::default() })?;
        Ok(members)
    }

    /// A cycle is where the motion goes if it has the rate of the blows simulated, to 1 %.
    #[test]
    fn a_cycle_of_another_rate_than_the_blows_is_not_their_answer() -> Result<(), Error> {
        let scene = rigid();
        let mut members = simulated(&scene, SETTLED)?;
        let member = &mut members[0];
        assert!(solved(&scene, 1, member)?.is_some());
        for (part, taken) in [(1.005, true), (1.03, false), (0.97, false)] {
            let list = member.list.clone();
            member.list.iter_mut().for_each(|blow| blow[1] *= part);
            assert_eq!(solved(&scene, 1, member)?.is_some(), taken, "{part}");
            member.list = list;
        }
        Ok(())
    }

    /// Two stable motions whose rates differ by 0.15 %: the cycle that the equation has near the blows is
    /// not where they go.
    #[test]
    fn a_stable_cycle_close_by_is_not_the_answer_where_the_blows_go_elsewhere() -> Result<(), Error>
    {
        let mut scene = rigid();
        let p = &mut scene.parameters;
        (p.bit.length, scene.inputs.feed_force) = (0.2656, 3850.0);
        (p.rock.stiffness, p.rock.unloading_ratio) = (2.0557e8, 11.89);
        (p.rock.viscosity, p.rock.energy_barrier) = (1.7e5, 4.0);
        let close = find(&scene, &Search::default(), &[]).expect("there is one");
        assert!(close.is_stable());
        let answer = steady(&scene, &Wanted::default(), &mut |_, _| true)?;
        assert_eq!(answer.kind, Kind::Cycle(2));
        let long = &simulated(&scene, 400)?[0].list;
        let rate = Means::exact(last(long, 100)).mean.tip_rate();
        // Both are solved to 1e-10 of the state.
        assert!((answer.mean.tip_rate() / rate - 1.0).abs() < 1e-8);
        let apart = (close.response.tip_rate / rate - 1.0).abs();
        assert!((1e-3..NEAR).contains(&apart), "{apart}");
        Ok(())
    }

    /// Without feed the rigid reference never repeats: simulations that begin a little apart become
    /// different ones. With feed all come to one cycle, which one simulation shows as well as four.
    #[test]
    fn simulations_of_a_mean_are_different_ones_or_count_once() -> Result<(), Error> {
        let mut scene = rigid();
        assert_eq!(apart(&simulated(&scene, 60)?).len(), 1);
        scene.inputs.feed_force = 0.0;
        let members = simulated(&scene, 60)?;
        assert_eq!(apart(&members).len(), 4);
        // From the first blow on, if not by much.
        assert!(members[1..].iter().all(|other| other.list[0] != members[0].list[0]));
        Ok(())
    }
}
