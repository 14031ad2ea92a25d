//! Measured scenes: volumes, cameras, and the spheres that a frame leaves on the device.

use glam::DVec3;

use crate::bench::rig::{EffectId, FORMAT, Rig};
use crate::data::Volume;
use crate::error::Result;
use crate::offline::Scene;
use crate::simulate::smoke::Builtin;
use crate::smoke::layout::{CONTROL, GROUPS, SPHERES};
use crate::smoke::params::Control;
use crate::smoke::reference::groups::Ranges;
use crate::smoke::reference::render;
use crate::smoke::{Desc, Settings};
use crate::view::Camera;

/// Frames a second.
pub(super) const FPS: f64 = 24.0;
/// The frame of the built-in volumes that is measured: the plume has risen by then.
const FRAME: u32 = 40;
/// Voxels of the paper's volume, the 20 of them along its height.
pub(super) const PAPER_VOXELS: [u32; 3] = [15, 20, 15];
/// Size of the paper's picture.
pub(super) const PAPER: [u32; 2] = [512, 512];
/// Full HD.
pub(super) const FULL_HD: [u32; 2] = [1920, 1080];

/// The plume with so many voxels.
pub(super) fn plume(dimensions: [u32; 3]) -> Volume {
    Builtin::Plume.sampled(FRAME, FPS, dimensions)
}

/// The plume without its motion.
pub(super) fn still_plume(dimensions: [u32; 3]) -> Volume {
    Volume { velocity: None, ..plume(dimensions) }
}

/// An effect for a volume.
pub(super) fn desc(size: [u32; 2], volume: &Volume, settings: Settings, layers: bool) -> Desc {
    Desc {
        size,
        target_format: FORMAT,
        dimensions: volume.dimensions,
        velocity: volume.velocity.is_some(),
        point_light: false,
        rim: false,
        second_light: false,
        fire_light: false,
        seed: 0,
        settings,
        layers,
        depth: None,
        edges: false,
        temporal: Default::default(),
    }
}

/// A rendered first frame of a volume.
pub(super) fn first_scene(camera: Camera, volume: &Volume) -> Scene<'_> {
    Scene { dt: 1.0 / FPS as f32, camera, volume: Some(volume), rendered: true, ..Scene::default() }
}

/// A camera in front of the plume, so far away that it fills the height of the picture.
pub(super) fn camera() -> Camera {
    seen_from(3.6)
}

fn seen_from(distance: f64) -> Camera {
    let target = DVec3::new(0.0, 1.1, 0.0);
    Camera { eye: target + DVec3::new(0.0, 0.0, distance), target, ..Camera::default() }
}

/// A camera so near that the spheres cover about this share of the picture. In a wide picture the plume lies on its side.
pub(super) fn camera_covering(spheres: &[[f64; 4]], size: [u32; 2], share: f64) -> Camera {
    let small = [size[0] / 8, size[1] / 8];
    let up = if size[0] > size[1] { DVec3::X } else { DVec3::Y };
    let seen_from = |distance: f64| Camera { up, ..seen_from(distance) };
    let covered = |distance: f64| {
        let hits = render::raycast(&seen_from(distance).view(small), small, spheres);
        hits.iter().flatten().count() as f64 / hits.len().max(1) as f64
    };
    // More is covered from nearer, until the camera is among the spheres.
    let (mut near, mut far) = (1.2, 12.0);
    for _ in 0..12 {
        let middle = 0.5 * (near + far);
        (near, far) = if covered(middle) > share { (middle, far) } else { (near, middle) };
    }
    seen_from(0.5 * (near + far))
}

/// The ranges of depth of the frame recorded last.
pub(super) fn ranges(rig: &mut Rig, effect: EffectId, settings: &Settings) -> Result<Ranges> {
    let control: Vec<Control> = rig.read(effect, CONTROL, 1)?;
    let Control { group_start, groups_per_metre, .. } = control[0];
    Ok(Ranges::of_device(group_start, groups_per_metre, settings.group_count()))
}

/// Centre and displayed radius of each sphere of the frame recorded last, and its group.
pub(super) fn spheres(rig: &mut Rig, effect: EffectId, particles: u32, fade: u32) -> Result<(Vec<[f64; 4]>, Vec<u32>)> {
    let count = particles as usize * (1 + fade as usize);
    let spheres: Vec<[f32; 4]> = rig.read(effect, SPHERES, count)?;
    let groups = rig.read(effect, GROUPS, count)?;
    Ok((spheres.iter().map(|sphere| sphere.map(f64::from)).collect(), groups))
}
