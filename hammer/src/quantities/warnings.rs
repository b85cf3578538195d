//! What a user should know about parameters that are allowed.

use crate::quantities::parameters::{Fidelity, Parameters, Source};
use crate::quantities::table::PARAMETERS;

/// In words; empty for an ordinary hammer.
pub(crate) fn warnings(parameters: &Parameters) -> Vec<String> {
    let usual = Parameters::default();
    let set = PARAMETERS.iter().filter(|row| row.slot.read(parameters) != row.slot.read(&usual));
    let mut list: Vec<String> = set.filter_map(|row| row.unread(parameters)).collect();
    if parameters.fidelity == Fidelity::Elastic {
        let ratio = parameters.contact.stiffness / parameters.mesh_stiffness();
        if ratio > 2.0 {
            list.push(format!(
                "contact.stiffness = {} N/m is {ratio:.1} times the stiffness E A mesh.degree / h \
                 of the stiffer of the elements that meet; beyond 2 the contact nodes rattle",
                parameters.contact.stiffness
            ));
        }
    }
    if parameters.drive.source == Source::Chambers {
        list.extend(parameters.chambers.overlaps().map(|(chamber, [supply, exhaust])| {
            format!(
                "supply and exhaust of the {chamber} chamber are both open where \
                 relative_position is between chambers.{chamber}.supply.position = {supply} m and \
                 chambers.{chamber}.exhaust.position = {exhaust} m"
            )
        }));
    }
    list
}
