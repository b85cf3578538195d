//! Two gas chambers that drive the piston; it opens and closes their ports as it passes them.
//! Together the pieces form the indicator diagram of a valveless hammer.
//!
//! ```text
//! F_A = p_drive A_drive - p_return A_return
//! ```
//!
//! A chamber has a supply and an exhaust, each open on one side of a position of
//! `vr = up_mean - ub_mean - g0`, the piston's mean position relative to the bit's:
//!
//! | chamber | supply is open | exhaust is open |
//! |---|---|---|
//! | drive, above the piston | `vr` above its port, `vr < x` | below it, `vr > x` |
//! | return, below the piston | below it, `vr > x` | above it, `vr < x` |
//!
//! When `vr` passes a port at the time `t0`, the chamber's pressure changes linearly from its value
//! there, `p0`, to the level `p1` that belongs to this port and direction, within the time `T1`:
//!
//! ```text
//! p(t) = p0 + (p1 - p0) min((t - t0) / T1, 1)
//! ```
//!
//! and stays there until the next port is passed. So the four levels of a chamber are the end
//! pressures of supply, expansion, exhaust and compression. A time of 0 is a jump. The pressure is
//! always between levels. Between events the load is a polynomial of degree 1 at most, so the
//! motion is exact. A chamber begins at the level of its open supply, otherwise of its open
//! exhaust. Where supply and exhaust are at one place (within 1e-12 m), the port that opens alone
//! changes the pressure, whichever turns first by rounding.

use crate::laws::event::{Direction, Displacement, Event, Guard, Quantity};
use crate::laws::mode::{Chamber, Port};
use crate::numerics::poly::Poly;
use crate::quantities::parameters::{ChamberLaw, ChamberLaws, PortLaw};
use serde::{Deserialize, Serialize};

/// Open ports, and the pressure after the epoch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Gas {
    /// Whether supply and exhaust are open.
    pub open: [bool; 2],
    /// The level that the pressure approaches or has, Pa.
    pub level: f64,
    /// Its rate until then, Pa/s.
    pub slope: f64,
    /// When it reaches the level, after the epoch, s; none if it is there.
    pub until: Option<f64>,
}

impl ChamberLaws {
    /// Of one of them.
    pub(crate) fn of(&self, chamber: Chamber) -> &ChamberLaw {
        match chamber {
            Chamber::Drive => &self.drive,
            Chamber::Return => &self.returning,
        }
    }

    /// Both at the start, or driving again after they were vented, the piston at `vr`.
    pub(crate) fn start(&self, vr: f64) -> [Gas; 2] {
        Chamber::ALL.map(|chamber| {
            let law = self.of(chamber);
            let open = Port::ALL.map(|port| match opening(chamber, port) {
                Direction::Rising => vr >= law.of(port).position,
                Direction::Falling => vr <= law.of(port).position,
            });
            let port = if open[Port::Supply as usize] { Port::Supply } else { Port::Exhaust };
            Gas { open, level: law.of(port).open_pressure, ..Gas::default() }
        })
    }

    /// Both while the drive is vented: at the exhaust's pressure, no port is watched.
    pub(crate) fn vented(&self) -> [Gas; 2] {
        Chamber::ALL.map(|chamber| {
            let level = self.of(chamber).exhaust.open_pressure;
            Gas { open: [false, true], level, ..Gas::default() }
        })
    }

    /// Both at the lowest of their levels, and at the highest: pressures are always between them.
    pub(crate) fn extremes(&self) -> [[Gas; 2]; 2] {
        let levels = |chamber| {
            let ports = Port::ALL.map(|port| self.of(chamber).of(port));
            ports.into_iter().flat_map(|port| [port.open_pressure, port.shut_pressure])
        };
        let extreme = |pick: fn(f64, f64) -> f64| {
            let level = |chamber| levels(chamber).reduce(pick).unwrap_or_default();
            Chamber::ALL.map(|chamber| Gas { level: level(chamber), ..Gas::default() })
        };
        [extreme(f64::min), extreme(f64::max)]
    }

    /// Guards of the ports, each in the direction that switches it.
    pub(crate) fn guards(&self, gas: &[Gas; 2], vr: Displacement) -> impl Iterator<Item = Guard> {
        let ports = Chamber::ALL.into_iter().flat_map(|c| Port::ALL.map(|port| (c, port)));
        ports.map(move |(chamber, port)| {
            let opens = !gas[chamber as usize].open[port as usize];
            let way = opening(chamber, port);
            Guard {
                quantity: Quantity::Displacement(vr),
                direction: if opens { way } else { way.reverse() },
                level: self.of(chamber).of(port).position,
                event: Event::Port { chamber, port, opens },
            }
        })
    }

    /// Ports that are open at the same time, for warnings.
    pub(crate) fn overlaps(&self) -> impl Iterator<Item = (Chamber, [f64; 2])> {
        Chamber::ALL.into_iter().filter_map(|chamber| {
            let [supply, exhaust] = Port::ALL.map(|port| self.of(chamber).of(port).position);
            let overlap = match opening(chamber, Port::Supply) {
                Direction::Falling => supply > exhaust,
                Direction::Rising => supply < exhaust,
            };
            overlap.then_some((chamber, [supply, exhaust]))
        })
    }

    /// The distance of the furthest port, m.
    pub(crate) fn furthest(&self) -> f64 {
        let ports = Chamber::ALL.map(|c| Port::ALL.map(|port| self.of(c).of(port).position.abs()));
        ports.as_flattened().iter().fold(0.0, |a, &b| a.max(b))
    }
}

/// Ports of a chamber that are as close as this are at one place, m.
const TOGETHER: f64 = 1e-12;

impl ChamberLaw {
    /// True if one port shuts where the other opens.
    fn turns_at_once(&self) -> bool {
        (self.supply.position - self.exhaust.position).abs() <= TOGETHER
    }

    /// Of one of its ports.
    pub(crate) fn of(&self, port: Port) -> &PortLaw {
        match port {
            Port::Supply => &self.supply,
            Port::Exhaust => &self.exhaust,
        }
    }
}

/// The direction in which `vr` passes a port that opens.
pub(crate) fn opening(chamber: Chamber, port: Port) -> Direction {
    if (chamber == Chamber::Drive) == (port == Port::Exhaust) {
        Direction::Rising
    } else {
        Direction::Falling
    }
}

impl Gas {
    /// Its pressure after the epoch, Pa, until the next change.
    pub(crate) fn pressure(&self) -> Poly {
        // Written from its end, so that it ends exactly there.
        let line = |until: f64| Poly::taylor(&[self.level - self.slope * until, self.slope]);
        self.until.map_or_else(|| Poly::constant(self.level), line)
    }

    /// Moves the epoch by `t`.
    pub(crate) fn shift(&mut self, t: f64) {
        self.until = self.until.map(|until| (until - t).max(0.0));
    }

    /// Switches a port at the epoch.
    pub(crate) fn switch(&mut self, law: &ChamberLaw, port: Port) {
        let open = &mut self.open[port as usize];
        *open = !*open;
        if !*open && law.turns_at_once() {
            return;
        }
        let law = law.of(port);
        let (level, time) = if *open {
            (law.open_pressure, law.open_time)
        } else {
            (law.shut_pressure, law.shut_time)
        };
        let slope = (level - self.pressure().at(0.0)) / time;
        // It jumps if the time is zero or too short for a number.
        let gradual = slope.is_finite() && slope != 0.0;
        (self.level, self.slope) = (level, if gradual { slope } else { 0.0 });
        self.until = gradual.then_some(time);
    }

    /// Notes that the level is reached at the epoch.
    pub(crate) fn arrive(&mut self) {
        (self.slope, self.until) = (0.0, None);
    }

    /// True if every number is finite and no level should have been reached before `now`.
    pub(crate) fn is_sound(&self, now: f64) -> bool {
        let numbers = self.level.is_finite() && self.slope.is_finite();
        numbers && self.until.is_none_or(|until| until.is_finite() && until >= now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities::parameters::Parameters;

    fn law() -> ChamberLaw {
        let port = |position, open_pressure, shut_pressure| PortLaw {
            position,
            open_pressure,
            open_time: 2e-3,
            shut_pressure,
            shut_time: 4e-3,
        };
        ChamberLaw { supply: port(-0.03, 16e5, 8e5), exhaust: port(-0.02, 1e5, 3e5) }
    }

    /// All numbers are sums and quotients of a few: the bound is a rounding of the largest
    /// pressure.
    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 8.0 * f64::EPSILON * 16e5
    }

    #[test]
    fn the_pressure_goes_straight_to_the_level_of_the_port_that_turned() {
        let mut gas = Gas { open: [true, false], level: 16e5, ..Gas::default() };
        gas.switch(&law(), Port::Supply);
        assert_eq!(gas.open, [false, false]);
        // From 16 to 8 bar in 4 ms: after 1 ms at 14 bar.
        gas.shift(1e-3);
        assert!(close(gas.pressure().at(0.0), 14e5));
        // The exhaust opens at 14 bar and takes it to 1 bar in 2 ms.
        gas.switch(&law(), Port::Exhaust);
        assert!(close(gas.pressure().at(0.0), 14e5) && close(gas.pressure().at(1e-3), 7.5e5));
        gas.shift(2e-3);
        assert_eq!(gas.until, Some(0.0));
        gas.arrive();
        assert_eq!(gas.pressure(), Poly::constant(1e5));
    }

    #[test]
    fn no_time_is_a_jump() {
        let mut gas = Gas { open: [true, false], level: 16e5, ..Gas::default() };
        let mut law = law();
        law.supply.shut_time = 0.0;
        gas.switch(&law, Port::Supply);
        assert_eq!((gas.pressure(), gas.until), (Poly::constant(8e5), None));
        // There is nothing to wait for if the level is the present pressure.
        law.supply.open_pressure = 8e5;
        gas.switch(&law, Port::Supply);
        assert_eq!((gas.open, gas.until), ([true, false], None));
    }

    #[test]
    fn every_port_is_watched_on_the_way_that_turns_it() {
        let laws = Parameters::default().chambers;
        for (vr, way) in [(-1.0, Direction::Rising), (0.0, Direction::Falling)] {
            let gas = laws.start(vr);
            // On the bit the drive chamber exhausts and the return chamber is supplied.
            assert_eq!(gas[0].open, [vr < 0.0, vr == 0.0]);
            assert_eq!(gas[1].open, [vr == 0.0, vr < 0.0]);
            let guards: Vec<Guard> = laws.guards(&gas, Displacement::Relative).collect();
            assert_eq!(guards.len(), 4);
            assert!(guards.iter().all(|guard| guard.direction == way));
        }
        assert_eq!(laws.overlaps().count(), 0);
    }
}
