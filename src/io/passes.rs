//! The passes that renderers write beside their pictures: depth, motion vectors and objects of each pixel.
//!
//! They are what one sample at a pixel's centre sees: filtered ones mix objects at their borders.

use std::path::Path;

use super::ReadError;
use super::image::{Wanted, read_named};
use super::pattern::Pattern;
use crate::settings::words;

words! {
    /// Whose motion vectors these are: which channels they have, and what these mean.
    pub enum Vectors {
        /// Blender's pass `Vector`: X, Y (or R, G) are where a place was in the frame before less where it is; Z, W (or B, A)
        /// where it is less where it will be in the frame after. In pixels, y up.
        #[default]
        Blender = "blender",
        /// Arnold's `motionvector`: R, G (or X, Y) are how far a place moves while the shutter is open, in pixels, y up. The
        /// shutter must be open for the whole time from the frame before to this one, or `scale` must be 1 / its time.
        Arnold = "arnold",
        /// The motion vectors of Unreal's Movie Render Queue: R, G are 0.5 and where a place is less where it was in the frame
        /// before, in shares of the picture's width and height, y up.
        Unreal = "unreal",
    }
}

/// The passes of a shot's frames, and how they are to be read.
#[derive(Clone, Debug, PartialEq)]
pub struct Passes {
    /// Depth along the view axis, in any unit, above 0.
    pub depth: Pattern,
    /// Motion vectors.
    pub motion: Pattern,
    /// Objects; none: borders are seen by depth and motion alone.
    pub id: Option<Pattern>,
    /// Whose vectors they are.
    pub vectors: Vectors,
    /// What vectors are multiplied by.
    pub scale: f32,
}

/// What the passes say of a frame. All lists have a value a pixel, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct PassFrame {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Depth, above 0; infinite where nothing is seen.
    pub depth: Vec<f32>,
    /// Object.
    pub id: Vec<u32>,
    /// From where a place is to where it was in the frame before, in pixels, y down.
    pub previous: Vec<[f32; 2]>,
    /// From there to where it will be in the frame after, if the pass knows it.
    pub next: Option<Vec<[f32; 2]>>,
}

/// Depths from which on nothing is seen: Blender has 1e10 there, others the largest number.
const NOTHING: f32 = 1e9;
/// Vectors of so many pixels stand for none.
const UNKNOWN: f32 = 1e4;

const DEPTH: Wanted = Wanted {
    what: "depth",
    layers: &["depth", "z", "worlddepth", "scenedepth"],
    channels: &[&["z"], &["v"], &["y"], &["r"], &["x"]],
    plain: &[&["z"], &["depth"], &["v"], &["y"], &["r"]],
};
const MOTION_LAYERS: &[&str] =
    &["vector", "motionvectors", "motionvector", "motion_vectors", "motion_vector", "velocity", "motion"];
const BOTH_WAYS: Wanted = Wanted {
    what: "motion vectors",
    layers: MOTION_LAYERS,
    channels: &[&["x", "y", "z", "w"], &["r", "g", "b", "a"], &["x", "y"], &["r", "g"]],
    plain: &[&["x", "y", "z", "w"], &["r", "g", "b", "a"], &["x", "y"], &["r", "g"]],
};
const ONE_WAY: Wanted = Wanted {
    what: "motion vectors",
    layers: MOTION_LAYERS,
    channels: &[&["r", "g"], &["x", "y"]],
    plain: &[&["r", "g"], &["x", "y"]],
};
const ID: Wanted = Wanted {
    what: "objects",
    layers: &[
        "cryptoobject00",
        "crypto_object00",
        "cryptoasset00",
        "crypto_asset00",
        "cryptomaterial00",
        "crypto_material00",
        "actorhitproxymask00",
        "indexob",
        "object index",
        "id",
    ],
    channels: &[&["r"], &["x"], &["v"], &["y"]],
    plain: &[&["id"], &["x"], &["v"], &["y"], &["r"]],
};

impl Passes {
    /// Files of a frame, each with what it is.
    pub fn files(&self) -> impl Iterator<Item = &Pattern> {
        [&self.depth, &self.motion].into_iter().chain(&self.id)
    }

    /// Reads those of a frame of a picture of that size.
    ///
    /// # Errors
    /// A file that cannot be read, of another size, or without such channels.
    pub fn read(&self, frame: u32, size: [u32; 2]) -> Result<PassFrame, ReadError> {
        let one = |pattern: &Pattern, wanted: &Wanted| {
            let mut channels = read_named(&pattern.path(frame), size, wanted)?;
            Ok(if channels.is_empty() { Vec::new() } else { channels.swap_remove(0) })
        };
        let depth: Vec<f32> = one(&self.depth, &DEPTH)?;
        let depth = depth.into_iter().map(|z| if z > 0.0 && z < NOTHING { z } else { f32::INFINITY }).collect();
        let id = self.id.as_ref().map(|id| one(id, &ID)).transpose()?;
        let pixels = size[0] as usize * size[1] as usize;
        let id = id.map_or_else(|| vec![0; pixels], |id| id.into_iter().map(number).collect());
        let (previous, next) = self.read_vectors(&self.motion.path(frame), size)?;
        Ok(PassFrame { size, depth, id, previous, next })
    }

    fn read_vectors(&self, path: &Path, size: [u32; 2]) -> Result<(Field, Option<Field>), ReadError> {
        let wanted = if self.vectors == Vectors::Blender { &BOTH_WAYS } else { &ONE_WAY };
        let channels = read_named(path, size, wanted)?;
        let [width, height] = size.map(|side| side as f32);
        // What a unit of each channel is to the right and down, and what stands for no motion.
        let ([right, down], zero) = match self.vectors {
            Vectors::Blender => ([1.0, -1.0], 0.0),
            Vectors::Arnold => ([-1.0, 1.0], 0.0),
            Vectors::Unreal => ([-width, height], 0.5),
        };
        let field = |x: usize, by: f32| {
            let pairs = channels.get(x)?.iter().zip(channels.get(x + 1)?);
            let vector = |(x, y): (&f32, &f32)| [right * (x - zero), down * (y - zero)].map(|c| by * self.scale * c);
            Some(pairs.map(vector).map(known).collect())
        };
        // The other direction is the other way around.
        let next = if self.vectors == Vectors::Blender { field(2, -1.0) } else { None };
        Ok((field(0, 1.0).unwrap_or_default(), next))
    }
}

/// A vector of each pixel.
type Field = Vec<[f32; 2]>;

/// A vector, or none where there is none.
fn known(vector: [f32; 2]) -> [f32; 2] {
    if vector.iter().all(|c| c.abs() < UNKNOWN) { vector } else { [0.0; 2] }
}

/// The number of an object: itself, or the bits of one that is none, as Cryptomatte has them.
fn number(id: f32) -> u32 {
    let whole = id as u32;
    if whole as f32 == id { whole } else { id.to_bits() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::image::write_exr_channels;
    use crate::io::tests::Folder;

    const SIZE: [u32; 2] = [4, 2];

    /// A place that is at a pixel of the second frame was 6 pixels to the left of it and 3 above, and goes on so: the vectors as
    /// each renderer writes them.
    fn written(folder: &Folder, vectors: Vectors, channels: &[(&str, f32)]) -> PassFrame {
        let all = |(name, value): &(&str, f32)| ((*name).to_owned(), vec![*value; 8]);
        let mut channels: Vec<(String, Vec<f32>)> = channels.iter().map(all).collect();
        channels.push(("L.Depth.Z".to_owned(), vec![2.0, 2.0, 2.0, 2.0, 0.0, 1e10, f32::NAN, -1.0]));
        channels.push(("L.IndexOB.X".to_owned(), vec![3.0; 8]));
        let path = folder.0.join("all.exr");
        write_exr_channels(&path, SIZE, &channels).expect("written");
        let pattern = Pattern::single(path);
        let passes = Passes { depth: pattern.clone(), motion: pattern.clone(), id: Some(pattern), vectors, scale: 1.0 };
        passes.read(1, SIZE).expect("readable")
    }

    #[test]
    fn one_motion_is_the_same_in_every_convention() {
        let folder = Folder::new();
        let blender = [("L.Vector.X", -6.0), ("L.Vector.Y", 3.0), ("L.Vector.Z", -6.0), ("L.Vector.W", 3.0)];
        let blender = written(&folder, Vectors::Blender, &blender);
        let arnold = written(&folder, Vectors::Arnold, &[("motionvector.R", 6.0), ("motionvector.G", -3.0)]);
        let unreal = [("Final_MotionVectors.R", 0.5 + 6.0 / 4.0), ("Final_MotionVectors.G", 0.5 - 3.0 / 2.0)];
        let unreal = written(&folder, Vectors::Unreal, &unreal);
        assert_eq!(blender.previous, [[-6.0, -3.0]; 8]);
        assert_eq!(blender.next, Some(vec![[6.0, 3.0]; 8]));
        for other in [arnold, unreal] {
            assert_eq!(other, PassFrame { next: None, ..blender.clone() });
        }
        assert_eq!(blender.depth, [[2.0; 4], [f32::INFINITY; 4]].concat());
        assert_eq!(blender.id, [3; 8]);
    }

    #[test]
    fn vectors_that_are_unknown_are_none() {
        let channels = [("L.Vector.X", 1e4), ("L.Vector.Y", f32::NAN)];
        assert_eq!(written(&Folder::new(), Vectors::Blender, &channels).previous, [[0.0; 2]; 8]);
        // Hashes of Cryptomatte are any bits; what is a number stays one.
        assert_eq!([0.0, 7.0, 0.5, -1.0].map(number), [0, 7, 0.5_f32.to_bits(), (-1.0_f32).to_bits()]);
    }
}
