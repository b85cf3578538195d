//! A correct host: one instance, with variables by name.

#![allow(dead_code, reason = "each test uses its part")]

use super::library::{Callbacks, Handle, Library, Log, OK};
use dth_hammer::GUID;
use hammer::variables::{Role, Slot, VARIABLES};

/// Value reference of a name.
pub fn vr(name: &str) -> u32 {
    let position = VARIABLES.iter().position(|variable| variable.name == name);
    position.unwrap_or_else(|| panic!("no variable {name}")) as u32
}

/// Outputs that are equal to the bit only if the trajectories are.
pub const FINGERPRINT: [&str; 8] = [
    "piston_position",
    "piston_velocity",
    "bit_tip_position",
    "bit_tip_velocity",
    "rock_impulse",
    "energy_residual",
    "event_count",
    "blow_time",
];

/// An instance, and its log.
pub struct Host<'a> {
    pub library: &'a Library,
    pub handle: Handle,
    log: Box<Log>,
}

impl<'a> Host<'a> {
    /// An instance before initialization.
    pub fn new(library: &'a Library) -> Self {
        Self::with_logging(library, false)
    }

    /// The same, with debug logging.
    pub fn with_logging(library: &'a Library, logging: bool) -> Self {
        Self::made(library, GUID, logging)
    }

    /// An instance of the FMU with this GUID.
    pub fn of_guid(library: &'a Library, guid: &str) -> Self {
        Self::made(library, guid, false)
    }

    fn made(library: &'a Library, guid: &str, logging: bool) -> Self {
        let log = Box::new(Log::default());
        let callbacks = Callbacks::logging(&log);
        let handle =
            library.instantiate(Some("a hammer"), 1, Some(guid), None, Some(&callbacks), logging);
        assert_ne!(handle.0, 0, "{:?}", log.lock());
        Self { library, handle, log }
    }

    /// An instance before initialization, with these values.
    pub fn with(library: &'a Library, values: &[(&str, f64)]) -> Self {
        let host = Self::new(library);
        values.iter().for_each(|(name, value)| host.set(name, *value));
        host
    }

    /// An instance that is ready to step, with these values.
    pub fn running(library: &'a Library, values: &[(&str, f64)]) -> Self {
        let host = Self::with(library, values);
        host.start(0.0);
        host
    }

    /// Initialises.
    pub fn start(&self, time: f64) {
        assert_eq!(self.library.set_up(self.handle, time, None), OK);
        self.plain("fmi2EnterInitializationMode");
        self.plain("fmi2ExitInitializationMode");
    }

    /// Calls a function whose only argument is the instance, which must succeed.
    pub fn plain(&self, call: &str) {
        let status = self.library.plain(call, self.handle);
        assert_eq!(status, OK, "{call}: {:?}", self.take_log());
    }

    /// Sets a variable: a real one, an integer, or an enumeration by the number of its item.
    pub fn set(&self, name: &str, value: f64) {
        let reference = [vr(name)];
        let status = match VARIABLES[reference[0] as usize].role {
            Role::Parameter(row) if !matches!(row.slot, Slot::Real(..)) => {
                self.library.set_ints(false, self.handle, &reference, &[value as i32])
            }
            _ => self.library.set_reals(self.handle, &reference, &[value]),
        };
        assert_eq!(status, OK, "{name}: {:?}", self.take_log());
    }

    /// Sets an input's derivative.
    pub fn set_derivative(&self, name: &str, order: i32, value: f64) {
        let status = self.library.set_derivatives(self.handle, &[vr(name)], &[order], &[value]);
        assert_eq!(status, OK, "{name}: {:?}", self.take_log());
    }

    /// A real variable.
    pub fn get(&self, name: &str) -> f64 {
        let mut value = [f64::NAN];
        let status = self.library.get_reals(self.handle, &[vr(name)], &mut value);
        assert_eq!(status, OK, "{name}: {:?}", self.take_log());
        value[0]
    }

    /// A real output's first derivative.
    pub fn rate(&self, name: &str) -> f64 {
        self.derivative(name, 1)
    }

    /// A real output's derivative of an order.
    pub fn derivative(&self, name: &str, order: i32) -> f64 {
        let mut value = [f64::NAN];
        let status = self.library.derivatives(self.handle, &[vr(name)], &[order], &mut value);
        assert_eq!(status, OK, "{name}: {:?}", self.take_log());
        value[0]
    }

    /// Bits of these outputs, which are equal only if the trajectories are.
    pub fn fingerprint(&self) -> Vec<u64> {
        FINGERPRINT.iter().map(|name| self.get(name).to_bits()).collect()
    }

    /// Makes a step, which must succeed.
    pub fn step(&self, point: f64, size: f64) {
        let status = self.library.step(self.handle, point, size);
        assert_eq!(status, OK, "{point} + {size}: {:?}", self.take_log());
    }

    /// A copy of the state, to be freed.
    pub fn state(&self) -> Handle {
        let mut state = Handle(0);
        assert_eq!(self.library.get_state(self.handle, Some(&mut state)), OK);
        state
    }

    /// Log lines since the last call: status, category, text.
    pub fn take_log(&self) -> Vec<(i32, String, String)> {
        std::mem::take(&mut *self.log.lock().unwrap())
    }

    /// The text of the one error logged since the last call.
    pub fn only_error(&self) -> String {
        let mut lines = self.take_log();
        assert_eq!(lines.len(), 1, "{lines:?}");
        let (status, category, text) = lines.remove(0);
        assert_eq!((status, &*category), (3, "logStatusError"), "{text}");
        text
    }
}

/// An instance, detached from the library that made it.
pub struct Detached {
    pub handle: Handle,
    log: Box<Log>,
}

impl Detached {
    /// Attaches it to another load of the library.
    pub fn attach<'a>(self, library: &'a Library) -> Host<'a> {
        Host { library, handle: self.handle, log: self.log }
    }
}

impl Host<'_> {
    /// Detaches the instance, which stays alive.
    pub fn detach(mut self) -> Detached {
        let log = std::mem::take(&mut self.log);
        let handle = std::mem::replace(&mut self.handle, Handle(0));
        Detached { handle, log }
    }
}

impl Drop for Host<'_> {
    fn drop(&mut self) {
        self.library.free(self.handle);
    }
}
