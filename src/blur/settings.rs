//! The settings of the blur effect: one field per key of `[blur]`, with unit, range and default.

mod curve;

pub use curve::Curve;

use crate::error::{Error, Result};
use crate::settings::{Dial, Setting, settings, words};
use crate::toon::{Operator, Outline, Tone};
use crate::view::BRIGHTEST;

words! {
    /// The curve that a vertex follows between frames.
    pub enum Trajectory {
        /// A natural cubic spline through the frames (the paper's way, section 2.3).
        #[default]
        Spline = "spline",
        /// The spline also goes through sub-frame poses, which the scene must be able to give.
        Exact = "exact",
        /// A spline through the frames up to the later one, where it goes on as a parabola: for renderers that do not know
        /// what comes.
        Past = "past",
    }
}

words! {
    /// The coordinates that are interpolated.
    pub enum Space {
        /// Homogeneous pixel coordinates, divided at evaluation: exact under perspective.
        #[default]
        Homogeneous = "homogeneous",
        /// Pixels (the paper's way, section 2.3).
        Screen = "screen",
    }
}

words! {
    /// How vertices are divided into regions that are smeared as one.
    pub enum Clusters {
        /// By the direction of motion, then into parts that are connected on screen.
        #[default]
        Direction = "direction",
        /// Binary division by a linear discriminant on position and velocity (the paper's way, section 2.4).
        Ldf = "ldf",
    }
}

words! {
    /// What front and rear of a part are.
    pub enum Extent {
        /// Those of each row across the part's motion: what leads in its own row leads.
        #[default]
        Row = "row",
        /// Those of the whole part, in each vertex's own direction (the paper's way, equations 3 to 6).
        Part = "part",
    }
}

words! {
    /// Where triangles are divided.
    pub enum Refine {
        /// Where an edge departs from its true curve by more than `tolerance`.
        #[default]
        Error = "error",
        /// Where an edge is longer than `edge` (the paper's way, section 2.5).
        Length = "length",
    }
}

words! {
    /// What is made of the colours that the two frames have of a place.
    pub enum Mix {
        /// One of them: the later from the middle of the time between on. No colour is one that nobody has drawn.
        #[default]
        Choose = "choose",
        /// Their mixture at the time (the paper's way, equation 12).
        Blend = "blend",
    }
}

words! {
    /// When ink is drawn, of frames without images.
    pub enum Ink {
        /// After the distortion, from what that has made of the mesh: lines are as dark in smears as elsewhere.
        #[default]
        After = "after",
        /// Before it, in the frames: lines are smeared with them (the paper's way).
        Before = "before",
    }
}

words! {
    /// What replaces a colour that one of the two frames hides.
    pub enum Completion {
        /// The colour of the other frame, changed as the light on the surface changes: how that follows from normals is learnt
        /// from the places that both frames show. Where neither shows a place: what is typical of the object at that normal.
        #[default]
        Surface = "surface",
        /// The change of colour of the neighbouring pixels, in HSV (the paper's way, section 2.8).
        Gradient = "gradient",
        /// The colour of the other frame.
        None = "none",
    }
}

words! {
    /// What after-images are.
    pub enum GhostKind {
        /// Pale, the earlier the paler.
        #[default]
        Fade = "fade",
        /// Inked, opaque copies.
        Multiples = "multiples",
    }
}

settings! {
    /// Speed lines along the trajectories of trailing vertices.
    #[derive(Copy)]
    pub struct Lines {
        /// Lines of a part; fewer where it has fewer vertices.
        count: u32 = 0, "", 0..=1024, "off";
        /// How long they are.
        length: f32 = 1.0, "frames", 0.0..=MOST_LENGTH;
        /// How broad they are where they begin; they taper to nothing.
        width: f32 = 3.0, "pixels at 1080 lines", 0.0..=64.0;
        /// Their opacity where they begin.
        opacity: f32 = 1.0, "", 0.0..=1.0;
        /// How much shorter, thinner and closer together some are than others.
        variation: f32 = 0.5, "", 0.0..=1.0, "all are alike";
        /// What they are drawn with.
        colour: [f32; 3] = [0.0; 3], "linear [red, green, blue]", 0.0..=BRIGHTEST;
    }
}

settings! {
    /// After-images: the mesh at earlier times.
    #[derive(Copy)]
    pub struct Ghosts {
        /// How many.
        count: u32 = 0, "", 0..=16, "off";
        /// Time from one to the next; count times step is at most 8.
        step: f32 = 0.25, "frames", 0.01..=1.0;
        /// Whether they "fade", or are "multiples": opaque copies, each with the ink line of drawn frames around it.
        kind: GhostKind = GhostKind::default();
        /// Opacity of the latest that fades; the others' falls to 0 in equal steps.
        opacity: f32 = 0.5, "", 0.0..=1.0;
    }
}

settings! {
    /// How frames are drawn for shots without images.
    pub struct Toon {
        /// What luminances become: each tone multiplies the mesh's own colour.
        tones: Vec<Tone> = vec![
            Tone::new(0.0, [0.38, 0.36, 0.50]),
            Tone::new(0.45, [1.0, 1.0, 1.0]),
        ];
        /// When the ink is drawn: "after" the distortion, or "before" it, so that it is smeared as the rest (the original
        /// way).
        ink: Ink = Ink::default();
        /// The ink line.
        outline: Outline = Outline { operator: Operator::Step, ..Outline::default() };
    }
}

settings! {
    /// Settings of the blur effect. Fixed until `Effect::change`; what comes with each frame is in `Frame`.
    pub struct Settings {
        /// How far smears reach back.
        strength: f32 = 1.0, "frames", 0.0..=MOST_STRENGTH, "off";
        /// How far smears reach ahead of the later frame, along the paths as they leave it.
        lead: f32 = 0.0, "frames", 0.0..=MOST_LEAD, "off";
        /// What share of strength and lead each speed has: [[10, 0], [60, 1]] smears nothing that is slower than 10.
        curve: Curve = Curve::default();
        /// Random numbers across a part, instead of tooth_width, with which they are not given together; the paper has 43.
        teeth: Option<u32> = None, "", 1..=MOST_TEETH;
        /// Width of a tooth; without it and teeth, 12. Small: fine bristles; large: a few broad tongues.
        tooth_width: Option<f32> = None, "pixels at 1080 lines", 0.1..=1e4;
        /// How far from the rear the bristles of a smear end, at most, as a share of the part's extent: its ends are dry.
        dry: f32 = 0.0, "", 0.0..=1.0, "off";
        /// Time for which the teeth stay.
        hold: u32 = 1, "frames", 1..=1_000_000;
        /// The paths of vertices: a "spline" through the frames, "exact", through the scene's own poses between frames,
        /// too (not of .npz files), or "past", through those up to the frame alone, as a game has them.
        trajectory: Trajectory = Trajectory::default();
        /// What is interpolated: "homogeneous" coordinates, exact in perspective, or those on the "screen", the original way.
        space: Space = Space::default();
        /// When position and velocity are taken; 0 is the original way.
        reference_time: f32 = 0.5, "frames after the earlier one", 0.0..=1.0;
        /// A move of the centre of the mesh's box this far in a frame is a cut, and a turn of the camera by 20 degrees, if it is
        /// 4 times as far as those beside it.
        jump: f32 = 1.0, "picture heights", 0.0..=1000.0, "never";
        /// The parts, each of which is smeared as one: by "direction" of motion, or by "ldf", a linear discriminant of place
        /// and velocity (the original way).
        clusters: Clusters = Clusters::default();
        /// Largest angle between a vertex's velocity and its part's.
        angle: f32 = 25.0, "degrees", 0.0..=180.0;
        /// What is drawn back: all that trails in its own "row" across the part's motion, or what is behind the front of the
        /// whole "part" (the original way).
        extent: Extent = Extent::default();
        /// Rounds of smoothing where parts meet: what trails there is drawn back less.
        seam_smoothing: u32 = 8, "rounds", 0..=64, "the original way";
        /// Where triangles are divided: where they are off their path by `tolerance`, "error", or by the "length" of their
        /// edges (the original way).
        refine: Refine = Refine::default();
        /// Largest departure from the path, with refine = "error".
        tolerance: f32 = 1.0, "pixels at 1080 lines", 0.0..=1e4;
        /// Longest edge, with refine = "length".
        edge: f32 = 15.0, "pixels at 1080 lines", 0.0..=1e4;
        /// What stands where one frame hides what the other shows: the other's colour under the light that falls on its
        /// "surface" then, changed by the "gradient" of the neighbours (the original way), or as it is: "none".
        completion: Completion = Completion::default();
        /// What is made of two colours, of the earlier frame and of the later: to "choose" one of them, or to "blend" them
        /// (the original way).
        mix: Mix = Mix::default();
        /// How far smears of images reach over the mesh's outline, for lines on it.
        skirt: f32 = 2.0, "pixels", 0.0..=16.0;
        /// Speed lines behind what trails.
        lines: Lines = Lines::default();
        /// After-images.
        ghosts: Ghosts = Ghosts::default();
        /// How frames are drawn if there are no images.
        toon: Toon = Toon::default();
    }
}

/// The most random numbers across a cluster.
pub const MOST_TEETH: u32 = 4096;
/// The largest strength.
pub const MOST_STRENGTH: f32 = 4.0;
/// The largest lead.
pub const MOST_LEAD: f32 = 1.0;
/// How far lines and after-images reach back at most, in frames.
pub const MOST_LENGTH: f32 = 8.0;

impl Lines {
    /// Whether there are any.
    pub fn are_on(&self) -> bool {
        self.count > 0
    }
}

impl Toon {
    /// Whether smears are drawn as frames are, and not looked up in these.
    pub fn draws_smears(&self) -> bool {
        self.ink == Ink::After
    }

    /// Whether smears have ink of their own.
    pub fn inks_smears(&self) -> bool {
        self.draws_smears() && self.outline.is_on()
    }
}

impl Ghosts {
    /// Whether there are any.
    pub fn are_on(&self) -> bool {
        self.count > 0
    }
}

impl Settings {
    /// The paper's choices: in screen space, at the earlier frame, parts by a linear discriminant, each smeared as a whole, by 43 random
    /// numbers, triangles by length, colours blended and completed by gradients, ink in the frames.
    pub fn paper() -> Settings {
        let outline = Outline { operator: Operator::Second, ..Outline::default() };
        Settings {
            teeth: Some(43),
            space: Space::Screen,
            reference_time: 0.0,
            clusters: Clusters::Ldf,
            angle: 60.0,
            extent: Extent::Part,
            seam_smoothing: 0,
            refine: Refine::Length,
            completion: Completion::Gradient,
            mix: Mix::Blend,
            toon: Toon { ink: Ink::Before, outline, ..Toon::default() },
            ..Settings::default()
        }
    }

    /// Whether anything is smeared.
    pub fn smears(&self) -> bool {
        self.strength > 0.0 || self.lead > 0.0
    }

    /// Whether there are speed lines or after-images.
    pub fn draws_behind(&self) -> bool {
        self.lines.are_on() || self.ghosts.are_on()
    }

    /// `pixels` at 1080 lines, in a picture of `height` lines.
    pub fn scaled(pixels: f32, height: u32) -> f32 {
        pixels * height as f32 / 1080.0
    }

    /// Width of a tooth in pixels at 1080 lines.
    pub fn tooth_width(&self) -> f32 {
        self.tooth_width.unwrap_or(12.0)
    }

    /// How far before frame i the trajectory is looked at, in frames, 0 to 11.
    pub fn reach(&self) -> f32 {
        let lines = if self.lines.are_on() { self.lines.length } else { 0.0 };
        let ghosts = self.ghosts.count as f32 * self.ghosts.step;
        (self.strength - 1.0).max(0.0) + lines.max(ghosts)
    }

    /// Whether triangles that are drawn outside the picture need no refinement. After-images are of the same triangles,
    /// and may be inside.
    pub fn is_clipped(&self) -> bool {
        !self.ghosts.are_on()
    }

    /// The keys of `[blur]`, in order.
    pub fn dials() -> Vec<Dial> {
        Setting::dials(&Settings::default())
    }

    /// Checks every value; the error names the key and what is allowed.
    pub fn validate(&self) -> Result<()> {
        self.check("blur", &())?;
        if let (Some(teeth), Some(_)) = (self.teeth, self.tooth_width) {
            return Err(Error::setting("blur.teeth", teeth, "not together with blur.tooth_width"));
        }
        let Ghosts { count, step, .. } = self.ghosts;
        if count as f32 * step > MOST_LENGTH {
            return Err(Error::setting("blur.ghosts.count", count, "times blur.ghosts.step: 8 frames at most"));
        }
        if let Some(shadow) = self.toon.tones.iter().find_map(|tone| tone.shadow) {
            let allowed = "one colour a tone: drawn frames have no shadows";
            return Err(Error::setting("blur.toon.tones", format!("{shadow:?} in shadow"), allowed));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_allowed_is_refused_by_name() {
        let refused = |change: &dyn Fn(&mut Settings)| {
            let mut settings = Settings::default();
            change(&mut settings);
            settings.validate().unwrap_err().to_string()
        };
        assert!(Settings::default().validate().is_ok());
        assert!(refused(&|s| s.strength = 4.5).starts_with("blur.strength = 4.5: "));
        assert!(refused(&|s| s.strength = f32::NAN).starts_with("blur.strength"));
        assert!(refused(&|s| s.teeth = Some(0)).starts_with("blur.teeth"));
        assert!(refused(&|s| (s.teeth, s.tooth_width) = (Some(3), Some(3.0))).contains("not together"));
        assert!(refused(&|s| s.tooth_width = Some(0.0)).starts_with("blur.tooth_width"));
        assert!(refused(&|s| s.hold = 0).starts_with("blur.hold"));
        assert!(refused(&|s| s.reference_time = -0.1).starts_with("blur.reference_time"));
        assert!(refused(&|s| s.jump = -1.0).starts_with("blur.jump"));
        assert!(refused(&|s| s.angle = 181.0).starts_with("blur.angle"));
        assert!(refused(&|s| s.seam_smoothing = 65).starts_with("blur.seam_smoothing"));
        assert!(refused(&|s| s.tolerance = -1.0).starts_with("blur.tolerance"));
        assert!(refused(&|s| s.edge = f32::INFINITY).starts_with("blur.edge"));
        assert!(refused(&|s| s.skirt = 17.0).starts_with("blur.skirt"));
        assert!(refused(&|s| s.lines.length = 9.0).starts_with("blur.lines.length"));
        assert!(refused(&|s| s.lines.colour[1] = -1.0).starts_with("blur.lines.colour"));
        for bad in [1.1e6, 1e38, f32::INFINITY, f32::NAN] {
            assert!(refused(&|s| s.lines.colour[1] = bad).contains("0 to 1e6"));
            assert!(refused(&|s| s.toon.outline.colour[1] = bad).contains("0 to 1e6"));
            assert!(refused(&|s| s.toon.tones[1].colour[1] = bad).contains("0 to 1e6"));
        }
        assert!(refused(&|s| (s.ghosts.count, s.ghosts.step) = (16, 1.0)).contains("8 frames"));
        assert!(refused(&|s| s.toon.tones.clear()).starts_with("blur.toon.tones"));
        assert!(refused(&|s| s.toon.outline.width = 0.0).starts_with("blur.toon.outline.width"));
    }

    #[test]
    fn the_reach_is_that_of_what_is_on() {
        let mut settings = Settings::default();
        assert_eq!(settings.reach(), 0.0);
        settings.strength = 2.5;
        assert_eq!(settings.reach(), 1.5);
        settings.lines = Lines { count: 3, length: 2.0, ..Lines::default() };
        settings.ghosts = Ghosts { count: 4, step: 0.75, ..Ghosts::default() };
        assert_eq!(settings.reach(), 4.5);
    }

    #[cfg(feature = "cli")]
    #[test]
    fn keys_are_read_as_the_shot_names_them() {
        let text = "strength = 2\ntooth_width = 8.0\ntrajectory = \"exact\"\nspace = \"screen\"\nclusters = \"ldf\"\n\
            refine = \"length\"\ncompletion = \"gradient\"\nlines = { count = 5 }\nghosts = { count = 2, step = 0.5 }\n\
            toon = { tones = [[0.0, [0, 0, 1]]], outline = { width = 2 } }";
        let settings: Settings = toml::from_str(text).unwrap();
        assert_eq!(settings.strength, 2.0);
        assert_eq!((settings.trajectory, settings.space), (Trajectory::Exact, Space::Screen));
        assert_eq!((settings.clusters, settings.refine), (Clusters::Ldf, Refine::Length));
        assert_eq!(settings.completion, Completion::Gradient);
        assert_eq!((settings.lines.count, settings.ghosts.step), (5, 0.5));
        assert_eq!(settings.toon.tones, [Tone::new(0.0, [0.0, 0.0, 1.0])]);
        assert!(toml::from_str::<Settings>("tooths = 3").is_err());
    }
}
