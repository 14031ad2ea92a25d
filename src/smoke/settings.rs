//! The settings of the smoke effect: one field per key of `[smoke]`, with unit, range and default.

use crate::error::{Error, Result};
use crate::settings::{Dial, DialKind, Setting, settings, words};
use crate::shaders::smoke::constants::GROUP_MASK;
use crate::toon::Tone;
use crate::view::FARTHEST;

mod outline;
mod pixels;

pub use crate::toon::LINES;
pub use outline::{Line, Operator, Outline};
pub use pixels::Pixels;

/// The most depth groups.
pub const MAX_GROUPS: u32 = GROUP_MASK - 1;

words! {
    /// Where particles are placed.
    pub enum Placement {
        /// Uniformly at random in the occupied voxels (the paper's way, section 3.1).
        #[default]
        Random = "random",
    }
}

words! {
    /// How particles are moved along the velocity field.
    pub enum Integrator {
        /// One step along the velocity at the particle (the paper's way, section 3.1).
        #[default]
        Euler = "euler",
        /// The midpoint rule.
        Rk2 = "rk2",
    }
}

words! {
    /// What the radius of a sphere is.
    pub enum Radius {
        /// Half side of the largest box without an empty voxel (the paper's way, section 3.1).
        #[default]
        Box = "box",
        /// Euclidean distance to the nearest empty voxel's centre.
        Ball = "ball",
    }
}

words! {
    /// Where smoke ends, as radii see it.
    pub enum RadiusFrom {
        /// Where the density between voxel centres, which is trilinear, is no longer above the threshold: radii change as
        /// smoothly as the smoke does. Too large by at most 0.02 of a voxel's smallest side.
        #[default]
        Surface = "surface",
        /// At the centres of empty voxels (the paper's way, section 3.1).
        Voxels = "voxels",
    }
}

words! {
    /// How the radius from voxels is searched. All give the same radius.
    pub enum Grow {
        /// The fastest for this number of voxels and particles.
        #[default]
        Chosen = "chosen",
        /// The paper's loop: shells from the particle outwards.
        Growth = "growth",
        /// A chessboard distance field of the volume, then 27 look-ups a particle; cubic voxels and boxes only.
        Field = "field",
        /// A pyramid of "any empty" bits.
        Pyramid = "pyramid",
    }
}

words! {
    /// How spheres shadow each other.
    pub enum Shadow {
        /// The ray to the light against the spheres of its light-space tile, in closed form.
        #[default]
        Exact = "exact",
        /// A shadow map (the paper's way, section 3.2).
        Map = "map",
        /// No shadows.
        None = "none",
    }
}

words! {
    /// How silhouettes are antialiased.
    pub enum Antialias {
        /// Pixels have the share of the smoke that covers them, in closed form.
        #[default]
        Coverage = "coverage",
        /// They have smoke or not, as their middle has (the paper's way).
        None = "none",
    }
}

words! {
    /// Which pixels the Gaussian averages over.
    pub enum Mask {
        /// Those of about the pixel's own depth: each belongs to the two nearest planes of depth, one plane between two
        /// ranges, by shares that change with its depth. No seams.
        #[default]
        Soft = "soft",
        /// Those whose spheres are of the same group (the paper's way, section 3.3).
        Groups = "groups",
    }
}

/// An axis-aligned box in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(deny_unknown_fields))]
pub struct Emitter {
    /// Lower corner.
    pub min: [f32; 3],
    /// Upper corner, not below `min`.
    pub max: [f32; 3],
}

impl Setting for Emitter {
    type Rule = ();
    const KIND: DialKind = DialKind::Group;

    fn check(&self, key: &str, (): &()) -> Result<()> {
        let Emitter { min, max } = self;
        let is_box = (0..3).all(|a| min[a].abs() <= FARTHEST && max[a].abs() <= FARTHEST && min[a] <= max[a]);
        match is_box {
            true => Ok(()),
            false => Err(Error::setting(key.to_owned(), format!("{min:?} to {max:?}"), Self::allowed(&()))),
        }
    }

    fn allowed((): &()) -> String {
        "{ min = [x, y, z], max = [x, y, z] }, in metres, none beyond 1e12, min not above max".to_owned()
    }

    fn shown(&self) -> Option<String> {
        None
    }

    fn dials(&self) -> Vec<Dial> {
        let corner = |key: &str, about: &str, than: &str| Dial {
            key: key.to_owned(),
            about: about.to_owned(),
            allowed: format!("[x, y, z], in metres, none beyond 1e12, {than}"),
            default: None,
            kind: DialKind::Value,
        };
        vec![corner("min", "Lower corner.", "not above max"), corner("max", "Upper corner.", "not below min")]
    }
}

settings! {
    /// Settings of the smoke effect. Fixed until `Effect::change`; what comes with each frame is in `Frame`.
    pub struct Settings {
        /// A voxel holds smoke where density > threshold.
        threshold: f32 = 0.1, "", f32::MIN..=f32::MAX;
        /// How many particles there are; each becomes a sphere. Few: large, plain puffs; many: a skin of small billows.
        particles: u32 = 500, "", 0..=1_000_000;
        /// Where particles are placed: "random", uniform in the voxels that hold smoke.
        placement: Placement = Placement::default();
        /// Births happen in this box only; without one, anywhere.
        emitter: Option<Emitter> = None;
        /// How particles follow the velocity: in one step, "euler", or by the midpoint rule, "rk2".
        integrator: Integrator = Integrator::default();
        /// A particle this slow is reborn; in smallest sides of a voxel.
        still: f32 = 1e-4, "voxels per frame", 0.0..=1e6;
        /// A particle this old is reborn. Those of the first frame begin at ages of their own.
        lifetime: Option<u32> = None, "frames", 1..=1 << 24;
        /// Time over which newborn spheres grow and dying ones shrink.
        fade: u32 = 6, "frames", 0..=64, "they pop, as in the paper";
        /// Width of the Gaussian that smooths the density before the threshold cuts it, so that the drawing does not depend on
        /// the grid: twice its standard deviation, at most 16 voxels along any axis. Without one, the larger of a voxel and
        /// 1/40 of the volume's height, as far as 16 voxels allow.
        detail: Option<f32> = None, "metres", 0.0..=FARTHEST, "off, as in the paper";
        /// What a sphere's radius is: how far it is to empty space in a "box", or as a "ball" (Euclidean, fills more).
        radius: Radius = Radius::default();
        /// Where smoke ends for it: at the "surface" where the density between voxels falls to the threshold, or at the
        /// centres of empty "voxels".
        radius_from: RadiusFrom = RadiusFrom::default();
        /// Share of the last frame's radius that a sphere keeps while it lives; it leaves the smoke by at most 1/4 voxel.
        radius_smoothing: f32 = 0.0, "share of the last frame's radius", 0.0..=0.95, "off";
        /// How restless the drawing is: each sphere's radius differs by up to a quarter from drawing to drawing, as if drawn anew.
        boil: f32 = 0.0, "share of the most", 0.0..=1.0, "as steady as the smoke";
        /// Multiplies the radius. Below 1: balls apart, froth; above: they swell together into one body.
        scale: f32 = 1.0, "", f32::MIN_POSITIVE..=1e6;
        /// Smaller spheres are not drawn, so that there are no specks: down to half of it they shrink to nothing.
        smallest: f32 = 4.0, "pixels of diameter at 1080 lines", 0.0..=64.0, "all are drawn";
        /// Of radii from voxels: how they are searched, with the same result; "chosen" is the fastest.
        grow: Grow = Grow::default();
        /// How spheres shadow each other: by rays, "exact", or by a shadow map.
        shadow: Shadow = Shadow::default();
        /// Of exact shadows: how soft they are.
        softness: f32 = 0.0, "tangent of the light's half angle", 0.0..=1.0, "hard";
        /// Side of the shadow map.
        shadow_map: u32 = 2048, "texels a side", 16..=8192;
        /// The shadow map's filter.
        shadow_filter: u32 = 3, "taps a side", [1, 3, 5];
        /// What is smoothed together: pixels of about the same depth, "soft", or of spheres in the same range, "groups".
        mask: Mask = Mask::default();
        /// How many ranges of depth are smoothed separately. Few: light and shade flow over all of the smoke; many: what is in
        /// front is set off from what is behind.
        groups: u32 = 8, "", 1..=MAX_GROUPS;
        /// Fixed ranges of this depth instead, counted from the camera; without it, the smoke's own depth is divided.
        group_depth: Option<f32> = None, "metres", f32::MIN_POSITIVE..=FARTHEST;
        /// Share of the last frame's depth range that is kept.
        range_smoothing: f32 = 0.9, "share of the last frame's range", 0.0..=0.999;
        /// Of the mask "groups": a sphere keeps its group until it is this far past the border.
        hysteresis: f32 = 0.2, "share of a range", 0.0..=1.0;
        /// How far light and shade flow together: standard deviation of the Gaussian. Small: each ball has its own light;
        /// large: broad, calm shapes over many.
        sigma: f32 = 8.0, "pixels at 1080 lines", 0.1..=64.0, "off";
        /// Where the Gaussian's window ends; 4 is as good as exact.
        cutoff: f32 = 3.0, "multiples of sigma", 1.0..=4.0;
        /// What smoothed luminances become. Two: a woodcut; three: the usual cel; more: soft modelling. A tone that begins
        /// higher is a smaller patch of light.
        tones: Vec<Tone> = vec![
            Tone::new(0.0, [0.30, 0.33, 0.42]),
            Tone::new(0.42, [0.62, 0.65, 0.72]),
            Tone::new(0.68, [0.95, 0.95, 0.93]),
        ];
        /// What they become higher up; without it, they are the same everywhere.
        tones_above: Option<Vec<Tone>> = None;
        /// Heights in the scene between which the colours of the tones change to those of `tones_above`.
        gradient: [f32; 2] = [0.0, 2.0], "metres", -FARTHEST..=FARTHEST;
        /// Half the width of the border between tones; at least half a pixel of the picture, so that it is antialiased.
        tone_softness: f32 = 0.5, "pixels at 1080 lines", 0.0..=16.0, "hard";
        /// How silhouettes are antialiased: by the share of a pixel that smoke covers, "coverage", or not at all.
        antialias: Antialias = Antialias::default();
        /// The ink line.
        outline: Outline = Outline::default();
    }
}

impl Settings {
    /// Whether radii reach to the surface.
    pub fn has_surface(&self) -> bool {
        self.radius_from == RadiusFrom::Surface
    }

    /// Frames after which radii that are smoothed rest: what is left of the farthest way, a thousand million times what
    /// counts as there, is less than that.
    pub(super) fn settling(&self) -> u32 {
        let kept = f64::from(self.radius_smoothing);
        if kept > 0.0 { (1e-9_f64.ln() / kept.ln()).ceil() as u32 } else { 0 }
    }

    /// Whether the density is smoothed.
    pub fn is_detailed(&self) -> bool {
        self.detail != Some(0.0)
    }

    /// Whether luminance is smoothed.
    pub fn is_filtered(&self) -> bool {
        self.sigma > 0.0
    }

    /// Whether spheres shadow each other.
    pub fn casts_shadows(&self) -> bool {
        self.shadow != Shadow::None
    }

    /// Whether shadows are found by rays.
    pub fn is_exact(&self) -> bool {
        self.shadow == Shadow::Exact
    }

    /// Whether shadows are found by a map.
    pub fn has_shadow_map(&self) -> bool {
        self.shadow == Shadow::Map
    }

    /// Number of group ids in use: `groups`, or [`MAX_GROUPS`] where `group_depth` fixes the ranges.
    pub fn group_count(&self) -> u32 {
        if self.group_depth.is_some() { MAX_GROUPS } else { self.groups }
    }

    /// Whether smoke covers pixels in part.
    pub fn is_antialiased(&self) -> bool {
        self.antialias == Antialias::Coverage
    }

    /// Whether the mask is soft.
    pub fn is_soft(&self) -> bool {
        self.mask == Mask::Soft
    }

    /// What rows are summed up for: the first group and their number; or planes, one at either end of each group.
    pub(super) fn summed(&self) -> (u32, u32) {
        if self.is_soft() { (0, self.group_count() + 1) } else { (1, self.group_count()) }
    }

    /// Whether tones have colours of their own in shadow.
    pub fn has_shaded_tones(&self) -> bool {
        self.all_tones().any(|tone| tone.shadow.is_some())
    }

    /// The tones, then those above.
    pub(super) fn all_tones(&self) -> impl Iterator<Item = &Tone> {
        self.tones.iter().chain(self.tones_above.iter().flatten())
    }

    /// The keys of `[smoke]`, in order.
    pub fn dials() -> Vec<Dial> {
        Setting::dials(&Settings::default())
    }

    /// Checks every value; the error names the key and what is allowed.
    pub fn validate(&self) -> Result<()> {
        self.check("smoke", &())?;
        if !self.has_surface() && self.radius == Radius::Ball && self.grow == Grow::Field {
            return Err(Error::setting(
                "smoke.grow",
                "field",
                "\"chosen\", \"growth\" or \"pyramid\" with radius = \"ball\"",
            ));
        }
        if self.gradient[0] > self.gradient[1] {
            return Err(Error::setting(
                "smoke.gradient",
                format!("{:?}", self.gradient),
                "[from, to], from not above to",
            ));
        }
        Ok(())
    }
}
