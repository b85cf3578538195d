//! The long-run response of a hammer, whether it repeats or not.
//!
//! Blows are simulated. If they nearly repeat, the simulation goes on until they repeat to [`CLOSED`], and the
//! answer is the mean of the last ones. Otherwise several simulations, from slightly different starts that
//! drift apart, are averaged ([`Means`]) until the error asked for is reached. An unstable cycle is never found
//! in this way. Of several stable motions, the answer is the one that the scene's own start leads to.

use crate::energy::ledger::Energies;
use crate::error::Error;
use crate::interrupt::in_threads;
use crate::laws::event::{Displacement, Event};
use crate::machine::{Machine, Observer};
use crate::means::averages::{Averages, Means, NUMBERS, Numbers};
use crate::scene::Scene;

/// What a hammer does in the long run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It repeats after so many blows.
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
    /// Standard errors of the means; 0 of a motion that repeats.
    pub error: Averages,
    /// Standard deviations from blow to blow.
    pub spread: Averages,
    /// Blows that the means are of.
    pub blows: usize,
    /// True if the error asked for was reached.
    pub reached: bool,
}

/// How to search for a long-run response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Largest standard error of each mean, relative to the mean; infinity where it does not matter.
    pub error: Averages,
    /// Most blows simulated.
    pub blows: usize,
    /// A hammer that strikes no blow for so long has stalled, s.
    pub limit: f64,
    /// Longest cycle that is sought, in blows; 0: none. More than [`MOST_REPEATING`] has no effect.
    pub repeating: usize,
    /// Threads that simulate. The answer does not depend on their number.
    pub threads: usize,
}

impl Default for Wanted {
    fn default() -> Self {
        let error = Averages::of_rates(0.01);
        Self { error, blows: 20_000, limit: 10.0, repeating: 8, threads: 1 }
    }
}

/// Simulations of a mean, and the fewest blows of each. From fewer, the error is too uncertain to end the
/// search.
const MEMBERS: usize = 4;
const FEWEST: usize = 300;
/// Blows before a cycle is sought.
const SETTLED: usize = 40;
/// Blows that must repeat, in addition to two rounds of the cycle.
const WINDOW: usize = 8;
/// The longest cycle that the first [`SETTLED`] blows can show, in blows.
pub const MOST_REPEATING: usize = (SETTLED - WINDOW) / 2;
/// Least and largest factor by which simulations grow before the error is looked at again, and a reserve on the
/// number of blows that the error suggests. More frequent looks would stop where the error happens to be
/// underestimated.
const GROWTH: [f64; 3] = [1.5, 4.0, 1.2];
/// Blows nearly repeat if their speeds and periods differ by at most this share.
const NEAR: f64 = 5e-3;
/// Blows repeat if they differ by at most this share. Rounding contributes 1e-11. If the transient decays by a
/// factor `r` a blow, `r / (1 - r)` of the last difference is still to come.
const CLOSED: f64 = 1e-9;
/// Blows that repeat to this share after fewer rounds than to [`CLOSED`] have not settled yet.
const ALIKE: f64 = 1e-6;
/// Further blows in which a motion that nearly repeats may come to repeat; if it takes longer, it is averaged.
const FOLLOWED: usize = 200;
/// How much faster the piston starts in each simulation than in the previous one, m/s.
const APART: f64 = 0.03;
/// Interval at which a simulation without blows is tested for a stall, s.
const STEP: f64 = 0.25;

/// The long-run response of a scene. `progress` is told the number of blows and the present errors
/// ([`Means::error_ratio`]); it ends the search by returning false.
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
    let count = MEMBERS.min(wanted.blows / SETTLED).max(1);
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
        // A single simulation shows a cycle; only a mean needs several.
        let end = if next < fewest { fewest } else { most };
        next = ((growth * next as f64) as usize).min(end);
        if next >= fewest {
            for k in members.len()..count {
                members.push(Member::new(scene, k)?);
            }
        }
    }
}

/// The first `count` blows of each simulation that differs from the others. Simulations of a stable motion come
/// to the same blows even before these repeat, and then count as one.
fn distinct(members: &[Member], count: usize) -> Vec<&[Numbers]> {
    let mut different: Vec<&[Numbers]> = Vec::new();
    for member in members {
        let list = &member.list[..count];
        let alike =
            |other: &&[Numbers]| last(other, 3).iter().zip(last(list, 3)).all(within(CLOSED));
        if !different.iter().any(alike) {
            different.push(list);
        }
    }
    different
}

impl Steady {
    fn of(kind: Kind, means: Means, reached: bool) -> Self {
        let Means { mean, error, spread, blows } = means;
        Self { kind, mean, error, spread, blows, reached }
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

/// Stops the machine at each blow.
#[derive(Default)]
struct Way {
    struck: bool,
    rebound: f64,
}

impl Observer for Way {
    fn after(&mut self, machine: &Machine, event: Event) -> bool {
        let motion = machine.motion();
        if event == Event::OPENING {
            self.rebound = -motion.point(&motion.tracks, Displacement::PISTON, 0.0).velocity;
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

    /// Simulates up to a number of blows, or until no more follow.
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

/// Whether speeds and periods of two blows differ by no more than a share.
fn within(part: f64) -> impl Fn((&Numbers, &Numbers)) -> bool {
    move |(a, b)| [0, 2].iter().all(|k| (a[*k] - b[*k]).abs() <= part * b[*k].abs())
}

/// The length of the shortest cycle to which the last blows repeat, to a share; none if they do not.
fn repeats(list: &[Numbers], most: usize, part: f64) -> Option<usize> {
    (1..=most.min(MOST_REPEATING)).find(|k| {
        let recent = last(list, WINDOW + 2 * k);
        recent.iter().zip(&recent[*k..]).all(within(part))
    })
}

/// Continues a simulation whose blows nearly repeat until they repeat. Returns the length of the cycle; none if
/// they never do.
fn followed(member: &mut Member, wanted: &Wanted) -> Result<Option<usize>, Error> {
    let end = member.list.len() + FOLLOWED;
    while repeats(&member.list, wanted.repeating, NEAR).is_some() {
        let found = repeats(&member.list, wanted.repeating, CLOSED);
        // A transient that alternates in sign closes over two rounds sooner than over one.
        let settled = found == repeats(&member.list, wanted.repeating, ALIKE);
        let count = member.list.len() + 1;
        if found.is_some() && settled {
            return Ok(found);
        }
        if count > end {
            break;
        }
        member.strike(count, wanted.limit)?;
        if member.list.len() < count {
            break;
        }
    }
    Ok(None)
}

fn last(list: &[Numbers], count: usize) -> &[Numbers] {
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

    fn simulated(scene: &Scene, count: usize) -> Result<Vec<Member>, Error> {
        let mut members: Vec<_> =
            (0..4).map(|k| Member::new(scene, k)).collect::<Result<_, _>>()?;
        grow(&mut members, count, &Wanted { threads: 2, ..Wanted::default() })?;
        Ok(members)
    }

    /// Speeds of `10 + part` and `10` in turn have a cycle of one blow to a larger share, and of two blows to
    /// any.
    #[test]
    fn blows_repeat_after_as_few_as_they_agree() {
        let part = 1e-6;
        let list: Vec<Numbers> = (0..40)
            .map(|k| {
                let mut blow = [1.0; NUMBERS];
                blow[2] = 10.0 * (1.0 + part * f64::from(k % 2));
                blow
            })
            .collect();
        assert_eq!(repeats(&list, 8, 2.0 * part), Some(1));
        assert_eq!(repeats(&list, 8, 0.5 * part), Some(2));
        assert_eq!(repeats(&list, 1, 0.5 * part), None);
        assert_eq!(repeats(&list, 0, 1.0), None);
    }

    /// Without feed the rigid reference never repeats, and simulations from slightly different starts become
    /// different. With feed all four come to the same cycle.
    #[test]
    fn simulations_of_a_mean_are_different_ones_or_count_once() -> Result<(), Error> {
        let mut scene = rigid();
        assert_eq!(distinct(&simulated(&scene, 60)?, 60).len(), 1);
        scene.inputs.feed_force = 0.0;
        let members = simulated(&scene, 60)?;
        assert_eq!(distinct(&members, 60).len(), 4);
        // They differ from the first blow on, if only a little.
        assert!(members[1..].iter().all(|other| other.list[0] != members[0].list[0]));
        Ok(())
    }
}
