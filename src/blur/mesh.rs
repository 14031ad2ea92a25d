//! The constant part of an animated mesh: which vertices are one point, which triangles meet where.

use std::collections::HashMap;
use std::hash::Hash;

use super::shells::{Shells, Solid};
use crate::error::{Error, Result};

/// A mesh as a file or a host holds it.
#[derive(Clone, Copy, Debug)]
pub struct MeshInput<'a> {
    /// Number of vertices.
    pub vertices: usize,
    /// The vertices of each triangle, in either direction. Those without area are drawn nowhere and may stay.
    pub triangles: &'a [[u32; 3]],
    /// Object of each vertex, any number; without: one object. A triangle belongs to one object.
    pub objects: Option<&'a [u32]>,
    /// Vertices with the same number here are one point: those that are in the same place in all frames, which are
    /// separate only because normals or texture coordinates differ. Without: each vertex is a point.
    pub weld: Option<&'a [u32]>,
    /// Normal of each vertex at rest. Vertices of one point that have the same bits here share a smooth normal. Without:
    /// all of a point do.
    pub normals: Option<&'a [[f32; 3]]>,
    /// Position of each vertex at any time: the triangles of closed surfaces are turned counter-clockwise as seen from
    /// outside then. Without: as the first of them. Pictures differ by no more than rounding.
    pub rest: Option<&'a [[f32; 3]]>,
}

/// The topology of an animated mesh.
///
/// *Points* are welded vertices, numbered by their first vertex. Everything but [`Mesh::file_to_point`],
/// [`Mesh::point_to_file`] and [`Mesh::corners`] speaks of points. Triangles that hang together run in one direction, whatever
/// they do in the input. Nothing here depends on the order of anything but the input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mesh {
    points: usize,
    file_to_point: Vec<u32>,
    point_to_file: Vec<u32>,
    corners: Vec<[u32; 3]>,
    triangles: Vec<[u32; 3]>,
    shells: Shells,
    triangle_objects: Vec<u32>,
    triangle_surfaces: Vec<u32>,
    surfaces: u32,
    point_objects: Vec<u32>,
    neighbours: Lists,
    point_triangles: Lists,
    normal_groups: Vec<[u32; 3]>,
    group_triangles: Lists,
    objects: Vec<u32>,
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

    /// The lists of another, whose items are greater by so much.
    fn append(&mut self, other: &Lists, items: u32) {
        let end = self.items.len() as u32;
        self.starts.extend(other.starts[1..].iter().map(|start| start + end));
        self.items.extend(other.items.iter().map(|item| item + items));
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

fn check_length(name: &str, length: usize, vertices: usize) -> Result<()> {
    match length == vertices {
        true => Ok(()),
        false => Err(refused(format!("{length} entries of {name} for {vertices} vertices; give one a vertex"))),
    }
}

/// Ends of lists must fit into 32 bits too: an edge is in two lists of neighbours, for each of its triangles.
fn check_size(vertices: usize, triangles: usize) -> Result<()> {
    match vertices > 1 << 30 || triangles > (u32::MAX / 6) as usize {
        true => Err(refused(format!("{vertices} vertices, {triangles} triangles: too many"))),
        false => Ok(()),
    }
}

/// Refuses what can't be a mesh.
fn check(input: &MeshInput) -> Result<()> {
    let vertices = input.vertices;
    if vertices == 0 {
        return Err(refused("it has no vertices".into()));
    }
    check_size(vertices, input.triangles.len())?;
    let numbers = [("objects", input.objects), ("weld", input.weld)].map(|(name, list)| (name, list.map(<[_]>::len)));
    let vectors = [("normals", input.normals), ("rest", input.rest)].map(|(name, list)| (name, list.map(<[_]>::len)));
    for (name, length) in numbers.into_iter().chain(vectors) {
        check_length(name, length.unwrap_or(vertices), vertices)?;
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
        let point_of = |vertex: u32| file_to_point[vertex as usize];
        let rest = input.rest.map(|rest| point_to_file.iter().map(|v| rest[*v as usize]).collect::<Vec<_>>());
        let (corners, shells) = oriented(input.triangles, point_of, rest.as_deref());
        let triangles: Vec<[u32; 3]> = corners.iter().map(|t| t.map(point_of)).collect();
        let object = |vertex: u32| input.objects.map_or(0, |objects| objects[vertex as usize]);
        let sides = triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]).filter(|(a, b)| a != b);
        let neighbours = Lists::new(points, sides.flat_map(|(a, b)| [(a, b), (b, a)]).collect());
        let point_objects: Vec<u32> = point_to_file.iter().map(|v| object(*v)).collect();
        let mut objects = point_objects.clone();
        objects.sort_unstable();
        objects.dedup();
        let mut mesh = Mesh {
            points,
            triangle_objects: triangles.iter().map(|t| point_objects[t[0] as usize]).collect(),
            triangle_surfaces: Vec::new(),
            surfaces: 1,
            neighbours,
            point_triangles: Lists::new(points, by_corner(&triangles)),
            group_triangles: Lists::default(),
            objects,
            file_to_point,
            point_to_file,
            corners,
            triangles,
            shells,
            point_objects,
            normal_groups: Vec::new(),
        };
        mesh.find_surfaces(|_| 0);
        match input.normals {
            Some(normals) => mesh.set_normals(normals)?,
            None => mesh.group(&mesh.file_to_point.clone()),
        }
        Ok(mesh)
    }

    /// Material of each vertex, any number; without: one. What an object has of one material is a *surface*: colours that images
    /// show of one stand for no place of another, and those that hide are completed by surface. A triangle is of its first
    /// vertex' material. Effects tell 32,767 surfaces and 16,383 objects apart; those beyond count as one.
    ///
    /// # Errors
    /// Not one a vertex.
    pub fn set_materials(&mut self, materials: &[u32]) -> Result<()> {
        check_length("materials", materials.len(), self.file_to_point.len())?;
        self.find_surfaces(|vertex| materials[vertex as usize]);
        Ok(())
    }

    /// Surfaces by their objects' numbers, then by their materials'.
    fn find_surfaces(&mut self, material_of: impl Fn(u32) -> u32) {
        let corners = self.corners.iter().map(|corners| material_of(corners[0]));
        let keys: Vec<(u32, u32)> = self.triangle_objects.iter().copied().zip(corners).collect();
        let mut known = keys.clone();
        known.sort_unstable();
        known.dedup();
        self.triangle_surfaces = keys.iter().map(|key| known.partition_point(|other| other < key) as u32).collect();
        self.surfaces = (known.len() as u32).max(1);
    }

    /// Takes the place of [`MeshInput::normals`], where these follow from the mesh.
    ///
    /// # Errors
    /// Not one a vertex.
    pub fn set_normals(&mut self, normals: &[[f32; 3]]) -> Result<()> {
        check_length("normals", normals.len(), self.file_to_point.len())?;
        let keys = self.file_to_point.iter().zip(normals).map(|(p, n)| (*p, n.map(f32::to_bits)));
        self.group(&number(keys).0);
        Ok(())
    }

    /// `groups`: the normal group of each vertex.
    fn group(&mut self, groups: &[u32]) {
        let count = groups.iter().max().map_or(0, |last| *last as usize + 1);
        self.normal_groups = self.corners.iter().map(|t| t.map(|v| groups[v as usize])).collect();
        self.group_triangles = Lists::new(count, by_corner(&self.normal_groups));
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

    /// Several meshes as one, for one effect: vertices, points, triangles and normal groups of each follow those of the one
    /// before; its objects, too, by their order.
    ///
    /// # Errors
    /// No mesh, or too many triangles.
    pub fn join(meshes: &[&Mesh]) -> Result<Mesh> {
        let triangles: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        let vertices: usize = meshes.iter().map(|mesh| mesh.file_to_point.len()).sum();
        check_size(vertices, triangles)?;
        let (first, others) = meshes.split_first().ok_or_else(|| refused("there is none to join".into()))?;
        let mut joined = (*first).clone();
        joined.number_objects(0);
        others.iter().for_each(|other| joined.append(other));
        Ok(joined)
    }

    /// Objects become numbers from `first` on, in their order.
    fn number_objects(&mut self, first: u32) {
        let Mesh { objects, triangle_objects, point_objects, .. } = self;
        for object in triangle_objects.iter_mut().chain(point_objects) {
            *object = first + objects.partition_point(|other| *other < *object) as u32;
        }
        *objects = (first..).take(objects.len()).collect();
    }

    fn append(&mut self, other: &Mesh) {
        let mut other = other.clone();
        other.number_objects(self.objects.len() as u32);
        let (points, vertices) = (self.points as u32, self.file_to_point.len() as u32);
        let (triangles, groups) = (self.triangles.len() as u32, self.group_triangles.starts.len() as u32 - 1);
        let rows = |rows: Vec<[u32; 3]>, by: u32| rows.into_iter().map(move |row| row.map(|number| number + by));
        self.file_to_point.extend(other.file_to_point.iter().map(|point| point + points));
        self.point_to_file.extend(other.point_to_file.iter().map(|vertex| vertex + vertices));
        self.corners.extend(rows(other.corners, vertices));
        self.triangles.extend(rows(other.triangles, points));
        self.normal_groups.extend(rows(other.normal_groups, groups));
        self.shells.append(&other.shells);
        self.triangle_objects.extend(other.triangle_objects);
        self.triangle_surfaces.extend(other.triangle_surfaces.iter().map(|surface| surface + self.surfaces));
        self.surfaces += other.surfaces;
        self.point_objects.extend(other.point_objects);
        self.neighbours.append(&other.neighbours, points);
        self.point_triangles.append(&other.point_triangles, triangles);
        self.group_triangles.append(&other.group_triangles, triangles);
        self.objects.extend(other.objects);
        self.points += other.points;
    }

    /// Where each point is in the host's sources ([`crate::blur::Source`]), and how many points are of each: `vertices` has the
    /// vertices of each source, which follow each other in the mesh.
    ///
    /// # Errors
    /// Together not the mesh's vertices.
    pub fn source_rows(&self, vertices: &[u32]) -> Result<(Vec<u32>, Vec<u32>)> {
        let sum: u64 = vertices.iter().map(|count| u64::from(*count)).sum();
        if sum != self.file_to_point.len() as u64 {
            return Err(refused(format!("{sum} vertices in sources; it has {}", self.file_to_point.len())));
        }
        let (mut first, mut rows, mut points) = (0, Vec::with_capacity(self.points), Vec::new());
        for count in vertices {
            let (begin, end) = (first, first + count);
            first = end;
            // Points are numbered by their first vertex.
            let own = self.point_to_file[rows.len()..].iter().take_while(|vertex| **vertex < end);
            let before = rows.len();
            rows.extend(own.map(|vertex| vertex - begin).collect::<Vec<_>>());
            points.push((rows.len() - before) as u32);
        }
        Ok((rows, points))
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

    /// The vertices of each triangle, in the order of [`Mesh::triangles`].
    pub fn corners(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// The points of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The object of each triangle.
    pub fn triangle_objects(&self) -> &[u32] {
        &self.triangle_objects
    }

    /// The surface of each triangle: a number below [`Mesh::surfaces`].
    pub fn triangle_surfaces(&self) -> &[u32] {
        &self.triangle_surfaces
    }

    /// Number of surfaces, at least 1: objects, by their materials ([`Mesh::set_materials`]).
    pub fn surfaces(&self) -> u32 {
        self.surfaces
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

    /// The numbers of the objects in the input, ascending.
    pub fn objects(&self) -> &[u32] {
        &self.objects
    }

    /// The closed surfaces.
    pub fn shells(&self) -> &Shells {
        &self.shells
    }

    /// The solid that each of them encloses, in the place of what is in `solids`; one position a point.
    pub(super) fn find_solids(&self, positions: &[[f32; 3]], solids: &mut Vec<Solid>) {
        self.shells.find_solids(&self.triangles, positions, solids);
    }

    /// What the points have, as positions, from what the vertices have; none where their number is another.
    pub fn gather<T: Copy>(&self, vertices: &[T]) -> Option<Vec<T>> {
        let point = |vertex: &u32| vertices[*vertex as usize];
        (vertices.len() == self.file_to_point.len()).then(|| self.point_to_file.iter().map(point).collect())
    }
}

/// Each triangle once for each of its corners.
fn by_corner(corners: &[[u32; 3]]) -> Vec<(u32, u32)> {
    corners.iter().zip(0..).flat_map(|(corners, triangle)| corners.map(|corner| (corner, triangle))).collect()
}

/// The triangles, turned over where they must be, and the shells that they make up.
fn oriented(
    triangles: &[[u32; 3]],
    point_of: impl Fn(u32) -> u32 + Copy,
    rest: Option<&[[f32; 3]]>,
) -> (Vec<[u32; 3]>, Shells) {
    let of_points = |corners: &[[u32; 3]]| corners.iter().map(|t| t.map(point_of)).collect::<Vec<_>>();
    let (shells, turned) = Shells::find(&of_points(triangles));
    let turn = |corners: &mut [[u32; 3]], is_turned: &dyn Fn(usize) -> bool| {
        let all = corners.iter_mut().enumerate().filter(|(triangle, _)| is_turned(*triangle));
        all.for_each(|(_, corners)| corners.swap(1, 2));
    };
    let mut corners = triangles.to_vec();
    turn(&mut corners, &|triangle| turned[triangle]);
    if let Some(rest) = rest {
        let mut solids = Vec::new();
        shells.find_solids(&of_points(&corners), rest, &mut solids);
        let is_turned = |shell: usize| solids[shell].is_turned() == Some(true);
        turn(&mut corners, &|triangle| shells.of(triangle).is_some_and(is_turned));
    }
    (corners, shells)
}

#[cfg(test)]
mod tests;
