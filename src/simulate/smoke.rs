//! Smoke in closed form.
use crate::io::volume::Volume;

/// A built-in volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Builtin {
    /// A rising column.
    Plume,
    /// A cumulus.
    Cloud,
}

impl Builtin {
    /// Finds by name.
    pub fn named(name: &str) -> Option<Builtin> {
        match name {
            "plume" => Some(Builtin::Plume),
            "cloud" => Some(Builtin::Cloud),
            _ => None,
        }
    }
    /// Volume of a frame.
    pub fn volume(self, _frame: u32, _fps: f64) -> Volume {
        Volume { dimensions: [1; 3], voxel_size: [1.0; 3], origin: [0.0; 3], density: vec![1.0], velocity: None }
    }
}
