//! The air in two chambers that drives the piston, which opens and closes their ports.
//!
//! `x` is the piston's position relative to the bit (with a casing, to the casing): 0 at impact, negative above. `y`
//! is its position relative to the bit in either case; the return chamber ends at the bit. With the pressures `p_d`,
//! `p_r` of the chambers and `p_e` of the exhaust
//!
//! ```text
//! F_A = (p_d - p_e) A_d - (p_r - p_e) A_r - c x'
//! V_d = V_d0 + A_d (s + x)               V_r = V_r0 - A_r y
//! ```
//!
//! The return chamber presses on the bit with `(p_r - p_e) A_r`, and the casing carries the rest of the reaction. The
//! work of the gas is therefore the work on the hammer plus the drag's loss. Without a casing the cylinder follows
//! the bit and is held from outside; the holder's work is part of `energy_feed`.
//!
//! A chamber is an adiabatic ideal gas of mass `m` and temperature `T = p V / (m R)`. Its state is `m` and
//! `S = p V^kappa`, whose rates contain neither the piston's velocity nor that of the volume:
//!
//! ```text
//! m' = sum flow                          S' = kappa R V^(kappa - 1) sum flow T_upstream
//! ```
//!
//! While no air flows both are constant. The flow from the pressure `p_h` to `p_l` through an opening of area `a` is
//! that of an ideal gas through a nozzle,
//!
//! ```text
//! a p_h sqrt(2 kappa / ((kappa - 1) R T_h)) sqrt(r^(2/kappa) - r^((kappa + 1)/kappa)),
//! r = max(p_l / p_h, CHOKED).
//! ```
//!
//! Above `p_l / p_h = `[`STRAIGHT`] its slope would become infinite at 1, so there it is proportional to
//! `1 - p_l / p_h`. Each opening thus has six [`Regime`]s, in each of which the flow is a smooth function. A port is
//! open on one side of its edge, in proportion to the travel beyond it up to the port's height ([`Opening`]).
//!
//! In the cylinder's end, where the drive chamber has half its dead volume, its ports are shut, and its air throws the
//! piston back. While the drive is vented, only this air acts on the piston; the end then begins at `x = -s`, with air
//! at the exhaust's pressure. A drive that acts again begins with chambers at that pressure, which fill through their
//! ports.

use crate::laws::event::{Direction, Event, opening};
use crate::laws::mode::{Chamber, Port};
use crate::numerics::math;
use crate::quantities::air::{ATMOSPHERE, AirLaw};
use crate::quantities::parameters::Parameters;
use serde::{Deserialize, Serialize};

/// Gas constant of air, J/(kg K).
pub const GAS: f64 = 287.05;
/// Ratio of specific heats, 7/5, of a diatomic gas.
pub const KAPPA: f64 = 1.4;
/// Density of free air, at 0 degrees Celsius and 1.01325e5 Pa, kg/m3.
pub const FREE_DENSITY: f64 = ATMOSPHERE / (GAS * 273.15);
/// `V^(kappa - 1)`.
pub(crate) fn heated(volume: f64) -> f64 {
    math::two_fifths(volume)
}

/// The ratio of pressures `(2 / (kappa + 1))^(kappa / (kappa - 1))` below which a flow is choked.
const CHOKED: f64 = 0.528_281_787_717_174;
/// `sqrt(CHOKED^(2/kappa) - CHOKED^((kappa + 1)/kappa))`.
pub(crate) const CHOKED_FLOW: f64 = 0.258_804_164_062_475_66;
/// `sqrt(2 kappa / (kappa - 1))`, which is `sqrt(7)`.
pub(crate) const NOZZLE: f64 = 2.645_751_311_064_590_6;
/// The ratio of pressures above which a flow is proportional to their difference.
pub(crate) const STRAIGHT: f64 = 0.995;
/// `sqrt(STRAIGHT^(2/kappa) - STRAIGHT^((kappa + 1)/kappa)) / (1 - STRAIGHT)`.
pub(crate) const STRAIGHT_SLOPE: f64 = 7.539_014_179_480_226;

/// State of a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Opening {
    /// Closed.
    #[default]
    Closed,
    /// Partly open, in proportion to the travel beyond its edge.
    Partial,
    /// Fully open.
    Full,
}

/// The formula of the flow through an opening.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Regime {
    /// True if the air flows from the second side to the first.
    pub reversed: bool,
    /// The formula.
    pub flow: Flow,
}

/// A formula of the flow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Flow {
    /// Proportional to the difference of the pressures.
    #[default]
    Straight,
    /// Slower than sound.
    Subsonic,
    /// At the speed of sound in the opening.
    Choked,
}

/// Air on one side of an opening: pressure, Pa, and temperature, K.
pub type Side = [f64; 2];

impl Regime {
    /// The regime for pressures on both sides.
    pub fn of([one, other]: [f64; 2]) -> Self {
        let reversed = other > one;
        let (high, low) = if reversed { (other, one) } else { (one, other) };
        let flow = match low {
            _ if low > STRAIGHT * high => Flow::Straight,
            _ if low > CHOKED * high => Flow::Subsonic,
            _ => Flow::Choked,
        };
        Self { reversed, flow }
    }

    /// How far the pressures are beyond the bounds of the regime, as a share of the higher pressure (negative inside).
    /// The first number is for the bound towards larger flow.
    pub fn beyond(self, [one, other]: [f64; 2]) -> [f64; 2] {
        let ratio = if self.reversed { one / other } else { other / one };
        let [low, high] = self.bounds();
        [low - ratio, ratio - high]
    }

    /// The bounds of the lower over the higher pressure; the first is that towards larger flow.
    pub(crate) fn bounds(self) -> [f64; 2] {
        match self.flow {
            Flow::Straight => [STRAIGHT, 1.0],
            Flow::Subsonic => [CHOKED, STRAIGHT],
            Flow::Choked => [0.0, CHOKED],
        }
    }

    /// The regime beyond the first (0) or the second bound (1) of [`Self::beyond`].
    pub fn next(self, bound: usize) -> Self {
        let Self { reversed, flow } = self;
        match (flow, bound) {
            (Flow::Straight, 0) | (Flow::Choked, _) => Self { flow: Flow::Subsonic, ..self },
            (Flow::Straight, _) => Self { reversed: !reversed, ..self },
            (Flow::Subsonic, 0) => Self { flow: Flow::Choked, ..self },
            (Flow::Subsonic, _) => Self { flow: Flow::Straight, ..self },
        }
    }

    /// The larger of the flow's derivatives with respect to the logarithms of the two pressures, through 1 m2, kg/s.
    pub(crate) fn steepness(self, one: Side, other: Side) -> f64 {
        let ([high, hot], [low, _]) = if self.reversed { (other, one) } else { (one, other) };
        let factor = NOZZLE / (GAS * hot).sqrt();
        let most = match self.flow {
            Flow::Straight => STRAIGHT_SLOPE * high.max(low),
            Flow::Choked => CHOKED_FLOW * high,
            Flow::Subsonic => {
                // With `b = r^(1/kappa)` the flow is proportional to `p_h g`, where `g^2 = b (b - r)`.
                let ratio = low / high;
                let b = math::five_sevenths(ratio);
                let g = (b * (b - ratio)).max(0.0).sqrt();
                let by_low = (b * (b / KAPPA - 0.5 * ratio * (1.0 / KAPPA + 1.0)) / g).abs();
                high * (g + by_low)
            }
        };
        factor * most
    }

    /// Flow from the first side to the second through 1 m2, kg/s, and its upstream temperature, K.
    pub fn flow(self, one: Side, other: Side) -> [f64; 2] {
        let ([high, hot], [low, _], sign) =
            if self.reversed { (other, one, -1.0) } else { (one, other, 1.0) };
        let factor = sign * NOZZLE / (GAS * hot).sqrt();
        let shape = match self.flow {
            Flow::Straight => STRAIGHT_SLOPE * (high - low),
            Flow::Choked => CHOKED_FLOW * high,
            Flow::Subsonic => {
                let ratio = low / high;
                let root = math::five_sevenths(ratio); // The power 1 / kappa.
                // It can be negative only during an iteration, outside the regime.
                high * (root * (root - ratio)).max(0.0).sqrt()
            }
        };
        [factor * shape, hot]
    }
}

/// States of the four ports: supply and exhaust of the drive chamber, then of the return chamber.
pub type Openings = [[Opening; 2]; 2];

/// Direction in which `vr` opens a port, and its positions where the port begins to open and is fully open.
fn edges(law: &AirLaw, chamber: Chamber, port: Port) -> (Direction, f64, f64) {
    let chamber_law = match chamber {
        Chamber::Drive => &law.drive,
        Chamber::Return => &law.returning,
    };
    let edge = match port {
        Port::Supply => chamber_law.supply,
        Port::Exhaust => chamber_law.exhaust,
    };
    let way = opening(chamber, port);
    (way, edge, edge + way.sign() * law.port_height)
}

impl Parameters {
    /// Position at which the end of an air hammer's cylinder begins, m.
    pub(crate) fn cylinder_end(&self, vented: bool) -> f64 {
        let room =
            if vented { 0.0 } else { 0.5 * self.air.drive.dead_volume / self.drive.area_drive };
        -self.air.cylinder - room
    }
}

impl AirLaw {
    /// States of the ports with the piston at `vr`; `shut` is true in the cylinder's end.
    pub(crate) fn openings(&self, vr: f64, shut: bool) -> Openings {
        Chamber::ALL.map(|chamber| {
            Port::ALL.map(|port| {
                let (way, edge, full) = edges(self, chamber, port);
                match way.sign() * vr {
                    _ if shut && chamber == Chamber::Drive => Opening::Closed,
                    x if x < way.sign() * edge => Opening::Closed,
                    x if x < way.sign() * full => Opening::Partial,
                    _ => Opening::Full,
                }
            })
        })
    }

    /// Areas of the openings of ports and leak with the piston at `vr`, m2.
    pub(crate) fn areas(&self, openings: &Openings, vr: f64) -> [f64; 5] {
        let mut areas = [self.leakage_area; 5];
        for chamber in Chamber::ALL {
            for port in Port::ALL {
                let (way, edge, _) = edges(self, chamber, port);
                let share = match openings[chamber as usize][port as usize] {
                    Opening::Closed => 0.0,
                    Opening::Partial => way.sign() * (vr - edge) / self.port_height,
                    Opening::Full => 1.0,
                };
                let whole = [self.supply_area, self.exhaust_area][port as usize];
                areas[2 * chamber as usize + port as usize] = self.discharge * whole * share;
            }
        }
        areas
    }

    /// Tells `watch` the guards of the cylinder's end, inside which the piston is if `shut`, and, unless the drive is
    /// vented, of the limits of the ports' present openings. Only the nearest positions are guarded. Those further away
    /// are guarded after these have been passed.
    pub(crate) fn guards(
        &self,
        openings: &Openings,
        now: [bool; 2],
        end: f64,
        mut watch: impl FnMut(Direction, f64, Event),
    ) {
        let (mut below, mut above) = (f64::NEG_INFINITY, f64::INFINITY);
        self.limits(openings, now, end, |direction, level, _| match direction {
            Direction::Rising if level < above => above = level,
            Direction::Falling if level > below => below = level,
            _ => {}
        });
        self.limits(openings, now, end, |direction, level, event| {
            let nearest = if direction == Direction::Rising { above } else { below };
            if level == nearest {
                watch(direction, level, event);
            }
        });
    }

    /// Tells `limit` every position of [`Self::guards`].
    #[inline(always)]
    fn limits(
        &self,
        openings: &Openings,
        [shut, vented]: [bool; 2],
        end: f64,
        mut limit: impl FnMut(Direction, f64, Event),
    ) {
        if end.is_finite() {
            let direction = if shut { Direction::Rising } else { Direction::Falling };
            limit(direction, end, Event::End(!shut));
        }
        for chamber in Chamber::ALL {
            if vented || shut && chamber == Chamber::Drive {
                continue;
            }
            for port in Port::ALL {
                let (way, edge, full) = edges(self, chamber, port);
                let passes = |opens| Event::Port { chamber, port, opens };
                let fills = |full| Event::Opening { chamber, port, full };
                match openings[chamber as usize][port as usize] {
                    Opening::Closed => limit(way, edge, passes(true)),
                    Opening::Partial => {
                        limit(way.reverse(), edge, passes(false));
                        limit(way, full, fills(true));
                    }
                    Opening::Full => limit(way.reverse(), full, fills(false)),
                }
            }
        }
    }

    /// Pressures of both chambers at the start: that of the supply if its port is open, otherwise that of the exhaust.
    pub(crate) fn start(&self, openings: &Openings, supply: f64, exhaust: f64) -> [f64; 2] {
        openings.map(|[of_supply, _]| if of_supply == Opening::Closed { exhaust } else { supply })
    }

    /// Largest distance of a port or of the cylinder's end from the impact position, m.
    pub(crate) fn furthest(&self) -> f64 {
        let Self { drive, returning, cylinder, .. } = self;
        let edges = [drive.supply, drive.exhaust, returning.supply, returning.exhaust];
        edges.into_iter().fold(*cylinder, |most, edge| most.max(edge.abs()))
    }
}
