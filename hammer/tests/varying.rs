//! The ledger's derivatives under loads that vary, against central differences.

use hammer::tangent::{Parameter, Seed, Tangents};
use hammer::{
    Energies, Event, Fidelity, Impulses, Input, InputValues, Machine, Parameters, Source,
};

/// Value and derivatives of an input from the start on.
type Course = (Input, Vec<f64>);

fn list((e, i): (Energies, Impulses)) -> [f64; 12] {
    let Energies { drive, gravity, feed, kinetic, strain, contact, .. } = e;
    let lost = [e.rock_stored, e.rock_dissipated, e.viscous, e.damping];
    let [a, b, c, d] = lost;
    [drive, gravity, feed, kinetic, strain, contact, a, b, c, d, i.contact, i.rock]
}

/// The bit stands where the feed presses it at first.
fn begin(p: &Parameters, courses: &[Course]) -> Machine {
    let feed = courses.iter().find(|c| c.0 == Input::FeedForce).expect("a feed");
    let inputs = InputValues { feed_force: feed.1[0], ..InputValues::default() };
    Machine::new(p, &inputs, 0.0).expect("a scene")
}

fn run(p: &Parameters, courses: &[Course], end: f64) -> (Vec<Event>, [f64; 12]) {
    let mut machine = begin(p, courses);
    machine.keep_journal(true);
    for (input, derivatives) in courses {
        machine.set_input(*input, derivatives).expect("an input");
    }
    machine.advance(end).expect("a run");
    let events = machine.take_journal().iter().map(|r| r.event).collect();
    (events, list((machine.energies(), machine.impulses())))
}

/// The scene and its courses with what a seed is by changed.
fn changed(p: &Parameters, courses: &[Course], seed: Seed, by: f64) -> (Parameters, Vec<Course>) {
    let (mut p, mut courses) = (*p, courses.to_vec());
    match seed {
        Seed::Parameter(q) => *q.slot(&mut p) += by,
        Seed::Input(input, order) => {
            let course = courses.iter_mut().find(|c| c.0 == input).expect("a course");
            course.1[order] += by;
        }
        Seed::State => {}
    }
    (p, courses)
}

/// Differences over `h` and half of it; what they do not agree about, four times (curvature), and
/// 1e-12 of 200 J over the step are granted.
fn compare(p: &Parameters, courses: &[Course], seeds: &[(Seed, f64)], end: f64) -> usize {
    let mut machine = begin(p, courses);
    let by: Vec<Seed> = seeds.iter().map(|s| s.0).collect();
    let mut tangents = Tangents::of_scene(&machine, &by).expect("tangents").with_ledger(&machine);
    for (input, derivatives) in courses {
        tangents.set_input(&mut machine, *input, derivatives).expect("an input");
    }
    tangents.advance(&mut machine, end).expect("a run");
    assert_eq!(tangents.cautious(), 0, "{:?}", tangents.cautions());
    let (found, reach) = (tangents.look(&machine), tangents.reach());
    let (events, _) = run(p, courses, end);
    let mut compared = 0;
    for (((seed, unit), d), reach) in seeds.iter().zip(&found).zip(reach) {
        let h = (0.01 * reach / unit).min(1e-5);
        let difference = |h: f64| {
            let [low, high] = [-h, h].map(|part| {
                let (p, courses) = changed(p, courses, *seed, part * unit);
                run(&p, &courses, end)
            });
            let same = low.0 == events && high.0 == events;
            same.then(|| std::array::from_fn(|k| (high.1[k] - low.1[k]) / (2.0 * h)))
        };
        let (Some(coarse), Some(fine)): (Option<[f64; 12]>, _) =
            (difference(h), difference(0.5 * h))
        else {
            continue;
        };
        compared += 1;
        for (k, ours) in list(d.ledger.expect("asked for")).into_iter().enumerate() {
            let (ours, theirs) = (ours * unit, fine[k] + (fine[k] - coarse[k]) / 3.0);
            let bound = 4.0 * (coarse[k] - fine[k]).abs() + 200.0 * 1e-12 / h + 1e-8 * ours.abs();
            let off = (ours - theirs).abs();
            assert!(off <= bound, "{seed:?} {k} at {end}: {ours:e} {theirs:e}, bound {bound:e}");
        }
    }
    compared
}

#[test]
fn works_of_loads_that_vary_have_the_derivatives_that_differences_tend_to() {
    let mut compared = 0;
    for (fidelity, segments) in
        [(Fidelity::Rigid, 0), (Fidelity::Elastic, 0), (Fidelity::Elastic, 2)]
    {
        let mut p = Parameters { fidelity, ..Parameters::default() };
        (p.piston.elements, p.bit.elements, p.bit.length) = (5, 4, 0.21);
        (p.drive.source, p.piston.segments) = (Source::Force, segments);
        (p.piston.segment[0].length, p.piston.segment[1].area) = (0.07, 1.9e-3);
        (p.contact.initial_gap, p.piston.initial_velocity) = (0.01, 3.0);
        let courses: [Course; 2] = [
            (Input::DriveForce, vec![900.0, 4e4, -3e6]),
            (Input::FeedForce, vec![5e3, -2e5, 6e7, 1e9]),
        ];
        let read = Parameter::ALL.iter().filter(|q| q.is_read(&p));
        let value = |q: &Parameter| *q.slot(&mut p.clone());
        let mut seeds: Vec<_> =
            read.map(|q| (Seed::Parameter(*q), value(q))).filter(|s| s.1 != 0.0).collect();
        for (input, derivatives) in &courses {
            let orders = derivatives.iter().enumerate();
            seeds.extend(orders.map(|(k, x)| (Seed::Input(*input, k), x.abs())));
        }
        for end in [2e-3, 3.2e-3, 0.012, 0.02] {
            compared += compare(&p, &courses, &seeds, end);
        }
    }
    assert!(compared > 200, "{compared}");
}
