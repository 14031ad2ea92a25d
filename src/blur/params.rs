//! Parameters of the kernels of `glsl/blur`. The structures and constants are the shaders' own (build.rs).

use bytemuck::Zeroable;
use glam::{DMat3, DVec3};

use crate::blur::desc::Desc;
use crate::blur::frame::{self, Frame, IntervalInput};
use crate::blur::layout::{COMPLETING_WORDS, Layout};
use crate::blur::settings::{Settings, Toon};
use crate::host::Background;
use crate::shaders::blur as glsl;
pub use crate::shaders::blur::blocks::*;
pub use crate::shaders::blur::constants::*;
use crate::view::{Camera, Light, LightSource};

impl BackgroundConstants {
    /// Of what is under a frame that is drawn.
    pub fn new(background: Background) -> BackgroundConstants {
        match background {
            Background::Clear(background) => BackgroundConstants { background, has_image: 0 },
            Background::Copy(_) => BackgroundConstants { background: [0.0; 4], has_image: 1 },
            Background::Keep => BackgroundConstants { background: [0.0; 4], has_image: 0 },
        }
    }
}

impl Control {
    /// The state at the start of a frame.
    pub fn reset() -> Control {
        Control { draw: [0, 1, 0, 0], ..Control::zeroed() }
    }
}

/// The state of a frame's rounds at its start: the first has the mesh's triangles, the others none.
pub fn rounds(desc: &Desc) -> [Round; ROUNDS as usize + 1] {
    let none = Round { groups: [0, 1, 1, 0], ..Round::zeroed() };
    let mut rounds = [none; ROUNDS as usize + 1];
    rounds[0] = Round {
        groups: [desc.triangles.div_ceil(BLOCK), 1, 1, 0],
        triangles: desc.triangles,
        vertices_before: desc.points,
        ..none
    };
    rounds
}

/// The state of completion at its start: dispatches of no groups, that become some where samples need them.
pub fn completing(desc: &Desc) -> [u32; COMPLETING_WORDS] {
    let mut words = [0; COMPLETING_WORDS];
    let rows = (2 * desc.size[1]).div_ceil(glsl::border::SHADER.local_size[1]);
    for gradient in [0, 1] {
        words[border_dispatch(gradient)..][..3].copy_from_slice(&[0, rows, 1]);
        words[inward_dispatch(gradient)..][..3].copy_from_slice(&[0, 1, 1]);
    }
    words
}

/// The word of what completion works on where the dispatch over samples at borders begins: of those that neither frame shows
/// (0), and of those that one does (1).
pub fn border_dispatch(gradient: usize) -> usize {
    BORDER_DISPATCHES as usize + 4 * gradient
}

/// That of the dispatches that go inward from there.
pub fn inward_dispatch(gradient: usize) -> usize {
    INWARD_DISPATCHES as usize + 4 * gradient
}

/// Rows that make the pixel clip coordinates X, Y and W of a point less the eye.
pub fn clip_rows(camera: &Camera, size: [u32; 2]) -> [DVec3; 3] {
    let rotation: DMat3 = camera.rotation();
    let (right, up, forward) = (rotation.row(0), rotation.row(1), rotation.row(2));
    let [width, height] = size.map(f64::from);
    let focal = height / 2.0 / camera.half_extent(size).y;
    [right * focal + forward * (width / 2.0), forward * (height / 2.0) - up * focal, forward]
}

fn row(v: DVec3, w: f64) -> [f32; 4] {
    v.extend(w).as_vec4().to_array()
}

/// The rounding error of [`row`].
fn low(v: DVec3, w: f64) -> [f32; 4] {
    row(v - v.as_vec3().as_dvec3(), w - f64::from(w as f32))
}

fn split(v: DVec3) -> [[f32; 4]; 2] {
    [row(v, 0.0), low(v, 0.0)]
}

impl View {
    fn new(view: &frame::View, desc: &Desc) -> View {
        let [across, down, along] = clip_rows(&view.camera, desc.size).map(split);
        let [eye, eye_low] = split(view.camera.eye);
        View {
            across: across[0],
            down: down[0],
            along: along[0],
            across_low: across[1],
            down_low: down[1],
            along_low: along[1],
            eye,
            eye_low,
        }
    }
}

/// Where a frame's pose is among those on the device.
fn pose_place(view: &frame::View, desc: &Desc) -> u32 {
    view.frame % desc.frames_resident
}

impl Knot {
    /// `current`: the camera of frame i.
    pub fn new(knot: &frame::Knot, current: &Camera, desc: &Desc) -> Knot {
        let rows = clip_rows(&knot.view.camera, desc.size);
        let current_rows = clip_rows(current, desc.size);
        let way = knot.view.camera.eye - current.eye;
        let part = |i: usize| {
            let moved = -rows[i].dot(way);
            let own = [row(rows[i], moved), low(rows[i], moved)];
            let turn = rows[i] - current_rows[i];
            (own, [row(turn, 0.0), low(turn, 0.0)])
        };
        let ([across, across_low], [across_turn, across_turn_low]) = part(0);
        let ([down, down_low], [down_turn, down_turn_low]) = part(1);
        let ([along, along_low], [along_turn, along_turn_low]) = part(2);
        let has_other_camera = knot.view.camera != *current;
        Knot {
            across,
            down,
            along,
            across_low,
            down_low,
            along_low,
            across_turn,
            down_turn,
            along_turn,
            across_turn_low,
            down_turn_low,
            along_turn_low,
            weights: knot.weights,
            pose_place: pose_place(&knot.view, desc),
            has_other_camera: has_other_camera.into(),
            unused: [0; 2],
        }
    }
}

impl BlurParams {
    /// Parameters of an output, as the kernels read them.
    ///
    /// `outer`: whether frames i - 1 and i + 2 have images.
    pub fn new(desc: &Desc, layout: &Layout, interval: &IntervalInput, frame: &Frame, outer: [bool; 2]) -> BlurParams {
        let settings = &desc.settings;
        let scaled = |pixels| Settings::scaled(pixels, desc.size[1]);
        let knots = match interval.trajectories {
            frame::Trajectories::Poses(knots) => knots.len() as u32,
            frame::Trajectories::Pieces(_) => 0,
        };
        let ahead = interval.segments.iter().take_while(|segment| segment.begin >= 0.0).count().max(1);
        let mut segments = [SegmentTimes::zeroed(); MOST_SEGMENTS as usize];
        for (to, segment) in segments.iter_mut().zip(interval.segments) {
            *to = SegmentTimes { begin: segment.begin, end: segment.end, unused: [0; 2] };
        }
        BlurParams {
            segments,
            segment_count: interval.segments.len() as u32,
            segments_ahead: ahead as u32,
            knots,
            generation: interval.counts.generation,
            seam_points: interval.counts.seams,
            // Each of two sums of two products is off by less than 2^-23 of this, and what a hull has beside its outline is
            // up to 5 * 2^-24 of it away.
            hull_margin: interval.counts.farthest * 1e-6,
            vertex_room: layout.vertices,
            triangle_budget: layout.triangles,
            list_room: layout.listed,
            tables: layout.tables,
            strength: settings.strength,
            reference_time: settings.reference_time,
            tolerance: scaled(settings.tolerance),
            edge: scaled(settings.edge),
            skirt: settings.skirt,
            outer_images: u32::from(outer[0]) + 2 * u32::from(outer[1]),
            is_drawn: frame.images.is_none().into(),
            is_clipped: settings.is_clipped().into(),
            is_whole: (desc.layers || desc.depth.is_some()).into(),
            ..BlurParams::of_views(desc, &interval.views, frame.background)
        }
    }

    /// Parameters of a frame that stands still, as the kernels read them.
    pub fn of_views(desc: &Desc, views: &[frame::View; 4], background: Background) -> BlurParams {
        let mut params = BlurParams {
            views: views.map(|view| View::new(&view, desc)),
            pose_places: views.map(|view| pose_place(&view, desc)),
            size: desc.size,
            tiles: desc.size.map(|side| side.div_ceil(TILE)),
            seed: desc.seed,
            points: desc.points,
            triangles: desc.triangles,
            near: views[1].camera.near as f32,
            ..BlurParams::zeroed()
        };
        match background {
            Background::Clear(colour) => params.background = colour,
            Background::Copy(_) => params.has_background_image = 1,
            Background::Keep => {}
        }
        params
    }
}

/// Width of the ink in samples, of which a pixel has two a side.
fn ink_width(toon: &Toon) -> f32 {
    2.0 * toon.outline.width
}

/// Samples from which a line can reach a sample.
pub fn ink_reach(toon: &Toon) -> u32 {
    crate::toon::ink_reach(ink_width(toon))
}

impl ToonParams {
    /// Parameters of the kernels that draw a frame.
    pub fn new(desc: &Desc, camera: &Camera, light: &Light) -> ToonParams {
        let toon = &desc.settings.toon;
        let [r, g, b] = toon.outline.colour;
        let span = camera.half_extent(desc.size).y / f64::from(desc.size[1]);
        let mut params = ToonParams {
            light: match light.source {
                LightSource::Direction(way) => row(-way.normalize(), 0.0),
                LightSource::Position(place) => row(place, 1.0),
            },
            ink_colour: [r, g, b, 0.0],
            ink_strength: toon.outline.strength,
            ink_width: ink_width(toon),
            sample_extent: span as f32,
            ambient: light.ambient as f32,
            tone_count: toon.tones.len() as u32,
            groups: desc.groups,
            ..ToonParams::zeroed()
        };
        for (to, tone) in params.tones.iter_mut().zip(&toon.tones) {
            let [r, g, b] = tone.colour;
            *to = [r, g, b, tone.from];
        }
        params
    }
}
