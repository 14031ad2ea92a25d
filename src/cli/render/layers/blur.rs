//! The layers of the blur effect. Where nothing moved, or the strength is 0, a frame is frame i + 1: all of it is at
//! k' = 1, no triangle has been drawn, and buffers hold what an earlier frame left.

use super::{Blurred, Entry, Made};
use crate::blur::layout::{
    COLOUR_LAYER, CONTROL, FINISHED, MASK_LAYER, NEXT_LAYER, PICTURE, PREVIOUS_LAYER, SUBFRAME_LAYER, VERTICES,
};
use crate::blur::params::{Control, SHOWN_NEXT, Vertex};
use crate::blur::{Interval, Mesh};
use crate::cli::render::outputs::LayerData;
use crate::plan::BufferId;

pub(super) const LAYERS: &[Entry] = &[
    Entry::array("blur.vertices", &[CONTROL, VERTICES], vertices),
    Entry::array("blur.triangles", &[CONTROL, VERTICES, FINISHED], triangles),
    Entry::image("blur.previous", &[PREVIOUS_LAYER], |made| LayerData::Colour(shown(made, PREVIOUS_LAYER))),
    Entry::image("blur.next", &[NEXT_LAYER, PICTURE], |made| {
        LayerData::Colour(if is_still(made) { picture(made) } else { made.image(NEXT_LAYER) })
    }),
    Entry::image("blur.subframe", &[SUBFRAME_LAYER], |made| {
        LayerData::Value(if is_still(made) { vec![1.0; made.pixels] } else { made.image(SUBFRAME_LAYER) })
    }),
    Entry::image("blur.mask", &[MASK_LAYER], mask),
    Entry::image("blur.colour", &[COLOUR_LAYER], |made| LayerData::Colour(shown(made, COLOUR_LAYER))),
    Entry::image("blur", &[PICTURE], |made| LayerData::Colour(picture(made))),
];

/// Columns of `blur.vertices`: x, y, velocity x, y, cluster, k, l, k'.
const COLUMNS: u64 = 8;
/// Values of each corner in `blur.triangles`: x, y, view depth, k'.
const CORNER: u64 = 4;
/// In `blur.mask`: frame i + 1 alone shows it.
const NEXT: f32 = SHOWN_NEXT as f32;

fn is_still(made: &Made) -> bool {
    made.blurred.is_some_and(|blurred| blurred.is_still)
}

/// Triangles and vertices of the refined mesh, and its vertices.
fn refined(made: &Made) -> (usize, Vec<Vertex>) {
    let points = made.blurred.map_or(0, |blurred| blurred.motion.mesh.points());
    let control: Vec<Control> = made.read(CONTROL, 1);
    let [triangles, count] = control.first().map_or([0; 2], |control| [control.triangles, control.vertices]);
    (triangles as usize, made.read(VERTICES, (count as usize).max(points)))
}

/// A row for each vertex of the file.
fn vertices(made: &Made) -> LayerData {
    let Some(Blurred { motion, is_still, .. }) = made.blurred else { return LayerData::table(COLUMNS, Vec::new()) };
    let rows = match is_still {
        true => still_rows(&motion.mesh, &motion.interval),
        false => rows(&motion.mesh, &refined(made).1),
    };
    LayerData::table(COLUMNS, rows)
}

fn rows(mesh: &Mesh, vertices: &[Vertex]) -> Vec<f32> {
    let points = mesh.file_to_point().iter().filter_map(|point| vertices.get(*point as usize));
    let row = |Vertex { position: [x, y], velocity: [vx, vy], k, l, time, cluster, .. }: &Vertex| {
        [*x, *y, *vx, *vy, *cluster as f32, *k, *l, *time]
    };
    points.flat_map(row).collect()
}

fn still_rows(mesh: &Mesh, interval: &Interval) -> Vec<f32> {
    let row = |point: &u32| {
        let point = *point as usize;
        let [x, y, vx, vy] = interval.motion.get(point).copied().unwrap_or_default();
        [x, y, vx, vy, interval.labels.get(point).copied().unwrap_or_default() as f32, 1.0, 0.0, 1.0]
    };
    mesh.file_to_point().iter().flat_map(row).collect()
}

fn triangles(made: &Made) -> LayerData {
    let (count, vertices) = if is_still(made) { (0, Vec::new()) } else { refined(made) };
    let finished: Vec<[u32; 4]> = made.read(FINISHED, count);
    let corners = finished.iter().flat_map(|triangle| &triangle[..3]);
    let row = |v: &Vertex| [v.drawn[0], v.drawn[1], v.drawn_depth, v.drawn_time];
    let values: Vec<f32> = corners.filter_map(|corner| vertices.get(*corner as usize)).flat_map(row).collect();
    LayerData::Array { shape: vec![values.len() as u64 / (3 * CORNER), 3, CORNER], values }
}

/// What of the smear pixels show.
fn shown(made: &Made, id: BufferId) -> Vec<[f32; 4]> {
    if is_still(made) { vec![[0.0; 4]; made.pixels] } else { made.image(id) }
}

fn mask(made: &Made) -> LayerData {
    let mask = || made.image::<u32>(MASK_LAYER).into_iter().map(|mask| mask as f32).collect();
    LayerData::Value(if is_still(made) { vec![NEXT; made.pixels] } else { mask() })
}

/// The picture of the blur alone.
fn picture(made: &Made) -> Vec<[f32; 4]> {
    match made.blurred {
        Some(Blurred { is_alone: true, picture, .. }) => picture.to_vec(),
        // Other effects are drawn over it.
        Some(Blurred { is_still: true, .. }) => made.image(PICTURE),
        _ => made.image(PICTURE).into_iter().map(whole).collect(),
    }
}

/// A pixel without its mark: an alpha of negative sign is that of a pixel of frame i + 1.
fn whole([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    [r, g, b, a.abs()]
}
