//! Air in two chambers, as Taylor series of the mass and the inner energy of each.
//!
//! With `x` the piston's relative position and `y` that over the struck body, at which the return chamber ends,
//! `V_d = V_d0 + A_d (s + x)`, `V_r = V_r0 - A_r y`,
//!
//! ```text
//! p = (kappa - 1) E / V                  T = (kappa - 1) E / (R m)
//! m' = sum flow                          E' = cp sum flow T_upstream - p V'
//! ```
//!
//! Every factor of a flow is a product, a quotient or a power of series, whose coefficients follow from
//! the lower ones; so the air's series grow together with those of the bodies that it drives. A series
//! holds while no port passes an edge and no flow passes from one formula to another: the former are
//! events of the run, the latter bounds of its step ([`AirSeries::change`]).
//!
//! In the cylinder's end, where half of `V_d0` is left, the drive chamber's ports are shut. While the drive is
//! vented both chambers have the exhaust's pressure, and the end begins at `x = -s`: what is in them there is shut
//! in. A drive that works again begins with chambers at that pressure, which fill through their ports.

mod series;

use crate::law::{Event, Guard, Quantity};
use crate::linear::Real;
use crate::powers::raised;
use crate::scene::{AirLaw, Drive, Input, Scene};
pub use series::AirSeries;

/// Gas constant, J/(kg K), and ratio of heats.
const GAS: f64 = 287.05;
const KAPPA: f64 = 1.4;
/// Ratio of pressures above which a flow is proportional to their difference.
const STRAIGHT: f64 = 0.995;
/// Inputs that hold the pressures of the chambers above the exhaust's.
pub(crate) const PRESSURES: [Input; 2] = [Input::DrivePressure, Input::ReturnPressure];
/// Mass and inner energy of the drive chamber, then of the return chamber; mass taken from the supply.
pub type Content<T> = [T; 5];

/// State of a port.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Width {
    Shut,
    Part,
    Whole,
}

/// The formula of a flow.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Formula {
    Straight,
    Subsonic,
    Choked,
}

/// A flow: its formula, and true if it goes from its second side to its first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    formula: Formula,
    reversed: bool,
}

/// State of the ports, and formulas of the flows.
#[derive(Clone, Debug)]
pub struct Air<T> {
    law: AirLaw,
    /// Pressures of supply and exhaust, Pa: coefficients about the present instant.
    outside: [Vec<T>; 2],
    widths: [[Width; 2]; 2],
    /// Supply and exhaust of each chamber, then the leak from the drive chamber to the other.
    flows: [Flow; 5],
    vented: bool,
    /// True if the piston is in the cylinder's end.
    shut: bool,
    height: f64,
}

/// `+1` if a port is open where the relative position is above its edge.
fn side(chamber: usize, port: usize) -> f64 {
    if chamber == port { -1.0 } else { 1.0 }
}

/// `sqrt(r^(2/kappa) - r^((kappa+1)/kappa))`.
fn jet<T: Real>(ratio: T) -> T {
    let root = raised(ratio, (5, 7));
    raised(root * (root - ratio), (1, 2))
}

/// The ratio of pressures below which a flow is choked, `(2 / (kappa + 1))^(kappa / (kappa - 1))`.
fn choked<T: Real>() -> T {
    raised(T::from(5.0) / T::from(6.0), (7, 2))
}

impl<T: Real> Air<T> {
    /// The air of a scene with the piston at `vr`, if air drives it.
    pub fn start(scene: &Scene, vr: T) -> Option<Self> {
        let Drive::Air(law) = scene.drive else { return None };
        let flow = Flow { formula: Formula::Straight, reversed: false };
        let mut air = Self {
            law,
            outside: law.outside.map(|p| vec![T::from(p)]),
            widths: [[Width::Shut; 2]; 2],
            flows: [flow; 5],
            vented: false,
            shut: false,
            height: scene.resolutions[0],
        };
        air.shut = (vr - T::from(air.bottom())).to_f64() < 0.0;
        air.open(vr);
        Some(air)
    }

    /// The same air under these inputs.
    pub fn under(&self, inputs: &[Vec<T>; 6]) -> Self {
        let outside = [Input::Supply, Input::Exhaust].map(|input| inputs[input as usize].clone());
        Self { outside, ..self.clone() }
    }

    /// Where the cylinder's end begins, m.
    fn bottom(&self) -> f64 {
        let room = 0.5 * self.law.dead_volumes[0] / self.law.areas[0];
        -self.law.cylinder - if self.vented { 0.0 } else { room }
    }

    /// True if both chambers have the exhaust's pressure.
    fn is_open(&self) -> bool {
        self.vented && !self.shut
    }

    fn open(&mut self, vr: T) {
        for (chamber, widths) in self.widths.iter_mut().enumerate() {
            for (port, width) in widths.iter_mut().enumerate() {
                let beyond = vr - T::from(self.law.edges[chamber][port]);
                *width = match side(chamber, port) * beyond.to_f64() {
                    _ if self.vented || self.shut && chamber == 0 => Width::Shut,
                    x if x < 0.0 => Width::Shut,
                    x if x < self.law.height => Width::Part,
                    _ => Width::Whole,
                };
            }
        }
    }

    /// Pressure of the exhaust, Pa.
    pub fn exhaust(&self) -> T {
        self.outside[1][0]
    }

    /// Volumes with the piston at `x` and `y`, m3.
    pub fn volumes(&self, [x, y]: [T; 2]) -> [T; 2] {
        let [drive, back] = self.law.areas.map(T::from);
        let [drive_dead, back_dead] = self.law.dead_volumes.map(T::from);
        [drive_dead + drive * (T::from(self.law.cylinder) + x), back_dead - back * y]
    }

    /// Content of the chambers at a start with the piston at `x` and `y`.
    pub fn filled(&self, places: [T; 2]) -> Content<T> {
        let ports = [0, 1].map(|chamber| usize::from(self.widths[chamber][0] == Width::Shut));
        self.filled_from(ports, places, T::default())
    }

    /// Content of chambers at the exhaust's pressure; the mass taken from the supply stays.
    fn emptied(&self, places: [T; 2], taken: T) -> Content<T> {
        self.filled_from([1; 2], places, taken)
    }

    fn filled_from(&self, ports: [usize; 2], places: [T; 2], taken: T) -> Content<T> {
        let volumes = self.volumes(places);
        let fill = |chamber: usize| {
            let port = ports[chamber];
            let work = self.outside[port][0] * volumes[chamber];
            let mass = work / (T::from(GAS) * T::from(self.law.temperature));
            [mass, work / (T::from(KAPPA) - T::from(1.0))]
        };
        let [[md, ed], [mr, er]] = [0, 1].map(fill);
        [md, ed, mr, er, taken]
    }

    /// Pressures of the chambers with the piston at `x` and `y`, Pa; the exhaust's while they are vented.
    pub fn pressures(&self, content: &Content<T>, places: [T; 2]) -> [T; 2] {
        if self.is_open() {
            return [self.exhaust(); 2];
        }
        let volumes = self.volumes(places);
        let factor = T::from(KAPPA) - T::from(1.0);
        [0, 1].map(|i| factor * content[2 * i + 1] / volumes[i])
    }

    /// `F_A`, and the force on the struck body, at these pressures and this relative speed. `outside` is the
    /// exhaust's pressure, or 0 for coefficients after the first.
    fn forces(&self, anvil: f64, pressures: [T; 2], speed: T, outside: T) -> [T; 2] {
        let [drive, back] = pressures.map(|p| p - outside);
        let [area, back_area] = self.law.areas.map(T::from);
        [area * drive - back_area * back - T::from(self.law.drag) * speed, T::from(anvil) * back]
    }

    /// The forces in a state.
    pub fn drive(&self, anvil: f64, content: &Content<T>, (places, speed): ([T; 2], T)) -> [T; 2] {
        if self.is_open() {
            return [T::default(); 2];
        }
        self.forces(anvil, self.pressures(content, places), speed, self.exhaust())
    }

    /// Begins or ends venting. A drive that acts again has the ports of the piston's positions `x` and `y`.
    pub fn vent(&mut self, vented: bool, places: [T; 2], content: &mut Content<T>) {
        let was_shut = self.shut;
        self.vented = vented;
        self.shut = (places[0] - T::from(self.bottom())).to_f64() < 0.0;
        self.open(places[0]);
        if !(was_shut && self.shut) {
            *content = self.emptied(places, content[4]);
        }
    }

    /// The piston enters or leaves the cylinder's end.
    pub fn end(&mut self, inside: bool, places: [T; 2], content: &mut Content<T>) {
        self.shut = inside;
        self.open(places[0]);
        if self.vented {
            *content = self.emptied(places, content[4]);
        }
    }

    /// Guards at the ends of the ports' present openings.
    pub fn guards(&self) -> Vec<Guard<T>> {
        let quantity = Quantity::Relative;
        let sign = if self.shut { 1.0 } else { -1.0 };
        let (event, offset) = (Event::End(!self.shut), T::from(self.bottom()));
        let mut list = vec![Guard { event, quantity, sign, offset, height: self.height }];
        let works = |chamber: usize| !(self.vented || self.shut && chamber == 0);
        for (chamber, widths) in self.widths.iter().enumerate().filter(|(i, _)| works(*i)) {
            for (port, width) in widths.iter().enumerate() {
                let (way, edge) = (side(chamber, port), self.law.edges[chamber][port]);
                let mut guard = |event, sign, offset: f64| {
                    let offset = T::from(offset);
                    list.push(Guard { event, quantity, sign, offset, height: self.height });
                };
                let whole = edge + way * self.law.height;
                match width {
                    Width::Shut => guard(Event::Port(chamber, port, true), way, edge),
                    Width::Part => {
                        guard(Event::Port(chamber, port, false), -way, edge);
                        guard(Event::Whole(chamber, port, true), way, whole);
                    }
                    Width::Whole => guard(Event::Whole(chamber, port, false), -way, whole),
                }
            }
        }
        list
    }

    /// A port's opening changes.
    pub fn turn(&mut self, event: Event) {
        match event {
            Event::Port(chamber, port, opens) => {
                self.widths[chamber][port] = if opens { Width::Part } else { Width::Shut };
            }
            Event::Whole(chamber, port, whole) => {
                self.widths[chamber][port] = if whole { Width::Whole } else { Width::Part };
            }
            _ => {}
        }
    }

    /// Chooses the formula of every flow by these pressures, at a start and after jumps.
    pub fn classify(&mut self, pressures: [T; 2]) {
        for path in 0..5 {
            let [one, other] = self.sides(path).map(|chamber| match chamber {
                Side::Chamber(i) => pressures[i],
                Side::Outside(i) => self.outside[i][0],
            });
            let reversed = other > one;
            let (high, low) = if reversed { (other, one) } else { (one, other) };
            let formula = match low {
                _ if low > T::from(STRAIGHT) * high => Formula::Straight,
                _ if low > choked::<T>() * high => Formula::Subsonic,
                _ => Formula::Choked,
            };
            self.flows[path] = Flow { formula, reversed };
        }
    }

    /// Changes the formula of a flow.
    pub fn change(&mut self, (path, flow): (usize, Flow)) {
        self.flows[path] = flow;
    }

    fn sides(&self, path: usize) -> [Side; 2] {
        match path {
            4 => [Side::Chamber(0), Side::Chamber(1)],
            _ if path.is_multiple_of(2) => [Side::Outside(0), Side::Chamber(path / 2)],
            _ => [Side::Chamber(path / 2), Side::Outside(1)],
        }
    }

    /// Area of a fully open path, and its state.
    fn path(&self, path: usize) -> (f64, Width) {
        if path == 4 {
            return (self.law.leakage, Width::Whole);
        }
        (self.law.discharge * self.law.ports[path % 2], self.widths[path / 2][path % 2])
    }
}

/// One end of a flow path.
#[derive(Clone, Copy)]
enum Side {
    Chamber(usize),
    /// Supply (0) or exhaust (1).
    Outside(usize),
}
