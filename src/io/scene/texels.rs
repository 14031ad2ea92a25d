//! The pictures of a glTF file's textures.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::rc::Rc;

use image::{ImageFormat, RgbImage};

use super::Note;
use super::document::Document;
use crate::io::ReadError;
use crate::io::image::{Fit, decode};

/// Most pixels that are decoded, over and over if need be.
const MAX_DECODED: u64 = 1 << 30;

/// Most pixels that are kept, for what is textured next often has the same picture.
const MAX_KEPT: u64 = 1 << 26;

/// Most bytes of a picture's file.
const MAX_FILE: u64 = 1 << 28;

const EXPECTED: &str = "a PNG or JPEG picture";

/// Decoded pictures, 8-bit sRGB, by number; none where one cannot be decoded.
#[derive(Default)]
pub(super) struct Pictures {
    decoded: HashMap<usize, Option<Rc<RgbImage>>>,
    kept_pixels: u64,
    decoded_pixels: u64,
    /// Pictures that could not be used.
    pub(super) notes: Vec<Note>,
}

impl Pictures {
    /// A picture; a note where it cannot be had, for the mesh can be drawn without it.
    pub(super) fn get(&mut self, document: &Document, number: usize) -> Option<Rc<RgbImage>> {
        if let Some(picture) = self.decoded.get(&number) {
            return picture.clone();
        }
        let picture = self.decode(document, number).map(Rc::new);
        let left_out = |error| Note::of_looks(format!("{error}; the texture is left out"));
        let picture = picture.map_err(|error| self.notes.push(left_out(error))).ok();
        let pixels = picture.as_ref().map_or(0, |picture| pixels(picture));
        if self.kept_pixels + pixels > MAX_KEPT {
            self.decoded.retain(|_, picture| picture.is_none());
            self.kept_pixels = 0;
        }
        self.kept_pixels += pixels;
        self.decoded.insert(number, picture.clone());
        picture
    }

    fn decode(&mut self, document: &Document, number: usize) -> Result<RgbImage, ReadError> {
        let place = format!("image {number}");
        let bytes = bytes(document, &place, number)?;
        document.budget.work(&place, &format!("{} bytes", bytes.len()), bytes.len() as u64)?;
        let fault = |(why, expected): (String, String)| document.fault(&place[..], why, expected);
        let format = image::guess_format(&bytes).ok().filter(|f| matches!(f, ImageFormat::Png | ImageFormat::Jpeg));
        let format = format.ok_or_else(|| document.fault(&place[..], "is of another kind", EXPECTED))?;
        if self.decoded_pixels > MAX_DECODED {
            let why = format!("is behind others of {} pixels", self.decoded_pixels);
            return Err(document.fault(place, why, format!("{MAX_DECODED} pixels of all textures at most")));
        }
        let length = bytes.len() as u64;
        let picture = decode(Cursor::new(bytes), format, length, fit(length)).map_err(fault)?.into_rgb8();
        self.decoded_pixels += pixels(&picture);
        Ok(picture)
    }
}

/// How large a picture may be that so many bytes hold: flat ones of the usual sizes have few, others not.
fn fit(length: u64) -> Fit {
    Fit::AtMost(length.saturating_mul(256).clamp(1 << 24, 1 << 26))
}

fn pixels(picture: &RgbImage) -> u64 {
    u64::from(picture.width()) * u64::from(picture.height())
}

fn bytes<'d>(document: &'d Document, place: &str, number: usize) -> Result<Cow<'d, [u8]>, ReadError> {
    let missing = || document.fault(place, "is missing", EXPECTED);
    let image = document.root.images.get(number).ok_or_else(missing)?;
    match (image.buffer_view, &image.uri) {
        (Some(view), _) => document.view(view).map(|(bytes, _)| Cow::Borrowed(bytes)),
        (None, Some(uri)) => document.resource(place, uri, MAX_FILE),
        (None, None) => Err(missing()),
    }
}
