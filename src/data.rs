//! Input of effects, in memory: volumes, particles, meshes. Files and simulations make these.

use crate::blur::Texture;
use crate::smoke::reference::Grid;

/// A density volume in memory: x runs fastest, then y, then z.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Voxels along x, y, z.
    pub dimensions: [u32; 3],
    /// Sides of a voxel in metres.
    pub voxel_size: [f32; 3],
    /// World position of the corner of voxel (0, 0, 0).
    pub origin: [f32; 3],
    /// One density per voxel.
    pub density: Vec<f32>,
    /// One velocity (m/s; x, y, z) per voxel.
    pub velocity: Option<Vec<[f32; 3]>>,
}

impl Volume {
    /// As the references read it.
    pub fn grid(&self) -> Grid<'_> {
        Grid {
            dimensions: self.dimensions,
            voxel_size: self.voxel_size,
            origin: self.origin,
            density: &self.density,
            velocity: self.velocity.as_deref(),
        }
    }
}

/// Particles in memory, a row each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// World positions in metres, finite.
    pub position: Vec<[f32; 3]>,
    /// Temperatures in kelvin, above 0 and finite.
    pub temperature: Vec<f32>,
    /// Ids that keep a particle's random draws over frames; none: its row.
    pub id: Option<Vec<u32>>,
    /// Velocities in m/s, finite; none: all are still.
    pub velocity: Option<Vec<[f32; 3]>>,
}

/// Bounds of the particles of a sequence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleExtent {
    /// Most particles of a frame.
    pub most: u32,
    /// Highest temperature in kelvin, or a bound above it; at least 1.
    pub hottest: f32,
}

/// The constant part of an animated mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// Vertices of each triangle, in either direction: files differ, and mirrors turn them over.
    pub triangles: Vec<[u32; 3]>,
    /// Object of each vertex: its number in `objects`. In glTF each node that has a mesh is one.
    pub object: Vec<u32>,
    /// Names of the objects.
    pub objects: Vec<String>,
    /// Linear RGB of each vertex, not negative; without its texture.
    pub colour: Vec<[f32; 3]>,
    /// How much of a smear's strength each vertex has, 0 to 1: the attribute `_SMEAR` of a glTF file, the array `smear` of a
    /// cache; 1 where it has none.
    pub share: Vec<f32>,
    /// Material of each vertex: its number in `materials`.
    pub material: Vec<u32>,
    /// Names of the materials that there are; "" of what has none.
    pub materials: Vec<String>,
    /// Textures that vertices' colours are multiplied by.
    pub textures: Vec<Texture>,
    /// The texture of each vertex: its number in `textures`.
    pub texture: Vec<Option<u32>>,
    /// Where each vertex is in its texture, from the upper left to (1, 1).
    pub texture_place: Vec<[f32; 2]>,
    /// Texture coordinates of each vertex, TEXCOORD_0 of a glTF file, where `has_coordinates`.
    pub coordinates: Vec<[f32; 2]>,
    /// Whether some vertices have such.
    pub has_coordinates: bool,
    /// Normal of each vertex at rest, in its object's own space, as the file has it; (0, 0, 0) where it has none.
    pub normal: Vec<[f32; 3]>,
    /// Whether an object has triangles that are meant to be seen from both sides.
    pub double_sided: Vec<bool>,
    /// Whether triangles of vertices without normals are flat, as glTF has it. Otherwise they are smooth, but for sharp
    /// edges (the reader finds them).
    pub faceted: bool,
}

impl Topology {
    /// Whether a triangle has one normal, its own.
    pub fn is_flat(&self, triangle: usize) -> bool {
        self.faceted && self.triangles[triangle].iter().all(|&corner| self.normal[corner as usize] == [0.0; 3])
    }

    /// The same vertices without the triangles of one object, so that what it hides can be seen.
    pub fn without(&self, object: u32) -> Topology {
        let stays = |corners: &&[u32; 3]| self.object[corners[0] as usize] != object;
        Topology { triangles: self.triangles.iter().filter(stays).copied().collect(), ..self.clone() }
    }
}
