//! Density volumes.

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
