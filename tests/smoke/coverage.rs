//! Shares of pixels that smoke covers, against the reference.

use celfx::smoke::settings::{Antialias, Radius};
use celfx::smoke::{Sequence, Settings};
use celfx::view::Camera;

use crate::common::apart;
use crate::common::rig::{Rig, scene};
use crate::common::scenes::{camera, direction, drawn, moving_puffs};

/// Odd sides, so that the last tiles are cut.
const SIZE: [u32; 2] = [203, 131];

fn settings() -> Settings {
    Settings { particles: 300, ..Settings::default() }
}

#[test]
fn coverage_is_that_of_the_reference() {
    let near = camera(24.0);
    let way = near.eye - near.target;
    let cases = [
        ("as it is", settings(), near),
        (
            "most spheres are less than a pixel",
            Settings { particles: 4000, scale: 0.04, smallest: 0.0, ..settings() },
            near,
        ),
        ("balls beyond the picture", Settings { radius: Radius::Ball, scale: 3.0, ..settings() }, near),
        ("a wide view", settings(), Camera { eye: near.target + 0.35 * way, vertical_fov: 130.0, ..near }),
        ("from far away", settings(), Camera { eye: near.target + 1e4 * way, vertical_fov: 0.004, far: 1e6, ..near }),
        ("from within", settings(), Camera { eye: near.target + 0.1 * way, near: 0.05, ..near }),
        ("cut by the near plane", settings(), Camera { near: way.length() - 0.1, ..near }),
    ];
    let (light, volume) = (direction(-1.0, -1.5, -1.0), moving_puffs(32, 0.3));
    for (name, settings, camera) in cases {
        let Some(mut rig) = Rig::new(drawn(SIZE, [32; 3], settings)) else { return };
        rig.frame(&scene(Sequence::Restart, camera, light, Some(&volume)));
        let expected = rig.expected(&camera.view(SIZE), &light, volume.voxel_size[0]);
        let picture = rig.picture();
        let in_part = expected.image.iter().filter(|c| c[3] > 0.0 && c[3] < 1.0).count();
        let outside = expected.image.iter().zip(&expected.depth).filter(|(c, z)| c[3] > 0.0 && z.is_infinite()).count();
        let off = (0..picture.len()).filter(|i| apart(picture[*i][3], expected.image[*i][3]) > 1e-3).count();
        println!("{name}: {in_part} pixels in part, {outside} of them beside what is seen, {off} off");
        assert!(in_part > 100 && outside > 30, "{name}: {in_part}, {outside}");
        // An outline is known to some 1e-4 pixels from 1e-7 of its distance. Where rounding decides which pixels see
        // a sphere, another one may count.
        assert!(off <= 1 + in_part / 100, "{name}: {off} of {in_part}");
    }
}

#[test]
fn without_coverage_pixels_have_smoke_or_not() {
    let (light, volume) = (direction(-1.0, -1.5, -1.0), moving_puffs(32, 0.3));
    let hard = Settings { antialias: Antialias::None, ..settings() };
    let Some(mut rig) = Rig::new(drawn(SIZE, [32; 3], hard)) else { return };
    rig.frame(&scene(Sequence::Restart, camera(24.0), light, Some(&volume)));
    let hard = rig.picture();
    let Some(mut rig) = Rig::new(drawn(SIZE, [32; 3], settings())) else { return };
    rig.frame(&scene(Sequence::Restart, camera(24.0), light, Some(&volume)));
    for (hard, soft) in hard.iter().zip(rig.picture()) {
        assert!(hard[3] == 0.0 || hard[3] == 1.0);
        // Where all of a pixel has smoke, its colour is the same to the bit; and where its middle has, it has at least half.
        assert!(soft[3] < 1.0 || *hard == soft);
        assert!(if hard[3] == 1.0 { soft[3] >= 0.5 } else { soft[3] <= 0.5 });
    }
}
