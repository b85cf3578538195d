//! The air of a run: its pressures and flows.

use super::Run;
use crate::air::{Air, Flow, PRESSURES};
use crate::law::Quantity;
use crate::linear::Real;

impl<T: Real> Run<T> {
    /// Positions of the piston in the cylinder, and relative to what it strikes, m.
    pub(super) fn places(&self) -> [T; 2] {
        let state = &self.place.state;
        let over = self.model.over(&state.u) - T::from(self.model.scene.gap);
        [self.model.quantity(Quantity::Relative, state), over]
    }

    /// The air under the present outside pressures.
    fn air_now(&self) -> Option<Air<T>> {
        self.air.as_ref().map(|air| air.under(&self.inputs_now()))
    }

    /// Pressures of the chambers of air, Pa; zeros without.
    pub(super) fn pressures(&self) -> [T; 2] {
        let of = |air: Air<T>| air.pressures(&self.place.works.air, self.places());
        self.air_now().map_or([T::default(); 2], of)
    }

    /// The drive's force on the piston, N.
    pub(super) fn drive_force(&self) -> T {
        let state = &self.place.state;
        let Some(air) = self.air_now() else {
            let force = self.model.driving(self.mode, &self.inputs_now())[0][0];
            return force + self.model.line(self.mode, &state.v);
        };
        let motion = (self.places(), self.model.mean_difference(&state.v));
        air.drive(self.model.scene.anvil_area, &self.place.works.air, motion)[0]
    }

    /// Writes the air's pressures above the exhaust's into the inputs that hold them.
    pub(super) fn breathe(&mut self) {
        let Some(air) = self.air_now() else { return };
        let exhaust = air.exhaust();
        for (input, pressure) in PRESSURES.into_iter().zip(self.pressures()) {
            self.inputs[input as usize] = vec![pressure - exhaust];
        }
    }

    /// Chooses the flows' formulas by the present pressures, after a port or the vent has changed.
    pub(super) fn flow_anew(&mut self) {
        let pressures = self.pressures();
        self.air = self.air_now();
        self.air.iter_mut().for_each(|air| air.classify(pressures));
        self.breathe();
    }

    /// Changes the formula of a flow.
    pub(super) fn flow_as(&mut self, change: (usize, Flow)) {
        self.air.iter_mut().for_each(|air| air.change(change));
    }
}
