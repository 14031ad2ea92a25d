//! Which pixels of a frame are of one surface, and which of these are blurred.

use std::collections::BTreeMap;

use crate::io::passes::PassFrame;

/// The least jump of depth between two surfaces, as a share of it, beyond what the slope beside it makes.
pub(super) const DEPTH_JUMP: f32 = 0.02;
/// The same of vectors, in pixels: what is torn further in a frame was never one.
const MOTION_JUMP: f32 = 2.0;
/// The least move in a frame, in pixels: what the blur takes as motion.
const MOVES: f32 = 0.5;
/// A surface moves if one in so many of its pixels does, and at least [`LEAST`].
const FEW: usize = 64;
const LEAST: usize = 4;

/// The pixel is joined to the one to its right.
const RIGHT: u8 = 1;
/// The pixel is joined to the one below.
const DOWN: u8 = 2;
/// Something is seen.
const SEEN: u8 = 4;

/// Logarithm of depth: differences are shares of it, wherever it is.
pub(super) fn share_of(depth: f32) -> f32 {
    depth.ln()
}

/// First column and row of a part of a picture, and the ends.
pub(super) type Bounds = [[usize; 2]; 2];

/// The least part that has all of a mask, in a picture so wide; none if there is nothing of it.
pub(super) fn bounds(mask: &[bool], width: usize) -> Option<Bounds> {
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    for (y, row) in mask.chunks_exact(width.max(1)).enumerate() {
        let Some(first) = row.iter().position(|is_in| *is_in) else { continue };
        let last = row.iter().rposition(|is_in| *is_in).unwrap_or(first);
        low = [low[0].min(first), low[1].min(y)];
        high = [high[0].max(last + 1), high[1].max(y + 1)];
    }
    (high[0] > 0).then_some([low, high])
}

/// Pixels of a frame, and which of their neighbours are of the same surface.
///
/// Two pixels beside each other are, if they are of one object and depth does not jump between them: differs by more than a limit
/// from what it does to either side of them. So a surface that is seen at a slant stays one. The same of motion
/// ([`Sheets::tear`]).
#[derive(Clone, Debug)]
pub(super) struct Sheets {
    pub(super) size: [usize; 2],
    flags: Vec<u8>,
}

impl Sheets {
    /// Of a frame.
    pub(super) fn new(frame: &PassFrame) -> Sheets {
        Sheets::within(frame, [[0; 2], frame.size.map(|side| side as usize)])
    }

    /// Of a part of a frame, from its first column and row to the ends; beyond, nothing is seen.
    pub(super) fn within(frame: &PassFrame, [low, high]: Bounds) -> Sheets {
        let size = frame.size.map(|side| side as usize);
        let [width, height] = size;
        let mut inverse = vec![0.0; width * height];
        for row in low[1]..high[1] {
            let row = row * width + low[0]..row * width + high[0];
            inverse[row.clone()]
                .iter_mut()
                .zip(&frame.depth[row])
                .for_each(|(inverse, depth)| *inverse = depth.recip());
        }
        let look = Look { frame, inverse: &inverse };
        let mut flags = vec![0; width * height];
        for y in low[1]..high[1] {
            for x in low[0]..high[0] {
                let pixel = y * width + x;
                if inverse[pixel] == 0.0 {
                    continue;
                }
                flags[pixel] |= SEEN;
                if x + 1 < width && look.is_joined(pixel, 1, x > 0, x + 2 < width) {
                    flags[pixel] |= RIGHT;
                }
                if y + 1 < height && look.is_joined(pixel, width, y > 0, y + 2 < height) {
                    flags[pixel] |= DOWN;
                }
            }
        }
        Sheets { size, flags }
    }

    /// Parts pixels between which motion jumps.
    pub(super) fn tear(&mut self, vectors: &[[f32; 2]]) {
        let width = self.size[0];
        let joined = self.flags.clone();
        let is_joined = |pixel: usize, flag: u8| joined[pixel] & flag != 0;
        for (pixel, flags) in self.flags.iter_mut().enumerate().filter(|(_, flags)| **flags & (RIGHT | DOWN) != 0) {
            for (flag, step) in [(RIGHT, 1), (DOWN, width)] {
                let before = pixel.checked_sub(step).filter(|before| is_joined(*before, flag));
                let after = Some(pixel + step).filter(|after| is_joined(pixel, flag) && is_joined(*after, flag));
                if is_joined(pixel, flag) && !is_even(vectors, pixel, step, [before, after]) {
                    *flags &= !flag;
                }
            }
        }
    }

    /// Whether a pixel shows anything.
    pub(super) fn is_seen(&self, pixel: usize) -> bool {
        self.flags[pixel] & SEEN != 0
    }

    /// Whether a pixel is joined to the one to its right.
    pub(super) fn right(&self, pixel: usize) -> bool {
        self.flags[pixel] & RIGHT != 0
    }

    /// Whether a pixel is joined to the one below.
    pub(super) fn down(&self, pixel: usize) -> bool {
        self.flags[pixel] & DOWN != 0
    }

    /// The neighbours that a pixel is joined to: left, right, above, below.
    pub(super) fn beside(&self, pixel: usize) -> [Option<usize>; 4] {
        let [width, _] = self.size;
        let left = pixel.checked_sub(1).filter(|left| self.right(*left));
        let above = pixel.checked_sub(width).filter(|above| self.down(*above));
        [left, self.right(pixel).then_some(pixel + 1), above, self.down(pixel).then_some(pixel + width)]
    }

    /// Pixels of what moves: of surfaces that do, and of the others of an object most of which moves.
    pub(super) fn movers(&self, frame: &PassFrame) -> Vec<bool> {
        let pieces = self.pieces();
        let count = pieces.iter().copied().max().map_or(0, |last| last as usize + 1);
        let (mut sizes, mut moving, mut objects) = (vec![0_usize; count], vec![0_usize; count], vec![0; count]);
        for (pixel, piece) in pieces.iter().enumerate().filter(|(pixel, _)| self.is_seen(*pixel)) {
            let [x, y] = frame.previous[pixel];
            sizes[*piece as usize] += 1;
            moving[*piece as usize] += usize::from(x * x + y * y >= MOVES * MOVES);
            objects[*piece as usize] = frame.id[pixel];
        }
        let mut moves: Vec<bool> =
            sizes.iter().zip(&moving).map(|(size, moving)| *moving >= LEAST && moving * FEW >= *size).collect();
        let mut shares: BTreeMap<u32, [usize; 2]> = BTreeMap::new();
        for (piece, size) in sizes.iter().enumerate() {
            let share = shares.entry(objects[piece]).or_default();
            share[usize::from(moves[piece])] += size;
        }
        let of_object = |object: &u32| shares.get(object).is_some_and(|[still, moves]| moves > still);
        moves.iter_mut().zip(&objects).for_each(|(moves, object)| *moves |= of_object(object));
        pieces.iter().enumerate().map(|(pixel, piece)| self.is_seen(pixel) && moves[*piece as usize]).collect()
    }

    /// The surface that each pixel is of: pixels that are joined by way of others have the same number. What shows nothing has
    /// a number of its own or none.
    fn pieces(&self) -> Vec<u32> {
        let [width, _] = self.size;
        let mut parents: Vec<u32> = Vec::new();
        let mut of = vec![0_u32; self.flags.len()];
        for pixel in 0..of.len() {
            let left = pixel.checked_sub(1).filter(|left| self.right(*left)).map(|left| of[left]);
            let above = pixel.checked_sub(width).filter(|above| self.down(*above)).map(|above| of[above]);
            of[pixel] = match (left, above) {
                (Some(a), Some(b)) => join(&mut parents, a, b),
                (Some(one), None) | (None, Some(one)) => one,
                (None, None) if !self.is_seen(pixel) => 0,
                (None, None) => {
                    parents.push(parents.len() as u32);
                    parents.len() as u32 - 1
                }
            };
        }
        of.iter().map(|piece| if parents.is_empty() { 0 } else { root(&mut parents, *piece) }).collect()
    }
}

/// The first of the numbers that are joined to one.
fn root(parents: &mut [u32], mut piece: u32) -> u32 {
    while parents[piece as usize] != piece {
        parents[piece as usize] = parents[parents[piece as usize] as usize];
        piece = parents[piece as usize];
    }
    piece
}

fn join(parents: &mut [u32], a: u32, b: u32) -> u32 {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
    a.min(b)
}

/// Whether motion from a pixel to the one `step` after it does not differ by much from what it does from those that `beside` says
/// to the ones after them.
fn is_even(vectors: &[[f32; 2]], pixel: usize, step: usize, beside: [Option<usize>; 2]) -> bool {
    let slope = |from: usize| [0, 1].map(|c| vectors[from + step][c] - vectors[from][c]);
    let squared = |[x, y]: [f32; 2]| x * x + y * y;
    let own = slope(pixel);
    let off = |from: usize| squared([0, 1].map(|c| own[c] - slope(from)[c]));
    beside.into_iter().flatten().map(off).fold(squared(own), f32::min) <= MOTION_JUMP * MOTION_JUMP
}

/// What is compared of neighbours.
struct Look<'a> {
    frame: &'a PassFrame,
    /// 1 / depth, which is linear where a plane is seen in perspective; 0 where nothing is.
    inverse: &'a [f32],
}

impl Look<'_> {
    /// Whether a pixel and the one `step` after it are of one surface. Whether there is one before, and one after both.
    fn is_joined(&self, a: usize, step: usize, has_before: bool, has_after: bool) -> bool {
        let b = a + step;
        let is_one = |p: usize, q: usize| self.frame.id[p] == self.frame.id[q] && self.inverse[q] > 0.0;
        if !is_one(a, b) {
            return false;
        }
        let before = (has_before && is_one(a, a - step)).then(|| [a - step, a]);
        let after = (has_after && is_one(b, b + step)).then(|| [b, b + step]);
        let slope = |[p, q]: [usize; 2]| self.inverse[q] - self.inverse[p];
        let own = slope([a, b]);
        let beside = [before, after].into_iter().flatten();
        let off = beside.map(|pair| (own - slope(pair)).abs()).fold(own.abs(), f32::min);
        off <= DEPTH_JUMP * self.inverse[a].max(self.inverse[b])
    }
}
