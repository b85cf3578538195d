//! Drives outside, in the masters that exist: gas, and water in a hose with a valve; what their values stand for; which
//! unit is stepped first; and steps of any sizes. Prints what the exchange costs; `tests/masters.rs` asserts it.
//!
//! ```text
//! cargo run --release -p dth-hammer --example masters
//! ```

#![allow(missing_docs, reason = "a program, which a test includes")]

use hammer::{Fidelity, Input, InputValues, Machine, Parameters, Source};

/// A model of a drive that knows the piston along a straight line from where it last was.
pub trait Drive: Copy {
    const AREAS: [f64; 2];
    const END: f64;
    /// Longest step of its own integration, s.
    const FINE: f64;
    fn start(place: f64) -> Self;
    fn pressures(&self) -> [f64; 2];
    /// Moves the piston at once to a place: no time for any flow but the piston's.
    fn leap(&mut self, to: f64);
    /// Takes the piston to be at a place, without a flow.
    fn place(&mut self, at: f64) -> f64;
    /// Goes on for a time at the piston's speed. Its place moves by `way`, which is 0 where the place is held.
    fn go(&mut self, time: f64, speed: f64, way: f64);
}

/// What the partner's values stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stands {
    Position,
    Flow,
    Ahead,
}
pub use Stands::{Ahead, Flow, Position};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Master {
    HammerFirst,
    PartnerFirst,
    Together,
}
pub use Master::{HammerFirst, PartnerFirst, Together};

/// Sizes of steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steps {
    Even,
    /// Shorter and longer by this part, in turn.
    Uneven(f64),
    /// Cut in two anywhere, as by events.
    Cut,
}
pub use Steps::{Cut, Even, Uneven};

/// The delay that is right: what the values stand for, and one step more where all step at once.
pub fn right(stands: Stands, master: Master) -> f64 {
    let base = match stands {
        Position => 0.5,
        Flow => 0.0,
        Ahead => -0.5,
    };
    base + f64::from(u8::from(master == Together))
}

/// What a run gives: mean speed of the blows after the first, m/s; the energy that the exchange made, and that it tells
/// of, and the drive's work, J.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    pub speed: f64,
    pub made: f64,
    pub told: f64,
    pub work: f64,
    pub warnings: u32,
}

fn scene<D: Drive>(delay: f64) -> Parameters {
    let mut p = Parameters { fidelity: Fidelity::Rigid, ..Parameters::default() };
    (p.drive.source, p.drive.delay) = (Source::Pressure, delay);
    [p.drive.area_drive, p.drive.area_return] = D::AREAS;
    p
}

pub fn run<D: Drive>(
    stands: Stands,
    master: Master,
    delay: f64,
    steps: Steps,
    size: f64,
) -> Option<Found> {
    let mut machine = Machine::new(&scene::<D>(delay), &InputValues::default(), 0.0).unwrap();
    let now = |machine: &Machine| {
        let piston = machine.kinematics().relative;
        (piston.displacement, piston.velocity)
    };
    let (mut known, mut drive) = (now(&machine), D::start(now(&machine).0));
    let mut last = known.0;
    let force = |[drive, back]: [f64; 2]| D::AREAS[0] * drive - D::AREAS[1] * back;
    let (mut given, mut acted) = (0.0, 0.0);
    let (mut speeds, mut blows) = (Vec::new(), 0);
    let (mut number, mut rest, mut seed) = (0, 0.0, 7_u64);
    while machine.time() < D::END - 1e-12 {
        let time = machine.time();
        number += 1;
        let step = match steps {
            Even => size,
            Uneven(part) => size * (1.0 + if number % 2 == 0 { part } else { -part }),
            Cut if rest > 0.0 => std::mem::take(&mut rest),
            Cut => {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let part = 10_f64.powf(-6.0 * ((seed >> 33) as f64) * 2f64.powi(-31));
                rest = size * (1.0 - part);
                size * part
            }
        };
        let mut follow = |drive: &mut D, (place, speed): (f64, f64)| {
            let part = |drive: &D, from: f64, to: f64, before: f64| {
                f64::midpoint(before, force(drive.pressures())) * (to - from)
            };
            let before = force(drive.pressures());
            let speed = match stands {
                Position => (place - last) / step,
                Flow | Ahead => speed,
            };
            if stands == Ahead {
                drive.leap(place);
                given += part(drive, last, place, before);
            }
            let mut from = if stands == Position { last } else { drive.place(place) };
            let pieces = (step / D::FINE).ceil();
            for _ in 0..pieces as usize {
                let before = force(drive.pressures());
                let to = from + speed * step / pieces;
                let way = if stands == Flow { 0.0 } else { to - from };
                drive.go(step / pieces, speed, way);
                given += part(drive, from, to, before);
                from = to;
            }
            last = from;
        };
        if master == PartnerFirst {
            follow(&mut drive, known);
        }
        let values = drive.pressures();
        machine.set_input(Input::DrivePressure, &[values[0]]).ok()?;
        machine.set_input(Input::ReturnPressure, &[values[1]]).ok()?;
        machine.advance(time + step).ok()?;
        let applied = machine.kinematics().applied_drive_force;
        let after = now(&machine);
        acted += applied * (after.0 - known.0);
        match master {
            HammerFirst => follow(&mut drive, after),
            Together => follow(&mut drive, known),
            PartnerFirst => {}
        }
        known = after;
        if machine.counters().blows > blows {
            blows = machine.counters().blows;
            speeds.extend(machine.blow().map(|blow| blow.speed));
        }
        if known.0.abs() > 10.0 {
            return None;
        }
    }
    let later = speeds.get(1..).unwrap_or_default();
    Some(Found {
        speed: later.iter().sum::<f64>() / later.len() as f64,
        made: acted - given,
        told: machine.exchanged_energy(),
        work: acted,
        warnings: machine.exchange_excesses(),
    })
}

/// Air in two chambers, with ports that the piston opens.
#[derive(Clone, Copy)]
pub struct Gas {
    pressure: [f64; 2],
    at: f64,
}

impl Gas {
    const EXPONENT: f64 = 1.4;
    const OUTSIDE: [f64; 2] = [2.4e6, 101_325.0];

    fn volumes(at: f64) -> [f64; 2] {
        [1.2e-4 + Self::AREAS[0] * (0.1 + at), 1.2e-4 - Self::AREAS[1] * at]
    }

    /// Mass flow through an opening, kg/s.
    fn flow(area: f64, from: f64, to: f64) -> f64 {
        if to > from {
            return -Self::flow(area, to, from);
        }
        let (k, ratio) = (Self::EXPONENT, (to / from).max(0.5283));
        let part = ratio.powf(2.0 / k) - ratio.powf((k + 1.0) / k);
        0.8 * area * from / (287.05 * 300.0_f64).sqrt() * (2.0 * k / (k - 1.0) * part).sqrt()
    }

    fn rates(pressure: [f64; 2], at: f64, speed: f64) -> [f64; 2] {
        let open = |by: f64| 6e-5 * (by / 0.01).clamp(0.0, 1.0);
        let [drive, back] = pressure;
        let [supply, exhaust] = Self::OUTSIDE;
        let into = [
            Self::flow(open(-0.04 - at), supply, drive)
                - Self::flow(3.0 * open(at + 0.02), drive, exhaust),
            Self::flow(open(at + 0.025), supply, back)
                - Self::flow(3.0 * open(-0.045 - at), back, exhaust),
        ];
        let grows = [Self::AREAS[0] * speed, -Self::AREAS[1] * speed];
        let volumes = Self::volumes(at);
        [0, 1].map(|k| {
            Self::EXPONENT / volumes[k] * (287.05 * 300.0 * into[k] - pressure[k] * grows[k])
        })
    }
}

impl Drive for Gas {
    const AREAS: [f64; 2] = [6e-3, 5e-3];
    const END: f64 = 0.15;
    const FINE: f64 = 1e-5;

    fn start(at: f64) -> Self {
        Self { pressure: [3e5, 1e6], at }
    }
    fn pressures(&self) -> [f64; 2] {
        self.pressure.map(|pressure| pressure - Self::OUTSIDE[1])
    }
    fn leap(&mut self, to: f64) {
        let (before, after) = (Self::volumes(self.at), Self::volumes(to));
        for k in 0..2 {
            self.pressure[k] *= (before[k] / after[k]).powf(Self::EXPONENT);
        }
        self.at = to;
    }
    fn place(&mut self, at: f64) -> f64 {
        self.at = at;
        at
    }
    fn go(&mut self, time: f64, speed: f64, way: f64) {
        let rates = |p, part: f64| Self::rates(p, self.at + part * way, speed);
        self.pressure = runge_kutta(self.pressure, time, rates);
        self.at += way;
    }
}

/// Water above the piston behind a valve that its place switches, on a hose, of which the return chamber is a part.
#[derive(Clone, Copy)]
pub struct Hose {
    /// Drive pressure, spool, pressure at the hose's end, flow in it.
    state: [f64; 4],
    command: f64,
    at: f64,
}

impl Hose {
    const PUMP: f64 = 1.4e7;
    const TANK: f64 = 2e5;
    const BULK: f64 = 2.1e9;
    const COMPLIANCE: f64 = 5e-12;
    const INERTANCE: f64 = 8e6;

    fn flow(opening: f64, difference: f64) -> f64 {
        let area = 0.65 * 1.2e-4 * (2.0_f64 / 1000.0).sqrt() * opening.max(0.0);
        area * difference / difference.hypot(5e5).sqrt()
    }

    fn volume(at: f64) -> f64 {
        1e-4 + Self::AREAS[0] * at
    }

    fn rates([drive, spool, end, flow]: [f64; 4], command: f64, at: f64, speed: f64) -> [f64; 4] {
        let (into, out) = (Self::flow(spool, end - drive), Self::flow(-spool, drive - Self::TANK));
        [
            Self::BULK / Self::volume(at) * (into - out - Self::AREAS[0] * speed),
            (command - spool) / 5e-4,
            (flow - into + Self::AREAS[1] * speed) / Self::COMPLIANCE,
            (Self::PUMP - end - 2e8 * flow) / Self::INERTANCE,
        ]
    }
}

impl Drive for Hose {
    const AREAS: [f64; 2] = [3.6e-4, 1.8e-4];
    const END: f64 = 0.15;
    const FINE: f64 = 5e-6;

    fn start(at: f64) -> Self {
        Self { state: [Self::TANK, 1.0, Self::PUMP, 0.0], command: 1.0, at }
    }
    fn pressures(&self) -> [f64; 2] {
        [self.state[0], self.state[2]]
    }
    fn leap(&mut self, to: f64) {
        self.state[0] -= Self::BULK * (Self::volume(to) / Self::volume(self.at)).ln();
        self.state[2] += Self::AREAS[1] * (to - self.at) / Self::COMPLIANCE;
        self.at = to;
    }
    fn place(&mut self, at: f64) -> f64 {
        self.at = at;
        at
    }
    fn go(&mut self, time: f64, speed: f64, way: f64) {
        let end = self.at + way;
        if self.command > 0.0 && end > -8e-3 {
            self.command = -1.0;
        } else if self.command < 0.0 && end < -30e-3 {
            self.command = 1.0;
        }
        let command = self.command;
        let rates = |y, part: f64| Self::rates(y, command, self.at + part * way, speed);
        self.state = runge_kutta(self.state, time, rates);
        self.at = end;
    }
}

/// One step of the classical method, with rates that depend on the part of the step.
fn runge_kutta<const N: usize>(
    y: [f64; N],
    step: f64,
    rates: impl Fn([f64; N], f64) -> [f64; N],
) -> [f64; N] {
    let plus = |by: [f64; N], part: f64| std::array::from_fn(|k| y[k] + part * step * by[k]);
    let first = rates(y, 0.0);
    let second = rates(plus(first, 0.5), 0.5);
    let third = rates(plus(second, 0.5), 0.5);
    let last = rates(plus(third, 1.0), 1.0);
    std::array::from_fn(|k| y[k] + step / 6.0 * (first[k] + 2.0 * (second[k] + third[k]) + last[k]))
}

pub const ALL: [(Stands, Master); 9] = [
    (Position, HammerFirst),
    (Position, PartnerFirst),
    (Position, Together),
    (Flow, HammerFirst),
    (Flow, PartnerFirst),
    (Flow, Together),
    (Ahead, HammerFirst),
    (Ahead, PartnerFirst),
    (Ahead, Together),
];
pub const STEPS: [Steps; 4] = [Even, Uneven(0.2), Uneven(0.5), Cut];

/// The limit of all: the piston followed in steps of 2 us.
pub fn truth<D: Drive>() -> Found {
    run::<D>(Position, HammerFirst, 0.5, Even, 2e-6).expect("the limit")
}

/// Error of the blows' speed.
pub fn error<D: Drive>(
    case: (Stands, Master),
    delay: f64,
    steps: Steps,
    size: f64,
    truth: Found,
) -> f64 {
    run::<D>(case.0, case.1, delay, steps, size)
        .map_or(f64::INFINITY, |f| f.speed / truth.speed - 1.0)
}

fn print<D: Drive>(name: &str) {
    let truth = truth::<D>();
    println!("of each steps even, +-20 %, +-50 %, cut: % of speed, made of the work, told of made");
    for (size, case) in [1e-3, 3e-4, 1e-4, 1e-5].into_iter().flat_map(|h| ALL.map(|case| (h, case)))
    {
        let mut delays = vec![0.0, right(case.0, case.1)];
        delays.dedup();
        for delay in delays {
            let cells = STEPS.map(|steps| {
                run::<D>(case.0, case.1, delay, steps, size).map_or("fails".into(), |f| {
                    let [speed, made] =
                        [f.speed / truth.speed - 1.0, f.made / f.work].map(|x| 100.0 * x);
                    format!("{speed:+.2} {made:+.2} {:+.2}", f.told / f.made)
                })
            });
            println!("{name} {size} {case:?} {delay}: {}", cells.join(" | "));
        }
    }
}

fn main() {
    print::<Gas>("gas");
    print::<Hose>("water");
}
