//! How a view differs from that of the frame before.

use glam::{DMat3, DVec2, DVec3};

use super::{Projection, View};
use crate::shaders::shared::blocks::MotionConstants;

impl MotionConstants {
    /// From the view of the frame before to this one, for pictures of `size` pixels. Between views of which one is perspective and the
    /// other is not, as in no frame before, nothing is told to have moved. `moves`: whether what is seen has moved by itself.
    pub(crate) fn new(before: Option<&View>, view: &View, size: [u32; 2], moves: bool) -> MotionConstants {
        let now = Projection::of_valid(&view.without_jitter(), size);
        let before = before.map(|before| Projection::of_valid(&before.without_jitter(), size));
        let before = before.filter(|before| before.is_orthographic == now.is_orthographic).unwrap_or(now);
        // What is the same is exactly so.
        let turn = match before.axes == now.axes {
            true => DMat3::ZERO,
            false => before.axes * now.axes.transpose() - DMat3::IDENTITY,
        };
        let shift: DVec3 = before.axes * (now.eye - before.eye);
        let row = |axis: usize| turn.row(axis).extend(shift[axis]).as_vec4().to_array();
        let pair = |v: DVec2| v.as_vec2().to_array();
        MotionConstants {
            right: row(0),
            up: row(1),
            forward: row(2),
            focal: pair(before.focal),
            focal_change: pair(before.focal - now.focal),
            centre_change: pair(before.centre - now.centre),
            near: before.near as f32,
            moves: moves.into(),
            has_edges: 0,
        }
    }
}
