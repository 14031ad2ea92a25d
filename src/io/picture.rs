//! Pictures by file name: PNG (8-bit sRGB, straight alpha) or EXR (linear 32-bit float, premultiplied). JPEG can be read.

use std::path::Path;

use super::display::Display;
use super::image::{Fit, Picture, exr_note, png_note, read_coded, read_colours, write_exr_noted, write_png8_noted};
use super::{ReadError, WriteError};
use crate::view::BRIGHTEST;

/// The formats of pictures that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8-bit sRGB with straight alpha.
    Png,
    /// Linear 32-bit float, premultiplied.
    Exr,
}

impl Format {
    /// The format that the file's name ends in; `None` if it is another one.
    pub fn of(path: &Path) -> Option<Format> {
        let extension = path.extension()?.to_str()?;
        match extension.to_ascii_lowercase().as_str() {
            "png" => Some(Format::Png),
            "exr" => Some(Format::Exr),
            _ => None,
        }
    }
}

/// Reads a PNG, EXR or JPEG file into linear premultiplied pixels, upright. Of an EXR file it is what is seen in its
/// display window, of the part and layer that has channels R, G and B; without A it is opaque. At most 16 Mi pixels.
pub fn read(path: &Path) -> Result<Picture<[f32; 4]>, ReadError> {
    read_fitting(path, Fit::ANY)
}

/// As [`read`], for a picture of that size, whatever it is.
pub fn read_sized(path: &Path, size: [u32; 2]) -> Result<Picture<[f32; 4]>, ReadError> {
    read_fitting(path, Fit::Exactly(size))
}

/// As [`read_sized`], for what is rendered with. An error names the first pixel that is not finite or is brighter than
/// [`BRIGHTEST`].
pub fn read_frame(path: &Path, size: [u32; 2]) -> Result<Picture<[f32; 4]>, ReadError> {
    checked(path, read_sized(path, size)?)
}

/// Linear RGB of the first row of a picture, checked as [`read_frame`] does.
pub fn read_row(path: &Path) -> Result<Vec<[f32; 3]>, ReadError> {
    let row = checked(path, read_fitting(path, Fit::Row)?)?;
    // Pixels are premultiplied; a row of colours has no other use for alpha.
    Ok(row.pixels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect())
}

fn read_fitting(path: &Path, fit: Fit) -> Result<Picture<[f32; 4]>, ReadError> {
    match Format::of(path) {
        Some(Format::Png) => read_coded(path, image::ImageFormat::Png, fit),
        Some(Format::Exr) => read_colours(path, fit),
        None if is_jpeg(path) => read_coded(path, image::ImageFormat::Jpeg, fit),
        None => {
            Err(ReadError::file(path, "not a known kind of picture", "a name that ends in .png, .exr, .jpg or .jpeg"))
        }
    }
}

fn is_jpeg(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("jpg") || e.eq_ignore_ascii_case("jpeg"))
}

fn checked(path: &Path, picture: Picture<[f32; 4]>) -> Result<Picture<[f32; 4]>, ReadError> {
    let is_fine = |pixel: &[f32; 4]| pixel.iter().all(|x| x.abs() <= BRIGHTEST);
    match picture.pixels.iter().position(|pixel| !is_fine(pixel)) {
        None => Ok(picture),
        Some(at) => {
            let width = picture.size[0] as usize;
            let place = format!("pixel ({}, {})", at % width, at / width);
            let expected = format!("finite numbers, none beyond {BRIGHTEST}");
            Err(ReadError::at(path, place, format!("is {:?}", picture.pixels[at]), expected))
        }
    }
}

/// Writes linear premultiplied pixels in the given format, as PNG for a display, and a text of Latin letters that changes none of them. Atomic.
pub fn write(
    path: &Path,
    format: Format,
    size: [u32; 2],
    pixels: &[[f32; 4]],
    display: &Display,
    note: Option<&str>,
) -> Result<(), WriteError> {
    match format {
        Format::Png => write_png8_noted(path, size, &display.codes(pixels), display.gamma(), note),
        Format::Exr => write_exr_noted(path, size, pixels, note),
    }
}

/// The text that [`write()`] was given, if the file at `path` holds one.
pub fn note(path: &Path) -> Option<String> {
    match Format::of(path)? {
        Format::Png => png_note(path),
        Format::Exr => exr_note(path),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::image::write_exr;
    use crate::io::tests::Folder;

    #[test]
    fn a_picture_comes_back_by_its_name() {
        let folder = Folder::new();
        let pixels = [[0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 1.0]];
        for name in ["a.png", "a.EXR"] {
            let path = folder.0.join(name);
            for written in [None, Some("a note"), Some("")] {
                write(&path, Format::of(&path).expect("known"), [2, 1], &pixels, &Display::Srgb, written)
                    .expect("written");
                let expected = Picture { size: [2, 1], pixels: pixels.to_vec() };
                assert_eq!(read(&path).expect("readable"), expected, "{name}");
                assert_eq!(note(&path).as_deref(), written, "{name}");
            }
            std::fs::write(&path, "not a picture").expect("temporary folder");
            assert_eq!(note(&path), None);
        }
        let opaque = folder.0.join("rgb.exr");
        write_exr(&opaque, [1, 1], &[[0.25f32, 0.5, 2.0]]).expect("written");
        assert_eq!(read(&opaque).expect("readable").pixels, [[0.25, 0.5, 2.0, 1.0]]);
        let grey = folder.0.join("y.exr");
        write_exr(&grey, [1, 1], &[0.25f32]).expect("written");
        assert!(read(&grey).expect_err("no colour").to_string().contains("channels Y"));
        assert!(read(&folder.0.join("a.bmp")).expect_err("unknown").to_string().contains(".png, .exr, .jpg"));
        image::RgbImage::from_raw(8, 8, vec![188; 192]).expect("pixels").save(folder.0.join("a.jpg")).expect("written");
        let jpeg = read(&folder.0.join("a.jpg")).expect("readable");
        assert!(jpeg.size == [8, 8] && (jpeg.pixels[9][0] - 0.5).abs() < 0.01 && jpeg.pixels[9][3] == 1.0, "{jpeg:?}");
    }
}
