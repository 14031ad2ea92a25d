//! Trajectories as the device evaluates them: pieces in f32, each operation rounded by itself, in this order.

use crate::blur::motion::{Piece, Segment};

/// One vertex's trajectory.
#[derive(Clone, Copy, Debug)]
pub struct Path<'a> {
    /// The segments of the interval.
    pub segments: &'a [Segment],
    /// The vertex's piece of each.
    pub pieces: &'a [Piece],
    /// Whether pieces are in pixels.
    pub on_screen: bool,
}

/// Where a vertex is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Pixels, y down.
    pub position: [f32; 2],
    /// Pixels per frame.
    pub velocity: [f32; 2],
    /// View depth in metres.
    pub depth: f32,
}

impl Path<'_> {
    /// The piece that holds `time`, in frames after frame i, and its place: the first in the order of segments that
    /// does; else the earliest or the latest.
    fn piece(&self, time: f32) -> usize {
        let holds = |s: &Segment| s.begin <= time && time <= s.end;
        let nearest = |a: usize, b: usize| {
            let (first, second) = (self.segments[a], self.segments[b]);
            let better = if time < 0.0 { second.begin < first.begin } else { second.end > first.end };
            if better { b } else { a }
        };
        let outside = (1..self.segments.len()).fold(0, nearest);
        self.segments.iter().position(holds).unwrap_or(outside)
    }

    /// The offset of the channels from frame i's at `time`, and the derivative by time.
    fn offset(&self, time: f32) -> [[f32; 3]; 2] {
        let place = self.piece(time);
        let (Segment { begin, end }, piece) = (self.segments[place], &self.pieces[place]);
        let length = end - begin;
        let beyond = if time < begin { time - begin } else { (time - end).max(0.0) };
        let u = (time - beyond - begin) / length;
        let c = 1.0 - u;
        let (first, second) = ((c * c * c - c) * (1.0 / 6.0), (u * u * u - u) * (1.0 / 6.0));
        let (first_slope, second_slope) = ((1.0 - 3.0 * (c * c)) * (1.0 / 6.0), (3.0 * (u * u) - 1.0) * (1.0 / 6.0));
        let channel = |i: usize| {
            let from = if place == 0 { 0.0 } else { piece.origin[i] };
            let (step, bends) = (piece.step[i], [piece.bend_begin[i], piece.bend_end[i]]);
            let slope = (step + first_slope * bends[0] + second_slope * bends[1]) / length;
            let value = from + (u * step + first * bends[0] + second * bends[1]);
            // Straight before the earliest segment and after the latest.
            [if beyond == 0.0 { value } else { value + beyond * slope }, slope]
        };
        let channels = [0, 1, 2].map(channel);
        [0, 1].map(|part| channels.map(|c| c[part]))
    }

    /// The state at `time`: an offset from frame i's position, so that it is exact for what hardly moves.
    pub fn at(&self, time: f32) -> State {
        let [x, y, w, _] = self.pieces[0].origin;
        let [d, slope] = self.offset(time);
        let depth = w + d[2];
        if self.on_screen {
            return State { position: [x + d[0], y + d[1]], velocity: [slope[0], slope[1]], depth };
        }
        let from = [x / w, y / w];
        let moved = [(d[0] - from[0] * d[2]) / depth, (d[1] - from[1] * d[2]) / depth];
        let position = [from[0] + moved[0], from[1] + moved[1]];
        let velocity = [(slope[0] - position[0] * slope[2]) / depth, (slope[1] - position[1] * slope[2]) / depth];
        State { position, velocity, depth }
    }

    /// The distance from frame i's position to that at `time` in pixels.
    pub fn moved(&self, time: f32) -> [f32; 2] {
        let [x, y, w, _] = self.pieces[0].origin;
        let [d, _] = self.offset(time);
        if self.on_screen {
            return [d[0], d[1]];
        }
        let depth = w + d[2];
        [(d[0] - x / w * d[2]) / depth, (d[1] - y / w * d[2]) / depth]
    }
}
