//! A random host of FMI 3.0.

use super::{STRUCTURES, Structure, Watchdog, pick, split, state, step_size, value};
use crate::support::host::vr;
use crate::support::library::{ERROR, Handle, Library, OK};
use crate::support::three::Three;
use dth_hammer::events::Extra;
use dth_hammer::symbols;
use hammer::variables::VARIABLES;
use rand::{Rng, RngExt};

/// Number of instances, few enough that calls meet them in all phases.
const INSTANCES: usize = 4;
/// Calls whose only argument is the instance.
const PLAIN: [&str; 8] = [
    "EnterEventMode",
    "EnterStepMode",
    "EnterConfigurationMode",
    "ExitConfigurationMode",
    "ExitInitializationMode",
    "EvaluateDiscreteStates",
    "Terminate",
    "Reset",
];
/// Getters and setters by the types that variables have.
const KINDS: [&str; 5] = ["Float64", "Int32", "UInt64", "Boolean", "Clock"];

/// A random host: it keeps instances in all phases, and states, live and stale.
pub struct ThreeAbuser<'a> {
    library: &'a Library,
    rng: Box<dyn Rng>,
    hosts: Vec<Three<'a>>,
    states: Vec<Handle>,
    held: Vec<Handle>,
    pub accepted: usize,
}

impl<'a> ThreeAbuser<'a> {
    /// A random host with one instance. The random numbers determine everything that follows.
    pub fn new(library: &'a Library, rng: impl Rng + 'static) -> Self {
        let (hosts, states) = (vec![Three::new(library, true, true)], vec![Handle(0)]);
        Self { library, rng: Box::new(rng), hosts, states, held: Vec::new(), accepted: 0 }
    }

    fn reference(&mut self) -> u32 {
        let extras: Vec<u32> = Extra::all().map(Extra::reference).collect();
        match self.rng.random_range(0..20) {
            0 => self.rng.random(),
            1..6 => pick(&mut self.rng, &extras),
            _ => self.rng.random_range(0..VARIABLES.len() as u32),
        }
    }

    /// Makes one call.
    pub fn act(&mut self, dog: &Watchdog) {
        let (at, choice) =
            (self.rng.random_range(0..self.hosts.len()), self.rng.random_range(0..24));
        dog.about_to(format!("kind {choice} of FMI 3.0"));
        let status = match choice {
            0 => self.instantiate(),
            1..4 => self.bring_up(at),
            4..6 => {
                let call = pick(&mut self.rng, &PLAIN);
                self.hosts[at].plain(call)
            }
            6..12 => self.step(at),
            12..16 => self.access(at, "Get"),
            16..19 => self.access(at, "Set"),
            19 => self.hosts[at].try_update(),
            20 => self.save(at),
            21 => {
                let state = state(&mut self.rng, &self.states);
                self.hosts[at].restore(state)
            }
            22 => self.forget(at),
            _ => self.nothing(at),
        };
        assert!(status == OK || status == ERROR, "{status}");
        self.accepted += usize::from(status == OK);
        for line in self.hosts.iter().flat_map(Three::lines) {
            assert!(!line.starts_with("internal error"), "a panic was caught: {line}");
        }
    }

    fn instantiate(&mut self) -> i32 {
        let [events, early] = [self.rng.random(), self.rng.random()];
        self.hosts.push(Three::new(self.library, events, early));
        if self.hosts.len() > INSTANCES {
            self.hosts.remove(0);
        }
        OK
    }

    fn bring_up(&mut self, at: usize) -> i32 {
        self.hosts[at].plain("Reset");
        let Structure { source, counts, reals } = pick(&mut self.rng, &STRUCTURES);
        self.hosts[at].access("SetInt64", &[vr("drive.source")], &mut [i64::from(source)]);
        let (references, mut values) = split(counts);
        self.hosts[at].access("SetInt32", &references, &mut values);
        let (references, mut values) = split(reals);
        self.hosts[at].access("SetFloat64", &references, &mut values);
        let start = if self.rng.random_range(0..9) == 0 { value(&mut self.rng) } else { 0.0 };
        self.hosts[at].enter_initialization(start);
        let left = self.hosts[at].plain("ExitInitializationMode");
        if self.rng.random() {
            self.hosts[at].try_update();
            self.hosts[at].plain("EnterStepMode");
        }
        left
    }

    fn step(&mut self, at: usize) -> i32 {
        let mut now = [0.0];
        self.hosts[at].access("GetFloat64", &[Extra::Time.reference()], &mut now);
        let point = if self.rng.random_range(0..10) > 0 { now[0] } else { value(&mut self.rng) };
        let size = step_size(&mut self.rng);
        let (status, ended) = self.hosts[at].try_step(point, size);
        if ended.event && status == OK && self.rng.random_range(0..4) > 0 {
            self.hosts[at].plain("EnterEventMode");
            self.hosts[at].happened();
            self.hosts[at].try_update();
            self.hosts[at].plain("EnterStepMode");
        }
        status
    }

    fn access(&mut self, at: usize, way: &str) -> i32 {
        let references: Vec<u32> =
            (0..self.rng.random_range(0..4)).map(|_| self.reference()).collect();
        let kind = pick(&mut self.rng, &KINDS);
        let call = format!("{way}{kind}");
        let numbers: Vec<f64> = references.iter().map(|_| value(&mut self.rng)).collect();
        let bits = |x: &f64| match kind {
            "Int32" | "UInt64" | "Boolean" => *x as i64 as u64 % 40,
            _ => x.to_bits(),
        };
        // Room for the widest type.
        let mut values: Vec<u64> = numbers.iter().map(bits).collect();
        self.hosts[at].access(&call, &references, &mut values)
    }

    fn save(&mut self, at: usize) -> i32 {
        let mut state =
            if self.rng.random() { Handle(0) } else { state(&mut self.rng, &self.states) };
        let fresh = state.0 == 0;
        let status = self.hosts[at].save(&mut state);
        if status == OK && fresh {
            self.states.push(state);
            self.held.push(state);
        }
        status
    }

    fn forget(&mut self, at: usize) -> i32 {
        let mut state = state(&mut self.rng, &self.states);
        let freed = state;
        let status = self.hosts[at].forget(&mut state);
        if status == OK {
            self.held.retain(|held| *held != freed);
        }
        status
    }

    /// Calls a function with null pointers and zeros after the instance.
    fn nothing(&mut self, at: usize) -> i32 {
        let other = ["GetVersion", "Instantiate", "FreeInstance"];
        let takes = |name: &String| !other.iter().any(|begin| name[4..].starts_with(begin));
        let names: Vec<String> =
            symbols().into_iter().filter(|n| n.starts_with("fmi3")).filter(takes).collect();
        let name = &names[self.rng.random_range(0..names.len())];
        self.library.with_nothing(name, self.hosts[at].handle)
    }

    /// Frees all live handles.
    pub fn clean_up(&mut self) {
        let helper = Three::new(self.library, false, false);
        for mut state in std::mem::take(&mut self.held) {
            helper.forget(&mut state);
        }
        self.hosts.clear();
    }
}
