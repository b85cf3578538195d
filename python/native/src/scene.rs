//! Parameters and start values of inputs by name, and what follows from them alone.

use crate::failure::{Failure, refused};
use crate::table::row;
use hammer::Scene;
use hammer::families::{ALONG, Along};
use hammer::variables::Role;
use hammer::{Body, Fidelity, Input, MeshAdvice, Parameters, Reading};
use numpy::PyArray1;
use pyo3::prelude::*;
use std::collections::HashMap;

/// The reference hammer with these numbers laid over it.
pub fn scene_of(numbers: &HashMap<String, f64>) -> PyResult<Scene> {
    let mut scene = Scene::default();
    lay(&mut scene, numbers)?;
    Ok(scene)
}

/// Lays numbers over a scene.
pub fn lay(scene: &mut Scene, numbers: &HashMap<String, f64>) -> PyResult<()> {
    for (name, value) in numbers {
        match &row(name)?.1.role {
            Role::Parameter { slot, .. } => slot.write(&mut scene.parameters, *value),
            Role::Input { start, .. } => *start(&mut scene.inputs) = *value,
            _ => return Err(refused(format!("{name} is an output: it cannot be set"))),
        }
    }
    Ok(())
}

/// The parameters of a scene that the engine does not refuse.
fn checked(numbers: &HashMap<String, f64>) -> PyResult<Parameters> {
    let parameters = scene_of(numbers)?.parameters;
    parameters.validate().map_err(Failure::from)?;
    Ok(parameters)
}

/// The body of a name.
fn body(name: &str) -> PyResult<Body> {
    let found = Body::ALL.into_iter().chain([Body::Casing]).find(|body| body.name() == name);
    found.ok_or_else(|| refused(format!("there is no body {name:?}")))
}

/// Lengths (m) and areas (m2) of a body's sections, from top to bottom.
#[pyfunction]
#[pyo3(name = "sections")]
pub fn sections(numbers: HashMap<String, f64>, name: &str) -> PyResult<Vec<(f64, f64)>> {
    let sections = checked(&numbers)?.sections(body(name)?);
    Ok(sections.as_slice().iter().map(|s| (s.length, s.area)).collect())
}

/// Distances of the mesh's nodes below a body's upper face, m.
#[pyfunction]
pub fn nodes<'py>(
    py: Python<'py>,
    numbers: HashMap<String, f64>,
    name: &str,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (parameters, body) = (checked(&numbers)?, body(name)?);
    let nodes = parameters.sections(body).nodes(parameters.spans(body));
    Ok(PyArray1::from_vec(py, nodes))
}

/// Relative error of the forces at an impact on a scene's own mesh, by the engine's rule.
#[pyfunction]
pub fn force_error(numbers: HashMap<String, f64>) -> PyResult<f64> {
    Ok(checked(&numbers)?.force_error())
}

/// What a mesh may be for, and the error of it that is asked for where none is given.
#[pyfunction]
pub fn mesh_readings() -> HashMap<&'static str, f64> {
    Reading::ALL.map(|reading| (reading.name(), reading.usual_error())).into()
}

/// Width of the sharpest front (m), and degree and spans of piston, bit and a casing of sections on which
/// what is read errs by no more than `error`, if there is such a mesh.
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

/// Names of the bodies that carry waves.
#[pyfunction]
pub fn elastic_bodies(numbers: HashMap<String, f64>) -> PyResult<Vec<&'static str>> {
    let parameters = checked(&numbers)?;
    Ok(parameters.bodies().filter(|body| parameters.is_elastic(*body)).map(Body::name).collect())
}

/// Names of all that a hammer has along its bodies.
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

/// Of what has these names, what a scene does not read, and a sentence that says why.
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

/// Values that look as if they were in another unit, a sentence each.
#[pyfunction]
pub fn unlikely(numbers: HashMap<String, f64>) -> PyResult<Vec<String>> {
    let scene = scene_of(&numbers)?;
    Ok(hammer::unlikely(&scene.parameters, &scene.inputs))
}

/// Whether the drive needs inputs of which none is among those set, as a sentence.
#[pyfunction]
pub fn starved(numbers: HashMap<String, f64>, set: Vec<String>) -> PyResult<Option<String>> {
    let source = scene_of(&numbers)?.parameters.drive.source;
    let sets = |input: Input| set.iter().any(|name| name == input.name());
    Ok(hammer::starved(source, sets))
}

/// What is doubtful of a scene whose numbers with these names were set, as `dth_hammer.warnings`
/// finds it of a hammer that is stepped.
pub fn warnings(scene: &Scene, names: &[String]) -> Vec<String> {
    let (parameters, inputs) = (&scene.parameters, &scene.inputs);
    let unread = names.iter().filter_map(|name| row(name).ok()?.1.unread(parameters));
    let sets = |input: Input| names.iter().any(|name| name == input.name());
    let starved = hammer::starved(parameters.drive.source, sets);
    unread.chain(hammer::unlikely(parameters, inputs)).chain(starved).collect()
}
