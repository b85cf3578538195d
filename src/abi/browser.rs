//! What the page asks of the library beyond FMI. Hosts have no use for it: it is exported to
//! browsers alone.

use crate::c::{Out, Text};
use crate::datasheet;

/// Solves a datasheet; writes the answer as far as there is room, and returns its length in bytes.
#[unsafe(no_mangle)]
extern "C" fn dth_datasheet(request: Text, answer: Out<u8>, room: usize) -> usize {
    let text = request.read().map(|text| text.to_string_lossy().into_owned()).unwrap_or_default();
    let found = datasheet::answer(&text);
    for (index, byte) in found.bytes().take(room).enumerate() {
        if answer.write(index, byte, "answer").is_err() {
            return 0;
        }
    }
    found.len()
}
