//! The peers against the reference: each within what its method promises, every event found.

use bench::alpha::Alpha;
use bench::exponential::Exponential;
use bench::hybrid;
use bench::radau::Radau;
use bench::sampled::Sampled;
use bench::tabulated::Tabulated;
use bench::trajectory::{Peer, Task, Trajectory, Verdict};
use oracles::model::Model;
use oracles::reference::{Record, stored};

fn judge(solve: impl FnOnce(&Model<f64>, &Task) -> Result<Trajectory, String>) -> Verdict {
    let record: Record = stored(20).unwrap();
    let model = Model::new(&record.scene);
    let task = Task::cycle(&record);
    solve(&model, &task).unwrap().judge(&model, &record, &task)
}

#[test]
fn adaptive_radau_finds_every_event_and_follows_its_tolerance() {
    // Local errors grow by the two collisions: a factor of ten is measured at most.
    for tolerance in [1e-5, 1e-7] {
        let verdict = judge(|m, task| hybrid::run(m, &mut Radau::adaptive(m, tolerance), task));
        assert!(verdict.error < 10.0 * tolerance, "{tolerance}: {verdict:?}");
        assert_eq!((verdict.missed, verdict.spurious), (0, 0));
    }
}

#[test]
fn fixed_radau_converges_at_order_five() {
    let error = |h| judge(|m, task| hybrid::run(m, &mut Radau::fixed(m, h), task)).error;
    let order = (error(2e-7) / error(1e-7)).log2();
    assert!(order > 4.0, "{order}");
}

#[test]
fn tabulated_propagators_are_exact_but_for_their_scan() {
    let verdict = judge(|m, task| Tabulated::new(m, 5e-7).run(task));
    assert!(verdict.error < 1e-7, "{verdict:?}");
    assert_eq!((verdict.missed, verdict.spurious), (0, 0));
}

#[test]
fn generalised_alpha_is_of_second_order() {
    let error = |h| judge(|m, task| hybrid::run(m, &mut Alpha::new(m, h, 0.8), task)).error;
    let ratio = error(4e-8) / error(2e-8);
    assert!((2.5..6.5).contains(&ratio), "{ratio}");
}

#[test]
fn exponential_integrator_finds_every_event_and_follows_its_tolerance() {
    // Local errors add up over some ten thousand steps and grow by the two collisions.
    for tolerance in [1e-8, 1e-10] {
        let solve =
            |m: &Model<f64>, task: &Task| hybrid::run(m, &mut Exponential::new(m, tolerance), task);
        let verdict = judge(solve);
        assert!(verdict.error < 1e4 * tolerance, "{tolerance}: {verdict:?}");
        // A creeping tip's speed is resolved to 1e-9 m/s: a local error above it may turn it.
        assert_eq!(verdict.missed, 0, "{tolerance}: {verdict:?}");
        assert!(verdict.spurious == 0 || tolerance > 1e-9, "{tolerance}: {verdict:?}");
    }
}

#[test]
fn guards_that_are_sampled_need_no_proof_in_fine_strides_and_miss_events_in_coarse_ones() {
    let run = |stride| judge(|_, task| Sampled::new(Default::default(), stride)?.run(task));
    let fine = run(2.5e-7);
    assert_eq!((fine.missed, fine.spurious), (0, 0), "{fine:?}");
    // Rounding of 1 mm, 1e-14 of it, times up to 1e3 at each of the two collisions; an event is
    // off by 1e-15 s, in which nothing moves by more than 1e-14 m.
    assert!(fine.error < 1e-9, "{fine:?}");
    // Bit and piston part and meet again within a microsecond or two: half of the events are lost.
    let coarse = run(4e-6);
    assert!(coarse.missed > 0, "{coarse:?}");
}
