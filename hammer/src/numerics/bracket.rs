//! Iterations for a zero within a bracket: a fast method at first, then halvings, which always end.

/// Passes in which a fast method may choose the next point. It needs some ten; one that creeps, as beside a zero of high
/// order, may stay inside the bracket for ever.
const FAST: usize = 50;
/// Passes of an iteration. The halvings after the fast ones leave the share `2^-64` of any bracket, which is less than a
/// double resolves: an iteration to a share of 1e-15 or more ends before.
pub(crate) const PASSES: usize = FAST + 64;

/// True if the next point may be `x`, which a fast method has found in this pass; otherwise the bracket is halved.
pub(crate) fn admits(pass: usize, [low, high]: [f64; 2], x: f64) -> bool {
    pass < FAST && low < x && x < high
}
