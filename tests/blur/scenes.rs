//! Meshes that move, and the splines through their poses in f64.

use celfx::blur::motion::PixelClip;
use celfx::blur::motion::{Segment, outline};
use celfx::blur::reference::distort::{Drawing, Outside, Triangle, Vertex, draw, hidden};
use celfx::blur::reference::scene;
use celfx::blur::{Cluster, FrameView, Interval, Knot, Mesh, MeshInput, Pose};
use celfx::low_level::blur::params::BASE_MASK;
use celfx::view::{Camera, Projection, View};
use glam::{DVec2, DVec3};

use crate::common::blur::BlurRig;
use crate::common::scenes::random;

/// A grid of this many points.
pub fn grid([columns, rows]: [u32; 2]) -> Mesh {
    let mut triangles = Vec::new();
    for y in 0..rows - 1 {
        for x in 0..columns - 1 {
            let at = y * columns + x;
            triangles.extend([[at, at + 1, at + columns], [at + 1, at + columns + 1, at + columns]]);
        }
    }
    mesh((columns * rows) as usize, &triangles)
}

pub fn mesh(vertices: usize, triangles: &[[u32; 3]]) -> Mesh {
    Mesh::new(&MeshInput { vertices, triangles, objects: None, weld: None, normals: None, rest: None }).expect("a mesh")
}

/// What is made of a frame's view.
pub type Change = fn(View, usize) -> View;

/// Frames of a mesh and of what sees it.
pub struct Animation {
    pub poses: Vec<Vec<[f32; 3]>>,
    pub cameras: Vec<Camera>,
    /// What is made of a frame's view.
    pub change: Change,
    pub size: [u32; 2],
}

impl Animation {
    /// Seen through cameras.
    pub fn new(poses: Vec<Vec<[f32; 3]>>, cameras: Vec<Camera>, size: [u32; 2]) -> Animation {
        Animation { poses, cameras, change: |view, _| view, size }
    }

    /// What a frame is seen through.
    pub fn seen(&self, frame: usize) -> View {
        (self.change)(self.cameras[frame].view(self.size), frame)
    }

    /// What all of them are seen through.
    pub fn all_seen(&self) -> Vec<View> {
        (0..self.poses.len()).map(|frame| self.seen(frame)).collect()
    }

    /// The poses as the motion takes them.
    pub fn poses<'a>(&'a self, seen: &'a [View]) -> Vec<Pose<'a>> {
        self.poses.iter().zip(seen).map(|(positions, view)| Pose { positions, view, cut: false }).collect()
    }

    pub fn view(&self, frame: usize) -> FrameView {
        let frame = frame.min(self.poses.len() - 1);
        FrameView { frame: frame as u32, view: self.seen(frame) }
    }

    /// Frames i - 1 to i + 2.
    pub fn views(&self, i: usize) -> [FrameView; 4] {
        [i.saturating_sub(1), i, i + 1, i + 2].map(|frame| self.view(frame))
    }

    /// The same seen through a window in the picture's middle: pixels are as large and as many of them lie between points,
    /// but few have to be rendered.
    pub fn through_window(mut self, size: [u32; 2]) -> Animation {
        let share = f64::from(size[1]) / f64::from(self.size[1]);
        for camera in &mut self.cameras {
            camera.vertical_fov = 2.0 * (share * (camera.vertical_fov.to_radians() / 2.0).tan()).atan().to_degrees();
        }
        self.size = size;
        self
    }

    /// Whether rays are parallel: nothing is divided by depth.
    pub fn is_parallel(&self) -> bool {
        Projection::of_valid(&self.seen(0), self.size).is_orthographic
    }

    /// Whether triangles are seen the other way round.
    pub fn is_mirrored(&self) -> bool {
        Projection::of_valid(&self.seen(0), self.size).is_mirrored()
    }

    /// Pixels and view depth of a point.
    pub fn pixel(&self, frame: usize, point: usize) -> DVec3 {
        let view = self.seen(frame);
        let projection = PixelClip::new(&view, view.jitter, self.size);
        let clip = projection.clip(self.poses[frame][point]);
        projection.pixel_of(clip).extend(clip.z)
    }

    /// Pixel clip coordinates.
    pub fn clip(&self, frame: usize, point: usize) -> DVec3 {
        let view = self.seen(frame);
        PixelClip::new(&view, view.jitter, self.size).clip(self.poses[frame][point])
    }

    /// What the splines of a point interpolate, in each frame.
    pub fn channels(&self, point: usize, screen: bool) -> Vec<DVec3> {
        let clips = (0..self.poses.len()).map(|frame| self.clip(frame, point));
        clips.map(|c| if screen { (c.truncate() / c.z).extend(c.z) } else { c }).collect()
    }

    /// Knots for the device: all frames, with the weights of segments from frame i and of as many before it.
    pub fn knots(&self, i: usize, segments: usize) -> Vec<Knot> {
        let count = self.poses.len();
        let unit = |k: usize| (0..count).map(|j| DVec3::splat(f64::from(u8::from(j == k)))).collect::<Vec<_>>();
        (0..count)
            .map(|k| {
                let (values, bends) = (unit(k), natural(&unit(k)));
                let mut weights = [[0.0; 4]; 12];
                for (s, row) in weights.iter_mut().enumerate().take(segments) {
                    let (a, b) = (i - s, i - s + 1);
                    let origin = if s == 0 { 0.0 } else { values[a].x };
                    *row = [origin, values[b].x - values[a].x, bends[a].x, bends[b].x].map(|w| w as f32);
                }
                Knot { view: self.view(k), weights }
            })
            .collect()
    }
}

/// Second derivatives of the natural spline through values at whole times.
pub fn natural(values: &[DVec3]) -> Vec<DVec3> {
    let n = values.len();
    let mut bends = vec![DVec3::ZERO; n];
    if n < 3 {
        return bends;
    }
    let mut pivots = vec![4.0; n - 2];
    let mut right: Vec<DVec3> = values.windows(3).map(|v| 6.0 * (v[0] - 2.0 * v[1] + v[2])).collect();
    for j in 1..n - 2 {
        let share = 1.0 / pivots[j - 1];
        pivots[j] -= share;
        right[j] = right[j] - right[j - 1] * share;
    }
    for j in (0..n - 2).rev() {
        bends[j + 1] = (right[j] - bends[j + 2]) / pivots[j];
    }
    bends
}

/// The spline at a time after frame i: straight before the first frame.
pub fn spline(values: &[DVec3], bends: &[DVec3], i: usize, time: f64) -> (DVec3, DVec3) {
    let at = i as f64 + time;
    let a = (at.floor().max(0.0) as usize).min(values.len() - 2);
    let u = at - a as f64;
    let (c, way) = (1.0 - u, values[a + 1] - values[a]);
    let slope = |u: f64| {
        let c = 1.0 - u;
        way + bends[a] * ((1.0 - 3.0 * c * c) / 6.0) + bends[a + 1] * ((3.0 * u * u - 1.0) / 6.0)
    };
    if u < 0.0 {
        return (values[a] + slope(0.0) * u, slope(0.0));
    }
    (values[a] + way * u + bends[a] * ((c * c * c - c) / 6.0) + bends[a + 1] * ((u * u * u - u) / 6.0), slope(u))
}

/// An interval whose points with a label above 0 are clusters; everything in f64
/// and rounded once. The seams are all points of a cluster.
pub fn interval(animation: &Animation, i: usize, labels: &[u32], time: f64, teeth: u32, segments: usize) -> Interval {
    let points = animation.poses[0].len();
    let mut motion = Vec::new();
    for point in 0..points {
        let values = animation.channels(point, false);
        let (at, slope) = spline(&values, &natural(&values), i, time);
        let pixel = at.truncate() / at.z;
        let velocity: DVec2 = (slope.truncate() - pixel * slope.z) / at.z;
        motion.push([pixel.x, pixel.y, velocity.x, velocity.y].map(|c| c as f32));
    }
    let (mut clusters, mut bounds) = (Vec::new(), Vec::new());
    for label in 1..=labels.iter().max().copied().unwrap_or(0) {
        let begin = bounds.len() as u32;
        let members = (0..points).filter(|p| labels[*p] == label).map(|p| [motion[p][0], motion[p][1]]);
        let members: Vec<[f32; 2]> = members.collect();
        bounds.extend(outline(&members));
        let (bounds_end, points) = (bounds.len() as u32, members.len() as u32);
        clusters.push(Cluster {
            object: 7 + label,
            bounds_begin: begin,
            bounds_end,
            teeth,
            points,
            ..bytemuck::Zeroable::zeroed()
        });
    }
    let mut spans = vec![Segment { begin: 0.0, end: 1.0 }];
    spans.extend((1..segments).map(|s| Segment { begin: -(s as f32), end: 1.0 - s as f32 }));
    Interval {
        generation: 3,
        motion,
        labels: labels.to_vec(),
        clusters,
        bounds,
        seams: (0..points as u32).filter(|p| labels[*p as usize] > 0).collect(),
        // Nothing is closed. A point has fewer than eight triangles of its own.
        fronts: vec![0; points],
        segments: spans,
        pieces: Vec::new(),
    }
}

/// A grid that swings and bends, seen by a camera that goes with it: `reach` metres from side to side.
pub fn swing(sides: [u32; 2], frames: u32, size: [u32; 2], reach: f32) -> Animation {
    let [columns, rows] = sides;
    let pose = |frame: u32| {
        let t = frame as f32 * 0.3;
        (0..columns * rows)
            .map(|p| {
                let (u, v) = ((p % columns) as f32 / (columns - 1) as f32, (p / columns) as f32 / (rows - 1) as f32);
                let (u, v) = (u - 0.5 + 0.01 * random(1, p, 0), v - 0.5 + 0.01 * random(1, p, 1));
                [u + reach * (t + v).sin(), 1.0 - v + 0.3 * reach * (1.3 * t + u).cos(), 0.4 * (t + 2.0 * u).sin()]
            })
            .collect()
    };
    let camera = |frame: u32| {
        let t = f64::from(frame) * 0.2;
        Camera {
            eye: DVec3::new(0.3 * t.sin(), 1.0 + 0.1 * t.cos(), 4.0 - 0.2 * t.sin()),
            target: DVec3::new(0.1 * t.cos(), 1.0, 0.0),
            ..Camera::default()
        }
    };
    Animation::new((0..frames).map(pose).collect(), (0..frames).map(camera).collect(), size)
}

/// What samples see of the mesh that a device has refined between two frames.
pub fn drawn(rig: &mut BlurRig, mesh: &Mesh, animation: &Animation, frames: [usize; 2]) -> Drawing {
    let (vertices, finished) = (rig.vertices(), rig.finished());
    let triangle = |row: &[u32; 4]| {
        let base = row[3] & BASE_MASK;
        let corner = |i: usize| {
            let vertex = vertices[row[i] as usize];
            let [x, y, w, time] =
                [vertex.drawn[0], vertex.drawn[1], vertex.drawn_depth, vertex.drawn_time].map(f64::from);
            let weights = match vertex.is_point() {
                true => mesh.triangles()[base as usize].map(|point| f64::from(u8::from(point == row[i]))),
                false => {
                    let [v, w] = vertex.barycentrics.map(f64::from);
                    [1.0 - v - w, v, w]
                }
            };
            Vertex { drawn: [x * w, y * w, w], time, weights }
        };
        Triangle { corners: [0, 1, 2].map(corner), base }
    };
    let triangles: Vec<Triangle> = finished.iter().map(triangle).collect();
    let seen = |outside: Outside| match (outside, animation.is_mirrored()) {
        (Outside::Clockwise, true) => Outside::CounterClockwise,
        (Outside::CounterClockwise, true) => Outside::Clockwise,
        (outside, _) => outside,
    };
    let outsides = frames.map(|frame| {
        let outsides = scene::outsides(mesh, &animation.poses[frame], &animation.seen(frame), animation.size);
        outsides.into_iter().map(seen).collect::<Vec<_>>()
    });
    let corners =
        frames.map(|frame| scene::corners(mesh, &animation.poses[frame], &animation.seen(frame), animation.size));
    let hidden =
        hidden(corners.each_ref().map(|corners| &corners[..]), outsides.each_ref().map(|outsides| &outsides[..]));
    draw(&triangles, &hidden, animation.size, animation.cameras[frames[0]].near, 2)
}
