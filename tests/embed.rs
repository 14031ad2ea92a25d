//! The README's host, `examples/embed.rs`: it runs under validation, and what it makes is right.
#![cfg(feature = "cli")]

mod common;
#[path = "../examples/embed.rs"]
#[allow(dead_code, reason = "its main is not called")]
mod embed;

use celfx::profile::Clock;
use celfx::smoke::Settings;

use embed::{MOST_STEPS, Slot, render};

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
    assert!(smoke.plan().steps.capacity() as u32 <= MOST_STEPS);
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
