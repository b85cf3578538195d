//! Where a hammer starts.

use super::Model;
use crate::law::{Chuck, Memory, Mode, Rock, State};
use crate::linear::Real;
use crate::scene::Input;
use crate::spectral::solve;

impl<T: Real> Model<T> {
    /// The piston unstressed, the bit at rest and without oscillation: standing on the rock
    /// under its dead loads, or under its weight and what the casing's shoulder carries, in SS with `ul = uu = 0`; or, if they lift it, just touching in FF,
    /// strained as its loads strain it in the uniform acceleration that follows.
    pub fn start(&self) -> (State<T>, Mode, Memory<T>) {
        let (n, tip) = (self.nodes(), self.tip);
        let zero = T::default();
        let mut u = vec![zero; n];
        let inputs = self.scene.inputs.map(|value| vec![T::from(value)]);
        let mut pressed = inputs[Input::Feed as usize][0];
        let mut mode = Mode::bare(false, Rock::SS);
        if self.scene.casing.is_some() {
            // The piston hangs free: the drive's reaction lifts the casing.
            let weight = self.weight[tip + 1..].iter().fold(zero, |sum, &w| sum + w);
            pressed = pressed + weight - self.driving(mode, &inputs)[0];
            mode.chuck = Chuck::Shoulder;
        }
        let mut dead = self.weight[self.bit..=tip].to_vec();
        dead[0] = dead[0] + pressed;
        let load = dead.iter().fold(zero, |sum, &f| sum + f);
        let held = load >= zero;
        if held {
            u[tip] = load / self.rock_stiffness(3);
        } else {
            // What accelerates a node is not passed on.
            let shares = &self.bit_mean[self.bit..];
            dead.iter_mut().zip(shares).for_each(|(f, &share)| *f = *f - load * share);
        }
        let hung = self.hanging(self.bit, &dead, u[tip]);
        u[self.bit..=tip].copy_from_slice(&hung);
        if let Some(casing) = &self.scene.casing {
            let lowest = u[self.bit] + pressed / T::from(casing.stiffness);
            let drive = self.driving(mode, &inputs)[0];
            let loads = self.weight.iter().zip(&self.drive).map(|(&w, &share)| w + drive * share);
            let mut loads: Vec<T> = loads.skip(tip + 1).collect();
            loads[0] = loads[0] + inputs[Input::Feed as usize][0];
            u.splice(tip + 1.., self.hanging(tip + 1, &loads, lowest));
        }
        // A lifted bit may be longer than the gap has room for: the piston is that much higher.
        let gap = self.gap(&u) + T::from(self.scene.gap);
        if gap < zero {
            u[..self.bit].fill(gap);
        }
        let mut v = vec![zero; n];
        v[..self.bit].fill(T::from(self.scene.bodies[0].velocity));
        v[self.bit..=tip].fill(T::from(self.scene.bodies[1].velocity));
        mode.rock = if held { Rock::SS } else { Rock::FF };
        let turned = if held { load } else { zero };
        let memory = Memory { turned, ..Memory::default() };
        mode.closed =
            (self.gap(&u) + T::from(self.scene.gap)).to_f64() < -self.scene.resolutions[0];
        (State { u, v, psi: zero }, mode, memory)
    }

    /// Displacements of a body's nodes, from its `first` on, under forces, its lowest held at `tip`.
    fn hanging(&self, first: usize, forces: &[T], tip: T) -> Vec<T> {
        let n = forces.len() - 1;
        if self.far.is_empty() {
            // The force above a section is carried by every element below it.
            let mut u = vec![tip; n + 1];
            let mut carried = forces.iter().fold(T::default(), |sum, &f| sum + f) - forces[n];
            for i in (0..n).rev() {
                u[i] = u[i + 1] - carried / self.bars.off[first + i];
                carried = carried - forces[i];
            }
            return u;
        }
        let mut k = vec![vec![T::default(); n]; n];
        for i in 0..n {
            k[i][i] = self.bars.diagonal[first + i];
            if i + 1 < n {
                let off = self.bars.off[first + i];
                (k[i][i + 1], k[i + 1][i]) = (off, off);
            }
        }
        for &(i, j, value) in self.far.iter().filter(|e| e.0 >= first && e.1 < first + n) {
            let (i, j) = (i - first, j - first);
            (k[i][j], k[j][i]) = (value, value);
        }
        // Relative to the tip, which then needs no column.
        let relative = solve(k, forces[..n].to_vec());
        relative.into_iter().chain([T::default()]).map(|u| u + tip).collect()
    }
}
