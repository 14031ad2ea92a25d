//! Tones from an image file: its first row.

use std::path::Path;

use crate::io::ReadError;
use crate::io::picture;
use crate::toon::Tone;

/// Reads the tones of a shading texture, looked up at the nearest texel: texel i of n begins at luminance i / n.
/// Neighbours of equal colour are one tone, so that a wide texture of few flat tones is what it looks like.
pub(crate) fn tones(path: &Path) -> Result<Vec<Tone>, ReadError> {
    let row = picture::read_row(path)?;
    let width = row.len();
    let mut tones: Vec<Tone> = Vec::new();
    for (i, colour) in row.into_iter().enumerate() {
        if tones.last().is_none_or(|last| last.colour != colour) {
            tones.push(Tone::new(i as f32 / width as f32, colour));
        }
    }
    if tones.is_empty() || tones.len() > 256 {
        let why = format!("its first row has {} runs of equal colour", tones.len());
        return Err(ReadError::file(path, why, "1 to 256 tones"));
    }
    Ok(tones)
}
