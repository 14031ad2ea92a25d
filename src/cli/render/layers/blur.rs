//! The layers of the blur effect.

use super::{Blurred, LayerName, read};
use crate::blur::Mesh;
use crate::blur::layout;
use crate::blur::params::{Control, SHOWN_NEXT, Vertex};
use crate::cli::render::outputs::{Layer, LayerData};
use crate::plan::BufferId;

/// Every layer's name, and whether it is an array.
pub(super) const LAYERS: [LayerName; 8] = [
    ("blur.vertices", true),
    ("blur.triangles", true),
    ("blur.previous", false),
    ("blur.next", false),
    ("blur.subframe", false),
    ("blur.mask", false),
    ("blur.colour", false),
    ("blur", false),
];

/// The buffers that layers are made of, in the order in which [`decode`] takes them.
pub(super) const BUFFERS: [BufferId; 9] = [
    layout::CONTROL,
    layout::VERTICES,
    layout::FINISHED,
    layout::PREVIOUS_LAYER,
    layout::NEXT_LAYER,
    layout::SUBFRAME_LAYER,
    layout::MASK_LAYER,
    layout::COLOUR_LAYER,
    layout::PICTURE,
];

/// Columns of `blur.vertices`: x, y, velocity x, y, cluster, k, l, k'.
const COLUMNS: u64 = 8;
/// Values of each corner in `blur.triangles`: x, y, view depth, k'.
const CORNER: u64 = 4;
/// In `blur.mask`: frame i + 1 alone shows it.
const NEXT: f32 = SHOWN_NEXT as f32;

/// Makes the layers of a picture of `pixels` pixels.
pub(super) fn decode(bytes: [&[u8]; BUFFERS.len()], pixels: usize, blurred: &Blurred) -> Vec<Layer> {
    let mesh = &blurred.motion.mesh;
    let [control, vertices, finished, previous, next, subframe, mask, colour, picture] = bytes;
    let control: Vec<Control> = read(control, 1);
    let [triangles, count] = control.first().map_or([0; 2], |control| [control.triangles, control.vertices]);
    let vertices: Vec<Vertex> = read(vertices, (count as usize).max(mesh.points()));
    let finished: Vec<[u32; 4]> = read(finished, triangles as usize);
    let corners = finished.iter().flat_map(|triangle| &triangle[..3]);
    let corner = |v: &Vertex| [v.drawn[0], v.drawn[1], v.drawn_depth, v.drawn_time];
    let corners: Vec<f32> = corners.filter_map(|place| vertices.get(*place as usize)).flat_map(corner).collect();
    let mask: Vec<u32> = read(mask, pixels);
    let data = [
        LayerData::table(COLUMNS, rows(&vertices, mesh)),
        LayerData::Array { shape: vec![corners.len() as u64 / (3 * CORNER), 3, CORNER], values: corners },
        LayerData::Colour(read(previous, pixels)),
        LayerData::Colour(read(next, pixels)),
        LayerData::Value(read(subframe, pixels)),
        LayerData::Value(mask.into_iter().map(|mask| mask as f32).collect()),
        LayerData::Colour(read(colour, pixels)),
        LayerData::Colour(match blurred.is_alone {
            true => blurred.picture.to_vec(),
            false => read(picture, pixels).into_iter().map(whole).collect(),
        }),
    ];
    named(data)
}

/// The layers of a frame that is frame i + 1, because nothing moves or the strength is 0: all of it is at k' = 1, and
/// no triangle has been drawn.
pub(super) fn still(bytes: [&[u8]; BUFFERS.len()], blurred: &Blurred) -> Vec<Layer> {
    let Blurred { motion, picture, is_alone, .. } = blurred;
    let count = picture.len();
    // Other effects are drawn over it.
    let picture = if *is_alone { picture.to_vec() } else { read(bytes[BUFFERS.len() - 1], count) };
    let (mesh, interval) = (&motion.mesh, &motion.interval);
    let row = |point: &u32| {
        let point = *point as usize;
        let [x, y, vx, vy] = interval.motion.get(point).copied().unwrap_or_default();
        [x, y, vx, vy, interval.labels.get(point).copied().unwrap_or_default() as f32, 1.0, 0.0, 1.0]
    };
    named([
        LayerData::table(COLUMNS, mesh.file_to_point().iter().flat_map(row).collect()),
        LayerData::Array { shape: vec![0, 3, CORNER], values: Vec::new() },
        LayerData::Colour(vec![[0.0; 4]; count]),
        LayerData::Colour(picture.clone()),
        LayerData::Value(vec![1.0; count]),
        LayerData::Value(vec![NEXT; count]),
        LayerData::Colour(vec![[0.0; 4]; count]),
        LayerData::Colour(picture),
    ])
}

fn named(data: [LayerData; LAYERS.len()]) -> Vec<Layer> {
    LAYERS.into_iter().zip(data).map(|((name, _), data)| Layer { name, data }).collect()
}

/// A row for each vertex of the file.
fn rows(vertices: &[Vertex], mesh: &Mesh) -> Vec<f32> {
    let points = mesh.file_to_point().iter().filter_map(|point| vertices.get(*point as usize));
    let row = |Vertex { position: [x, y], velocity: [vx, vy], k, l, time, cluster, .. }: &Vertex| {
        [*x, *y, *vx, *vy, *cluster as f32, *k, *l, *time]
    };
    points.flat_map(row).collect()
}

/// A pixel without its mark: an alpha of negative sign is that of a pixel of frame i + 1.
fn whole([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    [r, g, b, a.abs()]
}
