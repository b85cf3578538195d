//! The random hosts of the tests, with the bytes of a fuzzer as random numbers.

#[path = "../../tests/abuser/mod.rs"]
pub mod abuser;
#[path = "../../tests/support/mod.rs"]
pub mod support;

use rand::TryRng;
use std::cell::Cell;
use std::convert::Infallible;
use std::rc::Rc;
use std::sync::LazyLock;
use support::library::Library;

/// The library, built with this program.
pub static LIBRARY: LazyLock<Library> = LazyLock::new(|| {
    let beside = Library::path();
    Library::load_from(&beside.with_file_name("deps").join(beside.file_name().expect("a name")))
});

/// Random numbers from bytes, followed by zeros.
#[derive(Clone)]
pub struct Draws {
    bytes: Rc<[u8]>,
    at: Rc<Cell<usize>>,
}

impl Draws {
    /// Random numbers from these bytes.
    pub fn new(bytes: &[u8]) -> Self {
        Self { bytes: bytes.into(), at: Rc::default() }
    }

    /// True if only zeros follow.
    pub fn are_over(&self) -> bool {
        self.at.get() >= self.bytes.len()
    }

    fn take<const N: usize>(&self) -> [u8; N] {
        let from = self.at.replace(self.at.get() + N);
        std::array::from_fn(|index| self.bytes.get(from + index).copied().unwrap_or_default())
    }
}

impl TryRng for Draws {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        // The highest byte is the last one: it decides among a few choices.
        Ok(u32::from_le_bytes(self.take()))
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(u64::from_le_bytes(self.take()))
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        bytes.fill_with(|| self.take::<1>()[0]);
        Ok(())
    }
}
