//! Which points are smeared as one: division of each object's moving points, and what is made of the classes.
//!
//! All that decides is a sum of whole numbers, a smallest or largest value, or a sorted order: it is the same whatever
//! the order of points and triangles.

use std::ops::Range;

use super::movers::Mover;
use super::trace::Traces;
use super::{crumbs, direction, hull, ldf, ranks, rows};
use crate::blur::mesh::Mesh;
use crate::blur::parts::Parts;
use crate::blur::settings::{self, MOST_TEETH, Settings};
use crate::shaders::blur::blocks::Cluster;
use crate::shaders::blur::constants::{COMMON, NO_MEAN};

/// What is divided, and how.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) traces: Traces<'a>,
    pub(super) settings: &'a Settings,
    /// Lines of the picture.
    pub(super) height: u32,
}

/// Where the clusters, the label of each point, and what bounds the clusters go: as in [`super::Interval`].
#[derive(Debug)]
pub(super) struct Found<'a> {
    pub(super) clusters: &'a mut Vec<Cluster>,
    pub(super) labels: &'a mut Vec<u32>,
    pub(super) bounds: &'a mut Vec<[f32; 2]>,
}

/// What clusters are found in.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    movers: Vec<Mover>,
    /// Movers that are still to be divided.
    waiting: Vec<Range<usize>>,
    direction: direction::Scratch,
    ldf: ldf::Scratch,
    crumbs: crumbs::Scratch,
    ranks: ranks::Scratch,
    /// The label and the number of each point of a cluster, sorted.
    members: Vec<(u32, u32)>,
    /// Where the points of one cluster are.
    points: Vec<[f32; 2]>,
    hull: hull::Scratch,
    rows: rows::Scratch,
}

impl Scratch {
    /// The clusters of the points that move: those of the host's parts, or those that are found.
    pub(super) fn find(&mut self, task: Task, parts: Option<&Parts>, found: Found) {
        let count = match parts {
            Some(parts) => {
                let moving = task.traces.moves.iter().map(|moves| u32::from(!moves[0].is_nan()));
                found.labels.clear();
                found.labels.extend(parts.labels().iter().zip(moving).map(|(label, moving)| label * moving));
                parts.rows().len() as u32
            }
            None => {
                self.label(task, found.labels);
                found.labels.iter().max().map_or(0, |last| *last)
            }
        };
        self.describe(task, count, found);
    }

    /// Divides the points that move.
    fn label(&mut self, task: Task, labels: &mut Vec<u32>) {
        let Task { mesh, traces, settings, height } = task;
        let moving = (0..mesh.points() as u32).filter(|p| !traces.moves[*p as usize][0].is_nan());
        self.movers.clear();
        self.movers.extend(moving.map(|point| Mover::new(point, traces)));
        let object = |mover: &Mover| mesh.point_objects()[mover.point as usize];
        self.movers.sort_unstable_by_key(|mover| (object(mover), mover.point));
        labels.clear();
        labels.resize(mesh.points(), 0);
        let (mut begin, mut count) = (0, 0);
        while begin < self.movers.len() {
            let end =
                begin + self.movers[begin..].partition_point(|mover| object(mover) == object(&self.movers[begin]));
            self.divide(begin..end, settings, |class| {
                count += 1;
                class.iter().for_each(|mover| labels[mover.point as usize] = count);
            });
            begin = end;
        }
        if settings.clusters == settings::Clusters::Direction {
            let cell = f64::from(Settings::scaled(direction::CELL, height));
            self.direction.connect(mesh, &self.movers, traces.motion, cell, labels);
            self.crumbs.merge(mesh, traces, &self.movers, labels);
        }
        self.ranks.number(mesh, traces, labels);
    }

    /// Divides movers until each class keeps within the angle, or is the same all over; gives each class to `class`.
    fn divide(&mut self, movers: Range<usize>, settings: &Settings, mut class: impl FnMut(&[Mover])) {
        let cosine = f64::from(settings.angle).to_radians().cos();
        self.waiting.clear();
        self.waiting.push(movers);
        while let Some(Range { start, end }) = self.waiting.pop() {
            let part = &mut self.movers[start..end];
            let middle = match (is_coherent(part, cosine), settings.clusters) {
                (true, _) => None,
                (false, settings::Clusters::Direction) => self.direction.split(part),
                (false, settings::Clusters::Ldf) => self.ldf.split(part),
            };
            match middle {
                None => class(part),
                Some(middle) => self.waiting.extend([start + middle..end, start..start + middle]),
            }
        }
    }

    /// What bounds each of so many clusters, and its teeth.
    fn describe(&mut self, task: Task, count: u32, found: Found) {
        let Task { mesh, traces, settings, height } = task;
        let Found { clusters, labels, bounds } = found;
        self.members.clear();
        self.members.extend(labels.iter().copied().zip(0..).filter(|(label, _)| *label > 0));
        self.members.sort_unstable();
        clusters.clear();
        bounds.clear();
        let mut room = rows::SHARED;
        let mut rest = &self.members[..];
        for label in 1..=count {
            let cluster;
            (cluster, rest) = rest.split_at(rest.partition_point(|member| member.0 <= label));
            let points = cluster.iter().map(|(_, point)| traces.motion[*point as usize]);
            self.points.clear();
            self.points.extend(points.map(|[x, y, ..]| [x, y]));
            self.movers.clear();
            self.movers.extend(cluster.iter().map(|(_, point)| Mover::new(*point, traces)));
            let begin = bounds.len();
            let ahead = match settings.extent {
                settings::Extent::Row => common_direction(&self.movers),
                settings::Extent::Part => None,
            };
            let across = match ahead {
                Some(ahead) => {
                    let of = rows::Task { mesh, motion: traces.motion, labels, members: cluster, ahead };
                    self.rows.find(of, f64::from(Settings::scaled(rows::ROW, height)), &mut room, bounds)
                }
                None => {
                    self.hull.extremes(&self.points, bounds);
                    rows::Across::default()
                }
            };
            clusters.push(Cluster {
                object: cluster.first().map_or(0, |(_, point)| mesh.point_objects()[*point as usize]),
                bounds_begin: begin as u32,
                bounds_end: bounds.len() as u32,
                teeth: teeth(settings, height, &self.movers, &self.points),
                points: cluster.len() as u32,
                aside: across.begin,
                ahead: ahead.unwrap_or_default(),
                width: across.width,
                unused: 0,
            });
        }
    }
}

/// Whether each direction is within the angle of the mean velocity, and there is one.
fn is_coherent(movers: &[Mover], cosine: f64) -> bool {
    let mean = mean_velocity(movers);
    let length = mean[0].hypot(mean[1]);
    let within = |mover: &Mover| {
        let [x, y] = mover.direction.map(|c| c as f64);
        (x * mean[0] + y * mean[1]) >= cosine * length * x.hypot(y)
    };
    length >= f64::from(NO_MEAN) * mean_speed(movers) && length > 0.0 && movers.iter().all(within)
}

/// The direction in which movers go together, of length 1; none where too much of their speed cancels.
fn common_direction(movers: &[Mover]) -> Option<[f32; 2]> {
    let [x, y] = mean_velocity(movers);
    let length = x.hypot(y);
    (length > 0.0 && length >= f64::from(COMMON) * mean_speed(movers))
        .then(|| [x / length, y / length].map(|c| c as f32))
}

/// In units.
fn mean_velocity(movers: &[Mover]) -> [f64; 2] {
    [2, 3].map(|c| movers.iter().map(|mover| i128::from(mover.place[c])).sum::<i128>() as f64 / movers.len() as f64)
}

/// In units.
fn mean_speed(movers: &[Mover]) -> f64 {
    movers.iter().map(Mover::speed).sum::<f64>() / movers.len() as f64
}

/// Random numbers across a cluster: as many as teeth fit across its mean velocity, or across its longer side where that
/// is 0.
fn teeth(settings: &Settings, height: u32, movers: &[Mover], points: &[[f32; 2]]) -> u32 {
    if let Some(teeth) = settings.teeth {
        return teeth;
    }
    let tooth = f64::from(Settings::scaled(settings.tooth_width(), height));
    let width = |[x, y]: [f64; 2]| {
        let across = points.iter().map(|p| f64::from(p[0]) * x + f64::from(p[1]) * y);
        let [least, most] = across.fold([f64::MAX, f64::MIN], |[a, b], c| [a.min(c), b.max(c)]);
        most - least
    };
    let [x, y] = mean_velocity(movers);
    let length = x.hypot(y);
    let width = match length > 0.0 && length >= f64::from(NO_MEAN) * mean_speed(movers) {
        true => width([y / length, -x / length]),
        false => width([1.0, 0.0]).max(width([0.0, 1.0])),
    };
    ((width / tooth).round() + 1.0).clamp(2.0, f64::from(MOST_TEETH)) as u32
}
