//! What hosts see through, made of a camera's view: projections of every kind.

use celfx::view::{Camera, View};
use glam::{DMat4, DVec3, DVec4};

/// Changes the rows of a projection: across, down, depth and w.
fn with_rows(view: View, change: impl Fn([DVec4; 4]) -> [DVec4; 4]) -> View {
    let clip = &view.view_to_clip;
    let [across, down, depth, w] = change([0, 1, 2, 3].map(|row| clip.row(row)));
    View { view_to_clip: DMat4::from_cols(across, down, depth, w).transpose(), ..view }
}

/// Off its axis, as one eye's.
pub fn moved(view: View) -> View {
    with_rows(view, |[across, down, depth, w]| [across + 0.3 * w, down - 0.2 * w, depth, w])
}

/// A part of the picture, larger.
pub fn tile(view: View) -> View {
    with_rows(view, |[across, down, depth, w]| [1.7 * across + 0.4 * w, 1.7 * down, depth, w])
}

/// Pixels that are wider than high.
pub fn squeezed(view: View) -> View {
    with_rows(view, |[across, down, depth, w]| [0.7 * across, down, depth, w])
}

/// What is to the left is to the right.
pub fn mirrored(view: View) -> View {
    with_rows(view, |[across, down, depth, w]| [-across, down, depth, w])
}

/// By a quarter, as screens are that are held upright. `aspect`: width over height.
pub fn turned(view: View, aspect: f64) -> View {
    with_rows(view, |[across, down, depth, w]| [-down * aspect, across / aspect, depth, w])
}

/// The same with view space's z axis to the viewer.
pub fn backwards(view: View) -> View {
    let flip = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
    View { world_to_view: flip * view.world_to_view, view_to_clip: view.view_to_clip * flip, ..view }
}

/// Moved within a pixel, each frame another way.
pub fn jittered(view: View, frame: usize) -> View {
    let place = |base: f64| (frame as f64 * base + 0.37).fract() - 0.5;
    View { jitter: [place(0.618), place(0.414)], ..view }
}

/// Orthographic, with as much in the picture as a camera's view has at a distance, and what is so far before and behind that.
pub fn parallel(view: View, distance: f64, around: f64) -> View {
    with_rows(view, |[across, down, ..]| {
        let (near, far) = (distance - around, distance + around);
        [across / distance, down / distance, DVec4::new(0.0, 0.0, -1.0, far) / (far - near), DVec4::W]
    })
}

/// The same of a view space whose origin is at the distance.
pub fn parallel_around(view: View, distance: f64, around: f64) -> View {
    let back = DMat4::from_translation(DVec3::new(0.0, 0.0, -distance));
    let view = View { world_to_view: back * view.world_to_view, ..parallel(view, distance, around) };
    with_rows(view, |[across, down, _, w]| [across, down, DVec4::new(0.0, 0.0, -1.0, around) / (2.0 * around), w])
}

/// Views of much the same as a camera has `distance` away in pictures of `size` pixels.
pub fn of(camera: &Camera, size: [u32; 2], distance: f64) -> Vec<(&'static str, View)> {
    let (view, aspect) = (camera.view(size), f64::from(size[0]) / f64::from(size[1]));
    let orthographic = parallel(view, distance, 2.0);
    vec![
        ("jittered", jittered(view, 0)),
        ("off-centre", moved(view)),
        ("tile", tile(view)),
        ("squeezed", squeezed(view)),
        ("mirrored", mirrored(view)),
        ("turned", turned(view, aspect)),
        ("backwards", backwards(view).with_reversed(false)),
        ("orthographic", orthographic),
        ("orthographic around", parallel_around(view, distance, 2.0)),
        ("orthographic tile", jittered(tile(mirrored(orthographic)), 1)),
        ("orthographic turned", squeezed(turned(backwards(orthographic), aspect))),
    ]
}
