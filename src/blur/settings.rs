//! The settings of the blur effect: one field per key of `[blur]`, with unit, range and default.

use crate::error::{Error, Result, within};
use crate::toon::{Operator, Outline, Tone, validate_tones};
use crate::view::BRIGHTEST;

/// The curve that a vertex follows between frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Trajectory {
    /// A natural cubic spline through the frames (the paper's way, section 2.3).
    #[default]
    Spline,
    /// The spline also goes through sub-frame poses, which the scene must be able to give.
    Exact,
}

/// The coordinates that are interpolated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Space {
    /// Homogeneous pixel coordinates, divided at evaluation: exact under perspective.
    #[default]
    Homogeneous,
    /// Pixels (the paper's way, section 2.3).
    Screen,
}

/// How vertices are divided into regions that are smeared as one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Clusters {
    /// By the direction of motion, then into parts that are connected on screen.
    #[default]
    Direction,
    /// Binary division by a linear discriminant on position and velocity (the paper's way, section 2.4).
    Ldf,
}

/// Where triangles are divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Refine {
    /// Where an edge departs from its true curve by more than `tolerance`.
    #[default]
    Error,
    /// Where an edge is longer than `edge` (the paper's way, section 2.5).
    Length,
}

/// What replaces a colour that one of the two frames hides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Completion {
    /// The colour of the other frame, changed as the light on the surface changes: how that follows from normals is learnt
    /// from the places that both frames show. Where neither shows a place: what is typical of the object at that normal.
    #[default]
    Surface,
    /// The change of colour of the neighbouring pixels, in HSV (the paper's way, section 2.8).
    Gradient,
    /// The colour of the other frame.
    None,
}

/// Speed lines along the trajectories of trailing vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Lines {
    /// Lines of a cluster, 0 (off, the default) to 1024; fewer where it has fewer vertices.
    pub count: u32,
    /// Length in frames, 0 to 8; default 1.
    pub length: f32,
    /// Width where a line begins in pixels at 1080 lines, 0 to 64; default 3. It tapers to nothing.
    pub width: f32,
    /// Opacity where a line begins, 0 to 1; default 1.
    pub opacity: f32,
    /// Linear RGB, 0 to 1e6; default black.
    pub colour: [f32; 3],
}

impl Default for Lines {
    fn default() -> Self {
        Lines { count: 0, length: 1.0, width: 3.0, opacity: 1.0, colour: [0.0; 3] }
    }
}

/// After-images: the mesh at earlier times.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Ghosts {
    /// After-images, 0 (off, the default) to 16.
    pub count: u32,
    /// Frames from one to the next, 0.01 to 1; default 0.25. `count` times `step` is at most 8.
    pub step: f32,
    /// Opacity of the latest, 0 to 1; default 0.5. The others' falls to 0 in equal steps.
    pub opacity: f32,
}

impl Default for Ghosts {
    fn default() -> Self {
        Ghosts { count: 0, step: 0.25, opacity: 0.5 }
    }
}

/// How frames are drawn for shots without images.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Toon {
    /// The tones, ascending, at least one: luminance where each begins, and what it multiplies the mesh's base colour by.
    /// Default: a cool shadow up to 0.45, and from there the base colour.
    pub tones: Vec<Tone>,
    /// The ink line; by default from second differences, because meshes have slopes.
    pub outline: Outline,
}

impl Default for Toon {
    fn default() -> Self {
        Toon {
            tones: vec![Tone { from: 0.0, colour: [0.38, 0.36, 0.50] }, Tone { from: 0.45, colour: [1.0, 1.0, 1.0] }],
            outline: Outline { operator: Operator::Second, ..Outline::default() },
        }
    }
}

/// Settings of the blur effect. Everything here is fixed at creation; what changes per frame is in `Frame`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Settings {
    /// How far the smear reaches back, s, in frames, 0 (off) to 4; default 1.
    pub strength: f32,
    /// Random numbers N across a cluster, 1 to 4096, instead of `tooth_width` (the paper: 43).
    pub teeth: Option<u32>,
    /// Width of a tooth in pixels at 1080 lines, 0.1 to 10000; default 12.
    pub tooth_width: Option<f32>,
    /// Frames for which the teeth stay, 1 to 1000000; default 1.
    pub hold: u32,
    /// The curve that a vertex follows between frames.
    pub trajectory: Trajectory,
    /// The coordinates that are interpolated.
    pub space: Space,
    /// Time after frame i at which position and velocity are taken, in frames, 0 (the paper's way) to 1; default 0.5.
    pub reference_time: f32,
    /// Trajectories are cut where the centre of the mesh's box moves farther in one frame than this many picture heights,
    /// and more than 4 times as far as in the frames before and after. 0 (never) to 1000; default 1.
    pub jump: f32,
    /// How vertices are divided into clusters.
    pub clusters: Clusters,
    /// The largest angle between a vertex's velocity and its cluster's, in degrees, 0 to 180; default 60.
    pub angle: f32,
    /// Rounds of smoothing of k' where clusters meet, 0 (the paper's way) to 64; default 8.
    pub seam_smoothing: u32,
    /// Where triangles are divided.
    pub refine: Refine,
    /// The largest departure from the true curve with `refine = "error"`, in pixels at 1080 lines, 0 to 10000; default 1.
    pub tolerance: f32,
    /// The longest edge with `refine = "length"`, in pixels at 1080 lines, 0 to 10000; default 15.
    pub edge: f32,
    /// What replaces hidden colours.
    pub completion: Completion,
    /// How far the drawing of images reaches over the mesh's outline, in pixels, 0 to 16; default 2. Frames that are drawn
    /// here have their lines on the mesh.
    pub skirt: f32,
    /// Speed lines.
    pub lines: Lines,
    /// After-images.
    pub ghosts: Ghosts,
    /// How frames are drawn for shots without images.
    pub toon: Toon,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            strength: 1.0,
            teeth: None,
            tooth_width: None,
            hold: 1,
            trajectory: Trajectory::default(),
            space: Space::default(),
            reference_time: 0.5,
            jump: 1.0,
            clusters: Clusters::default(),
            angle: 60.0,
            seam_smoothing: 8,
            refine: Refine::default(),
            tolerance: 1.0,
            edge: 15.0,
            completion: Completion::default(),
            skirt: 2.0,
            lines: Lines::default(),
            ghosts: Ghosts::default(),
            toon: Toon::default(),
        }
    }
}

/// The most random numbers across a cluster.
pub const MOST_TEETH: u32 = 4096;
/// The largest strength.
pub const MOST_STRENGTH: f32 = 4.0;
/// How far lines and after-images reach back at most, in frames.
pub const MOST_LENGTH: f32 = 8.0;

impl Settings {
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
        let lines = if self.lines.count > 0 { self.lines.length } else { 0.0 };
        let ghosts = self.ghosts.count as f32 * self.ghosts.step;
        (self.strength - 1.0).max(0.0) + lines.max(ghosts)
    }

    /// Whether triangles that are drawn outside the picture need no refinement. After-images are of the same triangles,
    /// and may be inside.
    pub fn is_clipped(&self) -> bool {
        self.ghosts.count == 0
    }

    /// Checks every value; the error names the key and what is allowed.
    pub fn validate(&self) -> Result<()> {
        let (number, whole) = (within::<f32>, within::<u32>);
        number("blur.strength", self.strength, 0.0, MOST_STRENGTH, "frames, 0 (off) to 4")?;
        if let Some(teeth) = self.teeth {
            whole("blur.teeth", teeth, 1, MOST_TEETH, "1 to 4096")?;
            if self.tooth_width.is_some() {
                return Err(Error::setting("blur.teeth", teeth, "not together with blur.tooth_width"));
            }
        }
        if let Some(width) = self.tooth_width {
            number("blur.tooth_width", width, 0.1, 1e4, "pixels at 1080 lines, 0.1 to 10000")?;
        }
        whole("blur.hold", self.hold, 1, 1_000_000, "frames, 1 to 1000000")?;
        number("blur.reference_time", self.reference_time, 0.0, 1.0, "frames after the earlier one, 0 to 1")?;
        number("blur.jump", self.jump, 0.0, 1000.0, "picture heights, 0 (never) to 1000")?;
        number("blur.angle", self.angle, 0.0, 180.0, "degrees, 0 to 180")?;
        whole("blur.seam_smoothing", self.seam_smoothing, 0, 64, "rounds, 0 (off) to 64")?;
        number("blur.tolerance", self.tolerance, 0.0, 1e4, "pixels at 1080 lines, 0 to 10000")?;
        number("blur.edge", self.edge, 0.0, 1e4, "pixels at 1080 lines, 0 to 10000")?;
        number("blur.skirt", self.skirt, 0.0, 16.0, "pixels, 0 to 16")?;
        self.validate_lines()?;
        self.validate_ghosts()?;
        validate_tones("blur.toon.tones", &self.toon.tones)?;
        let names = ["blur.toon.outline.strength", "blur.toon.outline.width", "blur.toon.outline.colour"];
        self.toon.outline.validate(names)
    }

    fn validate_lines(&self) -> Result<()> {
        let Lines { count, length, width, opacity, colour } = self.lines;
        within("blur.lines.count", count, 0, 1024, "0 (off) to 1024")?;
        within("blur.lines.length", length, 0.0, MOST_LENGTH, "frames, 0 to 8")?;
        within("blur.lines.width", width, 0.0, 64.0, "pixels at 1080 lines, 0 to 64")?;
        within("blur.lines.opacity", opacity, 0.0, 1.0, "0 to 1")?;
        colour.iter().try_for_each(|c| within("blur.lines.colour", *c, 0.0, BRIGHTEST, "linear RGB, 0 to 1e6"))
    }

    fn validate_ghosts(&self) -> Result<()> {
        let Ghosts { count, step, opacity } = self.ghosts;
        within("blur.ghosts.count", count, 0, 16, "0 (off) to 16")?;
        within("blur.ghosts.step", step, 0.01, 1.0, "frames, 0.01 to 1")?;
        within("blur.ghosts.opacity", opacity, 0.0, 1.0, "0 to 1")?;
        match count as f32 * step <= MOST_LENGTH {
            true => Ok(()),
            false => Err(Error::setting("blur.ghosts.count", count, "times blur.ghosts.step: 8 frames at most")),
        }
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
        assert_eq!(settings.toon.tones, [Tone { from: 0.0, colour: [0.0, 0.0, 1.0] }]);
        assert!(toml::from_str::<Settings>("tooths = 3").is_err());
    }
}
