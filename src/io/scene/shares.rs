//! How much of a smear's strength the parts of a mesh have.

use std::path::Path;

use super::AnimatedMesh;
use crate::io::image::srgb_from_linear;
use crate::io::{ReadError, picture};

impl AnimatedMesh {
    /// Multiplies the shares of strength of the objects and materials that have one of these names.
    ///
    /// # Errors
    /// A name that nothing has; it names those that there are.
    pub fn share_strength(&mut self, named: &[(String, f32)]) -> Result<(), ReadError> {
        let topology = &mut self.topology;
        for (name, share) in named {
            let is_named = |names: &[String], number: u32| names[number as usize] == *name;
            let mut found = false;
            let vertices = topology.object.iter().zip(&topology.material).zip(&mut topology.share);
            for ((object, material), own) in vertices {
                if is_named(&topology.objects, *object) || is_named(&topology.materials, *material) {
                    *own *= share;
                    found = true;
                }
            }
            if !found {
                let quoted = |names: &[String]| {
                    let named = names.iter().filter(|name| !name.is_empty());
                    named.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
                };
                let (objects, materials) = (quoted(&topology.objects), quoted(&topology.materials));
                let materials = if materials.is_empty() { "none".to_owned() } else { materials };
                let why = format!("blur.shares: nothing is called `{name}`");
                return Err(ReadError::file(
                    &self.path,
                    why,
                    format!("an object ({objects}) or a material ({materials})"),
                ));
            }
        }
        Ok(())
    }

    /// Multiplies the shares of strength by a painted picture, black for none to white for all, as a painter sees it: its
    /// luminance as sRGB codes it, at the texel of each vertex's texture coordinates, which repeat.
    ///
    /// # Errors
    /// A picture that cannot be read; a mesh without texture coordinates.
    pub fn paint_strength(&mut self, path: &Path) -> Result<(), ReadError> {
        let topology = &mut self.topology;
        if !topology.has_coordinates {
            let why = "has no texture coordinates, and blur.share_map is painted on those";
            return Err(ReadError::file(&self.path, why.to_owned(), "TEXCOORD_0 in a glTF file"));
        }
        let picture = picture::read(path)?;
        let [width, height] = picture.size;
        let texel = |coordinate: f32, size: u32| {
            // The conversion makes 0 of what is not a number.
            ((f64::from(coordinate).rem_euclid(1.0) * f64::from(size)) as u32).min(size - 1)
        };
        for ([u, v], share) in topology.coordinates.iter().zip(&mut topology.share) {
            let at = texel(*v, height) as usize * width as usize + texel(*u, width) as usize;
            let [r, g, b, _] = picture.pixels[at].map(f64::from);
            let painted = srgb_from_linear(0.2126 * r + 0.7152 * g + 0.0722 * b);
            *share *= painted.clamp(0.0, 1.0) as f32;
        }
        Ok(())
    }
}
