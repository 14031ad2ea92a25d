//! Pictures: PNG, EXR, JPEG (read only), animated GIF (written only). All in memory is linear light with premultiplied
//! alpha, rows from the top, unless said; 8-bit pixels are sRGB with straight alpha.

mod coded;
mod contained;
mod layered;
mod openexr;
mod profile;

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Cursor, Write};
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, Layer, LayerAttributes, Text,
    WritableImage,
};

use super::{WriteError, file, write_atomic};

pub use coded::read_png;
pub(super) use coded::{decode, read_coded};
pub use layered::{Channel, Header, Packing, write_exr_layered};
pub(super) use openexr::read_colours;
pub use openexr::{Channels, Wanted, read_exr, read_named};

/// Name of the text that a picture may hold beside its pixels.
const NOTE: &str = "celfx";

/// Largest side of a picture that is read, in pixels: that of a shot.
const MAX_SIDE: u32 = 16_384;

/// The fault of a file, and what was expected.
pub(super) type Fault = (String, String);

/// The allowed sizes of a picture. Checked before any of the picture is decoded.
#[derive(Clone, Copy, Debug)]
pub(super) enum Fit {
    /// Any of so many pixels at most.
    AtMost(u64),
    /// The shot's.
    Exactly([u32; 2]),
    /// Any, and only the first row is taken.
    Row,
}

impl Fit {
    /// For whoever does not know the size.
    pub(super) const ANY: Fit = Fit::AtMost(1 << 24);

    /// The size of what is taken of a picture of `size`, if that may be.
    fn checked(self, size: [u32; 2]) -> Result<[u32; 2], Fault> {
        let [width, height] = size;
        let pixels = u64::from(width) * u64::from(height);
        let (is_fit, expected) = match self {
            Fit::Exactly(wanted) => (size == wanted, format!("{} x {}, as the shot's size", wanted[0], wanted[1])),
            Fit::Row => (width <= MAX_SIDE, format!("a first row of at most {MAX_SIDE} pixels")),
            Fit::AtMost(most) => {
                let expected = format!("at most {MAX_SIDE} pixels a side and {most} in all");
                (width.max(height) <= MAX_SIDE && pixels <= most, expected)
            }
        };
        match is_fit && pixels > 0 {
            true => Ok(if matches!(self, Fit::Row) { [width, 1] } else { size }),
            false => Err((format!("the picture has {width} x {height} pixels"), expected)),
        }
    }
}

/// A picture in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture<P> {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Width x height pixels, rows from the top.
    pub pixels: Vec<P>,
}

pub use crate::srgb::linear_from_srgb;

/// The sRGB transfer function (IEC 61966-2-1) from linear light to the coded value; both 0 to 1.
pub fn srgb_from_linear(linear: f64) -> f64 {
    match linear <= 0.003_130_8 {
        true => 12.92 * linear,
        false => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
    }
}

/// 8-bit sRGB pixels with straight alpha of linear premultiplied ones. What is outside 0 to 1 is clamped, NaN is 0.
pub fn srgb8(pixels: &[[f32; 4]]) -> Vec<[u8; 4]> {
    // Flat tones: most pixels are as the one before, and the power function is what costs.
    let mut before = ([0.0f32; 4], [0u8; 4]);
    let convert = |pixel: &[f32; 4]| {
        if *pixel != before.0 {
            before = (*pixel, srgb8_pixel(*pixel));
        }
        before.1
    };
    pixels.iter().map(convert).collect()
}

fn srgb8_pixel([r, g, b, a]: [f32; 4]) -> [u8; 4] {
    let alpha = f64::from(a).clamp(0.0, 1.0);
    // The conversion to u8 saturates and makes 0 of NaN.
    let byte = |unit: f64| (unit.clamp(0.0, 1.0) * 255.0).round() as u8;
    let colour = |c: f32| if alpha > 0.0 { byte(srgb_from_linear(f64::from(c).max(0.0) / alpha)) } else { 0 };
    [colour(r), colour(g), colour(b), byte(alpha)]
}

fn invalid(why: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, why.into())
}

/// Refuses an empty picture and one whose pixels do not fill its size.
fn check_size(size: [u32; 2], count: usize) -> io::Result<()> {
    let [width, height] = size;
    if count == 0 || u64::from(width) * u64::from(height) != count as u64 {
        return Err(invalid(format!("{count} pixels do not make a picture of {width} x {height}")));
    }
    Ok(())
}

/// Writes linear premultiplied pixels as an 8-bit sRGB PNG with straight alpha. Atomic.
pub fn write_png(path: &Path, size: [u32; 2], pixels: &[[f32; 4]]) -> Result<(), WriteError> {
    write_png8(path, size, &srgb8(pixels))
}

/// Writes 8-bit sRGB pixels with straight alpha as a PNG. Atomic.
pub fn write_png8(path: &Path, size: [u32; 2], pixels: &[[u8; 4]]) -> Result<(), WriteError> {
    write_png8_noted(path, size, pixels, None, None)
}

/// As [`write_png8`], for another gamma of displays if there is one, with a text of Latin letters in a `tEXt` chunk named [`NOTE`].
pub(super) fn write_png8_noted(
    path: &Path,
    size: [u32; 2],
    pixels: &[[u8; 4]],
    gamma: Option<f64>,
    note: Option<&str>,
) -> Result<(), WriteError> {
    write_encoded(path, |buffer| {
        check_size(size, pixels.len())?;
        let mut encoder = png::Encoder::new(buffer, size[0], size[1]);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::Filter::Adaptive);
        if let Some(gamma) = gamma {
            encoder.set_source_gamma(png::ScaledFloat::new((1.0 / gamma) as f32));
        }
        if let Some(note) = note {
            encoder.add_text_chunk(NOTE.to_owned(), note.to_owned())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(pixels.as_flattened())?;
        Ok(writer.finish()?)
    })
}

/// Encodes into memory, then writes: some encoders write their last bytes when dropped, where errors would be lost.
fn write_encoded(path: &Path, encode: impl FnOnce(&mut Cursor<Vec<u8>>) -> io::Result<()>) -> Result<(), WriteError> {
    write_atomic(path, |file: &mut BufWriter<File>| {
        let mut buffer = Cursor::new(Vec::new());
        encode(&mut buffer)?;
        file.write_all(buffer.get_ref())
    })
}

fn from_image(error: image::ImageError) -> io::Error {
    match error {
        image::ImageError::IoError(error) => error,
        error => io::Error::other(error),
    }
}

/// A pixel type of an EXR file.
pub trait ExrPixel: Copy {
    /// Names of the channels.
    const CHANNELS: &'static [&'static str];
    /// The value in channel number `channel` of [`ExrPixel::CHANNELS`].
    fn channel(self, channel: usize) -> f32;
}

impl ExrPixel for f32 {
    const CHANNELS: &'static [&'static str] = &["Y"];
    fn channel(self, _: usize) -> f32 {
        self
    }
}

impl ExrPixel for [f32; 3] {
    const CHANNELS: &'static [&'static str] = &["R", "G", "B"];
    fn channel(self, channel: usize) -> f32 {
        self[channel]
    }
}

impl ExrPixel for [f32; 4] {
    const CHANNELS: &'static [&'static str] = &["R", "G", "B", "A"];
    fn channel(self, channel: usize) -> f32 {
        self[channel]
    }
}

/// Writes an EXR of 32-bit floats, ZIP-compressed: channel `Y` for `f32`, `R G B` for `[f32; 3]`, `R G B A`
/// (premultiplied) for `[f32; 4]`. Values pass unchanged, infinities and NaN too. Atomic.
pub fn write_exr<P: ExrPixel>(path: &Path, size: [u32; 2], pixels: &[P]) -> Result<(), WriteError> {
    write_exr_noted(path, size, pixels, None)
}

/// As [`write_exr`], with a text of Latin letters in an attribute named [`NOTE`].
pub(super) fn write_exr_noted<P: ExrPixel>(
    path: &Path,
    size: [u32; 2],
    pixels: &[P],
    note: Option<&str>,
) -> Result<(), WriteError> {
    let channel =
        |(i, name): (usize, &&str)| ((*name).to_owned(), pixels.iter().map(|pixel| pixel.channel(i)).collect());
    write_exr_layer(path, size, P::CHANNELS.iter().enumerate().map(channel).collect(), note)
}

/// As [`write_exr`], of channels by their names, each of as many values as the picture has pixels. Atomic.
pub fn write_exr_channels(path: &Path, size: [u32; 2], channels: &[(String, Vec<f32>)]) -> Result<(), WriteError> {
    write_exr_layer(path, size, channels.to_vec(), None)
}

fn write_exr_layer(
    path: &Path,
    size: [u32; 2],
    channels: Vec<(String, Vec<f32>)>,
    note: Option<&str>,
) -> Result<(), WriteError> {
    write_encoded(path, |buffer| {
        check_size(size, channels.iter().map(|(_, values)| values.len()).min().unwrap_or(0))?;
        let channel =
            |(name, values): (String, Vec<f32>)| AnyChannel::new(Text::from(&name[..]), FlatSamples::F32(values));
        let channels = AnyChannels::sort(channels.into_iter().map(channel).collect());
        let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::SMALL_LOSSLESS };
        let size = (size[0] as usize, size[1] as usize);
        let note = note.map(|note| (Text::from(NOTE), AttributeValue::Text(Text::from(note))));
        let attributes = LayerAttributes { other: note.into_iter().collect(), ..LayerAttributes::default() };
        let layer = Layer::new(size, attributes, encoding, channels);
        let image = exr::prelude::Image::from_layer(layer);
        image.write().to_buffered(buffer).map_err(failed)
    })
}

fn failed(error: exr::error::Error) -> io::Error {
    match error {
        exr::error::Error::Io(error) => error,
        error => io::Error::other(error),
    }
}

/// The text that a PNG was written with beside its pixels, if it was.
pub(super) fn png_note(path: &Path) -> Option<String> {
    let decoder = png::Decoder::new(BufReader::new(file::open(path).ok()?));
    let reader = decoder.read_info().ok()?;
    let texts = &reader.info().uncompressed_latin1_text;
    texts.iter().find(|text| text.keyword == NOTE).map(|text| text.text.clone())
}

/// The text that an EXR file was written with beside its pixels, if it was.
pub(super) fn exr_note(path: &Path) -> Option<String> {
    let metadata = exr::meta::MetaData::read_from_file(path, false).ok()?;
    match metadata.headers.first()?.own_attributes.other.get(&Text::from(NOTE))? {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    }
}

/// One picture of many of equal size: `columns` in a row (as many rows as it takes), `gap` transparent pixels between.
/// None if `frames` is empty or one of them has not the pixels of `size`.
pub fn contact_sheet(size: [u32; 2], frames: &[Vec<[u8; 4]>], columns: u32, gap: u32) -> Option<Picture<[u8; 4]>> {
    let pixels = size[0] as usize * size[1] as usize;
    if frames.is_empty() || pixels == 0 || frames.iter().any(|f| f.len() != pixels) {
        return None;
    }
    let columns = columns.clamp(1, frames.len() as u32);
    let rows = (frames.len() as u32).div_ceil(columns);
    let side = |count: u32, side: u32| count.checked_mul(side)?.checked_add((count - 1).checked_mul(gap)?);
    let [width, height] = [side(columns, size[0])?, side(rows, size[1])?];
    let mut sheet = vec![[0; 4]; width as usize * height as usize];
    for (i, frame) in frames.iter().enumerate() {
        let [column, row] = [i % columns as usize, i / columns as usize];
        let left = column * (size[0] + gap) as usize;
        let top = row * (size[1] + gap) as usize;
        for (y, line) in frame.chunks_exact(size[0] as usize).enumerate() {
            let start = (top + y) * width as usize + left;
            sheet[start..start + line.len()].copy_from_slice(line);
        }
    }
    Some(Picture { size: [width, height], pixels: sheet })
}

/// Writes an animated GIF that repeats for ever. All frames share one palette, in which flat tones keep their exact
/// colour, so that nothing flickers; pixels of alpha below one half are transparent. `fps` above 0: delays are whole
/// hundredths of a second (at least 2, which is what viewers honour), spread so that the mean is right. Atomic.
pub fn write_gif(path: &Path, size: [u32; 2], frames: &[Vec<[u8; 4]>], fps: f64) -> Result<(), WriteError> {
    use image::codecs::gif::{GifEncoder, Repeat};
    write_encoded(path, |buffer| {
        if !(fps > 0.0 && fps.is_finite()) {
            return Err(invalid(format!("{fps} frames per second")));
        }
        if frames.is_empty() || size.iter().any(|&s| s > u32::from(u16::MAX)) {
            return Err(invalid("a GIF holds at least one frame, of at most 65535 pixels a side"));
        }
        for frame in frames {
            check_size(size, frame.len())?;
        }
        let palette = super::palette::Palette::of(frames);
        let mut encoder = GifEncoder::new(buffer);
        encoder.set_repeat(Repeat::Infinite).map_err(from_image)?;
        for (i, frame) in frames.iter().enumerate() {
            let bytes: Vec<u8> = frame.iter().flat_map(|&pixel| palette.nearest(pixel)).collect();
            let frame = image::RgbaImage::from_raw(size[0], size[1], bytes);
            let frame = frame.ok_or_else(|| invalid("the pixels do not fill the picture"))?;
            let delay = image::Delay::from_numer_denom_ms(10 * hundredths(i, fps), 1);
            encoder.encode_frame(image::Frame::from_parts(frame, 0, 0, delay)).map_err(from_image)?;
        }
        Ok(())
    })
}

/// Writes an animated PNG that repeats for ever: 8-bit sRGB with straight alpha, every pixel as it is. `fps` above 0.
/// Viewers that know no animations show its first frame. Atomic.
pub fn write_apng(path: &Path, size: [u32; 2], frames: &[Vec<[u8; 4]>], fps: f64) -> Result<(), WriteError> {
    write_encoded(path, |buffer| {
        if !(fps > 0.0 && fps.is_finite()) || frames.is_empty() {
            return Err(invalid(format!("{} frames, {fps} per second", frames.len())));
        }
        for frame in frames {
            check_size(size, frame.len())?;
        }
        let mut encoder = png::Encoder::new(buffer, size[0], size[1]);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let count = u32::try_from(frames.len()).map_err(io::Error::other)?;
        encoder.set_animated(count, 0)?;
        let [seconds, parts] = delay(fps);
        encoder.set_frame_delay(seconds, parts)?;
        let mut writer = encoder.write_header()?;
        frames.iter().try_for_each(|frame| writer.write_image_data(frame.as_flattened()))?;
        Ok(writer.finish()?)
    })
}

/// The time between two frames as a fraction of a second: exact for whole rates, to a thousandth for others.
fn delay(fps: f64) -> [u16; 2] {
    let most = f64::from(u16::MAX);
    match fps {
        fps if fps.fract() == 0.0 && fps <= most => [1, fps as u16],
        fps if fps * 1000.0 <= most => [1000, (fps * 1000.0).round().max(1.0) as u16],
        fps => [1, fps.round().min(most) as u16],
    }
}

/// How long frame `i` stays, in hundredths of a second.
fn hundredths(i: usize, fps: f64) -> u32 {
    let end = |frames: usize| (frames as f64 * 100.0 / fps).round();
    (end(i + 1) - end(i)).clamp(2.0, 65535.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::tests::Folder;
    use image::AnimationDecoder;
    use std::fs;

    #[test]
    fn transfer_is_srgb() {
        for (linear, coded) in [(0.0, 0.0), (1.0, 1.0), (0.5, 0.735_356_983), (0.214_041_14, 0.5), (0.002, 0.025_84)] {
            assert!((srgb_from_linear(linear) - coded).abs() < 1e-7, "{linear}");
            assert!((linear_from_srgb(coded) - linear).abs() < 1e-7, "{coded}");
        }
        for code in 0..=255u8 {
            let linear = linear_from_srgb(f64::from(code) / 255.0) as f32;
            assert_eq!(srgb8(&[[linear, linear, linear, 1.0]]), [[code, code, code, 255]]);
        }
    }

    #[test]
    fn alpha_becomes_straight_and_nothing_panics() {
        let half = linear_from_srgb(128.0 / 255.0) as f32;
        assert_eq!(srgb8(&[[half * 0.5, 0.0, 0.5, 0.5]]), [[128, 0, 255, 128]]);
        assert_eq!(srgb8(&[[0.5, 0.5, 0.5, 0.0], [0.0; 4]]), [[0; 4]; 2]);
        let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0];
        for r in bad {
            for a in bad {
                assert_eq!(srgb8(&[[r, 0.0, 0.0, a]])[0][1], 0);
            }
        }
        assert_eq!(srgb8(&[[2.0, -1.0, f32::NAN, 1.0]]), [[255, 0, 0, 255]]);
    }

    #[test]
    fn png_round_trip() {
        let folder = Folder::new();
        let path = folder.0.join("new/a.png");
        let grey = |code: u8, alpha: f32| {
            let c = linear_from_srgb(f64::from(code) / 255.0) as f32 * alpha;
            [c, c * 0.5, c * 0.25, alpha]
        };
        let pixels: Vec<[f32; 4]> = (0..6u8).map(|i| grey(40 * i, if i == 3 { 0.0 } else { 1.0 })).collect();
        write_png(&path, [3, 2], &pixels).unwrap();
        let back = read_png(&path).unwrap();
        assert_eq!(back.size, [3, 2]);
        for (a, b) in pixels.iter().flatten().zip(back.pixels.iter().flatten()) {
            // Half a code of 8-bit sRGB: the curve's slope is at most 2.3 / 255 a code.
            assert!((a - b).abs() < 0.5 * 2.3 / 255.0, "{a} {b}");
        }
        assert_eq!(srgb8(&back.pixels), srgb8(&pixels));
        let error = write_png(&path, [4, 2], &pixels).unwrap_err().to_string();
        assert!(error.contains("a.png") && error.contains("4 x 2"), "{error}");
        assert!(write_png(&path, [0, 0], &[]).is_err());
        assert_eq!(read_png(&path).unwrap(), back);
        let bytes = fs::read(&path).unwrap();
        for bad in [&bytes[..40], b"GIF89a", b""] {
            fs::write(&path, bad).unwrap();
            assert!(read_png(&path).unwrap_err().to_string().contains("a.png: "));
        }
        assert!(read_png(&folder.0.join("absent.png")).is_err());
    }

    #[test]
    fn png_of_other_kinds() {
        let folder = Folder::new();
        let path = folder.0.join("grey.png");
        image::GrayImage::from_raw(2, 1, vec![0, 255]).unwrap().save(&path).unwrap();
        assert_eq!(read_png(&path).unwrap().pixels, [[0.0, 0.0, 0.0, 1.0], [1.0; 4]]);
        let deep = image::ImageBuffer::<image::Rgb<u16>, _>::from_raw(1, 1, vec![65535, 32768, 0]).unwrap();
        deep.save(&path).unwrap();
        let expected = linear_from_srgb(32768.0 / 65535.0) as f32;
        assert_eq!(read_png(&path).unwrap().pixels, [[1.0, expected, 0.0, 1.0]]);
        // Linear light, as it says of itself.
        let mut bytes = Vec::new();
        let mut info = png::Info::with_size(1, 1);
        (info.bit_depth, info.color_type) = (png::BitDepth::Sixteen, png::ColorType::Rgb);
        info.source_gamma = Some(png::ScaledFloat::new(1.0));
        let mut writer = png::Encoder::with_info(&mut bytes, info).unwrap().write_header().unwrap();
        writer.write_image_data(&[0xFF, 0xFF, 0x80, 0x00, 0, 0]).unwrap();
        writer.finish().unwrap();
        fs::write(&path, bytes).unwrap();
        assert_eq!(read_png(&path).unwrap().pixels, [[1.0, (32768.0 / 65535.0) as f32, 0.0, 1.0]]);
    }

    #[test]
    fn exr_keeps_every_bit() {
        let folder = Folder::new();
        let path = folder.0.join("new/a.exr");
        let odd = [0.0, -0.0, 1e-45, 1.5e38, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 0.1];
        let value = |x: usize, c: usize| odd[(x * 5 + c) % 8];
        let rgba: Vec<[f32; 4]> = (0..35 * 40).map(|x| [0, 1, 2, 3].map(|c| value(x, c))).collect();
        let rgb: Vec<[f32; 3]> = rgba.iter().map(|p| [p[0], p[1], p[2]]).collect();
        let y: Vec<f32> = rgba.iter().map(|p| p[0]).collect();
        let check = |names: &[(&str, usize)]| {
            let back = read_exr(&path).unwrap();
            assert_eq!(back.size, [35, 40]);
            assert_eq!(back.channels.len(), names.len());
            for ((name, values), (expected, c)) in back.channels.iter().zip(names) {
                assert_eq!(name, expected);
                let bits = |v: &f32| v.to_bits();
                assert!(values.iter().map(bits).eq(rgba.iter().map(|p| p[*c].to_bits())), "{name}");
            }
        };
        write_exr(&path, [35, 40], &rgba).unwrap();
        check(&[("A", 3), ("B", 2), ("G", 1), ("R", 0)]);
        write_exr(&path, [35, 40], &rgb).unwrap();
        check(&[("B", 2), ("G", 1), ("R", 0)]);
        write_exr(&path, [35, 40], &y).unwrap();
        check(&[("Y", 0)]);
        assert!(write_exr(&path, [35, 41], &y).unwrap_err().to_string().contains("35 x 41"));
        check(&[("Y", 0)]);
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        assert!(read_exr(&path).unwrap_err().to_string().contains("a.exr: "));
    }

    #[test]
    fn sheets_are_grids() {
        let frames: Vec<Vec<[u8; 4]>> = (1..=5).map(|i| vec![[i; 4]; 6]).collect();
        let sheet = contact_sheet([3, 2], &frames, 2, 1).unwrap();
        assert_eq!(sheet.size, [7, 8]);
        let at = |x: usize, y: usize| sheet.pixels[y * 7 + x][0];
        assert_eq!([at(0, 0), at(2, 1), at(3, 0), at(4, 0), at(6, 1), at(0, 2)], [1, 1, 0, 2, 2, 0]);
        assert_eq!([at(0, 3), at(6, 4), at(0, 6), at(2, 7), at(4, 6)], [3, 4, 5, 5, 0]);
        assert_eq!(contact_sheet([3, 2], &frames, 100, 0).unwrap().size, [15, 2]);
        assert_eq!(contact_sheet([3, 3], &frames, 2, 1), None);
        assert_eq!(contact_sheet([3, 2], &[], 2, 1), None);
        assert_eq!(contact_sheet([3, 2], &frames, 2, u32::MAX), None);
    }

    #[test]
    fn gifs_repeat_with_exact_tones() {
        let folder = Folder::new();
        let path = folder.0.join("new/a.gif");
        let frames: Vec<Vec<[u8; 4]>> =
            (0..24u8).map(|i| (0..12).map(|x| [10 * i, 200, 20 * x, if x == 5 { 0 } else { 255 }]).collect()).collect();
        write_gif(&path, [4, 3], &frames[..20], 24.0).unwrap();
        let bytes = fs::read(&path).unwrap();
        // The extension that makes it repeat, with a count of 0: for ever.
        assert!(bytes.windows(16).any(|w| w == b"NETSCAPE2.0\x03\x01\x00\x00\x00"));
        let decoder = image::codecs::gif::GifDecoder::new(Cursor::new(bytes)).unwrap();
        let read = decoder.into_frames().collect_frames().unwrap();
        assert_eq!(read.len(), 20);
        let mut total = 0;
        for (frame, expected) in read.iter().zip(&frames) {
            total += frame.delay().numer_denom_ms().0;
            for (pixel, &[r, g, b, a]) in frame.buffer().pixels().zip(expected) {
                assert_eq!(pixel.0, if a == 0 { [0; 4] } else { [r, g, b, a] });
            }
        }
        // 20 frames at 24 per second, in hundredths.
        assert_eq!(total, 830);
        for (size, count, fps) in [([4, 3], 0, 24.0), ([4, 4], 1, 24.0), ([70_000, 1], 1, 24.0), ([4, 3], 1, 0.0)] {
            assert!(write_gif(&path, size, &frames[..count], fps).is_err());
        }
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn apngs_keep_every_pixel() {
        let folder = Folder::new();
        let path = folder.0.join("new/a.apng");
        let frames: Vec<Vec<[u8; 4]>> =
            (0..5u8).map(|i| (0..12).map(|x| [10 * i, 200, 20 * x, 255 - 21 * x]).collect()).collect();
        write_apng(&path, [4, 3], &frames, 24.0).unwrap();
        let decoder = image::codecs::png::PngDecoder::new(Cursor::new(fs::read(&path).unwrap())).unwrap();
        let read = decoder.apng().unwrap().into_frames().collect_frames().unwrap();
        assert_eq!(read.len(), 5);
        for (frame, expected) in read.iter().zip(&frames) {
            assert_eq!(frame.buffer().as_raw(), expected.as_flattened());
            let (number, of) = frame.delay().numer_denom_ms();
            assert!((f64::from(number) / f64::from(of) - 1000.0 / 24.0).abs() < 1e-3);
        }
        assert!(write_apng(&path, [4, 4], &frames, 24.0).is_err() && write_apng(&path, [4, 3], &[], 24.0).is_err());
        assert_eq!([24.0, 23.976, 0.0005, 1e6].map(delay), [[1, 24], [1000, 23976], [1000, 1], [1, 65535]]);
    }

    #[test]
    fn delays_stay_within_what_viewers_honour() {
        assert_eq!((hundredths(0, 24.0), hundredths(2, 24.0)), (4, 5));
        assert_eq!((hundredths(0, 1000.0), hundredths(0, 1e-9)), (2, 65535));
    }
}
