use std::collections::HashMap;

use super::*;
use crate::io::scene::weld;

const ALL: [Builtin; 3] = [Builtin::Run, Builtin::Spin, Builtin::Crossing];

fn at(model: &Model, topology: &Topology, seconds: f64) -> Vec<DVec3> {
    let mut pose = vec![[0.0; 3]; topology.object.len()];
    model.positions(seconds, &mut pose);
    pose.into_iter().map(|p| DVec3::from(p.map(f64::from))).collect()
}

/// Volume within a closed surface.
fn volume(shape: &Shape) -> f64 {
    let cone = |c: &[u32; 3]| {
        let [a, b, c] = c.map(|corner| shape.positions[corner as usize]);
        a.dot(b.cross(c)) / 6.0
    };
    shape.triangles.iter().map(cone).sum()
}

fn shapes(edge: f64) -> [Shape; 5] {
    let white = [1.0; 3];
    [
        Shape::cuboid(DVec3::new(0.5, 1.0, 1.5), edge, white),
        Shape::ball(0.5, edge, white),
        Shape::cylinder(0.5, 2.0, edge, white),
        Shape::limb(0.5, 0.25, 1.0, edge, white),
        Shape::banded_capsule(0.5, 1.0, 3, edge, [white, [0.0; 3]]),
    ]
}

#[test]
fn shapes_are_closed_and_face_outwards() {
    for edge in [2.0, 0.3, 0.05] {
        for shape in shapes(edge) {
            let positions: Vec<_> = shape.positions.iter().map(|p| p.as_vec3().to_array()).collect();
            let points = weld(&vec![0; positions.len()], &[positions]);
            let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
            for corners in &shape.triangles {
                for i in 0..3 {
                    let [a, b] = [corners[i], corners[(i + 1) % 3]].map(|corner| points[corner as usize]);
                    assert_ne!(a, b, "{edge}");
                    // Each way counts against the other; no way is used twice.
                    *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { 1000 };
                }
                let [a, b, c] = corners.map(|corner| shape.positions[corner as usize]);
                let normal = (b - a).cross(c - a).normalize();
                // As far off as the coarsest ball is.
                let least = corners.iter().map(|&c| shape.normals[c as usize].dot(normal)).fold(1.0, f64::min);
                assert!(least > 0.35, "{edge}: {least}");
            }
            assert!(edges.values().all(|&uses| uses == 1001), "{edge}");
            assert!(shape.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-12));
        }
    }
}

#[test]
fn shapes_have_their_volumes() {
    use std::f64::consts::PI;
    let ball = 4.0 / 3.0 * PI * 0.125;
    // A cone's frustum and the parts of two balls that stand out of it; see [`Shape::limb`].
    let (r, s, l): (f64, f64, f64) = (0.5, 0.25, 1.0);
    let sine = (r - s) / l;
    let cosine = (1.0 - sine * sine).sqrt();
    let cap = |radius: f64, height: f64| PI * height * height * (3.0 * radius - height) / 3.0;
    let frustum = PI / 3.0 * (l - (r - s) * sine) * cosine * cosine * (r * r + r * s + s * s);
    let limb = frustum + cap(r, r * (1.0 + sine)) + cap(s, s * (1.0 - sine));
    let expected = [6.0, ball, PI * 0.5, limb, ball + PI * 0.25];
    for (shape, expected) in shapes(0.02).iter().zip(expected) {
        assert!((volume(shape) / expected - 1.0).abs() < 2e-3, "{} is not {expected}", volume(shape));
    }
    assert!((volume(&shapes(0.3)[0]) - 6.0).abs() < 1e-12);
}

#[test]
fn as_many_vertices_as_asked_for() {
    for which in ALL {
        for wanted in [2_000, 10_000, 100_000] {
            let (model, topology) = Model::new(which, wanted);
            let count = topology.object.len();
            assert!((count as f64 / f64::from(wanted) - 1.0).abs() < 0.05, "{}: {count} of {wanted}", which.name());
            assert_eq!(model.parts.iter().map(|(_, rest)| rest.len()).sum::<usize>(), count);
            assert_eq!((topology.colour.len(), topology.normal.len()), (count, count));
            assert!(topology.triangles.as_flattened().iter().all(|&corner| (corner as usize) < count));
            let same = |c: &[u32; 3]| c.iter().all(|&v| topology.object[v as usize] == topology.object[c[0] as usize]);
            assert!(topology.triangles.iter().all(same));
        }
        assert_eq!(Builtin::named(which.name()), Some(which));
        assert!(!Model::new(which, 0).1.triangles.is_empty());
        assert_eq!(Model::new(which, 3000).1, Model::new(which, 3000).1);
    }
    assert_eq!(Builtin::named("walk"), None);
}

#[test]
fn all_of_it_is_in_the_picture() {
    for which in ALL {
        let (model, topology) = Model::new(which, 1000);
        for frame in 0..which.frames() {
            let seconds = f64::from(frame) / which.fps();
            let camera = model.camera(seconds);
            camera.validate().expect("fit");
            let half = camera.half_extent([16, 9]);
            for p in at(&model, &topology, seconds) {
                let view = camera.rotation() * (p - camera.eye);
                let seen = view.x.abs() < half.x * view.z && view.y.abs() < half.y * view.z;
                assert!(seen && view.z > camera.near, "{} {frame}: {view}", which.name());
            }
        }
    }
}

#[test]
fn the_rotor_turns_as_it_says() {
    let (model, topology) = Model::new(Builtin::Spin, 1000);
    let rest = at(&model, &topology, 0.0);
    for seconds in [0.01, 0.4, 7.3, -1.0] {
        let turn = DQuat::from_rotation_z(TAU * SPIN_TURNS * seconds);
        for (p, rest) in at(&model, &topology, seconds).iter().zip(&rest) {
            assert!(p.distance(CENTRE + turn * (*rest - CENTRE)) < 1e-6, "{seconds}: {p}");
        }
    }
    assert_eq!(at(&model, &topology, 1.0 / SPIN_TURNS), rest);
    // On the axis, and far from it.
    assert!(rest.iter().any(|p| p.x == 0.0 && p.y == 1.0));
    assert!(rest.iter().any(|p| p.distance(CENTRE) > 0.98));
}

#[test]
fn the_bars_cross_as_they_say() {
    let (model, topology) = Model::new(Builtin::Crossing, 1000);
    let middle = at(&model, &topology, CROSSING_TIME);
    for seconds in [0.0, 0.9, 1.75] {
        for ((p, middle), object) in at(&model, &topology, seconds).iter().zip(&middle).zip(&topology.object) {
            let side = [1.0, -1.0][*object as usize];
            let x = side * CROSSING_SPEED * (seconds - CROSSING_TIME);
            assert!(p.distance(*middle + DVec3::X * x) < 1e-6 && p.z * side > 0.1, "{seconds}: {p}");
        }
    }
    for object in 0..2 {
        let own = topology.colour.iter().zip(&topology.object).filter(|(_, o)| **o == object);
        let mut colours: Vec<_> = own.map(|(colour, _)| colour.map(f32::to_bits)).collect();
        colours.sort_unstable();
        colours.dedup();
        assert_eq!(colours.len(), 2);
    }
}

#[test]
fn the_figure_runs() {
    use super::runner::{SPEED, STRIDES};
    let (model, topology) = Model::new(Builtin::Run, 2000);
    let stride = 1.0 / STRIDES;
    let mut lowest = f64::INFINITY;
    for step in 0..40 {
        let seconds = f64::from(step) / 40.0 * stride;
        let now = at(&model, &topology, seconds);
        // A stride later it is the same, only further on.
        for (p, q) in now.iter().zip(at(&model, &topology, seconds + stride)) {
            assert!((*p + DVec3::X * SPEED * stride).distance(q) < 1e-5, "{seconds}");
        }
        lowest = now.iter().map(|p| p.y).fold(lowest, f64::min);
        // Half a stride later the other side does it.
        let (now, later) = (runner::transforms(seconds), runner::transforms(seconds + stride / 2.0));
        for bone in 0..5 {
            let [right, left] = [now[3 + bone], later[8 + bone]].map(|bone| bone.translation);
            let expected = right * DVec3::new(1.0, 1.0, -1.0) + DVec3::X * SPEED * stride / 2.0;
            assert!(left.distance(expected) < 1e-9, "{bone} {seconds}");
        }
    }
    assert!(lowest.abs() < 0.01, "its feet are at {lowest} m");
    // The feet pass each other, and each is in front for half of the time.
    let ahead = |seconds: f64| {
        let bones = runner::transforms(seconds);
        bones[7].translation.x - bones[12].translation.x
    };
    let far = (0..40)
        .map(|step| ahead(f64::from(step) / 40.0 * stride))
        .fold((0.0f64, 0.0f64), |(low, high), x| (low.min(x), high.max(x)));
    assert!(far.0 < -0.7 && far.1 > 0.7, "{far:?}");
    let colours =
        topology.colour.iter().map(|colour| colour.map(f32::to_bits)).collect::<std::collections::HashSet<_>>();
    assert!(colours.len() >= 12, "{}", colours.len());
}
