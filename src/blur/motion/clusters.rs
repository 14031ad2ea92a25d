//! Which points are smeared as one: division of each object's moving points, and what is made of the classes.
//!
//! All that decides is a sum of whole numbers, a smallest or largest value, or a sorted order: it is the same whatever
//! the order of points and triangles.

use super::movers::{Joined, Mover};
use super::trace::Traces;
use super::{direction, hull, ldf};
use crate::blur::mesh::Mesh;
use crate::blur::parts::Parts;
use crate::blur::settings::{self, MOST_TEETH, Settings};
use crate::random::pcg;
use crate::shaders::blur::blocks::Cluster;
use crate::shaders::blur::constants::NO_MEAN;

/// A part with fewer than one in so many of its object's moving points is a crumb.
const CRUMB: usize = 200;

/// The clusters and the label of each point; `hull` holds their extreme points.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Clusters {
    pub(super) clusters: Vec<Cluster>,
    pub(super) labels: Vec<u32>,
    pub(super) hull: Vec<[f32; 2]>,
}

/// Divides the points that move.
pub(super) fn find(mesh: &Mesh, traces: &Traces, settings: &Settings, height: u32) -> Clusters {
    let moving = (0..mesh.points() as u32).filter(|p| !traces.moves[*p as usize][0].is_nan());
    let mut movers: Vec<Mover> = moving.map(|point| Mover::new(point, traces)).collect();
    let object = |mover: &Mover| mesh.point_objects()[mover.point as usize];
    movers.sort_by_key(object);
    let mut classes = vec![0; mesh.points()];
    let mut count = 0;
    for object in movers.chunk_by_mut(|a, b| object(a) == object(b)) {
        divide(object, settings, |class| {
            count += 1;
            class.iter().for_each(|mover| classes[mover.point as usize] = count);
        });
    }
    if settings.clusters == settings::Clusters::Direction {
        let cell = f64::from(Settings::scaled(direction::CELL, height));
        direction::connect(mesh, &movers, &traces.motion, cell, &mut classes);
        merge_crumbs(mesh, traces, &movers, &mut classes);
    }
    number(mesh, traces, &mut classes);
    let count = classes.iter().max().map_or(0, |last| *last);
    describe(mesh, traces, settings, height, (classes, count))
}

/// Those of the points that move of each part of the host's.
pub(super) fn of_parts(mesh: &Mesh, traces: &Traces, settings: &Settings, height: u32, parts: &Parts) -> Clusters {
    let label = |(label, moves): (&u32, &[f32; 2])| if moves[0].is_nan() { 0 } else { *label };
    let labels = parts.labels().iter().zip(&traces.moves).map(label).collect();
    describe(mesh, traces, settings, height, (labels, parts.rows().len() as u32))
}

/// Divides movers until each class keeps within the angle, or is the same all over; gives each class to `class`.
fn divide(movers: &mut [Mover], settings: &Settings, mut class: impl FnMut(&[Mover])) {
    let cosine = f64::from(settings.angle).to_radians().cos();
    let mut waiting = vec![movers];
    while let Some(part) = waiting.pop() {
        let middle = match (is_coherent(part, cosine), settings.clusters) {
            (true, _) => None,
            (false, settings::Clusters::Direction) => direction::split(part),
            (false, settings::Clusters::Ldf) => ldf::split(part),
        };
        match middle {
            None => class(part),
            Some(middle) => {
                let (left, right) = part.split_at_mut(middle);
                waiting.push(right);
                waiting.push(left);
            }
        }
    }
}

/// Whether each direction is within the angle of the mean velocity, and there is one.
fn is_coherent(movers: &[Mover], cosine: f64) -> bool {
    let mean = mean_velocity(movers);
    let length = mean[0].hypot(mean[1]);
    let fastest = movers.iter().map(Mover::speed).fold(0.0, f64::max);
    let within = |mover: &Mover| {
        let [x, y] = mover.direction.map(|c| c as f64);
        (x * mean[0] + y * mean[1]) >= cosine * length * x.hypot(y)
    };
    length >= f64::from(NO_MEAN) * fastest && length > 0.0 && movers.iter().all(within)
}

/// In units.
fn mean_velocity(movers: &[Mover]) -> [f64; 2] {
    [2, 3].map(|c| movers.iter().map(|mover| i128::from(mover.place[c])).sum::<i128>() as f64 / movers.len() as f64)
}

/// A number for a set of points that depends on where they are and how they move, and not on their order.
fn fingerprint(motion: &[f32; 4]) -> u64 {
    let [a, b] = [0, 1].map(|seed| motion.iter().fold(seed, |h, c| pcg(h ^ c.to_bits())));
    u64::from(a) << 32 | u64::from(b)
}

/// The order of clusters: size, and a fingerprint for those of one size.
type Rank = (u32, u64);

fn ranks(traces: &Traces, labels: &[u32]) -> Vec<Rank> {
    let count = labels.iter().max().map_or(0, |last| *last as usize);
    let mut ranks = vec![(0, 0_u64); count + 1];
    for (point, label) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        let rank = &mut ranks[*label as usize];
        *rank = (rank.0 + 1, rank.1.wrapping_add(fingerprint(&traces.motion[point])));
    }
    ranks
}

/// Joins each crumb to the neighbour that shares most edges with it, the largest of those that share as many; all at
/// once, until none is left but those without neighbour.
fn merge_crumbs(mesh: &Mesh, traces: &Traces, movers: &[Mover], classes: &mut [u32]) {
    let mut least = vec![0; mesh.points()];
    let object = |mover: &Mover| mesh.point_objects()[mover.point as usize];
    for members in movers.chunk_by(|a, b| object(a) == object(b)) {
        members.iter().for_each(|mover| least[mover.point as usize] = members.len());
    }
    loop {
        let ranks = ranks(traces, classes);
        let is_crumb = |point: usize| (ranks[classes[point] as usize].0 as usize) * CRUMB < least[point];
        let mut borders = Vec::new();
        for mover in movers.iter().filter(|mover| is_crumb(mover.point as usize)) {
            let own = classes[mover.point as usize];
            let others = mesh.neighbours().of(mover.point as usize).iter().map(|other| classes[*other as usize]);
            borders.extend(others.filter(|other| *other != 0 && *other != own).map(|other| (own, other)));
        }
        if borders.is_empty() {
            return;
        }
        borders.sort_unstable();
        let mut best: Vec<(u32, u32, usize)> = Vec::new();
        for border in borders.chunk_by(|a, b| a == b) {
            let (own, other) = border[0];
            match best.last_mut().filter(|last| last.0 == own) {
                Some(last) if (last.2, ranks[last.1 as usize]) < (border.len(), ranks[other as usize]) => {
                    (last.1, last.2) = (other, border.len());
                }
                Some(_) => {}
                None => best.push((own, other, border.len())),
            }
        }
        let mut joined = Joined::new(ranks.len());
        best.iter().for_each(|(own, other, _)| joined.join(*own, *other));
        classes.iter_mut().for_each(|class| *class = joined.root(*class));
    }
}

/// Numbers classes from 1 by their size, so that numbers depend on nothing else (but fingerprints, for equal sizes).
fn number(mesh: &Mesh, traces: &Traces, classes: &mut [u32]) {
    let ranks = ranks(traces, classes);
    let mut objects = vec![0; ranks.len()];
    classes.iter().zip(mesh.point_objects()).for_each(|(class, object)| objects[*class as usize] = *object);
    let mut order: Vec<usize> = (1..ranks.len()).filter(|class| ranks[*class].0 > 0).collect();
    order.sort_by_key(|class| (ranks[*class].0, objects[*class], ranks[*class].1));
    let mut label_of = vec![0; ranks.len()];
    order.iter().zip(1..).for_each(|(class, label)| label_of[*class] = label);
    classes.iter_mut().for_each(|class| *class = label_of[*class as usize]);
}

/// Hull and teeth of each of so many clusters.
fn describe(
    mesh: &Mesh,
    traces: &Traces,
    settings: &Settings,
    height: u32,
    (labels, count): (Vec<u32>, u32),
) -> Clusters {
    let mut members: Vec<(u32, u32)> = labels.iter().copied().zip(0..).filter(|(label, _)| *label > 0).collect();
    members.sort_unstable();
    let mut found = Clusters { labels, ..Clusters::default() };
    let mut rest = &members[..];
    for label in 1..=count {
        let cluster;
        (cluster, rest) = rest.split_at(rest.partition_point(|member| member.0 <= label));
        let points: Vec<[f32; 2]> =
            cluster.iter().map(|(_, p)| traces.motion[*p as usize]).map(|m| [m[0], m[1]]).collect();
        let movers: Vec<Mover> = cluster.iter().map(|(_, point)| Mover::new(*point, traces)).collect();
        let extremes = hull::extremes(&points);
        let hull_begin = found.hull.len();
        found.clusters.push(Cluster {
            object: cluster.first().map_or(0, |(_, point)| mesh.point_objects()[*point as usize]),
            hull_begin: hull_begin as u32,
            hull_end: (hull_begin + extremes.len()) as u32,
            teeth: teeth(settings, height, &movers, &extremes),
            points: cluster.len() as u32,
        });
        found.hull.extend(extremes);
    }
    found
}

/// Random numbers across a cluster: as many as teeth fit across its mean velocity, or across its longer side where that
/// is 0.
fn teeth(settings: &Settings, height: u32, movers: &[Mover], extremes: &[[f32; 2]]) -> u32 {
    if let Some(teeth) = settings.teeth {
        return teeth;
    }
    let tooth = f64::from(Settings::scaled(settings.tooth_width(), height));
    let width = |[x, y]: [f64; 2]| {
        let across = extremes.iter().map(|p| f64::from(p[0]) * x + f64::from(p[1]) * y);
        let [least, most] = across.fold([f64::MAX, f64::MIN], |[a, b], c| [a.min(c), b.max(c)]);
        most - least
    };
    let [x, y] = mean_velocity(movers);
    let length = x.hypot(y);
    let width = match length > 0.0 && length >= f64::from(NO_MEAN) * movers.iter().map(Mover::speed).fold(0.0, f64::max)
    {
        true => width([y / length, -x / length]),
        false => width([1.0, 0.0]).max(width([0.0, 1.0])),
    };
    ((width / tooth).round() + 1.0).clamp(2.0, f64::from(MOST_TEETH)) as u32
}
