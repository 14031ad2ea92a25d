//! Lines from depth (section 3.5 of the paper, and steps).
//!
//! Images have `size` = [width, height] pixels, row by row from the top. `depth` is linear view depth in metres, infinite
//! where nothing is seen.

use std::collections::VecDeque;

use super::tone::{inside, place};
use crate::shaders::smoke::constants::{FULL_STEP, LINE_STEP, LOWEST_STEP};
use crate::smoke::settings::{Operator, Outline};
use crate::view::{Projection, View};

/// A line's strength at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark {
    /// None.
    None,
    /// What is beside shows nothing.
    Silhouette,
    /// Within the smoke; the strength of the line.
    Inner(f64),
}

/// Opacity of inner lines and of silhouettes in every pixel, 0 to 1; 0 where nothing is seen.
///
/// `voxel` is the smallest side of a voxel in metres. Width spreads a line: the greatest opacity of all pixels near enough.
pub fn outline(size: [u32; 2], depth: &[f64], view: &View, voxel: f64, settings: &Outline) -> Vec<[f64; 2]> {
    let marks = marks(size, depth, view, voxel, settings);
    let marks = if settings.operator == Operator::Step { drawn(size, &marks, settings) } else { marks };
    widened(size, depth, &marks, settings)
}

/// Strengths before lines are followed: of steps their height.
pub fn marks(size: [u32; 2], depth: &[f64], view: &View, voxel: f64, settings: &Outline) -> Vec<Mark> {
    let projection = Projection::of_valid(view, size);
    let mark = |pixel: usize| {
        let centre = depth[pixel];
        if !centre.is_finite() || !settings.is_on() {
            return Mark::None;
        }
        let unit = voxel.max(8.0 * projection.widening(centre) / projection.focal.y);
        stencil(size, depth, unit, settings, pixel)
    };
    (0..depth.len()).map(mark).collect()
}

/// The mark of a pixel that shows something, with depth in `unit`.
fn stencil(size: [u32; 2], depth: &[f64], unit: f64, settings: &Outline, pixel: usize) -> Mark {
    let [x, y] = place(size, pixel);
    let [last_x, last_y] = size.map(|n| i64::from(n) - 1);
    let at = |dx: i64, dy: i64| {
        let [x, y] = [(x + dx).clamp(0, last_x), (y + dy).clamp(0, last_y)];
        depth[y as usize * size[0] as usize + x as usize]
    };
    let axes: &[[i64; 2]] = match settings.operator {
        Operator::Step => &[[1, 1], [1, -1], [1, 0], [0, 1]],
        Operator::Roberts | Operator::Second => &[[1, 1], [1, -1]],
    };
    let pairs: Vec<[f64; 2]> = axes.iter().map(|[dx, dy]| [at(-dx, -dy), at(*dx, *dy)]).collect();
    if pairs.iter().flatten().any(|z| !z.is_finite()) {
        return Mark::Silhouette;
    }
    let strength = f64::from(settings.inner_lines().strength);
    let second = |[a, b]: &[f64; 2]| (a + b - 2.0 * depth[pixel]) / unit;
    let squared = |difference: f64| 1.0 - (1.0 - strength * difference).max(0.0);
    Mark::Inner(match settings.operator {
        Operator::Step => strength * pairs.iter().map(second).fold(0.0, f64::max),
        Operator::Roberts => squared(pairs.iter().map(|[a, b]| ((a - b) / unit).powi(2)).sum()),
        Operator::Second => squared(pairs.iter().map(|pair| second(pair).powi(2)).sum()),
    })
}

/// Of the heights of steps, those that are ink; what is left of them is the share of the width that each has.
///
/// Ink is what is higher than `LINE_STEP`, and what is higher than `LOWEST_STEP` within `follow` pixels along such from
/// it. Of that stays what within `shortest` pixels along ink reaches over `shortest` columns or rows.
pub fn drawn(size: [u32; 2], heights: &[Mark], settings: &Outline) -> Vec<Mark> {
    let above = |limit: f32| {
        let is_above = move |mark: &Mark| match mark {
            Mark::None => false,
            Mark::Silhouette => true,
            Mark::Inner(height) => *height > f64::from(limit),
        };
        heights.iter().map(is_above).collect::<Vec<bool>>()
    };
    let (weak, strong) = (above(LOWEST_STEP), above(LINE_STEP));
    let pixels = || 0..heights.len();
    let traced = walk(size, &weak, pixels().filter(|pixel| strong[*pixel]), settings.trace_reach());
    let mut ink = vec![false; heights.len()];
    traced.into_iter().for_each(|pixel| ink[pixel] = true);
    let stays = |pixel: usize| {
        let piece = walk(size, &ink, [pixel], settings.piece_reach());
        let span = |axis: usize| {
            let along = || piece.iter().map(|pixel| place(size, *pixel)[axis]);
            along().max().unwrap_or(0) - along().min().unwrap_or(0) + 1
        };
        span(0).max(span(1)) as f64 >= f64::from(settings.shortest)
    };
    let mark = |pixel: usize| match heights[pixel] {
        _ if !ink[pixel] || !stays(pixel) => Mark::None,
        Mark::Inner(height) => {
            let [lowest, full] = [LOWEST_STEP, FULL_STEP].map(f64::from);
            let fullness = ((height - lowest) / (full - lowest)).clamp(0.0, 1.0);
            Mark::Inner(1.0 - f64::from(settings.taper) * (1.0 - fullness))
        }
        silhouette => silhouette,
    };
    pixels().map(mark).collect()
}

/// The pixels of `allowed` that are at most `reach` steps to neighbours from one of `starts`.
fn walk(size: [u32; 2], allowed: &[bool], starts: impl IntoIterator<Item = usize>, reach: u32) -> Vec<usize> {
    let mut seen = vec![false; allowed.len()];
    let mut found: Vec<usize> = Vec::new();
    let mut waiting: VecDeque<(usize, u32)> = starts.into_iter().map(|start| (start, 0)).collect();
    waiting.iter().for_each(|(start, _)| seen[*start] = true);
    while let Some((pixel, steps)) = waiting.pop_front() {
        found.push(pixel);
        let [x, y] = place(size, pixel);
        for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
            match inside(size, x + dx, y + dy) {
                Some(other) if steps < reach && allowed[other] && !seen[other] => {
                    seen[other] = true;
                    waiting.push_back((other, steps + 1));
                }
                _ => {}
            }
        }
    }
    found
}

/// Opacities of lines with their width.
fn widened(size: [u32; 2], depth: &[f64], marks: &[Mark], settings: &Outline) -> Vec<[f64; 2]> {
    let (inner, silhouettes) = (settings.inner_lines(), settings.silhouettes());
    let opacity = |strength: f64, width: f32, way: f64| match settings.operator {
        Operator::Step => (strength * f64::from(width) - way).clamp(0.0, 1.0),
        Operator::Roberts | Operator::Second => strength * (f64::from(width) - way).clamp(0.0, 1.0),
    };
    let reach = i64::from(settings.reach());
    let pixel = |pixel: usize| {
        let mut most = [0.0_f64; 2];
        let [x, y] = place(size, pixel);
        for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
            let way = (dx as f64).hypot(dy as f64);
            match inside(size, x + dx, y + dy).map(|other| marks[other]) {
                Some(Mark::Inner(strength)) => most[0] = most[0].max(opacity(strength, inner.width, way)),
                Some(Mark::Silhouette) => most[1] = most[1].max(opacity(1.0, silhouettes.width, way)),
                Some(Mark::None) | None => {}
            }
        }
        let seen = if depth[pixel].is_finite() { 1.0 } else { 0.0 };
        [seen * most[0], seen * most[1] * f64::from(silhouettes.strength)]
    };
    (0..depth.len()).map(pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Camera;

    const SIZE: [u32; 2] = [9, 7];

    fn image<T>(value: impl Fn(i64, i64) -> T) -> Vec<T> {
        (0..63).map(|pixel| value(pixel % 9, pixel / 9)).collect()
    }

    /// 90 degrees: at depth 1 the seven rows are 2 m high.
    fn camera() -> Camera {
        Camera { vertical_fov: 90.0, ..Camera::default() }
    }

    /// The opacity of both kinds of lines together.
    fn of_both(lines: Vec<[f64; 2]>) -> Vec<f64> {
        lines.into_iter().map(|[inner, silhouette]| inner.max(silhouette)).collect()
    }

    fn line(depth: &[f64], voxel: f64, settings: Outline) -> Vec<f64> {
        of_both(outline(SIZE, depth, &camera().view(SIZE), voxel, &settings))
    }

    fn thin(strength: f32, operator: Operator) -> Outline {
        Outline { strength, width: 1.0, operator, ..Outline::default() }
    }

    #[test]
    fn a_step_of_one_voxel_is_black_and_half_a_voxel_half_grey() {
        // One degree: at depth 1, 8 pixels are 0.02 m, below a voxel of 0.125. A step between columns 3 and 4 is crossed
        // by both diagonals of columns 3 and 4: l' = 2 (step / voxel)^2.
        let row = |step: f64, strength: f32| {
            let depth = image(|x, _| if x < 4 { 1.0 } else { 1.0 + step });
            let camera = Camera { vertical_fov: 1.0, ..camera() };
            let settings = thin(strength, Operator::Roberts);
            of_both(outline(SIZE, &depth, &camera.view(SIZE), 0.125, &settings))[27..36].to_vec()
        };
        assert_eq!(row(0.125, 1.0), [0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(row(0.0625, 1.0), [0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(row(0.0625, 0.5), [0.0, 0.0, 0.0, 0.25, 0.25, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn far_away_the_unit_is_eight_pixels_of_the_centre() {
        // Depth 7: a pixel is 2 m high, the unit 16 m. The step of 8 m is seen from 7 (l' = 2 / 4) and from 15, where
        // the unit is 240 / 7 m.
        let depth = image(|x, _| if x < 4 { 7.0 } else { 15.0 });
        let opacity = line(&depth, 0.125, thin(1.0, Operator::Roberts));
        assert!((opacity[30] - 0.5).abs() < 1e-14);
        assert!((opacity[31] - 2.0 * (56.0_f64 / 240.0).powi(2)).abs() < 1e-14);
    }

    #[test]
    fn second_differences_ignore_slopes() {
        let slope = image(|x, y| 0.01 + 0.05 * x as f64 + 0.02 * y as f64);
        let roberts = line(&slope, 1.0, thin(1.0, Operator::Roberts));
        let second = line(&slope, 1.0, thin(1.0, Operator::Second));
        // Diagonals (2, -2) and (2, 2): 0.06^2 + 0.14^2. The unit is 1 m, as 8 pixels are 0.66 m there.
        assert!((roberts[2 * 9 + 2] - (0.06_f64.powi(2) + 0.14_f64.powi(2))).abs() < 1e-14);
        assert!(second[2 * 9 + 2] < 1e-14);
        let crease = image(|x, _| 0.01 + 0.1 * x.abs_diff(4) as f64);
        assert!((line(&crease, 1.0, thin(1.0, Operator::Second))[31] - 2.0 * 0.2_f64.powi(2)).abs() < 1e-14);
    }

    #[test]
    fn borders_of_the_smoke_are_silhouette_and_borders_of_the_image_are_not() {
        let depth = image(|x, y| if (x, y) == (4, 3) { f64::INFINITY } else { 0.01 });
        let opacity = line(&depth, 1.0, thin(1.0, Operator::Roberts));
        let black: Vec<usize> = (0..63).filter(|pixel| opacity[*pixel] == 1.0).collect();
        // The four diagonal neighbours see the hole; the hole itself carries no line.
        assert_eq!(black, [2 * 9 + 3, 2 * 9 + 5, 4 * 9 + 3, 4 * 9 + 5]);
        assert_eq!(opacity.iter().sum::<f64>(), 4.0);
        assert_eq!(line(&depth, 1.0, thin(0.0, Operator::Roberts)), [0.0; 63]);
        assert_eq!(line(&[f64::INFINITY; 63], 1.0, thin(1.0, Operator::Roberts)), [0.0; 63]);
    }

    #[test]
    fn width_spreads_the_line_over_smoke() {
        let depth = image(|x, y| if (x, y) == (4, 3) { f64::INFINITY } else { 0.01 });
        let opacity = line(&depth, 1.0, Outline { width: 2.25, ..thin(1.0, Operator::Roberts) });
        let at = |x: usize, y: usize| opacity[y * 9 + x];
        assert_eq!(at(4, 3), 0.0, "the hole");
        assert_eq!(at(4, 2), 1.0, "beside two black pixels");
        assert_eq!(at(2, 1), 2.25 - 2.0_f64.sqrt(), "a diagonal away");
        assert_eq!(at(1, 2), 0.25, "two away");
        assert_eq!(at(0, 2), 0.0, "three away");
    }
}
