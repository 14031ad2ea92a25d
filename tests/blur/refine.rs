//! Refinement: the reference's triangles to the bit, without cracks, within its budget.

use std::collections::BTreeSet;

use celfx::blur::reference::extent::extents;
use celfx::blur::reference::refine::{Refined, Rules, refine};
use celfx::blur::reference::watertight::border;
use celfx::blur::settings::{Refine, Space};
use celfx::blur::{Desc, Interval, Mesh, Settings};
use celfx::low_level::blur::params::{BASE_MASK, CULLED, Control, ENDED_BY_BUDGET, Vertex};
use celfx::simulate::mesh::Builtin;

use crate::common::blur::{BlurRig, Shot, desc, incomplete};
use crate::scenes::{Animation, grid, interval, swing};
use crate::toon::Film;

const SIDES: [u32; 2] = [13, 9];

struct Case {
    mesh: Mesh,
    animation: Animation,
    desc: Desc,
}

impl Case {
    fn new(settings: Settings) -> Case {
        let mesh = grid(SIDES);
        let animation = swing(SIDES, 8, [480, 270], 0.4);
        let desc = Desc { most_triangles: 20_000, ..desc(animation.size, &mesh, settings) };
        Case { mesh, animation, desc }
    }

    fn labels(&self) -> Vec<u32> {
        let label = |p: u32| match p % SIDES[0] {
            0..3 => 0,
            3..8 => 1,
            _ => 2,
        };
        (0..SIDES[0] * SIDES[1]).map(label).collect()
    }

    /// The device's mesh, and the interval with the pieces that it made.
    fn refined(&self, i: usize) -> Option<(BlurRig, Interval)> {
        let segments = self.desc.segments as usize;
        let mut interval = interval(&self.animation, i, &self.labels(), 0.5, 12, segments);
        let mut rig = BlurRig::new(self.desc.clone(), self.mesh.clone())?;
        let knots = self.animation.knots(i, segments);
        let views = self.animation.views(i);
        let poses = Some((0, &self.animation.poses[..]));
        let shot = Shot { poses, interval: Some(&interval), views, knots: Some(&knots) };
        rig.frame(&shot).expect("a frame");
        interval.pieces = (0..segments).flat_map(|s| rig.pieces(s)).collect();
        Some((rig, interval))
    }

    fn reference(&self, interval: &Interval) -> Refined {
        let settings = &self.desc.settings;
        let (seed, size) = (self.desc.seed, self.desc.size);
        let budget = self.desc.most_triangles as usize;
        let rules = Rules { interval, settings, size, seed, budget };
        refine(&self.mesh, &extents(&self.mesh, &rules.pull(), &[]), &rules)
    }
}

/// Bits of where a vertex is drawn.
fn drawn(vertex: &Vertex) -> [u32; 3] {
    [vertex.drawn[0], vertex.drawn[1], vertex.drawn_time].map(f32::to_bits)
}

/// Triangles by their base, barycentric coordinates and drawn corners.
type Row = (u32, [[u32; 2]; 3], [[u32; 3]; 3]);

fn rows(rig: &mut BlurRig, mesh: &Mesh) -> BTreeSet<Row> {
    let (vertices, finished) = (rig.vertices(), rig.finished());
    let place = |base: u32, vertex: u32| {
        let vertex_of = vertices[vertex as usize];
        let corners = mesh.triangles()[base as usize];
        let whole = |corner: usize| f32::from(u8::from(corners[corner] == vertex)).to_bits();
        if vertex_of.is_point() { [whole(1), whole(2)] } else { vertex_of.barycentrics.map(f32::to_bits) }
    };
    let row = |triangle: &[u32; 4]| {
        assert_eq!(triangle[3] & CULLED, 0, "open meshes are drawn whole");
        let (base, corners) = (triangle[3] & BASE_MASK, [triangle[0], triangle[1], triangle[2]]);
        (base, corners.map(|v| place(base, v)), corners.map(|v| drawn(&vertices[v as usize])))
    };
    let rows: BTreeSet<Row> = finished.iter().map(row).collect();
    assert_eq!(rows.len(), finished.len(), "a triangle is there twice");
    rows
}

fn expected(refined: &Refined) -> BTreeSet<Row> {
    let row = |triangle: &celfx::blur::reference::refine::Triangle| {
        let places = triangle.weights.map(|[_, v, w]| [v.to_bits(), w.to_bits()]);
        let corners = triangle.corners.map(|v| {
            let vertex = &refined.vertices[v as usize];
            [vertex.drawn[0], vertex.drawn[1], vertex.extent.time].map(f32::to_bits)
        });
        (triangle.base, places, corners)
    };
    refined.triangles.iter().map(row).collect()
}

#[test]
fn triangles_are_the_references() {
    let settings = incomplete;
    let cases = [
        ("error", Settings { tolerance: 4.0, ..settings() }),
        ("length", Settings { refine: Refine::Length, edge: 40.0, ..settings() }),
        ("screen", Settings { tolerance: 4.0, space: Space::Screen, ..settings() }),
        ("strong", Settings { tolerance: 8.0, strength: 2.5, ..settings() }),
        ("no smoothing", Settings { tolerance: 8.0, seam_smoothing: 0, ..settings() }),
    ];
    for (name, settings) in cases {
        let case = Case::new(settings);
        let Some((mut rig, interval)) = case.refined(3) else { return };
        let refined = case.reference(&interval);
        let (found, expected) = (rows(&mut rig, &case.mesh), expected(&refined));
        eprintln!("{name}: {} triangles, {} rounds", found.len(), refined.rounds);
        assert!(found.len() > case.mesh.triangles().len(), "{name}: nothing is divided");
        let (more, less) = (found.difference(&expected).count(), expected.difference(&found).count());
        assert_eq!((more, less), (0, 0), "{name}: of {} triangles", expected.len());
        assert!(!refined.over_budget && rig.control().ended_by == 0, "{name}: it came to its end by itself");
    }
}

#[test]
fn what_is_outside_the_picture_is_not_refined() {
    // How far the camera is to the side; how far it is until nothing is seen of the mesh.
    for (aside, is_outside) in [(2.6, false), (4.5, true)] {
        for refine in [Refine::Error, Refine::Length] {
            let settings = Settings { tolerance: 2.0, edge: 40.0, refine, ..incomplete() };
            let mut case = Case::new(settings);
            for camera in &mut case.animation.cameras {
                camera.eye.x += aside;
                camera.target.x += aside;
            }
            let Some((mut rig, interval)) = case.refined(3) else { return };
            let refined = case.reference(&interval);
            assert!(rows(&mut rig, &case.mesh) == expected(&refined), "{refine:?} {aside}");
            let base = case.mesh.triangles().len();
            assert_eq!(refined.triangles.len() == base, is_outside, "{refine:?} {aside}: {}", refined.triangles.len());
            // Their after-images may be inside.
            case.desc.settings.ghosts.count = 1;
            let all = case.reference(&interval).triangles.len();
            assert!(all > refined.triangles.len(), "{refine:?} {aside}: {all}");
        }
    }
}

/// Edges that are not passed both ways, by the bits of what is drawn and of k'.
fn open_edges(rig: &mut BlurRig) -> Vec<[[u32; 3]; 2]> {
    let vertices = rig.vertices();
    let corners = |t: &[u32; 4]| [t[0], t[1], t[2]].map(|v| drawn(&vertices[v as usize]));
    border(&rig.finished().iter().map(corners).collect::<Vec<_>>())
}

#[test]
fn there_are_no_cracks() {
    for tolerance in [4.0, 1.0, 0.3] {
        let case = Case::new(Settings { tolerance, ..incomplete() });
        let Some((mut rig, _)) = case.refined(4) else { return };
        let border = open_edges(&mut rig);
        // The grid's own border, divided: a closed way on which each vertex has one edge before and one after.
        let ends: BTreeSet<_> = border.iter().flatten().collect();
        assert_eq!(ends.len(), border.len(), "tolerance {tolerance}: the border is one closed line");
        let vertices = rig.vertices();
        let on_border: BTreeSet<[u32; 3]> = (0..SIDES[0] * SIDES[1])
            .filter(|p| [0, SIDES[0] - 1].contains(&(p % SIDES[0])) || [0, SIDES[1] - 1].contains(&(p / SIDES[0])))
            .map(|p| drawn(&vertices[p as usize]))
            .collect();
        assert!(on_border.iter().all(|p| ends.contains(p)), "tolerance {tolerance}: the border's points are on it");
    }
}

#[test]
fn a_budget_ends_it_and_is_reported() {
    let mut case = Case::new(Settings { tolerance: 0.5, ..incomplete() });
    case.desc.most_triangles = 1000;
    let Some((mut rig, interval)) = case.refined(3) else { return };
    let refined = case.reference(&interval);
    let control = rig.control();
    assert!(refined.over_budget && control.ended_by == ENDED_BY_BUDGET && control.undivided > 0, "{control:?}");
    assert!(control.triangles <= 1000 && control.draw[0] == 3 * control.triangles);
    assert!(rows(&mut rig, &case.mesh) == expected(&refined));
    assert!(control.vertices as usize == refined.vertices.len());
}

/// Nothing ends where the tolerance is 0, but edges of a quarter of a pixel, the rounds and the budget.
#[test]
fn no_tolerance_ends() {
    let mut case = Case::new(Settings { tolerance: 0.0, ..incomplete() });
    (case.desc.size, case.animation.size) = ([48, 27], [48, 27]);
    case.desc.most_triangles = 400_000;
    let Some((mut rig, _)) = case.refined(3) else { return };
    let control = rig.control();
    eprintln!("{control:?}");
    assert!(control.ended_by != ENDED_BY_BUDGET, "edges below a quarter of a pixel are not divided: {control:?}");
    let (vertices, finished) = (rig.vertices(), rig.finished());
    let shortest = finished.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]).map(|edge| {
        let [a, b] = edge.map(|v| vertices[v as usize].drawn);
        (a[0] - b[0]).hypot(a[1] - b[1])
    });
    assert!(shortest.fold(f32::INFINITY, f32::min) < 0.25, "it went on down to a quarter of a pixel");
}

#[test]
fn same_frame_same_bits() {
    let case = Case::new(Settings { tolerance: 2.0, ..incomplete() });
    let Some((mut first, _)) = case.refined(3) else { return };
    let Some((mut second, _)) = case.refined(3) else { return };
    assert!(first.finished() == second.finished(), "triangles in the same order");
    let bits = |rig: &mut BlurRig| bytemuck::cast_slice::<_, u32>(&rig.vertices()).to_vec();
    assert!(bits(&mut first) == bits(&mut second));
}

/// Needles, whose edges are straight enough where they are looked at while parts of them are not, were divided until the
/// last round: of these frames each had some.
#[test]
fn a_runner_comes_to_its_end_by_itself() {
    let frames = [9, 13, 22, 27];
    for i in frames {
        let poses = i - 8..i + 10;
        let Some(mut film) = Film::new(Builtin::Run, 10_000, [512, 512], poses, incomplete(), false) else {
            return;
        };
        film.output(8, true);
        let Control { triangles, ended_by, undivided, .. } = film.rig.control();
        assert_eq!((ended_by, undivided), (0, 0), "frame {}: of {triangles} triangles", i + 1);
    }
}
