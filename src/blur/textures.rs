//! Textures of frames that are drawn, as the device looks them up.

use crate::blur::mesh::Mesh;
use crate::shaders::blur::constants::{
    CLAMPED, MIRRORED, NEAREST, NONE, REPEATED, TEXEL_BITS, TEXEL_MASK, TEXTURE_ROWS, TRIANGLE_ROWS,
};
use crate::srgb::linear_from_srgb;

/// Texels of all textures and their smaller levels that a device is given; of larger ones the largest levels are left out.
pub const MOST_TEXELS: u64 = 1 << 24;

/// How a texture goes on beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// Again and again.
    #[default]
    Repeat,
    /// Again and again, every other time turned over.
    Mirror,
    /// As it is at the edge.
    Clamp,
}

/// A texture of base colours.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Texture {
    /// Texels across and down, at least 1 each.
    pub size: [u32; 2],
    /// Red, green and blue of each texel, row by row from the top, as sRGB codes them in 8 bits.
    pub texels: Vec<[u8; 3]>,
    /// How it goes on across and down.
    pub wrap: [Wrap; 2],
    /// Whether texels are squares where it is magnified.
    pub is_nearest: bool,
}

/// A level of a texture: each is half as large as the one before, the last is one texel.
#[derive(Clone, Debug, PartialEq)]
struct Level {
    size: [u32; 2],
    /// Linear RGB, 0 to 1.
    texels: Vec<[f32; 3]>,
}

impl Level {
    fn of(texture: &Texture, linear: &[f32; 256]) -> Level {
        let texels = texture.texels.iter().map(|texel| texel.map(|c| linear[usize::from(c)])).collect();
        Level { size: texture.size, texels }
    }

    /// The next smaller one: means of two by two texels; of an odd number the last row or column is left out.
    fn halved(&self) -> Option<Level> {
        if self.size == [1, 1] {
            return None;
        }
        let size = self.size.map(|side| (side / 2).max(1));
        let [width, height] = self.size.map(|side| side as usize);
        let texel = |x: usize, y: usize| self.texels[y.min(height - 1) * width + x.min(width - 1)];
        let mean = |x: usize, y: usize| {
            let four =
                [texel(2 * x, 2 * y), texel(2 * x + 1, 2 * y), texel(2 * x, 2 * y + 1), texel(2 * x + 1, 2 * y + 1)];
            [0, 1, 2].map(|c| 0.25 * four.iter().map(|texel| texel[c]).sum::<f32>())
        };
        let texels = (0..size[1] as usize).flat_map(|y| (0..size[0] as usize).map(move |x| (x, y)));
        Some(Level { size, texels: texels.map(|(x, y)| mean(x, y)).collect() })
    }
}

/// Words of all levels of a texture of such a size.
fn words([width, height]: [u32; 2]) -> u64 {
    let own = u64::from(width) * u64::from(height);
    if own == 1 { 1 } else { own + words([(width / 2).max(1), (height / 2).max(1)]) }
}

/// The rows of [`crate::blur::TopologyInput::textures`] of a mesh, if it has any textures. `of`: the number of each vertex's texture
/// in `textures`, or none; `coordinates`: where each vertex is in it, from (0, 0), the upper left, to (1, 1).
pub fn texture_rows(mesh: &Mesh, textures: &[Texture], of: &[Option<u32>], coordinates: &[[f32; 2]]) -> Vec<[u32; 4]> {
    if textures.is_empty() {
        return Vec::new();
    }
    let triangle = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| coordinates[corner as usize].map(f32::to_bits));
        let number = of[corners[0] as usize].unwrap_or(NONE);
        [[a[0], a[1], b[0], b[1]], [c[0], c[1], number, 0]]
    };
    let mut rows: Vec<[u32; 4]> = mesh.corners().iter().flat_map(triangle).collect();
    debug_assert_eq!(rows.len(), TRIANGLE_ROWS as usize * mesh.corners().len());
    let left_out = left_out(textures);
    let linear = std::array::from_fn(|coded| linear_from_srgb(coded as f64 / 255.0) as f32);
    let table = rows.len();
    rows.resize(table + TEXTURE_ROWS as usize * textures.len(), [0; 4]);
    // Rows follow three of base colours a triangle.
    let before = 3 * mesh.corners().len();
    let begin_of_texels = 4 * (before + rows.len());
    let mut texels: Vec<u32> = Vec::new();
    for (number, texture) in textures.iter().enumerate() {
        let mut level = Level::of(texture, &linear);
        for _ in 0..left_out {
            level = level.halved().unwrap_or(level);
        }
        let ([width, height], begin) = (level.size, begin_of_texels + texels.len());
        let (mut levels, mut next) = (0, Some(level));
        while let Some(level) = next {
            texels.extend(level.texels.iter().map(packed));
            levels += 1;
            next = level.halved();
        }
        let row = table + TEXTURE_ROWS as usize * number;
        let wrap = texture.wrap.map(|wrap| match wrap {
            Wrap::Repeat => REPEATED,
            Wrap::Mirror => MIRRORED,
            Wrap::Clamp => CLAMPED,
        });
        rows[row] = [begin as u32, width, height, levels];
        rows[row + 1] = [wrap[0], wrap[1], if texture.is_nearest { NEAREST } else { 0 }, 0];
    }
    texels.resize(texels.len().next_multiple_of(4), 0);
    rows.extend_from_slice(texels.as_chunks().0);
    rows
}

/// How many of the largest levels are left out of each, so that there is room for all.
fn left_out(textures: &[Texture]) -> u32 {
    let all = |halvings: u32| -> u64 {
        textures.iter().map(|texture| words(texture.size.map(|side| (side >> halvings.min(31)).max(1)))).sum()
    };
    (0..32).find(|halvings| all(*halvings) <= MOST_TEXELS).unwrap_or(31)
}

/// The square roots of the channels, so that dark ones are as fine as sRGB has them.
fn packed(texel: &[f32; 3]) -> u32 {
    let [r, g, b] = texel.map(|c| (c.clamp(0.0, 1.0).sqrt() * TEXEL_MASK as f32 + 0.5) as u32);
    r | g << TEXEL_BITS | b << (2 * TEXEL_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blur::mesh::MeshInput;

    fn mesh() -> Mesh {
        let triangles = [[0, 1, 2], [2, 1, 3]];
        let input =
            MeshInput { vertices: 4, triangles: &triangles, objects: None, weld: None, normals: None, rest: None };
        Mesh::new(&input).expect("a mesh")
    }

    #[test]
    fn rows_have_coordinates_tables_and_texels_of_all_levels() {
        let texture =
            Texture { size: [4, 2], texels: vec![[255, 0, 0]; 8], wrap: [Wrap::Mirror, Wrap::Clamp], is_nearest: true };
        let coordinates = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        assert!(texture_rows(&mesh(), &[], &[None; 4], &coordinates).is_empty());
        let rows = texture_rows(&mesh(), &[texture], &[Some(0), Some(0), None, None], &coordinates);
        let one = 1.0_f32.to_bits();
        assert_eq!(rows[..4], [[0, 0, one, 0], [0, one, 0, 0], [0, one, one, 0], [one, one, NONE, 0]]);
        // Six rows of base colours and six of these before the texels: 4 x 2, 2 x 1, 1 x 1.
        assert_eq!(rows[4..6], [[4 * 12, 4, 2, 3], [MIRRORED, CLAMPED, NEAREST, 0]]);
        let texels = rows[6..].as_flattened();
        assert_eq!(texels.len(), 12);
        assert!(texels[..11].iter().all(|texel| *texel == TEXEL_MASK) && texels[11] == 0);
    }

    #[test]
    fn levels_are_means_of_light() {
        let texels = vec![[255, 0, 0], [0, 0, 0], [255, 255, 0], [0, 0, 255], [9, 9, 9], [9, 9, 9]];
        let linear = std::array::from_fn(|coded| linear_from_srgb(coded as f64 / 255.0) as f32);
        let level = Level::of(&Texture { size: [2, 3], texels, ..Texture::default() }, &linear);
        let half = level.halved().expect("a smaller one");
        assert_eq!((half.size, &half.texels[..]), ([1, 1], &[[0.5, 0.25, 0.25]][..]));
        assert_eq!(half.halved(), None);
        assert_eq!(words([2, 3]), 7);
    }

    #[test]
    fn what_has_no_room_loses_its_largest_levels() {
        let large = |side: u32| Texture { size: [side, side], ..Texture::default() };
        assert_eq!(left_out(&[large(2048), large(2048)]), 0);
        assert_eq!(left_out(&[large(4096)]), 1);
        assert_eq!(left_out(&[large(8192), large(8192)]), 2);
    }

    #[test]
    fn texels_are_as_fine_as_srgb_codes_them() {
        for coded in 0..=255_u32 {
            let light = linear_from_srgb(f64::from(coded) / 255.0);
            let stored = f64::from(packed(&[light as f32; 3]) & TEXEL_MASK) / f64::from(TEXEL_MASK);
            // Half of the way to the next code, at most.
            let next = linear_from_srgb(f64::from(coded.max(1)) / 255.0)
                - linear_from_srgb(f64::from(coded.max(1) - 1) / 255.0);
            assert!((stored * stored - light).abs() < 0.5 * next, "{coded}");
        }
    }
}
