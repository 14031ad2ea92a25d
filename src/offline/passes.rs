//! Input of a blur's frames without a mesh: the passes that any renderer writes beside its pictures.
//!
//! The pixels of frame i + 1 that move become a mesh: a grid of each surface, cut where depth, object or motion jumps. It lives in
//! a space whose x and y are pixels and whose depth is the logarithm of the passes', seen without perspective; where its points
//! were in frame i, and are in the frames beside, follows from the motion vectors. What frame i shows and frame i + 1 hides is a
//! second part of the mesh, made of frame i's pixels, so that nothing is missing where smears lay it bare; and a third is where
//! surfaces go on a little below what hides them in both. What stands still is in the mesh where it is before smears, and hides
//! them. All else is as with the mesh of a scene.
//!
//! What passes do not say is not known: what neither frame shows, what is transparent, what is blurred already.

mod front;
mod grid;
mod hidden;
mod sheets;
mod tracks;
mod under;

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use glam::{DMat4, DVec4};

use crate::blur::settings::{Completion, Settings, Trajectory};
use crate::blur::{self, Counts, FrameView, Mesh, MeshInput, Motion, Pose, Window};
use crate::io::ReadError;
use crate::io::passes::PassFrame;
use crate::offline::motion::{BlurError, BlurFrame, Positions};
use crate::view::View;
use grid::Grid;
use tracks::{Around, Next, Places, Poses, Seen};

/// The farthest depth of passes that is seen, and the inverse of the nearest.
const DEEPEST: f64 = 1e9;
/// Half the vertical angle of view, in degrees, for which the blur takes lengths in a view without perspective.
const HALF_VIEW: f64 = 20.0;
/// Side of the largest cells of a surface, in pixels at 1080 lines.
const CELL: u32 = 4;
/// Pixels of the picture for each point that there is room for, and the least room.
const PIXELS_A_POINT: u32 = 8;
const LEAST_ROOM: u32 = 4096;

/// Reads the passes of a frame.
type Read = dyn FnMut(u32) -> Result<PassFrame, ReadError> + Send;

/// The passes of a shot. Frames may be asked for in any order, and each depends on the shot alone.
pub struct PassesInput {
    read: Box<Read>,
    /// First and last of the shot.
    frames: [u32; 2],
    /// Frames at which it is cut, where these are all.
    cuts: Vec<u32>,
    settings: Settings,
    size: [u32; 2],
    motion: Motion,
    seen: BTreeMap<u32, Arc<Seen>>,
    threads: usize,
}

impl fmt::Debug for PassesInput {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("PassesInput").field("frames", &self.frames).finish_non_exhaustive()
    }
}

impl PassesInput {
    /// Of a shot of the frames `frames[0]` to `frames[1]`, pictures of `size` pixels, whose passes `read` reads. With at most so
    /// many threads.
    ///
    /// # Errors
    /// A setting out of range.
    pub fn new(
        read: impl FnMut(u32) -> Result<PassFrame, ReadError> + Send + 'static,
        frames: [u32; 2],
        settings: &Settings,
        size: [u32; 2],
        threads: usize,
    ) -> Result<PassesInput, BlurError> {
        let motion = Motion::new(settings, size)?;
        let settings = settings.clone();
        let (cuts, seen) = (Vec::new(), BTreeMap::new());
        Ok(PassesInput { read: Box::new(read), frames, cuts, settings, size, motion, seen, threads })
    }

    /// The same, cut at these frames, each the first of what comes then, besides at those that are found: none, if the
    /// settings' `jump` is 0.
    #[must_use]
    pub fn cut_at(mut self, frames: &[u32]) -> PassesInput {
        self.cuts = frames.to_vec();
        self
    }

    /// Description of an effect that blurs these passes' pictures, with room for the mesh of any frame.
    ///
    /// # Errors
    /// None that there can be.
    pub fn desc(&self, seed: u32, layers: bool) -> Result<blur::Desc, BlurError> {
        let points = self.room();
        let triangles = 2 * points;
        let mut settings = self.settings.clone();
        // All that the mesh has is seen, and its normals are not those of what was rendered: there is nothing to learn from them.
        if settings.completion == Completion::Surface {
            settings.completion = Completion::None;
        }
        Ok(blur::Desc {
            target_format: super::TARGET_FORMAT,
            points,
            triangles,
            // Of a plane graph; each edge is in two lists.
            neighbours: 6 * points,
            surfaces: points,
            groups: points.next_multiple_of(blur::GroupInput::MULTIPLE),
            group_triangles: 3 * triangles,
            outer: true,
            most_triangles: blur::MOST_TRIANGLES.max(2 * triangles).min(crate::blur::params::BASE_MASK),
            segments: blur::Desc::segments_of(&settings),
            seed,
            layers,
            ..blur::Desc::new(&nothing()?, self.size, settings)
        })
    }

    /// Points that a frame's mesh may have.
    fn room(&self) -> u32 {
        let [width, height] = self.size;
        (width * height / PIXELS_A_POINT).max(LEAST_ROOM)
    }

    fn shape(&self) -> Shape {
        let lines = (CELL * self.size[1] / 1080).max(2);
        Shape { room: self.room() as usize, cell: 1 << lines.ilog2(), reach: self.settings.reach() }
    }

    /// The input of output `number`.
    ///
    /// # Errors
    /// Passes that cannot be read.
    pub fn frame(&mut self, number: u32) -> Result<BlurFrame, BlurError> {
        let [first, last] = self.frames;
        let number = number.clamp(first, last);
        let current = if number == first { first } else { number - 1 };
        let (mesh, poses, frames) = match number == first || self.is_cut(number)? {
            true => (nothing()?, vec![vec![[0.0; 3]]; (number - current) as usize + 1], [current, number]),
            false => self.meshed(number)?,
        };
        let view = self.view();
        let poses: Vec<Positions> = poses.into_iter().map(Arc::new).collect();
        let seen = poses.iter().map(|positions| Pose { positions, view: &view, cut: false });
        let seen: Vec<Pose> = seen.collect();
        let place = (current - frames[0]) as usize;
        let window = Window { frame: current, poses: &seen, current: place, between: &[] };
        let interval = self.motion.interval(&mesh, &window, self.threads)?;
        let knots = self.motion.knots(&window).map(<[_]>::to_vec);
        let views = [-1, 0, 1, 2].map(|offset| {
            let frame = (i64::from(current) + offset).clamp(frames[0].into(), frames[1].into()) as u32;
            FrameView { frame, view }
        });
        let counts = Counts::of(&interval, mesh.neighbours());
        let (mesh, colours) = (Arc::new(mesh), Arc::default());
        let (textures, shares) = Default::default();
        Ok(BlurFrame { mesh, colours, textures, shares, interval, counts, views, knots, first: frames[0], poses })
    }

    /// The mesh of output `number`, its poses, and the first and the last frame that they are of.
    fn meshed(&mut self, number: u32) -> Result<(Mesh, Vec<Places>, [u32; 2]), BlurError> {
        let [first, last] = self.frames;
        let begin = if number - 1 > first && !self.is_cut(number - 1)? { number - 2 } else { number - 1 };
        let knows_next = number < last && self.settings.trajectory != Trajectory::Past;
        let end = if knows_next && !self.is_cut(number + 1)? { number + 1 } else { number };
        // The next output begins no earlier.
        self.seen = self.seen.split_off(&begin);
        let frames = [number.checked_sub(2), Some(number - 1), Some(number), Some(number + 1)];
        let frames = frames.map(|frame| frame.filter(|frame| (begin..=end).contains(frame)));
        let around = frames.map(|frame| self.seen.get(&frame?).cloned());
        let around = around.each_ref().map(Option::as_deref);
        let (mesh, poses) = mesh_of(around, self.shape())?;
        let unit = self.depth_unit() as f32;
        let placed = |pose: Vec<[f32; 3]>| pose.into_iter().map(|[x, y, share]| [x, y, unit * share]).collect();
        let poses = poses.into_iter().zip(frames).filter(|(_, frame)| frame.is_some());
        Ok((mesh, poses.map(|(pose, _)| placed(pose)).collect(), [begin, end]))
    }

    /// Whether a frame of the shot begins a new one.
    fn is_cut(&mut self, frame: u32) -> Result<bool, BlurError> {
        if self.cuts.contains(&frame) {
            return Ok(true);
        }
        let (before, after) = (self.see(frame - 1)?, self.see(frame)?);
        Ok(self.settings.jump > 0.0 && tracks::is_cut(&before, &after))
    }

    fn see(&mut self, frame: u32) -> Result<Arc<Seen>, BlurError> {
        if let Some(seen) = self.seen.get(&frame) {
            return Ok(seen.clone());
        }
        let seen = Arc::new(Seen::new((self.read)(frame)?));
        self.seen.insert(frame, seen.clone());
        Ok(seen)
    }

    /// What a depth that is e times as far is farther, in pixels: what the blur takes for as much of a view without perspective.
    fn depth_unit(&self) -> f64 {
        0.5 * f64::from(self.size[1]) / HALF_VIEW.to_radians().tan()
    }

    /// What sees the mesh: x and y are pixels.
    fn view(&self) -> View {
        let [width, height] = self.size.map(f64::from);
        let deepest = 2.0 * DEEPEST.ln() * self.depth_unit();
        let view_to_clip = DMat4::from_cols(
            DVec4::new(2.0 / width, 0.0, 0.0, -1.0),
            DVec4::new(0.0, 2.0 / height, 0.0, -1.0),
            DVec4::new(0.0, 0.0, 1.0 / deepest, 0.5),
            DVec4::W,
        )
        .transpose();
        let view = View { world_to_view: DMat4::IDENTITY, view_to_clip, jitter: [0.0; 2], reversed: false };
        // As the depth that effects of a picture share.
        view.with_reversed(true)
    }
}

/// What a mesh of pixels is to be like.
#[derive(Clone, Copy, Debug)]
struct Shape {
    /// Points that there may be.
    room: usize,
    /// Side of the largest cells in pixels.
    cell: usize,
    /// Frames that smears reach back.
    reach: f32,
}

/// A mesh of what does not move: a point that is not seen.
fn nothing() -> Result<Mesh, BlurError> {
    let input = MeshInput { vertices: 1, triangles: &[], objects: None, weld: None, normals: None, rest: None };
    Ok(Mesh::new(&input)?)
}

/// The mesh of frames i and i + 1, and its places.
fn mesh_of([before, previous, next, after]: Around, shape: Shape) -> Result<(Mesh, Poses), BlurError> {
    let (Some(previous), Some(next)) = (previous, next) else { return Ok((nothing()?, Poses::default())) };
    let mut mask = front::pixels(next, shape.reach);
    mask.iter_mut().zip(&next.movers).for_each(|(is_in, moves)| *is_in |= moves);
    let own = Grid::new(&next.sheets, &mask, shape.cell);
    let found = Next::new(&own, previous, next, after);
    let mask = hidden::pixels(previous, next, &found.earlier, &own.triangles, found.ids());
    let behind = Grid::new(&previous.sheets, &mask, shape.cell);
    let (frame, sheets, mask) = under::extended(next, shape.reach);
    let below = Grid::new(&sheets, &mask, shape.cell);
    let grids = [&own, &behind, &below];
    if grids.iter().map(|grid| grid.points.len()).sum::<usize>() > shape.room {
        // Of every other pixel there are fewer.
        let halved = [before, Some(previous), Some(next), after].map(|seen| Some(seen?.halved()));
        let (mesh, poses) = mesh_of(halved.each_ref().map(Option::as_ref), shape)?;
        let doubled = |pose: Vec<[f32; 3]>| pose.into_iter().map(|[x, y, share]| [2.0 * x, 2.0 * y, share]).collect();
        return Ok((mesh, poses.map(doubled)));
    }
    let others = [tracks::of_hidden(&behind, previous, next), tracks::of_below(&below, &frame, &sheets, next)];
    let ids = others.iter().map(|(_, ids)| &ids[..]);
    let mesh = joined(grids, &std::iter::once(found.ids()).chain(ids).collect::<Vec<_>>().concat())?;
    let mut poses = found.poses(mesh.neighbours());
    for (places, _) in others {
        poses.iter_mut().zip(places).for_each(|(pose, places)| pose.extend(places));
    }
    if poses[0].is_empty() {
        poses = std::array::from_fn(|_| vec![[0.0; 3]]);
    }
    Ok((mesh, poses))
}

/// The mesh of several grids, the object of whose points is known.
fn joined(grids: [&Grid; 3], ids: &[u32]) -> Result<Mesh, BlurError> {
    if ids.is_empty() {
        return nothing();
    }
    let (mut triangles, mut first) = (Vec::new(), 0);
    for grid in grids {
        triangles.extend(grid.triangles.iter().map(|triangle| triangle.map(|point| first + point)));
        first += grid.points.len() as u32;
    }
    Ok(Mesh::new(&MeshInput {
        vertices: ids.len(),
        triangles: &triangles,
        objects: Some(ids),
        weld: None,
        normals: None,
        rest: None,
    })?)
}

#[cfg(test)]
mod tests;
