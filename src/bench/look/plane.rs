//! Pictures of one value a pixel, and what all measures do with them: neighbourhoods, connected pieces, a Gaussian.

/// One value a pixel, rows from the top. Pixel (0, 0) is top left, its centre (0.5, 0.5).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plane<T> {
    /// Width in pixels.
    pub(super) width: usize,
    /// Width x height values.
    pub(super) values: Vec<T>,
}

impl<T> Plane<T> {
    /// A plane of `width` columns.
    pub(super) fn new(width: usize, values: Vec<T>) -> Plane<T> {
        Plane { width, values }
    }

    /// Height in pixels.
    pub(super) fn height(&self) -> usize {
        self.values.len() / self.width.max(1)
    }

    /// Place of a pixel in `values`; none outside of the picture.
    pub(super) fn index(&self, [x, y]: [i64; 2]) -> Option<usize> {
        let inside = (0..self.width as i64).contains(&x) && (0..self.height() as i64).contains(&y);
        inside.then(|| y as usize * self.width + x as usize)
    }

    /// Column and row of a place in `values`.
    pub(super) fn pixel(&self, index: usize) -> [i64; 2] {
        [(index % self.width) as i64, (index / self.width) as i64]
    }

    /// The same pixels with other values.
    pub(super) fn map<U>(&self, of: impl Fn(&T) -> U) -> Plane<U> {
        Plane::new(self.width, self.values.iter().map(of).collect())
    }

    /// Values by their places.
    pub(super) fn filled<U>(&self, of: impl Fn(usize) -> U) -> Plane<U> {
        Plane::new(self.width, (0..self.values.len()).map(of).collect())
    }

    /// Places of neighbouring pixels, horizontal pairs and vertical ones, each pair once.
    pub(super) fn pairs(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let beside = |i: usize| (!(i + 1).is_multiple_of(self.width)).then_some([i, i + 1]);
        let below = |i: usize| (i + self.width < self.values.len()).then_some([i, i + self.width]);
        (0..self.values.len()).flat_map(move |i| [beside(i), below(i)]).flatten()
    }
}

/// Steps to all pixels whose centres are at most `radius` pixels away, the pixel itself included.
pub(super) fn disc(radius: i64) -> Vec<[i64; 2]> {
    let row = move |y: i64| (-radius..=radius).map(move |x| [x, y]);
    (-radius..=radius).flat_map(row).filter(|[x, y]| x * x + y * y <= radius * radius).collect()
}

impl Plane<bool> {
    /// How many pixels are set.
    pub(super) fn count(&self) -> u64 {
        self.values.iter().filter(|set| **set).count() as u64
    }

    /// Pixels that have a set one within `radius` pixels, centre to centre.
    pub(super) fn near(&self, radius: i64) -> Plane<bool> {
        let mut near = self.map(|_| false);
        let disc = disc(radius);
        for index in (0..self.values.len()).filter(|index| self.values[*index]) {
            let [x, y] = self.pixel(index);
            for at in disc.iter().filter_map(|[dx, dy]| self.index([x + dx, y + dy])) {
                near.values[at] = true;
            }
        }
        near
    }

    /// The places of each piece of set pixels; pixels hang together by sides and corners (8-connected).
    pub(super) fn pieces(&self) -> Vec<Vec<usize>> {
        let mut left = self.values.clone();
        let mut pieces = Vec::new();
        for start in 0..left.len() {
            if !std::mem::take(&mut left[start]) {
                continue;
            }
            let (mut piece, mut next) = (vec![start], 0);
            while next < piece.len() {
                let [x, y] = self.pixel(piece[next]);
                for dy in -1..=1 {
                    for at in (-1..=1).filter_map(|dx| self.index([x + dx, y + dy])) {
                        if std::mem::take(&mut left[at]) {
                            piece.push(at);
                        }
                    }
                }
                next += 1;
            }
            pieces.push(piece);
        }
        pieces
    }
}

impl Plane<f64> {
    /// Smoothed by a Gaussian of this standard deviation in pixels, whose window of four of them is normalised at the
    /// picture's border.
    pub(super) fn smoothed(&self, sigma: f64) -> Plane<f64> {
        let reach = (4.0 * sigma).ceil() as i64;
        let weights: Vec<f64> = (-reach..=reach).map(|i| (-0.5 * (i as f64 / sigma).powi(2)).exp()).collect();
        let along = |from: &Plane<f64>, [dx, dy]: [i64; 2]| {
            from.filled(|index| {
                let [x, y] = from.pixel(index);
                let (mut sum, mut total) = (0.0, 0.0);
                for (step, weight) in (-reach..=reach).zip(&weights) {
                    if let Some(at) = from.index([x + step * dx, y + step * dy]) {
                        (sum, total) = (sum + weight * from.values[at], total + weight);
                    }
                }
                sum / total
            })
        };
        along(&along(self, [1, 0]), [0, 1])
    }
}

/// A plane of letters, for tests: each row a word.
#[cfg(test)]
pub(super) fn drawn<T>(rows: &[&str], of: impl Fn(char) -> T) -> Plane<T> {
    Plane::new(rows[0].len(), rows.iter().flat_map(|row| row.chars()).map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_is_a_disc() {
        let mut one = Plane::new(9, vec![false; 81]);
        one.values[4 * 9 + 4] = true;
        let expected = [
            ".........",
            "....x....",
            "..xxxxx..",
            "..xxxxx..",
            ".xxxxxxx.",
            "..xxxxx..",
            "..xxxxx..",
            "....x....",
            ".........",
        ];
        assert_eq!(one.near(3), drawn(&expected, |c| c == 'x'));
        assert_eq!((disc(2).len(), one.near(0)), (13, one));
    }

    #[test]
    fn pieces_hang_together_by_corners() {
        let plane = drawn(&["x..xx", ".x...", "....x", "x...x"], |c| c == 'x');
        let sizes: Vec<usize> = plane.pieces().iter().map(Vec::len).collect();
        assert_eq!(sizes, [2, 2, 2, 1]);
    }

    #[test]
    fn every_pair_comes_once() {
        let plane = Plane::new(3, vec![(); 6]);
        let pairs: Vec<[usize; 2]> = plane.pairs().collect();
        assert_eq!(pairs, [[0, 1], [0, 3], [1, 2], [1, 4], [2, 5], [3, 4], [4, 5]]);
    }

    #[test]
    fn a_gaussian_takes_waves_down_by_its_transform() {
        let (sigma, frequency) = (3.0, 0.3_f64);
        let wave = Plane::new(200, (0..200 * 40).map(|i| (f64::from(i % 200) * frequency).cos()).collect());
        let smooth = wave.smoothed(sigma);
        // exp(-(sigma w)^2 / 2), but for the window's end and the sum in place of an integral.
        let expected = (-0.5 * (sigma * frequency).powi(2)).exp();
        for x in 20..180 {
            let at = 20 * 200 + x;
            assert!((smooth.values[at] - expected * wave.values[at]).abs() < 2e-4, "{x}");
        }
        let flat = Plane::new(7, vec![0.75; 35]);
        assert!(flat.smoothed(sigma).values.iter().all(|v| (v - 0.75).abs() < 1e-12));
    }
}
