//! Births: where a particle appears. f32 in a fixed order of operations, so that the GPU gives the same bits.

use super::grid::Grid;
use crate::random::{hash, unit};
use crate::shaders::smoke::constants::{BIRTH_PLACE, BIRTH_VOXEL};
use crate::smoke::settings::Emitter;

/// The voxels that particles are born in: occupied, and overlapping the emitter if there is one; x fastest.
pub fn candidates(grid: &Grid, threshold: f32, emitter: Option<Emitter>) -> Vec<[u32; 3]> {
    let [nx, ny, nz] = grid.dimensions;
    let mut voxels = Vec::new();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let overlaps = emitter.is_none_or(|e| (0..3).all(|a| overlaps(grid, e, a, [x, y, z][a])));
                if overlaps && grid.occupied(x.into(), y.into(), z.into(), threshold) {
                    voxels.push([x, y, z]);
                }
            }
        }
    }
    voxels
}

/// Position in metres of the birth number `generation` in slot `slot`: a uniform voxel of `candidates`, a uniform
/// place in it (in its overlap with the emitter). None where there are no candidates.
pub fn birth(
    grid: &Grid,
    emitter: Option<Emitter>,
    candidates: &[[u32; 3]],
    seed: u32,
    slot: u32,
    generation: u32,
) -> Option<[f32; 3]> {
    let draw = u64::from(hash(seed, slot, generation, BIRTH_VOXEL));
    let voxel = candidates.get(((draw * candidates.len() as u64) >> 32) as usize)?;
    Some(std::array::from_fn(|axis| {
        let [mut low, mut high] = faces(grid, axis, voxel[axis]);
        if let Some(emitter) = emitter {
            low = low.max(emitter.min[axis]);
            high = high.min(emitter.max[axis]);
        }
        low + unit(hash(seed, slot, generation, BIRTH_PLACE + axis as u32)) * (high - low)
    }))
}

/// Lower and upper face of voxels number `q` along `axis`.
fn faces(grid: &Grid, axis: usize, q: u32) -> [f32; 2] {
    [q, q + 1].map(|q| grid.origin[axis] + q as f32 * grid.voxel_size[axis])
}

/// Does the voxel share more than a face with the emitter? An emitter without extent lies in the voxel that holds it.
fn overlaps(grid: &Grid, emitter: Emitter, axis: usize, q: u32) -> bool {
    let [low, high] = faces(grid, axis, q);
    emitter.min[axis] < high && (low < emitter.max[axis] || low <= emitter.min[axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full(density: &[f32]) -> Grid<'_> {
        Grid { dimensions: [4, 2, 1], voxel_size: [0.5; 3], origin: [-1.0, 0.0, 2.0], density, velocity: None }
    }

    #[test]
    fn candidates_are_occupied_and_share_a_volume_with_the_emitter() {
        let density = [1.0, 1.0, 0.0, 1.0, 1.0, f32::NAN, 1.0, 1.0];
        let grid = full(&density);
        assert_eq!(candidates(&grid, 0.5, None).len(), 6);
        // From face to face of voxel 3: its neighbours only touch.
        let emitter = Emitter { min: [0.5, 0.0, 0.0], max: [1.0, 0.5, 9.0] };
        assert_eq!(candidates(&grid, 0.5, Some(emitter)), [[3, 0, 0]]);
        // A floor, exactly on the volume's lower face, and a point on an inner face.
        let emitter = Emitter { min: [-9.0, 0.0, 0.0], max: [9.0, 0.0, 9.0] };
        assert_eq!(candidates(&grid, 0.5, Some(emitter)), [[0, 0, 0], [1, 0, 0], [3, 0, 0]]);
        let emitter = Emitter { min: [0.5, 0.25, 2.25], max: [0.5, 0.25, 2.25] };
        assert_eq!(candidates(&grid, 0.5, Some(emitter)), [[3, 0, 0]]);
        assert!(candidates(&grid, 5.0, None).is_empty());
    }

    #[test]
    fn births_lie_in_their_voxel_and_in_the_emitter_and_are_uniform() {
        let grid = full(&[1.0; 8]);
        let emitter = Some(Emitter { min: [-0.75, 0.0, 2.0], max: [0.25, 1.0, 2.25] });
        let voxels = candidates(&grid, 0.5, emitter);
        assert_eq!(voxels.len(), 6);
        let mut per_voxel = [0_u32; 4];
        for slot in 0..6000 {
            let p = birth(&grid, emitter, &voxels, 9, slot, 4).unwrap();
            assert!((-0.75..=0.25).contains(&p[0]) && (0.0..=1.0).contains(&p[1]) && (2.0..=2.25).contains(&p[2]));
            per_voxel[((p[0] + 1.0) / 0.5) as usize] += 1;
        }
        // Voxels are drawn, not volumes: 2000 each, deviation 37, five of them.
        assert!(per_voxel[..3].iter().all(|n| (1815..2185).contains(n)) && per_voxel[3] == 0, "{per_voxel:?}");
    }

    #[test]
    fn a_birth_draws_dimension_0_for_its_voxel_and_1_to_3_for_its_place() {
        let grid = full(&[1.0; 8]);
        let voxels = candidates(&grid, 0.5, None);
        for slot in 0..100 {
            // Eight candidates: the top three bits choose; x in the lowest two, y in the next.
            let voxel = hash(5, slot, 6, 0) >> 29;
            // Sides and origin are powers of two, so scaling is exact and only the last sum rounds.
            let place = |dimension| 0.5 * f64::from(unit(hash(5, slot, 6, dimension)));
            let low = [-1.0 + 0.5 * f64::from(voxel % 4), 0.5 * f64::from(voxel / 4), 2.0];
            let expected = [0, 1, 2].map(|axis| (low[axis] + place(1 + axis as u32)) as f32);
            assert_eq!(birth(&grid, None, &voxels, 5, slot, 6), Some(expected));
        }
    }

    #[test]
    fn a_birth_is_a_function_of_seed_slot_and_generation_alone() {
        let grid = full(&[1.0; 8]);
        let voxels = candidates(&grid, 0.5, None);
        let at = |seed, slot, generation| birth(&grid, None, &voxels, seed, slot, generation);
        assert_eq!(at(1, 2, 3), at(1, 2, 3));
        assert!(at(1, 2, 3) != at(0, 2, 3) && at(1, 2, 3) != at(1, 0, 3) && at(1, 2, 3) != at(1, 2, 0));
        assert_eq!(birth(&grid, None, &[], 1, 2, 3), None);
    }
}
