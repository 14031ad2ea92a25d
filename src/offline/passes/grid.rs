//! A mesh of pixels: cells of several where a surface goes on, single ones at its borders, without cracks.
//!
//! Cells are squares, sides of half of which are those of smaller ones, down to single pixels. Larger ones lie where all of their pixels are joined to each other. A cell
//! on whose sides smaller ones have corners is a fan around its centre through all of them; so triangles meet side by side
//! everywhere. Where surfaces are apart, a corner of pixels is as many points as there are surfaces around it.

use super::sheets::{Sheets, bounds};

/// No point.
const NONE: u32 = u32::MAX;

/// A corner of pixels, as a surface has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Point {
    /// Where it is, in pixels to the right and down.
    pub(super) corner: [u32; 2],
    /// Which of the four pixels around are of the surface: bit 0 above to the left, 1 above to the right, 2 and 3 below.
    around: u8,
}

/// The mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) points: Vec<Point>,
    /// Clockwise on screen.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// What a grid is made of.
#[derive(Clone, Copy)]
struct Pixels<'a> {
    sheets: &'a Sheets,
    mask: &'a [bool],
    /// First column and row that are looked at, and the ends, multiples of `cell` but for the picture's own border.
    low: [usize; 2],
    high: [usize; 2],
}

/// A square of pixels.
#[derive(Clone, Copy, Debug)]
struct Cell {
    at: [usize; 2],
    side: usize,
}

/// Points by the corner and the pixel around it.
struct Numbers<'a> {
    pixels: Pixels<'a>,
    numbers: Vec<[u32; 4]>,
    points: Vec<Point>,
}

impl Grid {
    /// Of the pixels of a mask; `cell` is the side of the largest cells, a power of two.
    pub(super) fn new(sheets: &Sheets, mask: &[bool], cell: usize) -> Grid {
        let Some(pixels) = Pixels::around(sheets, mask, cell) else { return Grid::default() };
        let mut cells = Vec::new();
        let [low, high] = [pixels.low, pixels.high];
        for y in (low[1]..high[1]).step_by(cell) {
            for x in (low[0]..high[0]).step_by(cell) {
                pixels.divide(Cell { at: [x, y], side: cell }, &mut cells);
            }
        }
        let columns = high[0] - low[0] + 1;
        let numbers = vec![[NONE; 4]; columns * (high[1] - low[1] + 1)];
        let mut numbers = Numbers { pixels, numbers, points: Vec::new() };
        for cell in &cells {
            cell.corners().into_iter().for_each(|(corner, pixel)| _ = numbers.number(corner, pixel));
        }
        let mut triangles = Vec::new();
        cells.iter().for_each(|cell| numbers.add(*cell, &mut triangles));
        Grid { points: numbers.points, triangles }
    }

    /// What a field that pixels have at their centres is at the points: as it is there where it is linear.
    pub(super) fn values<const N: usize>(&self, sheets: &Sheets, field: impl Fn(usize) -> [f32; N]) -> Vec<[f32; N]> {
        let value = |point: &Point| {
            let mut sum = [0.0; N];
            for (pixel, [right, down]) in point.pixels(sheets.size[0]) {
                let [left_of, right_of, above, below] = sheets.beside(pixel);
                let own = field(pixel);
                let slope = |before: Option<usize>, after: Option<usize>| -> [f32; N] {
                    let (from, to) = (before.map_or(own, &field), after.map_or(own, &field));
                    let steps = (usize::from(before.is_some()) + usize::from(after.is_some())).max(1) as f32;
                    std::array::from_fn(|c| (to[c] - from[c]) / steps)
                };
                let (across, along) = (slope(left_of, right_of), slope(above, below));
                (0..N).for_each(|c| sum[c] += own[c] + 0.5 * (right * across[c] + down * along[c]));
            }
            sum.map(|sum| sum / point.around.count_ones() as f32)
        };
        self.points.iter().map(value).collect()
    }

    /// A pixel of each point's surface.
    pub(super) fn pixels<'a>(&'a self, sheets: &'a Sheets) -> impl Iterator<Item = usize> + 'a {
        self.points.iter().filter_map(|point| Some(point.pixels(sheets.size[0]).next()?.0))
    }
}

impl Point {
    /// Pixels around it that are of its surface, and where it is as seen from the centre of each: 1 to the right or down, -1.
    fn pixels(&self, width: usize) -> impl Iterator<Item = (usize, [f32; 2])> {
        let [x, y] = self.corner.map(|c| c as usize);
        let around = self.around;
        (0..4_usize).filter(move |place| around >> place & 1 != 0).map(move |place| {
            let (right, below) = (place & 1, place >> 1);
            ((y + below - 1) * width + x + right - 1, [1.0 - 2.0 * right as f32, 1.0 - 2.0 * below as f32])
        })
    }
}

impl<'a> Pixels<'a> {
    /// Those of a mask; none if there are none.
    fn around(sheets: &'a Sheets, mask: &'a [bool], cell: usize) -> Option<Pixels<'a>> {
        let [low, high] = bounds(mask, sheets.size[0])?;
        let low = low.map(|c| c / cell * cell);
        Some(Pixels {
            sheets,
            mask,
            low,
            high: [0, 1].map(|axis| high[axis].next_multiple_of(cell).min(sheets.size[axis])),
        })
    }

    fn pixel(&self, [x, y]: [usize; 2]) -> Option<usize> {
        let [width, height] = self.sheets.size;
        let pixel = y * width + x;
        (x < width && y < height && self.mask[pixel]).then_some(pixel)
    }

    fn is_right(&self, pixel: usize) -> bool {
        self.sheets.right(pixel) && self.mask[pixel] && self.mask[pixel + 1]
    }

    fn is_down(&self, pixel: usize) -> bool {
        self.sheets.down(pixel) && self.mask[pixel] && self.mask[pixel + self.sheets.size[0]]
    }

    /// Whether all pixels of a cell are there and joined.
    fn is_whole(&self, Cell { at: [x, y], side }: Cell) -> bool {
        (y..y + side).all(|row| {
            (x..x + side).all(|column| {
                self.pixel([column, row]).is_some_and(|pixel| {
                    (column + 1 == x + side || self.is_right(pixel)) && (row + 1 == y + side || self.is_down(pixel))
                })
            })
        })
    }

    /// Adds the largest whole cells within one, row by row.
    fn divide(&self, cell: Cell, cells: &mut Vec<Cell>) {
        if self.is_whole(cell) {
            cells.push(cell);
        } else if cell.side > 1 {
            let half = cell.side / 2;
            let [x, y] = cell.at;
            for at in [[x, y], [x + half, y], [x, y + half], [x + half, y + half]] {
                self.divide(Cell { at, side: half }, cells);
            }
        }
    }

    /// Pixels around a corner that are joined around it to one of them, as [`Point::around`] has them.
    fn joined(&self, [x, y]: [usize; 2], to: usize) -> u8 {
        let at = |right: usize, below: usize| {
            let place = [(x + right).checked_sub(1)?, (y + below).checked_sub(1)?];
            self.pixel(place)
        };
        let pixels = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        let is_right =
            |place: usize| pixels[place].is_some_and(|pixel| pixels[place + 1].is_some() && self.is_right(pixel));
        let is_down =
            |place: usize| pixels[place].is_some_and(|pixel| pixels[place + 2].is_some() && self.is_down(pixel));
        let links = [(0, 1, is_right(0)), (2, 3, is_right(2)), (0, 2, is_down(0)), (1, 3, is_down(1))];
        let mut joined = 1_u8 << to;
        // Three links are the longest way around.
        for _ in 0..3 {
            for (a, b, _) in links.iter().filter(|(.., is_there)| *is_there) {
                if joined >> a & 1 != 0 || joined >> b & 1 != 0 {
                    joined |= 1 << a | 1 << b;
                }
            }
        }
        joined
    }
}

impl Cell {
    /// Its corners, clockwise from the upper left one, each with the place that the cell has around it.
    fn corners(&self) -> [([usize; 2], usize); 4] {
        let ([x, y], side) = (self.at, self.side);
        [([x, y], 3), ([x + side, y], 2), ([x + side, y + side], 0), ([x, y + side], 1)]
    }
}

impl Numbers<'_> {
    fn place(&self, [x, y]: [usize; 2]) -> usize {
        let [low, high] = [self.pixels.low, self.pixels.high];
        (y - low[1]) * (high[0] - low[0] + 1) + x - low[0]
    }

    /// The point of a corner that the pixel at this place around it has; a new one if there is none yet.
    fn number(&mut self, corner: [usize; 2], pixel: usize) -> u32 {
        let place = self.place(corner);
        if self.numbers[place][pixel] == NONE {
            let around = self.pixels.joined(corner, pixel);
            let number = self.points.len() as u32;
            self.points.push(Point { corner: corner.map(|c| c as u32), around });
            (0..4).filter(|other| around >> other & 1 != 0).for_each(|other| self.numbers[place][other] = number);
        }
        self.numbers[place][pixel]
    }

    /// The triangles of a cell, once all corners of all cells have a point.
    fn add(&mut self, cell: Cell, triangles: &mut Vec<[u32; 3]>) {
        let mut around = Vec::with_capacity(4 * cell.side);
        let corners = cell.corners();
        for (side, (corner, pixel)) in corners.into_iter().enumerate() {
            let to = corners[(side + 1) % 4].0;
            around.push(self.number(corner, pixel));
            // Corners of smaller cells beyond: of the pixels on both sides of them the cell has one at the same place.
            for step in 1..cell.side {
                let between = [0, 1].map(|c| (corner[c] * (cell.side - step) + to[c] * step) / cell.side);
                let number = self.numbers[self.place(between)][pixel];
                around.extend((number != NONE).then_some(number));
            }
        }
        if let [a, b, c, d] = around[..] {
            triangles.extend([[a, b, c], [a, c, d]]);
            return;
        }
        let half = cell.side / 2;
        let centre = self.number([cell.at[0] + half, cell.at[1] + half], 3);
        let next = around.iter().cycle().skip(1);
        triangles.extend(around.iter().zip(next).map(|(a, b)| [centre, *a, *b]));
    }
}
