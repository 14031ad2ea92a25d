//! Ends of smears that are dry: which bristles have left something.

use crate::blur::motion::Cluster;
use crate::random::{hash, unit};
use crate::shaders::blur::constants::{BRISTLE_SLOT, BRISTLES, HELD};

/// A brush.
#[derive(Clone, Copy, Debug)]
pub struct Brush {
    /// The setting.
    pub dry: f64,
    /// Pixels that what ends in all of its bristles is drawn back.
    pub full: f64,
    /// Of the bristles.
    pub seed: u32,
    /// Of their random numbers.
    pub generation: u32,
}

impl Brush {
    /// How far front a vertex counts, which smoothing at seams has given `smoothing`.
    pub fn front(k: f64, smoothing: f64) -> f64 {
        (k + f64::from(HELD) * smoothing).min(1.0)
    }

    /// How far front of the end of its bristle a place of a cluster is, which is drawn back so many pixels: below 0 there is
    /// nothing of it.
    pub fn left(&self, cluster: &Cluster, front: f64, l: f64, back: f64) -> f64 {
        let length =
            unit(hash(self.seed, cluster.object, BRISTLE_SLOT + Brush::bristle(cluster, l) as u32, self.generation));
        front - self.dry * (back / self.full).clamp(0.0, 1.0) * f64::from(length)
    }

    /// The number of a bristle, and the share of it that is beside the place.
    pub fn bristle(cluster: &Cluster, l: f64) -> f64 {
        l.max(0.0) * f64::from(BRISTLES) * f64::from(cluster.teeth)
    }
}
