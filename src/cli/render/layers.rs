//! The layers of a shot's effects: from the bytes of the buffers that their passes wrote. Each effect has one table.

mod blur;
mod flame;
mod smoke;

use super::outputs::{Layer, LayerData};
use crate::offline::{BlurFrame, EffectBuffer, Effects};
use crate::plan::BufferId;

/// A layer's name, as in the file name, and whether it is an array.
pub(super) type LayerName = (&'static str, bool);

/// A line of an effect's table.
struct Entry {
    name: &'static str,
    /// Whether it is an array, and not an image of the picture's size.
    is_array: bool,
    /// What it is made of.
    buffers: &'static [BufferId],
    decode: fn(&Made) -> LayerData,
}

impl Entry {
    const fn array(name: &'static str, buffers: &'static [BufferId], decode: fn(&Made) -> LayerData) -> Entry {
        Entry { name, is_array: true, buffers, decode }
    }

    const fn image(name: &'static str, buffers: &'static [BufferId], decode: fn(&Made) -> LayerData) -> Entry {
        Entry { name, is_array: false, buffers, decode }
    }
}

/// An effect's table, and what its buffers are called.
type Table = (&'static [Entry], fn(BufferId) -> EffectBuffer);

/// The tables of those effects that are there: smoke, flame, blur.
fn tables(are_there: [bool; 3]) -> impl Iterator<Item = Table> {
    let all: [Table; 3] = [
        (smoke::LAYERS, EffectBuffer::Smoke),
        (flame::LAYERS, EffectBuffer::Flame),
        (blur::LAYERS, EffectBuffer::Blur),
    ];
    all.into_iter().zip(are_there).filter(|(_, is_there)| *is_there).map(|(table, _)| table)
}

fn tables_of(effects: &Effects) -> impl Iterator<Item = Table> + use<> {
    tables([effects.smoke.is_some(), effects.flame.is_some(), effects.blur.is_some()])
}

/// The layers of a shot with these effects.
pub(super) fn names(has_smoke: bool, has_flame: bool, has_blur: bool) -> Vec<LayerName> {
    let entries = tables([has_smoke, has_flame, has_blur]).flat_map(|(entries, _)| entries);
    entries.map(|entry| (entry.name, entry.is_array)).collect()
}

/// The buffers that layers are made of, each once.
pub(super) fn buffers(effects: &Effects) -> Vec<EffectBuffer> {
    let mut buffers = Vec::new();
    for (entries, name) in tables_of(effects) {
        for buffer in entries.iter().flat_map(|entry| entry.buffers).map(|id| name(*id)) {
            if !buffers.contains(&buffer) {
                buffers.push(buffer);
            }
        }
    }
    buffers
}

/// A blurred frame, as far as it is not in the effect's buffers.
#[derive(Clone, Copy)]
pub(super) struct Blurred<'a> {
    /// The motion.
    pub(super) motion: &'a BlurFrame,
    /// The picture, with all effects.
    pub(super) picture: &'a [[f32; 4]],
    /// Whether the blur is the only effect.
    pub(super) is_alone: bool,
    /// Whether nothing moved, so that buffers hold what an earlier frame left.
    pub(super) is_still: bool,
}

/// A frame that has been made, as an effect's layers see it.
struct Made<'a> {
    effects: &'a Effects,
    /// Pixels of the picture.
    pixels: usize,
    /// Particles of the flame's frame.
    particles: usize,
    blurred: Option<Blurred<'a>>,
    /// The effect's buffers.
    buffers: Vec<(BufferId, &'a [u8])>,
}

impl Made<'_> {
    /// The first `count` elements of a buffer, or as many as there are.
    fn read<T: bytemuck::AnyBitPattern>(&self, id: BufferId, count: usize) -> Vec<T> {
        let bytes = self.buffers.iter().find(|(other, _)| *other == id).map_or(&[][..], |(_, bytes)| bytes);
        bytes.chunks_exact(size_of::<T>()).take(count).map(bytemuck::pod_read_unaligned).collect()
    }

    /// An element a pixel.
    fn image<T: bytemuck::AnyBitPattern>(&self, id: BufferId) -> Vec<T> {
        self.read(id, self.pixels)
    }
}

/// Makes the layers of a frame of `particles` particles, and of a mesh's motion, from the bytes of [`buffers`]. Without
/// bytes there are none.
pub(super) fn decode(
    effects: &Effects,
    bytes: &[&[u8]],
    particles: usize,
    size: [u32; 2],
    blurred: Option<Blurred>,
) -> Vec<Layer> {
    let all = buffers(effects);
    if bytes.len() < all.len() {
        return Vec::new();
    }
    let pixels = size[0] as usize * size[1] as usize;
    let layers = tables_of(effects).flat_map(|(entries, name)| {
        let own = |entry: &'static Entry| entry.buffers.iter().map(|id| (*id, name(*id)));
        let of = |(id, buffer)| Some((id, bytes[all.iter().position(|other| *other == buffer)?]));
        let buffers = entries.iter().flat_map(own).filter_map(of).collect();
        let made = Made { effects, pixels, particles, blurred, buffers };
        entries.iter().map(move |entry| Layer { name: entry.name, data: (entry.decode)(&made) })
    });
    layers.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An effect's layers of a picture of two pixels, from the bytes of some of its buffers.
    pub(super) fn of(
        entries: &'static [Entry],
        effects: &Effects,
        buffers: &[(BufferId, &[u8])],
        particles: usize,
        blurred: Option<Blurred>,
    ) -> Vec<Layer> {
        let made = Made { effects, pixels: 2, particles, blurred, buffers: buffers.to_vec() };
        entries.iter().map(|entry| Layer { name: entry.name, data: (entry.decode)(&made) }).collect()
    }

    /// The values of a layer, one after the other.
    pub(super) fn values(layers: &[Layer], name: &str) -> Vec<f32> {
        let layer = layers.iter().find(|layer| layer.name == name).expect(name);
        match &layer.data {
            LayerData::Value(values) | LayerData::Array { values, .. } => values.clone(),
            LayerData::Rgb(pixels) => pixels.as_flattened().to_vec(),
            LayerData::Colour(pixels) => pixels.as_flattened().to_vec(),
        }
    }

    #[test]
    fn a_shot_has_the_layers_of_its_effects() {
        let count = |has_smoke, has_flame, has_blur| names(has_smoke, has_flame, has_blur).len();
        assert_eq!((count(true, false, false), count(false, true, false), count(true, true, false)), (9, 8, 17));
        assert_eq!((count(false, false, true), count(true, true, true)), (8, 25));
        assert!(names(false, true, false).iter().all(|(name, _)| name.starts_with("flame")));
        assert!(names(false, false, true).iter().all(|(name, _)| name.starts_with("blur")));
        assert!(decode(&Effects::default(), &[&[0_u8; 16][..]; 40], 3, [1, 1], None).is_empty());
    }
}
