//! The vector instructions that the loops of [`crate::numerics::kernel`] use.
//!
//! The widest that the processor has are detected once. All of them give the same bits, so the choice affects only
//! speed; tests select narrower ones to show that. In WebAssembly the vectors are a property of the library: it has
//! SIMD128 when it is built with `-C target-feature=+simd128`.

use pulp::{Arch, WithSimd};
use std::fmt;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU8, Ordering};

/// A set of vector instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Vectors {
    /// One number at a time, unless the compiler vectorises.
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

/// The sets of this processor, widest first, then `Scalar`. It uses no heap memory, so that a library with it can be
/// unloaded.
static PATHS: LazyLock<[Option<(Vectors, Arch)>; MOST]> = LazyLock::new(paths);
/// Most sets of one processor.
const MOST: usize = 3;
/// Position in [`PATHS`] of the set in use.
static CHOSEN: AtomicU8 = AtomicU8::new(0);

fn paths() -> [Option<(Vectors, Arch)>; MOST] {
    let mut list = [None; MOST];
    let mut next = list.iter_mut();
    let mut add = |vectors, arch: Option<Arch>| {
        if let Some(arch) = arch
            && let Some(place) = next.next()
        {
            *place = Some((vectors, arch));
        }
    };
    #[cfg(target_arch = "x86_64")]
    {
        use pulp::x86::{V3, V4};
        add(Vectors::Avx512, V4::try_new().map(Arch::V4));
        add(Vectors::Avx2, V3::try_new().map(Arch::V3));
    }
    #[cfg(target_arch = "aarch64")]
    add(Vectors::Neon, pulp::aarch64::Neon::try_new().map(Arch::Neon));
    #[cfg(target_arch = "wasm32")]
    add(Vectors::Simd128, pulp::wasm::Simd128::try_new().map(Arch::Simd128));
    add(Vectors::Scalar, Some(Arch::Scalar));
    list
}

impl Vectors {
    /// The sets that this processor has, widest first; `Scalar` is the last.
    pub fn available() -> impl Iterator<Item = Self> {
        PATHS.iter().flatten().map(|(vectors, _)| *vectors)
    }

    /// The set in use in this process: the widest, unless [`Self::select`] has changed it.
    pub fn in_use() -> Self {
        path().0
    }

    /// Uses this set from now on, in the whole process, without effect on any result. Returns false if the processor
    /// does not have it.
    pub fn select(self) -> bool {
        let found = Self::available().position(|vectors| vectors == self);
        // There are at most three entries.
        found.is_some_and(|at| {
            CHOSEN.store(at as u8, Ordering::Relaxed);
            true
        })
    }
}

#[inline(always)]
fn path() -> (Vectors, Arch) {
    let chosen = PATHS[usize::from(CHOSEN.load(Ordering::Relaxed))];
    chosen.unwrap_or((Vectors::Scalar, Arch::Scalar))
}

/// Runs a loop with the set in use.
#[inline(always)]
pub(crate) fn dispatch<Op: WithSimd>(op: Op) -> Op::Output {
    path().1.dispatch(op)
}
