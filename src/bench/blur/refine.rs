//! Pass `refine`: triangles divided until their edges are short (the paper's rule), or until they follow what is drawn.
//! The error is how far the surface that is drawn is from where each of its points should be.

use super::EFFECT;
use super::scene::{FULL_HD, Prepared, SEED, Scene};
use crate::bench::measure::{Deviation, Spread, interleaved};
use crate::bench::report::{Accuracy, Row, Subject};
use crate::bench::rig::{EffectId, Rig};
use crate::bench::{Outcome, Session};
use crate::blur::Settings;
use crate::blur::layout::{CONTROL, FINISHED, VERTICES};
use crate::blur::params::{BASE_MASK, CULLED, Control, ENDED_BY_BUDGET, Piece, Vertex};
use crate::blur::reference::extent::{self, Pull};
use crate::blur::reference::path::Path;
use crate::blur::settings::Refine;
use crate::error::Result;
use crate::plan::Plan;
use crate::random::{hash, unit};
use crate::simulate::mesh::Builtin;
use bytemuck::Zeroable;

const PASS: &str = "refine";
const VARIANTS: [(&str, (Refine, f32)); 8] = [
    ("length 15", (Refine::Length, 15.0)),
    ("length 8", (Refine::Length, 8.0)),
    ("length 4", (Refine::Length, 4.0)),
    ("length 3", (Refine::Length, 3.0)),
    ("length 2", (Refine::Length, 2.0)),
    ("error 2", (Refine::Error, 2.0)),
    ("error 1", (Refine::Error, 1.0)),
    ("error 0.5", (Refine::Error, 0.5)),
];
/// What `--quick` divides the picture's sides by.
const CUT: u32 = 2;
/// Name and vertices. The Fox of the glTF samples has 576 triangles.
const WORKLOADS: [(&str, u32); 2] = [("fox-like", 330), ("run", 10_000)];
/// Triangles that there may be, where the device has room for them.
const MOST_TRIANGLES: u32 = 2_000_000;
/// Random places on the surface.
const PLACES: u32 = 20_000;
/// The error at which triangles are compared, in pixels.
const COMPARED: f64 = 0.5;

pub(super) fn measure(session: &mut Session) -> Outcome {
    for (name, vertices) in WORKLOADS {
        let (name, size) = session.picture(name, FULL_HD, CUT);
        let variants = session.wanted(PASS, &name, &VARIANTS);
        if !variants.is_empty() {
            session.next(&format!("blur refine {name}"))?;
            measure_workload(session, &name, size, vertices, &variants)?;
            session.rig.clear();
        }
    }
    Ok(())
}

/// Results of a variant.
struct Made {
    triangles: u64,
    accuracy: Accuracy,
}

fn measure_workload(
    session: &mut Session,
    name: &str,
    size: [u32; 2],
    vertices: u32,
    variants: &[&(&str, (Refine, f32))],
) -> Outcome {
    let scene = Scene::builtin(Builtin::Run, vertices, size)?;
    let mut runs: Vec<(EffectId, Plan)> = Vec::new();
    let mut made = Vec::new();
    for (variant, (refine, amount)) in variants {
        session.next(&format!("blur refine {name}: {variant}"))?;
        let rig = &mut session.rig;
        let settings = Settings { refine: *refine, edge: *amount, tolerance: *amount, ..Settings::default() };
        let prepared = scene.prepare(&settings)?;
        let effect = rig.effect(scene.desc(&settings, MOST_TRIANGLES))?;
        rig.frame(effect, &scene.take(&prepared, None).scene())?;
        let surface = Surface::read(rig, effect, &scene, &prepared, &settings)?;
        if surface.is_cut_short {
            session.notes.push(format!("blur refine {name}: {variant} had no room for more triangles"));
        }
        made.push(Made { triangles: surface.triangles.len() as u64, accuracy: surface.accuracy() });
        runs.push((effect, rig.steps(effect, |pass| matches!(pass.name, "blur.params" | "blur.refine"))));
    }
    let (rig, quick) = (&mut session.rig, session.quick);
    let times = interleaved(variants.len(), quick, |i| rig.replay(runs[i].0, &runs[i].1))?;
    session.notes.extend(compare(name, variants, &made, &times));
    for ((((variant, _), times), made), (effect, plan)) in variants.iter().zip(&times).zip(&made).zip(runs) {
        let work = session.rig.work_of_replay(effect, &plan)?;
        let (variant, workload) = ((*variant).to_owned(), name.to_owned());
        let subject = Subject { pass: PASS, variant, workload, items: made.triangles };
        session.rows.push(Row::new(EFFECT, subject, times, &made.accuracy, work, &session.limits));
    }
    Ok(())
}

/// How many triangles each rule takes to keep 99 % of the surface within [`COMPARED`].
fn compare(name: &str, variants: &[&(&str, (Refine, f32))], made: &[Made], times: &[Spread]) -> Option<String> {
    let least = |rule: Refine| {
        let all = variants.iter().zip(made).zip(times).filter(|((variant, _), _)| variant.1.0 == rule);
        let good = all.filter(|((_, made), _)| made.accuracy.as_ref().is_some_and(|(d, _)| d.p99 <= COMPARED));
        good.min_by_key(|((_, made), _)| made.triangles)
    };
    let ((error, own), own_time) = least(Refine::Error)?;
    let found = format!("blur refine {name}: p99 within {COMPARED} px: {} with {} triangles", error.0, own.triangles);
    Some(match least(Refine::Length) {
        Some(((length, other), time)) => format!(
            "{found}, {} with {}: {:.1} x as many, {:.1} x the time",
            length.0,
            other.triangles,
            other.triangles as f64 / own.triangles as f64,
            time.gpu_ms / own_time.gpu_ms
        ),
        None => format!("{found}, no length"),
    })
}

/// The surface that an effect has made.
struct Surface<'a> {
    scene: &'a Scene,
    prepared: &'a Prepared,
    settings: &'a Settings,
    vertices: Vec<Vertex>,
    /// Those that are not turned away in both frames: three vertices, and the triangle of the mesh. The others are left
    /// as they are.
    triangles: Vec<[u32; 4]>,
    /// Whether there was no room for more.
    is_cut_short: bool,
}

impl Surface<'_> {
    fn read<'a>(
        rig: &mut Rig,
        effect: EffectId,
        scene: &'a Scene,
        prepared: &'a Prepared,
        settings: &'a Settings,
    ) -> Result<Surface<'a>> {
        let control: Vec<Control> = rig.read(effect, CONTROL, 1)?;
        let control = control.first().copied().unwrap_or(Control::zeroed());
        let mut drawn: Vec<[u32; 4]> = rig.read(effect, FINISHED, control.triangles as usize)?;
        drawn.retain(|triangle| triangle[3] & CULLED == 0);
        Ok(Surface {
            scene,
            prepared,
            settings,
            vertices: rig.read(effect, VERTICES, control.vertices as usize)?,
            triangles: drawn,
            is_cut_short: control.ended_by == ENDED_BY_BUDGET,
        })
    }

    /// Distances of places that are evenly spread over the surface at rest, between the triangle that is drawn there and
    /// where it should be. Only triangles of the mesh whose corners are of one cluster count: what is between clusters is
    /// defined by division itself.
    fn accuracy(&self) -> Accuracy {
        let mut sum = 0.0;
        let areas = self.triangles.iter().map(|triangle| {
            sum += self.area(triangle);
            sum
        });
        let sums: Vec<f64> = areas.collect();
        let draw = |i: u32, dimension: u32| f64::from(unit(hash(9, i, 0, dimension)));
        let distance = |i: u32| {
            let wanted = draw(i, 0) * sum;
            let triangle = self.triangles[sums.partition_point(|sum| *sum <= wanted).min(sums.len() - 1)];
            let (root, share) = (draw(i, 1).sqrt(), draw(i, 2));
            self.distance(&triangle, [1.0 - root, root * (1.0 - share), root * share])
        };
        let places = if sum > 0.0 { PLACES } else { 0 };
        let of = format!("exact map in px, at {PLACES} places of the surface");
        Deviation::of((0..places).map(distance).collect()).map(|deviation| (deviation, of))
    }

    fn base(&self, triangle: &[u32; 4]) -> [u32; 3] {
        self.scene.mesh.triangles()[(triangle[3] & BASE_MASK) as usize]
    }

    /// Barycentrics in the base triangle.
    fn barycentrics(&self, base: &[u32; 3], vertex: u32) -> [f64; 3] {
        let vertex_of = &self.vertices[vertex as usize];
        if vertex_of.is_point() {
            return base.map(|corner| f64::from(u8::from(corner == vertex)));
        }
        let [b, c] = vertex_of.barycentrics.map(f64::from);
        [1.0 - b - c, b, c]
    }

    /// Area of a part of the surface in frame i; 0 if its places do not count.
    fn area(&self, triangle: &[u32; 4]) -> f64 {
        let base = self.base(triangle);
        let [a, b, c] = base.map(|corner| self.prepared.interval.labels[corner as usize]);
        if a == 0 || a != b || a != c {
            return 0.0;
        }
        let pose = &self.scene.poses[self.scene.current];
        let [p, q, r] = base.map(|corner| glam::DVec3::from(pose[corner as usize].map(f64::from)));
        let [u, v, w] = [0, 1, 2].map(|i| self.barycentrics(&base, triangle[i]));
        let part = (v[1] - u[1]) * (w[2] - u[2]) - (v[2] - u[2]) * (w[1] - u[1]);
        0.5 * (q - p).cross(r - p).length() * part.abs()
    }

    /// How far a place on a triangle is from where it should be.
    fn distance(&self, triangle: &[u32; 4], place: [f64; 3]) -> f64 {
        let base = self.base(triangle);
        let (mut barycentrics, mut drawn) = ([0.0; 3], [0.0; 2]);
        for (share, vertex) in place.into_iter().zip(&triangle[..3]) {
            let of_vertex = self.barycentrics(&base, *vertex);
            barycentrics = [0, 1, 2].map(|i| barycentrics[i] + share * of_vertex[i]);
            let position = self.vertices[*vertex as usize].drawn;
            drawn = [0, 1].map(|i| drawn[i] + share * f64::from(position[i]));
        }
        let exact = self.exact(&base, barycentrics);
        (drawn[0] - f64::from(exact[0])).hypot(drawn[1] - f64::from(exact[1]))
    }

    /// Where a place of the mesh is drawn: as a vertex there would be.
    fn exact(&self, base: &[u32; 3], barycentrics: [f64; 3]) -> [f32; 2] {
        let (interval, settings) = (&self.prepared.interval, self.settings);
        let points = self.scene.mesh.points();
        let mix = |of: &dyn Fn(usize) -> f32| -> f32 {
            base.iter().zip(barycentrics).map(|(corner, share)| share * f64::from(of(*corner as usize))).sum::<f64>()
                as f32
        };
        let row = |of: fn(&Piece) -> &[f32; 4], s: usize| {
            [0, 1, 2, 3].map(|i| mix(&|p| of(&interval.pieces[s * points + p])[i]))
        };
        let piece = |s: usize| Piece {
            origin: row(|piece| &piece.origin, s),
            step: row(|piece| &piece.step, s),
            bend_begin: row(|piece| &piece.bend_begin, s),
            bend_end: row(|piece| &piece.bend_end, s),
        };
        let pieces: Vec<Piece> = (0..interval.segments.len()).map(piece).collect();
        let path = Path { segments: &interval.segments, pieces: &pieces, on_screen: false };
        let state = path.at(settings.reference_time);
        let ([x, y], [vx, vy]) = (state.position, state.velocity);
        let label = interval.labels[base[0] as usize];
        let Some(cluster) = interval.cluster(label) else { return path.at(1.0).position };
        let [k, l] = extent::extent_in([x, y, vx, vy], cluster, interval.bounds_of(cluster));
        let (offset, share) = (mix(&|p| self.vertices[p].smoothing), mix(&|p| self.vertices[p].share));
        let pull = Pull { interval, settings, height: FULL_HD[1], seed: SEED };
        path.at(pull.shifted(pull.time(cluster, [k, l], share), offset)).position
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blur::params::OF_POINT;

    #[test]
    fn every_documented_name_is_there() {
        let names = VARIANTS.map(|(name, _)| name);
        for name in ["length 15", "length 4", "error 1", "error 0.5"] {
            assert!(names.contains(&name), "{name}");
        }
        assert_eq!(WORKLOADS.map(|(name, _)| name), ["fox-like", "run"]);
    }

    #[test]
    fn the_fox_like_mesh_has_about_as_many_triangles() -> Result<()> {
        let scene = Scene::builtin(Builtin::Run, WORKLOADS[0].1, FULL_HD)?;
        assert!((480..680).contains(&scene.mesh.triangles().len()), "{}", scene.mesh.triangles().len());
        Ok(())
    }

    #[test]
    fn the_mesh_itself_is_exact_at_its_points_only() -> Result<()> {
        let scene = Scene::builtin(Builtin::Run, 330, FULL_HD)?;
        let settings = Settings { seam_smoothing: 0, ..Settings::default() };
        let prepared = scene.prepare(&settings)?;
        let pull = Pull { interval: &prepared.interval, settings: &settings, height: FULL_HD[1], seed: SEED };
        let extents = extent::extents(&scene.mesh, &pull, &[]);
        let points = scene.mesh.points();
        let vertex = |p: usize| {
            let piece = [prepared.interval.pieces[p]];
            let path = Path { segments: &prepared.interval.segments, pieces: &piece, on_screen: false };
            let [x, y] = path.at(extents[p].time).position;
            Vertex { drawn: [x, y], share: 1.0, barycentrics: [OF_POINT; 2], ..Vertex::zeroed() }
        };
        let triangles = scene.mesh.triangles().iter().zip(0..).map(|([a, b, c], base)| [*a, *b, *c, base]).collect();
        let vertices = (0..points).map(vertex).collect();
        let surface = Surface {
            scene: &scene,
            prepared: &prepared,
            settings: &settings,
            vertices,
            triangles,
            is_cut_short: false,
        };
        let counted: Vec<[u32; 4]> = surface.triangles.iter().filter(|t| surface.area(t) > 0.0).copied().collect();
        assert!(counted.len() > 200, "{}", counted.len());
        let worst = |place| counted.iter().map(|t| surface.distance(t, place)).fold(0.0, f64::max);
        // k and l jump where a point is the foremost or the rearmost of its cluster to rounding only.
        assert!(worst([1.0, 0.0, 0.0]) < 0.05, "{}", worst([1.0, 0.0, 0.0]));
        assert!(worst([0.3, 0.4, 0.3]) > 1.0);
        let (deviation, _) = surface.accuracy().unwrap_or_else(|| unreachable!("a surface"));
        assert!(deviation.p99 > 1.0 && deviation.max < 200.0, "{deviation:?}");
        Ok(())
    }
}
