//! A hammer driven by air through the C functions: pressures, flows and work.

use crate::support::host::{Host, vr};
use crate::support::library::{ERROR, Library, OK};
use crate::support::three::{Three, extra};
use dth_hammer::capabilities::OVER_STEP;
use dth_hammer::events::Extra;

/// `drive.source = Air`.
const AIR: i32 = 4;

/// A host of either standard.
trait Driver {
    fn value(&self, name: &str) -> f64;
    fn advance(&self, from: f64, to: f64);
    /// Sets an input to a value that changes at a rate.
    fn ramp(&self, name: &str, ramp: (f64, f64));
    /// Makes a step that must fail. Returns until when the motion is known, and the reason.
    fn fails(&self, from: f64, to: f64) -> (f64, String);
}

/// `fmi2LastSuccessfulTime`.
const LAST_TIME: i32 = 2;

impl Driver for Host<'_> {
    fn value(&self, name: &str) -> f64 {
        self.get(name)
    }
    fn advance(&self, from: f64, to: f64) {
        self.step(from, to - from);
    }
    fn ramp(&self, name: &str, (value, slope): (f64, f64)) {
        self.set(name, value);
        self.set_derivative(name, 1, slope);
    }
    fn fails(&self, from: f64, to: f64) -> (f64, String) {
        self.take_log();
        assert_eq!(self.library.step(self.handle, from, to - from), ERROR);
        (self.library.real_status(self.handle, LAST_TIME).1, self.only_error())
    }
}

impl Driver for Three<'_> {
    fn value(&self, name: &str) -> f64 {
        self.get(vr(name))
    }
    fn advance(&self, from: f64, to: f64) {
        self.run(from, to, |_, _| ());
    }
    fn ramp(&self, name: &str, (value, slope): (f64, f64)) {
        self.set("Float64", vr(name), value);
        self.set("Float64", extra(&format!("{name}_rate")), slope);
    }
    fn fails(&self, from: f64, to: f64) -> (f64, String) {
        self.lines();
        let (mut status, mut ended) = self.try_step(from, to - from);
        // A step may end early at a blow.
        while status == OK && ended.event {
            self.event(|_, _| {});
            (status, ended) = self.try_step(ended.time, to - ended.time);
        }
        assert_eq!(status, ERROR);
        (ended.time, self.only_error())
    }
}

/// Rigid and elastic, the latter in a casing that vents the chambers when it is lifted.
fn scenes() -> [(i32, Vec<(&'static str, f64)>); 2] {
    let cased = [
        ("casing.mass", 30.0),
        ("chuck.idle_travel", 0.02),
        ("contact.initial_gap", 0.04),
        ("feed_force", 8e3),
    ];
    let leaking = [("air.leakage_area", 2e-6), ("air.drag", 5.0)];
    [(1, leaking.to_vec()), (2, [&leaking[..], &cased].concat())]
}

fn two<'a>(library: &'a Library, (fidelity, values): &(i32, Vec<(&str, f64)>)) -> Host<'a> {
    let scene = [("drive.source", f64::from(AIR)), ("fidelity", f64::from(*fidelity))];
    Host::running(library, &[&scene[..], values].concat())
}

/// With event mode and early return: at blows, and where the piston passes 20 mm above the bit.
fn three<'a>(library: &'a Library, (fidelity, values): &(i32, Vec<(&str, f64)>)) -> Three<'a> {
    let host = Three::new(library, true, true);
    host.set("Int64", vr("drive.source"), i64::from(AIR));
    host.set("Int64", vr("fidelity"), i64::from(*fidelity));
    values.iter().for_each(|(name, value)| host.set("Float64", vr(name), *value));
    host.set("Int32", extra("event.positions"), 1_i32);
    host.set("Float64", Extra::Position(0).reference(), -0.02);
    host.start(true);
    host
}

/// A chamber at rest that a supply of constant pressure fills through a choked opening. The flow is
/// `C_d A sqrt(kappa / (R T)) (2 / (kappa + 1))^3 p_s`, so the mass taken is proportional to the pressure during the
/// step as it is to time, and the chamber's pressure is `kappa R T` over its volume times as much.
#[test]
fn what_is_taken_follows_the_supply_as_in_closed_form() {
    let library = Library::load();
    let start = 1e5;
    let host = Host::running(
        &library,
        &[
            ("drive.source", AIR.into()),
            ("fidelity", 1.0),
            ("drive.area_drive", 0.0),
            ("drive.area_return", 0.0),
            ("gravity", 0.0),
            ("air.drive.supply", 0.0),
            ("air.drive.exhaust", 1.0),
            ("air.return.supply", 1.0),
            ("air.return.exhaust", -1.0),
            ("supply_pressure", start),
        ],
    );
    host.step(0.0, 1e-3);
    assert_eq!(host.get("air_mass"), 0.0, "nothing flows between equal pressures");
    let [discharge, area, temperature, volume] =
        ["air.discharge", "air.supply_area", "air.temperature", "air.drive.dead_volume"]
            .map(|name| host.get(name));
    let flow = discharge * area * (1.4 / (287.05 * temperature)).sqrt() * (2.0f64 / 2.4).powi(3);
    let (supply, size) = (2e6, 4e-4);
    host.set("supply_pressure", supply);
    host.step(1e-3, size);
    let compressed = 1.4 * 287.05 * temperature / volume;
    assert!(start + compressed * flow * supply * size < 0.5 * supply, "still choked");
    // A quantity proportional to time is a finite series; a difference of a linear function keeps at least seven
    // digits.
    let close = |found: f64, expected: f64, error: f64| {
        assert!((found / expected - 1.0).abs() < error, "{found} for {expected}");
    };
    close(host.get("air_mass"), flow * supply * size, 1e-7);
    close(host.rate("air_mass"), flow * supply, 1e-7);
    close(host.get("drive_chamber_pressure"), start + compressed * flow * supply * size, 1e-7);
    close(host.rate("drive_chamber_pressure"), compressed * flow * supply, 1e-7);
    let of = ["air_mass", "drive_chamber_pressure"].map(|name| OVER_STEP + vr(name));
    let mut slopes = [f64::NAN; 2];
    let by = [vr("supply_pressure")];
    assert_eq!(library.directional_by(host.handle, &of, &by, &[1.0], &mut slopes), OK);
    close(slopes[0], flow * size, 1e-6);
    close(slopes[1], compressed * flow * size, 1e-6);
    host.take_log();
    // A parameter in place of an input is refused by name.
    let parameter = [vr("air.supply_area")];
    let status = library.directional_by(host.handle, &of, &parameter, &[1.0], &mut slopes);
    assert_eq!(status, ERROR);
    let line = host.only_error();
    assert!(line.starts_with("air.supply_area cannot be set"), "{line}");
}

/// If the exhaust's pressure rises, so does that of vented chambers, and nothing drives the piston.
#[test]
fn vented_chambers_follow_the_exhaust() {
    let library = Library::load();
    let (fidelity, mut values) = scenes()[1].clone();
    values.push(("feed_force", -1e3));
    let host = two(&library, &(fidelity, values));
    let (slope, size, mut time) = (3e5, 1e-3, 0.0);
    let lifted = |host: &Host| host.get("drive_chamber_pressure") == host.get("exhaust_pressure");
    while !lifted(&host) {
        host.step(time, size);
        time += size;
        assert!(time < 1.0, "never vented");
    }
    let taken = host.get("air_mass");
    host.set("exhaust_pressure", 1.1e5);
    host.set_derivative("exhaust_pressure", 1, slope);
    host.step(time, size);
    let expected = host.get("exhaust_pressure");
    assert!((expected - 1.1e5 - slope * size).abs() < 1e-9 * expected);
    for name in ["drive_chamber_pressure", "return_chamber_pressure"] {
        assert_eq!((host.get(name), host.rate(name)), (expected, slope), "{name}");
    }
    assert_eq!((host.get("applied_drive_force"), host.get("air_mass")), (0.0, taken));
}

/// A rate that would carry a pressure to zero within a step ends the step there, with the input's name. The outputs
/// are then those of that instant: two nanoseconds earlier, where a step can still end, all are within 1e-5 of them.
#[test]
fn a_pressure_that_falls_to_zero_ends_the_step_by_name_and_what_was_before_can_be_read() {
    let library = Library::load();
    let (from, lasts) = (0.01, 0.004);
    for scene in scenes() {
        let pairs: [[Box<dyn Driver>; 2]; 2] = [
            [Box::new(two(&library, &scene)), Box::new(two(&library, &scene))],
            [Box::new(three(&library, &scene)), Box::new(three(&library, &scene))],
        ];
        for ([one, other], name) in pairs.iter().zip(["supply_pressure", "exhaust_pressure"]) {
            for host in [one, other] {
                host.advance(0.0, from);
                host.ramp(name, (2e5, -2e5 / lasts));
            }
            let (time, why) = one.fails(from, from + 2.0 * lasts);
            assert!(why.starts_with(&format!("{name} falls to zero at t = 0.01")), "{why}");
            // The instant is found to a nanosecond.
            assert!((time - from - lasts).abs() < 3e-9, "{time}");
            other.advance(from, time - 2e-9);
            for shown in
                ["piston_position", "piston_velocity", "drive_chamber_pressure", "air_mass"]
            {
                let (value, expected) = (one.value(shown), other.value(shown));
                let off = (value - expected).abs();
                assert!(off <= 1e-5 * expected.abs(), "{shown}: {value} for {expected}");
            }
        }
    }
}
