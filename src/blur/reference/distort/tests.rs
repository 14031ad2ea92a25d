use super::*;

const WHOLE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A triangle of its own with corners at these pixels and depths, whose k' are 0, 0.5 and 1.
fn triangle(base: u32, corners: [[f64; 3]; 3]) -> Triangle {
    let vertex = |i: usize| {
        let [x, y, w] = corners[i];
        Vertex { drawn: [x * w, y * w, w], time: i as f64 * 0.5, weights: WHOLE[i] }
    };
    Triangle { corners: [0, 1, 2].map(vertex), base }
}

fn drawn(triangles: &[Triangle], size: [u32; 2]) -> Drawing {
    draw(triangles, &vec![false; triangles.len()], size, 0.1, 1)
}

#[test]
fn a_square_covers_the_centres_within_it_by_the_top_left_rule() {
    // From centre to centre: the left and the upper row count, the right and the lower do not.
    let [a, b, c, d] = [[2.5, 3.5, 1.0], [6.5, 3.5, 1.0], [6.5, 8.5, 1.0], [2.5, 8.5, 1.0]];
    for halves in [[[a, b, c], [a, c, d]], [[c, b, a], [d, c, a]], [[b, c, d], [d, a, b]]] {
        let drawing = drawn(&[triangle(0, halves[0]), triangle(1, halves[1])], [10, 12]);
        for (place, name) in drawing.raster.seen.iter().enumerate() {
            let (x, y) = (place % 10, place / 10);
            assert_eq!(*name > 0, (2..6).contains(&x) && (3..8).contains(&y), "{x}, {y}");
            let on_border =
                ((2..=6).contains(&x) && (y == 3 || y == 8)) || ((3..=8).contains(&y) && (x == 2 || x == 6));
            assert!(!on_border || drawing.raster.uncertain[place], "{x}, {y}");
        }
    }
}

#[test]
fn a_fan_covers_each_centre_exactly_once() {
    let (centre, size) = ([20.5, 20.5, 2.0], [41, 41]);
    let corner = |i: u32| match i % 8 {
        0 => [0.0, 0.0, 1.0],
        1 => [20.5, 0.0, 2.0],
        2 => [41.0, 0.0, 4.0],
        3 => [41.0, 20.5, 1.0],
        4 => [41.0, 41.0, 1.0],
        5 => [20.5, 41.0, 8.0],
        6 => [0.0, 41.0, 1.0],
        _ => [0.0, 20.5, 2.0],
    };
    let fan: Vec<Triangle> = (0..8).map(|i| triangle(i, [centre, corner(i), corner(i + 1)])).collect();
    let mut covered = vec![0; 41 * 41];
    for one in &fan {
        let hidden = vec![false; 8];
        let alone = draw(std::slice::from_ref(one), &hidden, size, 0.1, 1);
        covered.iter_mut().zip(&alone.raster.seen).for_each(|(count, name)| *count += u32::from(*name > 0));
    }
    assert!(covered.iter().all(|count| *count == 1));
    let all = drawn(&fan, size);
    let flagged = all.raster.uncertain.iter().filter(|flag| **flag).count();
    // The two axes and the two diagonals go through centres, and nothing else does.
    assert_eq!(flagged, 41 * 4 - 3);
}

#[test]
fn interpolation_is_that_of_a_plane_in_space() {
    // A floor 1 below an eye with a focal length of 50 pixels: y - 20 = 50 / W. k' is 0 at W = 2, 0.5 at 5 and 1 at 8,
    // linear in W on the floor's ray straight ahead, and so in all of it.
    let at = |x: f64, w: f64| [20.0 + 50.0 * x / w, 20.0 + 50.0 / w, w];
    let floor = triangle(0, [at(-1.5, 2.0), at(0.0, 5.0), at(1.5, 8.0)]);
    let other = triangle(1, [at(-1.5, 2.0), at(3.0, 2.0), at(1.5, 8.0)]);
    let drawing = drawn(&[floor, other], [60, 50]);
    let mut count = 0;
    for (place, fragment) in drawing.fragments.iter().enumerate() {
        let Some(fragment) = fragment else { continue };
        let (x, y) = ((place % 60) as f64 + 0.5, (place / 60) as f64 + 0.5);
        let depth = 50.0 / (y - 20.0);
        assert!((fragment.depth / depth - 1.0).abs() < 1e-12, "{x}, {y}: {fragment:?}");
        if fragment.base == 0 {
            assert!((fragment.time - (depth - 2.0) / 6.0).abs() < 1e-12, "{x}, {y}: {fragment:?}");
        } else {
            // Across: barycentric coordinates of (x, W) in the corners (-1.5, 2), (3, 2), (1.5, 8).
            let (across, far) = ((x - 20.0) * depth / 50.0, (depth - 2.0) / 6.0);
            let second = (across + 1.5 - 3.0 * far) / 4.5;
            let expected = [1.0 - second - far, second, far];
            assert!((0..3).all(|i| (fragment.weights[i] - expected[i]).abs() < 1e-12), "{fragment:?}");
        }
        count += 1;
    }
    assert!(count > 300, "{count}");
}

#[test]
fn the_nearer_wins_and_of_equal_ones_the_first() {
    let square = |w: f64| [[1.0, 1.0, w], [30.0, 1.0, w], [1.0, 30.0, w]];
    let names = |depths: [f64; 3]| {
        let triangles: Vec<Triangle> = depths.iter().zip(0..).map(|(w, base)| triangle(base, square(*w))).collect();
        let drawing = drawn(&triangles, [31, 31]);
        (drawing.raster.seen[5 * 31 + 5], drawing.raster.uncertain[5 * 31 + 5])
    };
    assert_eq!(names([2.0, 1.0, 3.0]), (2, false));
    assert_eq!(names([2.0, 3.0, 2.0]), (1, true));
    assert_eq!(names([2.0, 3.0, 2.0 - 1e-7]), (3, true));
    assert_eq!(names([0.05, 3.0, 4.0]), (2, false), "nearer than the near plane");
}

#[test]
fn what_goes_through_the_eye_is_cut_at_the_near_plane() {
    // A floor 1 below the eye, from 4 behind it to 16 before it.
    let at = |x: f64, w: f64| [20.0 * w + 10.0 * x, 20.0 * w + 10.0, w];
    let vertex = |(clip, i): (Clip, usize)| Vertex { drawn: clip, time: 0.0, weights: WHOLE[i] };
    let corners = [(at(-40.0, 16.0), 0), (at(40.0, 16.0), 1), (at(0.0, -4.0), 2)].map(vertex);
    let drawing = draw(&[Triangle { corners, base: 0 }], &[false], [40, 60], 0.5, 1);
    for (place, fragment) in drawing.fragments.iter().enumerate() {
        let (x, y) = ((place % 40) as f64 + 0.5, (place / 40) as f64 + 0.5);
        let depth = 10.0 / (y - 20.0);
        let across = (x - 20.0) * depth / 10.0;
        let inside = y > 20.0 && (0.5..16.0).contains(&depth) && across.abs() < 2.0 * (depth + 4.0);
        assert_eq!(fragment.is_some(), inside, "{x}, {y}");
    }
}

#[test]
fn nothing_is_drawn_of_what_has_no_area_or_is_turned_away_twice() {
    let flat = triangle(0, [[1.0, 1.0, 1.0], [5.0, 5.0, 1.0], [9.0, 9.0, 1.0]]);
    let wrong = triangle(0, [[1.0, f64::NAN, 1.0], [5.0, 5.0, 1.0], [9.0, 9.0, 1.0]]);
    assert!(drawn(&[flat, wrong], [10, 10]).fragments.iter().all(Option::is_none));
    // Anticlockwise on screen is towards the eye.
    let towards = triangle(0, [[1.0, 1.0, 1.0], [1.0, 9.0, 1.0], [9.0, 1.0, 1.0]]).corners.map(|c| c.drawn);
    let away = [towards[0], towards[2], towards[1]];
    let corners = [towards, away, towards, away, away];
    let next = [towards, towards, away, away, away];
    let mut outsides = [Outside::CounterClockwise; 5];
    outsides[4] = Outside::None;
    assert_eq!(hidden([&corners, &next], [&outsides; 2]), [false, false, false, true, false]);
    let turned = [Outside::Clockwise; 5];
    assert_eq!(hidden([&corners, &next], [&turned; 2]), [true, false, false, false, false]);
    // Turned inside out from one frame to the other, and closed in one of them.
    assert_eq!(hidden([&corners, &next], [&outsides, &turned]), [false, true, false, false, false]);
    assert_eq!(hidden([&corners, &next], [&[Outside::None; 5], &outsides]), [false; 5]);
    assert!(
        draw(&[triangle(0, [[1.0, 1.0, 1.0], [9.0, 1.0, 1.0], [1.0, 9.0, 1.0]])], &[true], [10, 10], 0.1, 1)
            .fragments
            .iter()
            .all(Option::is_none)
    );
}

#[test]
fn four_samples_a_pixel_lie_at_the_centres_of_its_quarters() {
    let half = triangle(0, [[0.0, 0.0, 1.0], [4.5, 0.0, 1.0], [4.5, 40.0, 1.0]]);
    let other = triangle(1, [[0.0, 0.0, 1.0], [4.5, 40.0, 1.0], [0.0, 40.0, 1.0]]);
    let drawing = draw(&[half, other], &[false; 2], [6, 4], 0.1, 2);
    assert_eq!(drawing.raster.size, [12, 8]);
    let columns = |row: usize| (0..12).filter(|x| drawing.raster.seen[row * 12 + x] > 0).count();
    assert!((0..8).all(|row| columns(row) == 9), "4 pixels and the left half of the fifth");
}

#[test]
fn what_rounding_can_change_is_flagged() {
    // Corners moved by up to 1/256 pixel, as a device's grid does.
    let random = |n: u32| f64::from(crate::random::unit(crate::random::hash(9, n, 0, 0)));
    let corner = |n: u32| [random(n) * 40.0, random(n + 1) * 40.0, 1.0 + random(n + 2)];
    let corners: Vec<[[f64; 3]; 3]> = (0..60).map(|i| [0, 3, 6].map(|k| corner(9 * i + k))).collect();
    let rounded =
        corners.iter().map(|c| c.map(|[x, y, w]| [(x * 256.0).round() / 256.0, (y * 256.0).round() / 256.0, w]));
    let make = |corners: Vec<[[f64; 3]; 3]>| -> Drawing {
        let triangles: Vec<Triangle> = corners.iter().zip(0..).map(|(c, base)| triangle(base, *c)).collect();
        drawn(&triangles, [40, 40])
    };
    let (exact, moved) = (make(corners.clone()), make(rounded.collect()));
    let differ = |place: &usize| exact.raster.seen[*place] != moved.raster.seen[*place];
    let differing: Vec<usize> = (0..1600).filter(differ).collect();
    let flagged = exact.raster.uncertain.iter().filter(|flag| **flag).count();
    assert!(!differing.is_empty() && differing.iter().all(|place| exact.raster.uncertain[*place]));
    assert!(flagged < 320, "{flagged}");
}
