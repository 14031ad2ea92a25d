//! Textures of drawn frames, in f64.

use glam::DVec3;

use crate::blur::textures::{Texture, Wrap};

/// The levels of a texture, each as linear RGB of its texels.
#[derive(Clone, Debug)]
pub struct Levels {
    /// Size and texels, the largest first.
    levels: Vec<([usize; 2], Vec<DVec3>)>,
    wrap: [Wrap; 2],
    is_nearest: bool,
}

impl Levels {
    /// Those of a texture: each is the mean of two by two texels of the one before.
    pub fn new(texture: &Texture) -> Levels {
        let linear = |coded: u8| {
            let coded = f64::from(coded) / 255.0;
            if coded <= 0.04045 { coded / 12.92 } else { ((coded + 0.055) / 1.055).powf(2.4) }
        };
        let texels: Vec<DVec3> = texture.texels.iter().map(|texel| DVec3::from_array(texel.map(linear))).collect();
        let mut levels = vec![(texture.size.map(|side| side as usize), texels)];
        while let Some(([width, height], texels)) = levels.last().filter(|(size, _)| *size != [1, 1]) {
            let size = [(width / 2).max(1), (height / 2).max(1)];
            let at = |x: usize, y: usize| texels[y.min(height - 1) * width + x.min(width - 1)];
            let mut half: Vec<DVec3> = Vec::new();
            for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
                let [x, y] = [2 * x, 2 * y];
                half.push((at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) / 4.0);
            }
            levels.push((size, half));
        }
        Levels { levels, wrap: texture.wrap, is_nearest: texture.is_nearest }
    }

    /// Texels of the largest level, across and down.
    pub fn size(&self) -> [f64; 2] {
        self.levels[0].0.map(|side| side as f64)
    }

    /// Linear RGB at a place where so many texels of the largest level are on a sample: between two levels, and in each of them
    /// between four texels; and whether rounding of single floats may decide which texel it is.
    pub fn at(&self, place: [f64; 2], texels: f64) -> (DVec3, bool) {
        let last = self.levels.len() - 1;
        let level = (0.5 * texels.max(1e-12).log2()).clamp(0.0, last as f64);
        let (upper, share) = (level.floor() as usize, level.fract());
        if self.is_nearest && level == 0.0 {
            let (size, _) = &self.levels[0];
            let texel = [0, 1].map(|axis| place[axis] * size[axis] as f64);
            let is_unsure = texel.iter().any(|x| (x - x.round()).abs() < 1e-3);
            return (self.texel(0, texel.map(|x| x.floor() as i64)), is_unsure || texels > 0.98);
        }
        let own = self.smooth(upper, place);
        let next = self.smooth((upper + 1).min(last), place);
        (own * (1.0 - share) + next * share, self.is_nearest && texels < 1.02)
    }

    fn smooth(&self, level: usize, place: [f64; 2]) -> DVec3 {
        let (size, _) = &self.levels[level];
        let at = [0, 1].map(|axis| place[axis] * size[axis] as f64 - 0.5);
        let ([x, y], [u, v]) = (at.map(|x| x.floor() as i64), at.map(|x| x - x.floor()));
        let row = |y: i64| self.texel(level, [x, y]) * (1.0 - u) + self.texel(level, [x + 1, y]) * u;
        row(y) * (1.0 - v) + row(y + 1) * v
    }

    fn texel(&self, level: usize, at: [i64; 2]) -> DVec3 {
        let (size, texels) = &self.levels[level];
        let place = [0, 1].map(|axis| {
            let count = size[axis] as i64;
            let within = match self.wrap[axis] {
                Wrap::Clamp => at[axis].clamp(0, count - 1),
                Wrap::Repeat => at[axis].rem_euclid(count),
                Wrap::Mirror => {
                    let within = at[axis].rem_euclid(2 * count);
                    within.min(2 * count - 1 - within)
                }
            };
            within as usize
        });
        texels[place[1] * size[0] + place[0]]
    }
}
