//! Measured scenes: meshes that move, and their cameras.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::draw;
use crate::bench::rig::FORMAT;
use crate::blur::{
    Counts, Desc, FrameView, Interval, Knot, Mesh, MeshInput, Motion, Pose, Settings, TopologyInput, Window,
};
use crate::data::Topology;
use crate::error::Result;
use crate::io::scene::weld;
use crate::offline::motion::Positions;
use crate::offline::{self, BlurFrame, BlurScene};
use crate::simulate::mesh::{Builtin, Model};
use crate::view::{Camera, View};

/// Seed of the effects.
pub(super) const SEED: u32 = 0;
/// Full HD.
pub(super) const FULL_HD: [u32; 2] = [1920, 1080];
/// Metres that a ball moves in a frame, and turns by which it turns.
const BALL_SPEED: f64 = 0.05;
const BALL_TURNS: f64 = 0.004;

/// A mesh that moves.
pub(super) struct Scene {
    pub(super) size: [u32; 2],
    pub(super) topology: Topology,
    pub(super) mesh: Arc<Mesh>,
    /// Of the mesh's points, from frame 0 on.
    pub(super) poses: Vec<Positions>,
    pub(super) views: Vec<View>,
    /// The earlier frame of the output.
    pub(super) current: usize,
}

/// Where the points of an output are, and the frames that trajectories go through.
pub(super) struct Prepared {
    pub(super) interval: Interval,
    pub(super) knots: Option<Vec<Knot>>,
}

impl Scene {
    /// One of the program's meshes, of about so many vertices, at the middle of its frames.
    pub(super) fn builtin(which: Builtin, vertices: u32, size: [u32; 2]) -> Result<Scene> {
        let (model, topology) = Model::new(which, vertices);
        let seconds = |frame: u32| f64::from(frame) / which.fps();
        let pose = |frame: u32| {
            let mut pose = vec![[0.0; 3]; topology.object.len()];
            model.positions(seconds(frame), &mut pose);
            pose
        };
        let files: Vec<Vec<[f32; 3]>> = (0..which.frames()).map(pose).collect();
        let welded = weld(&topology.object, &files);
        let input = MeshInput {
            vertices: topology.object.len(),
            triangles: &topology.triangles,
            objects: Some(&topology.object),
            weld: Some(&welded),
            normals: Some(&topology.normal),
            rest: None,
        };
        let mut mesh = Mesh::new(&input)?;
        mesh.set_materials(&topology.material)?;
        let mesh = Arc::new(mesh);
        let poses = files.iter().filter_map(|pose| mesh.gather(pose)).map(Arc::new).collect();
        let views = (0..which.frames()).map(|frame| model.camera(seconds(frame)).view(size)).collect();
        Ok(Scene { size, topology, mesh, poses, views, current: which.frames() as usize / 2 })
    }

    /// The runner's vertices as points of which hardly any is of a triangle: what is done for points alone.
    pub(super) fn points(vertices: u32, size: [u32; 2]) -> Result<Scene> {
        // There are not always exactly as many as are asked for.
        let (model, topology) = Model::new(Builtin::Run, vertices + vertices / 16);
        let frames = Builtin::Run.frames();
        let seconds = |frame: u32| f64::from(frame) / Builtin::Run.fps();
        let pose = |frame: u32| {
            let mut pose = vec![[0.0; 3]; topology.object.len()];
            model.positions(seconds(frame), &mut pose);
            pose.truncate(vertices as usize);
            pose
        };
        let poses: Vec<Vec<[f32; 3]>> = (0..frames).map(pose).collect();
        let views = (0..frames).map(|frame| model.camera(seconds(frame)).view(size)).collect();
        Scene::of_mesh(poses, vec![[0, 1, 2]], views, size, frames as usize / 2)
    }

    /// A ball of so many vertices that flies and turns slowly: one cluster.
    pub(super) fn ball(points: u32, size: [u32; 2]) -> Result<Scene> {
        let mut columns = (f64::from(points).sqrt() as u32).max(1);
        while !points.is_multiple_of(columns) {
            columns -= 1;
        }
        let rows = points / columns;
        let place = |i: u32| {
            let (sin, cos) = (TAU * f64::from(i % columns) / f64::from(columns)).sin_cos();
            let height = 2.0 * (f64::from(i / columns) + 0.5) / f64::from(rows) - 1.0;
            let ring = (1.0 - height * height).sqrt();
            0.8 * DVec3::new(ring * cos, height, ring * sin)
        };
        let cells = (0..rows - 1).flat_map(|row| (0..columns).map(move |column| [row, column]));
        let triangles = cells.flat_map(|[row, column]| {
            let [a, b] = [column, (column + 1) % columns].map(|column| row * columns + column);
            [[a, b, a + columns], [b, b + columns, a + columns]]
        });
        let triangles: Vec<[u32; 3]> = triangles.collect();
        let rest: Vec<DVec3> = (0..points).map(place).collect();
        let pose = |frame: i32| {
            let turn = DQuat::from_rotation_z(TAU * BALL_TURNS * f64::from(frame));
            let centre = DVec3::new(BALL_SPEED * f64::from(frame), 1.0, 0.0);
            rest.iter().map(|p| (centre + turn * *p).as_vec3().to_array()).collect()
        };
        Scene::of_mesh((0..4).map(pose).collect(), triangles, vec![Camera::default().view(size); 4], size, 1)
    }

    fn of_mesh(
        poses: Vec<Vec<[f32; 3]>>,
        triangles: Vec<[u32; 3]>,
        views: Vec<View>,
        size: [u32; 2],
        current: usize,
    ) -> Result<Scene> {
        let vertices = poses.first().map_or(0, Vec::len);
        let input = MeshInput { vertices, triangles: &triangles, objects: None, weld: None, normals: None, rest: None };
        let mesh = Arc::new(Mesh::new(&input)?);
        let topology = Topology { triangles, object: vec![0; vertices], ..Topology::default() };
        let poses = poses.into_iter().map(Arc::new).collect();
        Ok(Scene { size, topology, mesh, poses, views, current })
    }

    /// The host's preparation of an output.
    pub(super) fn prepare(&self, settings: &Settings) -> Result<Prepared> {
        let poses = self.poses.iter().zip(&self.views);
        let poses: Vec<Pose> = poses.map(|(positions, view)| Pose { positions, view, cut: false }).collect();
        let window = Window { frame: self.current as u32, poses: &poses, current: self.current, between: &[] };
        let mut motion = Motion::new(settings, self.size)?;
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let interval = motion.interval(&self.mesh, &window, threads)?;
        Ok(Prepared { interval, knots: motion.knots(&window).map(<[_]>::to_vec) })
    }

    pub(super) fn view(&self, frame: usize) -> FrameView {
        FrameView { frame: frame as u32, view: self.views[frame] }
    }

    /// Frames i - 1 to i + 2.
    pub(super) fn seen(&self) -> [FrameView; 4] {
        [0, 1, 2, 3].map(|place| self.view((self.current + place).saturating_sub(1).min(self.views.len() - 1)))
    }

    /// The output, from all poses. Without images these are empty.
    pub(super) fn take(&self, prepared: &Prepared, images: Option<&[Vec<[f32; 4]>; 2]>) -> Take {
        let empty = || vec![[0.0; 4]; self.size[0] as usize * self.size[1] as usize];
        let Prepared { interval, knots } = prepared;
        let frame = BlurFrame {
            mesh: self.mesh.clone(),
            colours: Arc::new(TopologyInput::colour_rows(&self.mesh, &[])),
            textures: Arc::default(),
            shares: Arc::default(),
            interval: interval.clone(),
            counts: Counts::of(interval, self.mesh.neighbours()),
            views: self.seen(),
            knots: knots.clone(),
            first: 0,
            poses: self.poses.clone(),
        };
        Take { frame, images: images.cloned().unwrap_or_else(|| [empty(), empty()]) }
    }

    /// Description of an effect with such settings.
    pub(super) fn desc(&self, settings: &Settings, most_triangles: u32) -> Desc {
        let desc = Desc::new(&self.mesh, self.size, settings.clone());
        Desc {
            target_format: FORMAT,
            most_triangles: most_triangles.max(desc.triangles),
            frames_resident: self.poses.len() as u32,
            seed: SEED,
            ..desc
        }
    }

    /// The same points without the triangles of an object.
    pub(super) fn without(&self, object: u32) -> Result<Scene> {
        let topology = self.topology.without(object);
        let input = MeshInput {
            vertices: topology.object.len(),
            triangles: &topology.triangles,
            objects: Some(&topology.object),
            weld: Some(self.mesh.file_to_point()),
            normals: Some(&topology.normal),
            rest: None,
        };
        let mut mesh = Mesh::new(&input)?;
        mesh.set_materials(&topology.material)?;
        let mesh = Arc::new(mesh);
        let (poses, views) = (self.poses.clone(), self.views.clone());
        Ok(Scene { size: self.size, topology, mesh, poses, views, current: self.current })
    }

    /// Frames i and i + 1, each under its own light.
    pub(super) fn images(&self, lights: [DVec3; 2]) -> [Vec<[f32; 4]>; 2] {
        [0, 1].map(|later| {
            let frame = self.current + later;
            let pose = &self.poses[frame];
            let vertices: Vec<[f32; 3]> = self.mesh.file_to_point().iter().map(|p| pose[*p as usize]).collect();
            draw::picture(&self.topology, &vertices, &self.views[frame], lights[later], self.size)
        })
    }
}

/// One output of a mesh that moves, which is made again and again.
pub(super) struct Take {
    pub(super) frame: BlurFrame,
    images: [Vec<[f32; 4]>; 2],
}

impl Take {
    /// Of a frame and its images.
    pub(super) fn new(frame: BlurFrame, images: [Vec<[f32; 4]>; 2]) -> Take {
        Take { frame, images }
    }

    /// A frame of it: the motion says all that there is to say.
    pub(super) fn scene(&self) -> offline::Scene<'_> {
        let images = self.images.each_ref().map(|image| Some(&image[..]));
        let blur = BlurScene { frame: &self.frame, images, outer: [None; 2] };
        offline::Scene { blur: Some(blur), rendered: true, ..offline::Scene::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blur::settings::Extent;

    #[test]
    fn a_ball_is_one_cluster() -> Result<()> {
        let scene = Scene::ball(10_000, [512, 512])?;
        let Prepared { interval, knots } = scene.prepare(&Settings { extent: Extent::Part, ..Settings::default() })?;
        assert_eq!((interval.clusters.len(), interval.labels.len()), (1, 10_000));
        assert!(interval.labels.iter().all(|label| *label == 1));
        assert!((20..400).contains(&interval.bounds.len()), "{}", interval.bounds.len());
        assert_eq!(knots.map(|knots| knots.len()), Some(4));
        Ok(())
    }

    #[test]
    fn the_runner_is_in_the_middle_of_its_picture_and_runs() -> Result<()> {
        let scene = Scene::builtin(Builtin::Run, 300, [512, 512])?;
        let Prepared { interval, knots } = scene.prepare(&Settings::default())?;
        assert_eq!(knots.map(|knots| knots.len()), Some(26));
        assert!(interval.clusters.len() >= 6, "{}", interval.clusters.len());
        let [first, second] = scene.images([draw::LIGHT; 2]);
        let covered = |pixels: &[[f32; 4]]| pixels.iter().filter(|p| p[3] > 0.0).count();
        assert!((10_000..80_000).contains(&covered(&first)) && first != second, "{}", covered(&first));
        Ok(())
    }

    #[test]
    fn points_have_one_triangle_and_their_number() -> Result<()> {
        let scene = Scene::points(5000, FULL_HD)?;
        assert_eq!((scene.mesh.points(), scene.mesh.triangles().len(), scene.poses.len()), (5000, 1, 48));
        Ok(())
    }
}
