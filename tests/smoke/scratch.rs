//! No frame needs what scratch memory held before it: it may be anything.

use celfx::data::Volume;
use celfx::low_level::smoke::layout;
use celfx::smoke::settings::{Grow, Shadow};
use celfx::smoke::{Desc, Sequence, Settings};

use crate::common::rig::{Bits, Rig, scene, unaffected_by_poison};
use crate::common::scenes::{camera, desc, direction, moving_puffs, of_voxels, point, puffs};

/// All of each frame; of one that keeps no layers, its picture and depth. Volumes come where they change, holds and frames that
/// are not rendered stand between, and the light changes and comes back.
fn frames(desc: &Desc, poison: Option<u32>) -> Option<Vec<Bits>> {
    use Sequence::{Advance, Again, Hold, Restart};
    let volume = |time| if desc.velocity { moving_puffs(16, time) } else { puffs(16, time) };
    let (a, b): (Volume, Volume) = (volume(0.0), volume(1.0));
    let lights = match desc.point_light {
        true => [point(1.5, 2.0, 1.0), point(-1.0, 2.0, 1.5)],
        false => [direction(-1.0, -1.5, -1.0), direction(1.0, -0.2, 0.1)],
    };
    let steps = [
        (Restart, 0.0, 0, Some(&a), true),
        (Advance, 0.0, 0, None, true),
        (Advance, 0.0, 0, None, false),
        (Advance, 0.0, 0, None, true),
        (Advance, 40.0, 0, None, true),
        (Advance, 40.0, 1, None, true),
        (Again, 20.0, 1, None, true),
        (Hold, 0.0, 1, None, true),
        (Hold, 0.0, 0, Some(&b), true),
        (Hold, 40.0, 0, None, true),
        (Advance, 0.0, 0, None, true),
        (Restart, 0.0, 1, None, true),
        (Advance, 0.0, 1, None, true),
    ];
    let mut rig = Rig::new(desc.clone())?;
    rig.poison = poison;
    let frames = steps.iter().map(|(sequence, degrees, light, volume, rendered)| {
        let mut scene = scene(*sequence, camera(*degrees), lights[*light], *volume);
        scene.rendered = *rendered;
        rig.frame(&scene);
        match desc.layers {
            true => rig.bits(),
            false => {
                let mut bits = Bits::default();
                bits.push("picture", &rig.picture());
                bits.push("depth", &rig.layer(layout::DEPTH));
                bits
            }
        }
    });
    Some(frames.collect())
}

#[test]
fn frames_need_nothing_of_scratch() {
    let with = |settings: Settings| Settings { particles: 120, shadow_map: 128, ..settings };
    let base = desc([70, 52], [16; 3], with(Settings { fade: 2, ..Settings::default() }));
    let map = with(Settings { shadow: Shadow::Map, fade: 0, ..Settings::default() });
    let mortal = with(Settings { lifetime: Some(4), grow: Grow::Pyramid, ..of_voxels() });
    let plain = with(Settings { shadow: Shadow::None, sigma: 0.0, grow: Grow::Growth, ..of_voxels() });
    let cases = [
        base.clone(),
        Desc { layers: false, ..base.clone() },
        Desc { settings: map.clone(), ..base.clone() },
        Desc { layers: false, point_light: true, settings: map, ..base.clone() },
        Desc { velocity: true, point_light: true, settings: mortal.clone(), ..base.clone() },
        Desc { layers: false, velocity: true, settings: mortal, ..base.clone() },
        Desc { layers: false, settings: plain, ..base },
    ];
    for desc in cases {
        unaffected_by_poison(&format!("{desc:?}"), |poison| frames(&desc, poison));
    }
}
