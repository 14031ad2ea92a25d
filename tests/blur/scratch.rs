//! No frame needs what scratch memory held before it: it may be anything.

use ash::vk;
use celfx::blur::motion::{Motion, Window};
use celfx::blur::settings::{Completion, Ghosts, Lines};
use celfx::blur::{Background, DepthFormat, Desc, Mesh, Settings};
use celfx::effect::Effort;
use celfx::low_level::blur::layout;
use celfx::view::Light;

use crate::common::blur::{BlurRig, Shot, desc};
use crate::common::rig::{Bits, unaffected_by_poison};
use crate::common::scenes::random;
use crate::parts::bands;
use crate::scenes::{grid, swing};
use crate::toon::Film;

const SIDES: [u32; 2] = [7, 5];
const SIZE: [u32; 2] = [64, 48];

/// What a frame leaves for the host, and the layers if they are kept.
fn bits(rig: &mut BlurRig, moves: bool) -> Bits {
    let mut bits = Bits::default();
    bits.push("picture", &rig.picture());
    if rig.desc().depth.is_some() {
        bits.push("depth", &rig.host_depths());
        bits.push("edges", &rig.layer::<[u32; 4]>(layout::SURFACE));
    }
    if rig.desc().layers && moves {
        bits.push("subframe", &rig.layer::<u32>(layout::SUBFRAME_LAYER));
        bits.push("mask", &rig.layer::<u32>(layout::MASK_LAYER));
        bits.push("colour", &rig.layer::<[u32; 4]>(layout::COLOUR_LAYER));
        bits.push("names", &rig.layer::<u32>(layout::DISTORTED_NAMES));
        bits.push("triangles", &rig.finished());
    }
    bits
}

/// Outputs in order, of the same frames again, and of some in which nothing moves; the frames are images, or drawn.
fn frames(desc: impl Fn(&Mesh) -> Desc, poison: Option<u32>) -> Option<Vec<Bits>> {
    frames_with(desc, Effort::Needed, poison)
}

fn frames_with(desc: impl Fn(&Mesh) -> Desc, effort: Effort, poison: Option<u32>) -> Option<Vec<Bits>> {
    let (mesh, animation) = (grid(SIDES), swing(SIDES, 9, SIZE, 0.3));
    let seen = animation.all_seen();
    let desc = desc(&mesh);
    let motion = Motion::new(&desc.settings, SIZE).expect("settings");
    let (toon, outer) = (desc.toon, desc.outer);
    let mut rig = BlurRig::with_effort(desc, mesh.clone(), effort)?;
    rig.poison = poison;
    let parts = rig.desc().parts.map(|_| bands(&mesh));
    rig.parts.clone_from(&parts);
    rig.toon = toon.then(|| (Light::default(), Background::Clear([0.25, 0.5, 0.75, 1.0])));
    let picture = |key| -> Vec<[f32; 4]> {
        (0..SIZE[0] * SIZE[1]).map(|i| [random(key, i, 0), random(key, i, 1), random(key, i, 2), 1.0]).collect()
    };
    let mut all = Vec::new();
    for (number, (i, moves)) in [(2, true), (3, true), (3, true), (3, false), (4, true), (2, true)].iter().enumerate() {
        let window = Window { frame: *i as u32, poses: &animation.poses(&seen), current: *i, between: &[] };
        let interval = match &parts {
            Some(parts) => motion.interval_of_parts(&mesh, &window, parts, 1),
            None => motion.interval(&mesh, &window, 1),
        };
        let interval = interval.expect("an interval");
        if !toon {
            (0..2).for_each(|side| rig.set_image(side, &picture(*i as u32 + side as u32)));
            (0..if outer { 2 } else { 0 }).for_each(|side| rig.set_outer(side, &picture(20 + side as u32)));
        }
        let poses = (number == 0).then_some((0, &animation.poses[..]));
        let interval = moves.then_some(&interval);
        rig.frame(&Shot { poses, interval, views: animation.views(*i), knots: None }).expect("a frame");
        all.push(bits(&mut rig, *moves));
    }
    Some(all)
}

#[test]
fn frames_need_nothing_of_scratch() {
    let depth = Some(DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true });
    let base = |mesh: &_| Desc { outer: false, layers: false, ..desc(SIZE, mesh, Settings::default()) };
    unaffected_by_poison("images", |poison| frames(base, poison));
    unaffected_by_poison("images and layers", |poison| frames(|mesh| desc(SIZE, mesh, Settings::default()), poison));
    unaffected_by_poison("images and depth", |poison| frames(|mesh| Desc { depth, ..base(mesh) }, poison));
    unaffected_by_poison("drawn", |poison| frames(|mesh| Desc { toon: true, ..base(mesh) }, poison));
    unaffected_by_poison("drawn, outer, depth", |poison| {
        frames(|mesh| Desc { toon: true, outer: true, depth, ..base(mesh) }, poison)
    });
    let gradient = |mesh: &_| {
        let settings = Settings { completion: Completion::Gradient, ..Settings::default() };
        Desc { settings, outer: true, ..base(mesh) }
    };
    unaffected_by_poison("gradient", |poison| frames(gradient, poison));
    let of_parts = |mesh: &Mesh| Desc { toon: true, parts: Some(bands(mesh).sizes()), ..base(mesh) };
    unaffected_by_poison("parts", |poison| frames(of_parts, poison));
    let behind = |mesh: &_| {
        let lines = Lines { count: 3, ..Lines::default() };
        let ghosts = Ghosts { count: 2, ..Ghosts::default() };
        let settings = Settings { lines, ghosts, ..Settings::default() };
        Desc { outer: false, layers: false, ..desc(SIZE, mesh, settings) }
    };
    unaffected_by_poison("lines and ghosts", |poison| frames(behind, poison));
}

/// What is done with in a frame makes room for what comes later in it: the bits are those of an effect in which nothing does.
#[test]
fn what_lies_in_the_same_place_changes_nothing() {
    let depth = Some(DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true });
    let gradient = Settings { completion: Completion::Gradient, ..Settings::default() };
    for (toon, depth, settings) in
        [(false, None, Settings::default()), (true, depth, Settings::default()), (false, depth, gradient)]
    {
        let desc = |mesh: &_| Desc { layers: false, toon, depth, ..desc(SIZE, mesh, settings.clone()) };
        let Some(over) = frames_with(desc, Effort::Needed, None) else { return };
        let apart = frames_with(desc, Effort::Repeatable, None).expect("a device");
        for (number, (over, apart)) in over.iter().zip(&apart).enumerate() {
            assert_eq!(over.differences(apart), [], "toon {toon}, frame {number}");
        }
    }
}

/// Frames that have been drawn stay while scratch memory does not.
#[test]
fn drawn_frames_outlive_scratch() {
    let film = |poison| {
        let mut film = Film::without_layers(150, SIZE, 20..26, Settings::default(), Effort::Needed)?;
        film.rig.poison = poison;
        let mut all = vec![film.output(1, true)];
        all.extend([1, 2, 2, 3].map(|i| film.again(i)));
        let frames = all.iter().map(|picture| {
            let mut bits = Bits::default();
            bits.push("picture", picture);
            bits
        });
        Some(frames.collect())
    };
    unaffected_by_poison("a film", film);
}
