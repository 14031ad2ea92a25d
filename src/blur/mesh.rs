//! What never changes of an animated mesh: which vertices are one point, which triangles meet where.

use std::collections::HashMap;
use std::hash::Hash;

use crate::error::{Error, Result};

/// A mesh as a file or a host holds it.
#[derive(Clone, Copy, Debug)]
pub struct MeshInput<'a> {
    /// Number of vertices.
    pub vertices: usize,
    /// The vertices of each triangle. Those without area are drawn nowhere and may stay.
    pub triangles: &'a [[u32; 3]],
    /// Object of each vertex, any number; without: one object. A triangle belongs to one object.
    pub objects: Option<&'a [u32]>,
    /// Vertices with the same number here are one point: those that are in the same place in all frames, which are
    /// separate only because normals or texture coordinates differ. Without: each vertex is a point.
    pub weld: Option<&'a [u32]>,
    /// Normal of each vertex at rest. Vertices of one point that have the same bits here share a smooth normal. Without:
    /// all of a point do.
    pub normals: Option<&'a [[f32; 3]]>,
}

/// The topology of an animated mesh.
///
/// *Points* are welded vertices, numbered by their first vertex. Everything but [`Mesh::file_to_point`] and
/// [`Mesh::point_to_file`] speaks of points. Nothing here depends on the order of anything but the input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mesh {
    points: usize,
    file_to_point: Vec<u32>,
    point_to_file: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    triangle_objects: Vec<u32>,
    point_objects: Vec<u32>,
    neighbours: Lists,
    point_triangles: Lists,
    normal_groups: Vec<[u32; 3]>,
    group_triangles: Lists,
    objects: Vec<Object>,
}

/// One object of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Object {
    /// Its number in the input.
    pub id: u32,
    /// Whether each of its edges is shared by exactly two triangles that run along it in opposite directions. Triangles
    /// with two equal points do not count; a point without triangles is no border.
    pub closed: bool,
}

/// Lists of numbers, one after the other: list i is `items[starts[i]..starts[i + 1]]`, ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lists {
    /// Where each list begins, and the end of the last.
    pub starts: Vec<u32>,
    /// The lists.
    pub items: Vec<u32>,
}

impl Lists {
    /// List `i`.
    pub fn of(&self, i: usize) -> &[u32] {
        &self.items[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// Lists 0 to `count` - 1 of the second numbers of pairs, by the first; double pairs count once.
    fn new(count: usize, mut pairs: Vec<(u32, u32)>) -> Lists {
        pairs.sort_unstable();
        pairs.dedup();
        let mut starts = vec![0; count + 1];
        pairs.iter().for_each(|(list, _)| starts[*list as usize + 1] += 1);
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        Lists { starts, items: pairs.into_iter().map(|(_, item)| item).collect() }
    }
}

/// Numbers things by their first occurrence: the number of each, and the place of the first of each number.
fn number<K: Hash + Eq>(keys: impl Iterator<Item = K>) -> (Vec<u32>, Vec<u32>) {
    let (mut seen, mut first) = (HashMap::new(), Vec::new());
    let numbers = keys.enumerate().map(|(place, key)| {
        *seen.entry(key).or_insert_with(|| {
            first.push(place as u32);
            first.len() as u32 - 1
        })
    });
    (numbers.collect(), first)
}

fn refused(why: String) -> Error {
    Error::HostResource { name: "blur mesh", why }
}

/// Refuses what can't be a mesh.
fn check(input: &MeshInput) -> Result<()> {
    let vertices = input.vertices;
    if vertices == 0 {
        return Err(refused("it has no vertices".into()));
    }
    // Ends of lists must fit into 32 bits too: an edge is in two lists of neighbours, for each of its triangles.
    if vertices > 1 << 30 || input.triangles.len() > (u32::MAX / 6) as usize {
        return Err(refused(format!("{vertices} vertices, {} triangles: too many", input.triangles.len())));
    }
    let lists = [("objects", input.objects.map(<[u32]>::len)), ("weld", input.weld.map(<[u32]>::len))];
    for (name, length) in lists.into_iter().chain([("normals", input.normals.map(<[[f32; 3]]>::len))]) {
        if let Some(length) = length.filter(|length| *length != vertices) {
            return Err(refused(format!("{length} entries of {name} for {vertices} vertices; give one a vertex")));
        }
    }
    for (i, triangle) in input.triangles.iter().enumerate() {
        if let Some(vertex) = triangle.iter().find(|v| **v as usize >= vertices) {
            return Err(refused(format!("triangle {i} has vertex {vertex}; the last of them is {}", vertices - 1)));
        }
        if let Some(objects) = input.objects {
            let [a, b, c] = triangle.map(|v| objects[v as usize]);
            if a != b || a != c {
                return Err(refused(format!("triangle {i} has vertices of objects {a}, {b} and {c}; it needs one")));
            }
        }
    }
    if let (Some(weld), Some(objects)) = (input.weld, input.objects) {
        let mut object_of = HashMap::new();
        for (vertex, (point, object)) in weld.iter().zip(objects).enumerate() {
            if *object_of.entry(point).or_insert(object) != object {
                return Err(refused(format!(
                    "vertex {vertex} is welded to one of another object; weld within objects"
                )));
            }
        }
    }
    Ok(())
}

impl Mesh {
    /// Finds the topology.
    ///
    /// # Errors
    /// No vertices, lists of another length, a vertex number out of range, a triangle or a point in two objects.
    pub fn new(input: &MeshInput) -> Result<Mesh> {
        check(input)?;
        let (file_to_point, point_to_file) = match input.weld {
            Some(weld) => number(weld.iter()),
            None => (0..input.vertices as u32).map(|v| (v, v)).unzip(),
        };
        let points = point_to_file.len();
        let triangles: Vec<[u32; 3]> = input.triangles.iter().map(|t| t.map(|v| file_to_point[v as usize])).collect();
        let object = |vertex: u32| input.objects.map_or(0, |objects| objects[vertex as usize]);
        let groups = match input.normals {
            Some(normals) => number(file_to_point.iter().zip(normals).map(|(p, n)| (*p, n.map(f32::to_bits)))).0,
            None => file_to_point.clone(),
        };
        let normal_groups: Vec<[u32; 3]> = input.triangles.iter().map(|t| t.map(|v| groups[v as usize])).collect();
        let group_count = groups.iter().max().map_or(0, |last| *last as usize + 1);
        let sides = triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]).filter(|(a, b)| a != b);
        let neighbours = Lists::new(points, sides.flat_map(|(a, b)| [(a, b), (b, a)]).collect());
        let point_objects: Vec<u32> = point_to_file.iter().map(|v| object(*v)).collect();
        Ok(Mesh {
            points,
            triangle_objects: triangles.iter().map(|t| point_objects[t[0] as usize]).collect(),
            neighbours,
            point_triangles: Lists::new(points, by_corner(&triangles)),
            group_triangles: Lists::new(group_count, by_corner(&normal_groups)),
            objects: objects(&point_objects, &triangles),
            file_to_point,
            point_to_file,
            triangles,
            point_objects,
            normal_groups,
        })
    }

    /// The same mesh with flat triangles: those that `is_flat` says, by their number, have a normal of their own.
    pub fn faceted(mut self, is_flat: impl Fn(usize) -> bool) -> Mesh {
        let smooth = |groups: &[u32; 3]| groups.map(|group| (false, group));
        let flat = |triangle: usize| [(true, triangle as u32); 3];
        let corners = self.normal_groups.iter().enumerate();
        let corners = corners.flat_map(|(i, groups)| if is_flat(i) { flat(i) } else { smooth(groups) });
        let (groups, firsts) = number(corners);
        self.normal_groups = groups.as_chunks().0.to_vec();
        self.group_triangles = Lists::new(firsts.len(), by_corner(&self.normal_groups));
        self
    }

    /// Number of points V, at least 1.
    pub fn points(&self) -> usize {
        self.points
    }

    /// The point of each vertex.
    pub fn file_to_point(&self) -> &[u32] {
        &self.file_to_point
    }

    /// The first vertex of each point.
    pub fn point_to_file(&self) -> &[u32] {
        &self.point_to_file
    }

    /// The points of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The object of each triangle.
    pub fn triangle_objects(&self) -> &[u32] {
        &self.triangle_objects
    }

    /// The object of each point.
    pub fn point_objects(&self) -> &[u32] {
        &self.point_objects
    }

    /// The points at the other ends of each point's edges.
    pub fn neighbours(&self) -> &Lists {
        &self.neighbours
    }

    /// The triangles at each point.
    pub fn point_triangles(&self) -> &Lists {
        &self.point_triangles
    }

    /// The normal group of each corner of each triangle: corners of a group have one normal.
    pub fn normal_groups(&self) -> &[[u32; 3]] {
        &self.normal_groups
    }

    /// The triangles of each normal group.
    pub fn group_triangles(&self) -> &Lists {
        &self.group_triangles
    }

    /// The objects, by ascending id.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Positions of the points from those of the vertices; none where their number is another.
    pub fn gather(&self, vertices: &[[f32; 3]]) -> Option<Vec<[f32; 3]>> {
        let point = |vertex: &u32| vertices[*vertex as usize];
        (vertices.len() == self.file_to_point.len()).then(|| self.point_to_file.iter().map(point).collect())
    }
}

/// Each triangle once for each of its corners.
fn by_corner(corners: &[[u32; 3]]) -> Vec<(u32, u32)> {
    corners.iter().zip(0..).flat_map(|(corners, triangle)| corners.map(|corner| (corner, triangle))).collect()
}

fn objects(point_objects: &[u32], triangles: &[[u32; 3]]) -> Vec<Object> {
    let mut ids = point_objects.to_vec();
    ids.sort_unstable();
    ids.dedup();
    let mut objects: Vec<Object> = ids.iter().map(|id| Object { id: *id, closed: true }).collect();
    let whole = triangles.iter().filter(|[a, b, c]| a != b && b != c && c != a);
    let sides = whole.flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]);
    let mut edges: Vec<(u32, u32, bool)> = sides.map(|(a, b)| (a.min(b), a.max(b), a < b)).collect();
    edges.sort_unstable();
    for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if edge.len() != 2 || edge[0].2 == edge[1].2 {
            let id = point_objects[edge[0].0 as usize];
            if let Ok(place) = ids.binary_search(&id) {
                objects[place].closed = false;
            }
        }
    }
    objects
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];

    fn input<'a>(vertices: usize, triangles: &'a [[u32; 3]]) -> MeshInput<'a> {
        MeshInput { vertices, triangles, objects: None, weld: None, normals: None }
    }

    #[test]
    fn a_tetrahedron_is_closed_and_everything_meets() {
        let mesh = Mesh::new(&input(4, &TETRAHEDRON)).unwrap();
        assert_eq!(mesh.objects(), [Object { id: 0, closed: true }]);
        for point in 0..4 {
            let others: Vec<u32> = (0..4).filter(|other| *other != point).collect();
            assert_eq!(mesh.neighbours().of(point as usize), others);
            assert_eq!(mesh.point_triangles().of(point as usize).len(), 3);
        }
        assert_eq!(mesh.point_triangles().of(3), [1, 2, 3]);
        assert_eq!(mesh.normal_groups(), TETRAHEDRON);
    }

    #[test]
    fn what_is_open_or_inconsistent_is_not_closed() {
        let closed = |triangles: &[[u32; 3]]| Mesh::new(&input(5, triangles)).unwrap().objects()[0].closed;
        assert!(closed(&TETRAHEDRON));
        assert!(!closed(&TETRAHEDRON[..3]));
        let mut turned = TETRAHEDRON;
        turned[0].swap(0, 1);
        assert!(!closed(&turned));
        let mut fin = TETRAHEDRON.to_vec();
        fin.push([0, 1, 4]);
        assert!(!closed(&fin));
        fin[4] = [0, 1, 1];
        assert!(closed(&fin));
        // Two tetrahedra that share an edge: four triangles meet there.
        let mut pair = TETRAHEDRON.to_vec();
        pair.extend(TETRAHEDRON.map(|t| t.map(|v| if v < 2 { v } else { v + 2 })));
        assert!(!Mesh::new(&input(6, &pair)).unwrap().objects()[0].closed);
    }

    #[test]
    fn welded_vertices_are_points_by_first_occurrence() {
        // Two triangles of a square, each with its own vertices; 9 stands for both ends of the diagonal's first corner.
        let weld = [9, 4, 7, 7, 2, 9];
        let triangles = [[0, 1, 2], [3, 4, 5]];
        let mesh = Mesh::new(&MeshInput { weld: Some(&weld), ..input(6, &triangles) }).unwrap();
        assert_eq!(mesh.points(), 4);
        assert_eq!(mesh.file_to_point(), [0, 1, 2, 2, 3, 0]);
        assert_eq!(mesh.point_to_file(), [0, 1, 2, 4]);
        assert_eq!(mesh.triangles(), [[0, 1, 2], [2, 3, 0]]);
        assert_eq!(mesh.neighbours().of(0), [1, 2, 3]);
        assert_eq!(mesh.neighbours().of(1), [0, 2]);
        assert_eq!(mesh.gather(&[[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3], [4.0; 3], [5.0; 3]]).unwrap()[3], [4.0; 3]);
        assert_eq!(mesh.gather(&[[0.0; 3]]), None);
    }

    #[test]
    fn normals_split_what_is_welded() {
        let weld = [0, 1, 2, 2, 3, 0];
        let triangles = [[0, 1, 2], [3, 4, 5]];
        let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let normals = [x, x, x, y, y, x];
        let hard = MeshInput { weld: Some(&weld), normals: Some(&normals), ..input(6, &triangles) };
        let mesh = Mesh::new(&hard).unwrap();
        let [first, second] = [mesh.normal_groups()[0], mesh.normal_groups()[1]];
        assert_eq!(first[0], second[2], "the same normal");
        assert_ne!(first[2], second[0], "an edge");
        assert_eq!(mesh.group_triangles().of(first[0] as usize), [0, 1]);
        assert_eq!(mesh.group_triangles().of(first[2] as usize), [0]);
        let smooth = Mesh::new(&MeshInput { normals: None, ..hard }).unwrap();
        assert_eq!(smooth.normal_groups(), smooth.triangles());
    }

    #[test]
    fn flat_triangles_share_no_normal() {
        let flat = Mesh::new(&input(4, &TETRAHEDRON)).unwrap().faceted(|_| true);
        assert_eq!(flat.normal_groups(), [[0; 3], [1; 3], [2; 3], [3; 3]]);
        assert!((0..4).all(|group| flat.group_triangles().of(group) == [group as u32]));
        // One flat triangle leaves the others as they were.
        let mixed = Mesh::new(&input(4, &TETRAHEDRON)).unwrap().faceted(|triangle| triangle == 3);
        let [a, b, c, d] = mixed.normal_groups() else { panic!("four triangles") };
        assert_eq!((a[0], a[1], b[1], d[0]), (b[0], c[0], c[1], d[2]));
        assert!([a, b, c].iter().all(|groups| !groups.contains(&d[0])));
        assert_eq!(mixed.group_triangles().of(d[0] as usize), [3]);
        assert_eq!(mixed.group_triangles().of(a[0] as usize), [0, 1]);
        let smooth = Mesh::new(&input(4, &TETRAHEDRON)).unwrap();
        assert_eq!((smooth.triangles(), smooth.objects()), (flat.triangles(), flat.objects()));
    }

    #[test]
    fn objects_are_separate() {
        let mut triangles = TETRAHEDRON.to_vec();
        triangles.push([4, 5, 6]);
        let objects = [8, 8, 8, 8, 3, 3, 3];
        let mesh = Mesh::new(&MeshInput { objects: Some(&objects), ..input(7, &triangles) }).unwrap();
        assert_eq!(mesh.objects(), [Object { id: 3, closed: false }, Object { id: 8, closed: true }]);
        assert_eq!(mesh.triangle_objects(), [8, 8, 8, 8, 3]);
        assert_eq!(mesh.point_objects(), objects);
    }

    #[test]
    fn what_cannot_be_a_mesh_is_refused_by_name() {
        let error = |input: MeshInput| Mesh::new(&input).unwrap_err().to_string();
        assert!(error(input(0, &[])).contains("no vertices"));
        assert!(error(input(3, &[[0, 1, 2], [0, 1, 3]])).contains("triangle 1 has vertex 3"));
        let (objects, triangles) = ([1, 1, 2], [[0, 1, 2]]);
        let two = MeshInput { objects: Some(&objects), ..input(3, &triangles) };
        assert!(error(two).contains("triangle 0 has vertices of objects 1, 1 and 2"));
        let weld = [0, 1, 1];
        assert!(error(MeshInput { triangles: &[], weld: Some(&weld), ..two }).contains("vertex 2 is welded"));
        assert!(error(MeshInput { weld: Some(&weld), ..input(4, &[]) }).contains("3 entries of weld for 4 vertices"));
        assert!(error(MeshInput { normals: Some(&[]), ..input(1, &[]) }).contains("0 entries of normals"));
        assert!(Mesh::new(&input(1, &[])).is_ok());
    }
}
