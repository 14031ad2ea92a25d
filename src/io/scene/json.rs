//! The JSON of a glTF 2.0 file, as far as it is read here.
//!
//! The types are our own because a file may hold anything in what is not listed here: `extras` of any type, extensions,
//! values that later versions add. What the standard lets a file leave out has a default or is an `Option`, and where it
//! wants a whole number, 54.0 is one. An unknown value is a fault only where it matters.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};

/// A whole number, 0 or above: `54`, `54.0` or `5.4e1`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Whole(pub(super) u64);

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Whole, D::Error> {
        struct Number;
        impl Visitor<'_> for Number {
            type Value = Whole;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a whole number, 0 or above")
            }

            fn visit_u64<E: Error>(self, number: u64) -> Result<Whole, E> {
                Ok(Whole(number))
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<Whole, E> {
                match number >= 0.0 && number.fract() == 0.0 {
                    // What is above u64::MAX is too large for whatever it counts.
                    true => Ok(Whole(number as u64)),
                    false => Err(E::invalid_value(Unexpected::Float(number), &self)),
                }
            }
        }
        deserializer.deserialize_u64(Number)
    }
}

/// Number of an entry in the file's list of `T`.
#[derive(Deserialize)]
#[serde(transparent, bound = "")]
pub(super) struct Index<T>(Whole, #[serde(skip)] PhantomData<fn() -> T>);

impl<T> Index<T> {
    pub(super) fn value(self) -> usize {
        usize::try_from(self.0.0).unwrap_or(usize::MAX)
    }
}

impl<T> Clone for Index<T> {
    fn clone(&self) -> Index<T> {
        *self
    }
}

impl<T> Copy for Index<T> {}

/// The file as a whole, but for what [`Head`] has.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Root {
    #[serde(default)]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(super) animations: Vec<Animation>,
    #[serde(default)]
    pub(super) buffers: Vec<Buffer>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub(super) cameras: Vec<Camera>,
    #[serde(default)]
    pub(super) images: Vec<Image>,
    #[serde(default)]
    pub(super) materials: Vec<Material>,
    #[serde(default)]
    pub(super) meshes: Vec<Mesh>,
    #[serde(default)]
    pub(super) nodes: Vec<Node>,
    #[serde(default)]
    pub(super) samplers: Vec<TextureSampler>,
    pub(super) scene: Option<Index<Scene>>,
    #[serde(default)]
    pub(super) scenes: Vec<Scene>,
    #[serde(default)]
    pub(super) skins: Vec<Skin>,
    #[serde(default)]
    pub(super) textures: Vec<Texture>,
}

/// The head of a file, read before anything else: whether the file can be read at all.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Head {
    pub(super) asset: Asset,
    #[serde(default)]
    pub(super) extensions_required: Vec<String>,
    #[serde(default)]
    pub(super) extensions_used: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Asset {
    pub(super) version: String,
    pub(super) min_version: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) byte_length: Whole,
    #[serde(default)]
    pub(super) extensions: BufferExtensions,
    pub(super) uri: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: Index<Buffer>,
    pub(super) byte_length: Whole,
    pub(super) byte_offset: Option<Whole>,
    pub(super) byte_stride: Option<Whole>,
    #[serde(default)]
    pub(super) extensions: ViewExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct BufferExtensions {
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Fallback,
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Fallback,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Fallback {
    fallback: bool,
}

impl BufferExtensions {
    /// Whether the buffer is for readers that cannot decompress.
    pub(super) fn is_fallback(&self) -> bool {
        self.khr.fallback || self.ext.fallback
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ViewExtensions {
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Option<Compressed>,
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Option<Compressed>,
}

impl ViewExtensions {
    /// How the view is compressed, if it is; the extension has two names.
    pub(super) fn compressed(&self) -> Option<&Compressed> {
        self.khr.as_ref().or(self.ext.as_ref())
    }
}

/// `EXT_meshopt_compression`: where the compressed bytes are, and what they become.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Compressed {
    pub(super) buffer: Index<Buffer>,
    #[serde(default)]
    pub(super) byte_offset: Whole,
    pub(super) byte_length: Whole,
    pub(super) byte_stride: Whole,
    pub(super) count: Whole,
    pub(super) mode: String,
    pub(super) filter: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<Index<BufferView>>,
    pub(super) byte_offset: Option<Whole>,
    pub(super) component_type: ComponentType,
    pub(super) count: Whole,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) sparse: Option<Sparse>,
    #[serde(rename = "type")]
    pub(super) type_: Type,
}

/// The shape of an accessor's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum Type {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat4,
    #[serde(other)]
    Other,
}

/// The type of the components of an accessor's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(from = "Whole")]
pub(super) enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
    Other,
}

impl From<Whole> for ComponentType {
    fn from(Whole(number): Whole) -> ComponentType {
        match number {
            5120 => ComponentType::I8,
            5121 => ComponentType::U8,
            5122 => ComponentType::I16,
            5123 => ComponentType::U16,
            5125 => ComponentType::U32,
            5126 => ComponentType::F32,
            _ => ComponentType::Other,
        }
    }
}

impl ComponentType {
    /// Bytes of one; 0 where that is not known.
    pub(super) fn size(self) -> usize {
        match self {
            ComponentType::I8 | ComponentType::U8 => 1,
            ComponentType::I16 | ComponentType::U16 => 2,
            ComponentType::U32 | ComponentType::F32 => 4,
            ComponentType::Other => 0,
        }
    }
}

/// Values that differ from those of the accessor's buffer view.
#[derive(Deserialize)]
pub(super) struct Sparse {
    pub(super) count: Whole,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: Index<BufferView>,
    #[serde(default)]
    pub(super) byte_offset: Whole,
    pub(super) component_type: ComponentType,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: Index<BufferView>,
    #[serde(default)]
    pub(super) byte_offset: Whole,
}

#[derive(Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub(super) nodes: Vec<Index<Node>>,
}

#[derive(Deserialize)]
pub(super) struct Node {
    pub(super) camera: Option<Index<Camera>>,
    pub(super) children: Option<Vec<Index<Node>>>,
    #[serde(default)]
    pub(super) extensions: NodeExtensions,
    /// Column by column.
    pub(super) matrix: Option<[f32; 16]>,
    pub(super) mesh: Option<Index<Mesh>>,
    pub(super) name: Option<String>,
    /// x, y, z, w.
    pub(super) rotation: Option<[f32; 4]>,
    pub(super) scale: Option<[f32; 3]>,
    pub(super) skin: Option<Index<Skin>>,
    pub(super) translation: Option<[f32; 3]>,
    pub(super) weights: Option<Vec<f32>>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(super) instancing: Option<Instancing>,
}

/// `EXT_mesh_gpu_instancing`: accessors by name, of one value an instance.
#[derive(Deserialize)]
pub(super) struct Instancing {
    pub(super) attributes: BTreeMap<String, Index<Accessor>>,
}

#[derive(Deserialize)]
pub(super) struct Mesh {
    pub(super) name: Option<String>,
    pub(super) primitives: Vec<Primitive>,
    pub(super) weights: Option<Vec<f32>>,
}

#[derive(Deserialize)]
pub(super) struct Primitive {
    /// By semantic: `POSITION`, `JOINTS_0`, ...
    pub(super) attributes: BTreeMap<String, Index<Accessor>>,
    pub(super) indices: Option<Index<Accessor>>,
    pub(super) material: Option<Index<Material>>,
    #[serde(default)]
    pub(super) mode: Mode,
    pub(super) targets: Option<Vec<MorphTarget>>,
}

impl Primitive {
    /// The accessor of an attribute.
    pub(super) fn attribute(&self, semantic: &str) -> Option<Index<Accessor>> {
        self.attributes.get(semantic).copied()
    }
}

#[derive(Deserialize)]
pub(super) struct MorphTarget {
    #[serde(rename = "POSITION")]
    pub(super) positions: Option<Index<Accessor>>,
}

/// The primitives that vertices form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(from = "Whole")]
pub(super) enum Mode {
    PointsOrLines,
    #[default]
    Triangles,
    TriangleStrip,
    TriangleFan,
    Other,
}

impl From<Whole> for Mode {
    fn from(Whole(number): Whole) -> Mode {
        match number {
            0..=3 => Mode::PointsOrLines,
            4 => Mode::Triangles,
            5 => Mode::TriangleStrip,
            6 => Mode::TriangleFan,
            _ => Mode::Other,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    pub(super) inverse_bind_matrices: Option<Index<Accessor>>,
    pub(super) joints: Vec<Index<Node>>,
}

#[derive(Deserialize)]
pub(super) struct Animation {
    #[serde(default)]
    pub(super) channels: Vec<Channel>,
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) samplers: Vec<AnimationSampler>,
}

#[derive(Deserialize)]
pub(super) struct Channel {
    pub(super) sampler: Index<AnimationSampler>,
    pub(super) target: Target,
}

/// The target of a channel. Without a node an extension says what, or nothing.
#[derive(Deserialize)]
pub(super) struct Target {
    pub(super) node: Option<Index<Node>>,
    pub(super) path: TargetPath,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) enum TargetPath {
    Translation,
    Rotation,
    Scale,
    Weights,
    #[serde(other)]
    Other,
}

#[derive(Deserialize)]
pub(super) struct AnimationSampler {
    pub(super) input: Index<Accessor>,
    #[serde(default)]
    pub(super) interpolation: KeyKind,
    pub(super) output: Index<Accessor>,
}

/// The interpolation between keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum KeyKind {
    Step,
    #[default]
    Linear,
    CubicSpline,
    #[serde(other)]
    Other,
}

/// A camera.
#[derive(Deserialize)]
pub(super) struct Camera {
    pub(super) name: Option<String>,
    pub(super) perspective: Option<Perspective>,
    pub(super) orthographic: Option<Orthographic>,
}

#[derive(Deserialize)]
pub(super) struct Orthographic {
    pub(super) ymag: f32,
    pub(super) zfar: f32,
    pub(super) znear: f32,
}

#[derive(Deserialize)]
pub(super) struct Perspective {
    pub(super) yfov: f32,
    pub(super) zfar: Option<f32>,
    pub(super) znear: f32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Material {
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) alpha_mode: AlphaMode,
    #[serde(default)]
    pub(super) double_sided: bool,
    #[serde(default)]
    pub(super) pbr_metallic_roughness: PbrMetallicRoughness,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct PbrMetallicRoughness {
    pub(super) base_color_factor: [f32; 4],
    pub(super) base_color_texture: Option<TextureInfo>,
}

impl Default for PbrMetallicRoughness {
    fn default() -> PbrMetallicRoughness {
        PbrMetallicRoughness { base_color_factor: [1.0; 4], base_color_texture: None }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    #[serde(default)]
    pub(super) extensions: TextureInfoExtensions,
    pub(super) index: Index<Texture>,
    #[serde(default)]
    pub(super) tex_coord: Whole,
}

#[derive(Default, Deserialize)]
pub(super) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(super) transform: Option<TextureTransform>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct TextureTransform {
    pub(super) offset: [f32; 2],
    /// Radians.
    pub(super) rotation: f32,
    pub(super) scale: [f32; 2],
    pub(super) tex_coord: Option<Whole>,
}

impl Default for TextureTransform {
    fn default() -> TextureTransform {
        TextureTransform { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

/// A texture. One without a source has its picture in an extension, in a format of its own.
#[derive(Deserialize)]
pub(super) struct Texture {
    pub(super) sampler: Option<Index<TextureSampler>>,
    pub(super) source: Option<Index<Image>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureSampler {
    pub(super) mag_filter: Option<Whole>,
    #[serde(default)]
    pub(super) wrap_s: WrappingMode,
    #[serde(default)]
    pub(super) wrap_t: WrappingMode,
}

/// How a material is seen through. An unknown one is opaque.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum AlphaMode {
    Mask,
    Blend,
    #[default]
    #[serde(other)]
    Opaque,
}

impl AlphaMode {
    /// Its name, if it is not opaque.
    pub(super) fn shown(self) -> Option<&'static str> {
        match self {
            AlphaMode::Mask => Some("MASK"),
            AlphaMode::Blend => Some("BLEND"),
            AlphaMode::Opaque => None,
        }
    }
}

/// The wrapping beyond a picture's edge. An unknown one repeats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(from = "Whole")]
pub(super) enum WrappingMode {
    ClampToEdge,
    MirroredRepeat,
    #[default]
    Repeat,
}

impl From<Whole> for WrappingMode {
    fn from(Whole(number): Whole) -> WrappingMode {
        match number {
            33071 => WrappingMode::ClampToEdge,
            33648 => WrappingMode::MirroredRepeat,
            _ => WrappingMode::Repeat,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image {
    pub(super) buffer_view: Option<Index<BufferView>>,
    pub(super) uri: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_may_have_a_point() {
        for (text, number) in [("54", 54), ("54.0", 54), ("5.4e1", 54), ("-0.0", 0), ("1e30", u64::MAX)] {
            assert_eq!(serde_json::from_str::<Whole>(text).unwrap(), Whole(number), "{text}");
        }
        for text in ["54.5", "-1", "-1.0", "\"54\"", "null", "[]", "true"] {
            let error = serde_json::from_str::<Whole>(text).unwrap_err().to_string();
            assert!(error.contains("whole number, 0 or above"), "{text}: {error}");
        }
    }

    #[test]
    fn unknown_values_are_no_fault_in_themselves() {
        assert_eq!(serde_json::from_str::<Type>("\"MAT2\"").unwrap(), Type::Other);
        assert_eq!(serde_json::from_str::<ComponentType>("5130").unwrap(), ComponentType::Other);
        assert_eq!(serde_json::from_str::<TargetPath>("\"pointer\"").unwrap(), TargetPath::Other);
        assert_eq!(serde_json::from_str::<KeyKind>("\"CUBICSPLINE\"").unwrap(), KeyKind::CubicSpline);
        assert_eq!(serde_json::from_str::<KeyKind>("\"MAGIC\"").unwrap(), KeyKind::Other);
        assert_eq!(serde_json::from_str::<Mode>("7").unwrap(), Mode::Other);
        assert_eq!(serde_json::from_str::<WrappingMode>("33071.0").unwrap(), WrappingMode::ClampToEdge);
    }
}
