//! The layers of the smoke effect.

use crate::plan::BufferId;
use crate::program::layers::{LayerData, LayerEntry, Made};
use crate::smoke::Desc;
use crate::smoke::layout::{
    CONTROL, DEPTH, GROUPS, MATTE_LAYER, OVERLAY_LAYER, PICTURE, PIXELS, SHADOW, SMOOTH, SPHERES, TONE_LAYER, VISIBLE,
};
use crate::smoke::params::{Control, GROUP_BITS, GROUP_MASK, LUMINANCE_ONE};

pub(super) const LAYERS: &[LayerEntry] = &[
    LayerEntry::array("smoke.spheres", &[CONTROL, VISIBLE, SPHERES, GROUPS], spheres),
    LayerEntry::image("smoke.luminance", &[PIXELS], |made| LayerData::Value(luminance(made))),
    LayerEntry::image("smoke.depth", &[DEPTH], |made| LayerData::Value(made.image(DEPTH))),
    LayerEntry::image("smoke.id", &[PIXELS], |made| {
        LayerData::Value(made.image::<u32>(PIXELS).into_iter().map(|word| (word & GROUP_MASK) as f32).collect())
    }),
    LayerEntry::image("smoke.shadow", &[SHADOW], |made| LayerData::Value(made.image(SHADOW))),
    LayerEntry::image("smoke.smooth", &[SMOOTH, PIXELS], smooth),
    LayerEntry::image("smoke.tone", &[TONE_LAYER], |made| LayerData::Colour(made.image(TONE_LAYER))),
    LayerEntry::image("smoke.matte_1", &[MATTE_LAYER], |made| value_of(made, MATTE_LAYER, |[m, ..]| m)),
    LayerEntry::image("smoke.matte_2", &[MATTE_LAYER], |made| value_of(made, MATTE_LAYER, |[_, m, ..]| m)),
    LayerEntry::image("smoke.matte_3", &[MATTE_LAYER], |made| value_of(made, MATTE_LAYER, |[.., m, _]| m)),
    LayerEntry::image("smoke.matte_4", &[MATTE_LAYER], |made| value_of(made, MATTE_LAYER, |[.., m]| m)),
    LayerEntry::image("smoke.cast_shadow", &[OVERLAY_LAYER], |made| {
        value_of(made, OVERLAY_LAYER, |[.., shadow, _]| shadow)
    }),
    LayerEntry::image("smoke.rim", &[OVERLAY_LAYER], |made| value_of(made, OVERLAY_LAYER, |[.., rim]| rim)),
    LayerEntry::image("smoke.outline", &[OVERLAY_LAYER], |made| value_of(made, OVERLAY_LAYER, |[ink, ..]| ink)),
    LayerEntry::image("smoke.outline.silhouette", &[OVERLAY_LAYER], |made| {
        value_of(made, OVERLAY_LAYER, |[_, silhouette, ..]| silhouette)
    }),
    LayerEntry::image("smoke.outline.inner", &[OVERLAY_LAYER], |made| {
        value_of(made, OVERLAY_LAYER, |[ink, silhouette, ..]| ink - silhouette)
    }),
    LayerEntry::image("smoke", &[PICTURE], |made| LayerData::Colour(made.image(PICTURE))),
];

/// One value a pixel of the four that a buffer has.
fn value_of(made: &Made, buffer: BufferId, value: fn([f32; 4]) -> f32) -> LayerData {
    LayerData::Value(made.image(buffer).into_iter().map(value).collect())
}

fn luminance(made: &Made) -> Vec<f32> {
    made.image::<u32>(PIXELS).into_iter().map(|word| (word >> GROUP_BITS) as f32 / LUMINANCE_ONE).collect()
}

/// The luminance itself where nothing is smoothed.
fn smooth(made: &Made) -> LayerData {
    let is_filtered = made.desc().is_some_and(|desc: &Desc| desc.settings.is_filtered());
    LayerData::Value(if is_filtered { made.image(SMOOTH) } else { luminance(made) })
}

/// x, y, z, radius and group of the visible spheres, in particle order.
fn spheres(made: &Made) -> LayerData {
    let control: Vec<Control> = made.read(CONTROL, 1);
    let count = control.first().map_or(0, |control| control.visible as usize);
    let (spheres, groups) = (made.read::<[f32; 4]>(SPHERES, usize::MAX), made.read::<u32>(GROUPS, usize::MAX));
    let row = |place: u32| {
        let [x, y, z, radius] = *spheres.get(place as usize)?;
        Some([x, y, z, radius, *groups.get(place as usize)? as f32])
    };
    let visible = made.read::<u32>(VISIBLE, count);
    LayerData::table(5, visible.into_iter().filter_map(row).flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::offline::TARGET_FORMAT;
    use crate::program::layers::tests::{of, values};
    use crate::smoke::Settings;
    use bytemuck::Zeroable;

    fn desc(sigma: f32) -> Desc {
        let settings = Settings { sigma, ..Settings::default() };
        Desc { target_format: TARGET_FORMAT, layers: true, ..Desc::new([2, 1], [1; 3], settings) }
    }

    #[test]
    fn words_are_taken_apart_and_spheres_come_in_particle_order() {
        let control = Control { visible: 2, ..Control::zeroed() };
        let spheres: Vec<[f32; 4]> = (0..4).map(|i| [i as f32, 0.0, 1.0, 0.5]).collect();
        let pixels = [0xffff_ff07_u32, 0];
        let zero = [[0.0f32; 4]; 2];
        let bytes = [
            (CONTROL, bytemuck::bytes_of(&control)),
            (VISIBLE, bytemuck::cast_slice(&[1_u32, 3, 77])),
            (SPHERES, bytemuck::cast_slice(&spheres)),
            (GROUPS, bytemuck::cast_slice(&[5_u32, 6, 7, 8])),
            (PIXELS, bytemuck::cast_slice(&pixels)),
            (DEPTH, bytemuck::cast_slice(&[2.0f32, f32::INFINITY])),
            (SHADOW, bytemuck::cast_slice(&[1.0f32, 0.0])),
            (SMOOTH, bytemuck::cast_slice(&[0.25f32, 0.0])),
            (TONE_LAYER, bytemuck::cast_slice(&zero)),
            (OVERLAY_LAYER, bytemuck::cast_slice(&[[0.75f32, 0.25, 0.5, 0.125], [0.0; 4]])),
            (MATTE_LAYER, bytemuck::cast_slice(&[[0.125f32, 0.5, 0.25, 0.0625], [0.0; 4]])),
            (PICTURE, bytemuck::cast_slice(&zero)),
        ];
        let layers = of(LAYERS, &desc(4.0), &bytes, &zero, None, (true, &[]));
        assert_eq!(values(&layers, "smoke.spheres"), [1.0, 0.0, 1.0, 0.5, 6.0, 3.0, 0.0, 1.0, 0.5, 8.0]);
        assert_eq!(values(&layers, "smoke.luminance"), [1.0, 0.0]);
        assert_eq!(values(&layers, "smoke.id"), [7.0, 0.0]);
        assert_eq!(values(&layers, "smoke.depth"), [2.0, f32::INFINITY]);
        assert_eq!(values(&layers, "smoke.smooth"), [0.25, 0.0]);
        for (name, expected) in [
            ("smoke.cast_shadow", 0.5),
            ("smoke.rim", 0.125),
            ("smoke.matte_1", 0.125),
            ("smoke.matte_2", 0.5),
            ("smoke.matte_3", 0.25),
            ("smoke.matte_4", 0.0625),
            ("smoke.outline", 0.75),
            ("smoke.outline.silhouette", 0.25),
            ("smoke.outline.inner", 0.5),
        ] {
            assert_eq!(values(&layers, name), [expected, 0.0], "{name}");
        }
        assert_eq!(
            values(&of(LAYERS, &desc(0.0), &bytes, &zero, None, (true, &[])), "smoke.smooth"),
            [1.0, 0.0],
            "without sigma nothing is smoothed"
        );
    }
}
