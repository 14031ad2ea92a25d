//! Pictures: PNG, EXR, animated GIF. All in memory is linear light with premultiplied alpha, rows from the top, unless
//! said; 8-bit pixels are sRGB with straight alpha.

use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Cursor, Write};
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Layer, LayerAttributes, ReadChannels, ReadLayers,
    WritableImage,
};
use image::ImageEncoder;

use super::{ReadError, WriteError, write_atomic};

/// Largest side of a picture that is read, in pixels.
const MAX_SIDE: u32 = 32_768;

/// A picture in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture<P> {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Width x height pixels, rows from the top.
    pub pixels: Vec<P>,
}

/// The sRGB transfer function (IEC 61966-2-1) from linear light to the coded value; both 0 to 1.
pub fn srgb_from_linear(linear: f64) -> f64 {
    match linear <= 0.003_130_8 {
        true => 12.92 * linear,
        false => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
    }
}

/// The sRGB transfer function (IEC 61966-2-1) from the coded value to linear light; both 0 to 1.
pub fn linear_from_srgb(coded: f64) -> f64 {
    match coded <= 0.040_45 {
        true => coded / 12.92,
        false => ((coded + 0.055) / 1.055).powf(2.4),
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
    write_encoded(path, |buffer| {
        check_size(size, pixels.len())?;
        image::codecs::png::PngEncoder::new(buffer)
            .write_image(pixels.as_flattened(), size[0], size[1], image::ExtendedColorType::Rgba8)
            .map_err(from_image)
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

/// Reads a PNG of any bit depth as sRGB (a profile in the file is not looked at) into linear premultiplied pixels.
pub fn read_png(path: &Path) -> Result<Picture<[f32; 4]>, ReadError> {
    let file = File::open(path).map_err(|error| ReadError::file(path, error, "a file that can be read"))?;
    let mut reader = image::ImageReader::with_format(BufReader::new(file), image::ImageFormat::Png);
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(1 << 33);
    reader.limits(limits);
    let expected = format!("a whole PNG picture of at most {MAX_SIDE} pixels a side");
    let picture = reader.decode().map_err(|error| ReadError::file(path, error, expected))?.into_rgba16();
    let table: Vec<f32> = (0..=u16::MAX).map(|v| linear_from_srgb(f64::from(v) / 65535.0) as f32).collect();
    let linear = |&image::Rgba([r, g, b, a]): &image::Rgba<u16>| {
        let alpha = f32::from(a) / 65535.0;
        let [r, g, b] = [r, g, b].map(|c| table[usize::from(c)] * alpha);
        [r, g, b, alpha]
    };
    Ok(Picture { size: [picture.width(), picture.height()], pixels: picture.pixels().map(linear).collect() })
}

/// What a pixel of an EXR file can be.
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
    write_encoded(path, |buffer| {
        check_size(size, pixels.len())?;
        let channel = |(i, name): (usize, &&str)| {
            AnyChannel::new(*name, FlatSamples::F32(pixels.iter().map(|p| p.channel(i)).collect()))
        };
        let channels = AnyChannels::sort(P::CHANNELS.iter().enumerate().map(channel).collect());
        let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::SMALL_LOSSLESS };
        let size = (size[0] as usize, size[1] as usize);
        let layer = Layer::new(size, LayerAttributes::default(), encoding, channels);
        let image = exr::prelude::Image::from_layer(layer);
        image.write().to_buffered(buffer).map_err(|error| match error {
            exr::error::Error::Io(error) => error,
            error => io::Error::other(error),
        })
    })
}

/// The channels of an EXR file's first layer, as f32.
#[derive(Clone, Debug, PartialEq)]
pub struct Channels {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Names and values, sorted by name; rows from the top.
    pub channels: Vec<(String, Vec<f32>)>,
}

/// Reads the first layer of an EXR file.
pub fn read_exr(path: &Path) -> Result<Channels, ReadError> {
    let expected = "a whole EXR picture without deep data";
    let bytes = fs::read(path).map_err(|error| ReadError::file(path, error, "a file that can be read"))?;
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let image = reader.all_attributes().from_buffered(Cursor::new(bytes));
    let layer = image.map_err(|error| ReadError::file(path, error, expected))?.layer_data;
    let channels = layer.channel_data.list.iter();
    let channels = channels.map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect())).collect();
    // An EXR is at most 2^31 pixels wide and high.
    Ok(Channels { size: [layer.size.x() as u32, layer.size.y() as u32], channels })
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

/// How long frame `i` stays, in hundredths of a second.
fn hundredths(i: usize, fps: f64) -> u32 {
    let end = |frames: usize| (frames as f64 * 100.0 / fps).round();
    (end(i + 1) - end(i)).clamp(2.0, 65535.0) as u32
}
