//! The layers of a shot's effects: from the bytes of the buffers that their passes wrote.

mod flame;
mod smoke;

use super::outputs::Layer;
use crate::offline::{EffectBuffer, Effects};

/// A layer's name, as in the file name, and whether it is an array.
pub(super) type LayerName = (&'static str, bool);

/// The layers of a shot with these effects.
pub(super) fn names(has_smoke: bool, has_flame: bool) -> Vec<LayerName> {
    let smoke = smoke::LAYERS.iter().filter(|_| has_smoke);
    smoke.chain(flame::LAYERS.iter().filter(|_| has_flame)).copied().collect()
}

/// The buffers that layers are made of, in the order in which [`decode`] takes them.
pub(super) fn buffers(effects: &Effects) -> Vec<EffectBuffer> {
    let smoke = effects.smoke.iter().flat_map(|_| smoke::BUFFERS.map(EffectBuffer::Smoke));
    smoke.chain(effects.flame.iter().flat_map(|_| flame::BUFFERS.map(EffectBuffer::Flame))).collect()
}

/// Makes the layers of a frame of `particles` particles. Without bytes there are none.
pub(super) fn decode(effects: &Effects, bytes: &[&[u8]], particles: usize) -> Vec<Layer> {
    let mut layers = Vec::new();
    let mut bytes = bytes;
    if let (Some(desc), Some((taken, rest))) = (&effects.smoke, bytes.split_first_chunk()) {
        layers.extend(smoke::decode(*taken, pixels(desc.size), desc.settings.sigma > 0.0));
        bytes = rest;
    }
    if let (Some(desc), Some((taken, _))) = (&effects.flame, bytes.split_first_chunk()) {
        layers.extend(flame::decode(*taken, pixels(desc.size), particles, desc.settings.variants));
    }
    layers
}

fn pixels(size: [u32; 2]) -> usize {
    size[0] as usize * size[1] as usize
}

/// The first `count` elements, or as many as there are.
fn read<T: bytemuck::AnyBitPattern>(bytes: &[u8], count: usize) -> Vec<T> {
    bytes.chunks_exact(size_of::<T>()).take(count).map(bytemuck::pod_read_unaligned).collect()
}

#[cfg(test)]
mod tests {
    use super::super::outputs::LayerData;
    use super::*;

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
        let count = |has_smoke, has_flame| names(has_smoke, has_flame).len();
        assert_eq!((count(true, false), count(false, true), count(true, true)), (9, 8, 17));
        assert!(names(false, true).iter().all(|(name, _)| name.starts_with("flame")));
        assert!(decode(&Effects::default(), &[&[0_u8; 16][..]; 40], 3).is_empty());
    }
}
