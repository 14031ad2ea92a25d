//! Input of fire: particles, and what follows from all of the shot's.

use std::sync::Arc;

use xxhash_rust::xxh3::Xxh3;

use super::fire_lights_smoke;
use super::shot::Flame;
use super::spread::Spreads;
use crate::data::{ParticleExtent, Particles};
use crate::flame::Desc;
use crate::flame::settings::Colour;
use crate::flame::{Settings, fire_light};
use crate::interrupt;
use crate::io::ReadError;
use crate::io::shot::Shot;
use crate::offline::{Effects, Scene, TARGET_FORMAT};
use crate::program::hash::builtin;
use crate::program::input::Fresh;
use crate::program::{Brought, Files, Input, InputError, Opened, add};
use crate::view::FireLight;

/// A shot's particles.
struct FlameInput {
    shot: Arc<Shot>,
    flame: Flame,
    particles: Fresh<Particles>,
    /// Where the table of physical colours ends: at the hottest particle of the whole shot, so that a frame alone looks as it does
    /// in the sequence. None where colours are others.
    hottest: Option<f32>,
    /// Finds the spread of each frame; none where the shot says it.
    spreads: Option<Spreads>,
    /// The first frame that is rendered, and its spread.
    first: Option<(u32, f32)>,
    /// The extent that the effect was made for, which all particles must be within.
    extent: Option<ParticleExtent>,
}

/// A frame's particles.
pub(super) struct FlameBrought {
    /// None where they are those of the frame before.
    pub(super) particles: Option<Arc<Particles>>,
    /// How many they are.
    pub(super) count: usize,
    /// The frame whose drawing it has.
    drawing: u32,
    /// Their spread, where the shot has none.
    spread: Option<f32>,
    /// Their light on the shot's smoke.
    fire: Option<FireLight>,
}

/// Looks at all of the shot's particles where that is what its fire follows from.
pub(super) fn open(shot: &Arc<Shot>) -> Opened {
    let Some(flame) = shot.part::<Flame>() else { return Ok(None) };
    let particles = flame.particles(shot)?;
    let (flame, [first, last]) = (flame.clone(), shot.frames);
    let hottest = match flame.settings.colour {
        Colour::Physical => Some(particles.extent(interrupt::until(first..=last))?.hottest),
        _ => None,
    };
    interrupt::check()?;
    let spreads = flame.settings.spread.is_none().then(|| Spreads::new(particles.clone(), shot.frames));
    let particles = Fresh::new(particles);
    let (shot, first, extent) = (shot.clone(), None, None);
    Ok(Some(Box::new(FlameInput { shot, flame, particles, hottest, spreads, first, extent })))
}

impl Input for FlameInput {
    fn add_common(&self, hash: &mut Xxh3, _: &mut Files) -> Result<(), ReadError> {
        let Flame { particles, exposure, settings, .. } = &self.flame;
        add(hash, ("flame", builtin(particles), self.hottest, exposure, settings));
        Ok(())
    }

    fn add_frame(&self, hash: &mut Xxh3, files: &mut Files, frame: u32) -> Result<(), ReadError> {
        let drawing = self.flame.exposure.drawing(frame);
        add(hash, files.digest_of(&self.particles.sequence, drawing)?);
        for (frame, weight) in self.spreads.iter().flat_map(|spreads| spreads.window(drawing)) {
            add(hash, (frame, weight, files.digest_of(&self.particles.sequence, frame)?));
        }
        Ok(())
    }

    fn describe(&mut self, effects: Effects, rendered: &[u32], layers: bool) -> Result<Effects, InputError> {
        let drawings = rendered.iter().map(|frame| self.flame.exposure.drawing(*frame));
        let extent = self.particles.sequence.extent(interrupt::until(drawings))?;
        interrupt::check()?;
        let extent = ParticleExtent { hottest: self.hottest.unwrap_or(extent.hottest), ..extent };
        if let (Some(spreads), Some(first)) = (&mut self.spreads, rendered.first()) {
            self.first = Some((*first, spreads.of(self.flame.exposure.drawing(*first))?));
        }
        self.extent = Some(extent);
        let light = if fire_lights_smoke(&self.shot) { 0.0 } else { self.flame.settings.light };
        Ok(effects.with(Desc {
            size: self.shot.size,
            lines: None,
            target_format: TARGET_FORMAT,
            scene: None,
            accumulates: false,
            particles: extent.most,
            hottest: extent.hottest,
            seed: self.shot.seed,
            settings: Settings { light, ..self.flame.settings.clone() },
            layers,
            temporal: Default::default(),
        }))
    }

    fn choices(&self) -> Option<String> {
        self.first.map(|(frame, spread)| format!("flame.spread = {spread} m in frame {frame}"))
    }

    fn read(&mut self, frame: u32, rendered: bool) -> Result<Option<Box<dyn Brought>>, InputError> {
        if !rendered {
            return Ok(None);
        }
        let (extent, drawing) = (self.extent, self.flame.exposure.drawing(frame));
        let particles = self.particles.read(drawing, |some, path| extent.map_or(Ok(()), |e| e.check(some, path)))?;
        let count = self.particles.last().map_or(0, |last| last.position.len());
        let spread = self.spreads.as_mut().map(|spreads| spreads.of(drawing)).transpose()?;
        Ok(Some(Box::new(FlameBrought { particles, count, drawing, spread, fire: self.light() })))
    }
}

impl FlameInput {
    /// Of the particles that were read last, on the shot's smoke.
    fn light(&self) -> Option<FireLight> {
        let Particles { position, temperature, .. } = self.particles.last()?;
        let hottest = self.extent.map_or(f32::MAX, |extent| extent.hottest);
        let is_lit = fire_lights_smoke(&self.shot);
        is_lit.then(|| fire_light(&self.flame.settings, hottest, position, temperature)).flatten()
    }
}

#[cfg(test)]
impl FlameBrought {
    /// So many, which are those of the frame before.
    pub(super) fn of(count: usize) -> FlameBrought {
        FlameBrought { particles: None, count, drawing: 1, spread: None, fire: None }
    }
}

impl Brought for FlameBrought {
    fn put<'a>(&'a self, scene: &mut Scene<'a>) {
        (scene.particles, scene.spread) = (self.particles.as_deref(), self.spread);
        (scene.drawing, scene.fire) = (Some(self.drawing), self.fire);
    }
}
