//! Linear base colours of a glTF primitive's vertices.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use super::Note;
use super::document::Document;
use super::json::{Index, Material, Primitive, TextureInfo, TextureTransform, Type, WrappingMode};
use super::texels::Pictures;
use crate::io::ReadError;
use crate::io::image::linear_from_srgb;
use crate::view::BRIGHTEST;

/// Finds vertices' colours: base colour factor x vertex colour x base colour texture at the vertex.
pub(super) struct Colours<'d> {
    document: &'d Document<'d>,
    pictures: Pictures,
    /// Textures whose pictures only an extension has.
    foreign: BTreeSet<usize>,
}

impl<'d> Colours<'d> {
    pub(super) fn new(document: &'d Document<'d>) -> Colours<'d> {
        Colours { document, pictures: Pictures::default(), foreign: BTreeSet::new() }
    }

    /// Images that could not be used.
    pub(super) fn into_notes(self) -> Vec<Note> {
        let foreign = self.foreign.into_iter().map(|texture| {
            Note::of_looks(format!("texture {texture} has no PNG or JPEG picture; the texture is left out"))
        });
        self.pictures.notes.into_iter().chain(foreign).collect()
    }

    fn material(&self, primitive: &Primitive) -> Result<Option<&'d Material>, ReadError> {
        let material = |index| self.document.entry(&self.document.root.materials, index, "material");
        primitive.material.map(material).transpose()
    }

    pub(super) fn is_double_sided(&self, primitive: &Primitive) -> Result<bool, ReadError> {
        Ok(self.material(primitive)?.is_some_and(|material| material.double_sided))
    }

    /// Linear RGB of the `count` vertices of a primitive. A texture is looked up at the nearest texel, so that what
    /// lies beside it in the picture does not bleed in.
    pub(super) fn of_vertices(&mut self, primitive: &Primitive, count: usize) -> Result<Vec<[f32; 3]>, ReadError> {
        let pbr = self.material(primitive)?.map(|material| &material.pbr_metallic_roughness);
        let [r, g, b, _] = pbr.map_or([1.0; 4], |pbr| pbr.base_color_factor.map(f64::from));
        let mut colours = vec![[r, g, b]; count];
        if let Some(own) = self.vertex_colours(primitive)? {
            multiply(&mut colours, own);
        }
        if let Some(info) = pbr.and_then(|pbr| pbr.base_color_texture.as_ref())
            && let Some(own) = self.texture_colours(primitive, info)?
        {
            multiply(&mut colours, own);
        }
        let sane = |x: f64| if x.is_finite() { x.clamp(0.0, BRIGHTEST.into()) as f32 } else { 0.0 };
        Ok(colours.into_iter().map(|colour| colour.map(sane)).collect())
    }

    /// COLOR_0, with or without alpha.
    fn vertex_colours(&self, primitive: &Primitive) -> Result<Option<Vec<[f64; 3]>>, ReadError> {
        let Some(accessor) = primitive.attribute("COLOR_0") else { return Ok(None) };
        let json = self.document.entry(&self.document.root.accessors, accessor, "accessor")?;
        if json.type_ == Type::Vec3 {
            return self.document.values::<3>(accessor).map(Some);
        }
        let values = self.document.values::<4>(accessor)?;
        Ok(Some(values.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()))
    }

    /// Colours of a texture at the vertices; none where its picture or the coordinates are missing.
    fn texture_colours(
        &mut self,
        primitive: &Primitive,
        info: &TextureInfo,
    ) -> Result<Option<Vec<[f64; 3]>>, ReadError> {
        let root = &self.document.root;
        let texture = self.document.entry(&root.textures, info.index, "texture")?;
        let transform = info.extensions.transform.as_ref();
        let set = transform.and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord).0;
        let Some(accessor) = primitive.attribute(&format!("TEXCOORD_{set}")) else { return Ok(None) };
        let wrap = match texture.sampler {
            Some(sampler) => {
                let sampler = self.document.entry(&root.samplers, sampler, "texture sampler")?;
                [sampler.wrap_s, sampler.wrap_t]
            }
            None => [WrappingMode::Repeat; 2],
        };
        let coordinates = self.document.values::<2>(accessor)?;
        let Some(image) = texture.source.map(Index::value) else {
            self.foreign.insert(info.index.value());
            return Ok(None);
        };
        let Some(texels) = self.pictures.get(self.document, image) else { return Ok(None) };
        let look_up = |uv: [f64; 2]| {
            let [u, v] = transform.map_or(uv, |transform| transformed(transform, uv));
            let [x, y] = [(u, texels.width(), wrap[0]), (v, texels.height(), wrap[1])].map(|(t, n, w)| texel(t, n, w));
            texels.get_pixel(x, y).0.map(|c| linear_from_srgb(f64::from(c) / 255.0))
        };
        Ok(Some(coordinates.into_iter().map(look_up).collect()))
    }
}

fn multiply(colours: &mut [[f64; 3]], factors: Vec<[f64; 3]>) {
    for (colour, factor) in colours.iter_mut().zip(factors) {
        (0..3).for_each(|i| colour[i] *= factor[i]);
    }
}

/// KHR_texture_transform: scale, then rotation, then offset.
fn transformed(transform: &TextureTransform, [u, v]: [f64; 2]) -> [f64; 2] {
    let [su, sv] = transform.scale.map(f64::from);
    let [ou, ov] = transform.offset.map(f64::from);
    let (sin, cos) = (f64::from(transform.rotation) % TAU).sin_cos();
    let (u, v) = (su * u, sv * v);
    [cos * u + sin * v + ou, cos * v - sin * u + ov]
}

/// The texel of a coordinate; `size` is at least 1.
fn texel(coordinate: f64, size: u32, wrap: WrappingMode) -> u32 {
    let within = match wrap {
        WrappingMode::ClampToEdge => coordinate,
        WrappingMode::MirroredRepeat => 1.0 - (coordinate.rem_euclid(2.0) - 1.0).abs(),
        WrappingMode::Repeat => coordinate.rem_euclid(1.0),
    };
    // The conversion saturates and makes 0 of NaN.
    ((within * f64::from(size)) as u32).min(size - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_wrap() {
        let at = |coordinate, wrap| texel(coordinate, 4, wrap);
        let coordinates = [-0.3, 0.0, 0.3, 0.99, 1.0, 1.3];
        assert_eq!(coordinates.map(|t| at(t, WrappingMode::Repeat)), [2, 0, 1, 3, 0, 1]);
        assert_eq!(coordinates.map(|t| at(t, WrappingMode::ClampToEdge)), [0, 0, 1, 3, 3, 3]);
        assert_eq!(coordinates.map(|t| at(t, WrappingMode::MirroredRepeat)), [1, 0, 1, 3, 3, 2]);
    }

    #[test]
    fn coordinates_are_transformed_as_the_extension_says() {
        let transform: TextureTransform =
            serde_json::from_str(r#"{"offset": [0.5, 0.25], "rotation": 1.5707964, "scale": [2, 3]}"#).unwrap();
        let [u, v] = transformed(&transform, [0.25, 0.125]);
        assert!((u - (0.375 + 0.5)).abs() < 1e-6 && (v - (0.25 - 0.5)).abs() < 1e-6, "{u} {v}");
    }
}
