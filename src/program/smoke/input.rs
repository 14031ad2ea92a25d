//! Input of smoke: a volume a frame.

use std::sync::Arc;

use xxhash_rust::xxh3::Xxh3;

use super::shot::Smoke;
use crate::data::Volume;
use crate::interrupt;
use crate::io::ReadError;
use crate::io::shot::Shot;
use crate::io::volume::Extent;
use crate::offline::{Effects, Scene, TARGET_FORMAT};
use crate::program::flame::fire_lights_smoke;
use crate::program::hash::builtin;
use crate::program::input::Fresh;
use crate::program::{Brought, Files, Input, InputError, Opened, add};
use crate::smoke::Desc;
use crate::view::LightSource;

/// A shot's volumes.
struct SmokeInput {
    shot: Arc<Shot>,
    smoke: Smoke,
    volumes: Fresh<Volume>,
    /// The extent that the effect was made for, which every volume must be within.
    extent: Option<Extent>,
}

/// A frame's volume; none where it is that of the frame before.
pub(super) struct SmokeBrought(Option<Arc<Volume>>);

pub(super) fn open(shot: &Arc<Shot>) -> Opened {
    let Some(smoke) = shot.part::<Smoke>() else { return Ok(None) };
    let volumes = smoke.volumes(shot)?;
    let (smoke, shot) = (smoke.clone(), shot.clone());
    Ok(Some(Box::new(SmokeInput { shot, smoke, volumes: Fresh::new(volumes), extent: None })))
}

impl Input for SmokeInput {
    fn add_common(&self, hash: &mut Xxh3, _: &mut Files) -> Result<(), ReadError> {
        let Smoke { volume, grids, settings, .. } = &self.smoke;
        add(hash, ("smoke", self.shot.frames[0], grids, builtin(volume), settings));
        Ok(())
    }

    fn add_frame(&self, hash: &mut Xxh3, files: &mut Files, frame: u32) -> Result<(), ReadError> {
        add(hash, files.digest_of(&self.volumes.sequence, frame)?);
        Ok(())
    }

    fn has_past(&self) -> bool {
        true
    }

    fn describe(&mut self, effects: Effects, rendered: &[u32], layers: bool) -> Result<Effects, InputError> {
        let shot = &self.shot;
        let [start, end] = shot.frames;
        let last = *rendered.last().unwrap_or(&end);
        let extent = self.volumes.sequence.extent(interrupt::until(start..=last))?;
        interrupt::check()?;
        self.extent = Some(extent);
        let lights = || (start..=end).map(|frame| shot.light(frame));
        Ok(effects.with(Desc {
            size: shot.size,
            target_format: TARGET_FORMAT,
            dimensions: extent.dimensions,
            velocity: extent.velocity,
            point_light: matches!(shot.light(start).source, LightSource::Position(_)),
            rim: lights().any(|light| light.rim > 0.0),
            second_light: lights().any(|light| light.second.is_some()),
            fire_light: fire_lights_smoke(shot),
            seed: shot.seed,
            settings: self.smoke.settings.clone(),
            layers,
            depth: None,
            edges: false,
            temporal: Default::default(),
        }))
    }

    fn read(&mut self, frame: u32, _: bool) -> Result<Option<Box<dyn Brought>>, InputError> {
        let extent = self.extent;
        let volume = self.volumes.read(frame, |volume, path| extent.map_or(Ok(()), |e| e.check(volume, path)))?;
        Ok(Some(Box::new(SmokeBrought(volume))))
    }
}

impl Brought for SmokeBrought {
    fn put<'a>(&'a self, scene: &mut Scene<'a>) {
        scene.volume = self.0.as_deref();
    }
}
