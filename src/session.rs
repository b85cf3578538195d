//! The live instances and the states taken, under their handles.

use crate::GUID;
use crate::abi::{Logger, Residence};
use crate::c::{CO_SIMULATION, Handle, Status};
use crate::category::Category;
use crate::fault::Fault;
use crate::instance::{Instance, Line, Snapshot};
use crate::registry::{CAPACITY, Store, Table};
use crate::variant::Variant;
use crate::{blows, waves};
use hammer::variables::VARIABLES;
use std::borrow::Cow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

static INSTANCES: Table<Entry> = Table::new();
static STATES: Store<Snapshot> = Store::new();

struct Entry {
    instance: Instance,
    logger: Logger,
    /// Last, as fields are dropped in their order.
    _residence: Option<Residence>,
}

/// Keeps a panic from reaching the host.
pub fn quietly<T>(work: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(work)).ok()
}

/// What instances shared does not outlive the library.
#[cfg(target_os = "linux")]
pub extern "C" fn at_unload() {
    let _ = quietly(hammer::forget_shared_systems);
}

/// A new instance's handle; `None`, and a log line, if there is none.
pub fn open(
    [name, guid]: [Option<Cow<str>>; 2],
    kind: i32,
    logging: bool,
    logger: &Logger,
    reside: fn() -> Option<Residence>,
) -> Option<usize> {
    let made = || {
        name.ok_or("instanceName is null")?;
        if kind != CO_SIMULATION {
            return Err(format!("fmuType = {kind}: this FMU is for co-simulation (1) only"));
        }
        let given = guid.ok_or("fmuGUID is null")?;
        let variant = Variant::named(&given, GUID)
            .ok_or_else(|| format!("fmuGUID is {given:?}, not {GUID:?}"))?;
        let instance = Instance::new(variant, logging);
        if logging {
            let text = format!("the engine runs in {} vectors", hammer::Vectors::in_use());
            logger.log(&Line { category: Category::Events, text });
        }
        let entry = Entry { instance, logger: logger.clone(), _residence: reside() };
        INSTANCES.insert(entry).ok_or_else(|| format!("{CAPACITY} instances live already"))
    };
    made().map_err(|text| logger.log(&Line { category: Category::Error, text })).ok()
}

/// Removes an instance, if it lives.
pub fn close(handle: usize) {
    // The guard is gone before the entry: its residence may be all that holds the library.
    let entry = INSTANCES.hold(handle).and_then(|mut held| held.remove());
    drop(entry);
}

/// Runs `work` on a live instance; then, without holding it, tells the host what was logged.
pub fn call(me: Handle, work: impl FnOnce(&mut Instance) -> Result<(), Fault>) -> Status {
    let guarded = quietly(|| {
        let Some(mut held) = INSTANCES.hold(me.number()) else { return Status::Error };
        let Some(entry) = held.get() else { return Status::Error };
        let instance = &mut entry.instance;
        let result = match catch_unwind(AssertUnwindSafe(|| work(instance))) {
            Ok(result) => result,
            Err(payload) => {
                instance.give_up();
                Err(Fault::of_panic(&*payload))
            }
        };
        if let Err(fault) = &result {
            instance.complain(fault);
        }
        let lines = instance.take_lines();
        if !lines.is_empty() {
            let logger = entry.logger.clone();
            drop(held);
            lines.iter().for_each(|line| logger.log(line));
        }
        if result.is_ok() { Status::Ok } else { Status::Error }
    });
    guarded.unwrap_or(Status::Error)
}

/// A count that a host can mean. Beyond it lies memory that is not the host's array.
pub fn sane(count: usize) -> Result<usize, Fault> {
    let variables = VARIABLES.len() + waves::CAPACITY + blows::CAPACITY;
    if count <= 4 * variables { Ok(count) } else { Err(Fault::TooMany { count, variables }) }
}

/// Keeps a state under the handle that the host holds already, or, if that is 0, a new one.
pub fn keep(known: usize, snapshot: Snapshot) -> Result<usize, Fault> {
    if known == 0 {
        return STATES.insert(snapshot).ok_or(Fault::TooManyStates);
    }
    if STATES.replace(known, snapshot) { Ok(known) } else { Err(Fault::UnknownState) }
}

/// A state that was kept.
pub fn state(handle: usize) -> Result<Arc<Snapshot>, Fault> {
    STATES.get(handle).ok_or(Fault::UnknownState)
}

/// Forgets a state; 0 is none, and allowed as with free(3).
pub fn forget(handle: usize) -> Result<(), Fault> {
    if handle == 0 || STATES.remove(handle) { Ok(()) } else { Err(Fault::UnknownState) }
}
