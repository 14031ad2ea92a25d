//! Linear base colours of a glTF primitive's vertices.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::f64::consts::TAU;

use super::Note;
use super::document::Document;
use super::json::{Index, Material, Primitive, TextureTransform, Type, Whole, WrappingMode};
use super::texels::Pictures;
use crate::blur::{Texture, Wrap};
use crate::io::ReadError;
use crate::view::BRIGHTEST;

/// A texture sampler's filter that takes the nearest texel.
const NEAREST_FILTER: u64 = 9728;

/// A primitive's texture.
pub(super) struct Textured {
    pub(super) number: u32,
    /// Where its vertices are in it.
    pub(super) places: Vec<[f32; 2]>,
}

/// Finds vertices' colours: base colour factor x vertex colour; and the base colour textures that are before them.
pub(super) struct Colours<'d> {
    document: &'d Document<'d>,
    pictures: Pictures,
    /// Textures, each once for each picture and way to look it up.
    textures: Vec<Texture>,
    known: HashMap<(usize, [Wrap; 2], bool), u32>,
    /// Textures whose pictures only an extension has.
    foreign: BTreeSet<usize>,
    /// Materials that are not opaque.
    see_through: BTreeMap<String, &'static str>,
}

impl<'d> Colours<'d> {
    pub(super) fn new(document: &'d Document<'d>) -> Colours<'d> {
        let (textures, known, foreign) = (Vec::new(), HashMap::new(), BTreeSet::new());
        let see_through = BTreeMap::new();
        Colours { document, pictures: Pictures::default(), textures, known, foreign, see_through }
    }

    /// The textures, and what could not be used.
    pub(super) fn into_textures(self) -> (Vec<Texture>, Vec<Note>) {
        let foreign = self.foreign.into_iter().map(|texture| {
            Note::of_looks(format!("texture {texture} has no PNG or JPEG picture; the texture is left out"))
        });
        let see_through = self
            .see_through
            .into_iter()
            .map(|(name, mode)| Note::of_looks(format!("material `{name}` has alphaMode {mode}: it is drawn opaque")));
        (self.textures, self.pictures.notes.into_iter().chain(foreign).chain(see_through).collect())
    }

    fn material(&self, primitive: &Primitive) -> Result<Option<&'d Material>, ReadError> {
        let material = |index| self.document.entry(&self.document.root.materials, index, "material");
        primitive.material.map(material).transpose()
    }

    /// Name of a primitive's material: its number where it has none, "" without a material.
    pub(super) fn material_name(&self, primitive: &Primitive) -> Result<String, ReadError> {
        let (Some(material), Some(index)) = (self.material(primitive)?, primitive.material) else {
            return Ok(String::new());
        };
        let name = material.name.clone().filter(|name| !name.is_empty());
        Ok(name.unwrap_or_else(|| index.value().to_string()))
    }

    pub(super) fn is_double_sided(&self, primitive: &Primitive) -> Result<bool, ReadError> {
        Ok(self.material(primitive)?.is_some_and(|material| material.double_sided))
    }

    /// Linear RGB of the `count` vertices of a primitive, without its texture.
    pub(super) fn of_vertices(&mut self, primitive: &Primitive, count: usize) -> Result<Vec<[f32; 3]>, ReadError> {
        let material = self.material(primitive)?;
        let [r, g, b, _] = material.map_or([1.0; 4], |m| m.pbr_metallic_roughness.base_color_factor.map(f64::from));
        if let Some(mode) = material.and_then(|material| material.alpha_mode.shown()) {
            self.see_through.insert(self.material_name(primitive)?, mode);
        }
        let mut colours = vec![[r, g, b]; count];
        if let Some(own) = self.vertex_colours(primitive)? {
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

    /// A primitive's base colour texture, and where its vertices are in it; none where its picture or the coordinates are
    /// missing.
    pub(super) fn texture(&mut self, primitive: &Primitive, count: usize) -> Result<Option<Textured>, ReadError> {
        let root = &self.document.root;
        let material = self.material(primitive)?;
        let Some(info) = material.and_then(|m| m.pbr_metallic_roughness.base_color_texture.as_ref()) else {
            return Ok(None);
        };
        let texture = self.document.entry(&root.textures, info.index, "texture")?;
        let transform = info.extensions.transform.as_ref();
        let set = transform.and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord).0;
        let Some(accessor) = primitive.attribute(&format!("TEXCOORD_{set}")) else { return Ok(None) };
        let (wrap, is_nearest) = match texture.sampler {
            Some(sampler) => {
                let sampler = self.document.entry(&root.samplers, sampler, "texture sampler")?;
                ([sampler.wrap_s, sampler.wrap_t].map(Wrap::from), sampler.mag_filter == Some(Whole(NEAREST_FILTER)))
            }
            None => ([Wrap::Repeat; 2], false),
        };
        let mut coordinates = self.document.values::<2>(accessor)?;
        coordinates.resize(count, [0.0; 2]);
        let Some(image) = texture.source.map(Index::value) else {
            self.foreign.insert(info.index.value());
            return Ok(None);
        };
        let number = match self.known.get(&(image, wrap, is_nearest)) {
            Some(number) => *number,
            None => {
                let Some(picture) = self.pictures.get(self.document, image) else { return Ok(None) };
                let size = [picture.width(), picture.height()];
                let texels = picture.pixels().map(|pixel| pixel.0).collect();
                self.textures.push(Texture { size, texels, wrap, is_nearest });
                let number = self.textures.len() as u32 - 1;
                self.known.insert((image, wrap, is_nearest), number);
                number
            }
        };
        let place = |uv: [f64; 2]| {
            let moved = transform.map_or(uv, |transform| transformed(transform, uv));
            // Whole turns are taken away while they can be told apart.
            [0, 1].map(|axis| match wrap[axis] {
                Wrap::Clamp => moved[axis].clamp(-1e6, 1e6) as f32,
                _ => moved[axis] as f32,
            })
        };
        Ok(Some(Textured { number, places: coordinates.into_iter().map(place).collect() }))
    }
}

impl From<WrappingMode> for Wrap {
    fn from(mode: WrappingMode) -> Wrap {
        match mode {
            WrappingMode::ClampToEdge => Wrap::Clamp,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::Repeat => Wrap::Repeat,
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_transformed_as_the_extension_says() {
        let transform: TextureTransform =
            serde_json::from_str(r#"{"offset": [0.5, 0.25], "rotation": 1.5707964, "scale": [2, 3]}"#).unwrap();
        let [u, v] = transformed(&transform, [0.25, 0.125]);
        assert!((u - (0.375 + 0.5)).abs() < 1e-6 && (v - (0.25 - 0.5)).abs() < 1e-6, "{u} {v}");
    }
}
