//! What is measured of smears: whether what leads stays whole, how much ink there is, and colours that are neither side's.

use std::collections::BTreeMap;

use super::still::Share;
use crate::bench::measure::oklab;

/// k' below which what leads has been drawn back.
const WHOLE: f32 = 0.9;
/// Distance in Oklab above which two colours are two, and below which one is the other.
const APART: [f64; 2] = [0.1, 0.05];
/// k' above which a pixel is no smear.
const SMEARED: f32 = 0.99;
/// What of its alpha a pixel differs from the ink by, at most, to be ink.
const INK: f32 = 0.1;

/// A row of `blur.vertices`: x, y, velocity x, y, cluster, k, l, k'.
pub(super) type Vertex = [f32; 8];

/// Share of the vertices on the leading side of their part with k' below 0.9. A vertex leads if nothing of its part is farther ahead,
/// along the part's mean motion, in its own row of a pixel: no edge that passes through the row is, by more than a pixel. `triangles`
/// are of vertices.
pub(super) fn leading(vertices: &[Vertex], triangles: &[[u32; 3]]) -> Share {
    let cluster = |vertex: u32| vertices.get(vertex as usize).map_or(0.0, |vertex| vertex[4]);
    let edges = triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
    let mut edges: Vec<[u32; 2]> = edges.filter(|[a, b]| cluster(*a) > 0.0 && cluster(*a) == cluster(*b)).collect();
    edges.sort_by(|a, b| cluster(a[0]).total_cmp(&cluster(b[0])));
    let mut members: Vec<u32> = (0..vertices.len() as u32).filter(|vertex| cluster(*vertex) > 0.0).collect();
    members.sort_by(|a, b| cluster(*a).total_cmp(&cluster(*b)));
    let parts = members.chunk_by(|a, b| cluster(*a) == cluster(*b)).map(|members| {
        let of_part = |edge: &[u32; 2]| cluster(edge[0]).total_cmp(&cluster(members[0]));
        let first = edges.partition_point(|edge| of_part(edge).is_lt());
        let end = edges.partition_point(|edge| of_part(edge).is_le());
        leading_of_part(vertices, members, &edges[first..end])
    });
    parts.fold(Share::default(), |a, b| Share::new(a.part + b.part, a.whole + b.whole))
}

fn leading_of_part(vertices: &[Vertex], members: &[u32], edges: &[[u32; 2]]) -> Share {
    let sum = |axis: usize| members.iter().map(|vertex| f64::from(vertices[*vertex as usize][axis])).sum::<f64>();
    let length = sum(2).hypot(sum(3));
    if length.is_nan() || length <= 0.0 {
        return Share::default();
    }
    let [dx, dy] = [sum(2) / length, sum(3) / length];
    // How far aside and how far ahead.
    let place = |vertex: u32| {
        let [x, y, ..] = vertices[vertex as usize].map(f64::from);
        [dy * x - dx * y, dx * x + dy * y]
    };
    // Edges by the rows of a pixel that they pass, as far as there are vertices in these.
    let row_of = |vertex: &u32| (place(*vertex)[0].floor() as i64, Vec::new());
    let mut rows: BTreeMap<i64, Vec<[[f64; 2]; 2]>> = members.iter().map(row_of).collect();
    for [a, b] in edges {
        let ends = [place(*a), place(*b)];
        let [low, high] = [ends[0][0].min(ends[1][0]) - 0.5, ends[0][0].max(ends[1][0]) + 0.5];
        rows.range_mut(low.floor() as i64..=high.floor() as i64).for_each(|(_, edges)| edges.push(ends));
    }
    let mut share = Share::default();
    for vertex in members {
        let [aside, ahead] = place(*vertex);
        // The front of the part of an edge that is in the row.
        let front = |[[a, from], [b, to]]: &[[f64; 2]; 2]| {
            let [low, high] = [a.min(*b), a.max(*b)];
            let ends = [aside - 0.5, aside + 0.5].map(|border| if a == b { 0.0 } else { (border - a) / (b - a) });
            let at = |along: f64| from + along.clamp(0.0, 1.0) * (to - from);
            let is_here = low <= aside + 0.5 && high >= aside - 0.5;
            is_here.then_some(if a == b { from.max(*to) } else { at(ends[0]).max(at(ends[1])) })
        };
        let passing = rows.get(&(aside.floor() as i64)).into_iter().flatten().filter_map(front);
        if passing.fold(ahead, f64::max) <= ahead + 1.0 {
            share.whole += 1;
            share.part += u64::from(vertices[*vertex as usize][7] < WHOLE);
        }
    }
    share
}

/// Share of what a picture shows that is ink of this colour (linear RGB). The picture has no background.
pub(super) fn inked(picture: &[[f32; 4]], ink: [f32; 3]) -> Share {
    let figure = picture.iter().filter(|pixel| pixel[3] > 0.5);
    let is_ink = |pixel: &&[f32; 4]| (0..3).all(|c| (pixel[c] - pixel[3] * ink[c]).abs() < INK * pixel[3]);
    Share::new(figure.clone().filter(is_ink).count() as u64, figure.count() as u64)
}

/// A smeared frame, pixel by pixel: colours, the sides that they may come from, and when they are drawn.
pub(super) struct Sides<'a> {
    pub(super) picture: &'a [[f32; 4]],
    pub(super) previous: &'a [[f32; 4]],
    pub(super) next: &'a [[f32; 4]],
    pub(super) mask: &'a [f32],
    pub(super) subframe: &'a [f32],
}

/// Share of the smear's pixels whose sides differ and that show neither. What is `ink` is not looked at: it is drawn over both.
pub(super) fn mixed(sides: &Sides, ink: [f32; 3]) -> Share {
    const BOTH: f32 = 3.0;
    let is_ink = |colour: &[f32; 4]| inked(&[*colour], ink).part > 0;
    let smear = (0..sides.picture.len()).filter(|i| sides.mask.get(*i) == Some(&BOTH) && sides.subframe[*i] < SMEARED);
    let [apart, alike] = APART;
    let mut share = Share::default();
    for pixel in smear {
        let [own, previous, next] = [sides.picture[pixel], sides.previous[pixel], sides.next[pixel]];
        if [own, previous, next].iter().any(is_ink) {
            continue;
        }
        share.whole += 1;
        let [own, previous, next] = [own, previous, next].map(oklab);
        let is_neither = own.distance(previous).min(own.distance(next)) > alike;
        share.part += u64::from(previous.distance(next) > apart && is_neither);
    }
    share
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertex(x: f32, y: f32, cluster: f32, time: f32) -> Vertex {
        [x, y, 5.0, 0.0, cluster, 0.0, 0.0, time]
    }

    #[test]
    fn what_leads_in_its_row_counts() {
        // Two triangles that move to the right: of the first the slanted edge leads, and one of its ends has been drawn back; of the
        // second, which has an edge to the first, all but what stays behind a side.
        let vertices = [
            vertex(10.0, 0.0, 1.0, 1.0),
            vertex(0.0, 0.0, 1.0, 0.2),
            vertex(40.0, 20.0, 1.0, 0.5),
            vertex(10.0, 0.0, 2.0, 0.95),
            vertex(7.0, 8.0, 2.0, 0.1),
            vertex(10.0, 16.0, 2.0, 1.0),
            vertex(90.0, 8.0, 0.0, 1.0),
        ];
        let triangles = [[0, 1, 2], [3, 4, 5], [0, 3, 4], [4, 5, 6]];
        assert_eq!(leading(&vertices, &triangles), Share::new(1, 4));
        assert_eq!(leading(&[], &[]), Share::default());
    }

    #[test]
    fn ink_is_what_is_as_dark() {
        let picture = [[0.0, 0.0, 0.0, 1.0], [0.05, 0.0, 0.0, 0.6], [0.5, 0.5, 0.5, 1.0], [0.0; 4]];
        assert_eq!(inked(&picture, [0.0; 3]), Share::new(2, 3));
    }

    #[test]
    fn a_colour_between_two_is_neither() {
        let (red, green) = ([0.8, 0.1, 0.1, 1.0], [0.1, 0.6, 0.1, 1.0]);
        let half = [0.45, 0.35, 0.1, 1.0];
        let black = [0.0, 0.0, 0.0, 1.0];
        let sides = Sides {
            picture: &[half, red, black, half, half],
            previous: &[red; 5],
            next: &[green, green, green, green, red],
            mask: &[3.0, 3.0, 3.0, 1.0, 3.0],
            subframe: &[0.5; 5],
        };
        assert_eq!(mixed(&sides, [0.0; 3]), Share::new(1, 3));
    }
}
