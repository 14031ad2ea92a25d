//! Input of fire: particles, and what follows from all of the shot's.

use std::sync::Arc;

use xxhash_rust::xxh3::Xxh3;

use super::fire_lights_smoke;
use super::shot::Flame;
use crate::data::{ParticleExtent, Particles};
use crate::flame::settings::Colour;
use crate::flame::{Desc, Settings, fire_light, mean_spacing};
use crate::interrupt;
use crate::io::ReadError;
use crate::io::particles::ParticleSequence;
use crate::io::shot::Shot;
use crate::offline::{Effects, Scene, TARGET_FORMAT};
use crate::program::hash::builtin;
use crate::program::input::Fresh;
use crate::program::{Brought, Files, Input, InputError, Opened, add};
use crate::view::FireLight;

/// Spread of a flame without one in a shot none of whose frames has two particles, in metres.
const DEFAULT_SPREAD: f32 = 0.1;

/// A shot's particles.
struct FlameInput {
    shot: Arc<Shot>,
    flame: Flame,
    particles: Fresh<Particles>,
    fire: Fire,
    /// The extent that the effect was made for, which all particles must be within.
    extent: Option<ParticleExtent>,
}

/// Values of a fire that follow from its whole shot, so that a frame alone looks as it does in the sequence.
#[derive(Clone, Copy, Debug)]
struct Fire {
    /// Where the table of physical colours ends: at the hottest particle. None where colours are others.
    hottest: Option<f32>,
    spread: f32,
}

/// A frame's particles.
pub(super) struct FlameBrought {
    /// None where they are those of the frame before.
    pub(super) particles: Option<Arc<Particles>>,
    /// How many they are.
    pub(super) count: usize,
    /// The frame whose drawing it has.
    drawing: u32,
    /// Their light on the shot's smoke.
    fire: Option<FireLight>,
}

/// Looks at all of the shot's particles where that is what its fire follows from.
pub(super) fn open(shot: &Arc<Shot>) -> Opened {
    let Some(flame) = shot.part::<Flame>() else { return Ok(None) };
    let mut particles = flame.particles(shot)?;
    let (flame, [first, last]) = (flame.clone(), shot.frames);
    let hottest = match flame.settings.colour {
        Colour::Physical => Some(particles.extent(interrupt::until(first..=last))?.hottest),
        _ => None,
    };
    let spread = match flame.settings.spread {
        Some(spread) => spread,
        None => spread(&mut particles, shot.frames)?,
    };
    interrupt::check()?;
    let fire = Fire { hottest, spread };
    let particles = Fresh::new(particles);
    Ok(Some(Box::new(FlameInput { shot: shot.clone(), flame, particles, fire, extent: None })))
}

/// The spread of a flame that has none: the mean distance to the 8th neighbour in the shot's first frame that has one.
fn spread(particles: &mut ParticleSequence, [first, last]: [u32; 2]) -> Result<f32, ReadError> {
    for frame in interrupt::until(first..=last) {
        if let Some(spacing) = mean_spacing(&particles.frame(frame)?.position) {
            return Ok(spacing);
        }
    }
    Ok(DEFAULT_SPREAD)
}

impl Input for FlameInput {
    fn add_common(&self, hash: &mut Xxh3, _: &mut Files) -> Result<(), ReadError> {
        let Flame { particles, exposure, settings, .. } = &self.flame;
        add(hash, ("flame", builtin(particles), self.fire, exposure, settings));
        Ok(())
    }

    fn add_frame(&self, hash: &mut Xxh3, files: &mut Files, frame: u32) -> Result<(), ReadError> {
        add(hash, files.digest_of(&self.particles.sequence, self.flame.exposure.drawing(frame))?);
        Ok(())
    }

    fn describe(&mut self, effects: Effects, rendered: &[u32], layers: bool) -> Result<Effects, InputError> {
        let drawings = rendered.iter().map(|frame| self.flame.exposure.drawing(*frame));
        let extent = self.particles.sequence.extent(interrupt::until(drawings))?;
        interrupt::check()?;
        let Fire { hottest, spread } = self.fire;
        let extent = ParticleExtent { hottest: hottest.unwrap_or(extent.hottest), ..extent };
        self.extent = Some(extent);
        let light = if fire_lights_smoke(&self.shot) { 0.0 } else { self.flame.settings.light };
        Ok(effects.with(Desc {
            size: self.shot.size,
            target_format: TARGET_FORMAT,
            scene: None,
            accumulates: false,
            particles: extent.most,
            hottest: extent.hottest,
            seed: self.shot.seed,
            settings: Settings { spread: Some(spread), light, ..self.flame.settings.clone() },
            layers,
            temporal: Default::default(),
        }))
    }

    fn choices(&self) -> Option<String> {
        self.flame.settings.spread.is_none().then(|| format!("flame.spread = {} m", self.fire.spread))
    }

    fn read(&mut self, frame: u32, rendered: bool) -> Result<Option<Box<dyn Brought>>, InputError> {
        if !rendered {
            return Ok(None);
        }
        let (extent, drawing) = (self.extent, self.flame.exposure.drawing(frame));
        let particles = self.particles.read(drawing, |some, path| extent.map_or(Ok(()), |e| e.check(some, path)))?;
        let count = self.particles.last().map_or(0, |last| last.position.len());
        Ok(Some(Box::new(FlameBrought { particles, count, drawing, fire: self.light() })))
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
        FlameBrought { particles: None, count, drawing: 1, fire: None }
    }
}

impl Brought for FlameBrought {
    fn put<'a>(&'a self, scene: &mut Scene<'a>) {
        scene.particles = self.particles.as_deref();
        scene.drawing = Some(self.drawing);
        scene.fire = self.fire;
    }
}
