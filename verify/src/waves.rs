//! Exact waves: the continuum that every mesh approximates, by characteristics.
//!
//! Each bar is a pair of delay lines that carry d'Alembert's waves; the contact is a rigid
//! unilateral junction, the rock the five-mode law, the loads uniform accelerations
//! removed by a falling frame. Jumps of a wave are followed exactly from end to end;
//! between them a wave is a chord a step, so the error falls with the square of the step.
//! Nothing of the engine is used but the parameters' numbers.

use crate::continuum::Jump;
pub use crate::continuum::{Collision, Mean, Rock, Scene};
use crate::line::Line;
use std::collections::BinaryHeap;

/// Transits for which a jump is followed.
const LIVES: u32 = 60;
/// Rounding, relative to a transit (times reach 1e5 of them) and to the scene's speed.
const ROUNDING: [f64; 2] = [1e-10, 1e-12];

/// A scene followed along characteristics.
#[derive(Clone, Debug)]
pub struct Waves {
    scene: Scene,
    step: f64,
    ticks: u64,
    tiny: [f64; 2],
    lines: [[Line; 2]; 2],
    jumps: BinaryHeap<Jump>,
    closed: bool,
    down: bool,
    rock: Rock,
    /// Velocity of each bar's frame.
    frame: [f64; 2],
    gap: f64,
    tip: f64,
    lower: f64,
    upper: f64,
    gain: f64,
    psi: f64,
    /// Present time.
    pub time: f64,
    /// Mean motion of piston and bit.
    pub means: [Mean; 2],
    /// Work that the rock keeps, without the viscous part.
    pub kept: f64,
    /// Work of the viscosity.
    pub viscous: f64,
    /// Largest rock force.
    pub peak: f64,
    /// Largest contact force.
    pub contact_peak: f64,
    /// Last lift-off from the rock.
    pub lifted: f64,
    /// Collisions so far.
    pub collisions: Vec<Collision>,
    /// Instants at which the relay turned to return.
    pub returns: Vec<f64>,
    /// Hole depth at each of these.
    pub depths: Vec<f64>,
    /// Entries into drilling.
    pub cycles: u64,
}

/// What may change sign within a step.
struct Step {
    span: f64,
    piston: [f64; 2],
    bit: [f64; 2],
    incident: [f64; 2],
    frames: [[f64; 2]; 2],
    stiffness: f64,
    origin: f64,
}

impl Waves {
    /// `steps` steps a transit of the piston.
    pub fn new(scene: Scene, steps: u32) -> Self {
        let [tp, tb] = scene.transit;
        let tiny = [ROUNDING[0] * tp, ROUNDING[1] * scene.scale()];
        let weight = scene.masses()[1] * scene.gravity;
        let press = scene.feed + weight;
        let (z2, half) = (2.0 * scene.impedance, 0.5);
        let [vp, vb] = scene.speed;
        // The preloaded bit: compression `FS` at its top, `FS + Mb G` at its tip.
        let slope = weight / (z2 * tb);
        let down = Line::new(tb, tiny[0], half * vb + scene.feed / z2, -slope);
        let up = Line::new(tb, tiny[0], half * vb - press / z2, -slope);
        let free = || Line::new(tp, tiny[0], half * vp, 0.0);
        let held = scene.stiffness > 0.0 && press > 0.0;
        let tip = if held { press / (scene.ratio * scene.stiffness) } else { 0.0 };
        Self {
            scene,
            step: tp / f64::from(steps),
            ticks: 0,
            tiny,
            lines: [[free(), free()], [down, up]],
            jumps: BinaryHeap::from([Jump { time: 0.0, lives: LIVES }]),
            closed: false,
            down: true,
            rock: if held { Rock::Still } else { Rock::Free },
            frame: [0.0; 2],
            gap: scene.gap,
            tip,
            lower: 0.0,
            upper: 0.0,
            gain: 0.0,
            psi: 0.0,
            time: 0.0,
            means: [Mean { position: 0.0, velocity: vp }, Mean { position: 0.0, velocity: vb }],
            kept: 0.0,
            viscous: 0.0,
            peak: 0.0,
            contact_peak: 0.0,
            lifted: f64::INFINITY,
            collisions: Vec::new(),
            returns: Vec::new(),
            depths: Vec::new(),
            cycles: 0,
        }
    }

    /// Hole depth.
    pub fn depth(&self) -> f64 {
        self.upper
    }

    /// Present mode of the rock.
    pub fn rock(&self) -> Rock {
        self.rock
    }

    /// Steps to the first step's end at or past `until`.
    pub fn advance(&mut self, until: f64) {
        while self.time < until - self.tiny[0] {
            self.settle();
            self.pass_jumps();
            while self.ticks as f64 * self.step <= self.time + self.tiny[0] {
                self.ticks += 1;
            }
            let jump = self.jumps.peek().map_or(f64::INFINITY, |j| j.time);
            let end = self.first_event((self.ticks as f64 * self.step).min(jump));
            self.commit(end);
        }
    }

    fn start_jump(&mut self, lives: u32) {
        for transit in self.scene.transit {
            self.jumps.push(Jump { time: self.time + transit, lives });
        }
    }

    /// Jumps that are at an end now leave for every end: where they came from is all one.
    fn pass_jumps(&mut self) {
        let mut lives = None;
        while let Some(jump) = self.jumps.peek().filter(|j| j.time <= self.time + self.tiny[0]) {
            lives = lives.max(Some(jump.lives));
            self.jumps.pop();
        }
        if let Some(lives) = lives.filter(|&l| l > 0) {
            self.start_jump(lives - 1);
        }
    }

    /// Stiffness, viscosity and origin of the rock's line.
    fn line(&self) -> [f64; 3] {
        let s = &self.scene;
        match self.rock {
            Rock::Free => [0.0, 0.0, 0.0],
            Rock::Viscous => [s.stiffness, s.viscosity, self.lower],
            Rock::Forward => [s.stiffness, 0.0, self.lower],
            Rock::Backward | Rock::Still => [s.ratio * s.stiffness, 0.0, self.upper],
        }
    }

    /// Force with which closed faces meet, from the waves that arrive.
    fn force(&self, piston: f64, bit: f64, frames: [f64; 2]) -> f64 {
        let z = self.scene.impedance;
        0.5 * z * (2.0 * (piston - bit) + frames[0] - frames[1]) - 0.5 * self.scene.feed
    }

    /// Speed at which open faces approach.
    fn approach(&self, piston: f64, bit: f64, frames: [f64; 2]) -> f64 {
        2.0 * self.force(piston, bit, frames) / self.scene.impedance
    }

    fn acceleration(&self) -> [f64; 2] {
        let alpha = if self.down { 1.0 } else { -1.0 };
        let g = self.scene.gravity;
        [alpha * self.scene.drive[0] / self.scene.masses()[0] + g, g]
    }

    /// Transitions at this instant: contact, rock, relay.
    fn settle(&mut self) {
        for _ in 0..20 {
            let (piston, bit) =
                (self.lines[0][0].after(self.time), self.lines[1][1].after(self.time));
            let speed = self.approach(piston, bit, self.frame);
            if !self.closed && self.gap <= self.tiny[0] * self.scene.scale() && speed > self.tiny[1]
            {
                (self.closed, self.gap) = (true, 0.0);
                let infinity = f64::INFINITY;
                let start = self.time;
                self.collisions.push(Collision { start, end: infinity, push: 0.0, impulse: 0.0 });
                self.start_jump(LIVES);
            } else if self.closed && speed < -self.tiny[1] {
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

    fn rate(&self, q: f64, incident: f64, frame: f64) -> f64 {
        let [k, c, _] = self.line();
        (self.scene.impedance * (2.0 * incident + frame) - k * q) / (self.scene.impedance + c)
    }

    fn settle_rock(&mut self) -> bool {
        let s = self.scene;
        if s.stiffness == 0.0 {
            return false;
        }
        let incident = self.lines[1][0].after(self.time);
        let [_, _, origin] = self.line();
        let rate = self.rate(self.tip - origin, incident, self.frame[1]);
        let (tiny, small) = (self.tiny[1], self.tiny[0] * s.scale());
        let before = self.rock;
        match self.rock {
            Rock::Free if self.tip >= self.lower - small && rate > tiny => self.drill(self.lower),
            Rock::Viscous if self.psi >= s.barrier => self.rock = Rock::Forward,
            Rock::Viscous | Rock::Forward if rate < -tiny => {
                let upper = self.tip - (self.tip - self.lower) / s.ratio;
                self.gain = upper - self.upper;
                (self.upper, self.rock) = (upper, Rock::Backward);
            }
            Rock::Backward | Rock::Still if self.tip <= self.upper + small && rate < tiny => {
                (self.rock, self.lower, self.lifted) = (Rock::Free, self.upper, self.time);
            }
            Rock::Backward if rate > tiny => {
                if self.gain < s.standstill[1] {
                    self.rock = Rock::Still;
                } else {
                    self.drill(self.tip - s.ratio * (self.tip - self.upper));
                }
            }
            Rock::Still if rate > s.standstill[0] + tiny => {
                self.drill(self.tip - s.ratio * (self.tip - self.upper));
            }
            Rock::Still if rate < -s.standstill[0] - tiny => self.rock = Rock::Backward,
            _ => {}
        }
        // A viscous force starts or ends at once.
        if s.viscosity > 0.0 && (before == Rock::Viscous) != (self.rock == Rock::Viscous) {
            self.start_jump(LIVES);
        }
        self.rock != before
    }

    fn drill(&mut self, lower: f64) {
        (self.lower, self.rock, self.psi) = (lower, Rock::Viscous, 0.0);
        self.cycles += 1;
    }

    fn relative(&self, means: [Mean; 2]) -> f64 {
        means[0].position - means[1].position - self.scene.gap
    }

    fn settle_relay(&mut self) -> bool {
        let (vr, tiny) = (self.relative(self.means), self.tiny[0] * self.scene.scale());
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

    fn gather(&self, end: f64) -> Step {
        let span = end - self.time;
        let ends = |line: &Line| [line.after(self.time), line.before(end)];
        let a = self.acceleration();
        let [stiffness, _, origin] = self.line();
        Step {
            span,
            piston: ends(&self.lines[0][0]),
            bit: ends(&self.lines[1][1]),
            incident: ends(&self.lines[1][0]),
            frames: [0, 1].map(|i| [self.frame[i], self.frame[i] + a[i] * span]),
            stiffness,
            origin,
        }
    }

    /// Indentation and its rate `t` into the step.
    fn relax(&self, step: &Step, t: f64) -> [f64; 2] {
        let drive = |k: usize| 2.0 * step.incident[k] + step.frames[1][k];
        let (first, slope) = (drive(0), (drive(1) - drive(0)) / step.span);
        let q = self.tip - step.origin;
        if step.stiffness == 0.0 {
            return [q + (first + 0.5 * slope * t) * t, first + slope * t];
        }
        let [k, c, _] = self.line();
        let z = self.scene.impedance;
        let decay = k / (z + c);
        let (first, slope) = (first * z / k, slope * z / k);
        let offset = first - slope / decay;
        let left = (q - offset) * (-decay * t).exp();
        [offset + slope * t + left, slope - decay * left]
    }

    /// Rock force at an indentation and rate.
    fn push(&self, [q, rate]: [f64; 2]) -> f64 {
        let [k, c, _] = self.line();
        k * q + c * rate
    }

    /// Viscous work `t` into the step, by Simpson's rule.
    fn viscous_work(&self, step: &Step, t: f64) -> f64 {
        let [_, c, _] = self.line();
        let square = |x: f64| self.relax(step, x)[1].powi(2);
        c * t / 6.0 * (square(0.0) + 4.0 * square(0.5 * t) + square(t))
    }

    /// Means `t` into the step, and the forces at its ends.
    fn carried(&self, step: &Step, t: f64) -> [Mean; 2] {
        let at = |x: [f64; 2]| x[0] + (x[1] - x[0]) * t / step.span;
        let frames = step.frames.map(at);
        let (first, last) = if self.closed {
            let frames0 = step.frames.map(|f| f[0]);
            (
                self.force(step.piston[0], step.bit[0], frames0),
                self.force(at(step.piston), at(step.bit), frames),
            )
        } else {
            (0.0, 0.0)
        };
        let rock = [self.push(self.relax(step, 0.0)), self.push(self.relax(step, t))];
        let [mp, mb] = self.scene.masses();
        let [ap, ab] = self.acceleration();
        let shoulder = self.scene.feed;
        [
            self.means[0].after(t, [ap - first / mp, ap - last / mp]),
            self.means[1].after(
                t,
                [(first, rock[0]), (last, rock[1])].map(|(f, r)| ab + (f + shoulder - r) / mb),
            ),
        ]
    }

    /// Whether anything has changed sign `t` into the step.
    fn signs(&self, step: &Step, t: f64) -> bool {
        let at = |x: [f64; 2]| x[0] + (x[1] - x[0]) * t / step.span;
        let speed = self.approach(at(step.piston), at(step.bit), step.frames.map(at));
        let tiny = self.tiny[1];
        let contact = if self.closed {
            speed < -tiny
        } else {
            let first = self.approach(step.piston[0], step.bit[0], step.frames.map(|f| f[0]));
            self.gap - 0.5 * (first + speed) * t < 0.0 && speed > tiny
        };
        let [q, rate] = self.relax(step, t);
        let [vs, _] = self.scene.standstill;
        let rock = match self.rock {
            Rock::Free => self.scene.stiffness > 0.0 && q > self.lower && rate > 0.0,
            Rock::Viscous => {
                rate < -tiny || self.psi + self.viscous_work(step, t) > self.scene.barrier
            }
            Rock::Forward => rate < -tiny,
            Rock::Backward => q < 0.0 || rate > tiny,
            Rock::Still => q < 0.0 || rate > vs + tiny || rate < -vs - tiny,
        };
        let means = self.carried(step, t);
        let (vr, climb) = (self.relative(means), means[0].velocity - means[1].velocity);
        let relay = if self.down {
            vr > 0.0 && climb > 0.0
        } else {
            vr + self.scene.drive[1] < 0.0 && climb < 0.0
        };
        contact || rock || relay
    }

    /// The first change of sign up to `end`, or `end`.
    fn first_event(&self, end: f64) -> f64 {
        let step = self.gather(end);
        if !self.signs(&step, step.span) {
            return end;
        }
        let (mut low, mut high) = (0.0, step.span);
        while high - low > 0.1 * self.tiny[0] {
            let middle = 0.5 * (low + high);
            if self.signs(&step, middle) { high = middle } else { low = middle }
        }
        self.time + high
    }

    /// Commits a step in which nothing changes its status.
    fn commit(&mut self, end: f64) {
        let step = self.gather(end);
        let (time, span, z) = (self.time, step.span, self.scene.impedance);
        let top = [self.lines[0][1].after(time), self.lines[0][1].before(end)];
        let reach = [self.relax(&step, 0.0), self.relax(&step, span)];
        let rock = reach.map(|r| self.push(r));
        let frames = |k: usize| step.frames.map(|f| f[k]);
        let force = [0, 1].map(|k| {
            if self.closed { self.force(step.piston[k], step.bit[k], frames(k)) } else { 0.0 }
        });
        let shoulder = force.map(|f| (f + self.scene.feed) / z);
        if self.rock == Rock::Viscous {
            let work = self.viscous_work(&step, span);
            self.psi += work;
            self.viscous += work;
        }
        if matches!(self.rock, Rock::Viscous | Rock::Forward) {
            let kept = (1.0 - 1.0 / self.scene.ratio) * step.stiffness;
            self.kept += 0.5 * kept * (reach[1][0].powi(2) - reach[0][0].powi(2));
        }
        self.note_force(force, span);
        if !self.closed {
            let speed = [0, 1].map(|k| self.approach(step.piston[k], step.bit[k], frames(k)));
            self.gap -= 0.5 * (speed[0] + speed[1]) * span;
        }
        self.means = self.carried(&step, span);
        self.lines[0][0].send(time, end, top[0], top[1]);
        self.lines[0][1].send(
            time,
            end,
            step.piston[0] - force[0] / z,
            step.piston[1] - force[1] / z,
        );
        self.lines[1][0].send(time, end, step.bit[0] + shoulder[0], step.bit[1] + shoulder[1]);
        self.lines[1][1].send(
            time,
            end,
            step.incident[0] - rock[0] / z,
            step.incident[1] - rock[1] / z,
        );
        self.peak = self.peak.max(rock[0]).max(rock[1]);
        self.tip = step.origin + reach[1][0];
        self.frame = frames(1);
        self.time = end;
    }

    fn note_force(&mut self, force: [f64; 2], span: f64) {
        let large = force[0].max(force[1]);
        self.contact_peak = self.contact_peak.max(large);
        if let Some(last) = self.collisions.last_mut().filter(|_| self.closed) {
            last.impulse += 0.5 * (force[0] + force[1]) * span;
            // Faces may stay together without force: rounding is no push.
            let felt = 1e3 * self.tiny[1] * self.scene.impedance;
            last.push += if large > felt { span } else { 0.0 };
        }
    }
}
