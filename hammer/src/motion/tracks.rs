//! Tracks at other instants.

use super::Motion;
use crate::laws::event::Bodies;
use crate::modal::track::{ROUNDED, Track};
use crate::scene::graph::Group;

impl Motion {
    pub(crate) fn at_anchor(&self, index: usize) -> Track {
        let anchor = &self.state.anchors[index];
        Track { system: self.tracks[index].system.clone(), z: anchor.z.clone(), at: anchor.at }
    }

    /// The tracks rotated from the last event to the present.
    pub(crate) fn present(&self) -> Vec<Track> {
        let rotated = |index| {
            let mut track = self.at_anchor(index);
            track.rotate_to(self.state.now);
            track
        };
        (0..self.tracks.len()).map(rotated).collect()
    }

    /// Rotates the tracks of some bodies to the epoch.
    pub(crate) fn rotate_to_epoch(&mut self, bodies: Bodies) {
        for (track, anchor) in self.tracks.iter_mut().zip(&self.state.anchors) {
            if anchor.group.bodies.meet(bodies) {
                track.rotate_to(0.0);
            }
        }
    }

    /// Resets each track that is beyond `at` to its anchor. A guard crosses before an instant already evaluated
    /// only if its resolution is absurd, as in a corrupt state.
    pub(crate) fn return_to_anchors(&mut self, at: f64) {
        for (track, anchor) in self.tracks.iter_mut().zip(&self.state.anchors) {
            if track.at > at + ROUNDED {
                track.z.copy_from_slice(&anchor.z);
                track.at = anchor.at;
            }
        }
    }

    /// Rotates all tracks to `at`, except the tip's track and that of a lone piston.
    pub(crate) fn rotate_others_to(&mut self, at: f64) {
        let beside = self.tracks.iter_mut().zip(&self.state.anchors).skip(1);
        for (track, _) in beside.filter(|(_, anchor)| anchor.group != Group::PISTON) {
            track.rotate_to(at);
        }
    }
}
