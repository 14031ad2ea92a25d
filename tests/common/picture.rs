//! Comparison of images. What differs is written as PNG: what is, what should be, and the difference.

use std::path::PathBuf;

/// An image in linear light: rows from the top, 1 (grey), 3 (RGB) or 4 (RGBA) values a pixel.
#[derive(Clone, Debug)]
pub struct Picture {
    pub size: [usize; 2],
    pub channels: usize,
    pub values: Vec<f32>,
}

/// How far two images may be apart.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Greatest difference of a value for a pixel to count as equal.
    pub value: f32,
    /// Pixels that may differ by more.
    pub pixels: usize,
}

impl Tolerance {
    /// Bit for bit (but for the sign of zero).
    pub const EXACT: Tolerance = Tolerance { value: 0.0, pixels: 0 };
}

/// What `compare` finds wrong; none if the images agree. Values that are not finite never agree with anything.
pub fn compare(actual: &Picture, expected: &Picture, tolerance: Tolerance) -> Result<(), String> {
    if (actual.size, actual.channels) != (expected.size, expected.channels) {
        return Err(format!(
            "{:?} pixels of {} values, expected {:?} of {}",
            actual.size, actual.channels, expected.size, expected.channels
        ));
    }
    let [width, height] = actual.size;
    let count = width * height * actual.channels;
    if actual.values.len() != count || expected.values.len() != count {
        return Err(format!("{} and {} values, expected {count}", actual.values.len(), expected.values.len()));
    }
    let (mut differing, mut worst) = (0, (0.0, 0));
    let pixels = actual.values.chunks(actual.channels).zip(expected.values.chunks(actual.channels));
    for (index, (a, e)) in pixels.enumerate() {
        let mut difference = 0.0_f32;
        for (a, e) in a.iter().zip(e) {
            if !a.is_finite() || !e.is_finite() {
                return Err(format!("pixel ({}, {}): {a}, expected {e}", index % width, index / width));
            }
            difference = difference.max((a - e).abs());
        }
        differing += usize::from(difference > tolerance.value);
        if difference > worst.0 {
            worst = (difference, index);
        }
    }
    if differing <= tolerance.pixels {
        return Ok(());
    }
    let (difference, index) = worst;
    let (x, y) = (index % width, index / width);
    Err(format!("{differing} pixels differ, by up to {difference} at ({x}, {y}); allowed: {tolerance:?}"))
}

/// Panics if the images do not agree, and says where it has written them.
#[track_caller]
pub fn assert_pictures(name: &str, actual: &Picture, expected: &Picture, tolerance: Tolerance) {
    if let Err(why) = compare(actual, expected, tolerance) {
        panic!("{name}: {why}; see {}", dump(name, actual, expected).display());
    }
}

/// Writes `target/failed/NAME.{actual,expected,difference}.png`; the difference is scaled so that the greatest is white.
fn dump(name: &str, actual: &Picture, expected: &Picture) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("../failed");
    std::fs::create_dir_all(&folder).expect("target/failed can be made");
    let save = |what: &str, picture: &Picture| {
        let path = folder.join(format!("{}.{what}.png", name.replace(['/', ' '], "_")));
        png(picture).save(&path).expect("target/failed can be written");
    };
    save("actual", actual);
    save("expected", expected);
    if actual.values.len() == expected.values.len() {
        let mut difference = actual.clone();
        difference.values.iter_mut().zip(&expected.values).for_each(|(a, e)| *a = (*a - e).abs());
        let greatest = difference.values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max);
        if greatest > 0.0 {
            difference.values.iter_mut().for_each(|v| *v /= greatest);
        }
        save("difference", &difference);
    }
    folder.join(format!("{name}.*.png"))
}

/// Opaque 8-bit sRGB; what is not finite is magenta.
fn png(picture: &Picture) -> image::RgbImage {
    let [width, height] = picture.size.map(|side| side as u32);
    image::RgbImage::from_fn(width, height, |x, y| {
        let at = (y * width + x) as usize * picture.channels;
        let Some(values) = picture.values.get(at..at + picture.channels) else { return image::Rgb([255, 0, 255]) };
        if values.iter().any(|v| !v.is_finite()) {
            return image::Rgb([255, 0, 255]);
        }
        let rgb = if picture.channels < 3 { [values[0]; 3] } else { [values[0], values[1], values[2]] };
        image::Rgb(rgb.map(|v| (srgb(v) * 255.0).round() as u8))
    })
}

fn srgb(linear: f32) -> f32 {
    let v = linear.clamp(0.0, 1.0);
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}
