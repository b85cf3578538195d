//! Datasheets, solved for the page that runs the engine in a browser. Request and answer are texts.
//!
//! A request has a line `name=value` for each number, in SI units. The numbers are those of the datasheet, and the
//! parameters and inputs of the scene for rock, feed and material.
//! A line such as `rock=granite` replaces the scene's rock, given by name, class or strength, as it is under the
//! inserts of the bit.
//!
//! The answer has a line for each fact, whose fields are separated by tabs:
//! * `set` name value
//! * `compared` name given solved unit
//! * `found` name value unit least largest
//! * `assumed`, `contradiction` or `error`, and a sentence.

use hammer::datasheet::{Datasheet, Quantity};
use hammer::presets::{Ground, Inserts, RockError};
use hammer::variables::{InputRow, Role, VARIABLES, Variable, differences};
use hammer::{Input, Scene};
use std::fmt::Write as _;

/// The answer to a request.
pub fn answer(request: &str) -> String {
    solve(request).unwrap_or_else(|message| format!("error\t{message}\n"))
}

fn solve(request: &str) -> Result<String, String> {
    let (mut sheet, mut scene, mut rock) = (Datasheet::default(), Scene::default(), None);
    for line in request.lines() {
        let (name, value) =
            line.split_once('=').ok_or_else(|| format!("{line} is not of the form name=value"))?;
        if name == "rock" {
            rock = Some(value);
            continue;
        }
        let value: f64 = value.parse().map_err(|_| format!("{name} = {value} is not a number"))?;
        match Quantity::all().find(|quantity| quantity.name() == name) {
            Some(quantity) => sheet.known.push((quantity, value)),
            // A feed force in the request counts as known.
            None if name == Input::FeedForce.name() => sheet.known.push((Quantity::Feed, value)),
            None => {
                sheet.own_rock |= name.starts_with("rock.");
                set(&mut scene, name, value)?;
            }
        }
    }
    // A rock that was set is scaled with the hole if that is given, but not with an assumed hole.
    let given =
        |quantity| sheet.known.iter().find(|(q, _)| *q == quantity).map(|(_, value)| *value);
    let usual_hole = || given(Quantity::OuterDiameter).map(Datasheet::usual_hole);
    let hole = given(Quantity::Hole).or_else(usual_hole);
    sheet.own_rock = rock.is_some() || sheet.own_rock && hole.is_none();
    let mut assumed_of_rock = Vec::new();
    if let Some(name) = rock {
        let hole = hole.ok_or(format!("rock {name} depends on the bit: give hole or od"))?;
        let message = |error: RockError| error.to_string();
        let bit = Inserts::of_hole(hole).map_err(message)?;
        let (ground, assumed) = Ground::named(name).map_err(message)?;
        scene.parameters.rock = ground.under(&bit).map_err(message)?;
        let (count, tip) = (bit.count, 1e3 * bit.radius);
        assumed_of_rock.push(format!("The bit has {count} inserts of {tip} mm at their tips."));
        let measured = given(Quantity::Rate).is_some();
        let assumed = assumed.into_iter().filter(|t| !measured || !t.contains("pecific energy"));
        assumed_of_rock.extend(assumed);
    }
    let answer = sheet.solve(&scene).map_err(|error| error.to_string())?;
    let mut text = String::new();
    let inputs = changed_inputs(&answer.scene, &scene);
    for (name, value) in differences(&answer.scene.parameters).into_iter().chain(inputs) {
        let _ = writeln!(text, "set\t{name}\t{value}");
    }
    for row in &answer.compared {
        let (name, unit) = (row.quantity.name(), row.quantity.entry().unit);
        let _ = writeln!(text, "compared\t{name}\t{}\t{}\t{unit}", row.given, row.solved);
    }
    for row in &answer.found {
        let ([low, high], unit) = (row.range, row.unit);
        let _ = writeln!(text, "found\t{}\t{}\t{unit}\t{low}\t{high}", row.name, row.value);
    }
    let assumed = [answer.assumed, assumed_of_rock].concat();
    for (kind, sentences) in [("assumed", assumed), ("contradiction", answer.contradictions)] {
        for sentence in sentences {
            let _ = writeln!(text, "{kind}\t{sentence}");
        }
    }
    Ok(text)
}

fn set(scene: &mut Scene, name: &str, value: f64) -> Result<(), String> {
    match VARIABLES.iter().find(|variable| variable.name == name).map(|variable| &variable.role) {
        Some(Role::Parameter(row)) => row.slot.write(&mut scene.parameters, value),
        Some(Role::Input(row)) => *(row.start)(&mut scene.inputs) = value,
        _ => return Err(format!("a datasheet has no number called {name}")),
    }
    Ok(())
}

/// Names and values of the inputs of `scene` that differ from those of `other`: the feed force, and the pressure of the
/// air.
fn changed_inputs(scene: &Scene, other: &Scene) -> Vec<(&'static str, f64)> {
    let [mut inputs, mut others] = [scene.inputs, other.inputs];
    let changed = |variable: &Variable| match &variable.role {
        Role::Input(InputRow { start, .. }) => {
            let value = *start(&mut inputs);
            (value != *start(&mut others)).then_some((variable.name, value))
        }
        _ => None,
    };
    VARIABLES.iter().filter_map(changed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text of the answer has exactly the engine's numbers.
    #[test]
    fn a_sheet_as_text_is_the_engine_s() {
        let known = [
            (Quantity::PistonMass, 8.6),
            (Quantity::ImpactSpeed, 10.0),
            (Quantity::BlowEnergy, 645.0),
            (Quantity::Frequency, 30.0),
        ];
        let mut scene = Scene::default();
        scene.parameters.rock.stiffness = 2e8;
        let own = Datasheet { known: known.to_vec(), own_rock: true, ..Default::default() }
            .solve(&scene)
            .expect("a hammer");
        let lines = known.map(|(quantity, value)| format!("{}={value}\n", quantity.name()));
        let text = answer(&(lines.concat() + "rock.stiffness=2e8\n"));
        let sets = differences(&own.scene.parameters);
        let inputs = changed_inputs(&own.scene, &scene);
        for (name, value) in sets.iter().chain(&inputs) {
            assert!(text.contains(&format!("set\t{name}\t{value}\n")));
        }
        assert!(!inputs.is_empty(), "the air's pressure at least");
        assert_eq!(text.matches("set\t").count(), sets.len() + inputs.len());
        assert_eq!(text.matches("contradiction\t").count(), own.contradictions.len());
        assert!(!own.contradictions.is_empty() && text.contains("assumed\t"));
    }

    #[test]
    fn what_is_wrong_is_told_by_name() {
        for (request, culprit) in [
            ("piston_mass=8.6\nblow_energy=9.5e6\nfrequency=30", "error\tblow_energy = 9500000"),
            ("blow_enrgy=475", "error\ta datasheet has no number called blow_enrgy"),
            ("piston_mass=8\nrock=R5", "error\trock R5 depends on the bit: give hole or od"),
            ("hole=0.1\nrock=cheese", "error\tthere is no rock \"cheese\": there are st anne"),
            ("piston_mass=heavy", "error\tpiston_mass = heavy is not a number"),
            ("rop_mean=1", "error\ta datasheet has no number called rop_mean"),
            ("piston_mass", "error\tpiston_mass is not of the form name=value"),
            ("", "error\tnothing says how heavy the piston is"),
        ] {
            assert!(answer(request).starts_with(culprit), "{}", answer(request));
        }
    }
}
