//! Bodies of very unequal masses, slender where they meet. Rounding leaves the gap on the wrong side of zero right
//! after its own event; only its rate shows that it is leaving.

use crate::scenes::Random;
use hammer::{InputValues, Machine, Parameters, Segment, Source};

/// One body is 1e3 to 1e6 times as heavy as the other, and one of them has a section down to 1e-6 of its area where
/// they meet. They are thrown at each other and pressed together.
fn scene(number: u64) -> (Parameters, InputValues) {
    let mut random = Random::new(number * 7919);
    (0..3).for_each(|_| _ = random.unit());
    let mut p = Parameters::default();
    p.drive.source = Source::Force;
    p.mesh.degree = 1 + (random.unit() * 5.0) as usize;
    p.piston.elements = 2 + (random.unit() * 7.0) as usize;
    p.bit.elements = 2 + (random.unit() * 7.0) as usize;
    let root = random.spread(1e3, 1e6).sqrt();
    let [mut heavy, mut light] = [root, 1.0 / root].map(|factor| factor * p.cross_section);
    if random.unit() < 0.5 {
        std::mem::swap(&mut heavy, &mut light);
    }
    let (share, end) = (random.spread(0.01, 0.5), random.spread(1e-6, 1.0));
    let [piston, bit] = if random.unit() < 0.5 { [end, 1.0] } else { [1.0, end] };
    let part = |length: f64, area: f64| Segment { length, area };
    let length = p.piston.length;
    p.piston
        .segments
        .set(&[part((1.0 - share) * length, heavy), part(share * length, piston * heavy)]);
    let length = p.bit.length;
    p.bit.segments.set(&[part(share * length, bit * light), part((1.0 - share) * length, light)]);
    p.contact.initial_gap = 1e-5;
    p.contact.stiffness *= random.spread(1e-2, 1e3);
    p.piston.initial_velocity = random.spread(0.1, 15.0);
    let drive_force = 1e4 * p.piston_mass() * p.piston.initial_velocity.powi(2);
    (p, InputValues { drive_force, ..InputValues::default() })
}

#[test]
fn a_gap_that_opens_is_not_taken_for_one_that_closes() {
    let mut events = 0;
    for number in 0..200 {
        let (p, inputs) = scene(number);
        let mut m = Machine::new(&p, &inputs, 0.0).expect("a scene");
        m.keep_journal(true);
        while m.time() < 5e-4 && m.counters().events < 1000 {
            let stepped = m.advance(m.time() + 1e-5);
            assert_eq!(stepped, Ok(()), "scene {number}: {p:?}");
        }
        let journal = m.take_journal();
        let contacts: Vec<_> = journal.iter().filter(|r| r.event.is_contact()).collect();
        for pair in contacts.windows(2) {
            let [first, second] = [pair[0], pair[1]];
            let passed = second.time - first.time + (second.time_rest - first.time_rest);
            assert!(passed > 1e-14, "scene {number}: {passed:e} s at {} s", first.time);
        }
        events += contacts.len();
        let energies = m.energies();
        let [residual, bound] = [energies.residual.abs(), energies.residual_bound()];
        assert!(residual <= bound, "scene {number}: {residual:e} J, at most {bound:e}");
    }
    assert!(events > 1000, "{events} events");
}
