//! Functions beyond FMI for the page that runs the engine in a browser. They are exported to browsers only.

use crate::c::{Handle, Out, Status, Text};
use crate::datasheet;
use crate::error::CallError;
use crate::session::call;
use hammer::Scene;
use hammer::means::{Averages, Kind, Wanted, steady};
use std::ffi::{CString, c_char};
use std::sync::OnceLock;

/// Solves a datasheet. Writes as much of the answer as there is room for, and returns its length in bytes.
#[unsafe(no_mangle)]
extern "C" fn dth_datasheet(request: Text, answer: Out<u8>, room: usize) -> usize {
    let text = request.read().map(|text| text.to_string_lossy().into_owned()).unwrap_or_default();
    let found = datasheet::answer(&text);
    for (index, byte) in found.bytes().take(room).enumerate() {
        if answer.write(index, byte, "answer").is_err() {
            return 0;
        }
    }
    found.len()
}

/// Writes stresses in the elements of piston (0) or bit (1), as many as there is room for, and returns their number;
/// 0 without an instance. Hosts read the arrays of FMI 3.0 instead.
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

/// Names of the means of [`dth_steady`], one on a line.
#[unsafe(no_mangle)]
extern "C" fn dth_steady_names() -> *const c_char {
    static NAMES: OnceLock<CString> = OnceLock::new();
    let names = || Averages::names().flat_map(|name| [name, "\n"]).collect::<String>();
    NAMES.get_or_init(|| CString::new(names()).unwrap_or_default()).as_ptr()
}

/// The long-run response of the scene set, before it runs: to a relative error of the rate of
/// penetration, with so many simulated blows at most.
///
/// Writes the number of blows after which it repeats (0: it does not, -1: it stalls), the number
/// of blows, 1 if the error was reached, then all means, all their standard errors, and all standard
/// deviations from blow to blow. SI units.
#[unsafe(no_mangle)]
extern "C" fn dth_steady(me: Handle, error: f64, blows: usize, values: Out<f64>) -> Status {
    call(me, |instance| {
        let (parameters, inputs) = instance.starting()?;
        let error = Averages::of_rates(error);
        let wanted = Wanted { error, blows, ..Wanted::default() };
        let found = steady(&Scene { parameters, inputs }, &wanted, &mut |_, _| true)
            .map_err(CallError::from)?;
        let kind = match found.kind {
            Kind::Cycle(blows) => blows as f64,
            Kind::Irregular => 0.0,
            Kind::Stalled => -1.0,
        };
        let head = [kind, found.blows as f64, f64::from(u8::from(found.reached))];
        let lists = [found.mean.0, found.error.0, found.spread.0];
        for (index, value) in head.iter().chain(lists.as_flattened()).enumerate() {
            values.write(index, *value, "values")?;
        }
        Ok(())
    })
}
