//! A host of the blur: other sizes and formats, frames in flight.

use ash::vk;
use celfx::blur::settings::Completion;
use celfx::blur::{Background, Settings};
use celfx::effect::Effort;
use celfx::simulate::mesh::Builtin;
use celfx::view::Light;

use crate::common::blur::{SLOTS, Shot};
use crate::common::scenes::random;
use crate::toon::Film;

const SIZE: [u32; 2] = [128, 72];

fn film(size: [u32; 2]) -> Option<Film> {
    Film::new(Builtin::Run, 800, size, 20..28, Settings::default(), false)
}

#[test]
fn another_size_is_another_effect() {
    let Some(mut film) = film(SIZE) else { return };
    let first = film.output(2, true);
    let other = [90, 110];
    film.rig.resize(other);
    film.animation.size = other;
    let resized = film.again(2);
    let mut fresh = self::film(other).expect("a device");
    assert!(resized == fresh.output(2, true));
    film.rig.resize(SIZE);
    film.animation.size = SIZE;
    assert!(film.again(2) == first && first != resized);
}

/// A second mesh is smeared over the picture of the first.
#[test]
fn two_blurs_in_one_picture() {
    let settings = Settings::default;
    let Some(mut first) = Film::new(Builtin::Run, 800, SIZE, 20..28, settings(), false) else { return };
    let other = || Film::new(Builtin::Crossing, 600, SIZE, 4..12, settings(), false).expect("a device");
    let under = first.output(2, true);
    let mut alone = other();
    alone.set_light(Light::default(), Background::Clear([0.0; 4]));
    let alone = alone.output(3, true);
    let mut second = other();
    second.rig.set_backdrop(&under);
    let both = second.output(3, true);
    let mut mixed = 0;
    for ((both, over), under) in both.iter().zip(&alone).zip(&under) {
        mixed += usize::from(over[3] > 0.0 && over[3] < 1.0);
        for c in 0..4 {
            // Four samples are each blended and rounded.
            let expected = over[c] + (1.0 - over[3]) * under[c];
            assert!((both[c] - expected).abs() < 4e-6, "{both:?}: {over:?} over {under:?}");
        }
    }
    assert!(mixed > 50 && both != under && both != alone, "{mixed} pixels of both");
}

/// Each frame has a slot's buffers and images, and is begun before the one before it has ended.
#[test]
fn frames_in_flight_are_those_that_are_waited_for() {
    let Some(mut film) = film(SIZE) else { return };
    let waited: Vec<_> = (1..6).map(|i| film.output(i, true)).collect();
    let mut other = self::film(SIZE).expect("a device");
    let intervals: Vec<_> = (1..6).map(|i| other.interval(i)).collect();
    let poses = other.animation.poses.clone();
    let (mut on_their_way, mut found) = (std::collections::VecDeque::new(), Vec::new());
    for (n, interval) in intervals.iter().enumerate() {
        other.rig.slot = n % SLOTS;
        if on_their_way.len() == SLOTS {
            other.rig.wait(on_their_way.pop_front().expect("a submission"));
            found.push(other.rig.picture());
        }
        let poses = (n == 0).then_some((0, &poses[..]));
        let shot = Shot { poses, interval: Some(interval), views: other.animation.views(n + 1), knots: None };
        on_their_way.push_back(other.rig.start(&shot));
    }
    for n in intervals.len() - SLOTS..intervals.len() {
        other.rig.wait(on_their_way.pop_front().expect("a submission"));
        other.rig.slot = n % SLOTS;
        found.push(other.rig.picture());
    }
    assert!(found == waited);
}

/// Targets of 8 bits have the picture of floats to a step, whether their frames are drawn or images.
#[test]
fn targets_of_eight_bits_are_floats_rounded() {
    for format in [vk::Format::R8G8B8A8_SRGB, vk::Format::R8G8B8A8_UNORM] {
        let Some(mut exact) = film(SIZE) else { return };
        let mut rounded = Film::with_format(Builtin::Run, 800, SIZE, 20..28, format).expect("a device");
        for film in [&mut exact, &mut rounded] {
            film.set_light(Light::default(), Background::Clear([0.1, 0.2, 0.3, 1.0]));
        }
        let (exact, rounded) = (exact.output(2, true), rounded.output(2, true));
        // Frames are rounded, and what is made of them: a step each, and half of one where both are mixed. A step of
        // sRGB is up to 1 / 115 of linear light.
        let step = if format == vk::Format::R8G8B8A8_UNORM { 1.0 / 255.0 } else { 1.0 / 115.0 };
        let off = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
        let worst = exact.iter().zip(&rounded).map(off).fold(0.0, f32::max);
        eprintln!("{format:?}: {worst:.4}");
        assert!(worst <= 1.5 * step, "{format:?}: {worst}");
    }
}

/// Where only the far sides of closed objects are left out, nothing changes.
#[test]
fn culling_changes_nothing() {
    let Some(mut film) = Film::new(Builtin::Spin, 800, SIZE, 2..8, Settings::default(), false) else { return };
    let picture = film.output(2, true);
    let culled =
        film.rig.finished().iter().filter(|triangle| triangle[3] & celfx::low_level::blur::params::CULLED != 0).count();
    assert!(culled > 50, "{culled} triangles are culled");
    let mut open = Film::new(Builtin::Spin, 800, SIZE, 2..8, Settings::default(), false).expect("a device");
    open.rig.are_closed = false;
    let whole = open.output(2, true);
    assert!(open.rig.finished().iter().all(|triangle| triangle[3] & celfx::low_level::blur::params::CULLED == 0));
    let differing = (0..picture.len()).filter(|pixel| picture[*pixel] != whole[*pixel]).count();
    // Where it is smeared, a few of what faces away in both frames is turned over at the outline.
    assert!(differing <= picture.len() / 100, "{differing} pixels");
}

/// Tiles without the mesh are left out, and frames that are there are not drawn again: to the bit nothing changes by it,
/// whatever reaches over the mesh's outline, and however bright what is beside it is.
#[test]
fn skipping_changes_nothing() {
    let usual = Settings::default();
    let all = [
        Settings { strength: 2.0, skirt: 9.5, ..usual.clone() },
        Settings { completion: Completion::Gradient, ..usual.clone() },
        Settings { completion: Completion::None, skirt: 0.0, ..usual.clone() },
        usual,
    ];
    for settings in all {
        // Tiles that are not whole at the right and at the bottom.
        let size = [154, 93];
        let make = |effort| Film::without_layers(800, size, 18..26, settings.clone(), effort);
        let (Some(mut film), Some(mut whole)) = (make(Effort::Needed), make(Effort::Everything)) else { return };
        for i in 1..4 {
            assert!(film.output(i, true) == whole.output(i, true), "drawn, {settings:?}");
        }
        for frame in 0..2 {
            let channel = |at: u32, c: u32| random(20 + frame, at, c) * if c < 3 { 4.0 } else { 1.0 };
            let image: Vec<_> = (0..size[0] * size[1]).map(|at| [0, 1, 2, 3].map(|c| channel(at, c))).collect();
            for film in [&mut film, &mut whole] {
                film.rig.toon = None;
                film.rig.set_image(frame as usize, &image);
            }
        }
        let (picture, expected) = (film.output(2, true), whole.output(2, true));
        assert!(picture == expected, "images, {settings:?}");
    }
}
