//! The examples run under validation, and what they make is right.
#![cfg(feature = "cli")]

mod common;
#[path = "../examples/embed.rs"]
#[allow(dead_code, reason = "its main is not called")]
mod embed;
#[path = "../examples/engine.rs"]
#[allow(dead_code, reason = "its main is not called")]
mod engine;

use celfx::profile::Clock;
use celfx::smoke::Settings;

use embed::{Slot, render};

/// Linear light as an sRGB byte.
fn srgb(v: f32) -> u8 {
    let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}

#[test]
fn smoke_in_a_host_of_its_own() {
    let Some(mut device) = common::device() else { return };
    let mut slots = [Slot::new(&mut device).expect("a slot"), Slot::new(&mut device).expect("a slot")];
    let mut smoke = render(&mut device, &mut slots, 7).expect("frames");
    for slot in &mut slots {
        slot.wait(&mut device).expect("the last frames end");
    }
    assert_eq!((slots[0].pictures.len(), slots[1].pictures.len()), (4, 3));
    assert!((1..=smoke.most_steps()).contains(&(smoke.plan().steps.len() as u32)));
    // 0.2, 0.5 and 0.9 as sRGB.
    let sky = [124, 188, 243, 255];
    for picture in slots.iter().flat_map(|slot| &slot.pictures) {
        let over = picture.iter().filter(|c| **c != sky).count();
        assert!(over > 800 && over < picture.len() / 2, "{over} pixels of smoke");
        // Ink, and the darker tones of the default ones, as sRGB; few smoothed pixels reach the brightest.
        assert!(picture.contains(&[0, 0, 0, 255]));
        for tone in Settings::default().tones.into_iter().take(2) {
            let [r, g, b] = tone.colour.map(srgb);
            let near = |c: &&[u8; 4]| c[0].abs_diff(r) <= 1 && c[1].abs_diff(g) <= 1 && c[2].abs_diff(b) <= 1;
            assert!(picture.iter().find(near).is_some(), "no {tone:?}");
        }
    }
    let properties = {
        let host = device.host();
        // SAFETY: valid handles.
        unsafe { host.instance.get_physical_device_properties(host.physical_device) }
    };
    if let Some(mut clock) = Clock::new(64, properties.limits.timestamp_period) {
        for ticks in slots.iter().flat_map(|slot| &slot.ticks) {
            assert!(!ticks.is_empty() && ticks.len() % 2 == 0);
            let times: Vec<u64> = ticks.iter().map(|tick| clock.nanoseconds(*tick)).collect();
            assert!(times.chunks(2).all(|step| step[0] <= step[1]), "a step ends after it begins: {times:?}");
        }
    }
    slots.iter_mut().for_each(|slot| slot.destroy(&mut device));
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe { smoke.destroy(&host, allocator) };
}

/// The README shows the part between the marks word for word.
#[test]
fn the_readme_shows_this_host() {
    let source = include_str!("../examples/embed.rs");
    let (_, rest) = source.split_once("    // README begin\n").expect("the first mark");
    let (shown, _) = rest.split_once("    // README end").expect("the second mark");
    let lines: Vec<&str> = shown.lines().map(|line| line.strip_prefix("    ").unwrap_or(line)).collect();
    assert!(include_str!("../README.md").contains(&lines.join("\n")), "README.md shows an older examples/embed.rs");
}

/// A box, smoke and fire in one picture, which the renderer's own wall hides.
#[test]
fn an_engine_has_all_effects() {
    let Some(mut device) = common::device() else { return };
    let (pixels, size) = engine::render(&mut device).expect("frames");
    assert_eq!((size, pixels.len()), ([400, 225], 4 * 400 * 225));
    let count = |is: &dyn Fn(usize, [u8; 3]) -> bool| {
        let pixels = pixels.chunks_exact(4).enumerate();
        pixels.filter(|(i, c)| is(i % 400, [c[0], c[1], c[2]])).count()
    };
    let near = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 1);
    // 0.55, 0.7, 0.9 and 0.45, 0.35, 0.3.
    let (sky, wall) = ([140, 179, 230], [115, 89, 77]);
    let is_wall = |x: usize| (250..300).contains(&x);
    assert_eq!(count(&|x, c| is_wall(x) && near(c, wall)), 50 * 225, "nothing is before the wall");
    assert!(count(&|_, c| near(c, sky)) > 50_000);
    let orange = count(&|_, [r, g, b]| r > 200 && (100..150).contains(&g) && b < 80);
    let (grey, fire) = (
        count(&|_, [r, g, b]| r.abs_diff(g) < 20 && b > r && b - r < 60 && r < 200),
        count(&|x, [r, g, _]| x < 160 && r > g && r > 60),
    );
    assert!(orange > 1000 && grey > 500 && fire > 200, "{orange} of the box, {grey} of smoke, {fire} of fire");
}
