//! The mesh as a host hands it over: what is constant of it.

use super::{one_sided, refuse};
use crate::blur::desc::Desc;
use crate::blur::mesh::Mesh;
use crate::blur::parts::{Chunk, PartRow, PartSizes};
use crate::blur::settings::Completion;
use crate::error::Result;
use crate::host::{HostBuffer, check_buffer as holds};
use crate::shaders::blur::constants::{MOST_OBJECT, MOST_SURFACE, OBJECT_SHIFT, SURFACE_SHIFT};

/// How much there is of a mesh: each at most what the effect was made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshSizes {
    /// Points.
    pub points: u32,
    /// Triangles.
    pub triangles: u32,
    /// Entries of the lists of neighbours.
    pub neighbours: u32,
    /// Surfaces: objects, by their materials.
    pub surfaces: u32,
    /// Normal groups, a multiple of [`GroupInput::MULTIPLE`]: the lists of the last may be empty.
    pub groups: u32,
    /// Entries of the lists of their triangles.
    pub group_triangles: u32,
}

/// The topology of the mesh, as [`crate::blur::Mesh`] has it. Usage of all buffers: `TRANSFER_SRC`.
#[derive(Clone, Copy, Debug)]
pub struct TopologyInput {
    /// Four `u32` a triangle: its points, and eight times the place of its object.
    pub triangles: HostBuffer,
    /// A `u32` a point and one more: where its list of neighbours begins, and the end of the last.
    pub neighbour_starts: HostBuffer,
    /// The lists.
    pub neighbours: HostBuffer,
    /// The normal groups; not needed unless `completion = "surface"` or frames are drawn.
    pub groups: Option<GroupInput>,
    /// Base colours, for frames that are drawn: four `f32` a corner of a triangle, linear RGB, not negative; unused.
    pub colours: Option<HostBuffer>,
    /// Textures that base colours are multiplied by in frames that are drawn ([`crate::blur::texture_rows`]); given exactly if
    /// the effect was made for them.
    pub textures: Option<HostBuffer>,
    /// Share of [`crate::blur::Settings::strength`] and of `lead` that each point has: an `f32`, 0 to 1, a point; none: all of it.
    pub shares: Option<HostBuffer>,
    /// The parts, given exactly if the effect was made for them.
    pub parts: Option<PartInput>,
    /// A `u32` a point, its vertex in its [`crate::blur::desc::Source`]; given exactly if the effect was made for sources.
    pub source_rows: Option<HostBuffer>,
    /// How much there is of it, if that is not what the effect was made for. The poses on the device are then of no mesh any more:
    /// the frame brings all that it needs.
    pub sizes: Option<MeshSizes>,
}

/// Which corners of triangles share a normal. Usage of all buffers: `TRANSFER_SRC`.
#[derive(Clone, Copy, Debug)]
pub struct GroupInput {
    /// Four `u32` a triangle: the groups of its corners, and 0.
    pub corners: HostBuffer,
    /// A `u32` a group and one more: where its list of triangles begins, and the end of the last.
    pub starts: HostBuffer,
    /// The lists.
    pub triangles: HostBuffer,
}

/// [`crate::blur::Parts`] on the device. Usage of all buffers: `TRANSFER_SRC`.
#[derive(Clone, Copy, Debug)]
pub struct PartInput {
    /// [`crate::blur::Parts::labels`].
    pub labels: HostBuffer,
    /// [`crate::blur::Parts::members`].
    pub members: HostBuffer,
    /// [`crate::blur::Parts::chunks`].
    pub chunks: HostBuffer,
    /// [`crate::blur::Parts::rows`].
    pub rows: HostBuffer,
    /// [`crate::blur::Parts::seams`]; not looked at if there are none.
    pub seams: HostBuffer,
}

impl MeshSizes {
    /// Those of a mesh as [`crate::blur::Upload`] packs it.
    pub fn of(mesh: &Mesh) -> MeshSizes {
        let groups = mesh.group_triangles().starts.len() as u32 - 1;
        MeshSizes {
            points: mesh.points() as u32,
            triangles: mesh.triangles().len() as u32,
            neighbours: mesh.neighbours().items.len() as u32,
            surfaces: mesh.surfaces(),
            groups: groups.next_multiple_of(GroupInput::MULTIPLE),
            group_triangles: mesh.group_triangles().items.len() as u32,
        }
    }

    fn named(&self) -> [(&'static str, u32); 6] {
        let MeshSizes { points, triangles, neighbours, surfaces, groups, group_triangles } = *self;
        [
            ("points", points),
            ("triangles", triangles),
            ("neighbours", neighbours),
            ("surfaces", surfaces),
            ("normal groups", groups),
            ("triangles of normal groups", group_triangles),
        ]
    }

    /// Refuses more than there is room for.
    pub(in crate::blur) fn check(&self, room: &MeshSizes) -> Result<()> {
        let pairs = self.named().into_iter().zip(room.named());
        for ((what, given), (_, most)) in pairs {
            if given > most {
                return refuse("the mesh", format!("{given} {what}; the effect was made for {most}"));
            }
        }
        match self.points == 0 || !self.groups.is_multiple_of(GroupInput::MULTIPLE) {
            true => refuse("the mesh", format!("{} points, {} normal groups", self.points, self.groups)),
            false => Ok(()),
        }
    }
}

impl GroupInput {
    /// Lists of so many groups are read at once.
    pub const MULTIPLE: u32 = crate::shaders::blur::normals::SHADER.local_size[0];

    /// The rows of [`GroupInput::corners`] of a mesh.
    pub fn corner_rows(mesh: &Mesh) -> Vec<[u32; 4]> {
        mesh.normal_groups().iter().map(|[a, b, c]| [*a, *b, *c, 0]).collect()
    }

    pub(super) fn validate(&self, desc: &Desc) -> Result<()> {
        holds("the mesh's normal groups", &self.corners, 16 * u64::from(desc.triangles))?;
        holds("the mesh's lists of normal groups", &self.starts, 4 * (u64::from(desc.groups) + 1))?;
        holds("the mesh's triangles of normal groups", &self.triangles, 4 * u64::from(desc.group_triangles))
    }
}

impl PartInput {
    /// The buffers, and the bytes that are needed of each.
    pub(in crate::blur) fn sized(&self, sizes: &PartSizes, points: u32) -> [(HostBuffer, u64); 5] {
        let PartSizes { parts, chunks, seams, .. } = *sizes;
        let points = u64::from(points);
        [
            (self.labels, 4 * points),
            (self.members, 4 * points),
            (self.chunks, size_of::<Chunk>() as u64 * u64::from(chunks)),
            (self.rows, size_of::<PartRow>() as u64 * u64::from(parts)),
            (self.seams, 4 * u64::from(seams)),
        ]
    }
}

impl TopologyInput {
    /// The rows of [`TopologyInput::colours`] of a mesh, from linear RGB of each vertex; where there is none, white.
    pub fn colour_rows(mesh: &Mesh, colours: &[[f32; 3]]) -> Vec<[f32; 4]> {
        let colour = |vertex: &u32| colours.get(*vertex as usize).map_or([1.0; 4], |[r, g, b]| [*r, *g, *b, 1.0]);
        mesh.corners().iter().flatten().map(colour).collect()
    }

    /// The rows of [`TopologyInput::triangles`] of a mesh. Objects and surfaces beyond those that have numbers there count as
    /// one.
    pub fn triangle_rows(mesh: &Mesh) -> Vec<[u32; 4]> {
        let place = |id: &u32| mesh.objects().partition_point(|object| object < id) as u32;
        let of = mesh.triangle_objects().iter().zip(mesh.triangle_surfaces());
        let words = of.map(|(id, surface)| {
            place(id).min(MOST_OBJECT) << OBJECT_SHIFT | (*surface).min(MOST_SURFACE) << SURFACE_SHIFT
        });
        mesh.triangles().iter().zip(words).map(|([a, b, c], word)| [*a, *b, *c, word]).collect()
    }
}

impl TopologyInput {
    pub(super) fn validate(&self, desc: &Desc) -> Result<()> {
        holds("the mesh's triangles", &self.triangles, 16 * u64::from(desc.triangles))?;
        holds("the mesh's lists of neighbours", &self.neighbour_starts, 4 * (u64::from(desc.points) + 1))?;
        holds("the mesh's neighbours", &self.neighbours, 4 * u64::from(desc.neighbours))?;
        match &self.groups {
            None if desc.toon || desc.settings.completion == Completion::Surface => {
                let why = "completion = \"surface\" and frames that are drawn need them";
                refuse("the mesh's normal groups", why.to_owned())
            }
            groups => groups.iter().try_for_each(|groups| groups.validate(desc)),
        }?;
        match (&self.parts, &desc.parts) {
            (None, None) => {}
            (Some(parts), Some(sizes)) => {
                for (buffer, bytes) in parts.sized(sizes, desc.points).iter().filter(|(_, bytes)| *bytes > 0) {
                    holds("the mesh's parts", buffer, *bytes)?;
                }
            }
            (given, _) => return refuse("the mesh's parts", one_sided(given.is_some())),
        }
        match (&self.source_rows, desc.sources.is_empty()) {
            (None, true) => {}
            (Some(rows), false) => holds("the mesh's source rows", rows, 4 * u64::from(desc.points))?,
            (given, _) => return refuse("the mesh's source rows", one_sided(given.is_some())),
        }
        match (&self.textures, desc.texture_rows) {
            (None, 0) => {}
            (Some(rows), 1..) => holds("the mesh's textures", rows, 16 * u64::from(desc.texture_rows))?,
            (given, _) => return refuse("the mesh's textures", one_sided(given.is_some())),
        }
        self.shares
            .iter()
            .try_for_each(|shares| holds("the mesh's shares of strength", shares, 4 * u64::from(desc.points)))?;
        match &self.colours {
            Some(colours) => holds("the mesh's colours", colours, 48 * u64::from(desc.triangles)),
            None if desc.toon => refuse("the mesh's colours", "frames that are drawn need them".to_owned()),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blur::MeshInput;

    #[test]
    fn objects_and_surfaces_beyond_those_that_have_numbers_count_as_one() {
        let count = MOST_SURFACE + 3;
        let triangles: Vec<[u32; 3]> = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let numbers: Vec<u32> = (0..3 * count).map(|vertex| vertex / 3).collect();
        let (vertices, objects) = (numbers.len(), Some(&numbers[..]));
        let input = MeshInput { vertices, triangles: &triangles, objects, weld: None, normals: None, rest: None };
        let words = |mesh: &Mesh| -> Vec<[u32; 2]> {
            let word = |row: &[u32; 4]| [row[3] >> OBJECT_SHIFT, row[3] >> SURFACE_SHIFT & MOST_SURFACE];
            TopologyInput::triangle_rows(mesh).iter().map(word).collect()
        };
        let expected = |i: u32| [i.min(MOST_OBJECT), i.min(MOST_SURFACE)];
        assert_eq!(words(&Mesh::new(&input).expect("a mesh")), (0..count).map(expected).collect::<Vec<_>>());
        // Of one object, of as many materials.
        let mut mesh = Mesh::new(&MeshInput { objects: None, ..input }).expect("a mesh");
        mesh.set_materials(&numbers).expect("one a vertex");
        assert_eq!(words(&mesh), (0..count).map(|i| [0, i.min(MOST_SURFACE)]).collect::<Vec<_>>());
    }

    #[test]
    fn a_mesh_has_room_or_is_refused_by_name() {
        let triangles = [[0, 1, 2], [1, 3, 2]];
        let input =
            MeshInput { vertices: 4, triangles: &triangles, objects: None, weld: None, normals: None, rest: None };
        let sizes = MeshSizes::of(&Mesh::new(&input).expect("a mesh"));
        assert_eq!((sizes.points, sizes.triangles, sizes.neighbours, sizes.surfaces), (4, 2, 10, 1));
        // Groups without triangles stand behind the others.
        assert_eq!((sizes.groups, sizes.group_triangles), (GroupInput::MULTIPLE, 6));
        assert!(sizes.check(&sizes).is_ok());
        let error = |sizes: MeshSizes, room: MeshSizes| sizes.check(&room).expect_err("refused").to_string();
        let less = MeshSizes { triangles: 1, ..sizes };
        assert!(error(sizes, less).contains("2 triangles; the effect was made for 1"), "{}", error(sizes, less));
        assert!(error(MeshSizes { points: 0, ..sizes }, sizes).contains("0 points"));
        assert!(error(MeshSizes { groups: 3, ..sizes }, sizes).contains("3 normal groups"));
    }
}
