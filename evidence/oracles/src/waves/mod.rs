//! Exact waves: the continuum that every mesh approximates, by characteristics.
//!
//! Each section of a bar is a pair of delay lines that carry d'Alembert's waves. The contact is a one-sided junction,
//! rigid or a spring; the rock is the law of five modes; the loads are uniform accelerations, removed by a falling
//! frame. In undamped bars jumps are followed exactly from end to end, and between them a wave is linear in each
//! step. In damped bars a wave is spread as Kelvin-Voigt damping spreads it. The error falls with the square of the
//! step. Nothing of the engine is used.

mod body;
pub mod line;
mod scene;
mod settle;

use body::Body;
use line::{Line, Sharp, Spread};
use scene::Jump;
pub use scene::{Collision, Mean, Rock, Scene, Section};
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
    bodies: [Body; 2],
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
    /// Work that the rock keeps, without what the viscosity takes.
    pub dissipated: f64,
    /// Largest rock force.
    pub peak: f64,
    /// Largest contact force.
    pub contact_peak: f64,
    /// Collisions so far.
    pub collisions: Vec<Collision>,
    /// Instants at which the relay turned to return.
    pub returns: Vec<f64>,
    /// Hole depth at each of these.
    pub depths: Vec<f64>,
}

/// Conditions that may change sign within a step.
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
    /// `steps` are the steps of one transit of the piston. Each section of damped bars has a whole number of them.
    pub fn new(scene: Scene, steps: u32) -> Self {
        let [tp, _] = scene.transits();
        let tiny = [ROUNDING[0] * tp, ROUNDING[1] * scene.scale()];
        let press = scene.feed + scene.masses()[1] * scene.gravity;
        let [vp, vb] = scene.speed;
        let line = |transit: f64, content: [f64; 2]| {
            if scene.damping == 0.0 {
                return Line::Sharp(Sharp::new(transit, tiny[0], content));
            }
            let cell = tp / f64::from(steps);
            let cells = (transit / cell).round() as usize;
            Line::Spread(Spread::new(cells, cell, scene.damping, content))
        };
        // The preloaded bit: compression `FS` at its top, `FS + Mb G` at its tip.
        let bodies = [
            Body::new(&scene.bodies[0], (vp, 0.0, 0.0), line),
            Body::new(&scene.bodies[1], (vb, scene.feed, scene.gravity), line),
        ];
        let held = scene.stiffness > 0.0 && press > 0.0;
        let tip = if held { press / (scene.ratio * scene.stiffness) } else { 0.0 };
        Self {
            step: tp / f64::from(steps),
            ticks: 0,
            tiny,
            bodies,
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
            dissipated: 0.0,
            peak: 0.0,
            contact_peak: 0.0,
            collisions: Vec::new(),
            returns: Vec::new(),
            depths: Vec::new(),
            scene,
        }
    }

    /// Present waves downward and upward in a section of piston (0) or bit (1), undamped, at a fraction of its length
    /// below its top. Their sum is the velocity in the falling frame, and their difference times the impedance the
    /// pressing force.
    pub fn inside(&self, body: usize, section: usize, part: f64) -> [f64; 2] {
        self.bodies[body].inside(self.time, section, part)
    }

    /// Steps until the end of a step is at or past `until`.
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
        if self.scene.damping > 0.0 {
            return; // a damped bar spreads a jump before it is back
        }
        for section in self.scene.bodies.iter().flatten() {
            self.jumps.push(Jump { time: self.time + section.transit, lives });
        }
    }

    /// Jumps that are now at an end leave it for every end, whatever their origin.
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

    /// Speed at which open faces approach, by the arriving waves.
    fn approach(&self, piston: f64, bit: f64, frames: [f64; 2]) -> f64 {
        2.0 * (piston - bit) + frames[0] - frames[1] - self.scene.feed / self.scene.ends()[1]
    }

    /// A length that counts as zero.
    fn small(&self) -> f64 {
        self.tiny[0] * self.scene.scale()
    }

    /// Delay with which a damped bar yields to a force: its impedance is `Z sqrt(1 + i beta w)`, to first order a
    /// delay of `beta / 2`. The differential equations of the junctions keep that order; transients of `beta / 2`
    /// after a jump are neglected.
    fn lag(&self) -> f64 {
        0.5 * self.scene.damping
    }

    /// Gap and contact force `t` into the step.
    fn meet(&self, step: &Step, t: f64) -> [f64; 2] {
        let speed =
            [0, 1].map(|k| self.approach(step.piston[k], step.bit[k], step.frames.map(|f| f[k])));
        let slope = (speed[1] - speed[0]) / step.span;
        if !self.closed {
            [self.gap - (speed[0] + 0.5 * slope * t) * t, 0.0]
        } else if self.scene.penalty.is_infinite() {
            [0.0, self.scene.meeting() * (speed[0] + slope * t)]
        } else {
            // The faces' overlap d obeys d' = speed - F / Z with F = KC d, and F is delayed by `lag`.
            let decay = self.scene.penalty / self.scene.meeting();
            let ease = 1.0 / (1.0 - self.lag() * decay);
            let drive = [speed[0] * ease, slope * ease];
            let [overlap, _] = relaxed(-self.gap, decay * ease, drive, t);
            [-overlap, self.scene.penalty * overlap]
        }
    }

    fn acceleration(&self) -> [f64; 2] {
        let alpha = if self.down { 1.0 } else { -1.0 };
        let g = self.scene.gravity;
        [alpha * self.scene.drive[0] / self.scene.masses()[0] + g, g]
    }

    fn gather(&self, end: f64) -> Step {
        let span = end - self.time;
        let ends = |line: &Line| [line.after(self.time), line.before(end)];
        let a = self.acceleration();
        let [stiffness, _, origin] = self.line();
        Step {
            span,
            piston: ends(self.bodies[0].bottom()),
            bit: ends(self.bodies[1].top()),
            incident: ends(self.bodies[1].bottom()),
            frames: [0, 1].map(|i| [self.frame[i], self.frame[i] + a[i] * span]),
            stiffness,
            origin,
        }
    }

    /// The indentation's rate is the first number times `2 d + frame`, less the second times the indentation. Damping
    /// delays the viscous force too; this would make the rate jump with the mode, and is neglected: it shifts a front
    /// by `lag` while the rock is viscous.
    fn yielding(&self) -> [f64; 2] {
        let [k, c, _] = self.line();
        let [.., z] = self.scene.ends();
        let ease = z / (z + c - self.lag() * k * z / (z + c));
        [ease, k / z * ease]
    }

    /// Indentation and its rate `t` into the step.
    fn relax(&self, step: &Step, t: f64) -> [f64; 2] {
        let [ease, decay] = self.yielding();
        let ends = [0, 1].map(|i| ease * (2.0 * step.incident[i] + step.frames[1][i]));
        relaxed(self.tip - step.origin, decay, [ends[0], (ends[1] - ends[0]) / step.span], t)
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

    /// Contact and rock force from now to `t` into the step. Each is linear, with the force's own impulse, which
    /// follows from the motion of faces and tip. Otherwise the means would drift from the faces blow after blow, and
    /// the relay depends on the means.
    fn chords(&self, step: &Step, t: f64) -> [[f64; 2]; 2] {
        let [.., z] = self.scene.ends();
        let at = |x: [f64; 2]| x[0] + (x[1] - x[0]) * t / step.span;
        let ends = [0.0, t].map(|x| self.meet(step, x));
        let reach = [0.0, t].map(|x| self.relax(step, x));
        let frames = [step.frames.map(|f| f[0]), step.frames.map(at)];
        let speeds = self.approach(step.piston[0], step.bit[0], frames[0])
            + self.approach(at(step.piston), at(step.bit), frames[1]);
        let drives = 2.0 * (step.incident[0] + at(step.incident)) + frames[0][1] + frames[1][1];
        let impulses = [
            self.scene.meeting() * (0.5 * speeds * t + ends[1][0] - ends[0][0]),
            z * (0.5 * drives * t - reach[1][0] + reach[0][0]),
        ];
        let forces = [ends.map(|e| e[1]), reach.map(|r| self.push(r))];
        // In a very short step the motion is rounding, and the end values are as good.
        if t < 0.01 * self.step {
            return forces;
        }
        [0, 1].map(|i| {
            let [first, last] = forces[i];
            let more = impulses[i] / t - 0.5 * (first + last);
            [first + more, last + more]
        })
    }

    /// Means `t` into the step.
    fn carried(&self, step: &Step, t: f64) -> [Mean; 2] {
        let [[first, last], rock] = self.chords(step, t);
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

    /// Whether any condition has changed sign `t` into the step.
    fn signs(&self, step: &Step, t: f64) -> bool {
        let at = |x: [f64; 2]| x[0] + (x[1] - x[0]) * t / step.span;
        let speed = self.approach(at(step.piston), at(step.bit), step.frames.map(at));
        let tiny = self.tiny[1];
        let gap = self.meet(step, t)[0];
        let contact = if !self.closed {
            gap < 0.0 && speed > tiny
        } else if self.scene.penalty.is_infinite() {
            speed < -tiny
        } else {
            gap > self.small()
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
        let (vr, rise) = (self.relative(means), means[0].velocity - means[1].velocity);
        let relay = if self.down {
            vr > 0.0 && rise > 0.0
        } else {
            vr + self.scene.drive[1] < 0.0 && rise < 0.0
        };
        contact || rock || relay
    }

    /// The first change of sign up to `end`, otherwise `end`.
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

    /// Ends a step without changes of sign.
    fn commit(&mut self, end: f64) {
        let step = self.gather(end);
        let (time, span) = (self.time, step.span);
        let top = self.bodies[0].top();
        let top = [top.after(time), top.before(end)];
        let reach = [self.relax(&step, 0.0), self.relax(&step, span)];
        let [force, rock] = self.chords(&step, span);
        let frames = |k: usize| step.frames.map(|f| f[k]);
        if self.rock == Rock::Viscous {
            self.psi += self.viscous_work(&step, span);
        }
        if matches!(self.rock, Rock::Viscous | Rock::Forward) {
            let dissipated = (1.0 - 1.0 / self.scene.ratio) * step.stiffness;
            self.dissipated += 0.5 * dissipated * (reach[1][0].powi(2) - reach[0][0].powi(2));
        }
        let met = [0.0, span].map(|t| self.meet(&step, t));
        self.note_force(force, met[0][1].max(met[1][1]), span);
        self.means = self.carried(&step, span);
        self.gap = met[1][0];
        let [face, anvil, tip] = self.scene.ends();
        let sent = |wave: [f64; 2], force: [f64; 2], impedance: f64| {
            [0, 1].map(|k| wave[k] + force[k] / impedance)
        };
        self.bodies[0].send(time, end, [top, sent(step.piston, force.map(|f| -f), face)]);
        let shoulder = sent(step.bit, force.map(|f| f + self.scene.feed), anvil);
        self.bodies[1].send(time, end, [shoulder, sent(step.incident, rock.map(|f| -f), tip)]);
        self.peak = reach.iter().map(|r| self.push(*r)).fold(self.peak, f64::max);
        self.tip = step.origin + reach[1][0];
        self.frame = frames(1);
        self.time = end;
    }

    fn note_force(&mut self, force: [f64; 2], large: f64, span: f64) {
        self.contact_peak = self.contact_peak.max(large);
        if let Some(last) = self.collisions.last_mut().filter(|_| self.closed) {
            last.impulse += 0.5 * (force[0] + force[1]) * span;
            // Faces may stay together without force, which rounding must not hide.
            let felt = 1e3 * self.tiny[1] * self.scene.meeting();
            last.push += if large > felt { span } else { 0.0 };
        }
    }
}

/// The solution of `x' = rate + slope t - decay x` and its rate, `t` after `start`.
fn relaxed(start: f64, decay: f64, [rate, slope]: [f64; 2], t: f64) -> [f64; 2] {
    if decay == 0.0 {
        return [start + (rate + 0.5 * slope * t) * t, rate + slope * t];
    }
    let offset = (rate - slope / decay) / decay;
    let left = (start - offset) * (-decay * t).exp();
    [offset + slope * t / decay + left, slope / decay - decay * left]
}
