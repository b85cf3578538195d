//! `model.png`: piston, bit and rock, drawn from their shapes.

use crate::Failure;

const WIDTH: usize = 320;
const HEIGHT: usize = 180;
/// Samples a pixel and direction: smooth edges.
const SAMPLES: usize = 4;

type Colour = [f64; 3];

const SKY: Colour = [244.0, 246.0, 248.0];
const ROCK: Colour = [146.0, 129.0, 112.0];
const CRUSHED: Colour = [176.0, 160.0, 142.0];
const CASING: Colour = [70.0, 84.0, 98.0];
const PISTON: Colour = [214.0, 120.0, 46.0];
const BIT: Colour = [120.0, 138.0, 156.0];
const BUTTON: Colour = [38.0, 46.0, 54.0];

/// The icon as PNG.
///
/// # Errors
/// None that is known; the encoder could refuse.
pub fn draw() -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, WIDTH as u32, HEIGHT as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    let pixels: Vec<u8> = (0..WIDTH * HEIGHT).flat_map(|i| pixel(i % WIDTH, i / WIDTH)).collect();
    writer.write_image_data(&pixels)?;
    writer.finish()?;
    Ok(bytes)
}

fn pixel(column: usize, row: usize) -> [u8; 3] {
    let mut sum = [0.0; 3];
    for sample in 0..SAMPLES * SAMPLES {
        let at = |base: usize, part: usize| base as f64 + (part as f64 + 0.5) / SAMPLES as f64;
        let colour = colour(at(column, sample % SAMPLES), at(row, sample / SAMPLES));
        sum.iter_mut().zip(colour).for_each(|(total, part)| *total += part);
    }
    sum.map(|total| (total / (SAMPLES * SAMPLES) as f64).round() as u8)
}

/// The scene lies on its side: the hole is drilled to the right.
fn colour(x: f64, y: f64) -> Colour {
    let off_axis = (y - HEIGHT as f64 / 2.0).abs();
    let inside = |from: f64, to: f64, half: f64| (from..to).contains(&x) && off_axis < half;
    let button = |along: f64, across: f64| (x - along).hypot(off_axis - across) < 6.0;
    if inside(70.0, 150.0, 24.0) {
        return PISTON;
    }
    if inside(168.0, 232.0, 20.0) || inside(232.0, 262.0, 44.0) {
        return BIT;
    }
    if x >= 261.0 && (button(262.0, 0.0) || button(262.0, 20.0) || button(260.0, 38.0)) {
        return BUTTON;
    }
    if inside(16.0, 214.0, 40.0) && off_axis > 28.0 || inside(16.0, 26.0, 40.0) {
        return CASING;
    }
    match off_axis {
        a if x > 268.0 => {
            if (x - 268.0).hypot(a * 0.4) < 18.0 {
                CRUSHED
            } else {
                ROCK
            }
        }
        a if a > 50.0 => ROCK,
        _ => SKY,
    }
}
