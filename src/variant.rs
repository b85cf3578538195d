//! Variants: FMUs that are made from the general one, with other start values, or with the arrays of FMI 3.0, which
//! many importers cannot read.
//!
//! A host need not set a variable that stays at its start value, so the library must know the start values in its model
//! description. It reads them from the only text that every host passes, the GUID. The differences follow the general
//! GUID:
//!
//! ```text
//! GENERAL[-set-REFERENCE:BITS,REFERENCE:BITS...][-arrays]
//! ```
//!
//! `BITS` are the 16 hexadecimal digits of an IEEE 754 double. References are in ascending order. Some hosts name a
//! folder by the GUID, so it must be short. In a configured unit, this suffix is therefore in a reserved section of the
//! library ([`RESERVED`]); its GUID has a dash and a hash of 16 digits instead ([`sign`]).

use crate::events::Extra;
use hammer::variables::{Role, VARIABLES};

/// How a model description differs from the general one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variant {
    /// Value references and start values of parameters and inputs.
    start: Vec<(u32, f64)>,
    /// True if arrays are listed. They can be read even if they are not listed.
    arrays: bool,
}

/// Suffix of a GUID with arrays.
pub const ARRAYS: &str = "-arrays";
/// Prefix of the start values in a GUID.
pub const SET: &str = "-set-";
/// The form of start values in a GUID, as the model description states it.
pub const START_VALUES: &str = "-set-{reference}:{bits}";

/// Size of the reserved section, bytes: a mark by which it is found in the file, and room for each variable.
pub const RESERVED: usize = MARK.len() + (1 << 14);
/// Mark at the start of the section.
pub const MARK: &[u8; 32] = b"dth_hammer: this unit starts as:";

/// The hash that stands for a text in a GUID: a dash and hexadecimal digits (FNV-1a of 64 bits).
pub fn sign(text: &str) -> String {
    let fold = |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    format!("-{:016x}", text.bytes().fold(0xcbf2_9ce4_8422_2325, fold))
}

impl Variant {
    /// The variant that a GUID names, for a library with `text` in its reserved section; `None` if the GUID belongs to
    /// another build or another text. `plain` is the general GUID.
    pub fn signed(guid: &str, plain: &str, text: &str) -> Option<Self> {
        match guid.strip_prefix(plain) {
            Some(rest) if !text.is_empty() => (rest == sign(text))
                .then(|| Self::named(&format!("{plain}{text}"), plain))
                .flatten(),
            _ => Self::named(guid, plain),
        }
    }

    /// The variant that an unabridged GUID names; `None` if it belongs to another build. `plain` is the general GUID.
    pub fn named(guid: &str, plain: &str) -> Option<Self> {
        let mut rest = guid.strip_prefix(plain)?;
        let mut variant = Self::default();
        if let Some(before) = rest.strip_suffix(ARRAYS) {
            (rest, variant.arrays) = (before, true);
        }
        if let Some(list) = rest.strip_prefix(SET) {
            variant.start = list.split(',').map(start_value).collect::<Option<_>>()?;
        }
        // A variant has only one valid text.
        (variant.suffix() == guid[plain.len()..]).then_some(variant)
    }

    /// The part of the unabridged GUID after the general one.
    pub fn suffix(&self) -> String {
        let pair =
            |(reference, value): &(u32, f64)| format!("{reference}:{:016x}", value.to_bits());
        let mut list: Vec<&(u32, f64)> = self.start.iter().collect();
        list.sort_by_key(|(reference, _)| *reference);
        list.dedup_by_key(|(reference, _)| *reference);
        let list: Vec<String> = list.into_iter().map(pair).collect();
        let set = if list.is_empty() { String::new() } else { format!("{SET}{}", list.join(",")) };
        set + if self.arrays { ARRAYS } else { "" }
    }

    /// True if the model description lists arrays, and the structural parameters that are their lengths.
    pub fn lists_arrays(&self) -> bool {
        self.arrays
    }

    /// Value references and start values of the parameters and inputs that differ.
    pub fn start_values(&self) -> &[(u32, f64)] {
        &self.start
    }
}

/// Parses the reference and the start value of a variable; `None` if the variable cannot be set, or not to this value.
fn start_value(text: &str) -> Option<(u32, f64)> {
    let (reference, bits) = text.split_once(':')?;
    let reference = reference.parse::<u32>().ok()?;
    let value = f64::from_bits(u64::from_str_radix(bits, 16).ok()?);
    let settable = match VARIABLES.get(reference as usize) {
        Some(row) => matches!(row.role, Role::Parameter(_) | Role::Input(_)),
        None => Extra::of(reference)?.may_start_with(value),
    };
    (settable && value.is_finite()).then_some((reference, value))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The library of a configured unit accepts only its own hash, and neither the general GUID nor the hash of another
    /// text.
    #[test]
    fn a_signed_guid_is_of_the_text_in_the_library() {
        let text = "-set-5:3fc999999999999a-arrays";
        let guid = format!("g{}", sign(text));
        assert_eq!(Variant::signed(&guid, "g", text), Variant::named(&format!("g{text}"), "g"));
        assert!(Variant::signed(&guid, "g", text).is_some());
        for (guid, section) in [("g", text), (&guid, ""), (&guid, "-set-5:3fc999999999999b")] {
            assert_eq!(Variant::signed(guid, "g", section), None, "{guid} {section}");
        }
        // These are the offset basis, and the hash of "a" as published by the authors of FNV.
        assert_eq!([sign(""), sign("a")], ["-cbf29ce484222325", "-af63dc4c8601ec8c"]);
        assert!(crate::GUID.len() + sign(text).len() <= 64);
    }

    #[test]
    fn a_guid_names_start_values_or_is_wrong() {
        let position = |name| VARIABLES.iter().position(|v| v.name == name).unwrap() as u32;
        let [length, feed, depth] = ["piston.length", "feed_force", "tip_depth"].map(position);
        let (a, b) = (0.2_f64.to_bits(), 4e3_f64.to_bits());
        let set = format!("g-set-{length}:{a:016x},{feed}:{b:016x}");
        let variant = Variant::named(&set, "g").unwrap();
        assert_eq!(variant.start_values(), [(length, 0.2), (feed, 4e3)]);
        let arrays = Variant::named(&format!("{set}-arrays"), "g").unwrap();
        assert!(arrays.arrays && arrays.start_values().len() == 2);
        let event = format!("{set},{}:{a:016x}", Extra::Position(7).reference());
        assert_eq!(Variant::named(&event, "g").unwrap().start_values().len(), 3);
        assert_eq!(Variant::named("g", "g"), Some(Variant::default()));
        let nan = f64::NAN.to_bits();
        for wrong in [
            String::new(),
            "h".into(),
            "g-".into(),
            "g-set-".into(),
            format!("g-set-{length}"),
            format!("g-set-{length}:{a:x},"),
            format!("g-set-{length}:+{:015x}", a >> 4),
            format!("g-set-0{length}:{a:016x}"),
            format!("g-set-{feed}:{b:016x},{length}:{a:016x}"),
            format!("g-set-{feed}:{b:016x},{feed}:{b:016x}"),
            format!("g-set-{length}:{nan:016x}"),
            format!("g-set-{depth}:{a:016x}"),
            format!("g-set-99999:{a:016x}"),
            format!("{set} "),
            format!("g-arrays{}", &set[1..]),
            "g-arrays-arrays".into(),
            format!("g-set-{}:{a:016x}", Extra::Positions.reference()),
            format!("g-set-{}:{b:016x}", Extra::Time.reference()),
        ] {
            assert_eq!(Variant::named(&wrong, "g"), None, "{wrong}");
        }
    }
}
