//! Where the roots would be almost without damping and on soft rock: the search for all of them starts from there.

use crate::modal::spectrum::deflation::Deflated;
use crate::modal::spectrum::joined::Joined;
use crate::modal::structure::{Attachment, Structure};
use num_complex::Complex64 as C;

/// Most of a mode's critical damping.
const LIGHT: f64 = 0.3;

/// For each mode a root above the real axis, to first order; none of a mode that hardly oscillates.
pub(crate) fn roots(system: &Deflated) -> Vec<Option<C>> {
    let each = system.shapes.iter().zip(&system.springs);
    let attached =
        each.map(|(shape, &(stiffness, viscosity))| Attachment { shape, stiffness, viscosity });
    let attachments: Vec<Attachment> = attached.collect();
    // The modes with all springs but the first, which is a rock's, are the same in every rock.
    let proportional = attachments[1..].iter().filter(|a| a.stiffness > 0.0).copied().collect();
    let (beta, bodies) = (system.beta, Structure::free(&system.omega2, system.beta));
    let structure = Structure { attachments, proportional, ..bodies };
    let joined = Joined::new(&structure).filter(|_| system.sliding.is_none());
    let Some(joined) = &joined else { return vec![None; system.omega2.len()] };
    let joined = joined.structure(&structure);
    let (first, omega2) = (&joined.attachments[0], joined.omega2);
    let root = |i: usize| {
        // A spring moves a mode by its own stiffness, at most to the next one.
        let own = first.stiffness * first.shape[i] * first.shape[i];
        let room = omega2.get(i + 1).map_or(f64::INFINITY, |next| next - omega2[i]);
        let w2 = omega2[i] + own / (1.0 + own / room);
        // With damping in proportion, `c = beta k`, the modes stay as they are.
        let more = |a: &Attachment| (a.viscosity - beta * a.stiffness) * a.shape[i] * a.shape[i];
        let half = 0.5 * (beta * w2 + joined.attachments.iter().map(more).sum::<f64>());
        (half < LIGHT * w2.sqrt()).then(|| C::new(-half, (w2 - half * half).sqrt()))
    };
    (0..omega2.len()).map(root).collect()
}
