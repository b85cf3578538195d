//! Random hosts of both standards, and a watchdog for them.

#![allow(dead_code, reason = "each test uses its part")]

pub mod forger;
pub mod three;
pub mod watchdog;

use crate::support::host::vr;
use crate::support::library::{Callbacks, ERROR, Handle, Library, Log, OK};
use dth_hammer::GUID;
use hammer::variables::{Role, VARIABLES};
use rand::{Rng, RngExt};
pub use watchdog::{Stopwatch, Watchdog};

/// A random host: it keeps handles, live and stale, and makes random calls.
pub struct Abuser<'a> {
    library: &'a Library,
    log: &'a Log,
    rng: Box<dyn Rng>,
    instances: Vec<Handle>,
    states: Vec<Handle>,
    bytes: Vec<u8>,
    live: Vec<Handle>,
    held: Vec<Handle>,
    pub accepted: usize,
}

const CRAZY: [f64; 12] = [
    0.0,
    -0.0,
    -1.0,
    1.0,
    1e-300,
    1e300,
    f64::MAX,
    f64::MIN_POSITIVE,
    f64::EPSILON,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
];

/// Bodies and meshes that need little time, so that most of it is spent in calls.
#[derive(Clone, Copy)]
pub struct Structure {
    /// The drive's source, as the number of its item: a relay, outside pressures, air.
    pub source: i32,
    pub counts: &'static [(&'static str, i32)],
    pub reals: &'static [(&'static str, f64)],
}

const COARSE: &[(&str, i32)] = &[("piston.elements", 4), ("bit.elements", 3), ("work_limit", 2)];
/// The bit of these soon hangs on the ring, so that the drive is vented.
const CASED: &[(&str, f64)] = &[
    ("casing.mass", 40.0),
    ("casing.impedance", 4e3),
    ("chuck.travel", 2e-3),
    ("chuck.idle_travel", 1e-3),
];

/// Piston and bit; a casing whose bit hangs on the ring after some blows and vents the drive; a string whose joints
/// part and pull at each blow; pressures that are exchanged at steps; air in a casing.
pub const STRUCTURES: [Structure; 5] = [
    Structure { source: 1, counts: COARSE, reals: &[] },
    Structure { source: 1, counts: COARSE, reals: CASED },
    Structure {
        source: 1,
        counts: &[
            ("work_limit", 2),
            ("piston.elements", 4),
            ("bit.elements", 12),
            ("mesh.degree", 3),
            ("drill.rods", 2),
        ],
        reals: &[
            ("drill.shank.length", 0.1),
            ("drill.rod.length", 0.1),
            ("drill.coupling.length", 0.0),
            ("drill.joint.stiffness", 2e9),
            ("drill.joint.slack", 1e-5),
        ],
    },
    Structure {
        source: 3,
        counts: COARSE,
        reals: &[("coupling.delay", 0.5), ("drive_pressure", 1.2e6), ("return_pressure", 2e5)],
    },
    Structure { source: 4, counts: COARSE, reals: CASED },
];

/// References and values of variables by name.
pub fn split<T: Copy>(named: &[(&str, T)]) -> (Vec<u32>, Vec<T>) {
    named.iter().map(|(name, value)| (vr(name), *value)).unzip()
}

fn pick<T: Copy>(rng: &mut dyn Rng, from: &[T]) -> T {
    from[rng.random_range(0..from.len())]
}

/// Mostly one of these states, live or stale; sometimes null, or an invalid handle.
fn state(rng: &mut dyn Rng, states: &[Handle]) -> Handle {
    match rng.random_range(0..8) {
        0 => Handle(0),
        1 => Handle(rng.random::<u64>() as usize),
        _ => pick(rng, states),
    }
}

fn value(rng: &mut dyn Rng) -> f64 {
    match rng.random_range(0..3) {
        0 => pick(rng, &CRAZY),
        1 => rng.random_range(-1e4..1e4),
        _ => rng.random_range(0.0..1.0),
    }
}

/// A step size from nothing to 3 ms, or an absurd one. A step of more than a second is legal but slow.
fn step_size(rng: &mut dyn Rng) -> f64 {
    match rng.random_range(0..10) {
        0 => Some(value(rng)).filter(|v| !(1.0..=1e3).contains(v)).unwrap_or(-1.0),
        1 => 0.0,
        _ => rng.random_range(0.0..3e-3),
    }
}

impl<'a> Abuser<'a> {
    /// A random host with one instance. The random numbers determine everything that follows.
    pub fn new(library: &'a Library, log: &'a Log, rng: impl Rng + 'static) -> Self {
        let first = library.instantiate(Some("x"), 1, Some(GUID), None, None, false);
        Self {
            library,
            log,
            rng: Box::new(rng),
            instances: vec![first],
            states: vec![Handle(0)],
            bytes: Vec::new(),
            live: vec![first],
            held: Vec::new(),
            accepted: 0,
        }
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        pick(&mut self.rng, from)
    }

    /// Mostly an instance, live or stale; sometimes null, or an invalid handle.
    fn instance(&mut self) -> Handle {
        match self.rng.random_range(0..40) {
            0 => Handle(0),
            1 => Handle(self.rng.random::<u64>() as usize),
            2 => self.state(),
            3..8 => self.pick(&self.instances.clone()),
            _ => self.live.last().copied().unwrap_or(Handle(0)),
        }
    }

    fn state(&mut self) -> Handle {
        state(&mut self.rng, &self.states)
    }

    fn value(&mut self) -> f64 {
        value(&mut self.rng)
    }

    fn reference(&mut self) -> u32 {
        match self.rng.random_range(0..20) {
            0 => self.rng.random(),
            1 => VARIABLES.len() as u32,
            _ => self.rng.random_range(0..VARIABLES.len() as u32),
        }
    }

    /// A parameter or input, and a value that is mostly near its default.
    fn reasonable(&mut self) -> (u32, f64) {
        loop {
            let reference = self.rng.random_range(0..VARIABLES.len() as u32);
            let start = match &VARIABLES[reference as usize].role {
                Role::Parameter(row) => row.slot.read(&hammer::Parameters::default()),
                Role::Input(row) => *(row.start)(&mut hammer::InputValues::default()),
                _ => continue,
            };
            let factor = match self.rng.random_range(0..4) {
                0 => 10_f64.powf(self.rng.random_range(-6.0..6.0)),
                _ => self.rng.random_range(0.5..2.0),
            };
            // A parameter that is zero by default is given the factor itself.
            return (reference, if start == 0.0 { factor } else { start * factor });
        }
    }

    /// The variables that differ from their defaults, to find out why a call hangs.
    fn scene(&self, h: Handle) -> String {
        let (parameters, mut inputs) =
            (hammer::Parameters::default(), hammer::InputValues::default());
        let mut log = String::new();
        for (reference, variable) in (0u32..).zip(VARIABLES.iter()) {
            let usual = match &variable.role {
                Role::Parameter(row) => row.slot.read(&parameters),
                Role::Input(row) => *(row.start)(&mut inputs),
                _ => continue,
            };
            let mut found = [usual];
            self.library.get_reals(h, &[reference], &mut found);
            if found != [usual] {
                log += &format!("{} = {:e}, ", variable.name, found[0]);
            }
        }
        log
    }

    fn note(&mut self, status: i32) {
        assert!(status == OK || status == ERROR, "{status}");
        self.accepted += usize::from(status == OK);
    }

    /// Makes one call.
    pub fn act(&mut self, dog: &Watchdog) {
        let h = self.instance();
        let choice = self.rng.random_range(0..30);
        dog.about_to(format!("kind {choice} on {h:?}"));
        let status = match choice {
            0 => self.instantiate(),
            1 => self.free(h),
            2..5 => self.bring_up(h),
            5 => self.library.plain("fmi2Reset", h),
            6 => self.plain(h),
            7..13 => self.step(h, dog),
            13..16 => self.get(h),
            16..19 => self.set(h),
            19 => self.derivatives(h),
            20 | 21 => self.take_state(h),
            22 => self.restore(h),
            23 => self.free_state(h),
            24 => self.write_bytes(h),
            25 | 26 => self.read_bytes(h),
            27 => self.set_up(h),
            28 => self.statuses(h),
            _ => self.nulls(h),
        };
        self.note(status);
        for (_, _, line) in std::mem::take(&mut *self.log.lock().unwrap()) {
            assert!(!line.starts_with("internal error"), "a panic was caught: {line}");
        }
    }

    fn instantiate(&mut self) -> i32 {
        let right = self.rng.random_range(0..4) > 0;
        let guid = if right { Some(GUID) } else { self.pick(&[None, Some(""), Some("%s%n")]) };
        let name = self.pick(&[Some("x"), Some(""), Some("%s %n \u{e9}"), None]);
        let kind = self.pick(&[1, 1, 1, 0, -1, i32::MAX]);
        let logging = self.rng.random();
        let callbacks = Callbacks::logging(self.log);
        let callbacks = if self.rng.random() { Some(&callbacks) } else { None };
        let handle = self.library.instantiate(name, kind, guid, None, callbacks, logging);
        if handle.0 == 0 {
            return ERROR;
        }
        self.instances.push(handle);
        self.live.push(handle);
        // Only a few instances at a time, so that calls meet them in all phases.
        if self.live.len() > 4 {
            let oldest = self.live.remove(0);
            self.library.free(oldest);
        }
        OK
    }

    fn free(&mut self, h: Handle) -> i32 {
        self.library.free(h);
        self.live.retain(|live| *live != h);
        if self.live.is_empty() {
            let callbacks = Callbacks::logging(self.log);
            let fresh =
                self.library.instantiate(Some("x"), 1, Some(GUID), None, Some(&callbacks), true);
            self.instances.push(fresh);
            self.live.push(fresh);
        }
        OK
    }

    fn bring_up(&mut self, h: Handle) -> i32 {
        self.library.plain("fmi2Reset", h);
        let Structure { source, counts, reals } = self.pick(&STRUCTURES);
        let (references, values) = split(&[counts, &[("drive.source", source)]].concat());
        self.library.set_ints(false, h, &references, &values);
        let (references, values) = split(reals);
        self.library.set_reals(h, &references, &values);
        for _ in 0..self.rng.random_range(0..4) {
            let (reference, value) = self.reasonable();
            self.library.set_reals(h, &[reference], &[value]);
        }
        self.library.plain("fmi2EnterInitializationMode", h);
        self.library.plain("fmi2ExitInitializationMode", h)
    }

    fn plain(&mut self, h: Handle) -> i32 {
        let call = self.pick(&[
            "fmi2EnterInitializationMode",
            "fmi2ExitInitializationMode",
            "fmi2Terminate",
            "fmi2CancelStep",
        ]);
        self.library.plain(call, h)
    }

    fn step(&mut self, h: Handle, dog: &Watchdog) -> i32 {
        let (_, now) = self.library.real_status(h, 2);
        let point = if self.rng.random_range(0..10) > 0 { now } else { self.value() };
        let size = step_size(&mut self.rng);
        dog.about_to(format!("fmi2DoStep({point:e}, {size:e}) of {}", self.scene(h)));
        self.library.step(h, point, size)
    }

    fn get(&mut self, h: Handle) -> i32 {
        let count = self.rng.random_range(0..6);
        let references: Vec<u32> = (0..count).map(|_| self.reference()).collect();
        match self.rng.random_range(0..4) {
            0 => self.library.get_ints(false, h, &references, &mut vec![0; count]),
            1 => self.library.get_ints(true, h, &references, &mut vec![0; count]),
            2 => {
                let orders: Vec<i32> = (0..count).map(|_| self.pick(&[1, 1, 0, 2, -7])).collect();
                self.library.derivatives(h, &references, &orders, &mut vec![0.0; count])
            }
            _ => self.library.get_reals(h, &references, &mut vec![0.0; count]),
        }
    }

    fn set(&mut self, h: Handle) -> i32 {
        let count = self.rng.random_range(0..4);
        let sane = self.rng.random_range(0..3) > 0;
        let pairs = (0..count).map(|_| match sane {
            true => self.reasonable(),
            false => (self.reference(), self.value()),
        });
        let (references, values): (Vec<u32>, Vec<f64>) = pairs.collect();
        let ints: Vec<i32> = values.iter().map(|value| *value as i32).collect();
        match self.rng.random_range(0..5) {
            // Large counts are legal, and slow.
            0 if ints.iter().all(|i| *i < 30) => {
                self.library.set_ints(false, h, &references, &ints)
            }
            1 => self.library.set_ints(true, h, &references, &ints),
            _ => self.library.set_reals(h, &references, &values),
        }
    }

    fn derivatives(&mut self, h: Handle) -> i32 {
        let reference = match self.rng.random() {
            true => vr("feed_force"),
            false => self.reference(),
        };
        let order = self.pick(&[1, 2, 3, 4, 0, 5, -1, i32::MIN]);
        let value = self.value();
        self.library.set_derivatives(h, &[reference], &[order], &[value])
    }

    fn take_state(&mut self, h: Handle) -> i32 {
        let mut state = if self.rng.random() { Handle(0) } else { self.state() };
        let fresh = state.0 == 0;
        let status = self.library.get_state(h, Some(&mut state));
        if status == OK && fresh {
            self.states.push(state);
            self.held.push(state);
        }
        status
    }

    fn restore(&mut self, h: Handle) -> i32 {
        let state = self.state();
        self.library.set_state(h, state)
    }

    fn free_state(&mut self, h: Handle) -> i32 {
        let mut state = self.state();
        let freed = state;
        let status = self.library.free_state(h, Some(&mut state));
        if status == OK {
            self.held.retain(|held| *held != freed);
        }
        status
    }

    fn write_bytes(&mut self, h: Handle) -> i32 {
        let state = self.state();
        match self.library.serialize(h, state) {
            Some(bytes) => {
                self.bytes = bytes;
                OK
            }
            None => ERROR,
        }
    }

    fn read_bytes(&mut self, h: Handle) -> i32 {
        let mut bytes = self.bytes.clone();
        let damaged = self.rng.random_range(0..3) > 0 && !bytes.is_empty();
        if damaged {
            let at = self.rng.random_range(0..bytes.len());
            match self.rng.random_range(0..3) {
                0 => bytes.truncate(at),
                1 => bytes.extend_from_slice(&self.bytes[at..]),
                _ => bytes[at] ^= 1 << self.rng.random_range(0..8),
            }
        }
        let mut state = Handle(0);
        let status = self.library.deserialize(h, &bytes, &mut state);
        assert!(!(damaged && status == OK), "a damaged state was taken");
        if status == OK {
            self.states.push(state);
            self.held.push(state);
        }
        status
    }

    fn set_up(&mut self, h: Handle) -> i32 {
        let (start, stop) = (self.value(), self.value());
        self.library.set_up(h, start, Some(stop).filter(|stop| *stop > 0.5))
    }

    fn statuses(&mut self, h: Handle) -> i32 {
        let kind = self.pick(&[0, 1, 2, 3, 4, -1, i32::MAX]);
        self.library.string_status(h, kind);
        self.library.int_status("fmi2GetIntegerStatus", h, kind);
        self.library.int_status("fmi2GetBooleanStatus", h, kind);
        self.library.directional(h);
        let names = self.pick(&[&["logAll"][..], &["logEvents", "logModes"], &["no"], &[]]);
        let on = self.rng.random();
        self.library.set_logging(h, on, names)
    }

    fn nulls(&mut self, h: Handle) -> i32 {
        let name = self.pick(&["fmi2GetReal", "fmi2SetReal", "fmi2GetString", "fmi2SetString"]);
        let count = self.pick(&[0, 1, 1 << 40, usize::MAX]);
        self.library.get_state(h, None);
        self.library.free_state(h, None);
        self.library.null_arrays(name, h, count)
    }

    /// Frees all live handles.
    pub fn clean_up(&mut self) {
        let helper = self.library.instantiate(Some("x"), 1, Some(GUID), None, None, false);
        for mut state in std::mem::take(&mut self.held) {
            self.library.free_state(helper, Some(&mut state));
        }
        for handle in self.live.drain(..).chain([helper]) {
            self.library.free(handle);
        }
    }
}
