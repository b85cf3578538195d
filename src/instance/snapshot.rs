//! The whole state of an instance, in memory or as bytes.

use super::events::Events;
use super::{Inputs, Instance, Phase, Settings};
use crate::GUID;
use crate::error::CallError;
use hammer::{Machine, State};
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// First bytes of a serialised state.
const MAGIC: [u8; 4] = *b"DTHS";
/// Version of the layout: this file's number, which is raised when its layout changes, and the engine's.
const VERSION: u32 = (12 << 16) | State::FORMAT;
/// Magic, version, payload length, checksum, GUID.
const HEADER: usize = 4 + 4 + 8 + 4 + GUID.len();

/// State of an instance between two calls.
#[derive(Debug, Serialize, Deserialize)]
pub struct Snapshot {
    phase: Phase,
    settings: Settings,
    events: Events,
    inputs: Inputs,
    start: f64,
    stop: Option<f64>,
    last_step_failed: bool,
    /// The engine's state, if it runs. Otherwise it follows from the other fields.
    engine: Option<State>,
    #[serde(skip)]
    bytes: OnceLock<Vec<u8>>,
}

impl Instance {
    /// The present state.
    pub fn snapshot(&mut self) -> Snapshot {
        let running = self.origin.is_none();
        let engine = self.machine.as_mut().filter(|_| running);
        Snapshot {
            phase: self.phase,
            settings: self.settings.clone(),
            events: self.events.clone(),
            inputs: self.inputs.clone(),
            start: self.start,
            stop: self.stop,
            last_step_failed: self.last_step_failed,
            engine: engine.map(|machine| machine.state()),
            bytes: OnceLock::new(),
        }
    }

    /// Adopts a state of any instance.
    ///
    /// # Errors
    ///
    /// The state is corrupt, or its limit of work is higher than that of this instance; nothing is changed then.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), CallError> {
        let work_limit = |settings: &Settings| settings.named("work_limit");
        let (allowed, wanted) = (work_limit(&self.settings), work_limit(&snapshot.settings));
        let engine = snapshot.engine.as_ref();
        let engine = engine.map_or(0.0, |state| state.parameters().work_limit as f64);
        if wanted.max(engine) > allowed {
            return Err(CallError::Argument(format!(
                "the state has work_limit = {}, above this instance's {allowed}: set that first",
                wanted.max(engine)
            )));
        }
        match &snapshot.engine {
            Some(state) => self.restore_engine(state)?,
            None => self.machine = None,
        }
        self.waves = None;
        self.step_start = None;
        self.origin = None;
        self.phase = snapshot.phase;
        self.settings = snapshot.settings.clone();
        self.events = snapshot.events.of_state(self.face, self.machine.as_ref());
        self.inputs = snapshot.inputs.clone();
        (self.start, self.stop) = (snapshot.start, snapshot.stop);
        self.retune = true; // If nothing was tuned, this changes nothing.
        self.last_step_failed = snapshot.last_step_failed;
        Ok(())
    }

    fn restore_engine(&mut self, state: &State) -> Result<(), CallError> {
        if let Some(machine) = &mut self.machine {
            return Ok(machine.restore(state)?);
        }
        let mut machine = Machine::new(state.parameters(), &self.inputs.starting(), 0.0)?;
        machine.restore(state)?;
        self.machine = Some(machine);
        Ok(())
    }
}

impl Snapshot {
    /// The state as bytes, computed once.
    ///
    /// # Errors
    ///
    /// The encoder fails; no case is known.
    pub fn bytes(&self) -> Result<&[u8], CallError> {
        if let Some(bytes) = self.bytes.get() {
            return Ok(bytes);
        }
        let payload = postcard::to_stdvec(self)
            .map_err(|_| CallError::Serialised("the state cannot be encoded"))?;
        let mut bytes = Vec::with_capacity(HEADER + payload.len());
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend((payload.len() as u64).to_le_bytes());
        bytes.extend(crc32fast::hash(&payload).to_le_bytes());
        bytes.extend(GUID.as_bytes());
        bytes.extend(payload);
        Ok(self.bytes.get_or_init(|| bytes))
    }

    /// A state from bytes.
    ///
    /// # Errors
    ///
    /// The header is wrong; the error names the part.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, CallError> {
        let payload = payload(bytes)?;
        let snapshot: Self = postcard::from_bytes(payload)
            .map_err(|_| CallError::Serialised("its content cannot be decoded"))?;
        if !snapshot.settings.is_complete() {
            return Err(CallError::Serialised("it is of an FMU with other variables"));
        }
        let Self { settings, inputs, events, .. } = &snapshot;
        if !(settings.is_sound() && inputs.is_sound() && events.is_sound()) {
            return Err(CallError::Serialised("it contains settings that no call could have made"));
        }
        Ok(snapshot)
    }
}

/// The payload after the header, if the header is valid.
fn payload(bytes: &[u8]) -> Result<&[u8], CallError> {
    let wrong = |what| Err(CallError::Serialised(what));
    let mut rest = bytes;
    if take(&mut rest)? != MAGIC {
        return wrong("it is not a state of this FMU");
    }
    if u32::from_le_bytes(take(&mut rest)?) != VERSION {
        return wrong("it is of another version of this FMU");
    }
    let length = u64::from_le_bytes(take(&mut rest)?);
    let checksum = u32::from_le_bytes(take(&mut rest)?);
    let Some((guid, payload)) = rest.split_at_checked(GUID.len()) else {
        return wrong("it is too short");
    };
    if guid != GUID.as_bytes() {
        return wrong("it is of another build of the FMU");
    }
    if u64::try_from(payload.len()) != Ok(length) {
        return wrong("its length is wrong");
    }
    if crc32fast::hash(payload) != checksum {
        return wrong("its checksum is wrong");
    }
    Ok(payload)
}

fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], CallError> {
    let (head, tail) = rest.split_first_chunk().ok_or(CallError::Serialised("it is too short"))?;
    *rest = tail;
    Ok(*head)
}
