//! Which guards each mode watches.

use crate::machine::{Event, Machine};
use crate::modal::model;
use crate::numerics::poly::Poly;
use crate::physics::mode::{Relay, RockMode};
use crate::physics::parameters::Source;
use crate::physics::rock::RockEvent;
use crate::search::barrier::Barrier;
use crate::search::guard::{Guard, Part, Watch};

impl Machine {
    /// Watches the guards of the present mode, from the epoch on.
    pub(crate) fn arm(&mut self) {
        use RockEvent::{Lift, Restart, Retreat, Return, Touch, Turn};
        self.watches.clear();
        self.views = Default::default();
        self.search_start = self.work.evaluations;
        let closed = self.state.mode.closed;
        self.watch(Event::Contact, model::GAP, 0, if closed { 1.0 } else { -1.0 }, 0.0);
        let rock = self.model.parameters.rock;
        let vs = rock.standstill_speed;
        let rules: &[(RockEvent, usize, f64, f64)] = match self.state.mode.rock {
            RockMode::FreeFlight => &[(Touch, 0, 1.0, 0.0)],
            RockMode::DissipativeForward | RockMode::Forward => &[(Turn, 1, -1.0, 0.0)],
            RockMode::Backward => &[(Lift, 0, -1.0, 0.0), (Return, 1, 1.0, 0.0)],
            RockMode::Standstill => {
                &[(Lift, 0, -1.0, 0.0), (Restart, 1, 1.0, vs), (Retreat, 1, -1.0, vs)]
            }
        };
        for &(event, order, factor, level) in rules {
            self.watch(Event::Rock(event), model::TIP, order, factor, level);
        }
        if self.model.parameters.drive.source == Source::Relay {
            match self.state.mode.relay {
                Relay::Drive => self.watch(Event::Relay, model::RELATIVE, 0, 1.0, 0.0),
                Relay::Return => {
                    self.watch(
                        Event::Relay,
                        model::RELATIVE,
                        0,
                        -1.0,
                        self.model.parameters.drive.stroke,
                    );
                }
            }
        }
        self.barrier = (self.state.mode.rock == RockMode::DissipativeForward).then(|| {
            Barrier::new(&self.tracks[0], rock.energy_barrier - self.state.psi, rock.viscosity)
        });
    }

    /// Watches `factor * u - level` rising through zero.
    pub(crate) fn watch(
        &mut self,
        event: Event,
        functional: usize,
        order: usize,
        factor: f64,
        level: f64,
    ) {
        let mut parts = [Some(Part { track: 0, functional, factor }), None];
        if !self.state.mode.closed {
            let other = match functional {
                model::GAP => Some(model::PISTON_GAP),
                model::RELATIVE => Some(model::PISTON_ALONE_MEAN),
                _ => None,
            };
            parts[1] = other.map(|functional| Part { track: 1, functional, factor });
        }
        let mut poly = Poly::default();
        for part in parts.iter().flatten() {
            let f = &self.tracks[part.track].system.functionals[part.functional];
            poly = poly.plus(
                factor,
                &f.poly(&self.state.loads, &self.state.anchors[part.track].translation),
            );
        }
        if order == 1 {
            poly = poly.derivative();
        }
        poly.0[0] -= level;
        let resolution = self.model.parameters.resolutions()[order];
        self.watches.push((event, Watch::new(Guard::new(poly, parts, order, resolution), 0.0)));
    }

    /// True if the piston rests on the bit and, the loads staying as they are, neither the
    /// contact can open nor the relay switch: a state that the law never leaves.
    pub fn stalled(&self) -> bool {
        if !self.state.mode.closed || self.model.parameters.drive.source != Source::Relay {
            return false;
        }
        let tracks = self.present();
        let never = |event: Event| {
            self.watches.iter().any(|(e, w)| *e == event && w.found.is_none() && w.never(&tracks))
        };
        never(Event::Contact) && never(Event::Relay)
    }
}
