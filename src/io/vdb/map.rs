//! Where a grid is in the world.

use glam::{DMat3, DVec3};

use super::bytes::Bytes;
use crate::io::ReadError;
use crate::view::FARTHEST;

/// Takes places on a grid, at whose whole numbers the middles of voxels are, to the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// The way from a voxel to the next along each of the grid's axes: columns.
    pub axes: DMat3,
    /// Where voxel (0, 0, 0) has its middle.
    pub middle: DVec3,
}

impl Map {
    pub(super) fn read(bytes: &mut Bytes) -> Result<Map, ReadError> {
        let begin = *bytes;
        let name = bytes.text("the kind of a transform")?;
        let vector = |bytes: &mut Bytes| bytes.value::<[f64; 3]>("a transform").map(DVec3::from_array);
        let map = match &name[..] {
            "UniformScaleMap" | "ScaleMap" => {
                let scale = vector(bytes)?;
                // What follows from it: voxel size and inverses.
                (0..4).try_for_each(|_| vector(bytes).map(|_| ()))?;
                Map { axes: DMat3::from_diagonal(scale), middle: DVec3::ZERO }
            }
            "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
                let (middle, scale) = (vector(bytes)?, vector(bytes)?);
                (0..4).try_for_each(|_| vector(bytes).map(|_| ()))?;
                Map { axes: DMat3::from_diagonal(scale), middle }
            }
            "TranslationMap" => Map { axes: DMat3::IDENTITY, middle: vector(bytes)? },
            "AffineMap" | "UnitaryMap" => {
                // Rows that a place is multiplied with from the left: each is an axis, and the last the translation.
                let rows: [[f64; 4]; 4] = bytes.value("a transform")?;
                let [x, y, z, middle] = rows.map(|[x, y, z, _]| DVec3::new(x, y, z));
                if rows.map(|row| row[3]) != [0.0, 0.0, 0.0, 1.0] {
                    return Err(begin.fault(format!("the transform is {rows:?}"), "an affine one"));
                }
                Map { axes: DMat3::from_cols(x, y, z), middle }
            }
            _ => {
                let expected = "an affine one: scaled, moved, turned or sheared";
                return Err(begin.fault(format!("the transform is a `{name}`"), expected));
            }
        };
        match map.is_valid() {
            true => Ok(map),
            false => Err(begin.fault(format!("the transform is {map:?}"), "finite axes that span space")),
        }
    }

    fn is_valid(&self) -> bool {
        let sizes = self.voxel_size();
        // Also the smallest and largest voxels.
        let farthest = f64::from(FARTHEST);
        let are_sizes = sizes.to_array().iter().all(|size| (1.0 / farthest..=farthest).contains(size));
        let volume = self.axes.determinant().abs() / sizes.element_product();
        are_sizes && volume > 1e-6 && self.middle.abs().max_element() <= farthest
    }

    /// The lengths of its axes, in metres.
    pub fn voxel_size(&self) -> DVec3 {
        DVec3::new(self.axes.x_axis.length(), self.axes.y_axis.length(), self.axes.z_axis.length())
    }

    /// Where a place of the grid is in the world.
    pub fn world(&self, place: DVec3) -> DVec3 {
        self.axes * place + self.middle
    }

    /// The same seen by somebody who calls up what the file calls its third axis: (x, y, z) is (x, z, -y) to them.
    #[must_use]
    pub fn z_up(&self) -> Map {
        let turn = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
        Map { axes: turn * self.axes, middle: turn * self.middle }
    }

    /// For each axis of the world the grid's own that runs along it, and whether backwards; none if one runs along none, but
    /// for what rounding has left.
    pub fn along_axes(&self) -> Option<[(usize, bool); 3]> {
        let mut found = [None; 3];
        for axis in 0..3 {
            let way = self.axes.col(axis);
            let longest = (0..3).max_by(|a, b| way[*a].abs().total_cmp(&way[*b].abs()))?;
            let beside = way.length_squared() - way[longest] * way[longest];
            if beside > 1e-12 * way.length_squared() || found[longest].is_some() {
                return None;
            }
            found[longest] = Some((axis, way[longest] < 0.0));
        }
        Some([found[0]?, found[1]?, found[2]?])
    }
}
