//! Parts of a mesh that are smeared as one, as a host names them.

use crate::blur::mesh::Mesh;
use crate::blur::motion::seams;
use crate::error::{Error, Result};
pub use crate::shaders::blur::blocks::{Chunk, PartRow};
use crate::shaders::blur::constants::DIRECTIONS;

/// A division of a mesh that does not depend on how it moves: by bone, by what a character is made of. It takes the place of
/// clusters by direction: nothing has to be found from poses, which need not be on the CPU then.
///
/// With poses that the host's own skinning has left on the device, no frame needs anything of them on the CPU:
///
/// ```
/// # use celfx::blur::{self, Counts, Desc, Frame, FrameView, IntervalInput, Mesh, Motion, Parts, Settings, SkinnedInput, Source};
/// # use celfx::host::{HostBuffer, HostImage};
/// # fn f(mesh: &Mesh, bones: &[u32], settings: Settings, size: [u32; 2], skinned: HostBuffer, target: HostImage, first: Vec<FrameView>,
/// #      generation: u32, next: FrameView, offset: u64) -> celfx::error::Result<()> {
/// // Once: a part for each bone, and a buffer of vertices of 32 bytes.
/// let parts = Parts::new(mesh, bones)?;
/// let vertices = mesh.file_to_point().len() as u32;
/// let (rows, points) = mesh.source_rows(&[vertices])?;
/// let source = Source { buffer: skinned, stride: 8, vertices, points: points[0] };
/// let mut desc = Desc { parts: Some(parts.sizes()), sources: vec![source], ..Desc::new(mesh, size, settings) };
/// desc.frames_resident = 16;
/// let mut motion = Motion::new(&desc.settings, size)?;
/// let mut upload = blur::Upload::default(); // with the first frame
/// upload.mesh(mesh, &[]);
/// upload.parts(&parts);
/// upload.source_rows(&rows);
///
/// // Each frame: the views of the last ones, the newest of which is that of the output.
/// let mut views: Vec<FrameView> = first;
/// views.push(next);
/// let current = views.len() - 2;
/// let found = motion.knots_of_views(&views, current);
/// let earlier = views[current.saturating_sub(1)];
/// let mut frame = Frame::new(target);
/// frame.skinned = Some(SkinnedInput { frame: next.frame, offsets: [offset, 0, 0, 0, 0, 0, 0, 0] });
/// frame.interval = found.map(|(knots, segments)| IntervalInput {
///     counts: Counts::of_parts(&parts.sizes(), generation),
///     segments,
///     views: [earlier, views[current], next, next],
///     trajectories: blur::Trajectories::Poses(knots),
///     clusters: None,
/// });
/// # Ok(())
/// # }
/// ```
///
/// Of each part, those points are smeared that move. They are labelled from 1, the larger label is the part with more points.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts {
    labels: Vec<u32>,
    members: Vec<u32>,
    chunks: Vec<Chunk>,
    rows: Vec<PartRow>,
    seams: Vec<u32>,
    most_neighbours: u32,
}

/// How much there is of [`Parts`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PartSizes {
    /// Parts.
    pub parts: u32,
    /// Chunks of their members.
    pub chunks: u32,
    /// Points near to where parts meet.
    pub seams: u32,
    /// The most neighbours of one of these.
    pub most_neighbours: u32,
}

impl Parts {
    /// From a number a vertex, any: points of one object whose first vertices have the same are a part.
    ///
    /// # Errors
    /// Not one a vertex.
    pub fn new(mesh: &Mesh, numbers: &[u32]) -> Result<Parts> {
        let vertices = mesh.file_to_point().len();
        if numbers.len() != vertices {
            let why = format!("{} numbers for {vertices} vertices; give one a vertex", numbers.len());
            return Err(Error::HostResource { name: "blur parts", why });
        }
        let key =
            |point: u32| (mesh.point_objects()[point as usize], numbers[mesh.point_to_file()[point as usize] as usize]);
        let mut members: Vec<u32> = (0..mesh.points() as u32).collect();
        members.sort_by_key(|point| key(*point));
        let mut parts: Vec<&[u32]> = members.chunk_by(|a, b| key(*a) == key(*b)).collect();
        parts.sort_by_key(|part| (part.len(), key(part[0])));
        let members = parts.concat();
        let mut found = Parts {
            labels: vec![0; mesh.points()],
            chunks: Vec::new(),
            rows: Vec::new(),
            seams: Vec::new(),
            most_neighbours: 0,
            members: Vec::new(),
        };
        let mut begin = 0;
        for (part, points) in parts.iter().enumerate() {
            points.iter().for_each(|point| found.labels[*point as usize] = part as u32 + 1);
            let first_chunk = found.chunks.len() as u32;
            for chunk in points.chunks(DIRECTIONS as usize) {
                let end = begin + chunk.len() as u32;
                found.chunks.push(Chunk { part: part as u32, begin, end, unused: 0 });
                begin = end;
            }
            let (object, last_chunk) = (mesh.point_objects()[points[0] as usize], found.chunks.len() as u32);
            found.rows.push(PartRow { object, first_chunk, last_chunk, unused: 0 });
        }
        found.members = members;
        seams::Scratch::default().find(mesh, &found.labels, &mut found.seams);
        found.most_neighbours = seams::most_neighbours(mesh.neighbours(), &found.seams);
        Ok(found)
    }

    /// How much there is of everything.
    pub fn sizes(&self) -> PartSizes {
        PartSizes {
            parts: self.rows.len() as u32,
            chunks: self.chunks.len() as u32,
            seams: self.seams.len() as u32,
            most_neighbours: self.most_neighbours,
        }
    }

    /// The part of each point, from 1.
    pub fn labels(&self) -> &[u32] {
        &self.labels
    }

    /// Points, part by part.
    pub fn members(&self) -> &[u32] {
        &self.members
    }

    /// Runs of members that a workgroup looks at.
    pub fn chunks(&self) -> &[Chunk] {
        &self.chunks
    }

    /// The parts.
    pub fn rows(&self) -> &[PartRow] {
        &self.rows
    }

    /// Points within 3 edges of where parts meet, ascending, but those with too many neighbours.
    pub fn seams(&self) -> &[u32] {
        &self.seams
    }
}
