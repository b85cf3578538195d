//! Transitions: how an event changes the mode, and how the state moves with it.
//!
//! At an event a track is read off in displacements and velocities of the bodies' modes, the
//! law changes, and the track enters the system of the new mode:
//!
//! ```text
//! contact   closes: [bit], [piston] -> [both]       opens: [both] -> [bit], [piston]
//! rock      spring and origin of the track that ends at the tip
//! drive     loads alone
//! ```

use super::{Motion, empty};
use crate::error::Error;
use crate::modal::driven::Driven;
use crate::modal::model::Span;
use crate::motion::state::Anchor;
use crate::physics::event::Displacement;
use crate::physics::event::RockEvent;
use crate::physics::mode::{Chamber, Port};
use crate::physics::rock::Spring;

impl Motion {
    /// Q9, Q10.
    pub(crate) fn switch_relay(&mut self) {
        self.state.mode.relay = self.state.mode.relay.turned();
        self.reload();
    }

    /// The piston passes a port.
    pub(crate) fn switch_port(&mut self, chamber: Chamber, port: Port) {
        let law = self.model.parameters.chambers.of(chamber);
        self.state.gas[chamber as usize].turn(law, port);
        self.reload();
    }

    /// A chamber's pressure is at its level.
    pub(crate) fn reach_level(&mut self, chamber: Chamber) {
        self.state.gas[chamber as usize].arrive();
        self.reload();
    }

    /// Q11: opens or closes the contact, the tracks standing at the epoch.
    pub(crate) fn switch_contact(&mut self) -> Result<(), Error> {
        self.rotate_to_epoch();
        let closed = &mut self.state.mode.closed;
        *closed = !*closed;
        if *closed { self.join() } else { self.part() }
    }

    fn join(&mut self) -> Result<(), Error> {
        let (p, b) = (self.model.piston.len(), self.model.bit.len());
        let bit = self.body_state(&self.tracks[0], 0, 0.0);
        let piston = self.body_state(&self.tracks[1], 1, 0.0);
        let both = [&piston[..p], &bit[..b], &piston[p..], &bit[b..]].concat();
        self.tracks.truncate(1);
        self.state.anchors.truncate(1);
        self.enter(0, Span::Both(self.spring()), &both)
    }

    fn part(&mut self) -> Result<(), Error> {
        let (p, both) = (self.model.piston.len(), self.model.piston.len() + self.model.bit.len());
        let state = self.body_state(&self.tracks[0], 0, 0.0);
        let body = |modes: std::ops::Range<usize>| {
            [&state[modes.clone()], &state[both + modes.start..both + modes.end]].concat()
        };
        self.enter(0, Span::Bit(self.spring()), &body(p..both))?;
        let system = self.model.system(Span::Piston, self.state.mode)?;
        let track = empty(system);
        self.state.anchors.push(Anchor {
            span: Span::Piston,
            z: track.z.clone(),
            at: 0.0,
            driven: Driven::default(),
            form: 0.0,
        });
        self.tracks.push(track);
        self.enter(1, Span::Piston, &body(0..p))
    }

    /// Q1 to Q8, the tip's track standing at the epoch.
    pub(crate) fn switch_rock(&mut self, event: RockEvent) -> Result<(), Error> {
        let p = self.point(&self.tracks[..1], Displacement::Tip, 0.0).displacement;
        let before = self.spring();
        let transition = self.state.memory.transit(event, p, &self.model.parameters.rock);
        self.state.mode.rock = transition.mode;
        self.state.psi = 0.0; // No event of the rock leaves a viscous part to go on.
        let after = Spring::of(transition.mode);
        if before == after && transition.shift == 0.0 {
            return Ok(());
        }
        let mut state = self.body_state(&self.tracks[0], 0, 0.0);
        self.shift_origin(transition.shift, &mut state);
        let closed = self.state.mode.closed;
        self.enter(0, if closed { Span::Both(after) } else { Span::Bit(after) }, &state)
    }

    /// Measures displacements from a point `shift` further down.
    fn shift_origin(&mut self, shift: f64, state: &mut [f64]) {
        self.state.origin.move_by(shift);
        let (mp, mb) = (self.model.piston.mass.sqrt(), self.model.bit.mass.sqrt());
        if self.state.mode.closed {
            state[0] -= shift * mp;
            state[self.model.piston.len()] -= shift * mb;
        } else {
            state[0] -= shift * mb;
            self.state.anchors[1].driven.translation.0[0] -= shift * mp;
        }
    }
}
