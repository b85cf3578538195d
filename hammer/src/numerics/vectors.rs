//! Which vectors the loops of [`crate::numerics::kernel`] run in.
//!
//! The widest that the processor has are found once. All of them give the same bits, so the
//! choice is of speed alone; a narrower one can be asked for, to show just that.
//!
//! In WebAssembly the vectors are a property of the library: it has SIMD128 when it is built
//! with `-C target-feature=+simd128`.

use pulp::{Arch, WithSimd};
use std::fmt;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU8, Ordering};

/// A kind of vectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Vectors {
    /// None: one number at a time, or what the compiler makes of it.
    Scalar,
    /// 64-bit ARM, two doubles.
    Neon,
    /// WebAssembly, two doubles.
    Simd128,
    /// x86-64-v3, four doubles.
    Avx2,
    /// x86-64-v4, eight doubles.
    Avx512,
}

impl fmt::Display for Vectors {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Scalar => "scalar",
            Self::Neon => "NEON",
            Self::Simd128 => "SIMD128",
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
        })
    }
}

/// What this processor has, widest first.
static PATHS: LazyLock<Vec<(Vectors, Arch)>> = LazyLock::new(paths);
/// Position in [`PATHS`] of the one in use.
static CHOSEN: AtomicU8 = AtomicU8::new(0);

fn paths() -> Vec<(Vectors, Arch)> {
    let mut list = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        use pulp::x86::{V3, V4};
        list.extend(V4::try_new().map(|v| (Vectors::Avx512, Arch::V4(v))));
        list.extend(V3::try_new().map(|v| (Vectors::Avx2, Arch::V3(v))));
    }
    #[cfg(target_arch = "aarch64")]
    list.extend(pulp::aarch64::Neon::try_new().map(|v| (Vectors::Neon, Arch::Neon(v))));
    #[cfg(target_arch = "wasm32")]
    list.extend(pulp::wasm::Simd128::try_new().map(|v| (Vectors::Simd128, Arch::Simd128(v))));
    list.push((Vectors::Scalar, Arch::Scalar));
    list
}

impl Vectors {
    /// Those that this processor has, widest first; `Scalar` is the last.
    pub fn available() -> impl Iterator<Item = Self> {
        PATHS.iter().map(|(vectors, _)| *vectors)
    }

    /// Those in use in this process: the widest, until [`Self::select`] says otherwise.
    pub fn in_use() -> Self {
        path().0
    }

    /// Uses these from now on, in the whole process. No result depends on it; false if the
    /// processor does not have them.
    pub fn select(self) -> bool {
        let found = PATHS.iter().position(|(vectors, _)| *vectors == self);
        // At most three entries.
        found.is_some_and(|at| {
            CHOSEN.store(at as u8, Ordering::Relaxed);
            true
        })
    }
}

#[inline(always)]
fn path() -> (Vectors, Arch) {
    PATHS[usize::from(CHOSEN.load(Ordering::Relaxed))]
}

/// Runs a loop in the vectors in use.
#[inline(always)]
pub(crate) fn dispatch<Op: WithSimd>(op: Op) -> Op::Output {
    path().1.dispatch(op)
}
