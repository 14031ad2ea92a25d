//! Which frames are drawn for an output, what is seen of them, and what lies beneath.

use celfx::blur::settings::{Completion, Ink, Mix, Toon};
use celfx::blur::{Background, Settings};
use celfx::low_level::blur::layout;
use celfx::low_level::blur::params::BASE_MASK;
use celfx::simulate::mesh::Builtin;
use celfx::toon::{Outline, Tone};
use celfx::view::Light;
use glam::{Quat, Vec3};

use crate::common::views;
use crate::scenes::Change;
use crate::toon::{Film, GREY};

/// Smears that are looked up need four frames, of which three are there of the output before; those that are drawn need two.
#[test]
fn a_frame_is_drawn_once() {
    for (ink, there, later) in [(Ink::Before, 3, 2), (Ink::After, 1, 0)] {
        let mut settings = Settings::default();
        settings.toon.ink = ink;
        let make = |settings| Film::new(Builtin::Run, 800, [128, 72], 22..28, settings, false);
        let (Some(mut film), Some(mut other)) = (make(settings.clone()), make(settings.clone())) else { return };
        let first = film.output(1, true);
        assert!(film.reasons().is_empty(), "no frame is there");
        film.output(2, true);
        assert_eq!(film.reasons(), vec!["the frame is there since an earlier output"; there]);
        let third = film.output(3, true);
        assert_eq!(film.reasons().len(), there);
        // A frame does not depend on those before it.
        assert!(other.output(3, true) == third);
        assert!(other.output(1, true) == first);
        assert_eq!(other.reasons().len(), later, "of four frames, i + 1 and i + 2 are there");
        // Another light, another drawing.
        other.set_light(Light { ambient: 0.9, ..Light::default() }, Background::Clear(GREY));
        assert!(other.output(1, true) != first && other.reasons().is_empty());
        // What stands still is the later frame, and all of it may be there.
        let still = film.output(3, false);
        assert_eq!(film.reasons(), ["the frame is there since an earlier output"]);
        let Some(mut weak) = make(Settings { strength: 0.0, ..settings }) else { return };
        assert!(weak.output(3, true) == still, "no strength is the later frame, to the bit");
        assert!(weak.output(3, false) == still && still != third);
    }
}

/// A host shows each frame through two views in turn: each picture is that of an effect that sees through one of them alone.
#[test]
fn two_views_of_each_frame() {
    let make = || Film::new(Builtin::Run, 800, [128, 72], 22..28, Settings::default(), false);
    let eyes: [Change; 2] = [|view, _| view, |view, frame| views::jittered(views::moved(view), frame)];
    let (Some(mut both), Some(mut left), Some(mut right)) = (make(), make(), make()) else { return };
    for i in 1..4 {
        for (eye, alone) in eyes.into_iter().zip([&mut left, &mut right]) {
            (both.animation.change, alone.animation.change) = (eye, eye);
            assert!(both.output(i, true) == alone.output(i, true), "frame {i}");
        }
    }
}

/// Frames that are drawn are blurred as if they were images: frames i - 1 and i + 2, too, which show what neither of the
/// others does.
#[test]
fn drawn_frames_are_those_that_images_bring() {
    let mut seen = 0;
    for i in [2, 3] {
        // Only images have lines beside the mesh, and only what they hide has to be guessed.
        let mut settings = Settings { skirt: 0.0, completion: Completion::None, ..Settings::default() };
        settings.toon.ink = Ink::Before;
        let make = || Film::new(Builtin::Crossing, 800, [192, 108], 18..26, settings.clone(), false);
        let (Some(mut film), Some(mut other)) = (make(), make()) else { return };
        film.set_light(Light::default(), Background::Keep);
        let picture = film.output(i, true);
        let frames: Vec<Vec<[f32; 4]>> = (i - 2..=i + 1).map(|frame| film.output(frame, false)).collect();
        other.rig.toon = None;
        other.rig.set_image(0, &frames[1]);
        other.rig.set_image(1, &frames[2]);
        let inner = other.output(i, true);
        other.rig.set_outer(0, &frames[0]);
        other.rig.set_outer(1, &frames[3]);
        assert!(other.output(i, true) == picture, "frame {i}");
        seen += (0..picture.len()).filter(|pixel| inner[*pixel] != picture[*pixel]).count();
        // After another one, with three of its frames already there.
        film.output(i - 1, true);
        assert!(film.output(i, true) == picture && film.reasons().len() == 3, "frame {i}: {:?}", film.reasons());
    }
    eprintln!("{seen} pixels see frames i - 1 and i + 2");
    assert!(seen > 0, "frames i - 1 and i + 2 are needed somewhere");
}

/// What frames i and i + 1 both hide has the colour that frame i - 1 or i + 2 shows of it.
#[test]
fn what_is_hidden_is_that_of_the_frames_around() {
    for side in [0, 1] {
        let Some(mut film) = Film::new(Builtin::Crossing, 800, [192, 108], 18..26, Settings::default(), false) else {
            return;
        };
        film.rig.toon = None;
        let of = |colour: [f32; 4]| vec![colour; 192 * 108];
        film.rig.set_image(0, &of([0.0, 0.0, 1.0, 1.0]));
        film.rig.set_image(1, &of([0.0, 0.0, 1.0, 1.0]));
        film.rig.set_outer(side, &of([1.0, 0.0, 0.0, 1.0]));
        let mut red = 0;
        for i in [2, 3, 4] {
            let picture = film.output(i, true);
            let masks: Vec<u32> = film.rig.layer(layout::MASK_LAYER);
            for (colour, mask) in picture.iter().zip(&masks) {
                // Of four samples three, or all: the centre is one of these.
                assert!(colour[0] < 0.76 || *mask == 0, "{colour:?}, {mask}");
                red += usize::from(colour[0] > 0.2 && colour[0] + colour[2] < 1.001);
            }
        }
        assert!(red > 0, "side {side} is seen somewhere");
    }
}

/// A bar that turns behind another one, or behind nothing: in some outputs each pixel's colour, which of the two frames show
/// its centre, and whether that is of this bar.
fn turning_bar(completion: Completion, is_hidden: bool) -> Option<Vec<([f32; 4], u32, bool)>> {
    // So many tones that each turn shows, and no ink.
    let tone = |i: u8| Tone::new(f32::from(i) / 64.0, [f32::from(i) / 64.0; 3]);
    let outline = Outline { strength: 0.0, ..Outline::default() };
    let toon = Toon { outline, ink: Ink::Before, tones: (0..64).map(tone).collect() };
    let settings = Settings { completion, toon, skirt: 0.0, mix: Mix::Blend, ..Settings::default() };
    let mut film = Film::new(Builtin::Crossing, 800, [320, 180], 14..30, settings, false)?;
    for (frame, pose) in film.animation.poses.iter_mut().enumerate() {
        let rear: Vec<usize> = (0..pose.len()).filter(|point| pose[*point][2] < 0.0).collect();
        let middle = rear.iter().map(|point| Vec3::from_array(pose[*point])).sum::<Vec3>() / rear.len() as f32;
        let turn = Quat::from_rotation_x(0.4 * frame as f32);
        for (point, place) in pose.iter_mut().enumerate() {
            if rear.binary_search(&point).is_ok() {
                *place = (middle + turn * (Vec3::from_array(*place) - middle)).to_array();
            } else if !is_hidden {
                place[1] += 100.0;
            }
        }
    }
    let is_rear: Vec<bool> =
        film.mesh.triangles().iter().map(|corners| film.animation.poses[0][corners[0] as usize][2] < 0.0).collect();
    let output = |i| {
        let picture = film.output(i, true);
        let names: Vec<u32> = film.rig.layer(layout::DISTORTED_NAMES);
        let masks: Vec<u32> = film.rig.layer(layout::MASK_LAYER);
        let finished = film.rig.finished();
        let of_rear = |name: u32| name > 0 && is_rear[(finished[name as usize - 1][3] & BASE_MASK) as usize];
        let seen: Vec<bool> = names.into_iter().map(of_rear).collect();
        // With all that is around it: other pixels have other things mixed in.
        let beside = [0, 1, 2, 320, 321, 322, 640, 641, 642];
        let is_inner = |pixel: usize| beside.iter().all(|way| seen.get((pixel + way).wrapping_sub(321)) == Some(&true));
        let own: Vec<bool> = (0..seen.len()).map(is_inner).collect();
        picture.into_iter().zip(masks).zip(own).map(|((colour, mask), own)| (colour, mask, own)).collect::<Vec<_>>()
    };
    Some([3, 5, 7, 12].map(output).concat())
}

/// What one frame hides has the colour that it would have if nothing hid it.
#[test]
fn what_drawn_frames_hide_is_drawn() {
    let Some(truth) = turning_bar(Completion::Surface, false) else { return };
    let errors = [Completion::Surface, Completion::None].map(|completion| {
        let hidden = turning_bar(completion, true).expect("a device");
        let both = hidden
            .iter()
            .zip(&truth)
            .filter(|((_, mask, own), (_, shown, alone))| *own && *alone && matches!(mask, 1 | 2) && *shown == 3);
        let off = |a: &[f32; 4], b: &[f32; 4]| (0..3).map(|i| f64::from((a[i] - b[i]).abs())).sum::<f64>();
        let mut all: Vec<f64> = both.map(|((colour, _, _), (alone, _, _))| off(colour, alone)).collect();
        assert!(all.len() > 100, "{} pixels are hidden in one frame", all.len());
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    });
    // The median: look-ups mix what is beside a border, and beside the occluder they have fewer taps.
    assert!(errors[0] < 0.25 * errors[1], "{errors:?}");
}

#[test]
fn a_background_can_be_an_image() {
    let make = || Film::new(Builtin::Crossing, 800, [128, 72], 22..26, Settings::default(), false);
    let (Some(mut film), Some(mut other)) = (make(), make()) else { return };
    // An image of one colour is that colour, drawn or given.
    let expected = film.output(1, true);
    other.rig.set_backdrop(&vec![GREY; 128 * 72]);
    assert!(other.output(1, true) == expected);
    for film in [&mut film, &mut other] {
        film.rig.set_image(0, &vec![[0.2, 0.3, 0.4, 1.0]; 128 * 72]);
        film.rig.set_image(1, &vec![[0.2, 0.3, 0.4, 1.0]; 128 * 72]);
    }
    // What is under frames is no part of them: they are not drawn again.
    let picture: Vec<[f32; 4]> =
        (0..128 * 72).map(|i| [0, 1, 2, 3].map(|c| crate::common::scenes::random(8, i, c))).collect();
    other.rig.set_backdrop(&picture);
    let still = other.output(1, false);
    let seen = (0..picture.len()).filter(|pixel| still[*pixel] == picture[*pixel]).count();
    assert!(seen > 128 * 72 / 3 && still[0] == picture[0], "{seen}");
    let moved = other.output(1, true);
    let seen = (0..picture.len()).filter(|pixel| moved[*pixel] == picture[*pixel]).count();
    assert!(seen > 128 * 72 / 3 && other.reasons().len() == 2, "{seen}");
}

#[test]
fn order_changes_nothing() {
    let make = |turned| Film::new(Builtin::Crossing, 800, [128, 72], 22..26, Settings::default(), turned);
    let (Some(mut film), Some(mut other)) = (make(false), make(true)) else { return };
    assert!(film.output(1, false) == other.output(1, false));
}

#[test]
fn without_a_background_there_is_nothing_behind() {
    let Some(mut film) = Film::new(Builtin::Spin, 800, [128, 72], 0..4, Settings::default(), false) else { return };
    film.set_light(Light::default(), Background::Keep);
    let picture = film.output(1, false);
    let empty = picture.iter().filter(|colour| **colour == [0.0; 4]).count();
    assert!(empty > 128 * 72 / 3 && picture[0] == [0.0; 4]);
    let partial = |c: &&[f32; 4]| c[3] > 0.0 && c[3] < 1.0;
    assert!(picture.iter().filter(partial).count() > 50, "edges are antialiased");
}
