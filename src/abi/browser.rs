//! Functions beyond FMI, for the page that runs the engine in a browser. Only the library for browsers exports them.

use crate::c::{Handle, Out, Status, Text};
use crate::datasheet;
use crate::error::CallError;
use crate::session::call;
use hammer::means::{Averages, Kind, Wanted, steady};
use std::ffi::{CString, c_char};
use std::sync::OnceLock;

/// Solves a datasheet. Writes as much of the answer as there is room for, and returns the length of the whole answer in
/// bytes.
#[unsafe(no_mangle)]
extern "C" fn dth_datasheet(request: Text, answer: Out<u8>, room: usize) -> usize {
    let text = request.read().map(|text| text.to_string_lossy().into_owned()).unwrap_or_default();
    let solved = datasheet::answer(&text);
    for (index, byte) in solved.bytes().take(room).enumerate() {
        if answer.write(index, byte, "answer").is_err() {
            return 0;
        }
    }
    solved.len()
}

/// Writes the stresses in the elements of the piston (`body` 0) or the bit (1), as many as there is room for. Returns
/// the number of elements, or 0 without an instance. Hosts read the arrays of FMI 3.0 instead.
#[unsafe(no_mangle)]
extern "C" fn dth_stress(me: Handle, body: usize, out: Out<f64>, room: usize) -> usize {
    let mut count = 0;
    call(me, |instance| {
        let profile = instance.profile()?;
        let stress = if body == 0 { &profile.piston_stress } else { &profile.bit_stress };
        count = stress.len();
        let mut values = stress.iter().take(room).enumerate();
        values.try_for_each(|(index, stress)| out.write(index, *stress, "values"))
    });
    count
}

/// Names of the means of [`dth_steady`], one on each line.
#[unsafe(no_mangle)]
extern "C" fn dth_steady_names() -> *const c_char {
    static NAMES: OnceLock<CString> = OnceLock::new();
    let names = || Averages::names().flat_map(|name| [name, "\n"]).collect::<String>();
    NAMES.get_or_init(|| CString::new(names()).unwrap_or_default()).as_ptr()
}

/// Computes the long-run response of the scene that was set and does not run yet. `error` is the relative error of the
/// rate of penetration at which the computation ends, `blows` the largest number of simulated blows.
///
/// Writes the number of blows after which the response repeats (0 if it does not repeat, -1 if the hammer stalls), the
/// number of simulated blows, 1 if the error was reached (otherwise 0), then all means, all their standard errors, and
/// all standard deviations from blow to blow, in SI units.
#[unsafe(no_mangle)]
extern "C" fn dth_steady(me: Handle, error: f64, blows: usize, values: Out<f64>) -> Status {
    call(me, |instance| {
        let error = Averages::of_rates(error);
        let target = Wanted { error, blows, ..Wanted::default() };
        let steady =
            steady(&instance.scene()?, &target, &mut |_, _| true).map_err(CallError::from)?;
        let kind = match steady.kind {
            Kind::Cycle(blows) => blows as f64,
            Kind::Irregular => 0.0,
            Kind::Stalled => -1.0,
        };
        let head = [kind, steady.blows as f64, f64::from(u8::from(steady.reached))];
        let lists = [steady.mean.0, steady.error.0, steady.spread.0];
        for (index, value) in head.iter().chain(lists.as_flattened()).enumerate() {
            values.write(index, *value, "values")?;
        }
        Ok(())
    })
}
