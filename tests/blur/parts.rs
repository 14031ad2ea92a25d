//! Parts that the host names, poses that its own skinning leaves on the device, and several meshes in one effect.

use celfx::blur::motion::{Motion, Window};
use celfx::blur::reference::extent::{extent, extent_in, rows};
use celfx::blur::settings::{Extent, Space};
use celfx::blur::{Cluster, Desc, Interval, Knot, MOST_SOURCES, Mesh, MeshInput, Parts, Settings, SkinnedInput};
use celfx::low_level::blur::layout;
use celfx::low_level::blur::params::{LARGEST_STEP, PointMotion};
use celfx::simulate::mesh::Builtin;
use celfx::view::View;

use crate::common::blur::{BlurRig, Shot, desc, incomplete};
use crate::common::views;
use crate::scenes::{Animation, Change, grid, swing};
use crate::toon::Film;

const SIZE: [u32; 2] = [160, 90];

/// A mesh in three bands of its vertices.
pub fn bands(mesh: &Mesh) -> Parts {
    let vertices = mesh.file_to_point().len() as u32;
    Parts::new(mesh, &(0..vertices).map(|vertex| 9 - 3 * vertex / vertices).collect::<Vec<_>>()).expect("parts")
}

/// What f64 finds, and what the device makes trajectories from.
fn expected(animation: &Animation, mesh: &Mesh, settings: &Settings, parts: &Parts, i: usize) -> (Interval, Vec<Knot>) {
    let seen = animation.all_seen();
    let poses = animation.poses(&seen);
    let window = Window { frame: i as u32, poses: &poses, current: i, between: &[] };
    let mut motion = Motion::new(settings, animation.size).expect("settings");
    let interval = motion.interval_of_parts(mesh, &window, parts, 1).expect("an interval");
    (interval, motion.knots(&window).expect("knots").to_vec())
}

fn shot<'a>(animation: &'a Animation, i: usize, interval: &'a Interval, knots: &'a [Knot], is_first: bool) -> Shot<'a> {
    let poses = is_first.then_some((0, &animation.poses[..]));
    Shot { poses, interval: Some(interval), views: animation.views(i), knots: Some(knots) }
}

/// Compares what the device has found of an interval.
fn compare(rig: &mut BlurRig, interval: &Interval, name: &str) {
    let points = interval.labels.len();
    let (motions, labels) = (rig.read::<PointMotion>(layout::MOTIONS, points), rig.read::<u32>(layout::LABELS, points));
    let clusters: Vec<Cluster> = rig.read(layout::CLUSTERS, interval.clusters.len());
    let vertices = rig.vertices();
    assert!(labels.iter().any(|label| *label > 0), "{name}: nothing moves");
    for point in 0..points {
        let expected = interval.motion[point];
        let [x, y] = motions[point].position;
        let [vx, vy] = motions[point].velocity;
        // Splines in f32: 1e-4 pixels of what is off from frame i, whose own place is rounded to 2 ulp of up to 250 pixels; a
        // velocity is a difference of such numbers in a third of a frame.
        for ((found, expected), most) in [x, y, vx, vy].into_iter().zip(expected).zip([3e-4, 3e-4, 1e-3, 1e-3]) {
            let most = most * (expected.abs() / 250.0).max(1.0);
            assert!((found - expected).abs() <= most, "{name}, point {point}: {found} is not {expected}");
        }
        let is_near = |way: f32| (way - 0.5).abs() < 1e-3;
        let way = interval.motion[point][2].hypot(interval.motion[point][3]);
        assert!(labels[point] == interval.labels[point] || is_near(way), "{name}, point {point} of {way} pixels");
    }
    for (label, (found, expected)) in (1..).zip(clusters.iter().zip(&interval.clusters)) {
        assert_eq!((found.object, found.points), (expected.object, expected.points), "{name}, part {label}");
        // Half a tooth may be one or none.
        assert!(found.teeth.abs_diff(expected.teeth) <= 1, "{name}: {found:?} is not {expected:?}");
        let members: Vec<usize> = (0..points).filter(|point| interval.labels[*point] == label).collect();
        let places: Vec<[f32; 2]> =
            members.iter().map(|point| [interval.motion[*point][0], interval.motion[*point][1]]).collect();
        let width = |[dx, dy]: [f32; 2]| {
            let along = places.iter().map(|[x, y]| dx * x + dy * y);
            along.clone().fold(f32::MIN, f32::max) - along.fold(f32::MAX, f32::min)
        };
        let diameter = width([1.0, 0.0]).hypot(width([0.0, 1.0]));
        assert_eq!(found.has_rows(), expected.has_rows(), "{name}, part {label}");
        if found.has_rows() {
            compare_rows(rig, found, expected, label, diameter);
            continue;
        }
        for point in members {
            let motion @ [.., vx, vy] = interval.motion[point];
            let speed = vx.hypot(vy);
            let [dx, dy] = [vx / speed, vy / speed];
            let vertex = &vertices[point];
            let found = [vertex.k, vertex.l];
            let ways = [[dx, dy], [dy, -dx]];
            for ((found, expected), way) in found.into_iter().zip(extent(motion, &places)).zip(ways) {
                // What lies between two neighbouring directions is missed by up to half its side times the tangent of half their
                // angle; at both ends.
                let most = 0.5 * LARGEST_STEP * diameter / width(way) + 1e-4;
                assert!((found - expected).abs() <= most, "{name}, point {point}: {found} is not {expected}");
            }
        }
    }
}

/// Compares what the device has found of a part with rows: with the host's, and row by row with all edges of what the device has.
fn compare_rows(rig: &mut BlurRig, found: &Cluster, expected: &Cluster, label: u32, diameter: f32) {
    let points = rig.mesh.points();
    let (motions, labels) = (rig.read::<PointMotion>(layout::MOTIONS, points), rig.read::<u32>(layout::LABELS, points));
    let bounds: Vec<[f32; 2]> = rig.read(layout::BOUNDS, found.bounds_end as usize);
    let bounds = &bounds[found.bounds_begin as usize..];
    for axis in 0..2 {
        let off = found.ahead[axis] - expected.ahead[axis];
        assert!(off.abs() < 1e-4, "part {label}: {:?} is not {:?}", found.ahead, expected.ahead);
    }
    // Across, a part is as wide as the farthest points in many directions say, and turned by what the direction is off.
    let most = LARGEST_STEP * diameter + 0.1;
    assert!((found.aside - expected.aside).abs() < most && (found.width - expected.width).abs() < most, "part {label}");
    let count = (found.width / (3.0 * SIZE[1] as f32 / 1080.0)).ceil() as usize + 1;
    assert_eq!(bounds.len(), count.min(256), "part {label}: {} pixels", found.width);
    let places: Vec<[f64; 2]> = motions.iter().map(|motion| motion.position.map(f64::from)).collect();
    let is_member = |point: usize| labels[point] == label;
    let is_member = &is_member;
    let edges = (0..points).filter(|point| is_member(*point)).flat_map(|point| {
        let others = rig.mesh.neighbours().of(point).iter().map(|other| *other as usize);
        others.filter(move |other| *other > point && is_member(*other)).map(move |other| [point, other])
    });
    let (edges, members): (Vec<[usize; 2]>, Vec<usize>) =
        (edges.collect(), (0..points).filter(|p| is_member(*p)).collect());
    let place_of = |point: usize| members.binary_search(&point).expect("a member");
    let edges: Vec<[usize; 2]> = edges.iter().map(|edge| edge.map(place_of)).collect();
    let own: Vec<[f64; 2]> = members.iter().map(|point| places[*point]).collect();
    for (row, (found, expected)) in bounds.iter().zip(rows(found, &own, &edges, bounds.len())).enumerate() {
        // Places along and across are sums of products of up to 250 pixels, rounded to 3e-5; edges are steep at most 10 times.
        let most = 1e-3 * (expected[0].abs().max(expected[1].abs()) / 250.0).max(1.0);
        let off = (0..2).map(|side| (f64::from(found[side]) - expected[side]).abs()).fold(0.0, f64::max);
        assert!(off < most, "part {label}, row {row} of {}: {found:?} is not {expected:?}", bounds.len());
    }
    let vertices = rig.vertices();
    for point in members {
        let PointMotion { position: [x, y], velocity: [vx, vy] } = motions[point];
        let expected = extent_in([x, y, vx, vy], found, bounds);
        assert_eq!([vertices[point].k, vertices[point].l], expected, "part {label}, point {point}");
    }
}

#[test]
fn the_device_finds_of_parts_what_f64_finds() {
    // Each part has more than a workgroup looks at.
    let sides = [41, 25];
    let camera: Change = |view, _| view;
    let (row, part) = (Extent::Row, Extent::Part);
    for (name, space, change, eye, extent) in [
        ("homogeneous", Space::Homogeneous, camera, None, row),
        ("whole", Space::Homogeneous, camera, None, part),
        ("screen", Space::Screen, camera, None, part),
        ("jittered", Space::Homogeneous, |view, frame| views::jittered(views::moved(view), frame), None, row),
        ("orthographic", Space::Homogeneous, |view, _| views::parallel(view, 4.0, 3.0), None, row),
        // Some of the mesh is behind it in some frames.
        ("amidst", Space::Homogeneous, camera, Some(0.45), row),
        ("whole amidst", Space::Homogeneous, camera, Some(0.45), part),
    ] {
        let mut animation = Animation { change, ..swing(sides, 12, [960, 540], 0.3) }.through_window(SIZE);
        for camera in &mut animation.cameras {
            camera.eye.z = eye.unwrap_or(camera.eye.z);
            camera.target.z = eye.map_or(camera.target.z, |_| -2.0);
        }
        let (mesh, settings) = (grid(sides), Settings { space, strength: 2.0, extent, ..incomplete() });
        let parts = bands(&mesh);
        let desc = Desc { parts: Some(parts.sizes()), ..desc(animation.size, &mesh, settings.clone()) };
        let Some(mut rig) = BlurRig::new(desc, mesh.clone()) else { return };
        rig.parts = Some(parts.clone());
        for i in [4, 9] {
            let (interval, knots) = expected(&animation, &mesh, &settings, &parts, i);
            rig.frame(&shot(&animation, i, &interval, &knots, i == 4)).expect("a frame");
            compare(&mut rig, &interval, name);
        }
    }
}

/// Points that stand still are of no part, and what has nothing that moves is passed.
#[test]
fn what_stands_still_is_not_smeared() {
    let sides = [12, 9];
    let (mesh, settings) = (grid(sides), incomplete());
    // Jitter is no motion.
    let change: Change = |view, frame| View { jitter: [0.9 * (frame % 2) as f64 - 0.45, 0.0], ..view };
    let mut animation = Animation { change, ..swing(sides, 12, [960, 540], 0.3) }.through_window(SIZE);
    let parts = bands(&mesh);
    let still: Vec<usize> = (0..mesh.points()).filter(|point| parts.labels()[*point] != 2 && point % 5 != 0).collect();
    let still: Vec<usize> = still.into_iter().chain((0..mesh.points()).filter(|p| parts.labels()[*p] == 1)).collect();
    let camera = animation.cameras[0];
    animation.cameras.fill(camera);
    let first = animation.poses[0].clone();
    animation.poses.iter_mut().for_each(|pose| still.iter().for_each(|point| pose[*point] = first[*point]));
    let desc = Desc { parts: Some(parts.sizes()), ..desc(animation.size, &mesh, settings.clone()) };
    let Some(mut rig) = BlurRig::new(desc, mesh.clone()) else { return };
    rig.parts = Some(parts.clone());
    let (interval, knots) = expected(&animation, &mesh, &settings, &parts, 5);
    rig.frame(&shot(&animation, 5, &interval, &knots, true)).expect("a frame");
    let labels: Vec<u32> = rig.read(layout::LABELS, mesh.points());
    assert!(still.iter().all(|point| labels[*point] == 0) && labels.contains(&2));
    compare(&mut rig, &interval, "still");
    assert_eq!(rig.read::<Cluster>(layout::CLUSTERS, 3)[0].points, 0);
}

/// Of a rectangle, all corners are found: k is that of f32 brute force, also along directions between those of its outline.
#[test]
fn corners_of_an_outline_are_exact() {
    let (mesh, settings) = (grid([9, 5]), Settings { extent: Extent::Part, ..incomplete() });
    let parts = Parts::new(&mesh, &[0; 45]).expect("parts");
    // Exactly along an axis, too.
    for (angle, off) in [(0.0_f32, 0.0_f32), (0.7, -0.011), (0.7, 0.006), (1.31, 0.003), (2.0, -0.009)] {
        let pose = |frame: u8| {
            let ([sin, cos], way) = ([angle.sin(), angle.cos()], 0.2 * f32::from(frame) - 0.6);
            let place = |point: u8| {
                let [u, v] = [0.2 * f32::from(point % 9) - 0.8, 0.1 * f32::from(point / 9) - 0.2];
                [
                    cos * u - sin * v + way * (angle + off).cos(),
                    sin * u + cos * v + way * (angle + off).sin() + 1.0,
                    0.0,
                ]
            };
            (0..45).map(place).collect()
        };
        let cameras = vec![swing([2, 2], 1, SIZE, 0.0).cameras[0]; 6];
        let animation = Animation::new((0..6).map(pose).collect(), cameras, SIZE);
        let desc = Desc { parts: Some(parts.sizes()), ..desc(SIZE, &mesh, settings.clone()) };
        let Some(mut rig) = BlurRig::new(desc, mesh.clone()) else { return };
        rig.parts = Some(parts.clone());
        let (interval, knots) = expected(&animation, &mesh, &settings, &parts, 2);
        rig.frame(&shot(&animation, 2, &interval, &knots, true)).expect("a frame");
        let places: Vec<[f32; 2]> = interval.motion.iter().map(|[x, y, ..]| [*x, *y]).collect();
        for (vertex, motion) in rig.vertices().iter().zip(&interval.motion) {
            let [k, l] = extent(*motion, &places);
            // Positions are off by 3e-4 pixels, of at least 20.
            assert!((vertex.k - k).abs().max((vertex.l - l).abs()) < 1e-4, "{angle} {off}: {vertex:?}, {k} {l}");
        }
    }
}

/// Pictures of parts that the device finds are those of parts that the host has found, but for what the hull of directions is off.
#[test]
fn pictures_of_parts_are_those_of_the_host() {
    let film = |on_device: bool| {
        let mut film = Film::new(Builtin::Run, 1500, SIZE, 20..30, Settings::default(), false)?;
        let parts = bands(&film.mesh);
        if on_device {
            let desc = Desc { parts: Some(parts.sizes()), ..film.rig.desc().clone() };
            let toon = film.rig.toon;
            film.rig = BlurRig::new(desc, film.mesh.clone())?;
            (film.rig.toon, film.rig.colours, film.rig.parts) = (toon, film.colours.clone(), Some(parts.clone()));
        }
        // Only a host that has the poses knows what is closed.
        film.rig.are_closed = false;
        let (interval, knots) = expected(&film.animation, &film.mesh, &film.settings, &parts, 4);
        film.rig.frame(&shot(&film.animation, 4, &interval, &knots, true)).expect("a frame");
        Some(film.rig.picture())
    };
    let Some(given) = film(false) else { return };
    let found = film(true).expect("a device");
    let off = |(a, b): &(&[f32; 4], &[f32; 4])| (0..4).any(|c| (a[c] - b[c]).abs() > 0.1);
    let count = given.iter().zip(&found).filter(off).count();
    // Teeth that are moved by a share of a pixel change pixels along their borders.
    assert!(count * 200 < given.len(), "{count} of {} pixels", given.len());
}

/// A skinned vertex buffer: positions among other things, vertices that are one point, two meshes, one of which lies farther
/// on in its buffer.
#[test]
fn poses_are_read_where_the_host_has_them() {
    let triangles = [[0, 1, 2], [3, 4, 5]];
    let weld = [0, 1, 2, 2, 3, 0];
    let welded = Mesh::new(&MeshInput {
        vertices: 6,
        triangles: &triangles,
        objects: None,
        weld: Some(&weld),
        normals: None,
        rest: None,
    });
    let meshes = [welded.expect("a mesh"), grid([4, 3])];
    let mesh = Mesh::join(&[&meshes[0], &meshes[1]]).expect("a mesh");
    let place = |frame: u32, vertex: u32| [0.05 * vertex as f32, 0.1 * frame as f32, 0.01 * (vertex * frame) as f32];
    // A vertex has 8 floats in the one, of which the position is the last but one; a pose stands behind the other.
    let (strides, starts, vertices) = ([8, 3], [4, 0], [6, 12]);
    let values = |source: usize| {
        let count = (strides[source] * vertices[source]) as usize;
        let mut values = vec![f32::NAN; starts[source] + 5 * count];
        for (frame, vertex) in (0..5).flat_map(|frame| (0..vertices[source]).map(move |vertex| (frame, vertex))) {
            let at = starts[source] + frame as usize * count + (vertex * strides[source]) as usize;
            values[at..at + 3].copy_from_slice(&place(frame, vertex + 6 * source as u32));
        }
        values
    };
    let values = [values(0), values(1)];
    let sources = [(&values[0][..], strides[0], vertices[0]), (&values[1][..], strides[1], vertices[1])];
    let animation = swing([4, 4], 5, [64, 36], 0.1);
    let desc = Desc { frames_resident: 5, ..desc([64, 36], &mesh, incomplete()) };
    let Some(mut rig) = BlurRig::of_sources(desc, mesh.clone(), &sources) else { return };
    for frame in 0..5 {
        let mut offsets = [0; MOST_SOURCES];
        for source in [0, 1] {
            let pose = u64::from(strides[source] * vertices[source]) * u64::from(frame);
            offsets[source] = 4 * (starts[source] as u64 + pose);
        }
        rig.skinned = Some(SkinnedInput { frame, offsets });
        rig.frame(&Shot { poses: None, interval: None, views: animation.views(1), knots: None }).expect("a frame");
    }
    let points = mesh.points();
    let found: Vec<[f32; 3]> = rig.read(layout::POSES, 5 * points);
    for frame in 0..5 {
        let expected: Vec<_> = mesh.point_to_file().iter().map(|vertex| place(frame, *vertex)).collect();
        assert_eq!(found[frame as usize * points..][..points], expected, "frame {frame}");
    }
    // What the host makes in the same command buffer is waited for as its buffer says.
    rig.skinning = vec![0.625; 4 + 8 * 6];
    rig.skinned = Some(SkinnedInput { frame: 5, offsets: [16, 0, 0, 0, 0, 0, 0, 0] });
    rig.frame(&Shot { poses: None, interval: None, views: animation.views(1), knots: None }).expect("a frame");
    assert_eq!(rig.read::<[f32; 3]>(layout::POSES, 4), [[0.625; 3]; 4]);
    let beyond = SkinnedInput { frame: 5, offsets: [4 * values[0].len() as u64; MOST_SOURCES] };
    let odd = SkinnedInput { frame: 5, offsets: [2; MOST_SOURCES] };
    for skinned in [beyond, odd] {
        rig.skinned = Some(skinned);
        let shot = Shot { poses: None, interval: None, views: animation.views(1), knots: None };
        let error = rig.frame(&shot).expect_err("it is refused").to_string();
        assert!(error.contains("positions of source 0"), "{error}");
    }
}

/// The knots of poses that only the device has are those of poses that are all different.
#[test]
fn knots_need_no_positions() {
    let animation = swing([4, 3], 12, [960, 540], 0.3);
    let settings = Settings { strength: 3.0, jump: 0.0, ..incomplete() };
    let mut motion = Motion::new(&settings, animation.size).expect("settings");
    let (seen, views) = (animation.all_seen(), (0..12).map(|frame| animation.view(frame)).collect::<Vec<_>>());
    for current in [0, 5, 10, 11] {
        let window = Window { frame: current as u32, poses: &animation.poses(&seen), current, between: &[] };
        let mesh = grid([4, 3]);
        let interval = motion.interval(&mesh, &window, 1).expect("an interval");
        let expected = motion.knots(&window).map(<[_]>::to_vec);
        let found = motion.knots_of_views(&views, current);
        assert_eq!(found.map(|(knots, _)| knots), expected.as_deref(), "frame {current}");
        assert!(found.is_none_or(|(_, segments)| segments == interval.segments), "frame {current}");
    }
}
