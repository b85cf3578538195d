//! The tables of live instances and of stored states, by handle.

use crate::abi::{Logger, Residence, guarded, quietly, section};
use crate::c::{Handle, Status};
use crate::category::Category;
use crate::error::CallError;
use crate::events::Extra;
use crate::instance::{Cancel, Face, Instance, Line, Snapshot};
use crate::registry::{self, CAPACITY, Table};
use crate::variant::Variant;
use crate::{GUID, TOKEN};
use hammer::variables::VARIABLES;
use std::borrow::Cow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

static INSTANCES: Table<Entry, Cancel, CAPACITY> = Table::new();
static STATES: Table<Arc<Snapshot>, (), { registry::STATES }> = Table::new();

struct Entry {
    instance: Instance,
    logger: Logger,
    residence: Option<Residence>,
}

/// The handle of a new instance; `None` and a log line if it cannot be created.
pub fn open(
    [name, guid]: [Option<Cow<str>>; 2],
    face: Result<Face, String>,
    logging: bool,
    logger: &Logger,
) -> Option<usize> {
    let mut lines = Vec::new();
    // FMI 3.0 logs only if logging is on; in FMI 2.0 the argument means the debug log.
    let silent = !logging && matches!(face, Ok(Face::Three { .. }));
    let made = || {
        name.ok_or("instanceName is null")?;
        let face = face?;
        let [label, own] = match face {
            Face::Two => ["fmuGUID", GUID],
            Face::Three { .. } => ["instantiationToken", TOKEN],
        };
        let given = guid.ok_or_else(|| format!("{label} is null"))?;
        let variant = Variant::signed(&given, own, &section())
            .ok_or_else(|| format!("{label} is {given:?}, not {own:?}"))?;
        let instance = Instance::new(variant, face, logging);
        if logging {
            let text = format!("the engine runs in {} vectors", hammer::Vectors::in_use());
            lines.push(Line { category: Category::Events, text });
        }
        let cancel = instance.cancel().clone();
        let entry = Entry { instance, logger: logger.clone(), residence: Residence::take() };
        INSTANCES.insert(entry, cancel).ok_or_else(|| format!("{CAPACITY} instances live already"))
    };
    let made = quietly(made).unwrap_or_else(|| Err("internal error".into()));
    lines.extend(
        made.as_ref().err().map(|text| Line { category: Category::Error, text: text.clone() }),
    );
    if !silent {
        tell(logger, &lines);
    }
    made.ok()
}

/// Removes an instance, if it exists. Returns its reference to the library, which may be the last.
pub fn close(handle: usize) -> Option<Residence> {
    quietly(|| {
        let Entry { instance, residence, .. } = INSTANCES.hold(handle)?.remove()?;
        drop(instance);
        residence
    })?
}

/// Logs to the host, whose function runs with its own floating-point settings.
fn tell(logger: &Logger, lines: &[Line]) {
    let _ = guarded(|| lines.iter().for_each(|line| logger.log(line)));
}

/// Runs `work` on a live instance. Its log lines are passed to the host afterwards, without holding the instance.
pub fn call(me: Handle, work: impl FnOnce(&mut Instance) -> Result<(), CallError>) -> Status {
    let done = quietly(|| {
        let mut held = INSTANCES.hold(me.number())?;
        let Entry { instance, logger, .. } = held.get()?;
        let result = match catch_unwind(AssertUnwindSafe(|| work(instance))) {
            Ok(result) => result,
            Err(payload) => {
                instance.give_up();
                Err(CallError::of_panic(&*payload))
            }
        };
        if let Err(error) = &result {
            instance.complain(error);
        }
        let lines = instance.take_lines();
        let lines = (!lines.is_empty()).then(|| (logger.clone(), lines));
        Some((result.is_ok(), lines))
    });
    let Some((succeeded, lines)) = done.flatten() else { return Status::Error };
    if let Some((logger, lines)) = lines {
        tell(&logger, &lines);
    }
    if succeeded { Status::Ok } else { Status::Error }
}

/// Cancels the step that another thread is making; false if there is none.
pub fn cancel(me: Handle) -> bool {
    INSTANCES.aside(me.number()).is_some_and(|cancel| cancel.cancel())
}

/// Refuses a count larger than any array of a host.
pub fn sane(count: usize) -> Result<usize, CallError> {
    let variables = VARIABLES.len() + Extra::all().count();
    if count <= 4 * variables { Ok(count) } else { Err(CallError::TooMany { count, variables }) }
}

/// Stores a state under the handle that the host already has or, if that is 0, under a new one.
pub fn keep(known: usize, snapshot: Snapshot) -> Result<usize, CallError> {
    let mut snapshot = Arc::new(snapshot);
    if known == 0 {
        return STATES.insert(snapshot, ()).ok_or(CallError::TooManyStates);
    }
    let mut held = STATES.hold(known).ok_or(CallError::UnknownState)?;
    std::mem::swap(held.get().ok_or(CallError::UnknownState)?, &mut snapshot);
    Ok(known)
}

/// A stored state.
pub fn state(handle: usize) -> Result<Arc<Snapshot>, CallError> {
    STATES.hold(handle).and_then(|mut held| held.get().cloned()).ok_or(CallError::UnknownState)
}

/// Deletes a state; 0 stands for none, which is allowed as with free(3).
pub fn forget(handle: usize) -> Result<(), CallError> {
    if handle == 0 {
        return Ok(());
    }
    let found = STATES.hold(handle).and_then(|mut held| held.remove());
    found.map(drop).ok_or(CallError::UnknownState)
}
