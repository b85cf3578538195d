//! Transitions: how an event changes the mode, and how the state moves with it.
//!
//! An event first *settles* the machine: sums are closed and the epoch moves to its instant.
//! Then a track is *lifted* to displacements and velocities of the bars' modes, the law
//! transforms, and the track *lands* on the system of the new mode.

use crate::error::Error;
use crate::machine::observe::Record;
use crate::machine::state::Anchor;
use crate::machine::{Event, MAX_BURST, MAX_CASCADE, Machine, SHORTEST_SPACING, TIME_RESOLUTION};
use crate::modal::model::{self, Span};
use crate::modal::system::{System, translation};
use crate::numerics::poly::Poly;
use crate::physics::inputs::Input;
use crate::physics::mode::{Relay, RockMode};
use crate::physics::rock::{RockEvent, Spring};
use crate::search::guard::Track;
use std::sync::Arc;

impl Machine {
    /// The transition of an event at `at` after the epoch.
    pub(crate) fn occur(&mut self, at: f64, event: Event) -> Result<(), Error> {
        let from = self.state.mode;
        self.settle(at)?;
        let state = &mut self.state;
        state.simultaneous = if at <= TIME_RESOLUTION { state.simultaneous + 1 } else { 0 };
        state.counters.events += 1;
        state.burst.0 += 1;
        if state.burst.0 == MAX_BURST {
            let span = state.epoch.since(state.burst.1);
            if span * self.model.fastest() < SHORTEST_SPACING * f64::from(MAX_BURST) {
                let reason = "too many transitions in too short a time";
                return Err(Error::Overwork {
                    time: state.epoch.value(),
                    reason,
                    mode: state.mode,
                });
            }
            state.burst = (0, state.epoch);
        }
        let name = event.name(state.mode);
        match event {
            Event::Contact => self.switch_contact()?,
            Event::Rock(event) => self.switch_rock(event)?,
            Event::Relay => self.switch_relay(),
        }
        if let Some(journal) = &mut self.journal {
            let epoch = self.state.epoch;
            let (time, time_rest) = (epoch.value(), epoch.rest());
            journal.push(Record { time, time_rest, event: name, mode: self.state.mode });
        }
        if self.state.simultaneous > MAX_CASCADE {
            return Err(Error::Cascade {
                time: self.state.epoch.value(),
                transitions: self.state.simultaneous,
                from,
                to: self.state.mode,
            });
        }
        self.arm();
        Ok(())
    }

    pub(crate) fn switch_relay(&mut self) {
        let relay = &mut self.state.mode.relay;
        *relay = if *relay == Relay::Drive { Relay::Return } else { Relay::Drive };
        self.reload();
    }

    pub(crate) fn switch_contact(&mut self) -> Result<(), Error> {
        let spring = Spring::of(self.state.mode.rock);
        let (piston, bit) = (2 * self.model.piston.len(), 2 * self.model.bit.len());
        let (p, b) = (piston / 2, bit / 2);
        if self.state.mode.closed {
            self.state.mode.closed = false;
            self.note_opening();
            let hub = self.lift(0);
            let both = p + b;
            let part = |i: std::ops::Range<usize>| {
                [&hub[i.clone()], &hub[both + i.start..both + i.end]].concat()
            };
            let (x, y) = (part(0..p), part(p..both));
            self.land(0, Span::Bit(spring), &y)?;
            self.add_track(Span::Piston)?;
            self.land(1, Span::Piston, &x)
        } else {
            self.state.mode.closed = true;
            self.note_closing();
            let lost = self.damping_left(1);
            self.state.sums.damping += lost;
            let (y, x) = (self.lift(0), self.lift(1));
            let hub = [&x[..p], &y[..b], &x[p..], &y[b..]].concat();
            self.tracks.truncate(1);
            self.state.anchors.truncate(1);
            self.land(0, Span::Both(spring), &hub)
        }
    }

    pub(crate) fn switch_rock(&mut self, event: RockEvent) -> Result<(), Error> {
        let p = self.tip(0.0)[0];
        let transition = self.state.memory.transit(event, p, &self.model.parameters.rock);
        let before = Spring::of(self.state.mode.rock);
        let after = Spring::of(transition.mode);
        self.state.mode.rock = transition.mode;
        if transition.mode == RockMode::DissipativeForward {
            self.state.counters.rock_cycles += 1;
            self.state.psi = 0.0;
        }
        if before == after && transition.shift == 0.0 {
            return Ok(());
        }
        let mut hub = self.lift(0);
        self.shift_origin(transition.shift, &mut hub);
        let span = if self.state.mode.closed { Span::Both(after) } else { Span::Bit(after) };
        self.land(0, span, &hub)
    }

    /// Measures displacements from a point `shift` further down.
    fn shift_origin(&mut self, shift: f64, hub: &mut [f64]) {
        self.state.origin.add(shift);
        let (mp, mb) = (self.model.piston.mass.sqrt(), self.model.bit.mass.sqrt());
        if self.state.mode.closed {
            hub[0] -= shift * mp;
            hub[self.model.piston.len()] -= shift * mb;
        } else {
            hub[0] -= shift * mb;
            self.state.anchors[1].translation.0[0] -= shift * mp;
        }
    }

    /// Moves the epoch to the present time, from the last event in one flow.
    pub(crate) fn settle_now(&mut self) -> Result<(), Error> {
        for (track, anchor) in self.tracks.iter_mut().zip(&self.state.anchors) {
            track.z.copy_from_slice(&anchor.z);
            track.at = anchor.at;
        }
        let now = self.state.now;
        // What the search counted ahead of the present is void.
        for (_, watch) in &mut self.watches {
            watch.undecided = 0;
        }
        self.settle(now)
    }

    /// Moves the epoch by `at` and sums up the stretch that ends there.
    pub(crate) fn settle(&mut self, at: f64) -> Result<(), Error> {
        self.keep_stretch(at);
        self.work.samples += self.tracks[0].rotate_to(at);
        let sums = self.stretch_sums(&self.tracks, at);
        self.state.psi +=
            if self.state.mode.rock == RockMode::DissipativeForward { sums.viscous } else { 0.0 };
        self.state.sums.add(&sums);
        self.state.counters.undecided += self.watches.iter().map(|(_, w)| w.undecided).sum::<u64>();
        self.watches.clear();
        self.barrier = None;
        let form = self.damping_form(0);
        for (i, (track, anchor)) in self.tracks.iter_mut().zip(&mut self.state.anchors).enumerate()
        {
            track.at -= at;
            anchor.z.copy_from_slice(&track.z);
            anchor.at = track.at;
            anchor.translation = anchor.translation.shifted(at);
            if i == 0 {
                (track.at, anchor.at, anchor.form) = (0.0, 0.0, form);
            }
        }
        let state = &mut self.state;
        state.epoch.add(at);
        state.now -= at;
        state.step_start = (state.step_start - at).max(0.0);
        state.inputs.shift(at);
        state.loads = state.loads.map(|p| p.shifted(at));
        self.views = Default::default();
        if self.tracks[0].z.iter().any(|x| !x.is_finite()) {
            return Err(Error::NotFinite { time: self.state.epoch.value() });
        }
        Ok(())
    }

    /// Displacements and velocities of a track's bodies in the bars' modes, at the epoch.
    pub(crate) fn lift(&mut self, index: usize) -> Vec<f64> {
        self.work.samples += self.tracks[index].rotate_to(0.0);
        self.hub(&self.tracks[index], index, 0.0)
    }

    /// `[q | q']` of a track standing at `t`.
    pub(crate) fn hub(&self, track: &Track, index: usize, t: f64) -> Vec<f64> {
        let system = &track.system;
        let mut y = track.z.clone();
        self.add_static(system, t, 1.0, &mut y);
        if system.rigid {
            let n = system.blocks();
            let moved = &self.state.anchors[index].translation;
            (y[0], y[n]) = (moved.at(t), moved.derivative().at(t));
        }
        let mut hub = vec![0.0; 2 * system.modes()];
        system.from_modal(&y, &mut hub);
        hub
    }

    fn add_static(&self, system: &System, t: f64, sign: f64, y: &mut [f64]) {
        system.add_static(&self.state.loads, t, sign, y);
    }

    pub(crate) fn add_track(&mut self, span: Span) -> Result<(), Error> {
        let system = self.model.system(span, self.state.mode)?;
        let z = vec![0.0; 2 * system.blocks()];
        self.state.anchors.push(Anchor {
            span,
            z: z.clone(),
            at: 0.0,
            translation: Poly::default(),
            form: 0.0,
        });
        self.tracks.push(Track { system, z, at: 0.0 });
        Ok(())
    }

    /// Puts a track on the system of `span` with the state `hub` at the epoch.
    pub(crate) fn land(&mut self, index: usize, span: Span, hub: &[f64]) -> Result<(), Error> {
        let system = self.model.system(span, self.state.mode)?;
        let n = system.blocks();
        let mut z = vec![0.0; 2 * n];
        system.to_modal(hub, &mut z);
        let start = [z[0], z[n]];
        self.add_static(&system, 0.0, -1.0, &mut z);
        let anchor = &mut self.state.anchors[index];
        anchor.translation = Poly::default();
        if system.rigid {
            (z[0], z[n]) = (0.0, 0.0);
            anchor.translation = translation(start, &system.gains, &self.state.loads);
        }
        anchor.span = span;
        anchor.at = 0.0;
        anchor.z.clone_from(&z);
        self.tracks[index] = Track { system, z, at: 0.0 };
        self.state.counters.basis_changes += 1;
        self.state.anchors[index].form = self.damping_form(index);
        Ok(())
    }

    /// Recomputes the loads at the epoch; where a load jumps, static shapes and the
    /// oscillation about them exchange.
    pub(crate) fn reload(&mut self) {
        let old = self.state.loads;
        let alpha = self.state.mode.relay.sign();
        self.state.loads[model::DRIVE] = self.state.inputs.drive(&self.model.parameters, alpha);
        self.state.loads[model::FEED] = *self.state.inputs.of(Input::FeedForce);
        if old == self.state.loads {
            return;
        }
        for index in 0..self.tracks.len() {
            let system: Arc<_> = self.tracks[index].system.clone();
            if self.state.anchors[index].span != Span::Piston {
                system.add_static(&old, 0.0, 1.0, &mut self.tracks[index].z);
                system.add_static(&self.state.loads, 0.0, -1.0, &mut self.tracks[index].z);
                let form = self.damping_form(index);
                let anchor = &mut self.state.anchors[index];
                anchor.z.copy_from_slice(&self.tracks[index].z);
                anchor.form = form;
            }
            if system.rigid {
                let t = self.state.anchors[index].translation;
                self.state.anchors[index].translation =
                    translation([t.0[0], t.0[1]], &system.gains, &self.state.loads);
            }
        }
    }
}
