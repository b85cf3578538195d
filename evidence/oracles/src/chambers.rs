//! Chambers whose pressures are straight lines of time from where the piston passes a port.
//!
//! A run keeps them as the two pressure inputs, which such a drive does not read: a port that
//! turns sets one of them to `p0 + (p1 - p0) (t - t0) / T`, and the end of that line to `p1`.

use crate::law::{Event, Guard, Quantity};
use crate::linear::Real;
use crate::scene::{Drive, Input, Port, Scene};

/// Where the pressures of chambers stand.
pub(crate) const PRESSURES: [Input; 2] = [Input::DrivePressure, Input::ReturnPressure];

/// What is open, and where the present lines end.
#[derive(Clone, Debug)]
pub struct Chambers<T> {
    /// Drive and return chamber; supply and exhaust of each.
    ports: [[Port; 2]; 2],
    open: [[bool; 2]; 2],
    /// The drive is vented: no port is watched.
    vented: bool,
    /// Where a line ends: when, s, and at which pressure, Pa.
    ends: [Option<(T, f64)>; 2],
    /// Rate of the guard that began it.
    rates: [T; 2],
    height: f64,
}

/// Ports of a chamber as close as this are at one place, m.
const TOGETHER: f64 = 1e-12;

/// `+1` if the port is open where the relative position is above its place: the exhaust of the
/// drive chamber and the supply of the return chamber.
fn side(chamber: usize, port: usize) -> f64 {
    if chamber == port { -1.0 } else { 1.0 }
}

/// The ports that are open with the piston at `vr`.
fn opened<T: Real>(ports: &[[Port; 2]; 2], vr: T) -> [[bool; 2]; 2] {
    let is_open = |chamber: usize, port: usize| {
        let beyond = (vr - T::from(ports[chamber][port].position)).to_f64();
        side(chamber, port) * beyond >= 0.0
    };
    [0, 1].map(|chamber| [0, 1].map(|port| is_open(chamber, port)))
}

impl<T: Real> Chambers<T> {
    /// Those of a scene with the piston at `vr`, if it has any.
    pub fn start(scene: &Scene, vr: T) -> Option<Self> {
        let Drive::Chambers { ports, .. } = scene.drive else { return None };
        let open = opened(&ports, vr);
        let rates = [T::default(); 2];
        Some(Self {
            ports,
            open,
            vented: false,
            ends: [None; 2],
            rates,
            height: scene.resolutions[0],
        })
    }

    /// Writes the pressures that hold until a port turns into a row of inputs, Pa.
    pub fn put(&self, inputs: &mut [Vec<T>; 4]) {
        for (chamber, input) in PRESSURES.into_iter().enumerate() {
            let [supply, exhaust] = &self.ports[chamber];
            let supplied = !self.vented && self.open[chamber][0];
            let port = if supplied { supply } else { exhaust };
            inputs[input as usize] = vec![T::from(port.open[0])];
        }
    }

    /// The drive is vented, or drives again with the piston at `vr`: ports and pressures are as a start
    /// there has them.
    pub fn vent(&mut self, vented: bool, vr: T) {
        self.open = opened(&self.ports, vr);
        (self.vented, self.ends) = (vented, [None; 2]);
    }

    /// The ports, on the way that turns each.
    pub fn guards(&self) -> Vec<Guard<T>> {
        let all = [(0, 0), (0, 1), (1, 0), (1, 1)];
        let guard = |(chamber, port): (usize, usize)| {
            let opens = !self.open[chamber][port];
            let sign = if opens { side(chamber, port) } else { -side(chamber, port) };
            Guard {
                event: Event::Port(chamber, port, opens),
                quantity: Quantity::Relative,
                sign,
                offset: T::from(self.ports[chamber][port].position),
                height: self.height,
            }
        };
        all.into_iter().filter(|_| !self.vented).map(guard).collect()
    }

    /// A port turns at `time` and the pressure `now`: the coefficients of its line, by powers of
    /// `unit`.
    pub fn turn(
        &mut self,
        (chamber, port, opens): (usize, usize, bool),
        (time, now, rate): (T, T, T),
        unit: f64,
    ) -> Vec<T> {
        self.open[chamber][port] = opens;
        let [supply, exhaust] = &self.ports[chamber];
        if !opens && (supply.position - exhaust.position).abs() <= TOGETHER {
            // The other one opens here, and has the pressure: the line goes on.
            let rest = self.ends[chamber].map(|(end, level)| (T::from(level) - now) / (end - time));
            return rest.map_or(vec![now], |slope| vec![now, slope * T::from(unit)]);
        }
        let port = &self.ports[chamber][port];
        let [level, span] = if opens { port.open } else { port.shut };
        let rise = (T::from(level) - now) * T::from(unit);
        // Nothing ends where there is nothing to wait for.
        let gradual = span > 0.0 && rise.to_f64() != 0.0;
        self.ends[chamber] = gradual.then(|| (time + T::from(span), level));
        self.rates[chamber] = rate;
        if gradual { vec![now, rise / T::from(span)] } else { vec![T::from(level)] }
    }

    /// The line that ends next: when, and of which chamber.
    pub fn next(&self) -> Option<(T, usize)> {
        let ends = [0, 1].map(|chamber| self.ends[chamber].map(|(time, _)| (time, chamber)));
        let earlier = |a: (T, usize), b: (T, usize)| if (b.0 - a.0).to_f64() < 0.0 { b } else { a };
        ends.into_iter().flatten().reduce(earlier)
    }

    /// A line ends: its pressure, and the rate of the guard that began it.
    pub fn arrive(&mut self, chamber: usize) -> Option<(f64, T)> {
        self.ends[chamber].take().map(|(_, level)| (level, self.rates[chamber]))
    }
}
