//! The triangle-id buffer by pixel centres: homogeneous edge functions in f64, without clipping.
//!
//! Corners are pixel clip coordinates (X, Y, W): X / W and Y / W are pixels, y down, W is the view depth in metres.
//! Each pixel also says whether rounding may have decided: a device rounds corners to f32 and then to 1/256 pixel.

/// Pixel clip coordinates (X, Y, W) of a point.
pub type Clip = [f64; 3];

/// How far a device may move a corner, in pixels, besides what f32 loses: its grid has at least 256 steps a pixel.
const GRID: f64 = 1.0 / 256.0;
/// Rounding error of an f32 position, as a share of it: 8 roundings.
const ROUNDING: f64 = 8.0 / 16_777_216.0;
/// Depths that differ by less than this share are a tie that rounding decides.
const TIE: f64 = 1e-6;

/// A triangle that has an area on screen.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    corners: [Clip; 3],
    /// Gradient of each corner's edge function by the place on screen. It grows towards the inside.
    lines: [[f64; 2]; 3],
    /// 1 or -1, for both orientations are drawn.
    side: f64,
    /// Six times the volume that the corners span with the eye, above 0.
    volume: f64,
}

/// A corner as seen from a place on screen.
fn seen_from(corner: Clip, [x, y]: [f64; 2]) -> Clip {
    let [cx, cy, w] = corner;
    [cx - x * w, cy - y * w, w]
}

/// Six times the volume that three corners span with the eye: above 0 where the triangle is turned away, which is where
/// its corners follow each other clockwise on screen.
pub fn volume(corners: [Clip; 3]) -> f64 {
    // The same wherever the origin of the screen is: near the triangle less is lost.
    let origin = corners.iter().find(|c| c[2] > 0.0).map_or([0.0; 2], |c| [c[0] / c[2], c[1] / c[2]]);
    let [a, b, c] = corners.map(|corner| seen_from(corner, origin));
    let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]
}

impl Shape {
    /// None where the triangle has no area, or is not finite.
    pub fn new(corners: [Clip; 3]) -> Option<Shape> {
        let volume = volume(corners);
        if !volume.is_finite() || volume == 0.0 {
            return None;
        }
        let side = volume.signum();
        let line = |i: usize| {
            let ([ax, ay, aw], [bx, by, bw]) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
            [side * (ay * bw - aw * by), side * (aw * bx - ax * bw)]
        };
        Some(Shape { corners, lines: [0, 1, 2].map(line), side, volume: volume.abs() })
    }

    /// The edge function opposite of each corner at a place on screen: above 0 inside. That of an edge that another
    /// triangle runs along the other way is the exact negative of that one's.
    fn edges(&self, at: [f64; 2]) -> [f64; 3] {
        let [a, b, c] = self.corners.map(|corner| seen_from(corner, at));
        let cross = |p: Clip, q: Clip| self.side * (p[0] * q[1] - p[1] * q[0]);
        [cross(b, c), cross(c, a), cross(a, b)]
    }

    /// Perspective-correct barycentric coordinates, where the triangle covers a place by the top-left rule.
    pub fn weights(&self, at: [f64; 2]) -> Option<[f64; 3]> {
        let edges = self.edges(at);
        let is_top_left = |[x, y]: [f64; 2]| x > 0.0 || (x == 0.0 && y > 0.0);
        let inside = |(edge, line): (&f64, &[f64; 2])| *edge > 0.0 || (*edge == 0.0 && is_top_left(*line));
        let sum: f64 = edges.iter().sum();
        (edges.iter().zip(&self.lines).all(inside) && sum > 0.0).then(|| edges.map(|edge| edge / sum))
    }

    /// Barycentric coordinates of where the triangle's plane is seen at a place, also beside the triangle.
    pub fn plane_weights(&self, at: [f64; 2]) -> [f64; 3] {
        let edges = self.edges(at);
        let sum: f64 = edges.iter().sum();
        edges.map(|edge| edge / sum)
    }

    /// 1 / W of the triangle's plane at a place; not above 0 where the plane is not seen there.
    pub fn inverse_depth(&self, at: [f64; 2]) -> f64 {
        self.edges(at).iter().sum::<f64>() / self.volume
    }

    /// How fast 1 / W changes along the screen, per pixel.
    pub fn slope(&self) -> f64 {
        let sum = |i: usize| self.lines.iter().map(|line| line[i]).sum::<f64>();
        sum(0).hypot(sum(1)) / self.volume
    }

    /// Distance in pixels to the nearest border, the near plane included; below 0 outside.
    fn clearance(&self, at: [f64; 2], near: f64) -> f64 {
        let edges = self.edges(at);
        let distances = edges.iter().zip(&self.lines).map(|(edge, line)| edge / line[0].hypot(line[1]));
        let least = distances.fold(f64::INFINITY, f64::min);
        match self.corners.iter().any(|c| c[2] < near * (1.0 + TIE)) {
            true => least.min((1.0 / near - self.inverse_depth(at)) / self.slope().max(f64::MIN_POSITIVE)),
            false => least,
        }
    }

    /// Box around the triangle on screen: least and largest; none where it goes through the eye's plane.
    fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        let places = self.corners.map(|[x, y, w]| (w > 0.0).then_some([x / w, y / w]));
        let [Some(a), Some(b), Some(c)] = places else { return None };
        Some([f64::min, f64::max].map(|pick| [0, 1].map(|i| pick(pick(a[i], b[i]), c[i]))))
    }

    /// How far a device may have the triangle's border from where it is, in pixels.
    fn slack(&self, size: [u32; 2]) -> f64 {
        let far = |bounds: [[f64; 2]; 2]| bounds.iter().flatten().fold(0.0, |most: f64, c| most.max(c.abs()));
        let reach = f64::from(size[0].max(size[1]));
        GRID + ROUNDING * self.bounds().map_or(reach, |bounds| far(bounds).max(reach))
    }

    /// Calls `visit` with the number and the centre of each pixel that the triangle can reach.
    fn reach(&self, size: [u32; 2], slack: f64, mut visit: impl FnMut(usize, [f64; 2])) {
        let [low, high] = self.bounds().unwrap_or([[f64::NEG_INFINITY; 2], [f64::INFINITY; 2]]);
        let range = |i: usize| {
            let side = f64::from(size[i]);
            let first = (low[i] - slack - 0.5).ceil().clamp(0.0, side) as u32;
            first..(high[i] + slack + 0.5).floor().clamp(0.0, side) as u32
        };
        for y in range(1) {
            for x in range(0) {
                visit(y as usize * size[0] as usize + x as usize, [f64::from(x) + 0.5, f64::from(y) + 0.5]);
            }
        }
    }
}

/// The triangles that pixels see.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Pixels, width and height.
    pub size: [u32; 2],
    /// The triangle at each pixel's centre, from 1; 0: none. Row by row.
    pub seen: Vec<u32>,
    /// Its W there in metres; infinite where there is none.
    pub depth: Vec<f64>,
    /// Whether a border or a tie of depths is so near that rounding may have decided.
    pub uncertain: Vec<bool>,
}

/// Draws triangles; none stands for one that is not drawn, but has a number. The smaller W wins, of equal ones the
/// smaller number. Nothing nearer than `near` metres is seen.
pub fn raster(shapes: &[Option<Shape>], size: [u32; 2], near: f64) -> Raster {
    let pixels = size[0] as usize * size[1] as usize;
    let (seen, depth) = (vec![0; pixels], vec![f64::INFINITY; pixels]);
    let mut raster = Raster { size, seen, depth, uncertain: vec![false; pixels] };
    let drawn = || shapes.iter().zip(1..).filter_map(|(shape, name)| shape.as_ref().map(|shape| (shape, name)));
    for (shape, name) in drawn() {
        shape.reach(size, 0.0, |pixel, at| {
            let depth = 1.0 / shape.inverse_depth(at);
            if shape.weights(at).is_some() && depth >= near && depth < raster.depth[pixel] {
                (raster.seen[pixel], raster.depth[pixel]) = (name, depth);
            }
        });
    }
    for (shape, name) in drawn() {
        let slack = shape.slack(size);
        let nearest = shape.corners.iter().fold(f64::INFINITY, |least: f64, c| least.min(c[2])).max(near);
        shape.reach(size, slack, |pixel, at| {
            let clearance = shape.clearance(at, near);
            if clearance < -slack || raster.uncertain[pixel] {
                return;
            }
            let first = 1.0 / raster.depth[pixel];
            let is_border = clearance <= slack && 1.0 / nearest >= first * (1.0 - TIE);
            let winner = raster.seen[pixel].checked_sub(1).and_then(|place| shapes[place as usize].as_ref());
            let is_tie = winner.is_some_and(|winner| {
                let moved = slack * (winner.slope() + shape.slope());
                raster.seen[pixel] != name && first - shape.inverse_depth(at) <= TIE * first + moved
            });
            raster.uncertain[pixel] = is_border || is_tie;
        });
    }
    raster
}
