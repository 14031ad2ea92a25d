use super::rig::{Rig, SIZE, Square};
use super::*;

const RED: [f32; 4] = [1.0, 0.25, 0.0, 1.0];
const BLUE: [f32; 4] = [0.0, 0.5, 2.0, 1.0];
const SKY: [f32; 4] = [0.125, 0.25, 0.5, 1.0];
const ALL: [f64; 4] = [0.0, 0.0, 24.0, 8.0];

fn wide(colour: [f32; 4]) -> Colour {
    colour.map(f64::from)
}

/// What is found at a place of the first square, in a picture whose second square begins at pixel 12.
fn found(other: u32, depth: f64, x: f64) -> Look {
    let wall = Square::new(1, 4.0, [ALL; 2], [RED; 2]);
    let box_ = Square::new(other, depth, [[12.0, 0.0, 24.0, 8.0]; 2], [BLUE; 2]);
    let rig = Rig::new(&[wall, box_], SKY);
    // The upper half of the wall: corners (0, 0), (24, 8), (24, 0).
    let (x, y) = (x / 24.0, 2.5 / 8.0);
    rig.frame(0).look_up(&rig.surface(), 1, [1.0 - x, y, x - y])
}

#[test]
fn taps_on_an_occluder_do_not_count() {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    let look = found(2, 2.0, 12.0);
    assert!(near(look.weight, 0.5) && look.colour == wide(RED) && !look.uncertain, "{look:?}");
    assert_eq!(found(1, 2.0, 12.0).known(), Some(wide(RED)), "the same object, another depth");
    let look = found(1, 4.0 / 1.002, 12.0);
    assert!(near(look.weight, 1.0) && near(look.colour[2], 1.0) && near(look.colour[0], 0.5), "{look:?}");
    assert!(near(found(1, 4.0 * (1.0 - 0.0031), 12.0).weight, 0.5));
    assert!(near(found(1, 4.0 * (1.0 - 0.0029), 12.0).weight, 1.0));
    assert!(found(1, 4.0 * (1.0 - 0.003), 12.0).uncertain);
    assert!(near(found(2, 4.0 / 1.002, 12.0).weight, 0.5), "another object, about the same depth");
    assert!(found(2, 2.0, 12.24).known().is_some() && found(2, 2.0, 12.26).known().is_none());
    assert!(found(2, 2.0, 12.25).uncertain);
    assert_eq!(found(2, 2.0, 13.0).weight, 0.0);
}

#[test]
fn a_surface_that_recedes_is_found_by_its_plane() {
    // Depth changes by a tenth from pixel to pixel.
    let slope = Square { depth: [1.0, 10.0], ..Square::new(1, 1.0, [ALL; 2], [RED; 2]) };
    let rig = Rig::new(&[slope], SKY);
    let look = rig.frame(0).look_up(&rig.surface(), 0, [0.3, 0.3, 0.4]);
    assert!((look.weight - 1.0).abs() < 1e-12, "{look:?}");
}

#[test]
fn a_border_is_as_opaque_as_what_it_borders() {
    let at = |opacity: f32, alpha: f32| {
        let square = Square::new(1, 4.0, [[4.0, 0.0, 12.0, 8.0]; 2], [RED.map(|c| c * opacity); 2]);
        let mut rig = Rig::new(&[square], [0.0; 4]);
        // The last column that sees the square is covered in part.
        (0..8).for_each(|y| rig.images[0][y * 24 + 11] = RED.map(|c| c * opacity * alpha));
        // Four pixels of the row in its middle, from the outer part of the last to the inner ones.
        [11.5, 11.25, 11.0, 10.5].map(|x| {
            let (right, down) = ((x - 4.0) / 8.0, 0.5 / 8.0);
            rig.frame(0).look_up(&rig.surface(), 1, [1.0 - right, down, right - down]).colour
        })
    };
    let equals = |a: &Colour, b: f64| (0..4).all(|i| (a[i] - wide(RED)[i] * b).abs() < 1e-6);
    assert!(at(1.0, 0.25).iter().all(|colour| equals(colour, 1.0)), "{:?}", at(1.0, 0.25));
    assert!(at(0.5, 0.25).iter().all(|colour| equals(colour, 0.5)), "what is half transparent stays so");
    // Only borders: what is inside keeps what it has.
    let whole = Square::new(1, 4.0, [ALL; 2], [RED; 2]);
    let mut rig = Rig::new(&[whole], SKY);
    (0..8).for_each(|y| rig.images[0][y * 24 + 11] = RED.map(|c| c * 0.25));
    let look = rig.frame(0).look_up(&rig.surface(), 1, [1.0 - 11.5 / 24.0, 4.5 / 8.0, 11.5 / 24.0 - 4.5 / 8.0]);
    assert!(look.weight > 0.9 && equals(&look.colour, 0.25), "{look:?}");
}

#[test]
fn what_is_off_screen_is_unknown() {
    let wide_wall = Square::new(1, 4.0, [[-24.0, -8.0, 48.0, 16.0]; 2], [RED; 2]);
    let rig = Rig::new(&[wide_wall], SKY);
    // The lower half: corners (-24, -8), (-24, 16), (48, 16).
    let look = |x: f64, y: f64| {
        let (right, down) = ((x + 24.0) / 72.0, (y + 8.0) / 24.0);
        rig.frame(0).look_up(&rig.surface(), 0, [1.0 - down, down - right, right])
    };
    assert!((look(0.0, 7.0).weight - 0.5).abs() < 1e-12);
    assert!((look(0.0, 8.0).weight - 0.25).abs() < 1e-12);
    assert!(look(0.3, 7.5).known().is_some() && look(-0.3, 7.5).known().is_none());
}

#[test]
fn each_mask_comes_from_the_frames_that_show_a_place() {
    // A square goes from left to right over a wall that stays; both are drawn where the square is half way.
    let wall = Square::new(1, 4.0, [ALL; 2], [RED; 2]);
    let boxes = [[4.0, 2.0, 8.0, 6.0], [12.0, 2.0, 16.0, 6.0]];
    let square = Square::new(2, 2.0, boxes, [BLUE, SKY]);
    let rig = Rig::new(&[wall, square], SKY);
    let (surface, frames) = (rig.surface(), [rig.frame(0), rig.frame(1)]);
    let drawing = rig.draw(0.5, 1);
    let shaded = shade(&surface, &drawing, [&frames[0], &frames[1]], [None; 2]);
    let row = |y: usize| -> Vec<u8> { shaded[y * 24..(y + 1) * 24].iter().map(|s| s.mask).collect() };
    assert_eq!(row(0), [3; 24]);
    assert_eq!(row(4), [3, 3, 3, 3, 2, 2, 2, 2, 3, 3, 3, 3, 1, 1, 1, 1, 3, 3, 3, 3, 3, 3, 3, 3]);
    let middle = &shaded[4 * 24 + 9];
    assert_eq!(middle.sides, [Some(wide(BLUE)), Some(wide(SKY))]);
    // Behind a second wall in both frames, but not when it is drawn: neither. Frames around show it.
    let cover = |x: f64| [x, 0.0, x + 4.0, 8.0];
    let hiding = [Square::new(3, 1.0, [cover(4.0), cover(4.0)], [RED; 2])];
    let behind = Square::new(2, 2.0, [[4.0, 2.0, 8.0, 6.0], [4.0, 2.0, 8.0, 6.0]], [BLUE, SKY]);
    let hidden = Rig::new(&[hiding[0], behind], SKY);
    let shown = Rig::new(&[Square::new(3, 1.0, [cover(16.0); 2], [RED; 2]), behind], SKY);
    let drawing = shown.draw(1.0, 1);
    let (frames, outer) = ([hidden.frame(0), hidden.frame(1)], [shown.frame(0), shown.frame(1)]);
    let surface = shown.surface();
    let alone = shade(&surface, &drawing, [&frames[0], &frames[1]], [None; 2])[4 * 24 + 5];
    assert_eq!((alone.mask, alone.sides), (0, [None; 2]));
    let helped = shade(&surface, &drawing, [&frames[0], &frames[1]], [Some(&outer[0]), Some(&outer[1])])[4 * 24 + 5];
    assert_eq!((helped.mask, helped.sides), (0, [Some(wide(BLUE)), Some(wide(SKY))]));
    assert_eq!(shade(&surface, &drawing, [&frames[0], &frames[1]], [None; 2])[0].mask, 4);
}

#[test]
fn colours_are_mixed_by_time_within_a_frame() {
    let sides = [wide(RED), wide(BLUE)];
    assert_eq!(mix(0.25, sides), [0.75, 0.3125, 0.5, 1.0]);
    assert_eq!(mix(-0.5, sides), sides[0]);
    assert_eq!(mix(1.5, sides), sides[1]);
}

/// The finished image of a square that goes from left to right over a wall that covers the right third.
fn finished(samples: u32, time: f64) -> (Rig, Vec<Colour>) {
    let wall = Square::new(1, 4.0, [[16.3, 0.0, 24.0, 8.0]; 2], [RED; 2]);
    let boxes = [[2.0, 2.0, 6.0, 6.0], [8.0, 2.0, 12.0, 6.0]];
    let mut rig = Rig::new(&[wall, Square::new(2, 2.0, boxes, [BLUE; 2])], SKY);
    // Nothing in the images is the same twice.
    for (k, image) in rig.images.iter_mut().enumerate() {
        for (place, pixel) in image.iter_mut().enumerate() {
            pixel[1] += (place + 1000 * k) as f32 / 3000.0;
        }
    }
    let (surface, frames) = (rig.surface(), [rig.frame(0), rig.frame(1)]);
    let frames = [&frames[0], &frames[1]];
    let drawing = rig.draw(time, samples);
    let shaded = shade(&surface, &drawing, frames, [None; 2]);
    let colour = |s: &Shaded| match (s.fragment, s.sides) {
        (Some(f), [Some(a), Some(b)]) => mix(f.time, [a, b]),
        (Some(_), _) => wide(RED),
        _ => [0.0; 4],
    };
    let colours: Vec<Colour> = shaded.iter().map(colour).collect();
    let image = compose(&surface, &drawing, frames, &shaded, &colours, [9.0, 9.0, 9.0, 1.0]);
    (rig, image)
}

#[test]
fn where_nothing_moves_is_the_next_image_bit_for_bit() {
    for samples in [1, 2] {
        let (rig, image) = finished(samples, 0.5);
        assert_eq!(image.len(), (SIZE[0] * SIZE[1]) as usize);
        for (place, pixel) in image.iter().enumerate() {
            let (x, y) = (place % 24, place / 24);
            let is_seen = (2..6).contains(&y) && (5..9).contains(&x);
            let was_next = (2..6).contains(&y) && (9..12).contains(&x);
            let expected = if was_next { rig.images[0][place] } else { rig.images[1][place] };
            assert_eq!(*pixel == wide(expected), !is_seen, "{samples}: {x}, {y}: {pixel:?}");
        }
    }
}

#[test]
fn what_no_image_shows_is_the_background() {
    let long = Square::new(2, 2.0, [[2.0, 2.0, 20.0, 6.0], [3.0, 2.0, 21.0, 6.0]], [BLUE; 2]);
    let rig = Rig::new(&[long], SKY);
    let frames = [rig.frame(0), rig.frame(1)];
    let frames = [&frames[0], &frames[1]];
    let nothing = draw_nothing();
    let shaded = vec![Shaded { mask: 4, fragment: None, sides: [None; 2], uncertain: false }; 24 * 8];
    let image = compose(&rig.surface(), &nothing, frames, &shaded, &vec![[0.0; 4]; 24 * 8], [9.0, 9.0, 9.0, 1.0]);
    assert_eq!(image[4 * 24 + 10], [9.0, 9.0, 9.0, 1.0]);
    assert_eq!([image[4 * 24 + 2], image[4 * 24 + 20]], [wide(SKY); 2]);
}

fn draw_nothing() -> Drawing {
    crate::blur::reference::distort::draw(&[], &[], SIZE, rig::NEAR, 1)
}

#[test]
fn what_lets_light_through_is_over_what_would_be_seen_without_it() {
    let long = Square::new(2, 2.0, [[2.0, 2.0, 20.0, 6.0], [3.0, 2.0, 21.0, 6.0]], [BLUE; 2]);
    let rig = Rig::new(&[long], SKY);
    let frames = [rig.frame(0), rig.frame(1)];
    let frames = [&frames[0], &frames[1]];
    let drawing = rig.draw(0.0, 1);
    let shaded = shade(&rig.surface(), &drawing, frames, [None; 2]);
    let image = compose(&rig.surface(), &drawing, frames, &shaded, &vec![[0.5, 0.0, 0.0, 0.75]; 24 * 8], [8.0; 4]);
    assert_eq!(image[4 * 24 + 10], [2.5, 2.0, 2.0, 2.75], "over the background");
    assert_eq!(image[4 * 24 + 2], [0.53125, 0.0625, 0.125, 1.0], "over the next image");
    assert_eq!(image[4 * 24 + 20], wide(SKY), "nothing, over the previous image");
}

#[test]
fn what_is_before_the_near_plane_is_unknown() {
    // At depths from 0.12 to 0.08, the near plane at 0.1.
    let wall = Square { depth: [0.12, 0.08], ..Square::new(1, 1.0, [ALL; 2], [RED; 2]) };
    let rig = Rig::new(&[wall], SKY);
    let look = |share: f64| rig.frame(0).look_up(&rig.surface(), 0, [1.0 - share, 0.0, share]);
    assert!(look(0.1).weight > 0.99 && look(0.499).weight > 0.0);
    assert_eq!([look(0.501).weight, look(0.9).weight], [0.0; 2]);
}

#[test]
fn an_open_surface_has_a_normal_on_both_sides() {
    let corners =
        [[[0.0, 0.0, 1.0], [0.0, 8.0, 1.0], [24.0, 8.0, 1.0]], [[0.0, 0.0, 1.0], [24.0, 8.0, 1.0], [0.0, 8.0, 1.0]]];
    let normals = [[[1.0, 2.0, 3.0]; 3], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [1.0, 0.0, 0.0]]];
    let image = vec![SKY; 24 * 8];
    let frame = Frame::new(&corners, &normals, &image, SIZE, rig::NEAR);
    let normal = |closed: bool, base: u32, weights: [f64; 3]| {
        let surface = Surface { surfaces: &[0; 2], closed: &[closed; 2], still: &[false; 2], near: rig::NEAR };
        frame.normal(&surface, base, weights)
    };
    assert_eq!(normal(false, 0, [0.25, 0.5, 0.25]), [1.0, 2.0, 3.0], "towards the camera");
    assert_eq!(normal(false, 1, [0.0, 1.0, 0.0]), [-4.0, -5.0, -6.0]);
    assert_eq!(normal(true, 1, [0.0, 0.5, 0.5]), [2.5, 2.5, 3.0]);
}
