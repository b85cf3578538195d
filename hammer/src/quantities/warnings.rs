//! Warnings about settings that are allowed but probably not intended.

use crate::numerics::display::DisplayNumber;
use crate::quantities::inputs::{INPUTS, Input, InputRow, Inputs};
use crate::quantities::parameters::{Fidelity, InputValues, Parameters, Source};
use crate::quantities::quantity::{Quantity, SOURCE};
use crate::quantities::sections::Body;
use crate::quantities::table::{Access, PARAMETERS, Parameter, Reader, Slot, name_of};
use std::fmt;

/// A parameter that is out of proportion to the bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Suspect {
    /// Its name.
    pub name: &'static str,
    /// Its value, in its unit.
    pub value: f64,
    /// The value relative to the bodies' own.
    pub ratio: f64,
}

impl fmt::Display for Suspect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, value, ratio } = self;
        let value = DisplayNumber(*value);
        write!(
            f,
            "{name} = {value} is {ratio:.1e} times the stiffness or impedance of the bodies themselves"
        )
    }
}

/// A value that differs from the reference hammer's by this factor is probably in another unit. Units that are easily
/// confused differ by a thousand (mm and m, kN and N); real hammers and rocks differ by less.
const SLIP: f64 = 300.0;
/// The same factor for a temperature: it separates degrees Celsius from kelvins.
const WARM: f64 = 2.0;
/// Usual values of quantities that the reference hammer lacks.
const USUAL: [(&str, f64); 4] = [
    ("drive_force", 5e3),
    ("drive_pressure", 5e6),
    ("return_pressure", 5e6),
    ("casing.mass", 50.0),
];

/// Warnings about values that seem to be in another unit, one sentence each.
pub fn unlikely(parameters: &Parameters, inputs: &InputValues) -> Vec<String> {
    let sized = |row: &&Parameter| !row.switches || usual_size(row.name).is_some();
    let read = |row: &&Parameter| row.reader.reads(parameters) && sized(row);
    let of_parameters = PARAMETERS.iter().filter(read).filter_map(|row| {
        let Slot::Real(quantity, _) = row.slot else { return None };
        let values = [parameters, &Parameters::default()].map(|p| row.slot.read(p));
        slip(row.name, quantity, values)
    });
    let of_inputs = INPUTS.iter().filter_map(|row| {
        let values = [*inputs, InputValues::default()].map(|mut values| *(row.start)(&mut values));
        slip(row.name, row.quantity, values)
    });
    of_parameters.chain(of_inputs).collect()
}

/// The usual value of a quantity that the reference hammer lacks.
fn usual_size(name: &str) -> Option<f64> {
    USUAL.iter().find(|(of, _)| *of == name).map(|(_, size)| *size)
}

/// The warning about a value, which is compared with the value of the reference hammer or the usual one.
fn slip(name: &str, quantity: Quantity, [value, own]: [f64; 2]) -> Option<String> {
    let (own, whose) =
        usual_size(name).map_or((own, "the reference hammer's"), |size| (size, "a usual"));
    let ratio = (value / own).abs();
    let slip = if quantity.unit == "K" { WARM } else { SLIP };
    let likely = (1.0 / slip..=slip).contains(&ratio);
    if quantity.unit == "1" || value == 0.0 || own == 0.0 || likely {
        return None;
    }
    let unit = quantity.unit;
    let [value, own] = [value, own].map(DisplayNumber);
    // The ratio, rounded to three digits.
    let ratio = DisplayNumber(format!("{ratio:.2e}").parse().unwrap_or(ratio));
    Some(format!(
        "{name} = {value} {unit} is {ratio} times {whose} {own} {unit}: is the unit right?"
    ))
}

/// The warning about a drive whose inputs are never set.
pub fn starved(source: Source, sets: impl Fn(Input) -> bool) -> Option<String> {
    let reads = |row: &&InputRow| matches!(row.reader, Reader::Drive(s) if s.contains(&source));
    let empty = |row: &&InputRow| *(row.start)(&mut InputValues::default()) == 0.0;
    let needed = || INPUTS.iter().filter(reads).filter(empty).map(|row| row.input);
    if needed().count() == 0 || needed().any(sets) {
        return None;
    }
    let names: Vec<&str> = needed().map(Input::name).collect();
    let (chosen, names) = (SOURCE.items[source as usize].0, names.join(" or "));
    Some(format!("drive.source is {chosen}, but nothing sets {names}: the piston is not driven"))
}

/// The warning about a feed force that does not press the hammer down at the first step.
pub fn unfed(force: f64) -> Option<String> {
    (force <= 0.0).then(|| {
        format!(
            "feed_force = {} N at the first step: nothing presses the hammer down (some hosts set what is \
             not connected to 0)",
            DisplayNumber(force)
        )
    })
}

/// Fastest impact that the steel of piston and bit withstands for long, m/s.
pub(crate) const FASTEST: f64 = 13.0;

/// The warning about an impact that exceeds this speed by more than rounding.
pub(crate) fn fast(speed: f64) -> Option<String> {
    (speed > 1.005 * FASTEST).then(|| {
        format!("An impact at {speed:.1} m/s: steel that strikes steel does not last beyond {FASTEST} m/s")
    })
}

/// Penetration of a blow, m, that buries the inserts of usual bits up to half their radius of 7 mm.
const BURIED: f64 = 3.5e-3;

/// The warning about a blow that lengthened the hole by more than the bit advanced, or buried the inserts. `rate` is
/// the rate of penetration and `tip` that of the bit's tip (m/s); the hole cannot grow faster than the lesser of the
/// two.
pub fn buried(rate: f64, tip: f64, depth: f64) -> Option<String> {
    let [rate, tip] = [rate, tip].map(|x| 3600.0 * x);
    if rate > tip {
        return Some(format!(
            "By its specific energy the hole grows at {rate:.0} m/h, but the bit goes in at {tip:.0} m/h only, and no hole \
             grows faster: the inserts are buried, and the rock is too weak for a percussive hammer, or its specific \
             energy too small for its hardness"
        ));
    }
    (depth > BURIED).then(|| {
        format!(
            "The bit goes in by {:.1} mm a blow: the inserts are buried, which is no percussive hammer's rock",
            1e3 * depth
        )
    })
}

/// A stiffness or viscosity this many times the bodies' own is out of proportion.
const FAR_OFF: f64 = 100.0;

impl Parameters {
    /// The stiffness or viscosity that exceeds the bodies' own by the largest factor, if that is at least [`FAR_OFF`].
    /// The bodies' own values are the mesh's `E A d / h` and the impedance of the section.
    pub(crate) fn suspect(&self) -> Option<Suspect> {
        let (mesh, rock) = (self.mesh_stiffness(), &self.rock);
        let tip = self.sections(Body::Bit).as_slice().iter().map(|s| s.area).fold(0.0, f64::max);
        let cased = |x: f64| if self.has_casing() { x } else { 0.0 };
        // The chuck's stiffness is compared with that of the softer body that it ties.
        let soft = self.end_stiffness(Body::Casing).min(self.end_stiffness(Body::Bit));
        let top = self.sections(Body::Casing).as_slice()[0].area;
        let neighbour = if self.is_elastic(Body::Casing) { top } else { tip };
        let joints = f64::from(u8::from(self.drill.loose() > 0));
        let candidates: [(Access, f64); 8] = [
            (|p| &mut p.drill.joint.stiffness, joints * self.drill.joint.stiffness / mesh),
            (|p| &mut p.chuck.stiffness, cased(self.chuck.stiffness / soft)),
            (
                |p| &mut p.chuck.viscosity,
                cased(self.chuck.viscosity / self.impedance_of(tip.min(neighbour))),
            ),
            (
                |p| &mut p.casing.impedance,
                cased(self.casing.impedance / self.impedance_of(neighbour)),
            ),
            (|p| &mut p.contact.stiffness, self.contact.stiffness / mesh),
            (|p| &mut p.rock.stiffness, rock.stiffness / mesh),
            (|p| &mut p.rock.unloading_ratio, rock.unloading_stiffness() / mesh),
            (|p| &mut p.rock.viscosity, rock.viscosity / self.impedance_of(tip)),
        ];
        let far = candidates.into_iter().filter(|(_, ratio)| *ratio >= FAR_OFF);
        let (field, ratio) = far.reduce(|a, b| if b.1 > a.1 { b } else { a })?;
        Some(Suspect { name: name_of(field), value: *field(&mut self.clone()), ratio })
    }
}

/// The warnings about a scene; none for an ordinary hammer.
pub(crate) fn warnings(parameters: &Parameters) -> Vec<String> {
    let usual = Parameters::default();
    let set = PARAMETERS.iter().filter(|row| row.slot.read(parameters) != row.slot.read(&usual));
    let mut list: Vec<String> = set.filter_map(|row| row.unread(parameters)).collect();
    if parameters.fidelity == Fidelity::Elastic {
        list.extend(rattling("contact", parameters.contact.stiffness, parameters.mesh_stiffness()));
    }
    if parameters.is_elastic(Body::Casing) {
        let mesh = [Body::Bit, Body::Casing].map(|body| parameters.end_stiffness(body));
        list.extend(rattling("chuck", parameters.chuck.stiffness, mesh[0].max(mesh[1])));
    }
    list.extend(overdamped(parameters));
    list.extend(short_cylinder(parameters));
    list
}

/// The warning that a port which opens as the piston rises is not yet fully open when the piston reaches the cylinder's
/// end.
fn short_cylinder(parameters: &Parameters) -> Option<String> {
    let air = &parameters.air;
    let ports: [(Access, f64, f64); 2] = [
        (|p| &mut p.air.drive.supply, air.drive.supply, air.supply_area),
        (|p| &mut p.air.returning.exhaust, air.returning.exhaust, air.exhaust_area),
    ];
    let open = |(_, edge, _): &(Access, f64, f64)| air.port_height - edge;
    let used = ports.into_iter().filter(|(_, _, area)| *area > 0.0);
    let (field, edge, _) = used.reduce(|a, b| if open(&b) > open(&a) { b } else { a })?;
    let needed = air.port_height - edge;
    (parameters.drive.source == Source::Air && needed > air.cylinder).then(|| {
        format!(
            "air.cylinder = {} m is shorter than the stroke needs: {} = {} m is wholly open only {needed:.4} m \
             above the bit (air.port_height)",
            DisplayNumber(air.cylinder),
            name_of(field),
            DisplayNumber(edge)
        )
    })
}

/// The warning that the bit on the rock's spring and dashpot is overdamped: it approaches rest from one side and never
/// turns upward.
fn overdamped(parameters: &Parameters) -> Option<String> {
    let (rock, mass) = (&parameters.rock, parameters.bit_mass());
    let critical = 2.0 * (rock.stiffness * mass).sqrt();
    (rock.viscosity > critical).then(|| {
        format!(
            "rock.viscosity = {} N s/m is above 2 sqrt(rock.stiffness M) = {critical:.3e} N s/m, M = \
             {mass:.3} kg of the bit: it creeps in the rock and does not come to stand still",
            DisplayNumber(rock.viscosity)
        )
    })
}

/// Warnings that the hammer cannot strike under constant loads: the drive is too weak for the piston's weight, or the
/// feed lifts the hammer. The mean forces over a cycle balance, and the rock can only push. So the sum of feed, weights
/// and drive must press the bit down; the drive counts unless a casing carries its reaction.
pub(crate) fn idle(parameters: &Parameters, inputs: &Inputs) -> Vec<String> {
    let Parameters { drive, gravity, .. } = parameters;
    let [lifts, throws, anvil] = drive.reach(inputs);
    let weight = parameters.piston_mass() * gravity;
    let mut list = Vec::new();
    // Without loads, a piston that was thrown flies on.
    let loaded = weight != 0.0 || lifts != 0.0 || throws != 0.0;
    if loaded && drive.source.switches() && (lifts + weight >= 0.0 || throws + weight <= 0.0) {
        list.push(format!(
            "a piston at rest stays at rest: drive.source = {:?} puts {lifts:.1} N to {throws:.1} N on \
             it, which does not overcome its weight of {weight:.1} N",
            drive.source
        ));
    }
    let feed = inputs.of(Input::FeedForce).at(0.0);
    let (driven, and) = match parameters.has_casing() {
        true => (0.0, ""),
        false => (throws + anvil, " and the drive's largest force"),
    };
    let held = parameters.total_mass() * gravity + driven;
    if feed + held < 0.0 {
        list.push(format!(
            "feed_force = {feed:.1} N lifts the hammer off the rock: its weight{and}: {held:.1} N"
        ));
    }
    list
}

/// The warning that a tie is stiffer than the mesh at its ends.
fn rattling(tie: &str, stiffness: f64, mesh: f64) -> Option<String> {
    let ratio = stiffness / mesh;
    (ratio > 2.0).then(|| {
        format!(
            "{tie}.stiffness = {stiffness} N/m is {ratio:.1} times the stiffness E A mesh.degree / h \
             of the stiffer of the elements that meet; beyond 2 the {tie} nodes rattle"
        )
    })
}
