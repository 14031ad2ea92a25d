//! What the coded colours of a picture mean: sRGB, linear light, a power of it, or what an ICC profile says.

use std::io::{BufRead, Seek};

use image::{ImageBuffer, Rgba};
use moxcms::{ColorProfile, DataColorSpace, Layout, TransformOptions};

use super::{Fault, linear_from_srgb};

/// A coded channel is so far from what sRGB has for it, at most, where a profile is taken for sRGB's: half a code of 8 bits.
const MOST_OFF: f32 = 0.5 / 255.0;
/// How far from a number one is that was rounded to stand for it.
const ROUNDED: f64 = 5e-3;
/// Where red, green, blue and white of sRGB are.
const SRGB: [[f64; 2]; 4] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];
/// Pixels that are converted at a time.
const BATCH: usize = 1 << 16;

/// How colours are coded.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Coding {
    Srgb,
    /// Light is this power of the code; 1: it is the code.
    Power(f64),
    /// An ICC profile.
    Profile(Vec<u8>),
}

/// What a PNG says of its colours; sRGB if it says nothing. The first of these counts: its code points, its profile, that it is
/// sRGB, its gamma with its primaries (PNG, third edition, 4.3).
pub(super) fn of_png(source: impl BufRead + Seek) -> Result<Coding, Fault> {
    // What is no PNG is told when its pixels are read.
    let Ok(reader) = png::Decoder::new(source).read_info() else { return Ok(Coding::Srgb) };
    let info = reader.info();
    if let Some(points) = info.coding_independent_code_points {
        return match (points.color_primaries, points.transfer_function) {
            (1, 13) => Ok(Coding::Srgb),
            (1, 8) => Ok(Coding::Power(1.0)),
            (primaries, transfer) => {
                let why = format!("its colours have primaries {primaries} and transfer {transfer} (cICP)");
                Err((why, "sRGB (1 and 13) or linear light (1 and 8)".to_owned()))
            }
        };
    }
    if let Some(profile) = &info.icc_profile {
        return Ok(Coding::Profile(profile.to_vec()));
    }
    let Some(gamma) = info.gama_chunk.filter(|_| info.srgb.is_none()) else { return Ok(Coding::Srgb) };
    if let Some(found) = info.chrm_chunk {
        let places = [found.red, found.green, found.blue, found.white];
        let places = places.map(|(x, y)| [f64::from(x.into_value()), f64::from(y.into_value())]);
        let is_other = |(a, b): (&[f64; 2], &[f64; 2])| (0..2).any(|i| (a[i] - b[i]).abs() > ROUNDED);
        if places.iter().zip(&SRGB).any(is_other) {
            let places = places.map(|place| place.map(|c| c as f32));
            return Err((
                format!("its red, green, blue and white are at {places:?} (cHRM)"),
                format!("sRGB's, {SRGB:?}"),
            ));
        }
    }
    match f64::from(gamma.into_value()) {
        gamma if (gamma - 1.0 / 2.2).abs() < ROUNDED => Ok(Coding::Srgb),
        gamma if (0.1..=10.0).contains(&gamma) => Ok(Coding::Power(1.0 / gamma)),
        gamma => Err((format!("its gamma is {}", gamma as f32), "0.1 to 10; 1 is linear light".to_owned())),
    }
}

/// Linear premultiplied pixels of coded ones with straight alpha.
pub(super) fn linear(coding: &Coding, picture: &ImageBuffer<Rgba<u16>, Vec<u16>>) -> Result<Vec<[f32; 4]>, Fault> {
    let one = f32::from(u16::MAX);
    let table = |curve: &dyn Fn(f64) -> f64| -> Vec<f32> {
        (0..=u16::MAX).map(|code| curve(f64::from(code) / f64::from(u16::MAX)) as f32).collect()
    };
    let through = |table: Vec<f32>| {
        let pixel = |&Rgba([r, g, b, a]): &Rgba<u16>| {
            let alpha = f32::from(a) / one;
            let [r, g, b] = [r, g, b].map(|code| table[usize::from(code)] * alpha);
            [r, g, b, alpha]
        };
        picture.pixels().map(pixel).collect()
    };
    let profile = match coding {
        Coding::Srgb => return Ok(through(table(&linear_from_srgb))),
        Coding::Power(power) => return Ok(through(table(&|code| code.powf(*power)))),
        Coding::Profile(profile) => Conversion::new(profile)?,
    };
    if profile.is_srgb()? {
        return Ok(through(table(&linear_from_srgb)));
    }
    let mut pixels = Vec::with_capacity(picture.len() / 4);
    for batch in picture.as_raw().chunks(4 * BATCH) {
        let codes: Vec<[f32; 3]> =
            batch.as_chunks().0.iter().map(|[r, g, b, _]| [r, g, b].map(|c| f32::from(*c) / one)).collect();
        for (colour, code) in profile.srgb(&codes)?.into_iter().zip(batch.as_chunks::<4>().0) {
            let alpha = f32::from(code[3]) / one;
            let [r, g, b] = colour.map(|c| linear_from_srgb(f64::from(c)) as f32 * alpha);
            pixels.push([r, g, b, alpha]);
        }
    }
    Ok(pixels)
}

/// From a profile's codes to those of sRGB.
struct Conversion {
    name: String,
    is_grey: bool,
    transform: std::sync::Arc<dyn moxcms::TransformExecutor<f32> + Send + Sync>,
}

impl Conversion {
    fn new(bytes: &[u8]) -> Result<Conversion, Fault> {
        const EXPECTED: &str = "a profile of sRGB, linear light, or other red, green and blue or grey; or none";
        let unusable = |why: moxcms::CmsError| (format!("its ICC profile cannot be used: {why}"), EXPECTED.to_owned());
        let profile = ColorProfile::new_from_slice(bytes).map_err(unusable)?;
        let name = format!("{:?}", profile.color_space);
        let is_grey = match profile.color_space {
            DataColorSpace::Rgb => false,
            DataColorSpace::Gray => true,
            _ => return Err((format!("its ICC profile is of {name}"), EXPECTED.to_owned())),
        };
        let from = if is_grey { Layout::Gray } else { Layout::Rgb };
        let srgb = ColorProfile::new_srgb();
        let options = TransformOptions { prefer_fixed_point: false, ..TransformOptions::default() };
        let transform = profile.create_transform_f32(from, &srgb, Layout::Rgb, options).map_err(unusable)?;
        Ok(Conversion { name, is_grey, transform })
    }

    /// Colours in sRGB's codes; what it has not is the nearest that it has, channel by channel.
    fn srgb(&self, codes: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, Fault> {
        let mut found = vec![[0.0; 3]; codes.len()];
        let greys: Vec<f32>;
        let from = if self.is_grey {
            greys = codes.iter().map(|code| code[0]).collect();
            &greys[..]
        } else {
            codes.as_flattened()
        };
        let done = self.transform.transform(from, found.as_flattened_mut());
        done.map_err(|why| {
            (format!("its ICC profile of {} cannot be used: {why}", self.name), "another profile".to_owned())
        })?;
        found.iter_mut().flatten().for_each(|channel| *channel = channel.clamp(0.0, 1.0));
        Ok(found)
    }

    /// Whether sRGB's own codes stay what they are.
    fn is_srgb(&self) -> Result<bool, Fault> {
        const STEPS: u32 = 16;
        let greys = (0..=STEPS).map(|step| [step as f32 / STEPS as f32; 3]);
        // Within the gamut: beyond it, other primaries are cut off to the same.
        let colours = (1..7).map(|bits: u32| [0, 1, 2].map(|i| if bits >> i & 1 == 1 { 0.75 } else { 0.25 }));
        let codes: Vec<[f32; 3]> = if self.is_grey { greys.collect() } else { greys.chain(colours).collect() };
        let near = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).all(|i| (a[i] - b[i]).abs() <= MOST_OFF);
        Ok(self.srgb(&codes)?.iter().zip(&codes).all(near))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    const CODES: [[u16; 4]; 3] = [[65535, 32768, 6554, 65535], [13107, 0, 65535, 32768], [40000, 40000, 40000, 65535]];

    fn picture() -> ImageBuffer<Rgba<u16>, Vec<u16>> {
        ImageBuffer::from_raw(3, 1, CODES.as_flattened().to_vec()).expect("three pixels")
    }

    /// A PNG of 16 bits with what is set.
    fn png_with(set: impl FnOnce(&mut png::Info)) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut info = png::Info::with_size(3, 1);
        (info.bit_depth, info.color_type) = (png::BitDepth::Sixteen, png::ColorType::Rgba);
        set(&mut info);
        let mut writer =
            png::Encoder::with_info(&mut bytes, info).expect("an encoder").write_header().expect("a header");
        let values: Vec<u8> = CODES.as_flattened().iter().flat_map(|code| code.to_be_bytes()).collect();
        writer.write_image_data(&values).expect("pixels");
        writer.finish().expect("an end");
        bytes
    }

    fn coding(set: impl FnOnce(&mut png::Info)) -> Result<Coding, Fault> {
        of_png(Cursor::new(png_with(set)))
    }

    fn gamma(value: f32) -> impl FnOnce(&mut png::Info) {
        move |info| info.source_gamma = Some(png::ScaledFloat::new(value))
    }

    #[test]
    fn a_png_says_how_it_is_coded() {
        assert_eq!(coding(|_| ()), Ok(Coding::Srgb));
        assert_eq!(coding(gamma(0.45455)), Ok(Coding::Srgb));
        assert_eq!(coding(gamma(1.0)), Ok(Coding::Power(1.0)));
        assert!(matches!(coding(gamma(1.0 / 1.8)), Ok(Coding::Power(power)) if (power - 1.8).abs() < 1e-3));
        assert!(coding(gamma(0.01)).is_err_and(|(why, _)| why.contains("gamma is 0.01")));
        let profile = ColorProfile::new_display_p3().encode().expect("a profile");
        let with_profile = coding(|info| info.icc_profile = Some(profile.clone().into()));
        assert_eq!(with_profile, Ok(Coding::Profile(profile)));
        let place = |x: f32, y: f32| (png::ScaledFloat::new(x), png::ScaledFloat::new(y));
        let primaries = |green| png::SourceChromaticities {
            white: place(0.3127, 0.3290),
            red: place(0.64, 0.33),
            green,
            blue: place(0.15, 0.06),
        };
        let both = |green| {
            coding(move |info| {
                info.source_chromaticities = Some(primaries(green));
                info.source_gamma = Some(png::ScaledFloat::new(1.0));
            })
        };
        assert_eq!(both(place(0.30, 0.60)), Ok(Coding::Power(1.0)));
        assert!(both(place(0.21, 0.71)).is_err_and(|(why, _)| why.contains("(cHRM)") && why.contains("0.71")));
        assert_eq!(of_png(Cursor::new(b"no picture".to_vec())), Ok(Coding::Srgb));
    }

    /// Light of each channel by the closed form of its coding.
    #[test]
    fn codes_become_light() {
        let expect = |coding: Coding, curve: &dyn Fn(f64) -> f64, tolerance: f64| {
            let found = linear(&coding, &picture()).expect("pixels");
            for (pixel, code) in found.iter().zip(CODES) {
                let alpha = f64::from(code[3]) / 65535.0;
                for channel in 0..3 {
                    let light = curve(f64::from(code[channel]) / 65535.0) * alpha;
                    assert!(
                        (f64::from(pixel[channel]) - light).abs() < tolerance,
                        "{tolerance}: {pixel:?}, {code:?}: {light}"
                    );
                }
            }
        };
        expect(Coding::Srgb, &linear_from_srgb, 1e-6);
        expect(Coding::Power(1.0), &|code| code, 1e-6);
        expect(Coding::Power(1.8), &|code| code.powf(1.8), 1e-6);
        let encoded = |profile: ColorProfile| Coding::Profile(profile.encode().expect("a profile"));
        // Taken for what it is, exactly.
        assert_eq!(linear(&encoded(ColorProfile::new_srgb()), &picture()), linear(&Coding::Srgb, &picture()));
        // Of profiles, as far as the library's tables go.
        let mut light = ColorProfile::new_srgb();
        light.cicp = None;
        let straight = Some(moxcms::ToneReprCurve::Parametric(vec![1.0]));
        (light.red_trc, light.green_trc, light.blue_trc) = (straight.clone(), straight.clone(), straight);
        expect(encoded(light), &|code| code, 2e-3);
    }

    #[test]
    fn profiles_of_other_primaries_are_converted() {
        let p3 = Coding::Profile(ColorProfile::new_display_p3().encode().expect("a profile"));
        let pixel = |r: u16, g: u16, b: u16| {
            let picture = ImageBuffer::from_raw(1, 1, vec![r, g, b, 65535]).expect("a pixel");
            linear(&p3, &picture).expect("a pixel")[0]
        };
        let near = |a: [f32; 4], b: [f64; 3]| (0..3).all(|i| (f64::from(a[i]) - b[i]).abs() < 4e-3);
        // Greys are those of sRGB; a colour within it is turned by the matrix of the two primaries.
        let half = linear_from_srgb(0.5);
        assert!(near(pixel(32768, 32768, 32768), [half; 3]), "{:?}", pixel(32768, 32768, 32768));
        let [r, g, b] = [40000_u16, 32768, 30000].map(|code| linear_from_srgb(f64::from(code) / 65535.0));
        let matrix = [[1.2249, -0.2247, 0.0], [-0.0420, 1.0419, 0.0], [-0.0197, -0.0786, 1.0979]];
        let expected = matrix.map(|[x, y, z]| x * r + y * g + z * b);
        assert!(near(pixel(40000, 32768, 30000), expected), "{:?} {expected:?}", pixel(40000, 32768, 30000));
        // What sRGB does not have is cut off.
        assert!(near(pixel(0, 65535, 0), [0.0, 1.0, 0.0]));
        let damaged = linear(&Coding::Profile(vec![7; 200]), &picture());
        assert!(damaged.is_err_and(|(why, _)| why.contains("its ICC profile cannot be used")));
    }
}
