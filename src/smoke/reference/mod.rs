//! The smoke effect in f64 on the CPU, written from its definition and not from the shaders: what tests and the
//! benchmark compare the GPU with. Clear before fast.

pub mod birth;
pub mod coverage;
pub mod detail;
pub mod gaussian;
pub mod grid;
pub mod groups;
pub mod grow;
pub mod outline;
pub mod particles;
pub mod render;
pub mod shadow;
pub mod surface;
pub mod tone;

pub use grid::Grid;

use glam::DVec3;

use super::settings::{Mask, Settings, Shadow};
use crate::view::{FireLight, Light, View};
use groups::Ranges;
use render::Hit;
use tone::{Canvas, Lit};

/// One rendered frame, every layer row by row from the top.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Which sphere each pixel sees, and where.
    pub hits: Vec<Option<Hit>>,
    /// Share of the light that arrives, 0 to 1; 1 where nothing is seen.
    pub shadow: Vec<f64>,
    /// Luminance, 0 to 1; 0 where nothing is seen.
    pub luminance: Vec<f64>,
    /// Linear view depth in metres; infinite where nothing is seen.
    pub depth: Vec<f64>,
    /// Depth group, of the sphere, or, under the soft mask, of what is seen; 0 where nothing is.
    pub id: Vec<u32>,
    /// Smoothed luminance; 0 where nothing is seen.
    pub smooth: Vec<f64>,
    /// What is smoothed beside luminance.
    pub channels: Channels,
    /// Tone colour before the line, linear RGB; black where nothing is seen.
    pub tone: Vec<[f64; 3]>,
    /// Opacity of inner lines and of silhouettes, 0 to 1.
    pub outline: Vec<[f64; 2]>,
    /// The effect alone, linear RGBA, premultiplied by the share of the pixel that it covers.
    pub image: Vec<[f64; 4]>,
}

/// What is smoothed as luminance is.
#[derive(Clone, Debug)]
pub struct Channels {
    /// Share of the light that arrives.
    pub shade: Vec<f64>,
    /// How far surfaces are turned away from the light and from the eye.
    pub away: Vec<f64>,
    /// The fire's light, if there is one.
    pub fire: Option<Vec<f64>>,
}

/// A fire, and the smoke between it and what it lights.
#[derive(Clone, Copy)]
pub struct Fire<'a> {
    /// The fire.
    pub light: FireLight,
    /// Whether a place in the world is in smoke.
    pub is_smoke: &'a dyn Fn(DVec3) -> bool,
}

/// What lights a frame.
#[derive(Clone, Copy)]
pub struct Lights<'a> {
    /// The lights.
    pub light: &'a Light,
    /// The fire, if there is one.
    pub fire: Option<Fire<'a>>,
}

impl<'a> From<&'a Light> for Lights<'a> {
    fn from(light: &'a Light) -> Lights<'a> {
        Lights { light, fire: None }
    }
}

/// What the mask of a frame is made from.
#[derive(Clone, Copy, Debug)]
pub struct Grouping<'a> {
    /// Depth group of each sphere.
    pub groups: &'a [u32],
    /// The ranges of depth that groups are.
    pub ranges: Ranges,
}

/// Renders one frame of `size` pixels from spheres (centre and displayed radius in metres) and their depth groups.
/// `voxel` is the smallest side of a voxel in metres. A shadow map is an approximation of hard exact shadows.
pub fn frame<'a>(
    settings: &Settings,
    view: &View,
    lights: impl Into<Lights<'a>>,
    size: [u32; 2],
    voxel: f64,
    spheres: &[[f64; 4]],
    grouping: &Grouping,
) -> Frame {
    let Lights { light, fire } = lights.into();
    let drawn = render::drawn(view, size, settings.smallest.into(), spheres);
    let hits = render::raycast(view, size, &drawn);
    let soft = |softness| shadow::shadow(view, size, spheres, &hits, light.source, softness);
    let shadow = match settings.shadow {
        Shadow::Exact => soft(f64::from(settings.softness)),
        Shadow::Map => soft(0.0),
        Shadow::None => vec![1.0; hits.len()],
    };
    let luminance = render::luminance(view, size, &drawn, &hits, light, &shadow);
    let depth = render::depth(&hits);
    let smoothed =
        |values: &[f64]| masked(settings, size, values, &depth, render::id(&hits, grouping.groups), &grouping.ranges);
    let (id, smooth) = smoothed(&luminance);
    let away = smoothed(&render::turned_away(view, size, &drawn, &hits, light)).1;
    let lit = fire.map(|Fire { light, is_smoke }| render::fire(view, size, &drawn, &hits, &light, is_smoke));
    let channels = Channels { shade: smoothed(&shadow).1, away, fire: lit.map(|light| smoothed(&light).1) };
    let canvas = Canvas { size, id: &id, mask: settings.mask, softness: settings.tone_softness.into() };
    let rimmed = tone::rimmed(light, &smooth, &channels.away);
    let lit = Lit {
        luminance: &rimmed,
        shade: Some(&channels.shade[..]),
        fire: fire.and_then(|fire| Some((fire.light.colour, channels.fire.as_deref()?))),
    };
    let above = tone::gradient_share(&render::height(view, size, &hits, light.up), settings.gradient);
    let tone = canvas.painted(settings, &lit, &above);
    let outline = outline::outline(size, &depth, view, voxel, &settings.outline);
    let mut image = tone::composite(&tone, &outline, &id, &settings.outline);
    if settings.is_antialiased() {
        image = coverage::covered(&image, &coverage::coverage(view, size, &drawn, &hits));
    }
    Frame { hits, shadow, luminance, depth, id, smooth, channels, tone, outline, image }
}

/// The group of each pixel and its smoothed luminance, from the groups of the spheres.
pub fn masked(
    settings: &Settings,
    size: [u32; 2],
    luminance: &[f64],
    depth: &[f64],
    id: Vec<u32>,
    ranges: &Ranges,
) -> (Vec<u32>, Vec<f64>) {
    let [width, height] = size.map(|n| n as usize);
    match settings.mask {
        Mask::Groups => {
            let smooth = gaussian::masked_separable(width, height, luminance, &id, settings.sigma, settings.cutoff);
            (id, smooth)
        }
        Mask::Soft => {
            let id = depth.iter().map(|z| if z.is_finite() { ranges.group(*z) } else { 0 }).collect();
            let at = |z: &f64| if z.is_finite() { ranges.coordinate(*z) } else { f64::INFINITY };
            let coordinate: Vec<f64> = depth.iter().map(at).collect();
            let (sigma, cutoff) = (settings.sigma, settings.cutoff);
            (id, gaussian::soft_separable(width, height, luminance, &coordinate, sigma, cutoff))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Camera;

    /// A small plume in motion, over some frames; the last one rendered.
    #[test]
    fn a_whole_frame_is_finite_and_consistent() {
        let density: Vec<f32> = (0..15 * 15 * 20).map(|i| if (i % 15_i32 - 7).abs() < 5 { 1.0 } else { 0.0 }).collect();
        let velocity = vec![[0.1, 1.0, -0.2]; density.len()];
        let grid = Grid {
            dimensions: [15, 15, 20],
            voxel_size: [0.1, 0.1, 0.12],
            origin: [-0.75, 0.25, -1.2],
            density: &density,
            velocity: Some(&velocity),
        };
        let settings = Settings { particles: 100, ..Settings::default() };
        let (camera, light, size) = (Camera::default(), Light::default(), [128, 96]);
        let mut particles = particles::Particles::default();
        let mut depth_groups = groups::Groups::default();
        let mut ids = Vec::new();
        for _ in 0..10 {
            particles.step(&grid, &settings, 0.04, 1);
            ids = depth_groups.step(&settings, &camera.view(size), &particles.spheres(), &particles.origins());
        }
        let (spheres, voxel) = (particles.spheres(), grid.smallest_side());
        let grouping = Grouping { groups: &ids, ranges: depth_groups.ranges(&settings) };
        let frame = frame(&settings, &camera.view(size), &light, size, voxel, &spheres, &grouping);
        let seen = frame.hits.iter().flatten().count();
        assert!(seen > 1000, "{seen} pixels");
        assert!(frame.hits.iter().flatten().any(|hit| hit.sphere >= 100), "no ghost is seen");
        for (pixel, hit) in frame.hits.iter().enumerate() {
            assert_eq!(frame.id[pixel] > 0, hit.is_some());
            let alpha = frame.image[pixel][3];
            assert!(if hit.is_some() { (0.5..=1.0).contains(&alpha) } else { (0.0..=0.5).contains(&alpha) });
            assert_eq!(frame.depth[pixel].is_finite(), hit.is_some());
            assert!(
                (0.0..=1.0).contains(&frame.smooth[pixel])
                    && frame.outline[pixel].iter().all(|ink| (0.0..=1.0).contains(ink))
            );
            assert!(frame.image[pixel].iter().all(|c| (0.0..=1.0).contains(c)));
        }
        let ink = frame.image.iter().filter(|c| c[..3] == [0.0; 3] && c[3] > 0.0).count();
        assert!(ink > 50 && ink < seen, "{ink} pixels of ink");
    }

    #[test]
    fn one_sphere_lit_from_the_eye() {
        let camera = Camera { eye: DVec3::ZERO, target: -DVec3::Z, vertical_fov: 90.0, ..Camera::default() };
        let light = Light {
            source: crate::view::LightSource::Direction(-DVec3::Z),
            ambient: 0.0,
            fill: 0.0,
            ..Light::default()
        };
        let no_line = crate::smoke::settings::Outline { strength: 0.0, ..Default::default() };
        let plain = Settings { sigma: 0.0, tone_softness: 0.0, outline: no_line, ..Settings::default() };
        let settings = Settings { mask: Mask::Groups, ..plain };
        let ranges = Ranges { start: 2.0, width: 1.0, count: 8 };
        let grouping = Grouping { groups: &[5], ranges };
        let view = camera.view([33, 33]);
        let frame = frame(&settings, &view, &light, [33, 33], 0.1, &[[0.0, 0.0, -4.0, 2.0]], &grouping);
        let middle = 16 * 33 + 16;
        assert_eq!((frame.depth[middle], frame.id[middle], frame.shadow[middle]), (2.0, 5, 1.0));
        assert!((frame.luminance[middle] - 1.0).abs() < 1e-15 && frame.smooth == frame.luminance);
        assert_eq!(frame.image[middle], [0.95_f32, 0.95, 0.93, 1.0].map(f64::from));
        let none = super::frame(&settings, &view, &light, [33, 33], 0.1, &[], &grouping);
        assert!(none.image.iter().all(|c| *c == [0.0; 4]));
    }
}
