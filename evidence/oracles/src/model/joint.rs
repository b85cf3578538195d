//! Joints between bodies: the threads of a drill string, and the chuck, in which the casing stands on the
//! bit or carries it.
//!
//! ```text
//! x = u_lower - u_upper               of the faces that meet
//! pressed, x <= 0:       k x + c x'              up on the lower, down on the upper
//! pulled, x >= travel:   k (x - travel) + c x'   the same
//! ```
//!
//! A joint without travel is pressed and pulled as one. The damping of a thread is the material's, `c = beta k`.

use super::Model;
use crate::law::{Event, Guard, Mode, Quantity, Side};
use crate::linear::Real;
use crate::scene::Scene;
use std::ops::Range;

/// A joint of two bodies.
#[derive(Clone, Copy, Debug)]
pub struct Joint<T> {
    /// Lowest node of the body above, and highest of the body below.
    pub nodes: [usize; 2],
    /// Stiffness `k`, N/m.
    pub stiffness: T,
    /// Viscosity `c`, N s/m.
    viscosity: T,
    /// Distance from the pressed to the pulled position, m.
    pub travel: T,
}

impl<T: Real> Joint<T> {
    /// The joints of a scene whose bodies are stacked so, top to bottom.
    pub(super) fn all(scene: &Scene, stack: &[Range<usize>]) -> Vec<Self> {
        let stiffness = T::from(scene.coupling.stiffness);
        let thread =
            [stiffness, T::from(scene.damping_time) * stiffness, T::from(scene.coupling.slack)];
        let chuck = scene
            .casing
            .iter()
            .map(|casing| [casing.stiffness, casing.viscosity, casing.travel].map(T::from));
        let laws = chuck.chain(std::iter::repeat(thread));
        let between = |(pair, [stiffness, viscosity, travel]): (&[Range<usize>], [T; 3])| Self {
            nodes: [pair[0].end - 1, pair[1].start],
            stiffness,
            viscosity,
            travel,
        };
        stack.windows(2).zip(laws).map(between).collect()
    }

    /// `x` of displacements, or `x'` of velocities.
    pub fn apart(&self, u: &[T]) -> T {
        u[self.nodes[1]] - u[self.nodes[0]]
    }

    /// Position without force on a side, if the joint acts there.
    fn level(&self, side: Side) -> Option<T> {
        match side {
            Side::Open => None,
            Side::Pressed => Some(T::default()),
            Side::Pulled => Some(self.travel),
        }
    }

    /// Force that pushes its bodies apart on a side, N.
    fn force(&self, side: Side, u: &[T], v: &[T]) -> T {
        self.level(side).map_or(T::default(), |level| {
            -(self.stiffness * (self.apart(u) - level) + self.viscosity * self.apart(v))
        })
    }

    /// Adds a force that pushes its bodies apart.
    fn press(&self, force: T, out: &mut [T]) {
        let [upper, lower] = self.nodes;
        out[lower] = out[lower] + force;
        out[upper] = out[upper] - force;
    }
}

impl<T: Real> Model<T> {
    /// Nodes of the bodies below the piston, from the top.
    pub(super) fn stack(&self) -> Vec<Range<usize>> {
        let mut bodies: Vec<_> =
            self.starts.windows(2).skip(1).map(|ends| ends[0]..ends[1]).collect();
        if self.scene.casing.is_some() {
            bodies.rotate_right(1);
        }
        bodies
    }

    /// The node that the feed acts on: the highest of the casing or, without one, of the struck body.
    pub fn fed(&self) -> usize {
        if self.scene.casing.is_some() { self.tip + 1 } else { self.bit }
    }

    /// The joints and the sides on which they act.
    fn joined(&self, mode: Mode) -> impl Iterator<Item = (&Joint<T>, Side)> {
        self.joints.iter().zip(mode.joints)
    }

    /// Forces by which the joints push their bodies apart, N.
    pub fn joint_forces(&self, mode: Mode, u: &[T], v: &[T]) -> Vec<T> {
        self.joined(mode).map(|(joint, side)| joint.force(side, u, v)).collect()
    }

    /// Sum of `k x^2 / 2` over all joints, J, with `x` measured from where each closed.
    pub(super) fn joint_energy(&self, mode: Mode, u: &[T]) -> T {
        let energy = |(joint, side): (&Joint<T>, Side)| {
            let x = joint.apart(u) - joint.level(side)?;
            Some(T::from(0.5) * joint.stiffness * x * x)
        };
        self.joined(mode).filter_map(energy).fold(T::default(), |sum, energy| sum + energy)
    }

    /// Adds the joints' forces at `u = 0`, N.
    pub(super) fn add_joint_push(&self, mode: Mode, out: &mut [T]) {
        for (joint, side) in self.joined(mode) {
            if let Some(level) = joint.level(side) {
                joint.press(joint.stiffness * level, out);
            }
        }
    }

    /// Adds the rest of their forces, N.
    pub(super) fn add_joint_forces(&self, mode: Mode, u: &[T], v: &[T], out: &mut [T]) {
        for (joint, _) in self.joined(mode).filter(|(_, side)| *side != Side::Open) {
            let force = joint.stiffness * joint.apart(u) + joint.viscosity * joint.apart(v);
            joint.press(-force, out);
        }
    }

    /// Stiffness and viscosity of the joints at a node, N/m and N s/m.
    pub(super) fn held(&self, node: usize) -> [f64; 2] {
        let here = self.joints.iter().filter(|joint| joint.nodes.contains(&node));
        here.fold([0.0; 2], |[k, c], joint| {
            [k + joint.stiffness.to_f64(), c + joint.viscosity.to_f64()]
        })
    }

    /// Guards of joints that open or close, and of venting.
    pub(super) fn joint_guards(&self, mode: Mode) -> Vec<Guard<T>> {
        let height = self.scene.resolutions[0];
        let mut list = Vec::new();
        for (i, (joint, side)) in self.joined(mode).enumerate() {
            let quantity = Quantity::Joint(i);
            let guard = |to, sign, offset| {
                let event = Event::Joint(i, to);
                Guard { event, quantity, sign, offset, height }
            };
            match side {
                _ if joint.travel == T::default() => {}
                Side::Open => {
                    list.push(guard(Side::Pressed, -1.0, T::default()));
                    list.push(guard(Side::Pulled, 1.0, joint.travel));
                }
                Side::Pressed => list.push(guard(Side::Open, 1.0, T::default())),
                Side::Pulled => list.push(guard(Side::Open, -1.0, joint.travel)),
            }
        }
        if let Some(casing) = self.scene.casing.as_ref().filter(|casing| casing.idle_travel > 0.0) {
            list.push(Guard {
                event: Event::Vent(!mode.vented),
                quantity: Quantity::Joint(0),
                sign: if mode.vented { -1.0 } else { 1.0 },
                offset: T::from(if mode.vented { 0.5 } else { 1.0 } * casing.idle_travel),
                height,
            });
        }
        list
    }
}
