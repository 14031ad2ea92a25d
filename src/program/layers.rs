//! The layers of a frame: from the bytes of the buffers that passes wrote. Each effect has one table.

use std::any::Any;

use super::EFFECTS;
use crate::offline::{EffectBuffer, Effects};
use crate::plan::BufferId;

/// A layer: what a pass wrote.
pub(crate) struct Layer {
    /// `effect.layer`, as in the file name.
    pub(crate) name: &'static str,
    pub(crate) data: LayerData,
}

/// The data of a layer.
pub(crate) enum LayerData {
    /// One value per pixel: channel `Y`.
    Value(Vec<f32>),
    /// Channels `R G B`.
    Rgb(Vec<[f32; 3]>),
    /// Channels `R G B A`.
    Colour(Vec<[f32; 4]>),
    /// Motion vectors: channels `X Y`.
    Vector(Vec<[f32; 2]>),
    /// What each of a pixel's four samples shows: a number from 1, 0 where it shows nothing, and what these are called, in their
    /// order. Channels `R G B A`.
    Objects { samples: Vec<[u32; 4]>, names: Vec<String> },
    /// An array of this shape, the last axis running fastest.
    Array { shape: Vec<u64>, values: Vec<f32> },
}

impl LayerData {
    /// Rows of so many columns.
    pub(crate) fn table(columns: u64, values: Vec<f32>) -> LayerData {
        LayerData::Array { shape: vec![values.len() as u64 / columns.max(1), columns], values }
    }
}

/// A layer's name, as in the file name, and whether it is an array.
pub(crate) type LayerName = (&'static str, bool);

/// The layer of motion vectors, of all effects together.
pub(crate) const VECTORS: LayerName = ("vector", false);

/// Which layers are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    None,
    /// Those that are images.
    Images,
    All,
}

impl Wanted {
    fn has(self, entry: &LayerEntry) -> bool {
        self == Wanted::All || self == Wanted::Images && !entry.is_array
    }
}

/// A line of an effect's table.
pub(crate) struct LayerEntry {
    name: &'static str,
    /// Whether it is an array, and not an image of the picture's size.
    is_array: bool,
    /// The buffers that it is made of.
    buffers: &'static [BufferId],
    decode: fn(&Made) -> LayerData,
}

impl LayerEntry {
    pub(super) const fn array(
        name: &'static str,
        buffers: &'static [BufferId],
        decode: fn(&Made) -> LayerData,
    ) -> LayerEntry {
        LayerEntry { name, is_array: true, buffers, decode }
    }

    pub(super) const fn image(
        name: &'static str,
        buffers: &'static [BufferId],
        decode: fn(&Made) -> LayerData,
    ) -> LayerEntry {
        LayerEntry { name, is_array: false, buffers, decode }
    }
}

/// The layers that say what is seen of an effect, by their names: who and where it is in files for compositing.
pub(crate) struct Shown {
    /// View depth; infinite where nothing is, or ink alone.
    pub(crate) depth: &'static str,
    pub(crate) who: Who,
}

/// Who is seen in a pixel.
pub(crate) enum Who {
    /// The effect, as much as there is alpha in the layer `colour`: one thing, or what the layer `id` has numbers of.
    Effect { colour: &'static str, id: Option<&'static str> },
    /// Objects at four samples.
    Objects(&'static str),
}

/// A check after each frame, whether layers are written or not.
pub(crate) struct Watch {
    pub(super) buffers: &'static [BufferId],
    /// The remark on the frame, if there is one.
    pub(super) says: fn(&Made) -> Option<String>,
}

/// A frame that has been made, as an effect sees it.
pub(crate) struct Made<'a> {
    /// The description that the effect was made for.
    desc: &'a dyn Any,
    /// Input of the frame.
    brought: Option<&'a dyn Any>,
    /// The picture, with all effects.
    pub(super) picture: &'a [[f32; 4]],
    /// Whether this is the only effect.
    pub(super) is_alone: bool,
    /// Passes that the effect left out.
    skipped: Vec<&'static str>,
    /// The effect's buffers.
    buffers: Vec<(BufferId, &'a [u8])>,
}

impl Made<'_> {
    /// The description that the effect was made for.
    pub(super) fn desc<D: 'static>(&self) -> Option<&D> {
        self.desc.downcast_ref()
    }

    /// Input of the frame.
    pub(super) fn brought<B: 'static>(&self) -> Option<&B> {
        self.brought?.downcast_ref()
    }

    /// Whether the effect left out a pass.
    pub(super) fn is_skipped(&self, pass: &str) -> bool {
        self.skipped.contains(&pass)
    }

    /// Pixels of the picture.
    pub(super) fn pixels(&self) -> usize {
        self.picture.len()
    }

    /// The first `count` elements of a buffer, or as many as there are.
    pub(super) fn read<T: bytemuck::AnyBitPattern>(&self, id: BufferId, count: usize) -> Vec<T> {
        let bytes = self.buffers.iter().find(|(other, _)| *other == id).map_or(&[][..], |(_, bytes)| bytes);
        bytes.chunks_exact(size_of::<T>()).take(count).map(bytemuck::pod_read_unaligned).collect()
    }

    /// An element a pixel.
    pub(super) fn image<T: bytemuck::AnyBitPattern>(&self, id: BufferId) -> Vec<T> {
        self.read(id, self.pixels())
    }
}

/// The layers of effects of these names.
pub(crate) fn names(is_there: impl Fn(&str) -> bool) -> Vec<LayerName> {
    let there = EFFECTS.iter().filter(|effect| is_there(effect.name()));
    there.flat_map(|effect| effect.layers).map(|entry| (entry.name, entry.is_array)).collect()
}

/// The buffers that are read back after each frame: those that are watched, and with layers those that these are made of.
/// Each once.
pub(crate) fn buffers(effects: &Effects, wanted: Wanted) -> Vec<EffectBuffer> {
    let mut all = Vec::new();
    for effect in EFFECTS.iter().filter(|effect| effects.named(effect.name()).is_some()) {
        let layers = effect.layers.iter().filter(|entry| wanted.has(entry)).flat_map(|entry| entry.buffers);
        let watched = effect.watch.iter().flat_map(|watch| watch.buffers);
        for buffer in layers.chain(watched).map(|id| EffectBuffer { effect: effect.name(), id: *id }) {
            if !all.contains(&buffer) {
                all.push(buffer);
            }
        }
    }
    all
}

/// A frame, before effects look at what they made of it.
pub(crate) struct Rendered<'a> {
    /// The descriptions that the effects were made for.
    pub(crate) effects: &'a Effects,
    /// The picture.
    pub(crate) picture: &'a [[f32; 4]],
    /// The data read back, and from where.
    pub(crate) buffers: Vec<(EffectBuffer, &'a [u8])>,
    /// Input of the frame, by the effect's name.
    pub(crate) brought: Vec<(&'static str, &'a dyn Any)>,
    /// Passes that effects left out, by the effect's name.
    pub(crate) skipped: Vec<(&'static str, &'static str)>,
}

impl Rendered<'_> {
    fn made(&self, effect: &str) -> Option<Made<'_>> {
        let own = self.buffers.iter().filter(|(buffer, _)| buffer.effect == effect);
        Some(Made {
            desc: self.effects.named(effect)?,
            brought: self.brought.iter().find(|(name, _)| *name == effect).map(|(_, brought)| *brought),
            picture: self.picture,
            is_alone: self.effects.len() == 1,
            skipped: self.skipped.iter().filter(|(name, _)| *name == effect).map(|(_, pass)| *pass).collect(),
            buffers: own.map(|(buffer, bytes)| (buffer.id, *bytes)).collect(),
        })
    }

    /// Its layers.
    pub(crate) fn layers(&self, wanted: Wanted) -> Vec<Layer> {
        let made = EFFECTS.iter().filter_map(|effect| Some((effect, self.made(effect.name())?)));
        let layers = made.flat_map(|(effect, made)| {
            let entries = effect.layers.iter().filter(|entry| wanted.has(entry));
            entries.map(move |entry| Layer { name: entry.name, data: (entry.decode)(&made) })
        });
        layers.collect()
    }

    /// Remarks on it.
    pub(crate) fn remarks(&self) -> Vec<String> {
        let watched = EFFECTS.iter().filter_map(|effect| Some((effect.watch.as_ref()?, self.made(effect.name())?)));
        watched.filter_map(|(watch, made)| (watch.says)(&made)).collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// An effect's layers of a picture, from the bytes of some of its buffers.
    pub(in crate::program) fn of<D: 'static>(
        entries: &'static [LayerEntry],
        desc: &D,
        buffers: &[(BufferId, &[u8])],
        picture: &[[f32; 4]],
        brought: Option<&dyn Any>,
        (is_alone, skipped): (bool, &[&'static str]),
    ) -> Vec<Layer> {
        let (skipped, buffers) = (skipped.to_vec(), buffers.to_vec());
        let made = Made { desc, brought, picture, is_alone, skipped, buffers };
        entries.iter().map(|entry| Layer { name: entry.name, data: (entry.decode)(&made) }).collect()
    }

    /// The values of a layer, one after the other.
    pub(in crate::program) fn values(layers: &[Layer], name: &str) -> Vec<f32> {
        let layer = layers.iter().find(|layer| layer.name == name).expect(name);
        match &layer.data {
            LayerData::Value(values) | LayerData::Array { values, .. } => values.clone(),
            LayerData::Rgb(pixels) => pixels.as_flattened().to_vec(),
            LayerData::Colour(pixels) => pixels.as_flattened().to_vec(),
            LayerData::Vector(pixels) => pixels.as_flattened().to_vec(),
            LayerData::Objects { samples, .. } => samples.iter().flatten().map(|number| *number as f32).collect(),
        }
    }

    #[test]
    fn a_shot_has_the_layers_of_its_effects() {
        for effect in EFFECTS {
            let own = names(|name| name == effect.name());
            assert!(!own.is_empty() && own.iter().all(|(name, _)| name.starts_with(effect.name())), "{own:?}");
        }
        let all: usize = EFFECTS.iter().map(|effect| effect.layers.len()).sum();
        assert_eq!(names(|_| true).len(), all);
    }
}
