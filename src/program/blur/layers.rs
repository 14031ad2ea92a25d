//! The layers of the blur effect. Where nothing moved, or the strength is 0, a frame is frame i + 1: all of it is at
//! k' = 1, no triangle has been drawn, and buffers hold what an earlier frame left.

use super::input::BlurBrought;
use crate::blur::layout::{
    COLOUR_LAYER, CONTROL, FINISHED, MASK_LAYER, NEXT_LAYER, OBJECT_LAYER, PICTURE, PREVIOUS_LAYER, SUBFRAME_LAYER,
    SURFACE, VERTICES,
};
use crate::blur::params::{Control, ENDED_BY_BUDGET, ROUNDS, SHOWN_NEXT, Vertex};
use crate::blur::settings::{Refine, Settings};
use crate::blur::{Desc, Interval, Mesh};
use crate::offline::BlurFrame;
use crate::plan::BufferId;
use crate::program::layers::{LayerData, LayerEntry, Made, Shown, Watch, Who};
use crate::shaders::blur::blocks::Covering;

pub(super) const LAYERS: &[LayerEntry] = &[
    LayerEntry::array("blur.vertices", &[CONTROL, VERTICES], vertices),
    LayerEntry::array("blur.triangles", &[CONTROL, VERTICES, FINISHED], triangles),
    LayerEntry::image("blur.previous", &[PREVIOUS_LAYER], |made| LayerData::Colour(shown(made, PREVIOUS_LAYER))),
    LayerEntry::image("blur.next", &[NEXT_LAYER, PICTURE], |made| {
        LayerData::Colour(if is_still(made) { picture(made) } else { made.image(NEXT_LAYER) })
    }),
    LayerEntry::image("blur.subframe", &[SUBFRAME_LAYER], |made| {
        LayerData::Value(if is_still(made) { vec![1.0; made.pixels()] } else { made.image(SUBFRAME_LAYER) })
    }),
    LayerEntry::image("blur.mask", &[MASK_LAYER], mask),
    LayerEntry::image("blur.colour", &[COLOUR_LAYER], |made| LayerData::Colour(shown(made, COLOUR_LAYER))),
    LayerEntry::image("blur.depth", &[SURFACE], |made| {
        LayerData::Value(made.image::<Covering>(SURFACE).iter().map(|covering| covering.depth).collect())
    }),
    LayerEntry::image("blur.object", &[OBJECT_LAYER], objects),
    LayerEntry::image("blur", &[PICTURE], |made| LayerData::Colour(picture(made))),
];

/// Where and what of the mesh pixels show.
pub(super) const SHOWN: Shown = Shown { depth: "blur.depth", who: Who::Objects("blur.object") };

/// Says it where a frame's refinement did not come to its own end.
pub(super) const REFINEMENT: Watch = Watch { buffers: &[CONTROL], says: refinement_ended };

/// Columns of `blur.vertices`: x, y, velocity x, y, cluster, k, l, k'.
const COLUMNS: u64 = 8;
/// Values of each corner in `blur.triangles`: x, y, view depth, k'.
const CORNER: u64 = 4;
/// In `blur.mask`: frame i + 1 alone shows it.
const NEXT: f32 = SHOWN_NEXT as f32;

fn is_still(made: &Made) -> bool {
    made.is_skipped("blur.refine")
}

fn motion<'a>(made: &'a Made) -> Option<&'a BlurFrame> {
    made.brought().map(|brought: &BlurBrought| &brought.frame)
}

/// Triangles and vertices of the refined mesh, and its vertices.
fn refined(made: &Made) -> (usize, Vec<Vertex>) {
    let points = motion(made).map_or(0, |motion| motion.mesh.points());
    let control: Vec<Control> = made.read(CONTROL, 1);
    let [triangles, count] = control.first().map_or([0; 2], |control| [control.triangles, control.vertices]);
    (triangles as usize, made.read(VERTICES, (count as usize).max(points)))
}

/// A row for each vertex of the file.
fn vertices(made: &Made) -> LayerData {
    let Some(motion) = motion(made) else { return LayerData::table(COLUMNS, Vec::new()) };
    let rows = match is_still(made) {
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

/// The part of the smear that pixels show.
fn shown(made: &Made, id: BufferId) -> Vec<[f32; 4]> {
    if is_still(made) { vec![[0.0; 4]; made.pixels()] } else { made.image(id) }
}

fn objects(made: &Made) -> LayerData {
    let brought: Option<&BlurBrought> = made.brought();
    let names = brought.map(|brought| brought.objects()).unwrap_or_default();
    LayerData::Objects { samples: made.image(OBJECT_LAYER), names }
}

fn mask(made: &Made) -> LayerData {
    let mask = || made.image::<u32>(MASK_LAYER).into_iter().map(|mask| mask as f32).collect();
    LayerData::Value(if is_still(made) { vec![NEXT; made.pixels()] } else { mask() })
}

/// The picture of the blur alone.
fn picture(made: &Made) -> Vec<[f32; 4]> {
    match (made.is_alone, is_still(made)) {
        (true, _) => made.picture.to_vec(),
        // Other effects are drawn over it.
        (false, true) => made.image(PICTURE),
        (false, false) => made.image(PICTURE).into_iter().map(whole).collect(),
    }
}

/// A pixel without its mark: an alpha of negative sign is that of a pixel of frame i + 1.
fn whole([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    [r, g, b, a.abs()]
}

fn refinement_ended(made: &Made) -> Option<String> {
    let Settings { refine, tolerance, edge, .. } = made.desc::<Desc>()?.settings;
    if is_still(made) {
        return None;
    }
    let Control { triangles, undivided, ended_by, .. } = *made.read(CONTROL, 1).first()?;
    let (key, value) = match refine {
        Refine::Error => ("blur.tolerance", tolerance),
        Refine::Length => ("blur.edge", edge),
    };
    let why = match ended_by {
        0 => return None,
        ENDED_BY_BUDGET => "there is room for no more".to_owned(),
        _ => format!("{ROUNDS} rounds are the most"),
    };
    Some(format!(
        "the blur's refinement ended at {triangles} triangles, {undivided} of which are coarser than \
         {key} = {value} asks for: {why}. Raise {key}, or use a simpler mesh"
    ))
}
