//! The state in which a hammer starts.

use super::Model;
use crate::air::Air;
use crate::law::{Memory, Mode, Rock, Side, State};
use crate::linear::Real;
use crate::scene::Input;

impl<T: Real> Model<T> {
    /// The piston is unstressed. Everything below it is at rest without oscillation, each body on the next and the
    /// bit on the rock under the dead loads, in SS with `ul = uu = 0`. If the loads lift the bit, it just touches, in
    /// FF, strained as in the uniform acceleration that follows. A casing that its loads lift is at rest where the
    /// shoulder just touches, strained likewise; the bit then stands by its own weight, or is in FF if it has none.
    pub fn start(&self) -> (State<T>, Mode, Memory<T>) {
        let n = self.nodes();
        let zero = T::default();
        let mut u = vec![zero; n];
        let inputs = self.scene.rows();
        let mut mode = Mode::bare(false, Rock::SS);
        mode.joints[..self.joints.len()].fill(Side::Pressed);
        // The piston hangs free, so the drive's reaction lifts a casing.
        let mut dead = self.weight.clone();
        let vr = -T::from(self.scene.gap);
        let forces = match Air::start(&self.scene, vr) {
            Some(air) => {
                let motion = ([vr; 2], T::from(self.scene.bodies[0].velocity));
                air.drive(self.scene.anvil_area, &air.filled([vr; 2]), motion)
            }
            None => self.driving(mode, &inputs).map(|force| force[0]),
        };
        self.push(&mut dead, &forces);
        dead[self.fed()] = dead[self.fed()] + inputs[Input::Feed as usize][0];
        let sum = |forces: &[T]| forces.iter().fold(zero, |sum, &f| sum + f);
        let load = sum(&dead[self.bit..]);
        let casing = self.tip + 1..n;
        let shoulder = sum(&dead[casing.clone()]);
        let lifted = self.scene.casing.is_some() && (shoulder <= zero || load < zero);
        if lifted {
            mode.joints[0] = Side::Open;
            let (shares, mass) = self.lumped(casing);
            let rate = shoulder / mass;
            dead.iter_mut().zip(shares).for_each(|(f, share)| *f = *f - rate * share);
        }
        let load = if lifted { load - shoulder } else { load };
        // A bit under no force stands where what is above it presses as much as lifts it.
        let above =
            if self.scene.casing.is_some() { shoulder } else { inputs[Input::Feed as usize][0] };
        let held = load > zero || !lifted && load == zero && above > zero;
        if !held {
            // The force that accelerates a node is not transmitted.
            dead.iter_mut().zip(&self.bit_mean).for_each(|(f, &share)| *f = *f - load * share);
        }
        let mut lowest = if held { load / self.rock_stiffness(3) } else { zero };
        let mut carried = sum(&dead[self.bit..]);
        for (i, nodes) in self.stack().into_iter().enumerate().rev() {
            let mut forces = dead[nodes.clone()].to_vec();
            carried = carried - sum(&forces);
            forces[0] = forces[0] + carried;
            u.splice(nodes.clone(), self.hanging(nodes.start, &forces, lowest));
            if i > 0 {
                lowest = u[nodes.start] + carried / self.joints[i - 1].stiffness;
            }
        }
        // A lifted bit may be longer than the gap permits; it then raises the piston.
        let gap = self.gap(&u) + T::from(self.scene.gap);
        if gap < zero {
            u[..self.bit].fill(gap);
        }
        let mut v = vec![zero; n];
        for (body, ends) in self.scene.bodies.iter().zip(self.starts.windows(2)) {
            v[ends[0]..ends[1]].fill(T::from(body.velocity));
        }
        mode.rock = if held { Rock::SS } else { Rock::FF };
        let turned = if held { load } else { zero };
        let memory = Memory { turned, ..Memory::default() };
        mode.closed =
            (self.gap(&u) + T::from(self.scene.gap)).to_f64() < -self.scene.resolutions[0];
        (State { u, v, psi: zero }, mode, memory)
    }

    /// Displacements of a body's nodes, from node `first` on, under forces, with its lowest node held at `tip`.
    fn hanging(&self, first: usize, forces: &[T], tip: T) -> Vec<T> {
        let n = forces.len() - 1;
        let mut u = vec![T::default(); n + 1];
        if n > 0 {
            // Relative to the tip, whose column is then not needed.
            u[..n].copy_from_slice(&forces[..n]);
            self.bars.factor(first, n).solve(&mut u[..n]);
        }
        u.into_iter().map(|u| u + tip).collect()
    }
}
