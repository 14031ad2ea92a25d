//! Whether triangles meet edge to edge.

/// Edges that are not passed as often in one direction as in the other, each by its ends: the border of the surface.
/// Vertices are compared by what `Key` holds, not by number.
pub fn border<Key: Ord + Clone>(triangles: &[[Key; 3]]) -> Vec<[Key; 2]> {
    let sides = triangles.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).filter(|[a, b]| a != b);
    let mut edges: Vec<([&Key; 2], i64)> = sides.map(|[a, b]| if a < b { ([a, b], 1) } else { ([b, a], -1) }).collect();
    edges.sort_unstable();
    let runs = edges.chunk_by(|a, b| a.0 == b.0);
    let open = runs.filter(|run| run.iter().map(|(_, direction)| direction).sum::<i64>() != 0);
    open.map(|run| run[0].0.map(Key::clone)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_has_no_border_and_a_t_junction_is_one() {
        let mut triangles = vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        assert_eq!(border(&triangles), Vec::<[i32; 2]>::new());
        // Vertex 4 divides the edge from 0 to 1 in one of its triangles only.
        triangles.splice(0..1, [[0, 4, 2], [4, 1, 2]]);
        assert_eq!(border(&triangles), [[0, 1], [0, 4], [1, 4]]);
        triangles.splice(2..3, [[0, 3, 4], [4, 3, 1]]);
        assert_eq!(border(&triangles), Vec::<[i32; 2]>::new());
    }
}
