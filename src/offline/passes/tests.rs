use std::collections::BTreeMap;

use super::grid::Point;
use super::sheets::{Sheets, share_of};
use super::*;

const SIZE: [u32; 2] = [48, 40];

/// A frame in which each pixel shows what `at` says of its centre: depth, object, and the vector to the frame before; or nothing.
fn frame(size: [u32; 2], at: impl Fn([f32; 2]) -> Option<(f32, u32, [f32; 2])>) -> PassFrame {
    let [width, height] = size;
    let centres = (0..height).flat_map(|y| (0..width).map(move |x| [x as f32 + 0.5, y as f32 + 0.5]));
    let pixels: Vec<(f32, u32, [f32; 2])> = centres.map(|c| at(c).unwrap_or((f32::INFINITY, 0, [0.0; 2]))).collect();
    PassFrame {
        size,
        depth: pixels.iter().map(|pixel| pixel.0).collect(),
        id: pixels.iter().map(|pixel| pixel.1).collect(),
        previous: pixels.iter().map(|pixel| pixel.2).collect(),
        next: None,
    }
}

fn grid(frame: &PassFrame) -> (Sheets, Vec<bool>, Grid) {
    let Seen { sheets, movers, .. } = Seen::new(frame.clone());
    let grid = Grid::new(&sheets, &movers, CELL as usize);
    (sheets, movers, grid)
}

fn corner(point: &Point) -> [i64; 2] {
    point.corner.map(i64::from)
}

/// Twice the area, above 0 clockwise on screen.
fn area(grid: &Grid, triangle: &[u32; 3]) -> i64 {
    let [a, b, c] = triangle.map(|point| corner(&grid.points[point as usize]));
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// How often each edge is there, from its first to its second point.
fn edges(grid: &Grid) -> BTreeMap<(u32, u32), usize> {
    let mut edges = BTreeMap::new();
    for [a, b, c] in &grid.triangles {
        [(*a, *b), (*b, *c), (*c, *a)].into_iter().for_each(|edge| *edges.entry(edge).or_default() += 1);
    }
    edges
}

/// Holds what must hold of every grid: triangles run one way, meet side by side, and cover each pixel of the mask once; where
/// they do not meet there is a border of single pixels.
fn check(sheets: &Sheets, mask: &[bool], grid: &Grid) {
    let covered: i64 = grid.triangles.iter().map(|triangle| area(grid, triangle)).sum();
    assert_eq!(covered, 2 * mask.iter().filter(|is_in| **is_in).count() as i64);
    assert!(grid.triangles.iter().all(|triangle| area(grid, triangle) > 0));
    let width = sheets.size[0] as i64;
    let is_in = |x: i64, y: i64| (0..width).contains(&x) && y >= 0 && mask.get((y * width + x) as usize) == Some(&true);
    let edges = edges(grid);
    for ((a, b), count) in &edges {
        assert_eq!(*count, 1, "an edge is there once in each direction");
        if edges.contains_key(&(*b, *a)) {
            continue;
        }
        // An outer edge runs along sides of pixels, with something else beyond.
        let [[ax, ay], [bx, by]] = [a, b].map(|point| corner(&grid.points[*point as usize]));
        assert!(ax == bx || ay == by, "{:?}", [[ax, ay], [bx, by]]);
        for step in 0..(ax - bx).abs() + (ay - by).abs() {
            let (x, y) = (ax.min(bx) + if ay == by { step } else { 0 }, ay.min(by) + if ay == by { 0 } else { step });
            let (own, other) = if ay == by { ([x, y], [x, y - 1]) } else { ([x, y], [x - 1, y]) };
            let pixel = |[x, y]: [i64; 2]| (y * width + x) as usize;
            let is_joined = is_in(own[0], own[1])
                && is_in(other[0], other[1])
                && if ay == by { sheets.down(pixel(other)) } else { sheets.right(pixel(other)) };
            assert!(!is_joined, "a crack between {own:?} and {other:?}");
        }
    }
    for pixel in (0..mask.len()).filter(|pixel| mask[*pixel]) {
        let centre = [2 * (pixel as i64 % width) + 1, 2 * (pixel as i64 / width) + 1];
        let covers = |triangle: &&[u32; 3]| {
            let corners = triangle.map(|point| corner(&grid.points[point as usize]).map(|c| 2 * c));
            (0..3).all(|i| {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                // A centre on an edge is of the triangle on one side of it.
                let side = (b[0] - a[0]) * (centre[1] - a[1]) - (b[1] - a[1]) * (centre[0] - a[0]);
                side > 0 || (side == 0 && (a[1] < b[1] || (a[1] == b[1] && a[0] < b[0])))
            })
        };
        assert_eq!(grid.triangles.iter().filter(covers).count(), 1, "{centre:?}");
    }
}

fn is_in_disc([x, y]: [f32; 2]) -> bool {
    (x - 23.0).hypot(y - 19.0) < 15.3
}

#[test]
fn a_disc_is_covered_once_and_without_cracks() {
    let disc = frame(SIZE, |at| is_in_disc(at).then_some((3.0, 7, [-2.0, 1.0])));
    let (sheets, movers, grid) = grid(&disc);
    assert_eq!(movers, disc.depth.iter().map(|depth| depth.is_finite()).collect::<Vec<_>>());
    check(&sheets, &movers, &grid);
    // Cells of several pixels are within, and single ones at the border.
    assert!(2 * grid.triangles.len() < 3 * movers.iter().filter(|is_in| **is_in).count(), "{}", grid.triangles.len());
}

#[test]
fn any_mask_is_covered_once() {
    // Pixels of a pattern without order, of three objects, some of them touching by a corner only.
    let noise = |[x, y]: [f32; 2]| (12.989_8 * x + 78.233 * y).sin() * 43_758.547;
    let ragged = frame([37, 29], |at| {
        let value = noise(at).rem_euclid(1.0);
        (value < 0.7).then_some((2.0, (value * 4.0) as u32, [3.0, 0.0]))
    });
    let (sheets, movers, grid) = grid(&ragged);
    check(&sheets, &movers, &grid);
}

#[test]
fn a_slanted_plane_is_whole_and_two_layers_are_cut() {
    // As a perspective view sees a floor: 1 / depth is linear. From a row to the next it grows by up to a fifth.
    let floor = frame(SIZE, |[_, y]| Some((40.0 / (40.0 - 0.9 * y), 0, [4.0, 0.0])));
    let (sheets, movers, whole) = grid(&floor);
    check(&sheets, &movers, &whole);
    let length = |grid: &Grid, a: u32, b: u32| {
        let [a, b] = [a, b].map(|point| corner(&grid.points[point as usize]));
        ((a[0] - b[0]).abs() + (a[1] - b[1]).abs()) as usize
    };
    let borders = |grid: &Grid| -> usize {
        let edges = edges(grid);
        let outer = edges.keys().filter(|(a, b)| !edges.contains_key(&(*b, *a)));
        outer.map(|(a, b)| length(grid, *a, *b)).sum()
    };
    let outline = 2 * (SIZE[0] + SIZE[1]) as usize;
    assert_eq!(borders(&whole), outline);
    // Half of it 5 % nearer, of the same object and with the same motion.
    let step = frame(SIZE, |[x, y]| {
        let depth = 40.0 / (40.0 - 0.5 * y);
        Some((if x < 21.0 { depth } else { 0.95 * depth }, 0, [4.0, 0.0]))
    });
    let (sheets, movers, cut) = grid(&step);
    check(&sheets, &movers, &cut);
    assert_eq!(borders(&cut), outline + 2 * SIZE[1] as usize);
    // Where depth says nothing motion does, and objects do.
    let torn = frame(SIZE, |[x, _]| Some((2.0, 0, [if x < 21.0 { 4.0 } else { 9.0 }, 0.0])));
    let objects = frame(SIZE, |[x, _]| Some((2.0, u32::from(x < 21.0), [4.0, 0.0])));
    for other in [torn, objects] {
        assert_eq!(borders(&grid_of(&other)), outline + 2 * SIZE[1] as usize);
    }
}

fn grid_of(frame: &PassFrame) -> Grid {
    grid(frame).2
}

/// A disc flies to the left behind a bar that stands still, over one at the other side, and before a wall.
#[test]
fn what_stands_still_is_in_the_mesh_where_smears_pass_behind_it() {
    let scene = |number: u32| {
        let centre = 70.5 - 8.0 * number as f32;
        frame([80, 40], move |[x, y]| match x {
            _ if (x - centre).hypot(y - 20.0) < 6.0 => Some((3.0, 1, [8.0, 0.0])),
            _ if (52.0..56.0).contains(&x) => Some((2.0, 2, [0.0; 2])),
            _ if (0.0..4.0).contains(&x) => Some((2.0, 3, [0.0; 2])),
            _ => Some((9.0, 4, [0.0; 2])),
        })
    };
    let size = [80, 40];
    let mut input =
        PassesInput::new(move |number| Ok(scene(number)), [1, 6], &Settings::default(), size, 1).expect("fine");
    let made = input.frame(3).expect("a frame");
    let objects = made.mesh.point_objects();
    // Points of the disc and of the near bar; the far one is not on its way, and the wall lies behind it.
    let places = |object: u32| {
        made.poses.iter().map(move |pose| (0..pose.len()).filter(move |i| objects[*i] == object).map(|i| pose[i]))
    };
    assert_eq!([1, 2, 3, 4].map(|object| objects.contains(&object)), [true, true, false, false]);
    assert!(places(2).all(|pose| pose.map(|[x, ..]| x).all(|x| (52.0..=56.0).contains(&x))));
    // It does not move.
    let moved = |pose: usize| places(2).nth(pose).expect("a pose").map(|[x, y, _]| [x, y]).collect::<Vec<_>>();
    assert!((0..4).all(|pose| moved(pose) == moved(2)));
}

#[test]
fn what_stands_still_is_no_mesh() {
    let scene = frame(SIZE, |at| match is_in_disc(at) {
        true => Some((2.0, 0, [3.0, 0.0])),
        false => Some((5.0, 0, [0.1, 0.0])),
    });
    let (_, movers, grid) = grid(&scene);
    let width = SIZE[0] as usize;
    let expected = |pixel: usize| is_in_disc([(pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5]);
    assert!((0..movers.len()).all(|pixel| movers[pixel] == expected(pixel)));
    assert!(!grid.triangles.is_empty());
    assert_eq!(grid_of(&frame(SIZE, |_| None)), Grid::default());
}

/// A square that turns and flies: where its points are in each frame.
fn turned([x, y]: [f32; 2], frame: f32) -> [f32; 2] {
    let (sin, cos) = (0.06 * frame).sin_cos();
    let (x, y) = (x - 24.0, y - 20.0);
    [24.0 + 1.5 * frame + cos * x - sin * y, 20.0 - 0.75 * frame + sin * x + cos * y]
}

/// The inverse.
fn rest([x, y]: [f32; 2], frame: f32) -> [f32; 2] {
    let (sin, cos) = (0.06 * frame).sin_cos();
    let (x, y) = (x - 24.0 - 1.5 * frame, y - 20.0 + 0.75 * frame);
    [24.0 + cos * x + sin * y, 20.0 - sin * x + cos * y]
}

fn square(number: f32) -> PassFrame {
    let of = |at: [f32; 2], to: f32| {
        let place = turned(rest(at, number), to);
        [place[0] - at[0], place[1] - at[1]]
    };
    let is_in = |at: [f32; 2]| rest(at, number).iter().zip([24.0, 20.0]).all(|(c, centre)| (c - centre).abs() < 9.0);
    frame(SIZE, |at| is_in(at).then(|| (4.0, 3, of(at, number - 1.0))))
}

/// Of a motion that is linear in space, as that of what is rigid and flat, points are where they are: to what single floats lose.
#[test]
fn points_of_a_turning_square_go_where_it_turns() {
    let read = |number: u32| Ok(square(number as f32 - 12.0));
    for trajectory in [Trajectory::Spline, Trajectory::Past] {
        let settings = Settings { trajectory, ..Settings::default() };
        let mut input = PassesInput::new(read, [1, 20], &settings, SIZE, 1).expect("settings");
        let made = input.frame(13).expect("a frame");
        let frames: Vec<u32> = (made.first..).take(made.poses.len()).collect();
        assert_eq!(frames, if trajectory == Trajectory::Past { vec![11, 12, 13] } else { vec![11, 12, 13, 14] });
        assert_eq!(made.images(), [12, 13]);
        let unit = input.depth_unit() as f32;
        for (i, now) in made.poses[2].iter().enumerate() {
            for (frame, pose) in frames.iter().zip(&made.poses) {
                let expected = turned(rest([now[0], now[1]], 1.0), *frame as f32 - 12.0);
                let off = (pose[i][0] - expected[0]).hypot(pose[i][1] - expected[1]);
                // 1e-3 px in the frames of the interval. In those beside it borders are half pixels off what is looked up
                // there, of vectors that change by 0.06 px from one to the next.
                let most = if [12, 13].contains(frame) { 1e-3 } else { 0.1 };
                assert!(off < most, "{off} in frame {frame} at {now:?}");
                assert!((pose[i][2] - unit * share_of(4.0)).abs() < 1e-3 * unit, "{:?}", pose[i]);
            }
        }
    }
}

#[test]
fn vectors_at_borders_that_are_mixed_are_made_whole() {
    // As a filtered pass has it: half of what is beyond.
    let mixed = |at: [f32; 2]| !is_in_disc([at[0] + 1.0, at[1]]) || !is_in_disc([at[0] - 1.0, at[1]]);
    let disc = frame(SIZE, |at| is_in_disc(at).then(|| (3.0, 7, if mixed(at) { [-4.0, 0.0] } else { [-8.0, 0.0] })));
    let seen = Seen::new(disc);
    let whole = seen.frame.previous.iter().filter(|vector| vector[0] == -8.0).count();
    let moving = seen.movers.iter().filter(|moves| **moves).count();
    // All but the few at the poles that have none inside beside them.
    assert!(moving - whole <= 8, "{whole} of {moving}");
}

/// Two surfaces, the nearer of which moves over the farther: what it hides of that is in the mesh, and nothing twice.
#[test]
fn what_is_hidden_then_is_taken_from_the_frame_before() {
    let bar = |number: u32| {
        frame(SIZE, move |[x, y]| {
            let left = 4.0 + 6.0 * number as f32;
            let is_near = (left..left + 8.0).contains(&x) && (8.0..32.0).contains(&y);
            let is_far = (2.0..46.0).contains(&x) && (12.0..28.0).contains(&y);
            if is_near { Some((2.0, 1, [-6.0, 0.0])) } else { is_far.then_some((3.0, 2, [-1.0, 0.0])) }
        })
    };
    let mut input =
        PassesInput::new(move |number| Ok(bar(number)), [1, 6], &Settings::default(), SIZE, 1).expect("fine");
    let made = input.frame(3).expect("a frame");
    let next = &made.poses[2];
    // Behind the bar of frame 3, x = 22 to 30, there is something of the other, at a greater depth.
    let behind = next.iter().zip(made.mesh.point_objects()).filter(|(_, object)| **object == 2);
    let behind: Vec<_> = behind.filter(|([x, y, _], _)| (23.0..29.0).contains(x) && (13.0..27.0).contains(y)).collect();
    let unit = input.depth_unit() as f32;
    assert!(!behind.is_empty() && behind.iter().all(|([.., z], _)| *z > unit * share_of(2.0)), "{}", behind.len());
    assert!(made.counts.clusters >= 2);
    // Frame 1 has none before it, and nothing goes over a cut.
    assert!(input.frame(1).expect("a frame").interval.clusters.is_empty());
    let mut cut = input.cut_at(&[3]);
    assert!(cut.frame(3).expect("a frame").interval.clusters.is_empty());
    assert_eq!(cut.frame(2).expect("a frame").outer_images(), [None, None]);
}

#[test]
fn another_scene_is_a_cut() {
    let scene = |number: u32| {
        let id = if number < 4 { 1 } else { 2 };
        frame(SIZE, move |at| is_in_disc(at).then_some((3.0, id, [-2.0, 0.0])))
    };
    let moves = |jump: f32, number: u32| {
        let settings = Settings { jump, ..Settings::default() };
        let mut input = PassesInput::new(move |number| Ok(scene(number)), [1, 8], &settings, SIZE, 1).expect("fine");
        !input.frame(number).expect("a frame").interval.clusters.is_empty()
    };
    assert_eq!([3, 4, 5].map(|number| moves(1.0, number)), [true, false, true]);
    assert!(moves(0.0, 4), "none is looked for");
}

/// Where there is no room for all, the mesh is of every other pixel, and in the same place.
#[test]
fn a_mesh_that_is_too_large_is_coarser() {
    let disc = || frame(SIZE, |at| is_in_disc(at).then_some((3.0, 1, [-2.0, 0.0])));
    let frames = [Seen::new(disc()), Seen::new(disc())];
    let shape = Shape { room: 4096, cell: 4, reach: 1.0 };
    let around = [None, Some(&frames[0]), Some(&frames[1]), None];
    let (fine, _) = mesh_of(around, shape).expect("a mesh");
    let (coarse, poses) = mesh_of(around, Shape { room: fine.points() - 1, ..shape }).expect("a mesh");
    assert!(coarse.points() < fine.points());
    let ends =
        |c: usize| poses[2].iter().map(|place| place[c]).fold((f32::MAX, f32::MIN), |(a, b), x| (a.min(x), b.max(x)));
    // A coarser border is within two pixels of the finer.
    for (axis, centre) in [(0, 23.0), (1, 19.0)] {
        let (low, high) = ends(axis);
        assert!((low - (centre - 15.3)).abs() < 2.5 && (high - (centre + 15.3)).abs() < 2.5, "{low} {high}");
    }
}
