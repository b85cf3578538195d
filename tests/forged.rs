//! States that were changed and given the right checksum are read and stepped. The engine's own test, `altered`,
//! counts how much work a step may take.

use crate::abuser::forger::{
    HEADER, PRESENT, SPAN, forge, honest, honest_three, receive, receive_three, sealed,
};
use crate::abuser::{STRUCTURES, Structure};
use crate::support::host::Host;
use crate::support::library::{ERROR, Library, OK};
use crate::support::three::Three;
use dth_hammer::events::MAX_POSITIONS;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

#[test]
fn a_step_that_began_ages_ago_is_refused() {
    let library = Library::load();
    let bytes = honest(&library, &STRUCTURES[0]);
    let other = Host::new(&library);
    assert_eq!(receive(&other, &bytes), [OK, OK], "as it was written");
    // Sets each number of the state in turn to a time at which a step could not have begun.
    let mut refused = 0;
    for at in HEADER..bytes.len() - 8 {
        let mut forged = bytes.clone();
        forged[at..at + 8].copy_from_slice(&(-1e6_f64).to_le_bytes());
        refused += usize::from(receive(&other, &sealed(forged)) != [OK, OK]);
    }
    assert!(refused > 8, "{refused}");
}

#[test]
fn nothing_forged_holds_who_reads_it() {
    let library = Library::load();
    let states = STRUCTURES.map(|structure| honest(&library, &structure));
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_121);
    let mut taken = 0;
    for bytes in states.iter().cycle().take(300) {
        let other = Host::new(&library);
        let forged = forge(&mut rng, bytes, HEADER..bytes.len() - 8);
        taken += usize::from(receive(&other, &forged) == [OK, OK]);
    }
    assert!(taken > 20, "only {taken} were so much as taken");
}

/// Half of the changes are in the part of FMI 3.0: positions, lengths, slopes, events that end steps.
#[test]
fn nothing_forged_holds_a_host_of_fmi_3_either() {
    let library = Library::load();
    let (bytes, events) = honest_three(&library);
    assert_eq!(
        receive_three(&Three::new(&library, true, true), &bytes),
        [OK, OK],
        "as it was written"
    );
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_123);
    let mut taken = 0;
    for draw in 0..100 {
        let other = Three::new(&library, true, true);
        // After the positions, about as many other numbers.
        let own = events..events + 8 * 2 * MAX_POSITIONS + 32;
        let places = if draw % 2 == 0 { own } else { HEADER..bytes.len() - 8 };
        let forged = forge(&mut rng, &bytes, places);
        taken += usize::from(receive_three(&other, &forged) == [OK, OK]);
    }
    assert!(taken > 20, "only {taken} were so much as taken");
}

/// A length is encoded in as many bytes as it needs, after the eight positions. Allocating room for 2^60 numbers
/// would end the program, not only the call.
#[test]
fn arrays_longer_than_a_host_can_ask_for_are_refused() {
    let library = Library::load();
    let (bytes, events) = honest_three(&library);
    let lengths = events + 8 * MAX_POSITIONS;
    assert_eq!(bytes[lengths..lengths + 2], [20, 16], "as they start");
    for place in [lengths, lengths + 1] {
        for number in [vec![0], vec![0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x0f]] {
            let mut forged = bytes.clone();
            forged.splice(place..=place, number);
            let length = (forged.len() - HEADER) as u64;
            forged[8..16].copy_from_slice(&length.to_le_bytes());
            let host = Three::new(&library, true, true);
            assert_eq!(receive_three(&host, &sealed(forged)), [ERROR, ERROR]);
        }
    }
}

/// The piston's position determines its side of each monitored position. A stored side that contradicts it would
/// report a false passage, or hide one. Positions that differ from the parameters are refused.
#[test]
fn a_forged_side_of_a_position_changes_no_event() {
    let library = Library::load();
    let (bytes, parameters) = honest_three(&library);
    let first = &bytes[parameters..parameters + 8];
    let behind = bytes[parameters + 8..].windows(8).position(|window| window == first);
    let watched =
        parameters + 8 + behind.expect("the positions that are watched, each with its side");
    let events = |bytes: &[u8]| {
        let host = Three::new(&library, true, true);
        assert_eq!(host.adopt(bytes), [OK, OK]);
        let mut events = Vec::new();
        // Over a blow.
        host.run(PRESENT, PRESENT + 2.0 * SPAN, |ended, event| {
            events.extend(event.map(|what| (ended.time.to_bits(), what)));
        });
        events
    };
    let honest = events(&bytes);
    assert!(honest.len() > MAX_POSITIONS / 2, "{honest:?}");
    for index in 0..MAX_POSITIONS {
        let (mut forged, side) = (bytes.clone(), watched + 9 * index + 8);
        assert!(forged[side] <= 1, "a side");
        forged[side] ^= 1;
        assert_eq!(events(&sealed(forged)), honest, "position {index}");
    }
    let mut forged = bytes.clone();
    forged[watched..watched + 8].copy_from_slice(&(-0.02_f64).to_le_bytes());
    assert_eq!(Three::new(&library, true, true).adopt(&sealed(forged)), [ERROR, ERROR]);
}

/// A changed state could otherwise occupy its reader as long as it wants, by a limit stored anywhere in it.
#[test]
fn a_state_that_allows_more_work_than_its_reader_is_refused() {
    let library = Library::load();
    let allowed = |counts| honest(&library, &Structure { source: 1, counts, reals: &[] });
    let two = allowed(&[("piston.elements", 4), ("bit.elements", 3), ("work_limit", 2)]);
    let more = allowed(&[("piston.elements", 4), ("bit.elements", 3), ("work_limit", 29)]);
    let reader = |limit: i32, bytes: &[u8]| {
        receive(&Host::with(&library, &[("work_limit", limit.into())]), bytes)
    };
    assert_eq!(reader(2, &more), [OK, ERROR]);
    assert_eq!(reader(29, &more), [OK, OK]);
    let places = (HEADER..two.len()).filter(|&place| two[place] != more[place]);
    let places: Vec<usize> = places.collect();
    assert_eq!(places.len(), 2, "of the settings and of the engine");
    for place in places {
        let mut forged = two.clone();
        forged[place] = more[place];
        assert_eq!(reader(2, &sealed(forged)), [OK, ERROR], "{place}");
    }
}
