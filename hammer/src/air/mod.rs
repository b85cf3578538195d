//! The air of a hammer in motion, integrated over windows of time.
//!
//! The steel is linear, the air is not. Over a *window* the air is therefore expanded in power series of time, together
//! with the piston's mean motion ([`series`]). The steel then feels a force that is a polynomial of time, under which
//! its motion is exact. A window begins at an event, at a port's edge, where a flow changes its formula, or where the
//! previous window ended; never at a host's communication point. If an event happens inside a window, its polynomials
//! are valid up to the event.

mod chambers;
pub mod course;
mod fit;
mod lanes;
pub(crate) mod part;
pub(crate) mod series;
pub(crate) mod steel;
mod stream;
mod windows;

use crate::laws::air::{GAS, KAPPA, Openings, Regime, Side, heated};
use crate::numerics::kernel::{self, Row};
use crate::numerics::series::{LOW, ORDER, Powers, value};
use crate::quantities::air::AirLaw;
use crate::quantities::parameters::Parameters;
use serde::{Deserialize, Serialize};
use std::array::from_fn;

/// Mass and `p V^kappa` of the drive chamber, then of the return chamber.
pub type Content = [f64; 4];

/// Positions of the piston, m: in its cylinder (`x`), which sets the volume of the drive chamber, and relative to what
/// it strikes (`y`), which sets that of the return chamber.
pub type Places = [f64; 2];

/// Flow paths: supply and exhaust of the drive chamber, of the return chamber, then the leak between both.
/// `ENDS` are the two [`Air::sides`] that each path connects.
pub(crate) const PATHS: usize = 5;
pub(crate) const ENDS: [[usize; 2]; PATHS] = [[0, 2], [2, 1], [0, 3], [3, 1], [2, 3]];

/// Sums since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AirSums {
    /// Taken from the supply, kg.
    pub mass: f64,
    /// Enthalpy that came in, less what went out, J.
    pub enthalpy: f64,
    /// Work of both chambers on piston, bit and casing, J.
    pub work: f64,
}

/// Polynomials of the air after the epoch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Window {
    /// Length as solved, s. The polynomials are in the time divided by it.
    pub length: f64,
    /// Coefficients of the chambers' pressures, masses and volumes, of the mass from the supply and of the incoming
    /// enthalpy; one row per power of time.
    pub rows: [Row; ORDER + 1],
    /// Whether air can flow into or out of each chamber. A closed chamber's content stays exactly the same.
    pub flows: [bool; 2],
    /// The sum of `int P' x` over the forces `P` of the pressures.
    pub moment: Powers,
    /// The forces of the pressures, `p_d A_d` and `-p_r A_r`, N.
    pub push: [[f64; LOW]; 2],
    /// The piston's positions at the start.
    pub place: Places,
    /// How long the window is valid, s: to its end, or until a flow changes its formula.
    pub reach: f64,
    /// The path whose flow changes its formula at `reach`, and the next formula.
    pub then: Option<(usize, Regime)>,
}

/// The air at the epoch, and the window that follows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Air {
    /// Content of the chambers.
    pub content: Content,
    /// State of the ports.
    pub openings: Openings,
    /// The formula of each flow.
    pub regimes: [Regime; PATHS],
    /// Sums up to the epoch.
    pub sums: AirSums,
    /// Inner energy at the start, J.
    pub energy_start: f64,
    /// True while the piston is in the end of the cylinder.
    pub shut: bool,
    /// The piston's positions when the chambers were vented; `None` while they are not.
    pub vented: Option<Places>,
    /// The window that follows; `None` while the chambers are vented.
    pub window: Option<Box<Window>>,
}

impl Window {
    /// Values of the series at `tau`, a time over the window's length.
    fn at(&self, tau: f64) -> Row {
        kernel::horner(&self.rows, tau)
    }

    /// The content of the chambers at `tau`, if it is `start` at the epoch.
    fn content_at(&self, tau: f64, start: Content) -> Content {
        self.content_of(self.at(tau), start)
    }

    fn content_of(&self, [p, q, m, n, v, w, ..]: Row, start: Content) -> Content {
        let of = |i: usize, m: f64, p: f64, v: f64| {
            if self.flows[i] { [m, p * v * heated(v)] } else { [start[2 * i], start[2 * i + 1]] }
        };
        let ([m, s], [n, t]) = (of(0, m, p, v), of(1, n, q, w));
        [m, s, n, t]
    }
}

/// Volumes of the chambers at the piston's positions, m3.
pub(crate) fn volumes(parameters: &Parameters, [x, y]: Places) -> [f64; 2] {
    let (AirLaw { drive, returning, cylinder, .. }, areas) = (&parameters.air, &parameters.drive);
    [
        drive.dead_volume + areas.area_drive * (cylinder + x),
        returning.dead_volume - areas.area_return * y,
    ]
}

/// Pressures of the chambers, Pa.
pub(crate) fn pressures(content: &Content, volumes: [f64; 2]) -> [f64; 2] {
    from_fn(|i| content[2 * i + 1] / (volumes[i] * heated(volumes[i])))
}

impl Air {
    /// The air at the start, with the ports that are open at these positions, and its forces on a piston that moves at
    /// `speed`. A chamber at the exhaust's pressure exerts exactly none.
    pub(crate) fn start(
        parameters: &Parameters,
        places: Places,
        [supply, exhaust]: [f64; 2],
        speed: f64,
    ) -> (Self, [f64; 2]) {
        let law = &parameters.air;
        let shut = places[0] < parameters.cylinder_end(false);
        let openings = law.openings(places[0], shut);
        let mut air = Self { openings, shut, ..Self::default() };
        let pressures = law.start(&openings, supply, exhaust);
        air.fill(parameters, places, pressures);
        air.energy_start = air.energy(parameters, places, 0.0);
        (air, series::pushes(parameters, pressures, speed, exhaust))
    }

    /// Sets the chambers to these pressures, at the supply's temperature.
    fn fill(&mut self, parameters: &Parameters, places: Places, pressures: [f64; 2]) {
        let volumes = volumes(parameters, places);
        self.content = from_fn(|k| {
            let (p, v) = (pressures[k / 2], volumes[k / 2]);
            if k % 2 == 0 { p * v / (GAS * parameters.air.temperature) } else { p * v * heated(v) }
        });
    }

    /// Begins or ends venting of the drive. Either way the chambers take the exhaust's pressure, and a drive that acts
    /// again fills them through their ports. While the piston is in the cylinder's end, they keep their air.
    pub(crate) fn vent(
        &mut self,
        parameters: &Parameters,
        places: Places,
        vented: bool,
        exhaust: f64,
    ) {
        let (was_shut, shut) = (self.shut, places[0] < parameters.cylinder_end(vented));
        let ports = parameters.air.openings(places[0], shut);
        self.openings = if vented { Openings::default() } else { ports };
        self.shut = shut;
        if !(was_shut && shut) {
            self.refill(parameters, places, exhaust, vented && !shut);
        }
    }

    /// Records that the piston enters or leaves the cylinder's end. If it enters while the chambers are vented, they
    /// are filled at the exhaust's pressure.
    pub(crate) fn pass_end(
        &mut self,
        parameters: &Parameters,
        places: Places,
        [inside, vented]: [bool; 2],
        exhaust: f64,
    ) {
        self.shut = inside;
        if vented {
            self.refill(parameters, places, exhaust, !inside);
        } else {
            self.openings = parameters.air.openings(places[0], inside);
        }
    }

    /// Sets both chambers to this pressure, and holds them there if they are vented. The change of their energy counts
    /// as enthalpy that came in.
    fn refill(&mut self, parameters: &Parameters, places: Places, pressure: f64, vented: bool) {
        let before = self.energy(parameters, places, 0.0);
        self.vented = vented.then_some(places);
        self.fill(parameters, places, [pressure; 2]);
        self.sums.enthalpy += self.energy(parameters, places, 0.0) - before;
        self.window = None;
    }

    /// The content of the chambers at `t` after the epoch.
    pub(crate) fn content_at(&self, t: f64) -> Content {
        let Some(window) = &self.window else { return self.content };
        window.content_at(t / window.length, self.content)
    }

    /// The sums at `t` after the epoch. The work `int P x'` is that of the polynomial forces on the actual
    /// motion of the steel. It is integrated by parts, since in a ringing motion the position is known better
    /// than the speed.
    pub(crate) fn sums_at(&self, places: Places, t: f64) -> AirSums {
        let Some(window) = &self.window else { return self.sums };
        let tau = t / window.length;
        self.sums_of(window, window.at(tau), (places, tau))
    }

    fn sums_of(&self, window: &Window, at: Row, (places, tau): (Places, f64)) -> AirSums {
        let ([.., mass, enthalpy], rest) = (at, value(&window.moment, tau));
        let at_ends = |i: usize| {
            value(&window.push[i], tau) * places[i] - window.push[i][0] * window.place[i]
        };
        let work = at_ends(0) + at_ends(1) - rest;
        AirSums {
            mass: self.sums.mass + mass,
            enthalpy: self.sums.enthalpy + enthalpy,
            work: self.sums.work + work,
        }
    }

    /// Pressure and temperature on the sides of the flow paths, at `t` after the epoch: supply, exhaust, both
    /// chambers.
    pub(crate) fn sides(
        &self,
        parameters: &Parameters,
        places: Places,
        outside: [f64; 2],
        t: f64,
    ) -> [Side; 4] {
        let (content, volumes) = (self.content_at(t), volumes(parameters, places));
        let side = |i: usize| {
            let product = content[2 * i + 1] / heated(volumes[i]);
            [product / volumes[i], product / (content[2 * i] * GAS)]
        };
        let [supply, exhaust] = outside.map(|pressure| [pressure, parameters.air.temperature]);
        [supply, exhaust, side(0), side(1)]
    }

    /// Pressures at `t` after the epoch, Pa.
    pub(crate) fn pressures(&self, parameters: &Parameters, places: Places, t: f64) -> [f64; 2] {
        pressures(&self.content_at(t), volumes(parameters, places))
    }

    /// Internal energy at `t` after the epoch, J; for vented chambers, the energy at which venting began.
    pub(crate) fn energy(&self, parameters: &Parameters, places: Places, t: f64) -> f64 {
        let volumes = volumes(parameters, self.vented.unwrap_or(places));
        let pressures = pressures(&self.content_at(t), volumes);
        (pressures[0] * volumes[0] + pressures[1] * volumes[1]) / (KAPPA - 1.0)
    }

    /// Error of the energy balance, J: enthalpy in less enthalpy out, less work, less the chambers' gain.
    pub(crate) fn residual(&self, parameters: &Parameters, places: Places, t: f64) -> f64 {
        let sums = self.sums_at(places, t);
        sums.enthalpy - sums.work - (self.energy(parameters, places, t) - self.energy_start)
    }

    /// Rates at `t` after the epoch: of both pressures, Pa/s, and of the mass taken from the supply, kg/s.
    pub(crate) fn rates(
        &self,
        parameters: &Parameters,
        outside: [f64; 2],
        [places, speeds]: [Places; 2],
        t: f64,
    ) -> [f64; 3] {
        if self.window.is_none() {
            return [0.0; 3];
        }
        let law = &parameters.air;
        let volumes = volumes(parameters, places);
        let sides = self.sides(parameters, places, outside, t);
        let areas = law.areas(&self.openings, places[0]);
        // Flow through each path, kg/s, and the temperature of its source, K.
        let flows: [[f64; 2]; PATHS] = from_fn(|path| {
            let [one, other] = ENDS[path].map(|i| sides[i]);
            let [flow, hot] = self.regimes[path].flow(one, other);
            if areas[path] == 0.0 { [0.0; 2] } else { [areas[path] * flow, hot] }
        });
        let drive = &parameters.drive;
        let swelling = [drive.area_drive * speeds[0], -drive.area_return * speeds[1]];
        let heats = gains(&flows.map(|[flow, hot]| flow * hot));
        let rate = |i: usize| KAPPA * (GAS * heats[i] - sides[2 + i][0] * swelling[i]) / volumes[i];
        [rate(0), rate(1), flows[0][0] + flows[2][0]]
    }

    /// Moves the epoch forward by `at`, where the piston has these positions.
    /// Returns the window, as storage for the next one.
    pub(crate) fn shift(&mut self, places: Places, at: f64) -> Option<Box<Window>> {
        let window = self.window.take()?;
        let tau = at / window.length;
        let numbers = window.at(tau);
        self.content = window.content_of(numbers, self.content);
        self.sums = self.sums_of(&window, numbers, (places, tau));
        if at >= window.reach
            && let Some((path, regime)) = window.then
        {
            self.regimes[path] = regime;
        }
        Some(window)
    }

    /// True if every number is finite and the window reaches beyond `now`.
    pub(crate) fn is_sound(&self, now: f64) -> bool {
        let window = |w: &Window| {
            let powers = w.rows.iter().flatten().chain(w.push.iter().flatten());
            let powers = powers.chain(&w.moment).chain(&w.place);
            powers.chain([&w.length]).all(|x| x.is_finite())
                && w.length > 0.0
                && w.reach <= w.length
                && w.reach >= now
                && w.then.is_none_or(|(path, _)| path < PATHS)
        };
        let AirSums { mass, enthalpy, work } = self.sums;
        let numbers = [mass, enthalpy, work, self.energy_start];
        self.content.iter().all(|x| x.is_finite() && *x > 0.0)
            && numbers.into_iter().all(f64::is_finite)
            && self.vented.is_none_or(|places| places.into_iter().all(f64::is_finite))
            && self.window.as_deref().is_none_or(window)
    }
}

/// What both chambers gain through the flow paths.
pub(crate) fn gains(flows: &[f64; PATHS]) -> [f64; 2] {
    [flows[0] - flows[1] - flows[4], flows[2] - flows[3] + flows[4]]
}
