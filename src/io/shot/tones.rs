//! Tones from an image file: its first row is the shading texture.

use std::path::Path;

use crate::io::ReadError;
use crate::io::picture;
use crate::smoke::settings::Tone;

/// Reads the tones of a shading texture, looked up at the nearest texel: texel i of n begins at luminance i / n.
/// Neighbours of equal colour are one tone, so that a wide texture of few flat tones is what it looks like.
pub(super) fn read(path: &Path) -> Result<Vec<Tone>, ReadError> {
    let texture = picture::read(path)?;
    let width = texture.size[0] as usize;
    let mut tones: Vec<Tone> = Vec::new();
    // Pixels are premultiplied; the texture has no other use for alpha.
    for (i, [r, g, b, _]) in texture.pixels.into_iter().take(width).enumerate() {
        let colour = [r, g, b];
        if tones.last().is_none_or(|last| last.colour != colour) {
            tones.push(Tone { from: i as f32 / width as f32, colour });
        }
    }
    if tones.is_empty() || tones.len() > 256 {
        let why = format!("its first row has {} runs of equal colour", tones.len());
        return Err(ReadError::file(path, why, "1 to 256 tones"));
    }
    Ok(tones)
}
