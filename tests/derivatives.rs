//! Directional and adjoint derivatives, against differences of getters and closed forms.

use crate::support::host::{Host, vr};
use crate::support::library::{ERROR, Handle, Library, OK};
use crate::support::three::{Three, extra};
use dth_hammer::capabilities::OVER_STEP;
use dth_hammer::events::Extra;
use dth_hammer::{MODEL_DESCRIPTION, MODEL_DESCRIPTION_3};
use hammer::Input;
use hammer::variables::{Parameter, Role, Slot, VARIABLES};

/// Value references of all real outputs, and their nominal values.
fn outputs() -> (Vec<u32>, Vec<f64>) {
    let nominal = |role: &Role| if let Role::Output(o) = role { Some(o.nominal) } else { None };
    let rows = VARIABLES.iter().zip(0..);
    rows.filter_map(|(row, reference)| Some((reference, nominal(&row.role)?))).unzip()
}

/// `drive.source = Air`.
const AIR: i32 = 4;

/// The dependencies that an element of a description lists; `None` stands for all.
fn listed(text: &str, element: &str) -> Option<Vec<u32>> {
    let rest = text.split(element).nth(1).unwrap_or_else(|| panic!("{element} is not there"));
    let list = rest.split("/>").next()?.split(" dependencies=\"").nth(1)?.split('"').next()?;
    Some(list.split_whitespace().map(|number| number.parse().unwrap()).collect())
}

/// Value references of the inputs on which an output depends at a communication point.
fn dependencies(reference: u32) -> Vec<u32> {
    let list = listed(MODEL_DESCRIPTION, &format!("<Unknown index=\"{}\"", reference + 1));
    list.expect("no output depends on everything").iter().map(|index| index - 1).collect()
}

fn derivative(host: &Host, of: &[u32], by: u32) -> Vec<f64> {
    let mut found = vec![f64::NAN; of.len()];
    let status = host.library.directional_by(host.handle, of, &[by], &[1.0], &mut found);
    assert_eq!(status, OK, "by {}: {:?}", VARIABLES[by as usize].name, host.take_log());
    found
}

fn read(host: &Host, of: &[u32]) -> Vec<f64> {
    let mut values = vec![f64::NAN; of.len()];
    assert_eq!(host.library.get_reals(host.handle, of, &mut values), OK);
    values
}

fn set(host: &Host, reference: u32, value: f64) {
    assert_eq!(host.library.set_reals(host.handle, &[reference], &[value]), OK);
}

/// Error of an air window.
const AIR_ERROR: f64 = 1e-11;

/// Every output by every input and every tunable parameter, at fixed state: the derivative is the immediate effect of
/// setting the known, and zero where the description lists no dependency. In each scene some input acts; it is read
/// in flight and during a blow.
#[test]
fn at_a_communication_point_an_output_follows_only_what_the_description_says() {
    let library = Library::load();
    let (of, nominal) = outputs();
    let mut followed = Vec::new();
    // Forces of about the weight of a tonne on the piston, so that a blow comes within 20 ms. The last hammer hangs
    // out of its casing, so that its air is vented.
    let hung = [("casing.mass", 30.0), ("chuck.idle_travel", 0.02), ("feed_force", -1e3)];
    for (source, values) in [
        (1, &[][..]),
        (2, &[("drive_force", 1e4)]),
        (3, &[("drive_pressure", 1e7)]),
        (AIR, &[]),
        (AIR, &hung),
    ] {
        let host = Host::with(&library, &[("drive.source", f64::from(source))]);
        if source == AIR {
            host.set("air.error", AIR_ERROR);
        }
        if source >= 3 {
            // With unequal areas, equal pressures on both faces do not cancel.
            host.set("drive.area_return", 0.8 * host.get("drive.area_drive"));
        }
        values.iter().for_each(|(name, value)| host.set(name, *value));
        host.start(0.0);
        let vented = || host.get("drive_chamber_pressure") == host.get("exhaust_pressure");
        let mut time = 0.0;
        let is_hung = values.len() == hung.len();
        while is_hung && !vented() && time < 1.0 {
            host.step(time, 1e-3);
            time += 1e-3;
        }
        assert_eq!(vented(), is_hung);
        // A vented piston does not fly.
        for size in [0.004, if is_hung { 0.001 } else { 0.05 }] {
            host.step(time, size);
            time += size;
            for input in Input::ALL {
                let by = vr(input.name());
                let found = derivative(&host, &of, by);
                let (own, step) = (read(&host, &[by])[0], input.row().nominal);
                let [low, high] = [-step, step].map(|change| {
                    set(&host, by, own + change);
                    read(&host, &of)
                });
                set(&host, by, own);
                for k in 0..of.len() {
                    let (name, slope) = (VARIABLES[of[k] as usize].name, found[k]);
                    let difference = (high[k] - low[k]) / (2.0 * step);
                    // The load's static part moves from one sum to another, which makes some hundred roundings of a
                    // number of the output's usual size, or of the energies'. The air begins another window, whose
                    // force is a polynomial through its nodes: inside a window it is less exact than at its end, for
                    // which the error is stated.
                    let size = low[k].abs().max(nominal[k]).max(1.0);
                    let relative = if source == AIR { 1e4 * AIR_ERROR } else { 1e-12 };
                    let allowed = relative * size / step;
                    assert!(
                        (slope - difference).abs() <= allowed,
                        "{name} by {}: {slope} {difference}",
                        input.name()
                    );
                    let listed = dependencies(of[k]).contains(&by);
                    assert!(listed || slope == 0.0, "{name} by {}: {slope}", input.name());
                    if slope != 0.0 {
                        followed.push((of[k], by));
                    }
                }
            }
            // A tunable parameter takes effect at the next step.
            assert!(derivative(&host, &of, vr("rock.stiffness")).iter().all(|slope| *slope == 0.0));
        }
    }
    // Every listed dependency has an effect.
    for output in of {
        for input in dependencies(output) {
            assert!(followed.contains(&(output, input)), "{output} by {input}");
        }
    }
}

/// Every output by every real parameter and input in initialization mode, against differences of a known that is set
/// a little lower and higher.
fn before_the_start<'a>(library: &'a Library, source: i32) -> Host<'a> {
    let (of, _) = outputs();
    let by = [("drive.source", f64::from(source)), ("air.error", AIR_ERROR)];
    let coarse = [("piston.elements", 3.0), ("bit.elements", 3.0)];
    let host = Host::with(library, &[by, coarse].concat());
    host.plain("fmi2EnterInitializationMode");
    let known = |row: &hammer::variables::Variable| {
        matches!(row.role, Role::Input(_) | Role::Parameter(Parameter { slot: Slot::Real(..), .. }))
    };
    let initial = MODEL_DESCRIPTION.split_once("<InitialUnknowns>").unwrap().1;
    let (mut followed, base) = (0, read(&host, &of));
    for (row, by) in VARIABLES.iter().zip(0..).filter(|(row, _)| known(row)) {
        let found = derivative(&host, &of, by);
        let own = read(&host, &[by])[0];
        let step = 1e-4 * if own == 0.0 { 1.0 } else { own.abs() };
        let at = |value: f64| {
            set(&host, by, value);
            let mut values = vec![f64::NAN; of.len()];
            let status = library.get_reals(host.handle, &of, &mut values);
            set(&host, by, own);
            (status == OK).then_some(values)
        };
        // At the edge of its domain only one side exists.
        let sides = [at(own - step), at(own + step)];
        let span = step * sides.iter().flatten().count() as f64;
        let [low, high] = sides.map(|side| side.unwrap_or_else(|| base.clone()));
        if span == 0.0 {
            // Values whose neighbours are not allowed: a casing's mass of 0, a line's impedance of 0, and 0 for a
            // number that must otherwise be at least 1.
            let alone = ["casing.mass", "drive.impedance", "drill.joint.stiffness"];
            assert!(alone.contains(&row.name), "{}", row.name);
            assert!(found.iter().all(|slope| *slope == 0.0), "{}", row.name);
            continue;
        }
        for k in 0..of.len() {
            let difference = (high[k] - low[k]) / span;
            // Curvature is 1e-4 with one side and less with two. Rounding is some units of the value; for air it is
            // its error, as above.
            let rounding = if source == AIR { 1e4 * AIR_ERROR } else { 1e-12 };
            let allowed = 1e-3 * difference.abs() + rounding * base[k].abs().max(1.0) / step;
            let name = VARIABLES[of[k] as usize].name;
            assert!(
                (found[k] - difference).abs() <= allowed,
                "{name} by {}: {} {difference}",
                row.name,
                found[k]
            );
            if found[k] != 0.0 {
                let all = listed(initial, &format!("<Unknown index=\"{}\"", of[k] + 1));
                let is_listed = all.is_some_and(|all| all.contains(&(by + 1)));
                assert!(is_listed, "{name} by {}", row.name);
                followed += 1;
            }
        }
        host.take_log();
    }
    assert!(followed > 20, "{followed}");
    host
}

#[test]
fn before_the_start_outputs_follow_parameters_and_inputs() {
    let library = Library::load();
    for source in [3, AIR] {
        before_the_start(&library, source);
    }
    let host = before_the_start(&library, 1);
    // Statics: rock and shoulder carry the feed, and the piston hangs above the bit by the gap.
    for (output, by, slope) in [
        ("rock_force", "feed_force", 1.0),
        ("relative_position", "contact.initial_gap", -1.0),
        ("applied_drive_force", "drive.amplitude", 1.0),
        ("piston_velocity", "piston.initial_velocity", 1.0),
    ] {
        let found = derivative(&host, &[vr(output)], vr(by))[0];
        // Differences have seven digits and more.
        assert!((found - slope).abs() < 1e-7, "{output} by {by}: {found}");
    }
}

#[test]
fn what_cannot_change_or_is_no_output_is_refused() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    let (h, [feed, output]) = (host.handle, ["feed_force", "bit_position"].map(vr));
    let mut slope = [0.0];
    // Without unknowns and knowns nothing happens.
    assert_eq!(library.directional(h), OK);
    for (unknown, known, by) in [
        (output, vr("piston.elements"), 1.0),
        (output, vr("piston.length"), 1.0),
        (output, output, 1.0),
        (output, u32::MAX, 1.0),
        (output, feed, f64::NAN),
        (feed, feed, 1.0),
        (feed + OVER_STEP, feed, 1.0),
        (output + OVER_STEP, vr("rock.stiffness"), 1.0),
    ] {
        assert_eq!(library.directional_by(h, &[unknown], &[known], &[by], &mut slope), ERROR);
        host.only_error();
    }
    host.step(0.0, 0.001);
}

#[test]
fn adjoint_derivatives_are_the_directional_ones_the_other_way_round() {
    let library = Library::load();
    let host = Three::new(&library, false, false);
    assert_eq!(host.enter_initialization(0.0), OK);
    // Stress along the bit is an array of 20.
    let stress = extra("bit_stress");
    check_adjoint(&host, &[vr("rock_force"), stress], &["feed_force", "bit.length"].map(vr), 21);
    host.calls(&["ExitInitializationMode"]);
    host.step(0.0, 0.02);
    let of = ["piston_position", "bit_velocity", "relative_position"].map(|n| OVER_STEP + vr(n));
    check_adjoint(&host, &of, &[vr("feed_force")], 3);
}

/// What the end of a step owes to an input over it, in hammers under a valve and under air, in a casing and without one: as
/// differences of the same step from the same state, of which two sizes tell their own error. A difference of 1 N moves
/// 1e-6 of a position, known to some 1e-13 of it; 95 of 100 are within what the engine tells of such, 1e-6.
#[test]
fn what_a_step_owes_to_an_input_is_that_of_fmi_3_s_own_steps() {
    let (library, feed) = (Library::load(), vr("feed_force"));
    let of = ["bit_position", "bit_velocity", "piston_velocity", "drilled_length"].map(vr);
    let mut held = Vec::new();
    for draw in 0..8 {
        let host = Three::new(&library, false, false);
        host.set("Int64", vr("fidelity"), 1_i64);
        if draw % 2 == 0 {
            host.set("Int64", vr("drive.source"), i64::from(AIR));
            host.set("Float64", vr("air.error"), 1e-11);
        }
        host.set("Float64", vr("casing.mass"), if draw % 4 < 2 { 60.0 } else { 0.0 });
        assert_eq!(host.enter_initialization(0.0), OK);
        host.calls(&["ExitInitializationMode"]);
        let (from, size) = (0.02 + 0.009 * f64::from(draw), 4e-3);
        host.step(0.0, from);
        let mut state = Handle(0);
        assert_eq!(host.save(&mut state), OK);
        let end = |by: f64| {
            assert_eq!(host.restore(state), OK);
            host.set("Float64", feed, 5e3 + by);
            host.step(from, size);
            of.map(|output| host.get(output))
        };
        let slope = |by: f64| {
            let ends = [end(-by), end(by)];
            std::array::from_fn::<f64, 4, _>(|k| (ends[1][k] - ends[0][k]) / (2.0 * by))
        };
        let [finer, coarser] = [slope(1.0), slope(2.0)];
        end(0.0);
        let found = host.derivative("Directional", &of.map(|o| o + OVER_STEP), &[feed], &[1.0], 4);
        for k in 0..4 {
            let known = (finer[k] - coarser[k]).abs();
            held.push((found[k] - finer[k]).abs() <= 1e-6 * finer[k].abs() + 2.0 * known + 1e-15);
        }
        assert_eq!(host.forget(&mut state), OK);
    }
    assert!(20 * held.iter().filter(|held| !**held).count() <= held.len(), "{held:?}");
}

fn check_adjoint(host: &Three, of: &[u32], by: &[u32], scalars: usize) {
    let seeds = |n: usize| (0..n).map(|k| (1.0 + 3.0 * k as f64).sin()).collect::<Vec<_>>();
    let (u, v) = (seeds(scalars), seeds(by.len()));
    let forward = host.derivative("Directional", of, by, &v, scalars);
    let back = host.derivative("Adjoint", of, by, &u, by.len());
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let size = u.iter().zip(&forward).map(|(x, y)| (x * y).abs()).sum::<f64>();
    let [one, other] = [dot(&u, &forward), dot(&v, &back)];
    // Sums of the same products in another order.
    assert!(size > 0.0 && (one - other).abs() <= 1e-12 * size, "{one} and {other}");
}

/// All float outputs, including arrays, by everything that a host may set, and by time. Each pair is answered in
/// initialization mode and after it, as in FMI 2.0 where that has both; nonzero derivatives are declared as
/// dependencies.
#[test]
fn every_pair_of_fmi_3_is_answered_and_declared() {
    let library = Library::load();
    let (two, _) = outputs();
    let more = Extra::all().filter(|e| e.is_output() && e.is_of_arrays()).map(Extra::reference);
    let arrays: Vec<u32> = more.collect();
    // 20 stations along three bodies, twice; 16 blows of seven figures, and their number.
    let along = 20 * hammer::variables::ALONG.len();
    let scalars = along + 16 * hammer::variables::OF_BLOW.len() + 1;
    let is_still = |e: &Extra| matches!(e, Extra::Time | Extra::Slope(_) | Extra::Position(_));
    let still: Vec<u32> = Extra::all().filter(is_still).map(Extra::reference).collect();
    let known = |role: &Role| {
        matches!(role, Role::Input(_) | Role::Parameter(Parameter { slot: Slot::Real(..), .. }))
    };
    let rows = VARIABLES.iter().zip(0..);
    let settable: Vec<u32> = rows.filter_map(|(row, by)| known(&row.role).then_some(by)).collect();
    let inputs: Vec<u32> = Input::ALL.iter().map(|input| vr(input.name())).collect();
    for source in [1, 3, AIR] {
        let host = Three::new(&library, false, false);
        host.set("Int64", vr("drive.source"), i64::from(source));
        let same = Host::with(&library, &[("drive.source", source.into())]);
        for name in ["piston.elements", "bit.elements"] {
            host.set("Int32", vr(name), 3_i32);
            same.set(name, 3.0);
        }
        let pairs = |by: &[u32], element: &str| {
            let (mut other, mut followed) = (0, 0);
            for by in by.iter().copied().chain(still.iter().copied()) {
                let found = host.derivative("Directional", &arrays, &[by], &[1.0], scalars);
                assert!(found.iter().all(|slope| slope.is_finite()), "by {by}");
                let found = host.derivative("Directional", &two, &[by], &[1.0], two.len());
                if (by as usize) < VARIABLES.len() {
                    assert_eq!(found, derivative(&same, &two, by), "by {by}");
                } else {
                    other += 1;
                    assert!(found.iter().all(|slope| *slope == 0.0), "by {by}: {found:?}");
                }
                for (output, _) in two.iter().zip(&found).filter(|(_, slope)| **slope != 0.0) {
                    let list = listed(
                        MODEL_DESCRIPTION_3,
                        &format!("<{element} valueReference=\"{output}\""),
                    );
                    assert!(list.is_none_or(|list| list.contains(&by)), "{output} by {by}");
                    followed += 1;
                }
            }
            // The time, the positions at which steps end, and the slope of each input.
            assert_eq!(other, 1 + 8 + Input::ALL.len());
            followed
        };
        assert_eq!(host.enter_initialization(0.0), OK);
        same.plain("fmi2EnterInitializationMode");
        assert!(pairs(&settable, "InitialUnknown") > 20);
        host.calls(&["ExitInitializationMode"]);
        same.plain("fmi2ExitInitializationMode");
        host.step(0.0, 0.03);
        same.step(0.0, 0.03);
        // Nothing depends on the relay at once.
        assert_eq!(pairs(&inputs, "Output") > 0, source == 3);
    }
}

/// A call with 800 equal knowns makes the runs of a single one, and sums as many directions.
#[test]
fn equal_knowns_are_differentiated_once() {
    let library = Library::load();
    let host = Host::with(&library, &[("piston.elements", 60.0), ("bit.elements", 60.0)]);
    host.plain("fmi2EnterInitializationMode");
    let [force, feed] = ["rock_force", "feed_force"].map(vr);
    let knowns = vec![feed; 800];
    let (by, mut slope) = (vec![1.0; knowns.len()], [0.0]);
    let status = library.directional_by(host.handle, &[force], &knowns, &by, &mut slope);
    // As many runs as knowns would take minutes. In statics the slope is 1.
    assert_eq!(status, OK);
    assert!((slope[0] - 800.0).abs() < 1e-4, "{slope:?}");
}
