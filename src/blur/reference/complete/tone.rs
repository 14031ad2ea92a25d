//! How the light on a surface depends on its normal, from the places that both frames show, and what that says of places
//! that one of them hides.
//!
//! A colour is what the surface is painted with times a *tone*, channel by channel, and the tone is a function of the
//! cosine between the normal and a direction, the light's: so it is for flat tones, ramps and diffuse light, whatever the
//! materials and textures. Neither the paint nor the direction nor the function is known. But where both frames show a
//! place, the paint cancels: the logarithm of its colour changes as that of its tone does. Of all directions and functions
//! those are taken that explain these changes best.
//!
//! Logarithms, weights and errors are whole numbers, so that the order of their sums does not matter.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::table::{lessons, scale};
use crate::blur::limits::LIGHT_CANDIDATES;
use crate::blur::params::{
    ALLOWED, AROUND, BESIDE, CLEAR, EVEN, FEW_WEIGHT, FIRST_SEARCHES, FIRST_STEPS, LOGARITHM, MOST_CHANGE, MOST_FEW,
    MOST_FIRST, MOST_SITES, MOST_STRIDE, REPEATS, RESIDUAL, SEARCH_STEPS, STARTS, STILL_STARTS, TONE_STEPS,
    TURNED_STARTS, WANTED_FIRST, WANTED_SITES, WHOLE,
};
use crate::blur::reference::visible::{Colour, Frame, Surface};
use crate::random::hash;
use crate::shaders::common::constants::MOST_HALF;

/// How tones are solved for in the search, and those under the light that is found.
const SEARCHING: Weighing = Weighing { scale: CLEAR, times: 2 };
const FINDING: Weighing = Weighing { scale: RESIDUAL, times: REPEATS as usize };
/// The distance that each round of the search after the first halves; the kernels have the nearest float.
const LATER_REACH: f64 = 0.24;
/// Added to colours before their logarithm, so that what is black has one; as [`LATER_REACH`].
const ADDED: f64 = 0.01;

/// A place that both frames show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Its surface.
    pub surface: u32,
    /// Unit normals in frames i and i + 1.
    pub normals: [[f64; 3]; 2],
    /// The logarithm of its red, green and blue in frame i + 1 by those in frame i, in units.
    pub change: [i32; 3],
    /// How many places it stands for.
    pub weight: u32,
}

/// The learnt tones.
#[derive(Clone, Debug, PartialEq)]
pub struct Tones {
    /// Directions in frames i and i + 1, of length 1. The opposite ones with tones the other way round say the same.
    pub lights: [[f64; 3]; 2],
    /// Logarithm of the tone at each step of the cosine, from -1 to 1, in units; only differences mean something.
    pub tones: Vec<[i32; 3]>,
    /// Those of each surface that shows a place.
    pub own: BTreeMap<u32, Vec<[i32; 3]>>,
    /// The variation that the tones leave unexplained over all places ([`badness`]), and the variation there was.
    pub unexplained: [u64; 2],
    /// The same of each surface's places, and what may be: twice what there was, and [`ALLOWED`] each.
    pub surfaces: BTreeMap<u32, [u64; 2]>,
    /// The largest value of a channel.
    brightest: f64,
}

/// `normal` with length 1; none of what has no direction.
pub fn unit(normal: [f64; 3]) -> Option<[f64; 3]> {
    let length = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
    (length > 0.0 && length.is_finite()).then(|| normal.map(|c| c / length))
}

fn lit(channel: f64) -> f64 {
    if channel > 0.0 { channel.min(MOST_HALF.into()) + ADDED } else { ADDED }
}

/// How a channel changes, in units, halves rounded up.
pub fn change(from: f64, to: f64) -> i32 {
    let logarithm = (lit(to).ln() - lit(from).ln()) * f64::from(LOGARITHM);
    ((logarithm + 0.5).floor() as i32).clamp(-MOST_CHANGE, MOST_CHANGE)
}

/// Weight of a residual r, the sum over the channels of how far a change is from that of the tone: r r / 2 C below C =
/// [`CLEAR`] (0.3), above r - C / 2: an outlier, a border of two paints, has no more than its share.
pub fn badness(residual: u32) -> u32 {
    if residual < CLEAR { residual * residual / (2 * CLEAR) } else { residual - CLEAR / 2 }
}

/// Over three channels.
fn changed(change: [i32; 3]) -> u32 {
    change.iter().map(|c| c.unsigned_abs()).sum()
}

fn step(light: [f64; 3], normal: [f64; 3], steps: usize) -> usize {
    let cosine: f64 = (0..3).map(|i| light[i] * normal[i]).sum();
    ((cosine * 0.5 + 0.5) * steps as f64).clamp(0.0, steps as f64 - 1.0) as usize
}

/// The places: of each frame, pixels in the middle of each `stride` x `stride` cells (`stride / 2` from its corner) that
/// teach (`lessons`), see a triangle that moves, and whose place the other frame shows. `stride` is the least that makes
/// the pixels of both frames that see what moves no more than [`WANTED_SITES`]. Second: the few with which the search
/// begins, those whose colour changes clearly ([`CLEAR`]), for these say most, and of the others those in every fourth column
/// and second row of cells, each for eight. Third: of these, with which its first rounds begin, one in so many that of all places
/// [`WANTED_FIRST`] would be left, chosen by hash of frame and cell. All are empty where there are more than [`MOST_SITES`].
pub fn sites(surface: &Surface, frames: [&Frame; 2]) -> [Vec<Site>; 3] {
    let width = frames[0].seen.size[0] as usize;
    let moves = |name: &&u32| name.checked_sub(1).is_some_and(|base| !surface.still[base as usize]);
    let moving: usize = frames.iter().map(|frame| frame.seen.seen.iter().filter(moves).count()).sum();
    let most = MOST_STRIDE as usize;
    let is_enough = |stride: &usize| (stride * stride) as u64 * u64::from(WANTED_SITES) >= moving as u64;
    let stride = (1..most).find(is_enough).unwrap_or(most);
    let parts = (moving / (stride * stride * WANTED_FIRST as usize)).max(1) as u32;
    let (mut all, mut few, mut first) = (Vec::new(), Vec::new(), Vec::new());
    for side in 0..2 {
        let other = 1 - side;
        for lesson in lessons(surface, frames[side], 1.0) {
            let at = [lesson.pixel % width, lesson.pixel / width];
            if at.iter().any(|c| c % stride != stride / 2) || surface.still[lesson.base as usize] {
                continue;
            }
            let Some(there) = frames[other].look_up(surface, lesson.base, lesson.weights).known() else { continue };
            let own = frames[side].image[lesson.pixel].map(f64::from);
            let colours = if side == 0 { [own, there] } else { [there, own] };
            let normals = frames.map(|frame| unit(frame.normal(surface, lesson.base, lesson.weights)));
            let [Some(earlier), Some(later)] = normals else { continue };
            let change = [0, 1, 2].map(|i| change(colours[0][i], colours[1][i]));
            let site = Site { surface: lesson.surface, normals: [earlier, later], change, weight: 1 };
            all.push(site);
            let cell = at.map(|c| (c / stride) as u32);
            let is_one = cell[0].is_multiple_of(4) && cell[1].is_multiple_of(2);
            let is_clear = changed(change) >= CLEAR;
            if is_clear || is_one {
                let site = Site { weight: if is_clear { 1 } else { FEW_WEIGHT }, ..site };
                few.push(site);
                if hash(side as u32, cell[0], cell[1], 0).is_multiple_of(parts) {
                    first.push(site);
                }
            }
        }
    }
    let most = [MOST_SITES, MOST_FEW, MOST_FIRST].map(|most| most as usize);
    let fits = [&all, &few, &first].iter().zip(most).all(|(places, most)| places.len() <= most);
    if fits { [all, few, first] } else { [const { Vec::new() }; 3] }
}

/// Steps of a place in frames i + 1 and i.
fn steps_at(site: &Site, lights: [[f64; 3]; 2], steps: usize) -> [usize; 2] {
    [step(lights[1], site.normals[1], steps), step(lights[0], site.normals[0], steps)]
}

fn residual(site: &Site, [later, earlier]: [usize; 2], tones: &[[i32; 3]]) -> u32 {
    (0..3).map(|i| (tones[later][i] - tones[earlier][i] - site.change[i]).unsigned_abs()).sum()
}

/// How often tones are solved for, and how much a place counts.
#[derive(Clone, Copy, Debug)]
pub struct Weighing {
    /// Residual above which a place counts less.
    pub scale: u32,
    /// Times. The first time all places count alike.
    pub times: usize,
}

/// Tones under given lights: the least squares over all places of the tone's change less the colour's. One that has a
/// residual r above `scale` counts `scale` / r, rounded to sixteenths. Two neighbouring steps that have one tone are as good
/// as a place; the square of a tone counts a sixteenth of one, so that there is always a solution. Rounded, halves up.
pub fn solve(sites: &[Site], lights: [[f64; 3]; 2], steps: usize, weighing: Weighing) -> Vec<[i32; 3]> {
    let Weighing { scale, times } = weighing;
    let mut tones = vec![[0; 3]; steps];
    for time in 0..times {
        let mut matrix = vec![vec![0.0; steps]; steps];
        let mut rights = vec![[0.0; 3]; steps];
        for site in sites {
            let at = steps_at(site, lights, steps);
            let residual = residual(site, at, &tones);
            let is_whole = time == 0 || residual <= scale;
            let weight = site.weight * if is_whole { WHOLE } else { (WHOLE * scale + residual / 2) / residual };
            couple(&mut matrix, at, f64::from(weight));
            for (i, change) in site.change.into_iter().enumerate() {
                let value = f64::from(weight) * f64::from(change);
                rights[at[0]][i] += value;
                rights[at[1]][i] -= value;
            }
        }
        (1..steps).for_each(|step| couple(&mut matrix, [step - 1, step], f64::from(WHOLE)));
        (0..steps).for_each(|step| matrix[step][step] += 1.0);
        tones = eliminated(matrix, rights);
    }
    tones
}

fn couple(matrix: &mut [Vec<f64>], [a, b]: [usize; 2], weight: f64) {
    if a != b {
        matrix[a][a] += weight;
        matrix[b][b] += weight;
        matrix[a][b] -= weight;
        matrix[b][a] -= weight;
    }
}

/// By Gauss: the matrix is diagonally dominant.
fn eliminated(mut matrix: Vec<Vec<f64>>, mut rights: Vec<[f64; 3]>) -> Vec<[i32; 3]> {
    let steps = rights.len();
    for pivot in 0..steps {
        let (row, right) = (matrix[pivot].clone(), rights[pivot]);
        for below in pivot + 1..steps {
            let factor = matrix[below][pivot] / row[pivot];
            (pivot..steps).for_each(|column| matrix[below][column] -= factor * row[column]);
            (0..3).for_each(|i| rights[below][i] -= factor * right[i]);
        }
    }
    for pivot in (0..steps).rev() {
        let solved = rights[pivot].map(|right| right / matrix[pivot][pivot]);
        (0..pivot).for_each(|above| (0..3).for_each(|i| rights[above][i] -= matrix[above][pivot] * solved[i]));
        rights[pivot] = solved;
    }
    rights.into_iter().map(|right| right.map(|tone| (tone + 0.5).floor() as i32)).collect()
}

/// The `index`-th of `count` directions spread over half of the sphere, on a spiral of golden angles.
fn spread(index: usize, count: usize) -> [f64; 3] {
    let z = 1.0 - (index as f64 + 0.5) / count as f64;
    let ring = (1.0 - z * z).sqrt();
    let (sin, cos) = (2.399_963_229_728_653 * index as f64).sin_cos();
    [ring * cos, ring * sin, z]
}

/// A direction (0), or one of `count` at a distance around it.
fn beside(light: [f64; 3], index: usize, count: usize, distance: f64) -> [f64; 3] {
    if index == 0 {
        return light;
    }
    let light = glam::DVec3::from_array(light);
    let size = light.abs();
    let axis = match () {
        () if size.x <= size.y && size.x <= size.z => glam::DVec3::X,
        () if size.y <= size.z => glam::DVec3::Y,
        () => glam::DVec3::Z,
    };
    let across = light.cross(axis).normalize();
    let (sin, cos) = (TAU * (index - 1) as f64 / count as f64).sin_cos();
    (light + distance * (cos * across + sin * light.cross(across))).normalize().to_array()
}

/// A candidate of a round of the search. Round 0: 256 directions over half of the sphere under a light that stays, then
/// eight around each of 32 under one that turns by 0.25. Later rounds r: the best of the one before and those around it,
/// four at a distance of 0.24 / 2^r, of both directions independently.
fn candidate(round: usize, index: usize, best: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
    if round > 0 {
        let directions = BESIDE as usize;
        let distance = LATER_REACH / f64::from(1_u32 << round);
        let own = [index / directions, index % directions];
        return [0, 1].map(|side| beside(best[side], own[side], directions - 1, distance));
    }
    let [all, still, around] = [STARTS, STILL_STARTS, TURNED_STARTS].map(|count| count as usize);
    if index < still {
        return [spread(index, still); 2];
    }
    let turned = index - still;
    let earlier = spread(turned / around, (all - still) / around);
    [earlier, beside(earlier, 1 + turned % around, around, AROUND.into())]
}

/// The directions under which tones leave least unexplained. In the first round of 16, later of 32 steps, solved for twice;
/// the first of equally good ones. Rounds 0 and 1 have the first places, the others the few. In the first, a light that turns must
/// leave a ninth less than one that stays.
pub fn search([_, few, first]: &[Vec<Site>; 3]) -> [[f64; 3]; 2] {
    let mut best = [[0.0; 3]; 2];
    for (round, count) in LIGHT_CANDIDATES.into_iter().enumerate() {
        let places = if (round as u32) < FIRST_SEARCHES { first } else { few };
        let steps = if round == 0 { FIRST_STEPS } else { SEARCH_STEPS } as usize;
        let cost = |index: usize| {
            let lights = candidate(round, index, best);
            let tones = solve(places, lights, steps, SEARCHING);
            let left = |site: &Site| site.weight * badness(residual(site, steps_at(site, lights, steps), &tones));
            let left: u32 = places.iter().map(left).sum();
            if round == 0 && index >= STILL_STARTS as usize { left + left / 8 } else { left }
        };
        let index = (0..count as usize).min_by_key(|index| cost(*index)).unwrap_or(0);
        best = candidate(round, index, best);
    }
    best
}

impl Tones {
    /// Learns from both frames.
    pub fn learn(surface: &Surface, frames: [&Frame; 2]) -> Tones {
        let sites = sites(surface, frames);
        let lights = search(&sites);
        let brightest = f64::from(scale(frames[0].shown()).max(scale(frames[1].shown())));
        Tones::under(&sites[0], lights, brightest)
    }

    /// The tones under lights: those common to all places; then of each surface what its own depart from these by, solved
    /// for in the same way, so that a surface of which little is seen has the common ones.
    fn under(sites: &[Site], lights: [[f64; 3]; 2], brightest: f64) -> Tones {
        let steps = TONE_STEPS as usize;
        let tones = solve(sites, lights, steps, FINDING);
        let (own, surfaces) = (BTreeMap::new(), BTreeMap::new());
        let mut found = Tones { lights, tones, own, unexplained: [0; 2], surfaces, brightest };
        let mut by_surface: BTreeMap<u32, Vec<Site>> = BTreeMap::new();
        sites.iter().for_each(|site| by_surface.entry(site.surface).or_default().push(*site));
        for (surface, sites) in by_surface {
            let rest = |site: &Site| {
                let [to, from] = steps_at(site, lights, steps);
                let change = [0, 1, 2].map(|i| site.change[i] - found.tones[to][i] + found.tones[from][i]);
                Site { change, ..*site }
            };
            let rest: Vec<Site> = sites.iter().map(rest).collect();
            let departing = solve(&rest, lights, steps, FINDING);
            let mut sums = [0; 2];
            for (site, rest) in sites.iter().zip(&rest) {
                let left = u64::from(badness(residual(rest, steps_at(rest, lights, steps), &departing)));
                let there = u64::from(badness(changed(site.change)));
                sums = [sums[0] + left, sums[1] + 2 * there + u64::from(ALLOWED)];
                found.unexplained = [found.unexplained[0] + left, found.unexplained[1] + there];
            }
            found.surfaces.insert(surface, sums);
            let own = departing.iter().zip(&found.tones).map(|(own, all)| [0, 1, 2].map(|i| own[i] + all[i])).collect();
            found.own.insert(surface, own);
        }
        found
    }

    /// The logarithm of a surface's tone at a unit normal in frame i (0) or i + 1 (1): that of its step; where the neighbouring
    /// step on its side differs by less than [`EVEN`], linear between the middles of the two.
    fn tone(&self, surface: u32, side: usize, normal: [f64; 3]) -> [f64; 3] {
        let tones = self.own.get(&surface).unwrap_or(&self.tones);
        let steps = tones.len();
        let cosine: f64 = (0..3).map(|i| self.lights[side][i] * normal[i]).sum();
        let nearest = step(self.lights[side], normal, steps);
        let beside = (cosine * 0.5 + 0.5) * steps as f64 - (nearest as f64 + 0.5);
        let next = if beside < 0.0 { nearest.saturating_sub(1) } else { (nearest + 1).min(steps - 1) };
        let (own, next) = (tones[nearest], tones[next]);
        let way = [0, 1, 2].map(|i| next[i] - own[i]);
        let is_even = way.iter().map(|c| c.abs()).sum::<i32>() < EVEN;
        let share = if is_even { beside.abs().min(0.5) } else { 0.0 };
        [0, 1, 2].map(|i| f64::from(own[i]) + share * f64::from(way[i]))
    }

    /// Whether colours of a surface follow from tones: of all places, these explain at least a quarter of what changes; of
    /// the surface's they do not leave more than may be. That is generous, for a surface may show few places that change,
    /// but one that has no tones is found: what glows, or shines.
    pub fn explains(&self, surface: u32) -> bool {
        let [left, most] = self.surfaces.get(&surface).copied().unwrap_or_default();
        4 * self.unexplained[0] <= 3 * self.unexplained[1] && left <= most
    }

    /// The colour in frame i (0) or i + 1 (1), `hidden`, of a place that only the other one shows, in colour `known`: red,
    /// green and blue, plus `LEAST_COLOUR`, times the tone at the normal in the one by that at the normal in the other,
    /// less it; from 0 to the [`scale`] of the images, or `known` if that is brighter. Alpha stays. None where a normal has
    /// no direction or tones do not explain the surface's colours.
    pub fn predict(&self, surface: u32, hidden: usize, normals: [[f64; 3]; 2], known: Colour) -> Option<Colour> {
        let (there, here) = (unit(normals[hidden])?, unit(normals[1 - hidden])?);
        if !self.explains(surface) {
            return None;
        }
        let (to, from) = (self.tone(surface, hidden, there), self.tone(surface, 1 - hidden, here));
        let channel = |i: usize| {
            let value = (known[i].max(0.0) + ADDED) * ((to[i] - from[i]) / f64::from(LOGARITHM)).exp() - ADDED;
            value.clamp(0.0, self.brightest.max(known[i]))
        };
        Some([channel(0), channel(1), channel(2), known[3]])
    }
}

#[cfg(test)]
mod tests;
