//! The settings of the smoke effect: one field per key of `[smoke]`, with unit, range and default.

use crate::error::{Error, Result, within};
use crate::shaders::smoke::constants::GROUP_MASK;
use crate::toon::{Outline, Tone, validate_tones};
use crate::view::FARTHEST;

/// The most depth groups.
pub const MAX_GROUPS: u32 = GROUP_MASK - 1;

/// Where particles are placed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Placement {
    /// Uniformly at random in the occupied voxels (the paper's way, section 3.1).
    #[default]
    Random,
    /// Greedy cover: not built yet, refused by [`Settings::validate`].
    Cover,
}

/// How particles are moved along the velocity field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Integrator {
    /// One step along the velocity at the particle (the paper's way, section 3.1).
    #[default]
    Euler,
    /// The midpoint rule.
    Rk2,
}

/// What the radius of a sphere is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Radius {
    /// Half side of the largest box without an empty voxel (the paper's way, section 3.1).
    #[default]
    Box,
    /// Euclidean distance to the nearest empty voxel's centre.
    Ball,
}

/// How the radius is searched. All give the same radius.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Grow {
    /// The fastest for this number of voxels and particles.
    #[default]
    Chosen,
    /// The paper's loop: shells from the particle outwards.
    Growth,
    /// A chessboard distance field of the volume, then 27 look-ups a particle; cubic voxels and boxes only.
    Field,
    /// A pyramid of "any empty" bits.
    Pyramid,
}

/// How spheres shadow each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Shadow {
    /// The ray to the light against the spheres of its light-space tile, in closed form.
    #[default]
    Exact,
    /// A shadow map (the paper's way, section 3.2).
    Map,
    /// No shadows.
    None,
}

/// An axis-aligned box in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(deny_unknown_fields))]
pub struct Emitter {
    /// Lower corner.
    pub min: [f32; 3],
    /// Upper corner, not below `min`.
    pub max: [f32; 3],
}

/// Settings of the smoke effect. Everything here is fixed at creation; what changes per frame is in `Frame`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Settings {
    /// A voxel is occupied where density > threshold. Any finite number; default 0.1.
    pub threshold: f32,
    /// Number of particles, 0 to 1,000,000; default 500.
    pub particles: u32,
    /// Where particles are placed.
    pub placement: Placement,
    /// Births happen only in this box; default: anywhere.
    pub emitter: Option<Emitter>,
    /// How particles move.
    pub integrator: Integrator,
    /// A particle this slow dies; voxels (smallest side) per frame, 0 to 1e6; default 1e-4.
    pub still: f32,
    /// A particle this old dies; frames, >= 1; default none. Those of the first frame begin at ages of their own.
    pub lifetime: Option<u32>,
    /// Frames over which newborn spheres grow and dying ones shrink, 0 to 64; default 6 (0: the paper's popping).
    pub fade: u32,
    /// What the radius is.
    pub radius: Radius,
    /// Multiplies the radius, > 0; default 1.
    pub scale: f32,
    /// How the radius is searched.
    pub grow: Grow,
    /// How spheres shadow each other.
    pub shadow: Shadow,
    /// Tangent of the light's half angle for exact shadows, 0 to 1; default 0 (hard).
    pub softness: f32,
    /// Side of the shadow map in texels, 16 to 8192; default 2048.
    pub shadow_map: u32,
    /// Taps per axis of the shadow map's filter: 1, 3 or 5; default 3.
    pub shadow_filter: u32,
    /// Number of depth groups, 1 to [`MAX_GROUPS`]; default 8.
    pub groups: u32,
    /// Depth of a group in metres, > 0, at most 1e12, counted from the camera; default: equal ranges of the smoke's own depth.
    pub group_depth: Option<f32>,
    /// Share of the last frame's depth range that is kept, 0 to 1 (exclusive); default 0.9.
    pub range_smoothing: f32,
    /// A particle keeps its group until it is this share of a range past the border, 0 to 1; default 0.2.
    pub hysteresis: f32,
    /// Standard deviation of the Gaussian in pixels, 0 (off) or 0.1 to 64; default 4.
    pub sigma: f32,
    /// The window ends at `cutoff` sigma, 1 to 4; default 3.
    pub cutoff: f32,
    /// The tones, ascending, at least one.
    pub tones: Vec<Tone>,
    /// Width of the antialiased border between tones in pixels, 0 (hard) to 16; default 0.5.
    pub tone_softness: f32,
    /// The ink line.
    pub outline: Outline,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            threshold: 0.1,
            particles: 500,
            placement: Placement::default(),
            emitter: None,
            integrator: Integrator::default(),
            still: 1e-4,
            lifetime: None,
            fade: 6,
            radius: Radius::default(),
            scale: 1.0,
            grow: Grow::default(),
            shadow: Shadow::default(),
            softness: 0.0,
            shadow_map: 2048,
            shadow_filter: 3,
            groups: 8,
            group_depth: None,
            range_smoothing: 0.9,
            hysteresis: 0.2,
            sigma: 4.0,
            cutoff: 3.0,
            tones: vec![
                Tone { from: 0.0, colour: [0.30, 0.33, 0.42] },
                Tone { from: 0.42, colour: [0.62, 0.65, 0.72] },
                Tone { from: 0.68, colour: [0.95, 0.95, 0.93] },
            ],
            tone_softness: 0.5,
            outline: Outline::default(),
        }
    }
}

impl Settings {
    /// Window of the Gaussian to each side in pixels: `ceil(cutoff * sigma)`; 0 if it is off.
    pub fn window(&self) -> u32 {
        (self.cutoff * self.sigma).ceil() as u32
    }

    /// Number of group ids in use: `groups`, or [`MAX_GROUPS`] where `group_depth` fixes the ranges.
    pub fn group_count(&self) -> u32 {
        if self.group_depth.is_some() { MAX_GROUPS } else { self.groups }
    }

    /// Checks every value; the error names the key and what is allowed.
    pub fn validate(&self) -> Result<()> {
        let (number, whole) = (within::<f32>, within::<u32>);
        number("smoke.threshold", self.threshold, f32::MIN, f32::MAX, "a finite density")?;
        whole("smoke.particles", self.particles, 0, 1_000_000, "0 to 1000000")?;
        if self.placement == Placement::Cover {
            return Err(Error::setting("smoke.placement", "cover", "\"random\" (\"cover\" is not built yet)"));
        }
        if let Some(Emitter { min, max }) = self.emitter
            && !(0..3).all(|a| min[a].abs() <= FARTHEST && max[a].abs() <= FARTHEST && min[a] <= max[a])
        {
            return Err(Error::setting(
                "smoke.emitter",
                format!("{min:?} to {max:?}"),
                "min not above max, in metres, none beyond 1e12",
            ));
        }
        number("smoke.still", self.still, 0.0, 1e6, "voxels per frame, 0 to 1e6")?;
        if let Some(lifetime) = self.lifetime {
            whole("smoke.lifetime", lifetime, 1, 1 << 24, "frames, 1 to 16777216")?;
        }
        whole("smoke.fade", self.fade, 0, 64, "frames, 0 to 64")?;
        number("smoke.scale", self.scale, f32::MIN_POSITIVE, 1e6, "above 0, at most 1e6")?;
        if self.radius == Radius::Ball && self.grow == Grow::Field {
            return Err(Error::setting(
                "smoke.grow",
                "field",
                "\"chosen\", \"growth\" or \"pyramid\" with radius = \"ball\"",
            ));
        }
        number("smoke.softness", self.softness, 0.0, 1.0, "tangent of the light's half angle, 0 to 1")?;
        whole("smoke.shadow_map", self.shadow_map, 16, 8192, "texels a side, 16 to 8192")?;
        if ![1, 3, 5].contains(&self.shadow_filter) {
            return Err(Error::setting("smoke.shadow_filter", self.shadow_filter, "1, 3 or 5 taps a side"));
        }
        whole("smoke.groups", self.groups, 1, MAX_GROUPS, "1 to 254")?;
        if let Some(depth) = self.group_depth {
            number("smoke.group_depth", depth, f32::MIN_POSITIVE, FARTHEST, "metres, above 0, at most 1e12")?;
        }
        number("smoke.range_smoothing", self.range_smoothing, 0.0, 0.999, "0 to 0.999")?;
        number("smoke.hysteresis", self.hysteresis, 0.0, 1.0, "share of a range, 0 to 1")?;
        if self.sigma != 0.0 {
            number("smoke.sigma", self.sigma, 0.1, 64.0, "pixels, 0 (off) or 0.1 to 64")?;
        }
        number("smoke.cutoff", self.cutoff, 1.0, 4.0, "multiples of sigma, 1 to 4")?;
        validate_tones("smoke.tones", &self.tones)?;
        number("smoke.tone_softness", self.tone_softness, 0.0, 16.0, "pixels, 0 to 16")?;
        self.outline.validate(["smoke.outline.strength", "smoke.outline.width", "smoke.outline.colour"])
    }
}
