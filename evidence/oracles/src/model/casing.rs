//! What a casing adds to the model: its nodes after the bit's, and the chuck. Rigid it is a node of mass
//! `Mc`, elastic a bar; feed and string act on its highest node, the chuck on its lowest.
//!
//! ```text
//! x = u_top - u_c     of the bit's highest node and the casing's lowest
//! shoulder, x <= 0:      ks x + cs x'             up on the bit's top, down on the casing
//! ring, x >= travel:     ks (x - travel) + cs x'  the same
//! ```

use super::Model;
use crate::law::{Chuck, Event, Guard, Mode, Quantity};
use crate::linear::Real;
use crate::scene::{Casing, Fidelity};

impl Casing {
    /// Number of its nodes.
    pub(super) fn nodes(&self, fidelity: Fidelity) -> usize {
        let elements: usize = self.sections.iter().map(|section| section.elements).sum();
        match fidelity {
            Fidelity::Rigid => 1,
            Fidelity::Elastic => elements + 1,
            Fidelity::Spectral(degree) => degree * elements + 1,
        }
    }
}

impl<T: Real> Model<T> {
    /// The node that the feed acts on: the casing's highest, or without one the bit's.
    pub fn fed(&self) -> usize {
        if self.scene.casing.is_some() { self.tip + 1 } else { self.bit }
    }

    /// `w3.u`, without a casing 0.
    pub fn chuck(&self, u: &[T]) -> T {
        if self.scene.casing.is_some() { u[self.bit] - u[self.nodes() - 1] } else { T::default() }
    }

    /// Stiffness, viscosity and level of the chuck's tie in a mode, if it acts.
    fn tie(&self, mode: Mode) -> Option<[T; 3]> {
        let casing = self.scene.casing.as_ref()?;
        let level = match mode.chuck {
            Chuck::Open => return None,
            Chuck::Shoulder => 0.0,
            Chuck::Ring => casing.travel,
        };
        Some([casing.stiffness, casing.viscosity, level].map(T::from))
    }

    /// Force on the casing upward and on the bit downward, N.
    pub fn chuck_force(&self, mode: Mode, u: &[T], v: &[T]) -> T {
        self.tie(mode).map_or(T::default(), |[stiffness, viscosity, level]| {
            -(stiffness * (self.chuck(u) - level) + viscosity * self.chuck(v))
        })
    }

    /// `ks x^2 / 2`, J, `x` from where the tie closed.
    pub(super) fn chuck_energy(&self, mode: Mode, u: &[T]) -> T {
        self.tie(mode).map_or(T::default(), |[stiffness, _, level]| {
            let x = self.chuck(u) - level;
            T::from(0.5) * stiffness * x * x
        })
    }

    /// Adds a force that presses the bit down and the casing up.
    fn press(&self, force: T, out: &mut [T]) {
        out[self.bit] = out[self.bit] + force;
        let lowest = self.nodes() - 1;
        out[lowest] = out[lowest] - force;
    }

    /// Adds what the tie pushes with where `u = 0`, N.
    pub(super) fn add_chuck_push(&self, mode: Mode, out: &mut [T]) {
        if let Some([stiffness, _, level]) = self.tie(mode) {
            self.press(stiffness * level, out);
        }
    }

    /// Adds the rest of its force, N.
    pub(super) fn add_chuck_force(&self, mode: Mode, u: &[T], v: &[T], out: &mut [T]) {
        if let Some([stiffness, viscosity, _]) = self.tie(mode) {
            self.press(-(stiffness * self.chuck(u) + viscosity * self.chuck(v)), out);
        }
    }

    /// Stiffness and viscosity of the tie where it holds a node, N/m and N s/m.
    pub(super) fn tied(&self, node: usize) -> [f64; 2] {
        match &self.scene.casing {
            Some(casing) if node == self.bit || node == self.nodes() - 1 => {
                [casing.stiffness, casing.viscosity]
            }
            _ => [0.0; 2],
        }
    }

    /// Where bit and casing meet or part, and where the drive is vented or works again.
    pub(super) fn chuck_guards(&self, mode: Mode) -> Vec<Guard<T>> {
        let Some(casing) = &self.scene.casing else { return Vec::new() };
        let guard = |event, sign, offset: f64| Guard {
            event,
            quantity: Quantity::Chuck,
            sign,
            offset: T::from(offset),
            height: self.scene.resolutions[0],
        };
        let mut list = match mode.chuck {
            Chuck::Open => vec![
                guard(Event::Chuck(Chuck::Shoulder), -1.0, 0.0),
                guard(Event::Chuck(Chuck::Ring), 1.0, casing.travel),
            ],
            Chuck::Shoulder => vec![guard(Event::Chuck(Chuck::Open), 1.0, 0.0)],
            Chuck::Ring => vec![guard(Event::Chuck(Chuck::Open), -1.0, casing.travel)],
        };
        if casing.idle_travel > 0.0 {
            let sign = if mode.vented { -1.0 } else { 1.0 };
            list.push(guard(Event::Vent(!mode.vented), sign, casing.idle_travel));
        }
        list
    }
}
