//! Input of smoke: a volume a frame.

use std::path::Path;
use std::sync::Arc;

use xxhash_rust::xxh3::Xxh3;

use super::shot::Smoke;
use crate::data::Volume;
use crate::interrupt;
use crate::io::ReadError;
use crate::io::shot::{Exposure, Shot};
use crate::io::volume::Extent;
use crate::offline::{Effects, Scene, TARGET_FORMAT};
use crate::program::flame::fire_lights_smoke;
use crate::program::hash::builtin;
use crate::program::input::Fresh;
use crate::program::{Brought, Files, Input, InputError, Opened, add};
use crate::smoke::{Desc, Sequence, Settings};
use crate::view::LightSource;

/// A shot's volumes.
struct SmokeInput {
    shot: Arc<Shot>,
    smoke: Smoke,
    volumes: Fresh<Volume>,
    /// The extent that the effect was made for, which every volume must be within.
    extent: Option<Extent>,
}

/// What a frame brings.
pub(super) struct SmokeBrought {
    /// None where it is that of the frame before.
    volume: Option<Arc<Volume>>,
    /// Whether the frame has the drawing of the one before.
    is_held: bool,
    /// Frames until the next drawing.
    on: u32,
}

pub(super) fn open(shot: &Arc<Shot>) -> Opened {
    let Some(smoke) = shot.part::<Smoke>() else { return Ok(None) };
    let volumes = smoke.volumes(shot)?;
    let (smoke, shot) = (smoke.clone(), shot.clone());
    Ok(Some(Box::new(SmokeInput { shot, smoke, volumes: Fresh::new(volumes), extent: None })))
}

/// The settings where a step is from a drawing to the next: what counts frames counts drawings.
fn drawn(settings: &Settings, exposure: Exposure) -> Settings {
    Settings {
        lifetime: settings.lifetime.map(|frames| exposure.drawings(frames)),
        fade: exposure.drawings(settings.fade),
        still: settings.still * exposure.on() as f32,
        range_smoothing: settings.range_smoothing.powi(exposure.on() as i32),
        radius_smoothing: settings.radius_smoothing.powi(exposure.on() as i32),
        ..settings.clone()
    }
}

impl Input for SmokeInput {
    fn add_common(&self, hash: &mut Xxh3, _: &mut Files) -> Result<(), ReadError> {
        let Smoke { volume, grids, volume_fps, exposure, settings, .. } = &self.smoke;
        add(hash, ("smoke", self.shot.frames[0], grids, volume_fps, builtin(volume), exposure, settings));
        Ok(())
    }

    fn add_frame(&self, hash: &mut Xxh3, files: &mut Files, frame: u32) -> Result<(), ReadError> {
        add(hash, files.digest_of(&self.volumes.sequence, self.smoke.exposure.drawing(frame))?);
        Ok(())
    }

    fn has_past(&self) -> bool {
        true
    }

    fn describe(&mut self, effects: Effects, rendered: &[u32], layers: bool) -> Result<Effects, InputError> {
        let shot = &self.shot;
        let [start, end] = shot.frames;
        let last = *rendered.last().unwrap_or(&end);
        let exposure = self.smoke.exposure;
        let drawings = (start..=last).filter(|frame| !exposure.is_held(*frame));
        let others = (last + 1..=end).filter(|frame| !exposure.is_held(*frame));
        let extent = self.volumes.sequence.extent(interrupt::until(drawings), interrupt::until(others))?;
        interrupt::check()?;
        self.extent = Some(extent);
        let lights = || (start..=end).map(|frame| shot.light(frame));
        Ok(effects.with(Desc {
            size: shot.size,
            lines: None,
            target_format: TARGET_FORMAT,
            dimensions: extent.dimensions,
            velocity: extent.velocity,
            point_light: matches!(shot.light(start).source, LightSource::Position(_)),
            rim: lights().any(|light| light.rim > 0.0),
            second_light: lights().any(|light| light.second.is_some()),
            fire_light: fire_lights_smoke(shot),
            seed: shot.seed,
            settings: drawn(&self.smoke.settings, exposure),
            layers,
            depth: None,
            edges: false,
            temporal: Default::default(),
        }))
    }

    fn read(&mut self, frame: u32, _: bool) -> Result<Option<Box<dyn Brought>>, InputError> {
        let extent = self.extent;
        let exposure = self.smoke.exposure;
        let check = |volume: &Volume, path: &Path| extent.map_or(Ok(()), |extent| extent.check(volume, path));
        let volume = self.volumes.read(exposure.drawing(frame), check)?;
        Ok(Some(Box::new(SmokeBrought { volume, is_held: exposure.is_held(frame), on: exposure.on() })))
    }
}

impl Brought for SmokeBrought {
    fn put<'a>(&'a self, scene: &mut Scene<'a>) {
        scene.volume = self.volume.as_deref();
        scene.dt *= self.on as f32;
        if self.is_held {
            scene.sequence = Sequence::Hold;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_counts_frames_counts_drawings() {
        let settings =
            Settings { lifetime: Some(15), fade: 6, still: 0.5, range_smoothing: 0.5, ..Settings::default() };
        assert_eq!(drawn(&settings, Exposure::new(1, 1)), settings);
        let twos = drawn(&settings, Exposure::new(1, 2));
        assert_eq!((twos.lifetime, twos.fade, twos.still, twos.range_smoothing), (Some(8), 3, 1.0, 0.25));
    }
}
