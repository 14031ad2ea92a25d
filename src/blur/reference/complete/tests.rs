use super::gradient::{hsv, hue_difference, predict, rgb};
use super::table::{bin, filled, quantised, scale};
use super::*;
use crate::blur::params;
use crate::blur::reference::distort::Fragment;
use crate::blur::reference::visible::rig::{Rig, Square};
use crate::blur::reference::visible::{mix, shade};

/// Bins of a table, and along each of its sides.
const ALL_BINS: usize = params::BINS as usize;
const SIDE_BINS: usize = params::SIDE as usize;

fn close(a: Colour, b: Colour, tolerance: f64) -> bool {
    (0..4).all(|i| (a[i] - b[i]).abs() <= tolerance)
}

fn grey(value: f64) -> Colour {
    [value, value, value, 1.0]
}

#[test]
fn every_bin_holds_the_normal_at_its_centre() {
    for place in 0..ALL_BINS {
        let [x, y] = [place % SIDE_BINS, place / SIDE_BINS].map(|c| (c as f64 + 0.5) / SIDE_BINS as f64 * 2.0 - 1.0);
        let z = 1.0 - x.abs() - y.abs();
        let unfolded = if z < 0.0 { [(1.0 - y.abs()) * x.signum(), (1.0 - x.abs()) * y.signum()] } else { [x, y] };
        assert_eq!(bin([unfolded[0] * 3.0, unfolded[1] * 3.0, z * 3.0]), Some(place));
    }
    assert_eq!(bin([0.0, 0.0, 1.0]), Some(16 * 32 + 16));
    assert_eq!(bin([0.0, 0.0, -1.0]), Some(31 * 32 + 31));
    assert_eq!(bin([-2.0, 0.0, 0.0]), Some(16 * 32));
    assert_eq!([bin([0.0; 3]), bin([f64::NAN, 0.0, 1.0]), bin([f64::INFINITY, 0.0, 1.0])], [None; 3]);
}

#[test]
fn one_bin_fills_all_and_full_ones_stay() {
    for place in [0, 31, 500, 1023] {
        let mut bins = vec![None; ALL_BINS];
        bins[place] = Some([7, 65_535, 1, 30_000]);
        assert_eq!(filled(&bins), Some(vec![[7, 65_535, 1, 30_000]; ALL_BINS]));
    }
    assert_eq!(filled(&vec![None; ALL_BINS]), None);
    let all: Vec<Option<[u32; 4]>> = (0..ALL_BINS as u32).map(|i| Some([i, 2 * i, 3 * i, 4 * i])).collect();
    assert_eq!(filled(&all), all.iter().copied().collect());
}

#[test]
fn an_empty_bin_takes_sixteenths_of_those_above() {
    // One bin of each four is filled, so the level above is `f`.
    let f = |x: u32, y: u32| 1000 * x + 3 * y * y;
    let with = |odd: u32| {
        let mut bins = vec![None; ALL_BINS];
        for (x, y) in (0..256).map(|i| (i % 16, i / 16)) {
            bins[(2 * y + odd) as usize * SIDE_BINS + (2 * x + odd) as usize] = Some([f(x, y); 4]);
        }
        filled(&bins).unwrap()
    };
    let mixed = |own: u32, in_x: u32, in_y: u32, in_both: u32| [(9 * own + 3 * in_x + 3 * in_y + in_both + 8) / 16; 4];
    let (even, odd) = (with(0), with(1));
    let at = |bins: &[[u32; 4]], x: usize, y: usize| bins[y * SIDE_BINS + x];
    assert_eq!(at(&even, 9, 11), mixed(f(4, 5), f(5, 5), f(4, 6), f(5, 6)));
    assert_eq!(at(&even, 9, 10), mixed(f(4, 5), f(5, 5), f(4, 4), f(5, 4)));
    assert_eq!(at(&odd, 8, 10), mixed(f(4, 5), f(3, 5), f(4, 4), f(3, 4)));
    // Over a border lies the same border, the other way round.
    assert_eq!(at(&odd, 0, 10), mixed(f(0, 5), f(0, 10), f(0, 4), f(0, 11)));
    assert_eq!(at(&even, 31, 10), mixed(f(15, 5), f(15, 10), f(15, 4), f(15, 11)));
    assert_eq!(at(&odd, 8, 0), mixed(f(4, 0), f(3, 0), f(11, 0), f(12, 0)));
    assert_eq!(at(&even, 9, 31), mixed(f(4, 15), f(5, 15), f(11, 15), f(10, 15)));
    assert_eq!(at(&odd, 0, 0), mixed(f(0, 0), f(0, 15), f(15, 0), f(15, 15)));
    // Each of the filled children counts once, whatever it was made of, and halves are rounded up.
    let mut bins = vec![None; ALL_BINS];
    (bins[0], bins[1], bins[SIDE_BINS], bins[2]) = (Some([10; 4]), Some([11; 4]), Some([11; 4]), Some([30; 4]));
    let all = filled(&bins).unwrap();
    assert_eq!(at(&all, 20, 20), [21; 4], "(11 + 30) / 2");
}

#[test]
fn colours_are_rounded_to_units_of_a_power_of_two() {
    assert_eq!(scale(&[[0.2, 0.3, 0.1, 1.0]]), 1.0);
    assert_eq!(scale(&[[0.2, 4.5, f32::NAN, 1.0], [f32::INFINITY; 4]]), 8.0);
    assert_eq!([scale(&[[8.0; 4]]), scale(&[[900.0; 4]])], [8.0, 16.0]);
    assert_eq!(quantised([0.5, 1.0, -3.0, f32::NAN], 1.0), [32_768, 65_535, 0, 0]);
    assert_eq!(quantised([0.5, 1.0, 7.99999, 0.75 / 8192.0], 8.0), [4096, 8192, 65_535, 1]);
}

#[test]
fn hue_saturation_and_value_are_those_known() {
    assert_eq!(hsv([1.0, 0.0, 0.0]), [0.0, 1.0, 1.0]);
    assert_eq!(hsv([0.0, 0.5, 0.0]), [1.0 / 3.0, 1.0, 0.5]);
    assert_eq!(hsv([2.0, 1.0, 2.0]), [5.0 / 6.0, 0.5, 2.0]);
    assert_eq!(hsv([0.25; 3]), [0.0, 0.0, 0.25]);
    for i in 0..125_u32 {
        let colour = [i % 5, i / 5 % 5, i / 25].map(|c| f64::from(c) * 0.3);
        let back = rgb(hsv(colour));
        assert!((0..3).all(|i| (back[i] - colour[i]).abs() < 1e-12), "{colour:?} {back:?}");
    }
}

#[test]
fn hues_change_the_short_way_and_greys_have_none() {
    assert!((hue_difference(0.03, 0.97) - 0.06).abs() < 1e-12);
    assert!((hue_difference(0.97, 0.03) + 0.06).abs() < 1e-12);
    assert_eq!(hue_difference(0.75, 0.25), -0.5);
    let colour = |h: f64, s: f64, v: f64| {
        let [r, g, b] = rgb([h, s, v]);
        [r * 0.5, g * 0.5, b * 0.5, 0.5]
    };
    let changed = predict(colour(0.98, 0.5, 0.5), &[[colour(0.03, 0.6, 0.7), colour(0.97, 0.5, 0.5)]], 1.0);
    assert!(close(changed, colour(0.04, 0.6, 0.7), 1e-12), "{changed:?}");
    let from_grey = predict(colour(0.3, 0.5, 0.5), &[[colour(0.6, 0.5, 0.5), colour(0.1, 0.04, 0.5)]], 1.0);
    assert!(close(from_grey, colour(0.3, 0.96, 0.5), 1e-12), "{from_grey:?}");
    let bright = predict(colour(0.3, 0.9, 0.9), &[[colour(0.3, 0.9, 0.9), colour(0.3, 0.2, 0.1)]], 1.25);
    assert!(close(bright, colour(0.3, 1.0, 1.25), 1e-12), "{bright:?}");
    // Two neighbours: the mean.
    let pairs = [[colour(0.2, 0.5, 0.5), colour(0.2, 0.5, 0.3)], [colour(0.2, 0.5, 0.5), colour(0.2, 0.5, 0.5)]];
    assert!(close(predict(colour(0.2, 0.5, 0.2), &pairs, 1.0), colour(0.2, 0.5, 0.3), 1e-12));
}

#[test]
fn holes_close_from_most_neighbours_inward_all_at_once() {
    let mut colours = vec![Some([0.0; 4]); 25];
    let hole: Vec<usize> = (0..9).map(|i| (1 + i / 3) * 5 + 1 + i % 3).collect();
    hole.iter().for_each(|place| colours[*place] = None);
    let round = |_: usize, others: &[usize], colours: &[Option<Colour>]| {
        let last = others.iter().filter_map(|other| colours[*other]).fold(0.0, |last: f64, c| last.max(c[0]));
        [last + 1.0, others.len() as f64, 0.0, 0.0]
    };
    let left = inward([5, 5], hole.clone(), &mut colours, |_, _| true, round);
    let made: Vec<[f64; 2]> = hole.iter().map(|place| colours[*place].unwrap()).map(|c| [c[0], c[1]]).collect();
    let (corner, edge, centre) = ([1.0, 2.0], [2.0, 3.0], [3.0, 4.0]);
    assert_eq!(made, [corner, edge, corner, edge, centre, edge, corner, edge, corner]);
    assert!(left.is_empty());
    let mut none = vec![None; 25];
    assert_eq!(inward([5, 5], hole.clone(), &mut none, |_, _| true, round), hole);
}

/// A row of samples by their sides; k' is 0.5.
fn row(sides: &[[Option<Colour>; 2]]) -> Vec<Shaded> {
    let fragment = Fragment { triangle: 0, base: 0, time: 0.5, depth: 1.0, weights: [1.0, 0.0, 0.0] };
    let mask = |side: &[Option<Colour>; 2]| u8::from(side[0].is_some()) + 2 * u8::from(side[1].is_some());
    sides.iter().map(|s| Shaded { mask: mask(s), fragment: Some(fragment), sides: *s, uncertain: false }).collect()
}

#[test]
fn the_gradient_of_a_ramp_is_found() {
    let image = vec![[1.0_f32; 4]; 12];
    let frame = Frame::new(&[], &[], &image, [12, 1], 0.1);
    let filled = |sides: &[[Option<Colour>; 2]]| -> Vec<Colour> {
        let shaded = row(sides);
        let both = |s: &Shaded| Some(mix(0.5, [s.sides[0]?, s.sides[1]?]));
        let mut colours: Vec<Option<Colour>> = shaded.iter().map(both).collect();
        gradient::fill([12, 1], [&frame, &frame], &shaded, &mut colours);
        colours.into_iter().map(Option::unwrap).collect()
    };
    // Frame i is a ramp, frame i + 1 the same, brighter: what is hidden of it is found.
    let ramp = |x: usize| 0.1 + 0.05 * x as f64;
    let hidden = |x: usize| (4..9).contains(&x);
    let sides: Vec<_> = (0..12).map(|x| [Some(grey(ramp(x))), (!hidden(x)).then(|| grey(ramp(x) + 0.2))]).collect();
    for (x, colour) in filled(&sides).into_iter().enumerate() {
        assert!(close(colour, grey(ramp(x) + 0.1), 1e-12), "{x}: {colour:?}");
    }
    // The change is itself a ramp, and one sample of the earlier frame is hidden.
    let sides: Vec<_> = (0..12).map(|x| [(x != 6).then(|| grey(ramp(x))), Some(grey(0.2 + 0.5 * ramp(x)))]).collect();
    for (x, colour) in filled(&sides).into_iter().enumerate() {
        assert!(close(colour, grey(0.1 + 0.75 * ramp(x)), 1e-12), "{x}: {colour:?}");
    }
    // Neighbours that the other frame shows teach nothing.
    let sides: Vec<_> = (0..12).map(|x| [(x < 6).then(|| grey(0.5)), (x >= 6).then(|| grey(0.25))]).collect();
    assert_eq!(filled(&sides), (0..12).map(|x| if x < 6 { grey(0.5) } else { grey(0.25) }).collect::<Vec<_>>());
    // Nor do those that have a colour, and are known from the other frame only or from frames around.
    let mut shaded = row(&[[Some(grey(0.5)), None], [None, Some(grey(0.25))]]);
    for mask in [2, 0] {
        shaded[1].mask = mask;
        let mut colours = [None, Some(grey(0.9))];
        gradient::fill([2, 1], [&frame, &frame], &shaded, &mut colours);
        assert_eq!(colours[0], Some(grey(0.5)), "{mask}");
        shaded[1].sides[0] = Some(grey(0.7));
    }
}

fn strip(place: u32, normal: [f64; 3], colours: [f32; 2]) -> Square {
    let left = f64::from(place) * 3.0;
    let bounds = [left, 0.0, left + 3.0, 8.0];
    let colours = colours.map(|c| [c, c, c, 1.0]);
    Square { normals: [normal; 2], is_still: false, ..Square::new(1, 4.0, [bounds; 2], colours) }
}

#[test]
fn what_neither_frame_shows_is_typical_or_like_its_neighbours() {
    let strips = [strip(1, [0.0, 1.0, 0.1], [0.8, 0.4]), strip(3, [1.0, 0.0, 0.1], [0.2, 0.2])];
    let rig = Rig::new(&strips, [0.0; 4]);
    let (surface, frames) = (rig.surface(), [rig.frame(0), rig.frame(1)]);
    let frames = [&frames[0], &frames[1]];
    let drawing = rig.draw(0.25, 1);
    let mut shaded = shade(&surface, &drawing, frames, [None; 2]);
    let hidden = 4 * 24 + 4;
    assert_eq!(shaded[hidden].mask, 3);
    (shaded[hidden].mask, shaded[hidden].sides) = (0, [None; 2]);
    shaded[hidden - 1].sides = [Some(grey(0.4)); 2];
    let typical = complete(&surface, &drawing, frames, &shaded, Completion::Surface, Mix::Blend)[hidden];
    assert!(close(typical, grey(0.75 * 0.8 + 0.25 * 0.4), 1e-4), "{typical:?}");
    let mean = complete(&surface, &drawing, frames, &shaded, Completion::None, Mix::Blend)[hidden];
    assert!(close(mean, grey((3.0 * 0.7 + 0.4) / 4.0), 1e-6), "{mean:?}");
    assert_eq!(complete(&surface, &drawing, frames, &shaded, Completion::None, Mix::Blend)[0], [0.0; 4]);
    // With the help of the frames around.
    shaded[hidden].sides = [Some(grey(0.3)), None];
    assert_eq!(complete(&surface, &drawing, frames, &shaded, Completion::Surface, Mix::Blend)[hidden], grey(0.3));
    shaded[hidden].sides = [Some(grey(0.3)), Some(grey(0.7))];
    assert!(close(
        complete(&surface, &drawing, frames, &shaded, Completion::Gradient, Mix::Blend)[hidden],
        grey(0.4),
        1e-12
    ));
}
