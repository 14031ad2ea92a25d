use super::*;

const TETRAHEDRON: [[u32; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];

fn input<'a>(vertices: usize, triangles: &'a [[u32; 3]]) -> MeshInput<'a> {
    MeshInput { vertices, triangles, objects: None, weld: None, normals: None, rest: None }
}

#[test]
fn a_tetrahedron_is_closed_and_everything_meets() {
    let mesh = Mesh::new(&input(4, &TETRAHEDRON)).unwrap();
    assert_eq!(mesh.objects(), [0]);
    assert!((0..4).all(|triangle| mesh.shells().of(triangle) == Some(0)));
    for point in 0..4 {
        let others: Vec<u32> = (0..4).filter(|other| *other != point).collect();
        assert_eq!(mesh.neighbours().of(point as usize), others);
        assert_eq!(mesh.point_triangles().of(point as usize).len(), 3);
    }
    assert_eq!(mesh.point_triangles().of(3), [1, 2, 3]);
    assert_eq!(mesh.normal_groups(), TETRAHEDRON);
}

/// All that is drawn is what the same triangles in one direction are drawn as: where they are turned over at random,
/// and where all of them are.
#[test]
fn triangles_run_counter_clockwise_whatever_they_do_in_the_input() {
    let corners = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let mirrored = corners.map(|[x, y, z]: [f32; 3]| [-x, y, z]);
    for mask in 0..16 {
        let mut triangles = TETRAHEDRON;
        triangles.iter_mut().enumerate().filter(|(i, _)| mask >> i & 1 == 1).for_each(|(_, t)| t.swap(1, 2));
        let rest = Some(&corners[..]);
        let mesh = Mesh::new(&MeshInput { rest, ..input(4, &triangles) }).unwrap();
        assert_eq!(mesh, Mesh::new(&input(4, &TETRAHEDRON)).unwrap(), "{mask}");
        let turned = Mesh::new(&MeshInput { rest: Some(&mirrored), ..input(4, &triangles) }).unwrap();
        assert_eq!(turned.triangles(), TETRAHEDRON.map(|[a, b, c]| [a, c, b]), "{mask}");
        assert_eq!(turned.corners(), turned.triangles(), "{mask}");
    }
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
    let mut smooth = Mesh::new(&MeshInput { normals: None, ..hard }).unwrap();
    assert_eq!(smooth.normal_groups(), smooth.triangles());
    smooth.set_normals(&normals).unwrap();
    assert_eq!(smooth, mesh);
    assert!(smooth.set_normals(&normals[1..]).unwrap_err().to_string().contains("5 entries of normals for 6"));
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

/// Joined meshes are the mesh of the joined inputs.
#[test]
fn meshes_are_joined() {
    let (weld, objects) = ([0, 1, 2, 2, 3, 0], [8, 8, 8, 8, 8, 8]);
    let first = MeshInput { weld: Some(&weld), objects: Some(&objects), ..input(6, &[[0, 1, 2], [3, 4, 5]]) };
    let others = [8, 8, 8, 8, 3, 3, 3];
    let mut triangles = TETRAHEDRON.to_vec();
    triangles.push([4, 5, 6]);
    let second = MeshInput { objects: Some(&others), ..input(7, &triangles) };
    let all: Vec<[u32; 3]> =
        first.triangles.iter().copied().chain(triangles.iter().map(|t| t.map(|v| v + 6))).collect();
    let whole = MeshInput {
        vertices: 13,
        triangles: &all,
        objects: Some(&[0, 0, 0, 0, 0, 0, 2, 2, 2, 2, 1, 1, 1]),
        weld: Some(&[0, 1, 2, 2, 3, 0, 6, 7, 8, 9, 10, 11, 12]),
        normals: None,
        rest: None,
    };
    let [first, second] = [first, second].map(|input| Mesh::new(&input).unwrap());
    let joined = Mesh::join(&[&first, &second]).unwrap();
    assert_eq!(joined, Mesh::new(&whole).unwrap());
    assert!(Mesh::join(&[]).is_err());
    let (rows, points) = joined.source_rows(&[6, 7]).unwrap();
    assert_eq!((&rows[..], &points[..]), (&[0, 1, 2, 4, 0, 1, 2, 3, 4, 5, 6][..], &[4, 7][..]));
    assert!(joined.source_rows(&[6, 6]).unwrap_err().to_string().contains("12 vertices in sources; it has 13"));
}

#[test]
fn objects_are_separate() {
    let mut triangles = TETRAHEDRON.to_vec();
    triangles.push([4, 5, 6]);
    let objects = [8, 8, 8, 8, 3, 3, 3];
    let mesh = Mesh::new(&MeshInput { objects: Some(&objects), ..input(7, &triangles) }).unwrap();
    assert_eq!(mesh.objects(), [3, 8]);
    assert_eq!([0, 1, 2, 3, 4].map(|triangle| mesh.shells().of(triangle)), [Some(0), Some(0), Some(0), Some(0), None]);
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

#[test]
fn what_an_object_has_of_one_material_is_a_surface() {
    let mut triangles = TETRAHEDRON.to_vec();
    triangles.extend([[4, 5, 6], [4, 6, 7]]);
    let objects = [8, 8, 8, 8, 3, 3, 3, 3];
    let mut mesh = Mesh::new(&MeshInput { objects: Some(&objects), ..input(8, &triangles) }).unwrap();
    assert_eq!((mesh.surfaces(), mesh.triangle_surfaces()), (2, &[1, 1, 1, 1, 0, 0][..]));
    // A triangle is of its first vertex' material; numbers of one object are none of another's.
    let first: Vec<u32> = mesh.corners().iter().map(|corners| corners[0]).collect();
    let mut materials = [5, 5, 5, 5, 5, 5, 5, 5];
    materials[first[0] as usize] = 1;
    mesh.set_materials(&materials).unwrap();
    let expected: Vec<u32> = first.iter().map(|v| if *v >= 4 { 0 } else { 1 + u32::from(*v != first[0]) }).collect();
    assert_eq!((mesh.surfaces(), mesh.triangle_surfaces()), (3, &expected[..]));
    assert!(mesh.set_materials(&[1; 7]).unwrap_err().to_string().contains("7 entries of materials for 8 vertices"));
    let joined = Mesh::join(&[&mesh, &mesh]).unwrap();
    let twice: Vec<u32> = [0, 3].iter().flat_map(|by| expected.iter().map(move |surface| surface + by)).collect();
    assert_eq!((joined.surfaces(), joined.triangle_surfaces()), (6, &twice[..]));
}
