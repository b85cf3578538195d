//! The vector instructions that the loops of [`crate::numerics::kernel`] use.
//!
//! The widest vectors that the processor has are detected once. All of them give identical results to the last binary
//! digit, so the choice affects only speed. Tests select narrower ones to show this. In WebAssembly the vectors are a
//! property of the library, which has SIMD128 if it is built with `-C target-feature=+simd128`.

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
    /// Two doubles at a time, on 64-bit ARM.
    Neon,
    /// Two doubles at a time, in WebAssembly.
    Simd128,
    /// Four doubles at a time, on x86-64-v3.
    Avx2,
    /// Eight doubles at a time, on x86-64-v4.
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

/// The sets that this processor has, from the widest to `Scalar`. The list uses no heap memory, so that a library that
/// contains it can be unloaded.
static PATHS: LazyLock<[Option<(Vectors, Arch)>; MAX_SETS]> = LazyLock::new(paths);
/// Largest number of sets of one processor.
const MAX_SETS: usize = 3;
/// Position in [`PATHS`] of the set in use.
static CHOSEN: AtomicU8 = AtomicU8::new(0);

fn paths() -> [Option<(Vectors, Arch)>; MAX_SETS] {
    let mut list = [None; MAX_SETS];
    let mut slots = list.iter_mut();
    let mut add = |vectors, arch: Option<Arch>| {
        if let Some(arch) = arch
            && let Some(slot) = slots.next()
        {
            *slot = Some((vectors, arch));
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
    /// The sets that this processor has, from the widest to `Scalar`.
    pub fn available() -> impl Iterator<Item = Self> {
        PATHS.iter().flatten().map(|(vectors, _)| *vectors)
    }

    /// The set in use in this process: the widest, unless [`Self::select`] has changed it.
    pub fn in_use() -> Self {
        path().0
    }

    /// Makes the whole process use this set from now on; results do not change. Returns false if the processor does not
    /// have the set.
    pub fn select(self) -> bool {
        let position = Self::available().position(|vectors| vectors == self);
        // There are at most three entries, so the position fits into a byte.
        position.is_some_and(|position| {
            CHOSEN.store(position as u8, Ordering::Relaxed);
            true
        })
    }
}

#[inline(always)]
fn path() -> (Vectors, Arch) {
    let chosen = PATHS[usize::from(CHOSEN.load(Ordering::Relaxed))];
    chosen.unwrap_or((Vectors::Scalar, Arch::Scalar))
}

/// Runs a loop with the vector instructions in use.
#[inline(always)]
pub(crate) fn dispatch<Op: WithSimd>(op: Op) -> Op::Output {
    path().1.dispatch(op)
}
