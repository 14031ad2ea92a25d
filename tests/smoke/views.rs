//! Smoke through every kind of projection, against the reference.

use celfx::low_level::smoke::layout;
use celfx::offline::Scene;
use celfx::smoke::{Sequence, Settings};

use crate::common::rig::{Rig, scene};
use crate::common::scenes::{camera, direction, drawn, moving_puffs};
use crate::common::{apart, views};

const SIZE: [u32; 2] = [120, 90];

#[test]
fn smoke_is_that_of_the_reference_through_any_projection() {
    let settings = Settings { particles: 300, ..Settings::default() };
    let Some(mut rig) = Rig::new(drawn(SIZE, [32; 3], settings)) else { return };
    let (light, camera) = (direction(-1.0, -1.5, -1.0), camera(24.0));
    let volume = moving_puffs(32, 0.3);
    for (name, view) in views::of(&camera, SIZE, camera.eye.length()) {
        let frame = scene(Sequence::Restart, camera, light, Some(&volume));
        rig.frame(&Scene { view: Some(view), ..frame });
        let expected = rig.expected(&view, &light, volume.voxel_size[0]);
        let picture = rig.picture();
        let depth = rig.layer(layout::DEPTH);
        let seen = expected.image.iter().filter(|c| c[3] > 0.0).count();
        let differs = |i: usize| (0..4).any(|c| apart(picture[i][c], expected.image[i][c]) > 1.0 / 255.0);
        let differing = (0..picture.len()).filter(|i| differs(*i)).count();
        // At silhouettes depth is off by up to a root of rounding.
        let deeper = |i: usize| {
            let (found, exact) = (f64::from(depth[i]), expected.depth[i]);
            found != exact && (found.is_finite() != exact.is_finite() || (found - exact).abs() >= 1e-4 * exact)
        };
        let off = (0..depth.len()).filter(|i| deeper(*i)).count();
        println!("{name}: of {seen} pixels {differing} differ by more than 1/255, and {off} in depth");
        // The specification's 0.1 % of pixels, on borders where rounding decides.
        assert!(seen > 1000 && differing <= seen / 500 && off <= seen / 500, "{name}: {differing}, {off} of {seen}");
    }
}
