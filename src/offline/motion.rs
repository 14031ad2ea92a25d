//! Input of a blur's frames: the poses of an animated mesh around each, and what moves between two of them.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use crate::blur::motion::MOST_FRAMES;
use crate::blur::motion::WINDOW;
use crate::blur::params::MOST_SEGMENTS;
use crate::blur::settings::{Settings, Trajectory};
use crate::blur::{
    self, Counts, FrameView, Interval, Knot, Mesh, MeshInput, Motion, Pose, TopologyInput, Window, texture_rows,
};
use crate::error::Error;
use crate::io::ReadError;
use crate::io::scene::{AnimatedMesh, shading_groups};
use crate::view::View;

/// Frames to each side of an interval in which different poses are looked for.
pub(crate) const FRAMES_BESIDE: u32 = MOST_FRAMES as u32;
/// Steps between two frames with `trajectory = "exact"`.
pub(crate) const STEPS: u32 = 8;

/// Positions of the points of a mesh in a frame.
pub type Positions = Arc<Vec<[f32; 3]>>;

/// Why a frame of a blur cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BlurError {
    /// The mesh has a pose that nothing can be made of.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// What follows from the poses cannot be made.
    #[error(transparent)]
    Effect(#[from] Error),
}

/// The animated mesh of a shot. Frames may be asked for in any order, and each depends on the shot alone; poses are kept
/// for as long as the next frame may need them.
pub struct BlurInput {
    scene: AnimatedMesh,
    view: Box<dyn Fn(f64) -> View + Send>,
    /// First and last of the shot.
    frames: [u32; 2],
    /// Frames at which it is cut, where these are all.
    cuts: Vec<u32>,
    settings: Settings,
    mesh: Arc<Mesh>,
    colours: Arc<Vec<[f32; 4]>>,
    textures: Arc<Vec<[u32; 4]>>,
    shares: Arc<Vec<f32>>,
    motion: Motion,
    poses: BTreeMap<u32, Positions>,
    threads: usize,
}

impl fmt::Debug for BlurInput {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("BlurInput").field("frames", &self.frames).finish_non_exhaustive()
    }
}

/// Input of one output, number i + 1, but for the images.
#[derive(Clone, Debug)]
pub struct BlurFrame {
    /// The mesh: that of the whole shot.
    pub mesh: Arc<Mesh>,
    /// Base colours: [`TopologyInput::colour_rows`] of the shot's mesh.
    pub colours: Arc<Vec<[f32; 4]>>,
    /// Rows of textures ([`crate::blur::texture_rows`]) for frames that are drawn.
    pub textures: Arc<Vec<[u32; 4]>>,
    /// Share of strength of each point; none, where all have all of it.
    pub shares: Arc<Vec<f32>>,
    /// The motion from frame i to frame i + 1. None in the shot's first frame, which has none before it.
    pub interval: Interval,
    /// How much of it there is.
    pub counts: Counts,
    /// Frames i - 1, i, i + 1, i + 2; where there is no such frame, the nearest of the others.
    pub views: [FrameView; 4],
    /// The frames that trajectories go through, where the device can make them.
    pub knots: Option<Vec<Knot>>,
    /// Number of the first of `poses`.
    pub first: u32,
    /// Poses of consecutive frames: at least those of the views and of the knots.
    pub poses: Vec<Positions>,
}

impl BlurFrame {
    /// Number of frame i, and of frame i + 1.
    pub fn images(&self) -> [u32; 2] {
        [self.views[1].frame, self.views[2].frame]
    }

    /// Number of frame i - 1, and of frame i + 2, if these exist.
    pub fn outer_images(&self) -> [Option<u32>; 2] {
        let [before, previous, next, after] = self.views.map(|view| view.frame);
        let moves = previous != next;
        [Some(before).filter(|frame| moves && *frame != previous), Some(after).filter(|frame| moves && *frame != next)]
    }
}

impl BlurInput {
    /// Of a shot of the frames `frames[0]` to `frames[1]`, of whose poses only the first is looked at. `view` is what a
    /// frame, which may lie between two, is seen through in pictures of `size` pixels. With at most so many threads.
    ///
    /// # Errors
    /// A vertex that is not at a finite position in the first frame, which it names; a setting out of range.
    pub fn new(
        scene: AnimatedMesh,
        view: impl Fn(f64) -> View + Send + 'static,
        frames: [u32; 2],
        settings: &Settings,
        size: [u32; 2],
        threads: usize,
    ) -> Result<BlurInput, BlurError> {
        let weld = scene.weld();
        let rest = scene.pose(f64::from(frames[0]))?;
        let mut topology = scene.topology().clone();
        let mut mesh = Mesh::new(&MeshInput {
            vertices: scene.vertices(),
            triangles: &topology.triangles,
            objects: Some(&topology.object),
            weld: Some(&weld),
            normals: None,
            rest: Some(&rest),
        })?;
        mesh.set_materials(&topology.material)?;
        topology.triangles = mesh.corners().to_vec();
        let groups = shading_groups(&topology, &weld, &rest);
        // Vertices of one point share a normal if they have the same one here: any that tells the groups apart.
        let normals: Vec<[f32; 3]> = groups.iter().map(|group| [f32::from_bits(*group), 0.0, 0.0]).collect();
        mesh.set_normals(&normals)?;
        let mesh = mesh.faceted(|triangle| topology.is_flat(triangle));
        let motion = Motion::new(settings, size)?;
        let colours = TopologyInput::colour_rows(&mesh, &topology.colour);
        let textures = texture_rows(&mesh, &topology.textures, &topology.texture, &topology.texture_place);
        let shares = mesh.gather(&topology.share).filter(|shares| shares.iter().any(|share| *share != 1.0));
        Ok(BlurInput {
            colours: Arc::new(colours),
            textures: Arc::new(textures),
            shares: Arc::new(shares.unwrap_or_default()),
            view: Box::new(view),
            frames,
            cuts: Vec::new(),
            settings: settings.clone(),
            mesh: Arc::new(mesh),
            motion,
            poses: BTreeMap::new(),
            threads,
            scene,
        })
    }

    /// The same, cut at these frames, each the first of what comes then, besides at those that are found: none, if the
    /// settings' `jump` is 0.
    #[must_use]
    pub fn cut_at(mut self, frames: &[u32]) -> BlurInput {
        self.cuts = frames.to_vec();
        self
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// Description of an effect that blurs this mesh in pictures of `size` pixels, with the poses on the device of all
    /// frames that the ones from `rendered[0]` to `rendered[1]` can be made of: [`crate::offline::Offline`] keeps fewer of
    /// them where they take too much of its memory. `toon`: frames are drawn, because there are no images of them.
    pub fn desc(&self, size: [u32; 2], rendered: [u32; 2], seed: u32, toon: bool, layers: bool) -> blur::Desc {
        let settings = &self.settings;
        let inner = if settings.trajectory == Trajectory::Exact { STEPS } else { 1 };
        let first = self.frames[0].max(rendered[0].saturating_sub(FRAMES_BESIDE + 1));
        let last = self.frames[1].min(rendered[1].saturating_add(FRAMES_BESIDE + 1));
        let desc = blur::Desc::new(&self.mesh, size, settings.clone());
        blur::Desc {
            target_format: super::TARGET_FORMAT,
            texture_rows: if toon { self.textures.len() as u32 } else { 0 },
            outer: !toon || !settings.toon.draws_smears(),
            toon,
            most_triangles: desc
                .most_triangles
                .max(desc.triangles.saturating_mul(4))
                .min(crate::blur::params::BASE_MASK),
            segments: (inner + settings.reach().ceil() as u32).min(MOST_SEGMENTS),
            frames_resident: last.saturating_sub(first).saturating_add(1).max(4),
            seed,
            layers,
            ..desc
        }
    }

    /// The input of output `number`.
    ///
    /// # Errors
    /// As [`BlurInput::new`]; a view too far from the mesh.
    pub fn frame(&mut self, number: u32) -> Result<BlurFrame, BlurError> {
        let [first, last] = self.frames;
        let number = number.clamp(first, last);
        let current = if number == first { first } else { number - 1 };
        self.read(current)?;
        self.read(number)?;
        let changes = self.changes([current, number]);
        let changes = [changes[0] || self.settings.trajectory == Trajectory::Exact, changes[1]];
        let begin = self.reach(current, |frame| frame.checked_sub(1).filter(|before| *before >= first), changes)?;
        let end = match number == first {
            // Nothing comes before it: it is the last of its own sequence.
            true => first,
            false => self.reach(number, |frame| Some(frame + 1).filter(|after| *after <= last), changes)?,
        };
        // The next output's window begins no earlier.
        self.poses = self.poses.split_off(&begin);
        let seen: Vec<View> = (begin..=end).map(|frame| (self.view)(f64::from(frame))).collect();
        let positions: Vec<Positions> = self.poses.range(begin..=end).map(|(_, pose)| pose.clone()).collect();
        let poses = (begin..).zip(positions.iter().zip(&seen)).map(|(frame, (positions, view))| Pose {
            positions,
            view,
            cut: self.cuts.contains(&frame),
        });
        let poses: Vec<Pose> = poses.collect();
        let between = self.between(current, number)?;
        let between: Vec<Pose> = between.iter().map(|(positions, view)| Pose { positions, view, cut: false }).collect();
        let window = Window { frame: current, poses: &poses, current: (current - begin) as usize, between: &between };
        let interval = self.motion.interval(&self.mesh, &window, self.threads)?;
        let knots = self.motion.knots(&window).map(<[_]>::to_vec);
        // Beside a cut there are no frames of this shot to look into.
        let own = self.motion.uncut(&window);
        let ends = [begin + own.start as u32, begin + own.end as u32 - 1].map(i64::from);
        let view = |frame: i64| {
            let frame = frame.clamp(ends[0], ends[1].max(number.into())) as u32;
            FrameView { frame, view: seen[(frame - begin) as usize] }
        };
        let views = [-1, 0, 1, 2].map(|offset| view(i64::from(current) + offset));
        let counts = Counts::of(&interval, self.mesh.neighbours());
        let (mesh, colours, shares) = (self.mesh.clone(), self.colours.clone(), self.shares.clone());
        let textures = self.textures.clone();
        Ok(BlurFrame {
            mesh,
            colours,
            textures,
            shares,
            interval,
            counts,
            views,
            knots,
            first: begin,
            poses: positions,
        })
    }

    /// Reads poses from a frame on, each followed by `next`, until enough of them differ, if it is the mesh that changes, and
    /// of the views, if it is the camera; the last one that was read.
    fn reach(&mut self, from: u32, next: impl Fn(u32) -> Option<u32>, is_wanted: [bool; 2]) -> Result<u32, BlurError> {
        let wanted = WINDOW + self.settings.reach().ceil() as usize;
        let (mut at, mut found) = (from, [0; 2]);
        let is_enough = |found: [usize; 2]| [0, 1].iter().all(|k| !is_wanted[*k] || found[*k] >= wanted);
        while let Some(frame) = next(at).filter(|frame| frame.abs_diff(from) <= FRAMES_BESIDE) {
            // One is looked into in any case.
            if at != from && is_enough(found) {
                break;
            }
            self.read(frame)?;
            let changes = self.changes([at, frame]);
            found = [0, 1].map(|k| found[k] + usize::from(changes[k]));
            at = frame;
        }
        Ok(at)
    }

    /// Whether the mesh differs in two frames, and whether the view does.
    fn changes(&self, frames: [u32; 2]) -> [bool; 2] {
        let [a, b] = frames.map(|frame| (self.view)(f64::from(frame)));
        let bits = |frame: u32| self.poses.get(&frame).map(|pose| bytemuck::cast_slice::<_, u8>(pose));
        [bits(frames[0]) != bits(frames[1]), a != b]
    }

    /// Reads a frame's pose, and those after it that threads can read in the same time and the window will want.
    fn read(&mut self, frame: u32) -> Result<(), BlurError> {
        if self.poses.contains_key(&frame) {
            return Ok(());
        }
        let more = (frame..=self.frames[1]).take(self.threads.min(WINDOW));
        let frames: Vec<u32> = more.take_while(|frame| !self.poses.contains_key(frame)).collect();
        let times: Vec<f64> = frames.iter().map(|frame| f64::from(*frame)).collect();
        let poses = self.scene.poses(&times, self.threads)?;
        for (frame, pose) in frames.into_iter().zip(&poses) {
            self.poses.insert(frame, self.gathered(pose));
        }
        Ok(())
    }

    fn gathered(&self, pose: &[[f32; 3]]) -> Positions {
        // A scene's poses have as many vertices as its mesh.
        Arc::new(self.mesh.gather(pose).unwrap_or_default())
    }

    /// Poses between two frames, and what sees them.
    fn between(&self, current: u32, number: u32) -> Result<Vec<(Positions, View)>, BlurError> {
        if self.settings.trajectory != Trajectory::Exact || current == number {
            return Ok(Vec::new());
        }
        let times = (1..STEPS).map(|step| f64::from(current) + f64::from(step) / f64::from(STEPS));
        let times: Vec<f64> = times.collect();
        let poses = self.scene.poses(&times, self.threads)?;
        Ok(poses.iter().zip(times).map(|(pose, time)| (self.gathered(pose), (self.view)(time))).collect())
    }
}

#[cfg(test)]
mod tests;
