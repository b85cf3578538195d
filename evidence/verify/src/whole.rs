//! Whole error by the mesh: of twenty drawn hammers that repeat their blow, and of the presets, what a
//! user reads on coarser meshes against that on a fine one of the highest degree.

use hammer::presets::PRESETS;
use hammer::sensitivity::Scene;
use hammer::{Body, Error, MAX_DEGREE, Machine, Parameters, Segment};
use std::f64::consts::PI;

/// What is read: rates, then forces, then stress.
pub const NAMES: [&str; 6] = [
    "`rop`",
    "tip rate",
    "blow energy",
    "largest contact force",
    "largest rock force",
    "largest stress",
];
/// Scenes that are drawn.
pub const DRAWN: usize = 20;
/// Blows that are left out, and those that are read.
const SETTLE: u64 = 60;
const READ: u64 = 6;
/// Instants of a blow at which stresses are looked at: so many while a wave passes the shorter body.
const LOOKS: f64 = 24.0;
/// The fine mesh has spans of this part of the front's width.
const FINE: f64 = 0.8;

/// A scene with a name.
pub struct Named {
    /// Preset, or number of the draw.
    pub name: String,
    /// The scene.
    pub scene: Scene,
}

/// A plain congruential sequence in (0, 1): the same on every machine.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn spread(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }
}

/// A hammer from 2 to 8 inches: bodies of one to three sections, contact, damping, rock and drive apart
/// by as much as those of the presets and more.
fn drawn(random: &mut Random) -> Option<Scene> {
    let mut scene = Scene::default();
    let p = &mut scene.parameters;
    let area = random.spread(1e-3, 1e-2);
    let mut body = |length: f64, segment: &mut [Segment]| {
        let count = 1 + (3.0 * random.unit()) as usize;
        for part in &mut segment[..count] {
            *part = Segment {
                length: length * random.between(0.6, 1.4) / count as f64,
                area: area * random.between(0.6, 1.6),
            };
        }
        count
    };
    p.piston.segments = body(0.4, &mut p.piston.segment);
    p.bit.segments = body(0.3, &mut p.bit.segment);
    let shorter = random.between(0.4, 1.0);
    p.piston.segment.iter_mut().for_each(|part| part.length *= shorter);
    p.mesh.degree = 5;
    (p.piston.elements, p.bit.elements) = (40, 40);
    p.material.damping_time = p.damping_time_of(random.spread(1e-3, 1e-2))?;
    let front = p.front_width();
    p.contact.stiffness *= front / random.between(3e-3, 8e-3);
    p.drive.stroke = random.spread(0.01, 0.06);
    p.contact.initial_gap = p.drive.stroke;
    let (mass, speed) = (p.piston_mass(), random.between(5.0, 10.0));
    p.drive.amplitude = 0.8 * mass * speed * speed / (4.0 * p.drive.stroke);
    let stretch = p.material.youngs_modulus * area / 0.3;
    p.rock.stiffness = stretch * random.spread(0.03, 0.4);
    p.rock.unloading_ratio = random.between(2.0, 6.0);
    let critical = 2.0 * (p.rock.stiffness * p.bit_mass()).sqrt();
    p.rock.viscosity = critical * random.between(0.1, 0.9);
    p.rock.energy_barrier = 0.5 * mass * speed * speed * random.spread(1e-3, 2e-2);
    scene.inputs.feed_force = p.drive.amplitude * random.between(1.0, 3.0);
    Some(scene)
}

/// The scene on spans of at most this length (m) and a degree.
pub fn meshed(scene: &Scene, degree: usize, span: f64) -> Scene {
    let mut scene = *scene;
    let p = &mut scene.parameters;
    let spans = |body: Body| -> usize {
        let sections = p.sections(body);
        sections.as_slice().iter().map(|s| (s.length / span).ceil() as usize).sum()
    };
    let [piston, bit] = Body::ALL.map(spans);
    (p.mesh.degree, p.piston.elements, p.bit.elements) = (degree, piston, bit);
    scene
}

/// The finest mesh.
pub fn fine(scene: &Scene) -> Scene {
    meshed(scene, MAX_DEGREE, FINE * scene.parameters.front_width())
}

/// What a user reads of settled blows; `None` if the hammer does not strike often enough.
///
/// # Errors
/// Whatever the engine says.
pub fn response(scene: &Scene) -> Result<Option<[f64; 6]>, Error> {
    let mut m = Machine::new(&scene.parameters, &scene.inputs, 0.0)?;
    let to = |m: &mut Machine, blows: u64, peaks: &mut [f64; 2]| -> Result<bool, Error> {
        while m.counters().blows < blows {
            if m.time() > 8.0 {
                return Ok(false);
            }
            m.advance(m.time() + 2e-3)?;
            if blows > SETTLE {
                let now = m.peaks();
                *peaks = [peaks[0].max(now.contact_force()), peaks[1].max(now.rock_force())];
            }
        }
        Ok(true)
    };
    let mut peaks = [0.0; 2];
    if !to(&mut m, SETTLE, &mut peaks)? {
        return Ok(None);
    }
    let (mut rop, mut gain, mut energy, mut time) = (0.0, 0.0, 0.0, 0.0);
    for blow in 1..=READ {
        if !to(&mut m, SETTLE + blow, &mut peaks)? {
            return Ok(None);
        }
        let Some(blow) = m.blow() else { return Ok(None) };
        rop += blow.rop * blow.period;
        gain += blow.penetration;
        energy += blow.energy;
        time += blow.period;
    }
    let stress = stress(scene, &m)?;
    Ok(Some([rop / time, gain / time, energy / READ as f64, peaks[0], peaks[1], stress]))
}

/// Largest stress of the next blow, by looks at it.
fn stress(scene: &Scene, m: &Machine) -> Result<f64, Error> {
    let p = &scene.parameters;
    let mut ahead = Machine::new(p, &scene.inputs, 0.0)?;
    ahead.restore(&m.state())?;
    let Some(blow) = m.blow() else { return Ok(f64::NAN) };
    let scales = p.timescales();
    let transit = scales.piston_transit.min(scales.bit_transit);
    // The next blow, as the last: settled ones are alike.
    let begin = blow.time + blow.period - transit;
    let quarter = 0.5 * PI * ((p.piston_mass() + p.bit_mass()) / p.rock.stiffness).sqrt();
    let end = begin + 6.0 * (scales.piston_transit + scales.bit_transit) + 2.0 * quarter;
    let (mut now, mut most) = (begin.max(ahead.time()), 0.0f64);
    while now < end {
        ahead.advance(now)?;
        let profile = ahead.profile();
        let all = profile.piston_stress.iter().chain(&profile.bit_stress);
        most = all.fold(most, |most, s| most.max(s.abs()));
        now += transit / LOOKS;
    }
    Ok(most)
}

/// The drawn scenes that repeat their blow on the fine mesh, and the presets without rods, each with what
/// is read there.
///
/// # Errors
/// Whatever the engine says.
pub fn scenes() -> Result<Vec<(Named, [f64; 6])>, Error> {
    let (mut random, mut list) = (Random(41), Vec::new());
    while list.len() < DRAWN {
        let Some(scene) = drawn(&mut random) else { continue };
        if scene.parameters.validate().is_err() {
            continue;
        }
        let fine = fine(&scene);
        let Some(values) = response(&fine)? else { continue };
        if settled(&fine)? {
            list.push((Named { name: format!("drawn {}", list.len() + 1), scene }, values));
        }
    }
    for preset in PRESETS {
        let (parameters, inputs) = preset.start();
        let scene = Scene { parameters, inputs };
        if parameters.drill.rods > 0 {
            continue;
        }
        if let Some(values) = response(&fine(&scene))? {
            list.push((Named { name: preset.name.into(), scene }, values));
        }
    }
    Ok(list)
}

/// True if the last blows are alike to a thousandth.
fn settled(scene: &Scene) -> Result<bool, Error> {
    let mut m = Machine::new(&scene.parameters, &scene.inputs, 0.0)?;
    while m.counters().blows < SETTLE && m.time() < 8.0 {
        m.advance(m.time() + 2e-3)?;
    }
    let mut last = m.blow().map_or(0.0, |blow| blow.tip_rate);
    for _ in 0..4 {
        let blows = m.counters().blows;
        while m.counters().blows == blows && m.time() < 8.0 {
            m.advance(m.time() + 2e-3)?;
        }
        let now = m.blow().map_or(0.0, |blow| blow.tip_rate);
        if (now / last - 1.0).abs() > 1e-3 {
            return Ok(false);
        }
        last = now;
    }
    Ok(true)
}

/// Relative errors of a scene on spans of at most a length (m) and a degree; `None` where there is no
/// such mesh.
///
/// # Errors
/// Whatever the engine says.
pub fn errors(
    scene: &Scene,
    exact: &[f64; 6],
    degree: usize,
    span: f64,
) -> Result<Option<[f64; 6]>, Error> {
    let scene = meshed(scene, degree, span);
    if scene.parameters.validate().is_err() {
        return Ok(None);
    }
    let found = response(&scene)?;
    Ok(found.map(|found| std::array::from_fn(|k| found[k] / exact[k] - 1.0)))
}

/// A hammer's own lengths, m: the shorter of its bodies, and its sharpest front.
pub fn lengths(p: &Parameters) -> [f64; 2] {
    let [piston, bit] = Body::ALL.map(|body| p.sections(body).length());
    [piston.min(bit), p.front_width()]
}
