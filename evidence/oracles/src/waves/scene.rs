//! Input and results of exact waves: scenes, modes, collisions, mean motion.

/// A uniform stretch of a bar.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Impedance.
    pub impedance: f64,
    /// Transit time.
    pub transit: f64,
}

/// A piston and a bit. SI units, or any consistent ones.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Sections of piston and bit, top to bottom.
    pub bodies: [Vec<Section>; 2],
    /// Kelvin-Voigt damping time `beta`.
    pub damping: f64,
    /// Contact stiffness `KC`; infinite for rigid faces.
    pub penalty: f64,
    /// `KR`; 0 leaves the bit's lower end free.
    pub stiffness: f64,
    /// `gamma`.
    pub ratio: f64,
    /// `CR`.
    pub viscosity: f64,
    /// `WR`.
    pub barrier: f64,
    /// `vs` and `dps`.
    pub standstill: [f64; 2],
    /// Relay amplitude and stroke.
    pub drive: [f64; 2],
    /// Feed force.
    pub feed: f64,
    /// Gravity.
    pub gravity: f64,
    /// Initial gap.
    pub gap: f64,
    /// Initial velocities of piston and bit.
    pub speed: [f64; 2],
}

impl Scene {
    /// A unit piston that touches a bit of length `bit` on virgin rock, and nothing else.
    pub fn unit(kappa: f64, gamma: f64, bit: f64) -> Self {
        let uniform = |transit| vec![Section { impedance: 1.0, transit }];
        Self {
            bodies: [uniform(1.0), uniform(bit)],
            damping: 0.0,
            penalty: f64::INFINITY,
            stiffness: kappa,
            ratio: gamma,
            viscosity: 0.0,
            barrier: 0.0,
            standstill: [0.0; 2],
            drive: [0.0, 1.0],
            feed: 0.0,
            gravity: 0.0,
            gap: 0.0,
            speed: [1.0, 0.0],
        }
    }

    /// Sums over the sections of piston and bit.
    fn sums(&self, of: impl Fn(&Section) -> f64) -> [f64; 2] {
        self.bodies.each_ref().map(|sections| sections.iter().map(&of).sum())
    }

    /// Masses of piston and bit.
    pub fn masses(&self) -> [f64; 2] {
        self.sums(|section| section.impedance * section.transit)
    }

    pub(super) fn transits(&self) -> [f64; 2] {
        self.sums(|section| section.transit)
    }

    /// Impedances of the piston's face, of the bit's, and of its tip.
    pub(super) fn ends(&self) -> [f64; 3] {
        let [piston, bit] = &self.bodies;
        [&piston[piston.len() - 1], &bit[0], &bit[bit.len() - 1]].map(|section| section.impedance)
    }

    /// The faces' impedance: their speed of approach over the force that stops it.
    pub(super) fn meeting(&self) -> f64 {
        let [piston, bit, _] = self.ends();
        piston * bit / (piston + bit)
    }

    /// A speed to measure rounding by.
    pub(super) fn scale(&self) -> f64 {
        let fall = 2.0 * (self.drive[0] / self.masses()[0] + self.gravity.abs()) * self.gap;
        self.speed[0].abs().max(self.speed[1].abs()).max(fall.sqrt())
    }
}

/// Modes of the rock law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rock {
    /// Free flight.
    Free,
    /// Dissipative forward contact.
    Viscous,
    /// Forward contact.
    Forward,
    /// Backward contact.
    Backward,
    /// Standstill.
    Still,
}

/// A collision; `push` is the part of it with force.
#[derive(Clone, Copy, Debug)]
pub struct Collision {
    /// First touch.
    pub start: f64,
    /// Parting.
    pub end: f64,
    /// Time under force.
    pub push: f64,
    /// Impulse.
    pub impulse: f64,
    /// Relative mean speed at the first touch.
    pub speed: f64,
}

/// A jump on its way: when it reaches an end of a section, and for how many more transits it is followed. After those
/// it is spread over a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jump {
    pub(super) time: f64,
    pub(super) lives: u32,
}

impl Eq for Jump {}
impl PartialOrd for Jump {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Jump {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.time.total_cmp(&self.time).then(self.lives.cmp(&other.lives))
    }
}

/// A body's mean motion: integrals of the forces on it.
#[derive(Clone, Copy, Debug)]
pub struct Mean {
    /// Displacement.
    pub position: f64,
    /// Velocity.
    pub velocity: f64,
}

impl Mean {
    /// The mean motion after `span`, with an acceleration that goes linearly from `a` to `b`.
    pub(super) fn after(self, span: f64, [a, b]: [f64; 2]) -> Self {
        let position = self.velocity * span + (2.0 * a + b) * span * span / 6.0;
        let velocity = 0.5 * (a + b) * span;
        Self { position: self.position + position, velocity: self.velocity + velocity }
    }
}
