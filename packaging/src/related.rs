//! Related files, by the layered standard FMI-LS-REF 1.0.0-alpha.1: an experiment with its results,
//! for a host to compare its own with, and the presets.

use crate::Failure;
use crate::archive::File;
use hammer::presets::PRESETS;
use hammer::variables::{Role, STEP_SIZE, VARIABLES};
use hammer::{InputValues, Machine, Parameters};
use quick_xml::escape::escape;

/// Where that standard has its files.
const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
/// Steps of the experiment, of the size that the description proposes.
const STEPS: u32 = 200;

const RESULT: &str = "reference.csv";
const EXPERIMENT: &str = "reference.exp";
const MEANING: &str = "The reference hammer, nothing set: all outputs at the communication points";

/// The files for the archive.
///
/// # Errors
/// If the engine fails on the reference hammer.
pub fn files() -> Result<Vec<File>, Failure> {
    let file = |name: &str, text: String| File::new(format!("{FOLDER}/{name}"), text);
    Ok(vec![
        file("fmi-ls-manifest.xml", manifest()),
        file(EXPERIMENT, experiment()),
        file(RESULT, results()?),
    ])
}

fn manifest() -> String {
    let related = |kind: &str, source: &str, role: &str, meaning: &str| {
        let meaning = escape(meaning);
        format!(
            "  <Related type=\"{kind}\" source=\"{source}\" role=\"{role}\" description=\"{meaning}\"/>\n"
        )
    };
    let presets = PRESETS.iter().map(|preset| {
        let source = format!("../../resources/{}.ssv", preset.name);
        related("application/x-ssp-parameter-set", &source, "parameter", preset.description)
    });
    let smoke = "experiment/smoke-test";
    let mut list = vec![
        related("application/x-ma-hs-experiments", EXPERIMENT, smoke, MEANING),
        related("text/csv", RESULT, "result", MEANING),
    ];
    list.extend(presets);
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiReferences xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
  fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref"
  fmi-ls:fmi-ls-version="1.0.0-alpha.1"
  fmi-ls:fmi-ls-description="Layered Standard providing information on related files included in an FMU.">
{}</fmiReferences>
"#,
        list.concat()
    )
}

fn experiment() -> String {
    let (step, end) = (STEP_SIZE, STEP_SIZE * f64::from(STEPS));
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<Experiments name="reference" description="{MEANING}">
  <Experiment name="reference" description="{MEANING}">
    <TransientSimulation startTime="0.0" stopTime="{end:?}" stepSize="{step:?}"/>
    <References source="{RESULT}"/>
  </Experiment>
</Experiments>
"#
    )
}

/// All outputs at the communication points, as numbers that read back to the bit.
fn results() -> Result<String, Failure> {
    let outputs = VARIABLES.iter().filter_map(|variable| match &variable.role {
        Role::Output(output) => Some((variable.name, output.value)),
        _ => None,
    });
    let (names, reads): (Vec<_>, Vec<_>) = outputs.unzip();
    let mut machine = Machine::new(&Parameters::default(), &InputValues::default(), 0.0)?;
    let mut text = format!("time,{}\n", names.join(","));
    for count in 0..=STEPS {
        let time = f64::from(count) * STEP_SIZE;
        if count > 0 {
            machine.advance(time)?;
        }
        // Nothing is nothing: -0 is written as 0.
        let values: Vec<f64> = reads.iter().map(|read| read(&mut machine) + 0.0).collect();
        let row = std::iter::once(time).chain(values).map(|value| format!("{value:?}"));
        text += &(row.collect::<Vec<_>>().join(",") + "\n");
    }
    Ok(text)
}
