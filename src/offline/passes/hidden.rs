//! What frame i shows of moving surfaces and frame i + 1 hides.

use super::sheets::share_of;
use super::tracks::{Seen, widened};

/// How far apart depths of one surface may be, as a share.
const SAME: f32 = 0.05;
/// Of a pixel and its eight neighbours, so many are shown by nothing else where something is hidden: single ones are rounding.
const MOST: usize = 6;
/// Pixels by which what is hidden reaches below what hides it, so that no gap is between.
const OVERLAP: usize = 2;

/// Pixels of frame i to be meshed besides those of frame i + 1, whose triangles are at these places in frame i: x, y and
/// share of depth, each with its object.
pub(super) fn pixels(
    previous: &Seen,
    next: &Seen,
    places: &[[f32; 3]],
    triangles: &[[u32; 3]],
    ids: &[u32],
) -> Vec<bool> {
    let [width, height] = previous.sheets.size;
    let mut shown = vec![false; width * height];
    for triangle in triangles {
        let id = ids[triangle[0] as usize];
        cover(triangle.map(|point| places[point as usize]), [width, height], |pixel, share| {
            let is_same =
                previous.frame.id[pixel] == id && (share_of(previous.frame.depth[pixel]) - share).abs() < SAME;
            shown[pixel] |= is_same;
        });
    }
    let is_missing = |pixel: usize| previous.movers[pixel] && !shown[pixel];
    let missing: Vec<bool> =
        (0..shown.len()).map(|pixel| is_missing(pixel) && is_behind(previous, next, pixel)).collect();
    let mut mask: Vec<bool> =
        (0..shown.len()).map(|pixel| missing[pixel] && is_core(&missing, [width, height], pixel)).collect();
    for _ in 0..OVERLAP {
        mask = widened(&previous.sheets, &mask);
    }
    mask
}

/// Whether what a pixel shows is hidden in the frame after, where it goes then, or leaves the picture.
fn is_behind(previous: &Seen, next: &Seen, pixel: usize) -> bool {
    let width = previous.sheets.size[0];
    let frame = &previous.frame;
    let [x, y] = match &frame.next {
        Some(next) => next[pixel],
        None => frame.previous[pixel].map(|c| -c),
    };
    let at = [(pixel % width) as f32 + 0.5 + x, (pixel / width) as f32 + 0.5 + y];
    let is_inside = [0, 1].iter().all(|axis| (0.0..frame.size[*axis] as f32).contains(&at[*axis]));
    !is_inside || next.nearest(at) < share_of(frame.depth[pixel]) + SAME
}

fn is_core(missing: &[bool], [width, height]: [usize; 2], pixel: usize) -> bool {
    let (x, y) = (pixel % width, pixel / width);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    let around = rows.flat_map(|row| (x.saturating_sub(1)..(x + 2).min(width)).map(move |column| row * width + column));
    around.filter(|pixel| missing[*pixel]).count() >= MOST
}

/// Calls `found` with each pixel whose centre a triangle covers, its border included, and the triangle's value there.
fn cover([a, b, c]: [[f32; 3]; 3], size: [usize; 2], mut found: impl FnMut(usize, f32)) {
    // Larger ones are torn: they show nothing that could be told.
    const MOST_SIDE: f32 = 64.0;
    let ends = |axis: usize| {
        let values = [a[axis], b[axis], c[axis]];
        (values.iter().copied().fold(f32::MAX, f32::min), values.iter().copied().fold(f32::MIN, f32::max))
    };
    let ((left, right), (top, bottom)) = (ends(0), ends(1));
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if area == 0.0 || !area.is_finite() || right - left > MOST_SIDE || bottom - top > MOST_SIDE {
        return;
    }
    let range = |from: f32, to: f32, side: usize| {
        let first = (from - 0.5).ceil().clamp(0.0, side as f32) as usize;
        first..((to - 0.5).floor() + 1.0).clamp(0.0, side as f32) as usize
    };
    for y in range(top, bottom, size[1]) {
        for x in range(left, right, size[0]) {
            let at = [x as f32 + 0.5, y as f32 + 0.5];
            let side = |p: [f32; 3], q: [f32; 3]| (q[0] - p[0]) * (at[1] - p[1]) - (q[1] - p[1]) * (at[0] - p[0]);
            let weights = [side(b, c), side(c, a), side(a, b)].map(|side| side / area);
            if weights.iter().all(|weight| *weight >= -1e-4) {
                found(y * size[0] + x, weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2]);
            }
        }
    }
}
