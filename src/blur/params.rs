//! Parameters of the kernels of `glsl/blur`. The structures and constants are the shaders' own (build.rs).

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

use crate::blur::desc::Desc;
use crate::blur::frame::{self, Frame, FrameView, IntervalInput};
use crate::blur::layout::{COMPLETING_WORDS, Layout};
use crate::blur::motion::clip_rows;
use crate::blur::settings::{GhostKind, Settings, Toon};
use crate::host::{Background, HostImage};
use crate::shaders::blur as glsl;
pub use crate::shaders::blur::blocks::*;
pub use crate::shaders::blur::constants::*;
use crate::view::{self, Light, Projection};

/// How many teeth long a smear is that ends in all of its bristles, if it is dry.
const DRY_TEETH: f32 = 2.0;

impl BackgroundConstants {
    /// Of what is under a frame that is drawn.
    pub fn new(background: Background, target: &HostImage) -> BackgroundConstants {
        let (background, has_image) = match background {
            Background::Clear(colour) => (colour, 0),
            Background::Copy(_) => ([0.0; 4], 1),
            Background::Keep => ([0.0; 4], 0),
        };
        BackgroundConstants { background, has_image, corner: target.offset, ..Zeroable::zeroed() }
    }
}

impl GhostConstants {
    /// Of after-image number `ghost`, from 1, in a picture of so many lines.
    pub fn new(settings: &Settings, ghost: u32, height: u32) -> GhostConstants {
        let Settings { ghosts, toon, .. } = settings;
        let share = (ghosts.count + 1 - ghost) as f32 / ghosts.count as f32;
        let [r, g, b] = toon.outline.colour;
        let (opacity, strength) = match ghosts.kind {
            GhostKind::Fade => (ghosts.opacity * share, 0.0),
            GhostKind::Multiples => (1.0, toon.outline.strength),
        };
        GhostConstants {
            ink: [r, g, b, strength],
            back: ghost as f32 * ghosts.step,
            opacity,
            radius: ink_width(toon, height),
        }
    }
}

impl Vertex {
    /// Whether it is a point of the mesh, and not made by refinement.
    pub fn is_point(&self) -> bool {
        self.barycentrics == [OF_POINT; 2]
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
    fn new(projection: &Projection, size: [u32; 2]) -> View {
        let (rows, constant) = clip_rows(projection);
        let part = |row_of: DVec3, w: f64| [row(row_of, w), low(row_of, w)];
        let [across, across_low] = part(rows[0], constant.x);
        let [down, down_low] = part(rows[1], constant.y);
        let [along, along_low] = split(rows[2]);
        let focal = projection.focal.x * if projection.is_orthographic { depth_unit(projection, size) } else { 1.0 };
        let [eye, eye_low] = part(projection.eye, focal);
        View { across, down, along, across_low, down_low, along_low, eye, eye_low }
    }
}

/// Where a frame's pose is among those on the device.
fn pose_place(view: &FrameView, desc: &Desc) -> u32 {
    view.frame % desc.frames_resident
}

impl Knot {
    /// `views`: of the interval.
    pub fn new(knot: &frame::Knot, [_, current, next, _]: &[FrameView; 4], desc: &Desc) -> Knot {
        // Trajectories are all of the one picture.
        let jitter = next.view.jitter;
        let [own, current] =
            [&knot.view, current].map(|of| Projection::of_valid(&view::View { jitter, ..of.view }, desc.size));
        let ((rows, constant), (current_rows, current_constant)) = (clip_rows(&own), clip_rows(&current));
        let way = own.eye - current.eye;
        let added = (constant - current_constant).extend(0.0);
        let part = |i: usize| {
            let moved = added[i] - rows[i].dot(way);
            let own = [row(rows[i], moved), low(rows[i], moved)];
            let turn = rows[i] - current_rows[i];
            (own, [row(turn, 0.0), low(turn, 0.0)])
        };
        let ([across, across_low], [across_turn, across_turn_low]) = part(0);
        let ([down, down_low], [down_turn, down_turn_low]) = part(1);
        let ([along, along_low], [along_turn, along_turn_low]) = part(2);
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
            has_other_view: (own != current).into(),
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
            curve: curve_rows(settings, desc.size[1]),
            curve_keys: settings.curve.keys.len() as u32,
            strength: settings.strength,
            lead: settings.lead,
            dry_back: scaled(DRY_TEETH * settings.tooth_width()),
            reach: settings.reach(),
            reference_time: settings.reference_time,
            tolerance: scaled(settings.tolerance),
            edge: scaled(settings.edge),
            skirt: settings.skirt,
            outer_images: u32::from(outer[0]) + 2 * u32::from(outer[1]),
            is_drawn: frame.images.is_none().into(),
            is_over_background: (frame.images.is_none() || matches!(frame.background, Background::Copy(_))).into(),
            is_clipped: settings.is_clipped().into(),
            has_directions: desc.parts.is_some().into(),
            is_whole: (desc.layers || desc.depth.is_some()).into(),
            ..BlurParams::of_views(desc, &interval.views, frame)
        }
    }

    /// Parameters of a frame that stands still, as the kernels read them.
    pub fn of_views(desc: &Desc, views: &[FrameView; 4], frame: &Frame) -> BlurParams {
        let seen = views.map(|view| Projection::of_valid(&view.view, desc.size));
        let [_, previous, next, _] = &seen;
        let [from, to] = [views[1], views[2]].map(|of| DVec2::from_array(of.view.jitter));
        let mut params = BlurParams {
            views: seen.map(|projection| View::new(&projection, desc.size)),
            pose_places: views.map(|view| pose_place(&view, desc)),
            size: desc.size,
            corner: frame.target.offset,
            tiles: desc.size.map(|side| side.div_ceil(TILE)),
            seed: desc.seed,
            points: desc.points,
            triangles: desc.triangles,
            near: previous.near as f32,
            far: previous.far as f32,
            is_orthographic: previous.is_orthographic.into(),
            depth_terms: next.terms(),
            depth_unit: depth_unit(previous, desc.size) as f32,
            winding: if previous.is_mirrored() { -1.0 } else { 1.0 },
            jitter_change: (to - from).as_vec2().to_array(),
            ..BlurParams::zeroed()
        };
        match frame.background {
            Background::Clear(colour) => params.background = colour,
            Background::Copy(_) => params.has_background_image = 1,
            Background::Keep => {}
        }
        params
    }
}

/// Keys of strength over speed, two a row, with speeds in pixels of a picture of so many lines.
fn curve_rows(settings: &Settings, height: u32) -> [[f32; 4]; CURVE_ROWS as usize] {
    let mut rows = [[0.0; 4]; CURVE_ROWS as usize];
    let keys = settings.curve.keys.iter().map(|[speed, share]| [Settings::scaled(*speed, height), *share]);
    rows.as_flattened_mut().chunks_exact_mut(2).zip(keys).for_each(|(to, key)| to.copy_from_slice(&key));
    rows
}

/// The depth whose shares count as those of any depth of an orthographic view: from there, 40 degrees have all of the picture.
fn depth_unit(projection: &Projection, size: [u32; 2]) -> f64 {
    0.5 * f64::from(size[1]) / projection.focal.y / 20.0_f64.to_radians().tan()
}

/// Width of the ink in samples, of which a pixel has two a side, in a picture of so many lines.
fn ink_width(toon: &Toon, height: u32) -> f32 {
    (2.0 * Settings::scaled(toon.outline.width, height)).max(1.0)
}

/// Samples from which a line can reach a sample.
pub fn ink_reach(toon: &Toon, height: u32) -> u32 {
    crate::toon::ink_reach(ink_width(toon, height))
}

impl ToonParams {
    /// Parameters of the kernels that draw a frame.
    pub fn new(desc: &Desc, view: &FrameView, light: &Light) -> ToonParams {
        let toon = &desc.settings.toon;
        let [r, g, b] = toon.outline.colour;
        let projection = Projection::of_valid(&view.view, desc.size);
        let span = 0.5 / projection.focal.y;
        let (second_light, second_strength) = light.second_terms();
        let mut params = ToonParams {
            light: light.source.homogeneous(),
            second_light,
            second_strength,
            rim: light.rim as f32,
            eye: projection.eye_terms(),
            ink_colour: [r, g, b, 0.0],
            ink_strength: toon.outline.strength,
            ink_width: ink_width(toon, desc.size[1]),
            sample_extent: span as f32,
            ambient: light.ambient as f32,
            fill: light.fill_axis(),
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
