//! Comparison of many drawn scenes with the reference, and its results.

use crate::comparison::compare::{Differences, Worst, beside, compare};
use crate::comparison::known::{Account, INSTANTS, PATIENCE};
use crate::drawn::scenes::{self, RandomScene};
use crate::laws::properties::refusal;
use clap::ValueEnum;
use hammer::Error;
use proptest::strategy::{BoxedStrategy, Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Results of many scenes.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Tally {
    /// Scenes drawn.
    pub scenes: u32,
    /// Events compared.
    pub events: usize,
    /// Instants compared.
    pub instants: usize,
    /// Scenes that double precision determines to their end.
    pub whole: u32,
    /// Scenes that the engine refused, for one of [`crate::laws::properties::REFUSALS`].
    pub refused: u32,
    /// Scenes whose difference is explained by the engine's own measure of its bases.
    pub rough: Vec<String>,
    /// Scenes whose events differ after a guard has come to rest within rounding of its level.
    pub at_rest: Vec<String>,
    /// Scenes that differ by more than is allowed, but by less than a guard resolves.
    pub unseen: Vec<String>,
    /// The largest difference that is allowed, among the numbers and among the events' times.
    pub worst: [Worst; 2],
    /// The largest difference of an excused scene, over what is allowed.
    #[serde(default)]
    pub excused: f64,
    /// Scenes that disagree, each with the reason.
    pub failures: Vec<String>,
}

/// Scenes that one seed draws.
const BATCH: u32 = 100;
/// Distinguishes these scenes from those drawn for other uses.
const STREAM: u8 = 1;

/// Drawn scenes in numbered batches from a number on; they are the same in every run. `stream` distinguishes the
/// uses.
pub(crate) fn batches(
    strategy: &impl Strategy<Value = RandomScene>,
    stream: u8,
    from: u32,
    scenes: u32,
) -> impl Iterator<Item = (u32, Vec<RandomScene>)> {
    (0..scenes.div_ceil(BATCH)).map(move |k| {
        let mut seed = [stream; 32];
        seed[..4].copy_from_slice(&(from + k).to_le_bytes());
        let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
        let mut runner = TestRunner::new_with_rng(Config::default(), rng);
        let mut one = || strategy.new_tree(&mut runner).expect("a scene can be drawn").current();
        (from + k, (0..BATCH.min(scenes - k * BATCH)).map(|_| one()).collect())
    })
}

/// Kinds of drawn scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum, Serialize, Deserialize)]
pub enum Kind {
    /// Loads are constant, but for the relay.
    Still,
    /// Everything at once, with a script of actions.
    Mixed,
    /// The same with air as the drive.
    Air,
    /// The same without air, with a line at the piston.
    Line,
    /// Hammers that strike twice.
    Blows,
}

impl Kind {
    fn strategy(self) -> BoxedStrategy<RandomScene> {
        match self {
            Self::Still => scenes::meshed().boxed(),
            Self::Mixed => scenes::mixed().boxed(),
            Self::Air => scenes::airy().boxed(),
            Self::Line => scenes::lined().boxed(),
            Self::Blows => scenes::striking().boxed(),
        }
    }

    /// What the reference determines of a scene of this kind.
    fn account(self, case: &RandomScene) -> Result<Account, Error> {
        match self {
            // Two blows are some thousand radians of the fastest mode apart.
            Self::Blows => Account::over(case, 40 * PATIENCE),
            _ => Account::of(case),
        }
    }
}

/// So many drawn scenes of a kind; they are the same in every run.
pub fn drawn(kind: Kind, scenes: u32) -> Vec<RandomScene> {
    batches(&kind.strategy(), STREAM, 0, scenes).flat_map(|(_, list)| list).collect()
}

/// Name of a drawn scene: its batch, and its place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Name {
    pub(crate) batch: u32,
    pub(crate) place: usize,
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.batch, self.place)
    }
}

impl FromStr for Name {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts =
            text.split_once('.').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        match parts {
            Some((batch, place)) if place < BATCH as usize => Ok(Self { batch, place }),
            _ => Err(format!("batch and place, the latter below {BATCH}: 12.34")),
        }
    }
}

/// Stored results of drawn scenes, by batch.
pub type Kept = BTreeMap<Kind, BTreeMap<u32, Tally>>;

/// Compares so many drawn scenes of a kind on all cores; they are the same in every run. Disagreements are reported
/// at once, and the results of each batch when it is complete.
pub fn tally(
    (scenes, from): (u32, u32),
    kind: Kind,
    mut tell: impl FnMut(&str) + Send,
    mut done: impl FnMut(u32, &Tally),
) -> Tally {
    let threads = thread::available_parallelism().map_or(1, |count| count.get());
    let mut whole = Tally::default();
    for (batch, list) in batches(&kind.strategy(), STREAM, from, scenes) {
        let (next, tell) = (AtomicUsize::new(0), Mutex::new(&mut tell));
        let share = || {
            let mut part = Tally::default();
            while let index = next.fetch_add(1, Ordering::Relaxed)
                && let Some(case) = list.get(index)
            {
                let mut tell = |text: &str| tell.lock().expect("no panic")(text);
                part.add(&format!("scene {batch}.{index}"), kind, case, &mut tell);
            }
            part
        };
        let mut found = Tally::default();
        thread::scope(|scope| {
            let shares: Vec<_> = (0..threads).map(|_| scope.spawn(share)).collect();
            shares.into_iter().for_each(|share| found.join(share.join().expect("no panic")));
        });
        done(batch, &found);
        whole.join(found);
    }
    whole
}

/// Compares drawn scenes of these names; reports the `events` of each if asked.
pub fn these(names: &[Name], kind: Kind, events: bool, mut tell: impl FnMut(&str)) -> Tally {
    let mut tally = Tally::default();
    let strategy = kind.strategy();
    for name in names {
        let mut lists = batches(&strategy, STREAM, name.batch, BATCH);
        let case = lists.next().and_then(|(_, mut list)| list.drain(..).nth(name.place));
        let case = case.expect("a batch has as many scenes as a name can tell apart");
        if events {
            let account = kind.account(&case);
            tell(&account.map_or_else(|error| error.to_string(), |account| beside(&account)));
        }
        tally.add(&format!("scene {name}"), kind, &case, &mut tell);
    }
    tally
}

/// The reference's accounts of so many drawn scenes, without those that the engine refuses.
pub fn accounts((scenes, from): (u32, u32), kind: Kind) -> Vec<Account> {
    let strategy = kind.strategy();
    let drawn = batches(&strategy, STREAM, from, scenes).flat_map(|(_, list)| list);
    let accounts = drawn.filter_map(|case| kind.account(&case).ok());
    accounts.filter(|account| compare(account).is_ok()).collect()
}

/// Compares the engine with accounts of scenes that it does not refuse.
pub fn against(accounts: &[Account], mut tell: impl FnMut(&str)) -> Tally {
    let mut tally = Tally::default();
    for (index, account) in accounts.iter().enumerate() {
        tally.note(&format!("account {index}"), &account.case, compare(account), &mut tell);
    }
    tally.failures.extend((0..tally.refused).map(|_| "refused".to_owned()));
    tally
}

impl Tally {
    /// Adds the results of others.
    pub fn join(&mut self, other: Self) {
        self.scenes += other.scenes;
        self.events += other.events;
        self.instants += other.instants;
        self.whole += other.whole;
        self.refused += other.refused;
        self.rough.extend(other.rough);
        self.at_rest.extend(other.at_rest);
        self.unseen.extend(other.unseen);
        self.excused = self.excused.max(other.excused);
        self.failures.extend(other.failures);
        for (worst, other) in self.worst.iter_mut().zip(other.worst) {
            worst.note(other);
        }
    }

    /// Compares one more scene.
    pub fn add(&mut self, name: &str, kind: Kind, case: &RandomScene, tell: &mut impl FnMut(&str)) {
        let found = kind.account(case).and_then(|account| compare(&account));
        self.note(name, case, found, tell);
    }

    /// Counts the results of one more scene.
    fn note(
        &mut self,
        name: &str,
        case: &RandomScene,
        found: Result<Differences, Error>,
        tell: &mut impl FnMut(&str),
    ) {
        self.scenes += 1;
        let violation = match found {
            Ok(found) => {
                self.events += found.events;
                self.instants += found.instants;
                self.whole += u32::from(found.instants == INSTANTS);
                if found.none() {
                    self.worst[0].note(found.observed);
                    self.worst[1].note(found.timing);
                    return;
                }
                let excuses = [
                    (found.from_rough_bases(), "rough bases", &mut self.rough),
                    (found.from_guard_at_rest(), "guard at rest", &mut self.at_rest),
                    (found.is_invisible(), "invisible", &mut self.unseen),
                ];
                if let Some((_, why, list)) = excuses.into_iter().find(|excuse| excuse.0) {
                    list.push(format!("{name}: {why}: {found:?}"));
                    self.excused = self.excused.max(found.ratio());
                    return tell(list.last().expect("just pushed"));
                }
                format!("{found:?}")
            }
            Err(error) if refusal(case, &error).is_some() => {
                self.refused += 1;
                return;
            }
            Err(error) => error.to_string(),
        };
        // In the form in which a test stores it.
        let stored = serde_json::to_string(case).unwrap_or_default();
        let text = format!("{name}: {violation}: {stored}");
        tell(&text);
        self.failures.push(text);
    }

    /// A summary in one line.
    pub fn line(&self) -> String {
        let by = match self.excused {
            0.0 => String::new(),
            most => format!(", by {most:.0} times what is allowed at most"),
        };
        format!(
            "{} scenes, {} decided to their end, {} refused, {} events, {} instants: {} unexplained; excused \
             {} by their rough bases, {} after a guard at rest, {} below what a guard resolves{by}; of the others \
             {:.3} of what is allowed at most ({}), {:.3} in time ({})",
            self.scenes,
            self.whole,
            self.refused,
            self.events,
            self.instants,
            self.failures.len(),
            self.rough.len(),
            self.at_rest.len(),
            self.unseen.len(),
            self.worst[0].ratio(),
            self.worst[0].what,
            self.worst[1].ratio(),
            self.worst[1].what,
        )
    }
}
