//! A vignette of two passes, for tests alone: all that an effect takes is its folders, a line of the registry and its keys.

mod bench;
mod effect;

use std::sync::Arc;

use xxhash_rust::xxh3::Xxh3;

use super::layers::{LayerData, LayerEntry};
use super::variants::{SIZE, passes};
use super::{Brought, EffectEntry, Files, Input, InputError, Opened, add};
use crate::bench::Benchmark;
use crate::effect::{DeviceTraits, Effort};
use crate::error::Error;
use crate::host::HostImage;
use crate::io::ReadError;
use crate::io::shot::{Part, Section, Shot, ShotError, Table, setting_error};
use crate::offline::{Depth, Describe, Effects, Feed, Place, Scene, TARGET_FORMAT};
use crate::plan::Pass;
use crate::settings::{Setting, settings};
use effect::{DARKNESS, Vignette};
pub use effect::{Desc, VignetteKind};

pub(super) static ENTRY: EffectEntry = EffectEntry {
    table: &TABLE,
    open,
    layers: &[LayerEntry::image("vignette.darkness", &[DARKNESS], |made| LayerData::Value(made.image(DARKNESS)))],
    shown: None,
    watch: None,
    variants,
    benchmark: Benchmark(bench::measure),
};

settings! {
    /// What a shot says of its vignette.
    pub struct Settings {
        /// How dark the corners are.
        strength: f32 = 0.5, "", 0.0..=1.0, "off";
        /// Where it begins, as a share of the way from the centre to a corner.
        radius: f32 = 0.75, "", 0.0..=0.99;
    }
}

const TABLE: Table = Table {
    name: "vignette",
    inputs: &[],
    dials: || Setting::dials(&Settings::default()),
    files: &[],
    excluding: &[],
    read,
};

impl Part for Settings {
    fn check(&self, is_alone: bool) -> Result<(), String> {
        match is_alone {
            true => Err("[vignette]: allowed: only with another effect, whose picture it darkens".to_owned()),
            false => Ok(()),
        }
    }
}

fn read(section: &Section) -> Result<Arc<dyn Part>, ShotError> {
    let settings: Settings = section.tree.settings("vignette", &[])?;
    Setting::check(&settings, "vignette", &()).map_err(|e| setting_error(section.tree, &e, ""))?;
    Ok(Arc::new(settings))
}

fn variants(traits: &DeviceTraits) -> Result<Vec<Vec<Pass>>, Error> {
    let Settings { strength, radius } = Settings::default();
    let desc = Desc { size: SIZE, target_format: TARGET_FORMAT, strength, radius };
    Ok(vec![passes::<VignetteKind>(&desc, traits, Effort::Needed)?])
}

/// Input of its frames: nothing but the shot.
struct VignetteInput {
    shot: Arc<Shot>,
    settings: Settings,
}

fn open(shot: &Arc<Shot>) -> Opened {
    let Some(settings) = shot.part::<Settings>() else { return Ok(None) };
    Ok(Some(Box::new(VignetteInput { shot: shot.clone(), settings: settings.clone() })))
}

impl Input for VignetteInput {
    fn add_common(&self, hash: &mut Xxh3, _: &mut Files) -> Result<(), ReadError> {
        add(hash, ("vignette", &self.settings));
        Ok(())
    }

    fn add_frame(&self, _: &mut Xxh3, _: &mut Files, _: u32) -> Result<(), ReadError> {
        Ok(())
    }

    fn describe(&mut self, effects: Effects, _: &[u32], _: bool) -> Result<Effects, InputError> {
        let Settings { strength, radius } = self.settings;
        Ok(effects.with(Desc { size: self.shot.size, target_format: TARGET_FORMAT, strength, radius }))
    }

    fn read(&mut self, _: u32, _: bool) -> Result<Option<Box<dyn Brought>>, InputError> {
        Ok(None)
    }
}

impl Describe for Desc {
    type Feed = VignetteFeed;
    const DEPTH: Depth = Depth::None;

    fn size(&self) -> [u32; 2] {
        self.size
    }
}

/// A frame is where it is drawn.
#[derive(Default)]
pub struct VignetteFeed;

impl Feed for VignetteFeed {
    type Kind = VignetteKind;

    fn frame<'a>(&'a self, _: &Vignette, _: &Scene<'a>, place: &Place) -> Option<HostImage> {
        place.target
    }
}
