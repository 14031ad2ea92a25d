//! The layers of the smoke effect: from the bytes of the buffers that its passes wrote.

use super::{LayerName, read};
use crate::cli::render::outputs::{Layer, LayerData};
use crate::plan::BufferId;
use crate::smoke::layout;
use crate::smoke::params::{Control, GROUP_BITS, GROUP_MASK, LUMINANCE_ONE};

/// Every layer's name, and whether it is an array.
pub(super) const LAYERS: [LayerName; 9] = [
    ("smoke.spheres", true),
    ("smoke.luminance", false),
    ("smoke.depth", false),
    ("smoke.id", false),
    ("smoke.shadow", false),
    ("smoke.smooth", false),
    ("smoke.tone", false),
    ("smoke.outline", false),
    ("smoke", false),
];

/// The buffers that layers are made of, in the order in which [`decode`] takes them.
pub(super) const BUFFERS: [BufferId; 11] = [
    layout::CONTROL,
    layout::VISIBLE,
    layout::SPHERES,
    layout::GROUPS,
    layout::PIXELS,
    layout::DEPTH,
    layout::SHADOW,
    layout::SMOOTH,
    layout::TONE_LAYER,
    layout::OUTLINE_LAYER,
    layout::PICTURE,
];

/// Makes the layers of a picture of `pixels` pixels. Without `filtered` the smoothed luminance is the luminance itself.
pub(super) fn decode(bytes: [&[u8]; BUFFERS.len()], pixels: usize, filtered: bool) -> Vec<Layer> {
    let [control, visible, spheres, groups, words, depth, shadow, smooth, tone, outline, picture] = bytes;
    let words: Vec<u32> = read(words, pixels);
    let luminance: Vec<f32> = words.iter().map(|word| (word >> GROUP_BITS) as f32 / LUMINANCE_ONE).collect();
    let smooth = if filtered { read(smooth, pixels) } else { luminance.clone() };
    let data = [
        LayerData::table(5, sphere_rows(control, visible, spheres, groups)),
        LayerData::Value(luminance),
        LayerData::Value(read(depth, pixels)),
        LayerData::Value(words.iter().map(|word| (word & GROUP_MASK) as f32).collect()),
        LayerData::Value(read(shadow, pixels)),
        LayerData::Value(smooth),
        LayerData::Colour(read(tone, pixels)),
        LayerData::Value(read(outline, pixels)),
        LayerData::Colour(read(picture, pixels)),
    ];
    LAYERS.into_iter().zip(data).map(|((name, _), data)| Layer { name, data }).collect()
}

/// x, y, z, radius and group of the visible spheres, in particle order.
fn sphere_rows(control: &[u8], visible: &[u8], spheres: &[u8], groups: &[u8]) -> Vec<f32> {
    let control: Vec<Control> = read(control, 1);
    let count = control.first().map_or(0, |control| control.visible as usize);
    let visible: Vec<u32> = read(visible, count);
    let row = |slot: &u32| {
        let slot = *slot as usize;
        let sphere: [f32; 4] = at(spheres, slot)?;
        let group: u32 = at(groups, slot)?;
        let [x, y, z, radius] = sphere;
        Some([x, y, z, radius, group as f32])
    };
    visible.iter().filter_map(row).flatten().collect()
}

/// Element `index`.
fn at<T: bytemuck::AnyBitPattern>(bytes: &[u8], index: usize) -> Option<T> {
    bytes.chunks_exact(size_of::<T>()).nth(index).map(bytemuck::pod_read_unaligned)
}

#[cfg(test)]
mod tests {
    use super::super::tests::values;
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn words_are_taken_apart_and_spheres_come_in_particle_order() {
        let control = Control { visible: 2, ..Control::zeroed() };
        let spheres: Vec<[f32; 4]> = (0..4).map(|i| [i as f32, 0.0, 1.0, 0.5]).collect();
        let pixels = [0xffff_ff07_u32, 0];
        let zero = [[0.0f32; 4]; 2];
        let bytes = [
            bytemuck::bytes_of(&control),
            bytemuck::cast_slice(&[1_u32, 3, 77]),
            bytemuck::cast_slice(&spheres),
            bytemuck::cast_slice(&[5_u32, 6, 7, 8]),
            bytemuck::cast_slice(&pixels),
            bytemuck::cast_slice(&[2.0f32, f32::INFINITY]),
            bytemuck::cast_slice(&[1.0f32, 0.0]),
            bytemuck::cast_slice(&[0.25f32, 0.0]),
            bytemuck::cast_slice(&zero),
            bytemuck::cast_slice(&[0.5f32, 0.0]),
            bytemuck::cast_slice(&zero),
        ];
        let layers = decode(bytes, 2, true);
        assert_eq!(values(&layers, "smoke.spheres"), [1.0, 0.0, 1.0, 0.5, 6.0, 3.0, 0.0, 1.0, 0.5, 8.0]);
        assert_eq!(values(&layers, "smoke.luminance"), [1.0, 0.0]);
        assert_eq!(values(&layers, "smoke.id"), [7.0, 0.0]);
        assert_eq!(values(&layers, "smoke.depth"), [2.0, f32::INFINITY]);
        assert_eq!(values(&layers, "smoke.smooth"), [0.25, 0.0]);
        assert_eq!(values(&decode(bytes, 2, false), "smoke.smooth"), [1.0, 0.0], "without sigma nothing is smoothed");
    }
}
