//! Hammers from datasheets.

use crate::scenes::one_in;
use hammer::datasheet::{Datasheet, DatasheetError, Quantity, Solution, THROUGH};
use hammer::means::{Wanted, steady};
use hammer::{Parameters, Scene};

use Quantity::{
    AirFlow, BlowEnergy, DampingRatio, Feed, Flow, Frequency, Hole, ImpactSpeed, Length,
    OuterDiameter, PistonMass, Power, Pressure, Rate, Stroke,
};

fn sheet(known: &[(Quantity, f64)]) -> Datasheet {
    Datasheet { known: known.to_vec(), ..Datasheet::default() }
}

fn solved(known: &[(Quantity, f64)]) -> Solution {
    sheet(known).solve(&Scene::default()).expect("a hammer")
}

fn found(solution: &Solution, name: &str) -> f64 {
    solution.found.iter().find(|row| row.name.starts_with(name)).expect("a number").value
}

fn range(solution: &Solution, name: &str) -> [f64; 2] {
    solution.found.iter().find(|row| row.name.starts_with(name)).expect("a number").range
}

/// Energy and frequency of the scene's blows in the long run, and its rate of penetration.
fn settled(scene: &Scene) -> [f64; 3] {
    let mean = steady(scene, &Wanted::default(), &mut |_, _| true).expect("blows").mean;
    [mean.get("blow_energy"), mean.get("blow_frequency"), mean.rop()]
}

const SANDVIK: [(Quantity, f64); 5] =
    [(OuterDiameter, 0.124), (Pressure, 24e5), (Power, 31.7e3), (PistonMass, 15.9), (Hole, 0.14)];

/// The scene strikes as the middle of the sample does: its loop stops at 0.5 % of the logarithm.
#[test]
fn the_scene_strikes_as_the_sample_says() {
    for known in [&SANDVIK[..], &[(PistonMass, 8.6), (BlowEnergy, 375.0), (Frequency, 30.0)]] {
        let solution = solved(known);
        let [energy, frequency, _] = settled(&solution.scene);
        assert!((energy / found(&solution, "blow energy") - 1.0).abs() < 0.01, "{energy} J");
        assert!((frequency / found(&solution, "frequency") - 1.0).abs() < 0.01, "{frequency} Hz");
    }
}

/// A number that is given is met by the middle of the sample, within its own error, where nothing contradicts.
#[test]
fn what_is_given_is_met() {
    let solution = solved(&[(PistonMass, 8.6), (BlowEnergy, 375.0), (Frequency, 30.0)]);
    for compared in &solution.compared {
        assert!(compared.off().abs() < compared.quantity.entry().error, "{compared:?}");
    }
    assert!(solution.contradictions.is_empty(), "{:?}", solution.contradictions);
    // 80 % of a normal number lie within 1.28 of its errors; what is known of the rest of the hammer narrows it.
    let [low, high] = range(&solution, "blow energy");
    assert!(high / low < (2.0 * 1.3 * 0.05f64).exp() && high / low > 1.03, "{low} {high}");
}

/// Energy and speed say the mass: `m = 2 W / v^2`, to the errors of both.
#[test]
fn energy_and_speed_say_the_mass() {
    let solution = solved(&[(ImpactSpeed, 9.0), (BlowEnergy, 375.0), (Frequency, 30.0)]);
    let mass = found(&solution, "piston mass");
    assert!((mass / (2.0 * 375.0 / 81.0) - 1.0).abs() < 0.11, "{mass}");
}

/// The hammers of makers' tables (`reports/makers.csv`), with all that their rows say.
fn catalogue() -> Vec<(&'static str, Datasheet)> {
    let mut list: Vec<(&str, Datasheet)> = Vec::new();
    for line in include_str!("../../reports/makers.csv").lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |k: usize| fields[k].parse::<f64>().ok();
        if list.last().is_none_or(|(model, _)| *model != fields[0]) {
            list.push((fields[0], Datasheet::default()));
        }
        let sheet = &mut list.last_mut().expect("pushed").1;
        let row = [
            (OuterDiameter, number(1).map(|x| 1e-3 * x)),
            (Hole, number(4).zip(number(5)).map(|(x, y)| 0.5e-3 * (x + y))),
            (PistonMass, number(6)),
            (Pressure, number(11).map(|x| 1e5 * x)),
            (Frequency, number(13).map(|x| x / 60.0)),
            (Power, number(14).map(|x| 1e3 * x)),
        ];
        for (quantity, value) in row {
            sheet.known.retain(|(known, _)| value.is_none() || *known != quantity);
            sheet.known.extend(value.map(|value| (quantity, value)));
        }
        sheet.air.extend(number(11).zip(number(12)).map(|(at, air)| [1e5 * at, air / 60.0]));
    }
    list
}

/// Logarithms of every number of a sheet, of its range, and of each member of the sample; without that which only
/// sheets of low pressure have.
fn numbers(sheet: &Datasheet) -> Vec<f64> {
    let mut rows = sheet.sample(&Scene::default()).expect("a hammer");
    rows.retain(|row| row.name != THROUGH);
    let all = rows.iter().flat_map(|row| [&[row.value], &row.range[..], &row.members].concat());
    all.map(f64::ln).collect()
}

/// Two steps side by side differ by a jump, however small they are; where there is none they differ by less than their
/// size, times the curvature or what a kink changes of a slope. So the pair of each sweep over a factor of two that differs
/// most is halved until its size is below 1e-4. Slopes are at most those of a small hammer's size, whose
/// mass has its third power; 2 is more than a kink changes of them.
#[test]
fn no_answer_and_no_member_jumps_anywhere_in_the_range_of_its_inputs() {
    const STEPS: usize = 6;
    const HALVED: i32 = 11;
    let inputs = [Pressure, PistonMass, OuterDiameter, Hole, Power, Frequency, Feed, AirFlow];
    let sheets = catalogue();
    let all = sheets.iter().flat_map(|one| inputs.map(|input| (one, input)));
    // One in three of eight, so that every input has its turn.
    for ((model, sheet), quantity) in all.step_by(one_in(3)) {
        let own = sheet.known.iter().find(|(known, _)| *known == quantity).map(|known| known.1);
        let rows = sheet.sample(&Scene::default()).expect("a hammer");
        let usual = |name| rows.iter().find(|row| row.name == name).expect("it").value;
        let middle = own.unwrap_or_else(|| match quantity {
            Hole => 0.15,
            Power => usual("power of the blows"),
            Frequency => usual("frequency"),
            Feed => usual("feed"),
            AirFlow => usual("free air"),
            PistonMass => usual("piston mass"),
            _ => 0.18,
        });
        let at = |x: f64| {
            let mut sheet = sheet.clone();
            sheet.known.retain(|(known, _)| *known != quantity);
            sheet.known.push((quantity, middle * x.exp()));
            numbers(&sheet)
        };
        let mut size = 2f64.ln() / STEPS as f64;
        let mut low = -0.5 * 2f64.ln();
        let mut sweep: Vec<_> = (0..=STEPS).map(|k| at(low + size * k as f64)).collect();
        for half in 0..=HALVED {
            // The largest of each pair of steps, and where it begins.
            let bend = |k: usize| -> f64 {
                let [a, b, c] = [0, 1, 2].map(|i| &sweep[k + i]);
                let each = a.iter().zip(b).zip(c).map(|((a, b), c)| (a - 2.0 * b + c).abs());
                each.fold(0.0, f64::max)
            };
            let most = (0..sweep.len() - 2).max_by(|a, b| bend(*a).total_cmp(&bend(*b)));
            let most = most.expect("steps");
            if half == HALVED {
                let jump = bend(most);
                let [a, b, c] = [0, 1, 2].map(|i| &sweep[most + i]);
                let each = a.iter().zip(b).zip(c).map(|((a, b), c)| (a - 2.0 * b + c).abs());
                let which =
                    each.enumerate().max_by(|x, y| x.1.total_cmp(&y.1)).map(|x| x.0).unwrap_or(0);
                let of = &rows[which / (3 + rows[0].members.len())].name;
                assert!(
                    jump < 2.0 * size,
                    "{model} {quantity:?} {low}: {jump} over {size}: {of} {which}"
                );
            } else {
                low += size * most as f64;
                size *= 0.5;
                let [left, right] = [1.0, 3.0].map(|k| at(low + size * k));
                let mut old = sweep.drain(most..most + 3);
                let [a, b, c] = [(); 3].map(|()| old.next().expect("three"));
                drop(old);
                sweep = vec![a, left, b, right, c];
            }
        }
    }
}

/// The energy of a blow never falls where the pressure that is worked at rises, of any hammer of a catalogue; nor does
/// that of a sheet which gives sizes and a pressure.
#[test]
fn energy_grows_with_the_pressure() {
    for (model, sheet) in catalogue() {
        let given = sheet.known.iter().find(|known| known.0 == Pressure).expect("a pressure").1;
        // Beyond 40 bar a liquid drives a hammer.
        let given = given.min(30e5);
        let sizes = sheet.known.iter().filter(|k| [OuterDiameter, Hole, PistonMass].contains(&k.0));
        let sizes: Vec<_> = sizes.copied().collect();
        let energies: Vec<[f64; 2]> = (0..7)
            .map(|k| given * (0.4 + 0.15 * f64::from(k)))
            .map(|at| {
                let worked = Datasheet { at: Some(at), ..sheet.clone() };
                let plain = Datasheet {
                    known: [&sizes[..], &[(Pressure, at)]].concat(),
                    ..Datasheet::default()
                };
                [worked, plain].map(|sheet| {
                    let rows = sheet.sample(&Scene::default()).expect("a hammer");
                    rows.iter().find(|row| row.name == "blow energy").expect("it").value
                })
            })
            .collect();
        for pair in energies.windows(2) {
            assert!(pair[1][0] > pair[0][0] && pair[1][1] > pair[0][1], "{model}: {energies:?}");
        }
    }
}

/// One row of a table ten times too large is named, with its pressure; the others are not.
#[test]
fn a_misprint_in_a_table_is_named() {
    let table = |first: f64| {
        let air = vec![[10e5, first / 60.0], [15e5, 12.0 / 60.0], [17e5, 14.0 / 60.0]];
        let known = vec![(OuterDiameter, 0.126), (PistonMass, 12.0), (Pressure, 17e5)];
        Datasheet { known, air, ..Datasheet::default() }.solve(&Scene::default()).expect("it")
    };
    let of_air = |solution: &Solution| -> Vec<String> {
        let all = solution.contradictions.iter();
        all.filter(|text| text.starts_with("air_flow")).cloned().collect()
    };
    assert!(of_air(&table(7.5)).is_empty(), "{:?}", of_air(&table(7.5)));
    let wrong = of_air(&table(75.0));
    assert!(wrong.len() == 1 && wrong[0].starts_with("air_flow at 10 bar: 75 m3/min"), "{wrong:?}");
}

/// Mass, energy and speed that do not fit: told, with the size. `W = m v^2 / 2` is off by a factor 1.5, of which energy
/// and twice the speed take 1 and 4 parts of five, the mass next to nothing.
#[test]
fn what_contradicts_is_told_with_its_size() {
    let energy = 1.5 * 0.5 * 8.6 * 100.0;
    let known = [(PistonMass, 8.6), (ImpactSpeed, 10.0), (BlowEnergy, energy), (Frequency, 30.0)];
    let solution = solved(&known);
    let messages = &solution.contradictions;
    assert!(messages.iter().any(|t| t.starts_with("blow_energy: 645 J given")), "{messages:?}");
    assert!(messages.iter().any(|t| t.starts_with("impact_speed")), "{messages:?}");
    let off = solution.compared.iter().find(|c| c.quantity == BlowEnergy).expect("it").off();
    // exp(-ln 1.5 / 5) - 1, to what the mass, and the frequency's pull on the energy, shift it.
    assert!((off - (-0.2 * 1.5f64.ln()).exp_m1()).abs() < 0.03, "{off}");
}

/// A rate says the specific energy: the power to the rock over area and rate, to the rate's error; at another pressure
/// the rate stays as narrow, though the energy of no rock is known to 10 %.
#[test]
fn a_measured_rate_is_carried_to_another_pressure() {
    let known = [&SANDVIK[..], &[(Rate, 18.0 / 3600.0)]].concat();
    let here = solved(&known);
    let area = std::f64::consts::FRAC_PI_4 * 0.14 * 0.14;
    let energy = found(&here, "specific energy");
    let product = energy * area * 18.0 / 3600.0 / found(&here, "power to the rock");
    assert!((product - 1.0).abs() < 0.05, "{product}");
    assert_eq!(here.scene.parameters.rock.specific_energy, energy);
    let wide = |solution: &Solution| {
        let [low, high] = range(solution, "rate of penetration");
        high / low
    };
    // 80 % of what is known to 10 %.
    assert!((wide(&here) / (2.0 * 1.28 * 0.1f64).exp() - 1.0).abs() < 0.06, "{}", wide(&here));
    let sheet = Datasheet { known, at: Some(30e5), ..Datasheet::default() };
    let there = sheet.solve(&Scene::default()).expect("a hammer");
    assert!(found(&there, "rate") > 1.15 * found(&here, "rate"));
    // Each hammer, elastic, drills at the told rate: to the error of its loop, 0.5 % of energy and frequency each, and
    // of means of few blows.
    for solution in [&here, &there, &solved(&SANDVIK)] {
        let [_, _, drilled] = settled(&solution.scene);
        let rate = found(solution, "rate of penetration");
        assert!((drilled / rate - 1.0).abs() < 0.015, "{drilled} {rate}");
    }
    assert!(wide(&there) < 1.1 * wide(&here), "{} {}", wide(&there), wide(&here));
    assert!(wide(&solved(&SANDVIK)) > 1.5 * wide(&here));
}

/// Members of two sheets are drawn alike: what is unknown of both cancels in their ratio.
#[test]
fn two_pressures_of_a_hammer_have_a_narrow_ratio() {
    let sample = |at: f64| {
        let sheet = Datasheet { known: SANDVIK.to_vec(), at: Some(at), ..Datasheet::default() };
        let rows = sheet.sample(&Scene::default()).expect("a hammer");
        rows.into_iter().find(|row| row.name == "rate of penetration").expect("it")
    };
    let (low, high) = (sample(24e5), sample(30e5));
    let mut ratios: Vec<f64> = high.members.iter().zip(&low.members).map(|(a, b)| a / b).collect();
    ratios.sort_by(f64::total_cmp);
    let [least, most] = [ratios[ratios.len() / 10], ratios[ratios.len() * 9 / 10]];
    // The exponents by which energy and frequency differ from the model's are known to 0.11 and 0.1, that of the power
    // to 0.15; the rest of what is unknown of the hammer cancels to some per cent.
    let own = (2.0 * 1.28 * 0.15 * (30.0f64 / 24.0).ln()).exp();
    assert!(least > 1.1 && (0.95 * own..1.07 * own).contains(&(most / least)), "{least} to {most}");
    assert!(low.range[1] / low.range[0] > 1.5);
}

#[test]
fn what_no_hammer_has_is_asked_about() {
    let refused = |known: &[(Quantity, f64)]| {
        let error = sheet(known).solve(&Scene::default()).expect_err("refused");
        assert!(matches!(error, DatasheetError::Absurd(_)), "{error:?}");
        error.to_string()
    };
    let rest = [(PistonMass, 8.6), (Frequency, 30.0)];
    let with = |known| refused(&[&rest[..], &[known]].concat());
    assert!(with((BlowEnergy, 9.5e6)).starts_with("blow_energy = 9500000"));
    assert!(with((ImpactSpeed, 1256.0)).contains("0.5 to 25 m/s"));
    // An energy that is allowed, of a piston that would be a projectile.
    assert!(with((BlowEnergy, 5e3)).contains("impact_speed"));
    assert!(with((Pressure, f64::NAN)).contains("pressure"));
    assert!(with((DampingRatio, 0.7)).contains("damping_ratio = 0.7"));
    let mut table = sheet(&rest);
    table.air = vec![[10e5, 1e3]];
    let error = table.solve(&Scene::default()).expect_err("refused").to_string();
    assert!(error.contains("air_flow = 1000"), "{error}");
}

/// 3.4 kg in which 350 J are asked for strike at 14.3 m/s: told, and cut, not met.
#[test]
fn a_piston_that_is_too_light_is_told() {
    let solution = solved(&[(PistonMass, 3.4), (BlowEnergy, 350.0), (Frequency, 30.0)]);
    let message = solution.contradictions.join("\n");
    assert!(message.contains("than the 13 m/s beyond which steel does not last"), "{message}");
    let [low, high] = range(&solution, "impact speed");
    assert!(low > 12.5 && high < 14.5 && high / low > 1.005, "{low} to {high}");
}

#[test]
fn what_no_hammer_does_is_told_in_words() {
    let message = |known: &[(Quantity, f64)]| solved(known).contradictions.join("\n");
    let fast = message(&[(PistonMass, 6.0), (BlowEnergy, 300.0), (Frequency, 100.0)]);
    assert!(fast.contains("more than the 50 that the fastest hammers do"), "{fast}");
    // Piston and stroke have 0.7 of the length: told in whole millimetres.
    let slow = [(PistonMass, 3.4), (BlowEnergy, 220.0), (Frequency, 10.0), (OuterDiameter, 0.067)];
    let short = |whole: f64| message(&[&slow[..], &[(Length, whole)]].concat());
    let refusal = short(0.4);
    let millimetres = |mark: &str| {
        let before = refusal.split(mark).next().and_then(|text| text.rsplit(' ').next());
        before.and_then(|word| word.parse::<f64>().ok()).expect("a length")
    };
    let least = 1e-3 * (millimetres(" mm turns") + millimetres(" mm above the bit")) / 0.7;
    let is_told = |whole: f64| short(whole).contains("there is no room for both");
    assert!(is_told(0.995 * least) && !is_told(1.005 * least), "{refusal}");
    let weak = [(PistonMass, 8.6), (BlowEnergy, 475.0), (Frequency, 30.0), (Stroke, 0.05)];
    let weak = message(&[&weak[..], &[(Pressure, 5e5), (OuterDiameter, 0.1)]].concat());
    assert!(weak.contains("% more than all of the supply's"), "{weak}");
}

/// Pressure times flow is the power of a liquid, of which the blows have 0.6, up to 15 % (the flow's own error aside).
#[test]
fn a_liquid_s_flow_is_a_power() {
    let flow = 380e-3 / 60.0;
    let known = [(Pressure, 150e5), (Flow, flow), (Frequency, 1780.0 / 60.0)];
    let solution = solved(&known);
    let power = found(&solution, "power of the blows");
    assert!((power / (0.6 * 150e5 * flow) - 1.0).abs() < 0.15, "{power}");
    let assumed = solution.assumed.join("\n");
    assert!(assumed.contains("liquid") && !assumed.contains("air presets"), "{assumed}");
    assert!(solution.contradictions.is_empty(), "{:?}", solution.contradictions);
    // The contact is as stiff as the section is large.
    let stiffness = |p: &Parameters| p.contact.stiffness / p.cross_section;
    let ratio = stiffness(&solution.scene.parameters) / stiffness(&Scene::default().parameters);
    assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
    let [energy, frequency, _] = settled(&solution.scene);
    assert!((energy / found(&solution, "blow energy") - 1.0).abs() < 0.02, "{energy} J");
    assert!((frequency * 60.0 / 1780.0 - 1.0).abs() < 0.05, "{frequency} Hz");
}

#[test]
fn too_little_is_told_with_what_is_missing() {
    let message = |known: &[(Quantity, f64)]| {
        sheet(known).solve(&Scene::default()).expect_err("refused").to_string()
    };
    assert!(message(&[(PistonMass, 8.6)]).contains("says the power"));
    assert!(message(&[(Frequency, 30.0)]).contains("piston_mass"));
}
