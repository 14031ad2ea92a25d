//! Which of several ways a device takes changes no bit: how many invocations share a tile, which kernels look the mask up, and
//! whether lists are cut into parts.

use celfx::data::Particles;
use celfx::flame::settings::{Mode, Sampling, Shape};
use celfx::flame::{Desc, SceneFormat, Settings};
use celfx::offline::Scene;

use crate::common::flame::{FlameRig, ball, desc, scene};
use crate::common::rig::Bits;
use crate::common::scenes::camera;
use crate::determinism::bits;

/// No tile of it is whole.
const SIZE: [u32; 2] = [41, 23];

/// The frame in every way: each is like the first.
fn compare(name: &str, desc: &Desc, scene: &Scene) {
    let mut first: Option<Bits> = None;
    for (tile_invocations, mask_kernels, ends_loops) in [(32, 2, true), (64, 1, false), (128, 2, false), (256, 1, true)]
    {
        let rig = FlameRig::fitted(desc.clone(), |traits| {
            traits.tuning.tile_invocations = tile_invocations;
            traits.tuning.mask_kernels = mask_kernels;
            traits.ends_loops = ends_loops;
        });
        let Some(mut rig) = rig else { return };
        rig.render(scene);
        let found = bits(&mut rig);
        match &first {
            Some(first) => {
                let differences = first.differences(&found);
                assert_eq!(differences, [], "{name}: {tile_invocations} invocations, {mask_kernels} kernels");
            }
            None => first = Some(found),
        }
    }
}

fn base() -> Settings {
    Settings { repetitions: 9, count: 6.0, spread: Some(0.15), size: Some(0.25), ..Settings::paper() }
}

#[test]
fn repetitions_have_the_same_bits_in_every_shape() {
    let given = ball(120, 2);
    let wall: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(|i| if i % SIZE[0] < 20 { 1.0 } else { 4.2 }).collect();
    let magnified = Settings { size: Some(1.5), ..base() };
    let sobol = Settings { sampling: Sampling::ShuffledSobol, shape: Shape::Cube, flicker: 0.4, ..base() };
    let adaptive = Settings { adaptive: 0.05, repetitions: 64, ..base() };
    let sparse = Settings { count: 0.3, threshold: 0.9, alpha_scale: 1.5, ..base() };
    for (name, settings) in [
        ("minified", base()),
        ("magnified", magnified),
        ("sobol points in a cube", sobol),
        ("stages", adaptive),
        ("few sprites", sparse),
    ] {
        let desc = Desc { scene: (name == "minified").then_some(SceneFormat::Buffer), ..desc(SIZE, 120, settings) };
        let depth = desc.scene.map(|_| wall.as_slice());
        compare(name, &desc, &Scene { depth, ..scene(Some(&given), camera(10.0)) });
    }
}

#[test]
fn the_expected_image_has_the_same_bits_in_every_shape() {
    let given = ball(120, 3);
    let wall: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(|i| if i % SIZE[0] < 20 { 1.0 } else { 4.2 }).collect();
    let expected = Settings { mode: Mode::Expected, bins: 12, ..base() };
    let narrow = Settings { spread: Some(0.002), size: Some(0.004), ..expected.clone() };
    for (name, settings) in [("expected", expected.clone()), ("narrow", narrow), ("behind a wall", expected)] {
        let is_walled = name == "behind a wall";
        let desc = Desc { scene: is_walled.then_some(SceneFormat::Buffer), ..desc(SIZE, 120, settings) };
        let depth = is_walled.then_some(wall.as_slice());
        compare(name, &desc, &Scene { depth, ..scene(Some(&given), camera(-20.0)) });
    }
}

/// Lists so long that drivers that end loops have them in parts; in one part they are still within what lavapipe does.
#[test]
fn parts_of_lists_change_nothing() {
    let given = cloud();
    let small = Settings { spread: Some(0.01), size: Some(0.03), repetitions: 2, ..base() };
    let stochastic = Settings { count: 1.6, threshold: 0.3, alpha_scale: 1.0, ..small.clone() };
    compare("repetitions", &desc([16, 16], 11_000, stochastic), &scene(Some(&given), camera(0.0)));
    let expected = Settings { mode: Mode::Expected, bins: 4, ..small };
    compare("bins", &desc([16, 16], 11_000, expected), &scene(Some(&given), camera(0.0)));
}

/// Small ones side by side.
fn cloud() -> Particles {
    let mut cloud = ball(11_000, 4);
    cloud.position.iter_mut().flatten().for_each(|x| *x *= 0.8);
    cloud
}
