//! Transitions of the exact waves: contact, rock, relay.

use super::scene::Mean;
use super::{Collision, LIVES, Rock, Waves};

impl Waves {
    /// Performs all transitions at this instant: contact, rock, relay.
    pub(super) fn settle(&mut self) {
        for _ in 0..20 {
            let (piston, bit) =
                (self.bodies[0].bottom().after(self.time), self.bodies[1].top().after(self.time));
            let speed = self.approach(piston, bit, self.frame);
            let rigid = self.scene.penalty.is_infinite();
            let parted = if rigid { speed < -self.tiny[1] } else { self.gap >= 0.9 * self.small() };
            if !self.closed && self.gap <= 0.5 * self.small() && speed > self.tiny[1] {
                self.close();
            } else if self.closed && parted {
                self.closed = false;
                if let Some(last) = self.collisions.last_mut() {
                    last.end = self.time;
                }
            } else if !self.settle_rock() && !self.settle_relay() {
                return;
            }
        }
        panic!("endless transitions at {}", self.time);
    }

    fn close(&mut self) {
        (self.closed, self.gap) = (true, 0.0);
        let (start, end) = (self.time, f64::INFINITY);
        let speed = self.means[0].velocity - self.means[1].velocity;
        self.collisions.push(Collision { start, end, push: 0.0, impulse: 0.0, speed });
        self.start_jump(LIVES);
    }

    /// The tip's velocity after this instant.
    fn rate(&self) -> f64 {
        let ([ease, decay], [_, _, origin]) = (self.yielding(), self.line());
        let drive = 2.0 * self.bodies[1].bottom().after(self.time) + self.frame[1];
        ease * drive - decay * (self.tip - origin)
    }

    fn settle_rock(&mut self) -> bool {
        let s = &self.scene;
        let (barrier, ratio, viscosity) = (s.barrier, s.ratio, s.viscosity);
        let [slow, little] = s.standstill;
        if s.stiffness == 0.0 {
            return false;
        }
        let rate = self.rate();
        let (tiny, small) = (self.tiny[1], self.small());
        let before = self.rock;
        match self.rock {
            Rock::Free if self.tip >= self.lower - small && rate > tiny => self.drill(self.lower),
            Rock::Viscous if self.psi >= barrier => self.rock = Rock::Forward,
            Rock::Viscous | Rock::Forward if rate < -tiny => {
                let upper = self.tip - (self.tip - self.lower) / ratio;
                self.gain = upper - self.upper;
                (self.upper, self.rock) = (upper, Rock::Backward);
            }
            Rock::Backward | Rock::Still if self.tip <= self.upper + small && rate < tiny => {
                (self.rock, self.lower) = (Rock::Free, self.upper);
            }
            Rock::Backward if rate > tiny => {
                if self.gain < little {
                    self.rock = Rock::Still;
                } else {
                    self.drill(self.tip - ratio * (self.tip - self.upper));
                }
            }
            Rock::Still if rate > slow + tiny => {
                self.drill(self.tip - ratio * (self.tip - self.upper));
            }
            Rock::Still if rate < -slow - tiny => self.rock = Rock::Backward,
            _ => {}
        }
        // A viscous force begins or ends with a jump.
        if viscosity > 0.0 && (before == Rock::Viscous) != (self.rock == Rock::Viscous) {
            self.start_jump(LIVES);
        }
        self.rock != before
    }

    fn drill(&mut self, lower: f64) {
        (self.lower, self.rock, self.psi) = (lower, Rock::Viscous, 0.0);
    }

    pub(super) fn relative(&self, means: [Mean; 2]) -> f64 {
        means[0].position - means[1].position - self.scene.gap
    }

    fn settle_relay(&mut self) -> bool {
        let (vr, tiny) = (self.relative(self.means), self.small());
        let rate = self.means[0].velocity - self.means[1].velocity;
        if self.down && vr >= -tiny && rate > 0.0 {
            self.down = false;
            self.returns.push(self.time);
            self.depths.push(self.upper);
            return true;
        }
        let back = !self.down && vr + self.scene.drive[1] <= tiny && rate < 0.0;
        self.down |= back;
        back
    }
}
