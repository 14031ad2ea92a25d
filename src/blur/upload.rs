//! Everything that an output brings, packed into one buffer.

use std::ops::Range;

use bytemuck::NoUninit;

use crate::blur::frame::{
    ClusterInput, Counts, FrameView, GroupInput, IntervalInput, PartInput, PoseInput, TopologyInput, Trajectories,
};
use crate::blur::mesh::Mesh;
use crate::blur::motion::{Interval, Knot};
use crate::blur::parts::Parts;
use crate::host::HostBuffer;

/// Multiple of bytes at which ranges begin: what any device may ask for.
const ALIGNMENT: usize = 256;

/// The mesh, poses and interval of an output in one range of bytes, which the host copies into a buffer of its own. Cleared and
/// filled for each output, it allocates nothing after the largest.
///
/// ```
/// # use celfx::blur::{Interval, Mesh, Upload};
/// # fn bytes<'a>(upload: &'a mut Upload, mesh: &Mesh, poses: &[Vec<[f32; 3]>], interval: &Interval) -> &'a [u8] {
/// upload.clear();
/// upload.mesh(mesh, &[]); // in the first output
/// upload.poses(0, poses); // those that are new
/// upload.interval(interval, true);
/// upload.bytes() // to be copied to a buffer, of which `placed` makes the frame's input
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Upload {
    bytes: Vec<u8>,
    mesh: Option<[Range<usize>; 7]>,
    textures: Option<Range<usize>>,
    shares: Option<Range<usize>>,
    /// Whether base colours are with it.
    has_colours: bool,
    parts: Option<[Range<usize>; 5]>,
    source_rows: Option<Range<usize>>,
    poses: Option<(u32, u32, Range<usize>)>,
    interval: Option<[Range<usize>; 7]>,
}

/// An [`Upload`] in a buffer.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Placed {
    /// For [`crate::blur::Frame::mesh`].
    pub mesh: Option<TopologyInput>,
    /// For [`crate::blur::Frame::poses`].
    pub poses: Option<PoseInput>,
    interval: Option<[HostBuffer; 7]>,
}

impl Upload {
    /// Nothing is in it any more; its memory stays.
    pub fn clear(&mut self) {
        self.bytes.clear();
        (self.mesh, self.textures, self.shares) = (None, None, None);
        (self.parts, self.source_rows) = (None, None);
        (self.poses, self.interval) = (None, None);
    }

    /// All of it, to be copied into a buffer with usage `TRANSFER_SRC`.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn add<T: NoUninit>(&mut self, values: &[T]) -> Range<usize> {
        let begin = self.begin();
        self.bytes.extend_from_slice(bytemuck::cast_slice(values));
        self.end(begin)
    }

    fn begin(&mut self) -> usize {
        let begin = self.bytes.len().next_multiple_of(ALIGNMENT);
        self.bytes.resize(begin, 0);
        begin
    }

    /// A range of no bytes is no range of a buffer: it gets some that nobody reads.
    fn end(&mut self, begin: usize) -> Range<usize> {
        if self.bytes.len() == begin {
            self.bytes.resize(begin + 16, 0);
        }
        begin..self.bytes.len()
    }

    /// Adds the mesh, with linear RGB of each vertex for frames that are drawn; a vertex without is white.
    pub fn mesh(&mut self, mesh: &Mesh, colours: &[[f32; 3]]) {
        self.mesh_of_rows(mesh, &TopologyInput::colour_rows(mesh, colours));
    }

    /// The same with [`TopologyInput::colour_rows`], or without.
    pub(crate) fn mesh_of_rows(&mut self, mesh: &Mesh, colours: &[[f32; 4]]) {
        self.has_colours = colours.len() >= 3 * mesh.triangles().len();
        let (neighbours, groups) = (mesh.neighbours(), mesh.group_triangles());
        // Lists of none behind the last, so that they are a multiple.
        let mut starts = groups.starts.clone();
        starts
            .resize((starts.len() - 1).next_multiple_of(GroupInput::MULTIPLE as usize) + 1, groups.items.len() as u32);
        self.mesh = Some([
            self.add(&TopologyInput::triangle_rows(mesh)),
            self.add(&neighbours.starts),
            self.add(&neighbours.items),
            self.add(&GroupInput::corner_rows(mesh)),
            self.add(&starts),
            self.add(&groups.items),
            self.add(colours),
        ]);
    }

    /// Adds the rows of textures ([`crate::blur::texture_rows`]), with the mesh.
    pub fn textures(&mut self, rows: &[[u32; 4]]) {
        self.textures = Some(self.add(rows));
    }

    /// Adds the share of strength that each point has, with the mesh ([`Mesh::gather`]).
    pub fn shares(&mut self, shares: &[f32]) {
        self.shares = Some(self.add(shares));
    }

    /// Adds the parts of the mesh, with it.
    pub fn parts(&mut self, parts: &Parts) {
        self.parts = Some([
            self.add(parts.labels()),
            self.add(parts.members()),
            self.add(parts.chunks()),
            self.add(parts.rows()),
            self.add(parts.seams()),
        ]);
    }

    /// Adds where the points of the mesh are in the host's sources ([`Mesh::source_rows`]), with it.
    pub fn source_rows(&mut self, rows: &[u32]) {
        self.source_rows = Some(self.add(rows));
    }

    /// Adds poses of consecutive frames, the first of which has this number: world positions of the mesh's points.
    pub fn poses<P: AsRef<[[f32; 3]]>>(&mut self, first: u32, poses: &[P]) {
        let begin = self.begin();
        poses.iter().for_each(|pose| self.bytes.extend_from_slice(bytemuck::cast_slice(pose.as_ref())));
        self.poses = Some((first, poses.len() as u32, self.end(begin)));
    }

    /// Adds the motion; its trajectories, too, where the device does not make them itself of poses
    /// ([`crate::blur::Motion::knots`]).
    pub fn interval(&mut self, interval: &Interval, with_trajectories: bool) {
        let pieces = if with_trajectories { &interval.pieces[..] } else { &[] };
        self.interval = Some([
            self.add(&interval.motion),
            self.add(&interval.labels),
            self.add(&interval.clusters),
            self.add(&interval.bounds),
            self.add(&interval.seams),
            self.add(&interval.fronts),
            self.add(pieces),
        ]);
    }

    /// As a buffer holds it from its offset on. The offset is a multiple of 256, or of the device's
    /// `minStorageBufferOffsetAlignment`.
    pub fn placed(&self, buffer: HostBuffer) -> Placed {
        let part = |range: &Range<usize>| HostBuffer {
            offset: buffer.offset + range.start as u64,
            size: range.len() as u64,
            ..buffer
        };
        let mesh = self.mesh.as_ref().map(|ranges| {
            let [triangles, neighbour_starts, neighbours, corners, starts, group_triangles, colours] =
                ranges.each_ref().map(part);
            let groups = Some(GroupInput { corners, starts, triangles: group_triangles });
            let parts = self.parts.as_ref().map(|ranges| {
                let [labels, members, chunks, rows, seams] = ranges.each_ref().map(part);
                PartInput { labels, members, chunks, rows, seams }
            });
            let (colours, textures) = (self.has_colours.then_some(colours), self.textures.as_ref().map(part));
            let shares = self.shares.as_ref().map(part);
            let source_rows = self.source_rows.as_ref().map(part);
            TopologyInput {
                triangles,
                neighbour_starts,
                neighbours,
                groups,
                colours,
                textures,
                shares,
                parts,
                source_rows,
                sizes: None,
            }
        });
        Placed {
            mesh,
            poses: self.poses.as_ref().map(|(first, count, range)| PoseInput {
                first: *first,
                count: *count,
                positions: part(range),
            }),
            interval: self.interval.as_ref().map(|ranges| ranges.each_ref().map(part)),
        }
    }
}

impl Placed {
    /// For [`crate::blur::Frame::interval`], of the interval that was added; none if none was. `views`: frames i - 1 to i + 2. `knots`:
    /// none if trajectories were added ([`Upload::interval`]), else [`crate::blur::Motion::knots`].
    pub fn interval<'a>(
        &self,
        interval: &'a Interval,
        mesh: &Mesh,
        views: [FrameView; 4],
        knots: Option<&'a [Knot]>,
    ) -> Option<IntervalInput<'a>> {
        let [motion, labels, clusters, bounds, seams, fronts, pieces] = self.interval?;
        Some(IntervalInput {
            counts: Counts::of(interval, mesh.neighbours()),
            segments: &interval.segments,
            views,
            trajectories: knots.map_or(Trajectories::Pieces(pieces), Trajectories::Poses),
            clusters: Some(ClusterInput { motion, labels, clusters, bounds, seams, fronts }),
        })
    }
}
