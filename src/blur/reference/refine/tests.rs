use glam::{DVec3, Vec3};

use super::*;
use crate::blur::mesh::MeshInput;
use crate::blur::motion::{Motion, Pose, Window};
use crate::blur::reference::extent::extents;
use crate::blur::reference::watertight::border;
use crate::blur::settings::Clusters;
use crate::random::{hash, unit};
use crate::view::Camera;

const SIZE: [u32; 2] = [1920, 1080];

/// A sphere of 12 x 24 quadrilaterals.
fn sphere() -> (Mesh, Vec<Vec3>) {
    let (rows, columns) = (12_u32, 24_u32);
    let mut points = vec![Vec3::Y, -Vec3::Y];
    for row in 1..rows {
        for column in 0..columns {
            let polar = row as f32 / rows as f32 * std::f32::consts::PI;
            let around = column as f32 / columns as f32 * std::f32::consts::TAU;
            points.push(Vec3::new(polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin()));
        }
    }
    let at = |row: u32, column: u32| match row {
        0 => 0,
        _ if row == rows => 1,
        _ => 2 + (row - 1) * columns + column % columns,
    };
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let quad = [at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)];
            triangles.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
        }
    }
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    let input = MeshInput {
        vertices: points.len(),
        triangles: &triangles,
        objects: None,
        weld: None,
        normals: None,
        rest: None,
    };
    (Mesh::new(&input).unwrap(), points)
}

/// The interval of a sphere that turns, and whose upper half goes another way than its lower half.
fn turning(settings: &Settings, size: [u32; 2]) -> (Mesh, Interval) {
    let (mesh, points) = sphere();
    assert!(mesh.shells().of(0).is_some());
    let pose = |f: usize| -> Vec<[f32; 3]> {
        let t = f as f32 * 0.22;
        let place = |p: &Vec3| {
            let side = 0.35 * t * p.y.clamp(-0.2, 0.2) * 5.0;
            let (sin, cos) = (0.9 * t).sin_cos();
            [p.x * cos - p.y * sin + side, 1.0 + p.x * sin + p.y * cos, p.z + 0.2 * t]
        };
        points.iter().map(place).collect()
    };
    let poses: Vec<Vec<[f32; 3]>> = (0..12).map(pose).collect();
    let view = Camera { eye: DVec3::new(0.0, 1.2, 5.0), ..Camera::default() }.view(size);
    let poses: Vec<Pose> = poses.iter().map(|p| Pose { positions: p, view: &view, cut: false }).collect();
    let window = Window { frame: 5, poses: &poses, current: 5, between: &[] };
    let interval = Motion::new(settings, size).unwrap().interval(&mesh, &window, 1).unwrap();
    (mesh, interval)
}

fn rules<'a>(interval: &'a Interval, settings: &'a Settings) -> Rules<'a> {
    Rules { interval, settings, size: SIZE, seed: 3, budget: 1_000_000 }
}

fn refined(settings: &Settings) -> (Mesh, Interval, Refined) {
    let (mesh, interval) = turning(settings, SIZE);
    let rules = rules(&interval, settings);
    let refined = refine(&mesh, &extents(&mesh, &rules.pull(), &[]), &rules);
    (mesh, interval, refined)
}

/// All the bits of a vertex.
fn key(vertex: &Vertex) -> Vec<u32> {
    let rows = |p: &Piece| [p.origin, p.step, p.bend_begin, p.bend_end].concat();
    let own = [vertex.drawn[0], vertex.drawn[1], vertex.extent.time, vertex.extent.k, vertex.extent.l];
    let floats = vertex.pieces.iter().flat_map(rows).chain(vertex.motion).chain(own);
    floats.map(f32::to_bits).chain([vertex.label]).collect()
}

fn check_watertight(refined: &Refined) {
    let keys: Vec<Vec<u32>> = refined.vertices.iter().map(key).collect();
    let triangles: Vec<[Vec<u32>; 3]> =
        refined.triangles.iter().map(|t| t.corners.map(|corner| keys[corner as usize].clone())).collect();
    assert_eq!(border(&triangles).len(), 0);
}

/// Share of its base triangle.
fn area(triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.weights.map(|w| [f64::from(w[0]), f64::from(w[1])]);
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether the corners of a triangle of the mesh are in one cluster. Where clusters meet k' is not continuous.
fn is_within_a_cluster(mesh: &Mesh, interval: &Interval, base: u32) -> bool {
    let labels = mesh.triangles()[base as usize].map(|p| interval.labels[p as usize]);
    labels[0] > 0 && labels[0] == labels[1] && labels[0] == labels[2]
}

/// 99th percentile, by area of the mesh's triangles, and maximum of the distance between triangles and what they stand
/// for, at three random places in each.
fn departure(mesh: &Mesh, interval: &Interval, settings: &Settings, refined: &Refined) -> [f64; 2] {
    let rules = rules(interval, settings);
    let base = extents(mesh, &rules.pull(), &[]);
    let mut errors = Vec::new();
    for (i, triangle) in refined.triangles.iter().chain(&refined.triangles).chain(&refined.triangles).enumerate() {
        let corners = triangle.corners.map(|corner| &refined.vertices[corner as usize]);
        let points = mesh.triangles()[triangle.base as usize];
        if !is_within_a_cluster(mesh, interval, triangle.base) {
            continue;
        }
        let (u, v) = (unit(hash(8, i as u32, 0, 0)), unit(hash(8, i as u32, 0, 1)));
        let own = if u + v > 1.0 { [u + v - 1.0, 1.0 - u, 1.0 - v] } else { [1.0 - u - v, u, v] };
        let weights: [f32; 3] = std::array::from_fn(|k| (0..3).map(|c| own[c] * triangle.weights[c][k]).sum());
        // What the mesh's own triangle has there.
        let mix = |row: &dyn Fn(&Piece) -> [f32; 4], s: usize| -> [f32; 4] {
            std::array::from_fn(|c| {
                let piece = |k: usize| row(&interval.pieces[s * mesh.points() + points[k] as usize])[c];
                (0..3).map(|k| weights[k] * piece(k)).sum()
            })
        };
        let piece = |s| Piece {
            origin: mix(&|p| p.origin, s),
            step: mix(&|p| p.step, s),
            bend_begin: mix(&|p| p.bend_begin, s),
            bend_end: mix(&|p| p.bend_end, s),
        };
        let pieces: Vec<Piece> = (0..interval.segments.len()).map(piece).collect();
        let offset = (0..3).map(|k| weights[k] * base[points[k] as usize].offset).sum();
        let exact = Extent { offset, ..Extent::NONE };
        let whole = Vertex {
            pieces,
            motion: [0.0; 4],
            extent: exact,
            label: interval.labels[points[0] as usize],
            drawn: [0.0; 2],
            depth: 0.0,
        };
        let exact = rules.middle(&whole, &whole).drawn;
        let drawn: [f32; 2] = std::array::from_fn(|c| (0..3).map(|k| own[k] * corners[k].drawn[c]).sum());
        let error = f64::from(exact[0] - drawn[0]).hypot(f64::from(exact[1] - drawn[1]));
        errors.push((error, area(triangle)));
    }
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = errors.iter().map(|(_, area)| area).sum();
    assert!(whole > 600.0, "{whole}");
    let mut below = 0.0;
    let percentile = errors.iter().find(|(_, area)| {
        below += area;
        below >= 0.99 * whole
    });
    [percentile, errors.last()].map(|found| found.unwrap().0)
}

#[test]
fn the_distorted_mesh_is_within_tolerance_and_has_no_crack() {
    let coarse = Settings { tolerance: 1e4, ..Settings::default() };
    let (mesh, interval, whole) = refined(&coarse);
    assert_eq!((whole.rounds, whole.triangles.len()), (0, mesh.triangles().len()));
    assert!(departure(&mesh, &interval, &coarse, &whole)[0] > 8.0);
    for tolerance in [1.0, 0.5] {
        let settings = Settings { tolerance, ..Settings::default() };
        let (mesh, interval, refined) = refined(&settings);
        assert!(interval.clusters.len() > 1 && !interval.seams.is_empty());
        assert!(!refined.over_budget && refined.triangles.len() > 2 * mesh.triangles().len());
        check_watertight(&refined);
        let [p99, _] = departure(&mesh, &interval, &settings, &refined);
        assert!(p99 < f64::from(tolerance), "{tolerance}: {p99}");
    }
}

#[test]
fn seams_take_few_triangles() {
    let settings = Settings { tolerance: 4.0, ..Settings::default() };
    let (mesh, interval, refined) = refined(&settings);
    let at_seams = |base: u32| !is_within_a_cluster(&mesh, &interval, base);
    let whole = (0..mesh.triangles().len() as u32).filter(|base| at_seams(*base)).count();
    let parts = refined.triangles.iter().filter(|triangle| at_seams(triangle.base)).count();
    assert!(whole > 0 && parts < 12 * whole, "{parts} of {whole}");
}

#[test]
fn length_splits_until_no_edge_is_longer() {
    let settings = Settings { refine: Refine::Length, ..Settings::default() };
    let (mesh, interval, refined) = refined(&settings);
    check_watertight(&refined);
    for triangle in refined.triangles.iter().filter(|t| is_within_a_cluster(&mesh, &interval, t.base)) {
        let [a, b, c] = triangle.corners.map(|corner| &refined.vertices[corner as usize]);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let length = (p.drawn[0] - q.drawn[0]).hypot(p.drawn[1] - q.drawn[1]);
            assert!(length <= 15.001, "{length}");
        }
    }
}

#[test]
fn a_tolerance_of_nothing_ends_by_length_or_budget_and_says_so() {
    let settings = Settings { tolerance: 0.0, ..Settings::default() };
    let (mesh, interval) = turning(&settings, SIZE);
    let few = Rules { budget: 20_000, ..rules(&interval, &settings) };
    let short = refine(&mesh, &extents(&mesh, &few.pull(), &[]), &few);
    assert!(short.over_budget && short.triangles.len() <= 20_000 && short.rounds > 0);
    check_watertight(&short);
    // One small triangle to the end.
    let (mesh, interval) = turning(&settings, [192, 108]);
    let one = MeshInput {
        vertices: mesh.points(),
        triangles: &mesh.triangles()[200..201],
        objects: None,
        weld: None,
        normals: None,
        rest: None,
    };
    let one = Mesh::new(&one).unwrap();
    let settings = Settings { seam_smoothing: 0, ..settings };
    let rules = rules(&interval, &settings);
    let end = refine(&one, &extents(&one, &rules.pull(), &[]), &rules);
    assert!(!end.over_budget && end.rounds > 0 && end.rounds <= ROUNDS, "{}", end.rounds);
}

#[test]
fn an_edge_splits_alike_from_both_ends() {
    let settings = Settings { clusters: Clusters::Ldf, strength: 2.0, ..Settings::default() };
    let (mesh, interval, refined) = refined(&settings);
    let rules = rules(&interval, &settings);
    for [a, b, _] in mesh.triangles() {
        let (a, b) = (&refined.vertices[*a as usize], &refined.vertices[*b as usize]);
        assert_eq!(rules.splits(a, b, 0), rules.splits(b, a, 0));
        assert_eq!(key(&rules.middle(a, b)), key(&rules.middle(b, a)));
    }
    check_watertight(&refined);
}

#[test]
fn parts_cover_their_triangle() {
    let (mesh, _, refined) = refined(&Settings::default());
    let mut areas = vec![0.0; mesh.triangles().len()];
    for triangle in &refined.triangles {
        areas[triangle.base as usize] += area(triangle);
        assert!(triangle.weights.iter().all(|w| w[0] + w[1] + w[2] == 1.0));
    }
    assert!(areas.iter().all(|area| *area == 1.0));
    assert!(refined.triangles.is_sorted_by_key(|triangle| triangle.base));
}
