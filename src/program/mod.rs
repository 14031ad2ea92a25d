//! The effects as the program has them: each in a folder of its own, and a line of `EFFECTS`.
//!
//! | file | holds |
//! |---|---|
//! | `shot.rs` | its table in shots |
//! | `input.rs` | what its frames are made from, read ahead of the renderer |
//! | `feed.rs` | how a scene becomes a frame of it |
//! | `layers.rs` | what of it `--layers` writes |
//!
//! What it is on the device stands in the folder of its name beside this one, and is described in [`crate::effect`].

pub mod blur;
pub mod flame;
mod hash;
mod input;
pub mod layers;
pub mod smoke;
mod variants;
#[cfg(feature = "vignette")]
pub mod vignette;

use std::sync::Arc;

use crate::bench::Benchmark;
use crate::effect::DeviceTraits;
use crate::error::Result;
use crate::io::shot::{self, Shot, ShotError, Table};
use crate::offline::Scene;
use crate::plan::Pass;
use crate::smoke::Sequence;
pub(crate) use hash::{Files, add};
pub use input::InputError;
pub(crate) use input::{Brought, Input, Opened};
use layers::{LayerEntry, Shown, Watch};

/// An effect as the program has it.
pub(crate) struct EffectEntry {
    /// Its table in shots, whose name is that of its layers, its benchmark, and before the dot of its passes.
    pub(crate) table: &'static Table,
    /// Begins to read what the frames of a shot are made from; none where the shot has no such effect.
    pub(crate) open: fn(&Arc<Shot>) -> Opened,
    /// What `--layers` writes.
    pub(crate) layers: &'static [LayerEntry],
    /// Which of them say what is seen of it; none: they do not.
    pub(crate) shown: Option<Shown>,
    /// Looked at after each frame.
    pub(crate) watch: Option<Watch>,
    /// Its passes, in all ways that their kernels are specialised for.
    pub(crate) variants: fn(&DeviceTraits) -> Result<Vec<Vec<Pass>>>,
    /// Measures it.
    pub(crate) benchmark: Benchmark,
}

impl EffectEntry {
    /// The effect's name.
    pub(crate) fn name(&self) -> &'static str {
        self.table.name
    }
}

/// Every effect, in the order in which they are drawn.
pub(crate) static EFFECTS: &[&EffectEntry] = &[
    &blur::ENTRY,
    &smoke::ENTRY,
    &flame::ENTRY,
    #[cfg(feature = "vignette")]
    &vignette::ENTRY,
];

/// What measures the effect of this name, or each of them where there is no name.
pub fn benchmarks(name: Option<&str>) -> Vec<Benchmark> {
    let chosen = EFFECTS.iter().filter(|effect| name.is_none_or(|name| name == effect.name()));
    chosen.map(|effect| effect.benchmark).collect()
}

/// The passes of every effect, in all ways that their kernels are specialised for.
///
/// # Errors
/// None, for what effects are known to allow.
pub fn variants(traits: &DeviceTraits) -> Result<Vec<Pass>> {
    let passes = EFFECTS.iter().map(|effect| (effect.variants)(traits)).collect::<Result<Vec<_>>>()?;
    Ok(passes.into_iter().flatten().flatten().collect())
}

/// The tables that shots may have.
pub fn tables() -> Vec<&'static Table> {
    EFFECTS.iter().map(|effect| effect.table).collect()
}

/// A frame of a shot, without what its effects' inputs bring.
pub(crate) fn scene<'a>(shot: &Shot, number: u32, rendered: bool) -> Scene<'a> {
    Scene {
        sequence: if number == shot.frames[0] { Sequence::Restart } else { Sequence::Advance },
        dt: (1.0 / shot.fps) as f32,
        camera: shot.camera(number),
        previous: (number > shot.frames[0]).then(|| shot.camera(number - 1).view(shot.size)),
        light: shot.light(number),
        rendered,
        number,
        ..Scene::default()
    }
}

/// Loads a shot that may have all of these tables: as [`Shot::load`].
///
/// # Errors
/// As there.
pub fn load(name: &str, sets: &[String]) -> std::result::Result<Shot, ShotError> {
    Shot::load(name, sets, &tables())
}

/// The commented text of a built-in shot.
///
/// # Errors
/// There is none of this name.
pub fn builtin_text(name: &str) -> std::result::Result<String, ShotError> {
    shot::builtin_text(name, &tables())
}
