//! Reference results, by which a host checks itself: in the archive as FMI-LS-REF has them, and as the FMI cross-check
//! asks for them.

use crate::archive::File;
use crate::{Failure, Standard};
use dth_hammer::MODEL_IDENTIFIER;
use hammer::presets::PRESETS;
use hammer::variables::{Role, Variable};
use hammer::{Input, InputValues, Machine, Parameters};
use quick_xml::escape::escape;
use std::fmt::Write;

/// Folder in the archive.
const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
/// Steps, and their size, s.
const STEPS: u32 = 200;
const SIZE: f64 = 1e-3;
/// The feed, N, to the step in the middle and from there on.
const FEED: [f64; 2] = [5e3, 6e3];
/// Outputs that do not depend on the communication step.
const SHOWN: [&str; 10] = [
    "piston_position",
    "piston_velocity",
    "bit_position",
    "tip_depth",
    "contact_impulse",
    "rock_impulse",
    "energy_drive",
    "blow_count",
    "blow_time",
    "blow_speed",
];
/// Largest difference, over the largest magnitude of an output: the sums of a host's steps are rounded.
const TOLERANCE: f64 = 1e-9;

/// The experiment.
pub struct Reference {
    inputs: String,
    outputs: String,
}

impl Reference {
    /// Runs it by the engine.
    pub fn new() -> Result<Self, Failure> {
        let middle = f64::from(STEPS / 2) * SIZE;
        let end = f64::from(STEPS) * SIZE;
        let [low, high] = FEED;
        let feed = Input::FeedForce.name();
        let inputs =
            format!("time,{feed}\n0,{low}\n{middle},{low}\n{middle},{high}\n{end},{high}\n");
        let values = InputValues { feed_force: low, ..InputValues::default() };
        let wrong = |error: hammer::Error| Failure::Unfit {
            name: "reference results".into(),
            reason: error.to_string(),
        };
        let mut machine = Machine::new(&Parameters::default(), &values, 0.0).map_err(wrong)?;
        let mut outputs = format!("time,{}\n", SHOWN.join(","));
        for step in 0..=STEPS {
            let time = f64::from(step) * SIZE;
            if step > 0 {
                machine.advance(time).map_err(wrong)?;
            }
            if step == STEPS / 2 {
                machine.set_input(Input::FeedForce, &[high]).map_err(wrong)?;
            }
            let _ = write!(outputs, "{time}");
            for (_, variable) in SHOWN.iter().filter_map(|name| Variable::named(name)) {
                if let Role::Output(output) = variable.role {
                    let _ = write!(outputs, ",{}", (output.value)(&mut machine) + 0.0);
                }
            }
            outputs.push('\n');
        }
        Ok(Self { inputs, outputs })
    }

    /// The files in an archive: the experiment, and a manifest that names it and the presets.
    pub fn files(&self) -> Vec<File> {
        let mut related = String::new();
        let mut add = |kind: &str, source: &str, role: &str, description: &str| {
            let description = escape(description);
            let _ = writeln!(
                related,
                "  <Related type=\"{kind}\" source=\"{source}\" role=\"{role}\" description=\"{description}\"/>"
            );
        };
        let tolerance = format!(
            "Outputs at each communication point of {SIZE} s; a host agrees if they differ by less than {TOLERANCE:e} \
             of their largest magnitude"
        );
        add(
            "text/csv",
            "reference_in.csv",
            "experiment/smoke-test",
            "Inputs, constant between instants; all else as it starts",
        );
        add("text/csv", "reference_out.csv", "result", &tolerance);
        for preset in PRESETS {
            let source = format!("../../resources/{}.ssv", preset.name);
            add("application/x-ssp-parameter-set", &source, "parameter", preset.description);
        }
        let manifest = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiReferences xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\"\n  \
             fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-ref\" fmi-ls:fmi-ls-version=\"1.0.0-alpha.1\"\n  \
             fmi-ls:fmi-ls-description=\"Layered Standard providing information on related files included in an FMU.\">\n\
             {related}</fmiReferences>\n"
        );
        vec![
            File::new(format!("{FOLDER}/fmi-ls-manifest.xml"), manifest),
            File::new(format!("{FOLDER}/reference_in.csv"), self.inputs.clone()),
            File::new(format!("{FOLDER}/reference_out.csv"), self.outputs.clone()),
        ]
    }

    /// The files that the FMI cross-check asks of an exporting tool, beside its archive: in a folder of its own.
    pub fn of_cross_check(&self, standard: Standard, platform: &str, fmu: Vec<u8>) -> Vec<File> {
        let version = if standard == Standard::Two { "2.0" } else { "3.0" };
        let (name, own) = (MODEL_IDENTIFIER, env!("CARGO_PKG_VERSION"));
        let folder = format!("fmus/{version}/cs/{platform}/{name}/{own}/{name}");
        let end = f64::from(STEPS) * SIZE;
        let options =
            format!("StartTime, 0.0\nStopTime, {end}\nStepSize, {SIZE}\nRelTol, {TOLERANCE:e}\n");
        let text = format!(
            "A down-the-hole hammer, version {own}, of FMI {version} for co-simulation.\n\nThe reference is the \
             engine's own solution, which is exact between events and does not depend on the step.\nOutputs agree if \
             they differ by less than {TOLERANCE:e} of their largest magnitude.\n"
        );
        let place = |suffix: &str| format!("{folder}/{name}{suffix}");
        vec![
            File::new(place(".fmu"), fmu),
            File::new(place("_in.csv"), self.inputs.clone()),
            File::new(place("_ref.csv"), self.outputs.clone()),
            File::new(place("_ref.opt"), options),
            File::new(format!("{folder}/ReadMe.txt"), text),
        ]
    }
}
