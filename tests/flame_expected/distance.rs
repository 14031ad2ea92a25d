//! Fire far away, and in worlds of other scales: with the same framing it looks the same.

use celfx::flame::SceneFormat;

use crate::cases::{Case, apart, plain, rgb, settings, usual};
use crate::common::flame::FlameRig;
use crate::common::scenes;
use crate::stochastic::repeated;
use crate::table::modelled;

/// As near as the device comes to its table in f64 anywhere (`accuracy`).
const SINGLE: f64 = 1e-5;
/// Of 4 m.
const AWAY: [f64; 4] = [1.0, 250.0, 25e3, 2.5e6];

#[test]
fn the_device_integrates_its_table_from_anywhere() {
    for case in [plain(), usual()] {
        let Some(mut rig) = FlameRig::new(case.desc.clone()) else { return };
        // From the farthest, where the table is made; nearer than that it stays.
        for times in AWAY.into_iter().rev() {
            let (_, image) = modelled(&case.away(times), &mut rig);
            let [_, most] = apart(&rig.mean(), &image.mean);
            println!("{}, {times} times as far: {most:.1e} at most of what f64 makes of the same table", case.name);
            assert!(most < SINGLE, "{}, {times} times as far: {most}", case.name);
            let seen: f32 = rig.mean().iter().map(|m| m[3]).sum();
            assert!(seen > 0.005, "{}: nothing is seen", case.name);
        }
    }
}

/// Binary powers change no digit of any length, so that only constants with a length could change the picture.
#[test]
fn worlds_of_any_scale_look_the_same() {
    let Some(mut rig) = plain().embers().render() else { return };
    let one = rgb(&rig.mean());
    for times in [2.0_f32.powi(-10), 2.0_f32.powi(10), 2.0_f32.powi(18)] {
        let Some(mut rig) = plain().embers().scaled(times).render() else { return };
        let [_, most] = apart(&rig.mean(), &one);
        assert!(most < SINGLE, "{times} times as large: {most}");
    }
    let case = repeated(&plain(), 8);
    let Some(mut rig) = case.render() else { return };
    let one = rgb(&rig.mean());
    let Some(mut rig) = case.scaled(2.0_f32.powi(18)).render() else { return };
    assert_eq!(apart(&rig.mean(), &one), [0.0; 2]);
}

/// From 1 km on rays are parallel to a thousandth of a pixel. Of the render particles, so many are decided otherwise: those
/// that lie on a border of what they cover, within rounding.
#[test]
fn repetitions_draw_the_same_sprites_from_anywhere() {
    let case = repeated(&plain(), 64);
    let [mut near, mut far] = match [AWAY[1], AWAY[3]].map(|times| case.away(times).render()) {
        [Some(near), Some(far)] => [near, far],
        _ => return,
    };
    let [rms, most] = apart(&far.mean(), &rgb(&near.mean()));
    println!("repetitions: {rms:.1e} RMS, {most:.1e} at most between 1 km and 10,000 km");
    assert!(rms < 3e-3, "{rms}");
    let light = |rig: &mut FlameRig| rgb(&rig.mean()).into_iter().flatten().sum::<f64>();
    let share = light(&mut far) / light(&mut near);
    assert!((share - 1.0).abs() < 1e-3, "{share}");
}

/// A wall in the middle of the fire hides the same half of it. Its depth is a float: at 100 km, steps of 8 mm.
#[test]
fn walls_far_away_hide_what_is_behind_them() {
    let light = |depth: f32, mode: fn(&Case) -> Case| {
        let mut case = mode(&Case::new("wall", [24, 18], 60, settings(), scenes::camera(25.0)).embers().away(25e3));
        case.desc.scene = Some(SceneFormat::Buffer);
        case.depth = Some(vec![depth; 24 * 18]);
        let mut rig = case.render()?;
        Some(rgb(&rig.mean()).into_iter().flatten().sum::<f64>())
    };
    let middle = (scenes::camera(25.0).eye.length() * 25e3) as f32;
    for mode in [|case: &Case| case.clone(), |case: &Case| repeated(case, 32)] {
        let Some(before) = light(middle - 2.0, mode) else { return };
        let (Some(half), Some(all)) = (light(middle, mode), light(f32::INFINITY, mode)) else { return };
        assert!(before == 0.0 && half > 0.2 * all && half < 0.95 * all, "{before}, {half} of {all}");
    }
}
