//! Scenes from parameters and start values of inputs by name, and everything that can be computed without a run.

use crate::failure::{Failure, refused};
use crate::table::row;
use hammer::Scene;
use hammer::variables::{ALONG, Along, Role};
use hammer::{Body, Fidelity, Input, MeshAdvice, Parameters, Reading};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use std::collections::HashMap;

/// The reference hammer with these numbers changed.
pub fn scene_of(numbers: &HashMap<String, f64>) -> PyResult<Scene> {
    let mut scene = Scene::default();
    for (name, value) in numbers {
        match &row(name)?.1.role {
            Role::Parameter(row) => row.slot.write(&mut scene.parameters, *value),
            Role::Input(row) => *(row.start)(&mut scene.inputs) = *value,
            _ => return Err(refused(format!("{name} is an output: it cannot be set"))),
        }
    }
    Ok(scene)
}

/// The parameters of the scene with these numbers, after the engine has checked them.
fn checked(numbers: &HashMap<String, f64>) -> PyResult<Parameters> {
    let parameters = scene_of(numbers)?.parameters;
    parameters.validate().map_err(Failure::from)?;
    Ok(parameters)
}

/// A body of a hammer; in Python it is a mapping.
#[derive(IntoPyObject)]
struct Shape {
    /// True if it is elastic.
    elastic: bool,
    /// Lengths (m) and areas (m2) of its sections, from top to bottom.
    sections: Vec<(f64, f64)>,
    /// Distances of the mesh's nodes from the body's upper face, m.
    nodes: Vec<f64>,
}

/// The bodies of a hammer by name, from top to bottom.
#[pyfunction]
pub fn bodies(py: Python<'_>, numbers: HashMap<String, f64>) -> PyResult<Bound<'_, PyDict>> {
    let parameters = checked(&numbers)?;
    let shape = |body: Body| {
        let sections = parameters.sections(body);
        let listed = sections.as_slice().iter().map(|s| (s.length, s.area)).collect();
        let nodes = sections.nodes(parameters.spans(body));
        Shape { elastic: parameters.is_elastic(body), sections: listed, nodes }
    };
    parameters.bodies().map(|body| (body.name(), shape(body))).into_py_dict(py)
}

/// Relative errors of rates and of an impact's forces on the scene's own mesh, by the engine's rules; that of a rate is
/// None for linear elements.
#[pyfunction]
pub fn mesh_errors(numbers: HashMap<String, f64>) -> PyResult<(Option<f64>, f64)> {
    let parameters = checked(&numbers)?;
    Ok((parameters.rate_error(), parameters.force_error()))
}

/// Width of the sharpest wave front (m), and a mesh with a relative error of at most `error`, if there is one.
///
/// The mesh is given as its degree, followed by the spans of piston, bit and (if it has sections) casing.
#[pyfunction]
pub fn mesh(
    numbers: HashMap<String, f64>,
    of: &str,
    error: f64,
) -> PyResult<(f64, Option<Vec<usize>>)> {
    let parameters = checked(&numbers)?;
    let reading =
        Reading::named(of).ok_or_else(|| refused("a mesh is for a rate, a force or a stress"))?;
    let advice = parameters.mesh_for(reading, error);
    let spans = |mesh: &MeshAdvice| mesh.spans.iter().map(|(_, spans)| *spans).collect::<Vec<_>>();
    let list = advice.map(|mesh| [vec![mesh.degree], spans(&mesh)].concat());
    Ok((parameters.front_width(), list))
}

/// Names of all variables along the bodies of a hammer, such as `bit_stress[12]`.
#[pyfunction]
pub fn wave_names(numbers: HashMap<String, f64>) -> PyResult<Vec<String>> {
    let parameters = checked(&numbers)?;
    if parameters.fidelity == Fidelity::Rigid {
        return Err(refused("rigid bodies carry no waves: set fidelity = Elastic"));
    }
    let members = |family: &'static Along| {
        (1..=family.count(&parameters)).map(|k| format!("{}[{k}]", family.name))
    };
    Ok(ALONG.iter().flat_map(members).collect())
}

/// The parameters and inputs, among these names, that have no effect in a scene, each with a sentence that says why.
#[pyfunction]
pub fn unread(
    numbers: HashMap<String, f64>,
    names: Vec<String>,
) -> PyResult<Vec<(String, String)>> {
    let parameters = scene_of(&numbers)?.parameters;
    let mut found = Vec::new();
    for name in names {
        let why = row(&name)?.1.unread(&parameters);
        found.extend(why.map(|why| (name, why)));
    }
    Ok(found)
}

/// Warnings about a scene, given the names of the numbers that were set; if it `runs`, also about its drive.
#[pyfunction]
pub fn diagnostics(
    numbers: HashMap<String, f64>,
    names: Vec<String>,
    runs: bool,
) -> PyResult<Vec<String>> {
    Ok(warnings(&scene_of(&numbers)?, &names, runs))
}

/// Warnings as of [`diagnostics`], for a scene of the engine.
pub fn warnings(scene: &Scene, names: &[String], runs: bool) -> Vec<String> {
    let (parameters, inputs) = (&scene.parameters, &scene.inputs);
    let unread = names.iter().filter_map(|name| row(name).ok()?.1.unread(parameters));
    let sets = |input: Input| names.iter().any(|name| name == input.name());
    let starved = hammer::starved(parameters.drive.source, sets).filter(|_| runs);
    unread.chain(hammer::unlikely(parameters, inputs)).chain(starved).collect()
}
