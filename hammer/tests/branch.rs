//! Branches of cycles along a parameter, against the simulation and single searches.

use crate::scenes::overdamped;
use hammer::Scene;
use hammer::periodic::{Branch, BranchPoint, Cycle, CycleError, Piece, Schedule, Search, find};
use hammer::sensitivity::Argument;
use hammer::{Fidelity, Input, InputValues, Machine, Parameters, Source};

fn scene(parameters: &Parameters) -> Scene {
    Scene { parameters: *parameters, ..Scene::default() }
}

fn named(name: &str) -> Argument {
    Argument::named(name).expect("a row of the table")
}

fn settled(p: &Parameters) -> Cycle {
    let search = Search { settle: 60, ..Search::default() };
    find(&scene(p), &search, &[]).expect("a cycle")
}

fn branch(p: &Parameters, along: &str, rising: bool) -> Result<Branch, CycleError> {
    let start = settled(p);
    Branch::new(&scene(p), named(along), &Search::default(), &start.orbit, rising)
}

fn rigid() -> Parameters {
    Parameters { fidelity: Fidelity::Rigid, ..overdamped() }
}

/// A piston of three sections.
fn stepped() -> Parameters {
    let mut p = overdamped();
    (p.piston.elements, p.bit.elements, p.piston.segments) = (7, 7, 3);
    let parts = [(0.1, 2.7e-3), (0.04, 1.7e-3), (0.03, 2e-3)];
    for (s, (length, area)) in p.piston.segment.iter_mut().zip(parts) {
        (s.length, s.area) = (length, area);
    }
    p
}

/// Points of a branch up to a value of the parameter over that of the start.
fn follow(p: &Parameters, parameter: &str, part: f64, step: f64) -> Vec<BranchPoint> {
    let own = named(parameter).value(&scene(p));
    let rising = part > 1.0;
    let mut branch = branch(p, parameter, rising).expect("a branch");
    let mut list: Vec<BranchPoint> = Vec::new();
    while list.last().is_none_or(|w| (w.value / own < part) == rising) {
        assert!(list.len() < 300, "{parameter:?} takes no end");
        list.push(branch.next(step, &[]).expect("a point"));
    }
    list
}

/// Both are solved to 1e-10 of the state.
#[test]
fn a_branch_passes_through_the_cycles_that_single_searches_find() {
    let (area, length) = ("piston.segment[2].area", "piston.segment[1].length");
    let elastic = stepped();
    let stepped = Parameters { fidelity: Fidelity::Rigid, ..elastic };
    for (p, parameter, part, step) in [
        (rigid(), "rock.stiffness", 1.6, 0.04),
        (rigid(), "bit.length", 0.7, 0.04),
        (overdamped(), "rock.stiffness", 1.015, 0.04),
        (stepped, area, 1.3, 0.04),
        (elastic, area, 1.0005, 1e-4),
        (elastic, length, 1.0004, 1e-4),
    ] {
        let list = follow(&p, parameter, part, step);
        for point in list.iter().step_by(list.len().div_ceil(3)) {
            let there = named(parameter).at(&scene(&p), point.value);
            let alone = settled(&there.parameters);
            let along = &point.cycle;
            let (alone_response, along_response) = (&alone.response, &along.response);
            for (a, b) in [
                (along_response.period, alone_response.period),
                (along_response.advance, alone_response.advance),
            ] {
                assert!((a / b - 1.0).abs() < 1e-9, "{parameter:?} {}: {a} {b}", point.value);
            }
            assert_eq!(along.sequence, alone.sequence);
        }
    }
}

/// The multiplier leaves the circle at -1, and the cycle is there all the same. A simulation that
/// starts beside it comes nearer, or goes away, at the rate that the multiplier says.
///
/// The feed is off by a hundredth for 1 ms: blow periods then differ by some 1e-8 s, curvature by
/// the square of that; after ten blows the other multiplier (0.5 of the leading one, less) has
/// left a thousandth.
#[test]
fn a_branch_goes_on_past_a_flip_and_simulations_leave_it_at_the_rate_of_its_multiplier() {
    let list = follow(&rigid(), "bit.length", 1.165, 0.02);
    let flip = list.iter().position(|w| !w.cycle.is_stable()).expect("a flip");
    for (point, stable) in [(&list[flip - 1], true), (&list[flip], false)] {
        let cycle = &point.cycle;
        assert!(cycle.distance < 1e-10);
        let rate = cycle.multipliers[0];
        assert!(rate.im == 0.0 && rate.re < -0.5 && (rate.re > -1.0) == stable, "{rate}");
        let mut p = rigid();
        p.bit.length = point.value;
        let mut machine = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
        machine.restore(&cycle.state).expect("its state");
        let feed = InputValues::default().feed_force;
        let start = machine.time();
        machine.set_input(Input::FeedForce, &[feed * 1.01]).expect("a force");
        machine.advance(start + 1e-3).expect("a run");
        machine.set_input(Input::FeedForce, &[feed]).expect("a force");
        let (mut off, mut observed) = (Vec::new(), machine.counters().blows);
        while off.len() < 14 {
            machine.advance(machine.time() + 0.01).expect("a run");
            if machine.counters().blows > observed {
                observed = machine.counters().blows;
                off.push(machine.blow().expect("a blow").period - cycle.response.period);
            }
        }
        for k in 11..14 {
            let observed = off[k] / off[k - 1];
            assert!(
                (observed / rate.re - 1.0).abs() < 5e-3,
                "blow {k}: {observed} {rate}, {off:?}"
            );
        }
    }
}

/// A rigid piston under gravity `G`, pushed by `F + f s(t)` with `s` falling from 1 to -1 over each
/// period `T`, rebounds from the bit at a part `e` of its speed. That it is back after a period asks
/// of the phase `x` of the blow, over `T`,
///
/// ```text
/// x - x^2 = 1/6 + (1 - e) (F + Mp G) / (2 (1 + e) f),
/// ```
///
/// which two phases do, up to `x = 1/2`, where `s` is 0: there the two cycles meet, and beyond a
/// certain `G` there is none. A blow that takes its time, two collisions long, has that instant
/// within it.
#[test]
fn a_branch_turns_at_a_fold_where_the_force_of_a_repeating_drive_changes_its_sign_in_the_blow() {
    let (period, mean) = (0.04, 600.0);
    let mut p = rigid();
    p.drive.source = Source::Force;
    p.contact.initial_gap = 0.01;
    let derivatives = vec![5.0 * mean, -8.0 * mean / period];
    let pieces = vec![Piece { at: 0.0, input: Input::DriveForce, derivatives }];
    let schedule = Some(Schedule { period, pieces });
    let search = Search { schedule, settle: 60, ..Search::default() };
    let inputs = InputValues::default();
    let start = find(&scene(&p), &search, &[]).expect("a cycle");
    // Strides are in parts of the start value: from far off, and from near by.
    let branch = |p: &Parameters, cycle: &Cycle| {
        Branch::new(&scene(p), named("gravity"), &search, &cycle.orbit, true).expect("a branch")
    };
    let round = |mut list: Vec<BranchPoint>, branch: &mut Branch, step: f64| {
        while list.last().is_none_or(|w| w.rising || w.value > 130.0) {
            assert!(list.len() < 100, "it takes no end");
            list.push(branch.next(step, &[]).expect("a point"));
        }
        list
    };
    // From far off the fold is tighter than a stride: strides become that short.
    let mut far = round(Vec::new(), &mut branch(&p, &start), 0.5);
    assert!(far.iter().all(|w| !w.unresolved));
    let tight = highest(&far);
    far.truncate(far.iter().position(|w| w.value > 127.0).expect("before the fold") + 1);
    let near = far.pop().expect("a point");
    p.gravity = near.value;
    let mut close = branch(&p, &near.cycle);
    let list = round(vec![near], &mut close, 0.02);
    // Both are below the fold by less than their neighbours are below them.
    let (fold, other) = (highest(&list), tight);
    assert!((fold[0] - other[0]).abs() < fold[1].max(other[1]), "{fold:?} {other:?}");
    let turn = list.iter().position(|w| !w.rising).expect("a fold");
    let leading = |w: &BranchPoint| w.cycle.multipliers[0];
    // The leading multiplier passes through 1 as the parameter turns back.
    assert!(list.iter().all(|w| !w.unresolved && w.cycle.distance < 1e-10));
    assert!(leading(&list[turn - 1]).re < 1.0 && list[turn - 1].cycle.is_stable());
    assert!(list[turn..].iter().all(|w| leading(w).im == 0.0 && leading(w).re > 1.0));
    let phase = |w: &BranchPoint| w.cycle.response.strikes[0].time;
    assert!(list.windows(2).all(|w| phase(&w[1]) < phase(&w[0])));
    // At one value there are two cycles.
    let back = list.last().expect("points");
    let other =
        list[..turn].windows(2).find(|w| w[0].value < back.value && back.value < w[1].value);
    assert!(other.is_some_and(|w| phase(&w[1]) > phase(back) + 0.05 * period));
    let fold = list.iter().max_by(|a, b| a.value.total_cmp(&b.value)).expect("points");
    p.gravity = fold.value;
    let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
    machine.restore(&fold.cycle.state).expect("its state");
    let begun = machine.time();
    machine.set_input(Input::DriveForce, &[5.0 * mean, -8.0 * mean / period]).expect("a force");
    machine.keep_journal(true);
    machine.advance(begun + 0.9 * period).expect("a run");
    let journal = machine.take_journal();
    let opened = journal.iter().rfind(|r| r.event.is_contact()).expect("a blow");
    let (struck, half, parted) = (phase(fold), 0.5 * period, opened.time - begun);
    assert!(struck < half && half < parted, "{struck} to {parted} of {period}");
    assert!(parted - struck < 0.05 * period, "{struck} to {parted} of {period}");
}

/// The highest value of a list of points that turns, and by how much it is above the lower of its
/// neighbours.
fn highest(list: &[BranchPoint]) -> [f64; 2] {
    let tops = |w: &&[BranchPoint]| w[1].value >= w[0].value.max(w[2].value);
    let [before, top, after] = list.windows(3).find(tops).expect("a turn") else { unreachable!() };
    [top.value, top.value - before.value.min(after.value)]
}

/// The tangent's slope is the derivative: of the period by an input, over a short stride.
#[test]
fn a_short_stride_along_an_input_follows_the_gradient() {
    let p = rigid();
    let feed = named("feed_force");
    let mut branch = branch(&p, "feed_force", true).expect("a branch");
    let first = branch.next(1e-4, &[feed]).expect("a point").clone();
    let second = branch.next(1e-4, &[feed]).expect("a point");
    let rise = second.cycle.response.period - first.cycle.response.period;
    let step = second.value - first.value;
    let slopes = [&first, &second].map(|point| point.cycle.gradients[0].values.period);
    let mean = 0.5 * (slopes[0] + slopes[1]);
    // The trapezoidal rule is off by the third derivative, 1e-8 of the slope; the periods by
    // 1e-12 of themselves.
    let bound = 1e-6 * mean.abs() + 2e-12 * first.cycle.response.period / step;
    assert!((rise / step - mean).abs() < bound, "{} {mean}", rise / step);
}

#[test]
fn a_branch_needs_a_parameter_that_is_not_zero() {
    let p = Parameters { gravity: 0.0, ..rigid() };
    let error = branch(&p, "gravity", true).expect_err("no size");
    assert_eq!(error, CycleError::NoScale { value: 0.0 });
}
