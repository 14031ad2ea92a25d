//! Pass `extent`: k and l from all points of a cluster, as the paper's equations are written, and from its hull, which
//! the host builds: both results have the same bits. And those of rows, which the host builds, too.

use std::time::Instant;

use super::EFFECT;
use super::scene::{Prepared, Scene};
use crate::bench::measure::{Deviation, interleaved};
use crate::bench::report::{Accuracy, Row, Subject};
use crate::bench::rig::{EffectId, KernelBuffer, KernelsId, Measured, Rig};
use crate::bench::{Outcome, Session};
use crate::blur::layout::{BUFFERS, VERTICES, resource};
use crate::blur::motion::{outline, rows_again};
use crate::blur::params::{BenchExtentConstants, Vertex};
use crate::blur::reference::extent::{extent, extent_in};
use crate::blur::settings::Extent;
use crate::blur::{Interval, Settings};
use crate::error::Result;
use crate::gpu::buffer::BufferDesc;
use crate::layout::LOOP_BUDGET;
use crate::plan::{BufferId, Command, Kernel, Pass, PassId, Plan, Resource};
use crate::random::hash;
use crate::shaders::blur as glsl;

const PASS: &str = "extent";
const VARIANTS: [(&str, Variant); 3] = [("brute", Variant::Brute), ("hull", Variant::Hull), ("rows", Variant::Rows)];
/// Name, points, and points with `--quick`.
const WORKLOADS: [(&str, [u32; 2]); 2] = [("10000", [10_000, 10_000]), ("100000", [100_000, 20_000])];
const SIZE: [u32; 2] = [512, 512];
/// Points of which the CPU is asked, too.
const CHECKED: usize = 1024;

const EXTREMES: BufferId = BufferId(BUFFERS);
const EXTENTS: BufferId = BufferId(BUFFERS + 1);
const BRUTE: PassId = PassId(0);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Variant {
    Brute,
    Hull,
    Rows,
}

pub(super) fn measure(session: &mut Session) -> Outcome {
    for (name, [points, few]) in WORKLOADS {
        let (name, points) = match session.quick && few < points {
            true => (format!("{name} (cut to {few})"), few),
            false => (name.to_owned(), points),
        };
        let variants = session.wanted(PASS, &name, &VARIANTS);
        if !variants.is_empty() {
            session.next(&format!("blur extent {name}"))?;
            measure_workload(session, &name, points, &variants)?;
            session.rig.clear();
        }
    }
    Ok(())
}

fn measure_workload(session: &mut Session, name: &str, points: u32, variants: &[&(&str, Variant)]) -> Outcome {
    let scene = Scene::ball(points, SIZE)?;
    let rig = &mut session.rig;
    let ways = [Extent::Part, Extent::Row].map(|extent| Settings { extent, ..Settings::default() });
    let [whole, rows] = ways.map(|settings| -> Result<(EffectId, Prepared)> {
        let prepared = scene.prepare(&settings)?;
        let effect = rig.effect(scene.desc(&settings, 1024))?;
        rig.frame(effect, &scene.take(&prepared, None).scene())?;
        Ok((effect, prepared))
    });
    let ((effect, prepared), (of_rows, in_rows)) = (whole?, rows?);
    let own = [effect, of_rows].map(|effect| rig.steps(effect, is_extent));
    let (kernels, plan) = brute(rig, effect, points)?;
    rig.warm_up(kernels, &plan)?;
    let mut exact: Vec<[f32; 2]> = Vec::new();
    let times = interleaved(variants.len(), session.quick, |i| match variants[i].1 {
        Variant::Brute => rig.run(kernels, &plan),
        Variant::Hull => {
            let begin = Instant::now();
            let hull = hulls(&prepared.interval);
            let building = begin.elapsed().as_secs_f64() * 1e3;
            debug_assert_eq!(hull, prepared.interval.bounds);
            let time = rig.replay(effect, &own[0])?;
            Ok(Measured { cpu_ms: time.cpu_ms + building, ..time })
        }
        Variant::Rows => {
            let begin = Instant::now();
            let rows = rows_again(&scene.mesh, &in_rows.interval, SIZE[1]);
            let building = begin.elapsed().as_secs_f64() * 1e3;
            debug_assert_eq!(rows, in_rows.interval.bounds);
            let time = rig.replay(of_rows, &own[1])?;
            Ok(Measured { cpu_ms: time.cpu_ms + building, ..time })
        }
    })?;
    if variants.iter().all(|(_, variant)| *variant != Variant::Brute) {
        rig.run(kernels, &plan)?;
    }
    exact.extend(rig.read_kernels::<[f32; 2]>(kernels, EXTENTS, points as usize)?);
    let mut shares = |effect| -> Result<Vec<[f32; 2]>> {
        let found: Vec<Vertex> = rig.read(effect, VERTICES, points as usize)?;
        Ok(found.iter().map(|vertex| [vertex.k, vertex.l]).collect())
    };
    let [found, found_in_rows] = [shares(effect)?, shares(of_rows)?];
    let hull = prepared.interval.bounds.len();
    let of = format!(
        "brute force in f32, bits that differ; hull of {hull}, {} rows; brute against {CHECKED} of the CPU's",
        in_rows.interval.bounds.len()
    );
    for ((variant, kind), times) in variants.iter().zip(&times) {
        let differences = match kind {
            Variant::Brute => checked(&prepared, &exact),
            Variant::Hull => found.iter().zip(&exact).flat_map(|(a, b)| bits(*a, *b)).collect(),
            Variant::Rows => {
                let expected = in_rows.interval.clusters.first().map(|cluster| {
                    let of = |motion| extent_in(motion, cluster, in_rows.interval.bounds_of(cluster));
                    in_rows.interval.motion.iter().map(move |motion| of(*motion))
                });
                let pairs = found_in_rows.iter().zip(expected.into_iter().flatten());
                pairs.flat_map(|(a, b)| bits(*a, b)).collect()
            }
        };
        let accuracy: Accuracy = Deviation::of(differences).map(|deviation| (deviation, of.clone()));
        let work = match kind {
            Variant::Brute => session.rig.work_of_run(kernels, &plan)?,
            Variant::Hull => session.rig.work_of_replay(effect, &own[0])?,
            Variant::Rows => session.rig.work_of_replay(of_rows, &own[1])?,
        };
        let subject =
            Subject { pass: PASS, variant: (*variant).to_owned(), workload: name.to_owned(), items: points.into() };
        session.rows.push(Row::new(EFFECT, subject, times, &accuracy, work, &session.limits));
    }
    if let [brute, hull, rows] = times.as_slice() {
        let (kernel, built) = (brute.gpu_ms / hull.gpu_ms, brute.gpu_ms / (hull.gpu_ms + hull.cpu_ms));
        session.notes.push(format!(
            "blur extent {name}: hull is {kernel:.0} x as fast as brute on the device, {built:.0} x with its building; rows take {:.2} \
             of the hull's time",
            (rows.gpu_ms + rows.cpu_ms) / (hull.gpu_ms + hull.cpu_ms)
        ));
    }
    Ok(())
}

fn is_extent(pass: &Pass) -> bool {
    matches!(pass.kernel, Kernel::Compute(shader) if std::ptr::eq(shader, &glsl::extent::SHADER))
}

/// The kernel on the points of a frame that the effect has made.
fn brute(rig: &mut Rig, effect: EffectId, points: u32) -> Result<(KernelsId, Plan)> {
    let mut buffers: Vec<_> = (0..BUFFERS).map(|id| KernelBuffer::Shared(effect, BufferId(id))).collect();
    let own = [("extremes", 16), ("brute extents", 8)];
    buffers.extend(own.map(|(name, bytes)| KernelBuffer::Own(BufferDesc::storage(name, bytes * u64::from(points)))));
    let pass = Pass::compute("bench.extent", &glsl::bench_extent::SHADER).bind_all(|binding| match binding.name {
        "Extremes" => Some(Resource::Buffer(EXTREMES)),
        "BruteExtents" => Some(Resource::Buffer(EXTENTS)),
        _ => resource(binding),
    });
    let kernels = rig.kernels(buffers, vec![pass])?;
    let mut plan = Plan::default();
    for first in (0..points).step_by(LOOP_BUDGET as usize) {
        let constants = BenchExtentConstants { first, end: points.min(first + LOOP_BUDGET) };
        plan.step_with(BRUTE, Command::Dispatch { threads: [points, 1, 1] }, &constants);
    }
    Ok((kernels, plan))
}

/// The hulls of all clusters, from their points.
fn hulls(interval: &Interval) -> Vec<[f32; 2]> {
    let mut members = vec![Vec::new(); interval.clusters.len()];
    for (motion, label) in interval.motion.iter().zip(&interval.labels).filter(|(_, label)| **label > 0) {
        members[*label as usize - 1].push([motion[0], motion[1]]);
    }
    members.iter().flat_map(|points| outline(points)).collect()
}

/// Bits of some points that differ from those of the CPU's brute force.
fn checked(prepared: &Prepared, exact: &[[f32; 2]]) -> Vec<f64> {
    let Interval { motion, labels, .. } = &prepared.interval;
    let place = |i: usize| hash(7, i as u32, 0, 0) as usize % motion.len();
    let places = (0..CHECKED.min(motion.len())).map(place);
    let differences = places.flat_map(|place| {
        let of_cluster = motion.iter().zip(labels).filter(|(_, label)| **label == labels[place]);
        let points: Vec<[f32; 2]> = of_cluster.map(|(motion, _)| [motion[0], motion[1]]).collect();
        bits(extent(motion[place], &points), exact[place])
    });
    differences.collect()
}

fn bits(a: [f32; 2], b: [f32; 2]) -> [f64; 2] {
    [0, 1].map(|i| f64::from((a[i].to_bits() ^ b[i].to_bits()).count_ones()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_documented_name_is_there() {
        assert_eq!(VARIANTS.map(|(name, _)| name), ["brute", "hull", "rows"]);
        assert_eq!(WORKLOADS.map(|(name, _)| name), ["10000", "100000"]);
    }

    #[test]
    fn hulls_are_those_of_the_interval() -> Result<()> {
        let prepared = Scene::ball(3000, SIZE)?.prepare(&Settings { extent: Extent::Part, ..Settings::default() })?;
        assert_eq!(hulls(&prepared.interval), prepared.interval.bounds);
        assert_eq!(bits([1.0, 0.0], [1.0_f32.next_up(), 0.0]), [1.0, 0.0]);
        Ok(())
    }
}
