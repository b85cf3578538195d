//! What a datasheet tells is what the scene that it hands out does.

use crate::scenes::Random;
use hammer::Scene;
use hammer::datasheet::{Datasheet, Quantity, Solution, THROUGH};
use hammer::means::{Averages, Kind, Steady, Wanted, steady};

use Quantity::{AirFlow, Feed, Frequency, Hole, OuterDiameter, Power, Pressure, Rate};

fn number(solution: &Solution, name: &str) -> f64 {
    solution.found.iter().find(|row| row.name == name).expect("a number").value
}

/// The long-run response of a scene, its rates to one per cent or what 1,600 blows give.
fn response(scene: &Scene) -> Steady {
    let wanted = Wanted { error: Averages::of_rates(0.01), blows: 1600, ..Wanted::default() };
    steady(scene, &wanted, &mut |_, _| true).expect("blows")
}

/// Sheets drawn over sizes, pressures, feeds from a tenth to one and a half of what holds the casing, rocks, and what else is
/// printed. `SHEETS=100` tries more than three.
///
/// Both means have errors: those of the sheet are at most 3 % of the rate and 5 % of the others, or what 600 blows give.
/// Of energy and frequency the told ones are medians of the members' numbers, which are scaled to the means; so is the
/// rate. Of free air and power the medians are of products: 1 % for these. Four standard errors are passed by chance once in
/// 16,000; an error of forty batches is itself known to a tenth.
#[test]
fn a_drawn_sheet_tells_what_its_scene_does() {
    let mut random = Random::new(70);
    let count = std::env::var("SHEETS").ok().and_then(|n| n.parse().ok()).unwrap_or(3);
    let mut failures = Vec::new();
    for sheet in 0..count {
        let outer = random.spread(0.06, 0.21);
        let pressure = random.spread(6e5, 30e5);
        let holds = 0.58 * outer * outer * pressure;
        let mut known = vec![
            (OuterDiameter, outer),
            (Pressure, pressure),
            (Hole, outer * random.between(1.08, 1.3)),
            (Feed, holds * random.spread(0.1, 1.5)),
        ];
        // Printed numbers within a fifth of what is usual.
        let usual = Datasheet { known: known.clone(), ..Datasheet::default() };
        let usual = usual.sample(&Scene::default()).expect("a hammer");
        let near =
            |name: &str, by: f64| by * usual.iter().find(|row| row.name == name).unwrap().value;
        let by = random.spread(0.8, 1.25);
        known.extend(match sheet % 4 {
            0 => Some((Power, near("power of the blows", by))),
            1 => Some((AirFlow, near("free air", by))),
            2 => Some((Frequency, near("frequency", by))),
            _ => None,
        });
        known.extend((sheet % 3 == 0).then(|| (Rate, random.spread(5.0, 30.0) / 3600.0)));
        let mut base = Scene::default();
        base.parameters.rock.stiffness *= random.spread(1.0, 8.0);
        base.parameters.rock.specific_energy = random.spread(1e8, 4e8);
        let all = Datasheet { known: known.clone(), ..Datasheet::default() };
        let solution = all.solve(&base).expect("a hammer");
        let found = response(&solution.scene);
        if found.kind == Kind::Stalled {
            // At once, or after more blows than a sheet simulates.
            let words = ["stalls", "may come to rest"];
            let said = |text: &String| words.iter().any(|word| text.contains(word));
            if !solution.contradictions.iter().any(said) {
                failures.push(format!("{sheet} {known:?} {:?}", solution.contradictions));
            }
            continue;
        }
        let exact = matches!(found.kind, Kind::Cycle(_));
        // An irregular motion may fall into a cycle after more blows than a sheet simulates: one of 40 did.
        let said = |words: &str| solution.contradictions.iter().any(|text| text.contains(words));
        if exact && said("The blows differ") && said("or fall into another motion") {
            continue;
        }
        let mean = |name| found.mean.get(name);
        let error = |name| found.error.get(name) / mean(name);
        let air = if pressure < 10e5 { THROUGH } else { "free air" };
        for (name, value, of, own, more) in [
            ("blow energy", mean("blow_energy"), "blow_energy", 0.05, 0.0),
            ("frequency", mean("blow_frequency"), "period", 0.05, 0.0),
            (air, mean("air_flow"), "air_flow", 0.05, 0.01),
            ("rate of penetration", mean("rop").min(mean("tip_rate")), "rop", 0.03, 0.01),
        ] {
            let off = number(&solution, name) / value - 1.0;
            let own = if exact { 0.0 } else { own };
            let allowed = 4.0 * f64::hypot(own, error(of)) + more + 0.005;
            if off.abs() >= allowed {
                failures.push(format!("{sheet} {known:?}: {name} {off:+.3} of {allowed:.3}"));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// What is printed of a hammer is of its casing held, whatever the feed: the printed power is told beside that at the
/// feed, to the error of a printed power, and the feed that does not hold the casing is named.
#[test]
fn printed_numbers_are_those_of_a_held_casing() {
    let known = [(OuterDiameter, 0.124), (Pressure, 24e5), (Power, 31.7e3), (Hole, 0.14)];
    let at = |feed: f64| {
        let known = [&known[..], &[(Feed, feed)]].concat();
        Datasheet { known, ..Datasheet::default() }.solve(&Scene::default()).expect("a hammer")
    };
    let [weak, firm] = [8e3, 25e3].map(at);
    let held = "power of the blows, casing held";
    for solution in [&weak, &firm] {
        assert!((number(solution, held) / 31.7e3 - 1.0).abs() < 0.05, "{}", number(solution, held));
    }
    assert!(number(&weak, "power of the blows") < 0.8 * number(&weak, held));
    // Rounds bring the scene's blows to the sample's within 1 %, of means good to 1 %, each of energy and frequency.
    let ratio = number(&firm, "power of the blows") / number(&firm, held);
    assert!((ratio - 1.0).abs() < 0.04, "{ratio}");
    let says = |solution: &Solution| {
        solution.contradictions.iter().any(|text| text.contains("does not hold the casing down"))
    };
    assert!(says(&weak) && !says(&firm));
}

/// The range of the rate that a run of the scene tells, by its factor, is the sheet's: both have their geometric middle at
/// the told rate, but for the skewness of a sample. Without a measured rate the range of the specific energy is the rock's
/// own 80 %: a quantile of 120 antithetic pairs has an error of 0.13 of the deviation, 0.1 of the range's width.
#[test]
fn the_range_of_the_rate_travels_with_the_scene() {
    let known = [(OuterDiameter, 0.124), (Pressure, 24e5), (Power, 31.7e3), (Hole, 0.14)];
    for more in [&[][..], &[(Rate, 24.0 / 3600.0)]] {
        let sheet = Datasheet { known: [&known[..], more].concat(), ..Datasheet::default() };
        let solution = sheet.solve(&Scene::default()).expect("a hammer");
        let row = solution.found.iter().find(|row| row.name.starts_with("rate")).expect("a rate");
        let factor = solution.scene.parameters.rock.specific_energy_factor;
        for (end, carried) in row.range.iter().zip([row.value / factor, row.value * factor]) {
            assert!((end / carried - 1.0).abs() < 0.04, "{end} {carried}");
        }
        if more.is_empty() {
            let row = solution.found.iter().find(|row| row.name == "specific energy").expect("one");
            let width = 0.5 * (row.range[1] / row.range[0]).ln();
            let rock = Scene::default().parameters.rock.specific_energy_factor.ln();
            assert!((width / rock - 1.0).abs() < 0.1, "{width} {rock}");
        }
    }
}

/// `rop <= tip_rate`: told is the lesser, and that the inserts are buried; so are a hammer wider than its hole, a bore
/// wider than its hammer, a piston without room and a feed beyond rigs.
#[test]
fn what_cannot_be_is_told() {
    let said = |known: &[(Quantity, f64)], soft: f64| {
        let mut base = Scene::default();
        base.parameters.rock.specific_energy /= soft;
        let known = known.to_vec();
        let solution = Datasheet { known, ..Datasheet::default() }.solve(&base).expect("it");
        (
            number(&solution, "rate of penetration"),
            solution.contradictions.join("\n"),
            solution.scene,
        )
    };
    let plain = [(OuterDiameter, 0.124), (Pressure, 24e5), (Power, 31.7e3), (Hole, 0.14)];
    assert_eq!(said(&plain, 1.0).1, "");
    let (rate, text, scene) = said(&plain, 100.0);
    assert!(text.contains("no hole grows faster") && text.contains("turns a minute"), "{text}");
    assert!(rate <= 1.02 * response(&scene).mean.tip_rate(), "{rate}");
    for (changed, words) in [
        ((Hole, 0.11), "A hammer of 124 mm is not in a hole of 110 mm"),
        ((Quantity::Bore, 0.124), "A bore of 124 mm does not fit"),
        ((Quantity::PistonMass, 150.0), "as long as wide"),
        ((Feed, 1e5), "more than rigs put on such a hammer"),
        ((Rate, 600.0 / 3600.0), "the measured rate gives a specific energy of"),
    ] {
        let mut known = plain.to_vec();
        known.retain(|(quantity, _)| *quantity != changed.0);
        known.push(changed);
        let text = said(&known, 1.0).1;
        assert!(text.contains(words), "{words}: {text}");
    }
}
