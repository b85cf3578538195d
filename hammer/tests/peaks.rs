//! The largest forces over a step, against the forces themselves.

use hammer::{Error, Input, InputValues, Interrupt, Machine, Parameters, Source, WorkLimit};

/// Where the first blow's contact force is largest, s, and the rock's force where
/// the tip turns: smooth maxima.
const BLOW: [[f64; 2]; 2] = [[0.01367, 0.01376], [0.01390, 0.01397]];

fn at(start: f64) -> Machine {
    let mut m =
        Machine::new(&Parameters::default(), &InputValues::default(), 0.0).expect("a scene");
    m.advance(start).expect("a step");
    m
}

/// `F_C` or `F_R`.
fn force(m: &Machine, which: usize) -> f64 {
    let k = m.kinematics();
    [k.contact_force, k.rock_force][which]
}

/// Instant and size of the largest of `n + 1` samples between two instants.
fn top([from, to]: [f64; 2], n: u32, which: usize) -> (f64, f64) {
    let mut m = at(from);
    let sample = |i| {
        let t = from + (to - from) * f64::from(i) / f64::from(n);
        m.advance(t).expect("a step");
        (t, force(&m, which))
    };
    (0..=n).map(sample).fold((0.0, 0.0), |a, b| if b.1 > a.1 { b } else { a })
}

/// Steps that begin anywhere before the maximum or end anywhere after it, by a nanosecond or a microsecond: the
/// maximum may lie anywhere in the search's windows, and at either end of one.
#[test]
fn the_peak_of_a_step_is_found_wherever_the_step_begins_and_ends() {
    for which in 0..2 {
        // To 0.1 us, then to 0.1 ns. F'' is below 1e17 N/s2, so the maximum is at most 0.001 N higher.
        let (near, _) = top(BLOW[which], 2400, which);
        let (place, largest) = top([near - 1e-7, near + 1e-7], 2000, which);
        assert!(largest > 1e5, "{which}: the blow is not where it was");
        for k in 0..60 {
            let ahead = 1e-9 * 1.13f64.powi(k);
            for [from, to] in [[place - ahead, place + 1e-6], [place - 1e-6, place + ahead]] {
                let mut m = at(from);
                m.advance(to).expect("a step");
                let peak = [m.peaks().contact_force(), m.peaks().rock_force()][which];
                // A window neglects 1e-13 m at 1e11 N/m; the rest is the sampling's own error.
                assert!((peak - largest).abs() < 0.02, "{which}, {from} to {to}: {peak} {largest}");
            }
        }
    }
}

/// The bit oscillates undamped in standstill, since 10 N more of feed is far below the standstill speed. On its way
/// up the piston passes a port of its cylinder, whose air does not push it, every 1.6 s.
fn ringing() -> Machine {
    let mut p = Parameters { gravity: 0.0, ..Parameters::default() };
    (p.material.damping_time, p.drive.source) = (0.0, Source::Air);
    (p.drive.area_drive, p.drive.area_return, p.piston.initial_velocity) = (1e-12, 1e-12, -0.1);
    let air = &mut p.air;
    (air.cylinder, air.port_height, air.supply_area, air.exhaust_area) = (2.0, 1.0, 0.0, 0.0);
    let (drive, back) = (&mut air.drive, &mut air.returning);
    let ports = [&mut drive.supply, &mut back.supply, &mut back.exhaust, &mut drive.exhaust];
    for (edge, count) in ports.into_iter().zip(1..) {
        *edge = -p.contact.initial_gap - 0.16 * f64::from(count);
    }
    let inputs =
        InputValues { supply_pressure: 1e5, exhaust_pressure: 1e5, ..InputValues::default() };
    let mut m = Machine::new(&p, &inputs, 0.0).expect("a scene");
    m.set_input(Input::FeedForce, &[inputs.feed_force + 10.0]).expect("a load");
    m
}

/// Only the search for peaks takes long here. The work of the whole step is limited, not that of each interval, and
/// the answer does not depend on how often or from which state it is asked for.
#[test]
fn a_step_that_rings_too_long_for_its_peaks_is_refused_and_a_shorter_one_is_searched() {
    let mut m = ringing();
    m.advance(8.0).expect("a step");
    assert_eq!(m.counters().events, 4, "stretches of 1.6 s, none of which would be too long");
    let refusal = m.prepare_peaks();
    let Err(Error::Overwork { limit: WorkLimit::Peaks, .. }) = &refusal else {
        panic!("{refusal:?}")
    };
    assert!(m.peaks().rock_force().is_nan() && m.peaks().contact_force().is_nan());
    assert_eq!(m.prepare_peaks(), refusal, "read again");
    let mut other = ringing();
    other.restore(&m.state()).expect("a state");
    assert_eq!(other.prepare_peaks(), refusal, "after a state");
    m.advance(8.01).expect("a step");
    assert_eq!(m.prepare_peaks(), Ok(()));
    assert!(
        m.peaks().rock_force() > InputValues::default().feed_force + 10.0,
        "it rings about that"
    );
}

/// A state is stored with the peaks of its step so far, here those of a blow.
#[test]
fn a_step_after_a_stored_state_has_its_own_peaks() {
    let (mut struck, mut restored) = (at(BLOW[0][1]), at(0.0));
    let stored = serde_json::to_string(&struck.state()).expect("a state in JSON");
    restored.restore(&serde_json::from_str(&stored).expect("a state")).expect("the same scene");
    for machine in [&mut struck, &mut restored] {
        machine.advance(0.015).expect("a step");
    }
    assert_eq!(restored.peaks(), struck.peaks());
}

#[test]
fn half_a_second_of_ringing_is_searched() {
    let mut m = ringing();
    let looks = (1..=1000).map(|k| {
        m.advance(5e-4 * f64::from(k)).expect("a step");
        m.kinematics().rock_force
    });
    let largest = looks.fold(0.0, f64::max);
    let mut m = ringing();
    m.advance(0.5).expect("a step");
    let cancelled = Interrupt::asking(|| true).watch(|| m.prepare_peaks());
    assert_eq!(cancelled, Err(Error::Cancelled));
    assert_eq!(m.prepare_peaks(), Ok(()), "a later look begins the search again");
    assert!(m.peaks().rock_force() >= largest, "{:?} {largest}", m.peaks());
}
