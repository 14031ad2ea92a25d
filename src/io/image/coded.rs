//! Reading PNG and JPEG pictures.

use std::io::{BufRead, BufReader, Seek};
use std::path::Path;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::contained::contained;
use super::profile::{self, Coding};
use super::{Fault, Fit, Picture};
use crate::io::{ReadError, file};

/// Bytes that a decoder may take besides the picture: for profiles, texts and the like.
const MAX_BESIDE: u64 = 1 << 26;
/// Longest JPEG file, which its decoder holds in memory: four bytes a pixel of the largest picture.
const MAX_JPEG: u64 = 1 << 30;

/// Reads a PNG of any bit depth into linear premultiplied pixels, by its gamma or profile; without one as sRGB.
pub fn read_png(path: &Path) -> Result<Picture<[f32; 4]>, ReadError> {
    read_coded(path, ImageFormat::Png, Fit::ANY)
}

/// Reads a PNG or JPEG into linear premultiplied pixels, by its gamma or profile; without one as sRGB.
pub(in crate::io) fn read_coded(path: &Path, format: ImageFormat, fit: Fit) -> Result<Picture<[f32; 4]>, ReadError> {
    let unreadable = |error| ReadError::file(path, error, "a file that can be read");
    let file = file::open(path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    let fault = |(why, expected)| ReadError::file(path, why, expected);
    let mut source = BufReader::new(file);
    let own = match format {
        ImageFormat::Png => Some(profile::of_png(&mut source).map_err(fault)?),
        _ => None,
    };
    source.rewind().map_err(unreadable)?;
    let (picture, of_file) = decode_coded(source, format, length, fit).map_err(fault)?;
    let coding = own.unwrap_or_else(|| of_file.map_or(Coding::Srgb, Coding::Profile));
    let picture = picture.into_rgba16();
    let size = [picture.width(), picture.height()];
    let pixels = contained(|| profile::linear(&coding, &picture));
    let pixels =
        pixels.map_err(|why| (why.to_owned(), "a profile that can be used".to_owned())).and_then(|found| found);
    Ok(Picture { size, pixels: pixels.map_err(fault)? })
}

/// Decodes a PNG or JPEG of `length` bytes, turned upright as it says (EXIF), whatever its colours mean. Nothing is decoded of
/// a picture that does not fit, or that has more pixels than so few bytes can hold.
pub(in crate::io) fn decode(
    source: impl BufRead + Seek,
    format: ImageFormat,
    length: u64,
    fit: Fit,
) -> Result<DynamicImage, Fault> {
    decode_coded(source, format, length, fit).map(|(picture, _)| picture)
}

/// As [`decode`], with the picture's ICC profile.
fn decode_coded(
    source: impl BufRead + Seek,
    format: ImageFormat,
    length: u64,
    fit: Fit,
) -> Result<(DynamicImage, Option<Vec<u8>>), Fault> {
    let expected = || format!("a whole {} picture", if format == ImageFormat::Jpeg { "JPEG" } else { "PNG" });
    let damaged = |why: image::ImageError| (why.to_string(), expected());
    let decoded = contained(|| {
        if format == ImageFormat::Jpeg && length > MAX_JPEG {
            return Err((format!("has {length} bytes"), format!("a JPEG picture of at most {MAX_JPEG} bytes")));
        }
        let mut reader = ImageReader::with_format(source, format);
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(MAX_BESIDE);
        reader.limits(limits);
        let mut decoder = reader.into_decoder().map_err(damaged)?;
        let orientation = decoder.orientation().map_err(damaged)?;
        let profile = decoder.icc_profile().map_err(damaged)?;
        let (width, height) = decoder.dimensions();
        let [width, height] = fit.checked(upright([width, height], orientation))?;
        if u64::from(width) * u64::from(height) > length.saturating_mul(most_pixels(format)) {
            return Err((format!("{length} bytes cannot be {width} x {height} pixels"), expected()));
        }
        decoder.set_limits(Limits::no_limits()).map_err(damaged)?;
        let mut picture = DynamicImage::from_decoder(decoder).map_err(damaged)?;
        picture.apply_orientation(orientation);
        Ok((if matches!(fit, Fit::Row) { picture.crop_imm(0, 0, width, height) } else { picture }, profile))
    });
    decoded.map_err(|why| (why.to_owned(), expected())).and_then(|result| result)
}

/// The size of a picture once it is turned.
fn upright([width, height]: [u32; 2], orientation: Orientation) -> [u32; 2] {
    match orientation {
        Orientation::NoTransforms
        | Orientation::Rotate180
        | Orientation::FlipHorizontal
        | Orientation::FlipVertical => [width, height],
        Orientation::Rotate90 | Orientation::Rotate270 | Orientation::Rotate90FlipH | Orientation::Rotate270FlipH => {
            [height, width]
        }
    }
}

/// Most pixels of a byte of a file.
fn most_pixels(format: ImageFormat) -> u64 {
    match format {
        // A bit for each 8 x 8 pixels of the first scan of a progressive grey picture, and twice that to be safe.
        ImageFormat::Jpeg => 1024,
        // Deflate makes 1032 bytes of one, and each may be 8 pixels.
        _ => 8 * 1032,
    }
}
