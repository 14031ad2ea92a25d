//! The pictures of a glTF file's textures.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::rc::Rc;

use image::{DynamicImage, ImageDecoder, ImageReader, RgbImage};

use super::document::Document;
use crate::io::ReadError;

/// Most pixels of a picture, 8192 x 8192: a few bytes can unpack to any number.
const MAX_PIXELS: u64 = 1 << 26;

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
    pub(super) notes: Vec<String>,
}

impl Pictures {
    /// A picture; a note where it cannot be had, for the mesh can be drawn without it.
    pub(super) fn get(&mut self, document: &Document, number: usize) -> Option<Rc<RgbImage>> {
        if let Some(picture) = self.decoded.get(&number) {
            return picture.clone();
        }
        let picture = self.decode(document, number).map(Rc::new);
        let picture = picture.map_err(|error| self.notes.push(format!("{error}; the texture is left out"))).ok();
        let pixels = picture.as_ref().map_or(0, |picture| pixels(picture.dimensions()));
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
        let fault = |error: image::ImageError| document.fault(&place[..], error, EXPECTED);
        let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
        let reader = reader.map_err(|error| document.fault(&place[..], error, EXPECTED))?;
        let decoder = reader.into_decoder().map_err(fault)?;
        let (width, height) = decoder.dimensions();
        let own = pixels((width, height));
        if own > MAX_PIXELS {
            let why = format!("has {width} x {height} pixels");
            return Err(document.fault(place, why, format!("{MAX_PIXELS} pixels at most")));
        }
        self.decoded_pixels += own;
        if self.decoded_pixels > MAX_DECODED {
            let why = format!("of {width} x {height} pixels brings those of all textures to {}", self.decoded_pixels);
            return Err(document.fault(place, why, format!("{MAX_DECODED} pixels at most")));
        }
        Ok(DynamicImage::from_decoder(decoder).map_err(fault)?.into_rgb8())
    }
}

fn pixels((width, height): (u32, u32)) -> u64 {
    u64::from(width) * u64::from(height)
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
