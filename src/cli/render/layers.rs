//! The layers of a shot's effects: from the bytes of the buffers that their passes wrote.

mod blur;
mod flame;
mod smoke;

use super::outputs::Layer;
use crate::offline::{BlurFrame, EffectBuffer, Effects};

/// A layer's name, as in the file name, and whether it is an array.
pub(super) type LayerName = (&'static str, bool);

/// The layers of a shot with these effects.
pub(super) fn names(has_smoke: bool, has_flame: bool, has_blur: bool) -> Vec<LayerName> {
    let smoke = smoke::LAYERS.iter().filter(|_| has_smoke);
    let flame = flame::LAYERS.iter().filter(|_| has_flame);
    smoke.chain(flame).chain(blur::LAYERS.iter().filter(|_| has_blur)).copied().collect()
}

/// The buffers that layers are made of, in the order in which [`decode`] takes them.
pub(super) fn buffers(effects: &Effects) -> Vec<EffectBuffer> {
    let smoke = effects.smoke.iter().flat_map(|_| smoke::BUFFERS.map(EffectBuffer::Smoke));
    let flame = effects.flame.iter().flat_map(|_| flame::BUFFERS.map(EffectBuffer::Flame));
    smoke.chain(flame).chain(effects.blur.iter().flat_map(|_| blur::BUFFERS.map(EffectBuffer::Blur))).collect()
}

/// A blurred frame, as far as it is not in the effect's buffers.
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

/// Makes the layers of a frame of `particles` particles, and of a mesh's motion. Without bytes there are none.
pub(super) fn decode(effects: &Effects, bytes: &[&[u8]], particles: usize, blurred: Option<&Blurred>) -> Vec<Layer> {
    let mut layers = Vec::new();
    let mut bytes = bytes;
    if let (Some(desc), Some((taken, rest))) = (&effects.smoke, bytes.split_first_chunk()) {
        layers.extend(smoke::decode(*taken, pixels(desc.size), desc.settings.sigma > 0.0));
        bytes = rest;
    }
    if let (Some(desc), Some((taken, rest))) = (&effects.flame, bytes.split_first_chunk()) {
        layers.extend(flame::decode(*taken, pixels(desc.size), particles, desc.settings.variants));
        bytes = rest;
    }
    if let (Some(desc), Some(blurred), Some((taken, _))) = (&effects.blur, blurred, bytes.split_first_chunk()) {
        layers.extend(match blurred.is_still {
            true => blur::still(*taken, blurred),
            false => blur::decode(*taken, pixels(desc.size), blurred),
        });
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
        let count = |has_smoke, has_flame, has_blur| names(has_smoke, has_flame, has_blur).len();
        assert_eq!((count(true, false, false), count(false, true, false), count(true, true, false)), (9, 8, 17));
        assert_eq!((count(false, false, true), count(true, true, true)), (8, 25));
        assert!(names(false, true, false).iter().all(|(name, _)| name.starts_with("flame")));
        assert!(names(false, false, true).iter().all(|(name, _)| name.starts_with("blur")));
        assert!(decode(&Effects::default(), &[&[0_u8; 16][..]; 40], 3, None).is_empty());
    }
}
