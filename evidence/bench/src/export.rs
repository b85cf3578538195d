//! The assembled hammer as text, for solvers that are not written in Rust.
//!
//! One array a line: `name value value ...`, every number in full precision. The
//! systems are `k0 k0_off c0 c0_off ...` by [`oracles::law::Mode::system_index`].

use oracles::law::{Mode, Rock};
use oracles::model::Model;
use oracles::scene::Input;
use std::fmt::Write as _;

/// The text.
pub fn text(model: &Model<f64>) -> String {
    let (scene, rock) = (&model.scene, &model.scene.rock);
    let ([amplitude, stroke], [displacement, velocity]) = (scene.drive.relay(), scene.resolutions);
    let (start, ..) = model.start();
    let mode =
        |rock| model.system(Mode { closed: false, rock, down: true }).stiffness.diagonal.last();
    let stiffness =
        |rock| mode(rock).copied().unwrap_or(0.0) - mode(Rock::FF).copied().unwrap_or(0.0);
    let scalars: [(&str, f64); 15] = [
        ("nodes", model.nodes() as f64),
        ("bit", model.bit as f64),
        ("gap", scene.gap),
        ("contact", model.contact_stiffness),
        ("loading", stiffness(Rock::FC)),
        ("unloading", stiffness(Rock::BC)),
        ("viscosity", rock.viscosity),
        ("gamma", rock.ratio),
        ("barrier", rock.barrier),
        ("speed", rock.standstill_speed),
        ("penetration", rock.standstill_penetration),
        ("amplitude", amplitude),
        ("stroke", stroke),
        ("velocity_resolution", velocity),
        ("position_resolution", displacement),
    ];
    let mut arrays: Vec<(String, Vec<f64>)> =
        scalars.iter().map(|(name, value)| (name.to_string(), vec![*value])).collect();
    let mut add = |name: String, row: &[f64]| arrays.push((name, row.to_vec()));
    let mut dead = model.weight.clone();
    dead[model.bit] += scene.inputs[Input::Feed as usize];
    add("lower".into(), &model.mass_factor.lower);
    add("inverse".into(), &model.mass_factor.inverse);
    add("dead".into(), &dead);
    add("drive".into(), &model.drive);
    add("relative".into(), &model.relative);
    add("start".into(), &start.u);
    for (i, system) in model.systems.iter().enumerate() {
        add(format!("k{i}"), &system.stiffness.diagonal);
        add(format!("k{i}_off"), &system.stiffness.off);
        add(format!("c{i}"), &system.damping.diagonal);
        add(format!("c{i}_off"), &system.damping.off);
    }
    let mut text = String::new();
    for (name, row) in arrays {
        text.push_str(&name);
        row.iter().for_each(|x| write!(text, " {x:e}").expect("a String takes it"));
        text.push('\n');
    }
    text
}
