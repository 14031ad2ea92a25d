//! What is drawn behind the mesh: speed lines and after-images.

use celfx::blur::reference::dry::Brush;
use celfx::blur::settings::{GhostKind, Ghosts, Lines};
use celfx::blur::{Cluster, Settings};
use celfx::low_level::blur::layout;
use celfx::simulate::mesh::Builtin;

use crate::scenes::{natural, spline};
use crate::toon::Film;

const SIZE: [u32; 2] = [480, 270];
const I: usize = 9;

fn film(which: Builtin, settings: Settings) -> Option<Film> {
    Film::new(which, 800, SIZE, 4..17, settings, false)
}

fn lines() -> Lines {
    Lines { count: 6, length: 2.0, width: 8.0, ..Lines::default() }
}

fn ghosts() -> Ghosts {
    Ghosts { count: 3, step: 0.5, opacity: 0.6, ..Ghosts::default() }
}

/// Pixels that differ, and pixels deep within the distorted mesh.
fn changes(film: &mut Film, picture: &[[f32; 4]], plain: &[[f32; 4]]) -> (Vec<usize>, Vec<usize>) {
    let names: Vec<u32> = film.rig.layer(layout::DISTORTED_NAMES);
    let width = SIZE[0] as usize;
    let deep = |p: &usize| {
        let near = [0, 1, width, width + 1, 2 * width, 2 * width + 1, 2, width + 2, 2 * width + 2];
        *p > width && near.iter().all(|offset| names.get(p + offset - width - 1).is_some_and(|name| *name > 0))
    };
    let changed = (0..picture.len()).filter(|p| picture[*p] != plain[*p]).collect();
    (changed, (0..picture.len()).filter(deep).collect())
}

#[test]
fn without_opacity_nothing_changes() {
    for strength in [1.0, 0.0] {
        let plain = Settings { strength, ..Settings::default() };
        let unseen = Settings {
            lines: Lines { opacity: 0.0, ..lines() },
            ghosts: Ghosts { opacity: 0.0, ..ghosts() },
            ..plain.clone()
        };
        let (Some(mut plain), Some(mut unseen)) = (film(Builtin::Run, plain), film(Builtin::Run, unseen)) else {
            return;
        };
        assert!(plain.output(I, true) == unseen.output(I, true), "strength {strength}");
        let skipped = |film: &Film, name| film.rig.blur().skipped().any(|(other, _)| other == name);
        assert!(skipped(&plain, "blur.lines") && skipped(&plain, "blur.ghosts"));
        assert!(!skipped(&unseen, "blur.lines") && !skipped(&unseen, "blur.ghosts"));
    }
}

#[test]
fn lines_follow_what_trails() {
    for (which, strength) in [(Builtin::Run, 1.0), (Builtin::Spin, 0.0)] {
        let plain = Settings { strength, ..Settings::default() };
        let settings = Settings { lines: lines(), ..plain.clone() };
        let (Some(mut plain), Some(mut film)) = (film(which, plain), film(which, settings)) else { return };
        let (without, with) = (plain.output(I, true), film.output(I, true));
        assert!(film.output(I, true) == with, "same frame, same bits");
        let (changed, deep) = changes(&mut film, &with, &without);
        assert!(changed.len() > 200 && changed.iter().all(|p| deep.binary_search(p).is_err()), "{}", changed.len());
        // Each changed pixel is near some point's way.
        let vertices = film.rig.vertices();
        let mut ways = vec![false; without.len()];
        let reach = 0.5 * 8.0 * f64::from(SIZE[1]) / 1080.0 + 2.0;
        for (point, vertex) in vertices.iter().enumerate().take(film.mesh.points()) {
            let values = film.animation.channels(point, false);
            let bends = natural(&values);
            for part in 0..=200 {
                let time = f64::from(vertex.time) - 2.0 * f64::from(part) / 200.0;
                let (at, _) = spline(&values, &bends, I, time);
                let (x, y) = (at.x / at.z, at.y / at.z);
                let side = reach.ceil() as i32;
                for (i, j) in (-side..=side).flat_map(|j| (-side..=side).map(move |i| (i, j))) {
                    let (px, py) = (x.floor() as i32 + i, y.floor() as i32 + j);
                    let off = (f64::from(px) + 0.5 - x).hypot(f64::from(py) + 0.5 - y);
                    if off <= reach && (0..SIZE[0] as i32).contains(&px) && (0..SIZE[1] as i32).contains(&py) {
                        ways[(py * SIZE[0] as i32 + px) as usize] = true;
                    }
                }
            }
        }
        let astray = changed.iter().filter(|p| !ways[**p]).count();
        assert_eq!(astray, 0, "of {}", changed.len());
    }
}

#[test]
fn lines_taper() {
    let plain = Settings { strength: 0.0, ..Settings::default() };
    let settings =
        Settings { lines: Lines { count: 1, length: 8.0, width: 40.0, ..Lines::default() }, ..plain.clone() };
    let (Some(mut plain), Some(mut film)) = (film(Builtin::Crossing, plain), film(Builtin::Crossing, settings)) else {
        return;
    };
    let (without, with) = (plain.output(I, true), film.output(I, true));
    // The front bar goes to the right: what trails it is at the left.
    let ink = |x: usize| {
        let column = (0..SIZE[1] as usize).map(|y| y * SIZE[0] as usize + x);
        column.map(|p| without[p][2] - with[p][2]).sum::<f32>()
    };
    let columns: Vec<f32> = (0..SIZE[0] as usize / 2).map(ink).collect();
    let first = columns.iter().position(|ink| *ink > 0.0).expect("a line");
    let end = columns.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map(|(x, _)| x).expect("columns");
    assert!(end > first + 30, "{first} to {end}");
    assert!(columns[first..end].is_sorted(), "it grows steadily: {:?}", &columns[first..end]);
}

#[test]
fn ghosts_are_behind_and_fade() {
    let plain = Settings { strength: 0.0, ..Settings::default() };
    let settings =
        Settings { ghosts: Ghosts { count: 2, step: 1.0, opacity: 0.6, ..Ghosts::default() }, ..plain.clone() };
    let (Some(mut plain), Some(mut film)) = (film(Builtin::Spin, plain), film(Builtin::Spin, settings)) else {
        return;
    };
    let (without, with) = (plain.output(I, true), film.output(I, true));
    assert!(film.output(I, true) == with, "same frame, same bits");
    let (changed, deep) = changes(&mut film, &with, &without);
    assert!(changed.len() > 400 && changed.iter().all(|p| deep.binary_search(p).is_err()), "{}", changed.len());
    // The blades are opaque: alpha tells how much of a ghost there is over the half transparent background.
    let alpha = |a: f32| 0.5 + 0.5 * a;
    let count = |a: f32| changed.iter().filter(|p| (with[**p][3] - alpha(a)).abs() < 1e-3).count();
    assert!(count(0.6) > 100 && count(0.3) > 100, "{} {}", count(0.6), count(0.3));
}

/// Lines that vary are within those that do not: no longer and no broader, and not all of one length.
#[test]
fn lines_vary_within_their_length_and_width() {
    let plain = Settings { strength: 0.0, ..Settings::default() };
    let with = |variation| Settings { lines: Lines { variation, ..lines() }, ..plain.clone() };
    let films = [plain.clone(), with(0.0), with(1.0)].map(|settings| film(Builtin::Crossing, settings));
    let [Some(mut plain), Some(mut even), Some(mut varied)] = films else { return };
    let (without, even, first) = (plain.output(I, true), even.output(I, true), varied.output(I, true));
    let ink = |picture: &[[f32; 4]]| picture.iter().zip(&without).map(|(a, b)| (b[2] - a[2]).abs()).sum::<f32>();
    let (all, some) = (ink(&even), ink(&first));
    // Both length and width are uniform in 0 to 1: a quarter of the area is left on average, of a dozen lines.
    assert!(some > 0.05 * all && some < 0.6 * all, "{some} of {all}");
    assert!(varied.output(I, true) == first, "same frame, same bits");
    assert!(varied.output(I + 1, true) != first);
}

/// Multiples are opaque, and lines are around each: what is changed is ink, or a colour of the mesh's.
#[test]
fn multiples_are_opaque_and_inked() {
    let mut plain = Settings { strength: 0.0, ..Settings::default() };
    plain.toon.outline.colour = [0.0, 1.0, 0.0];
    let ghosts = Ghosts { count: 2, step: 1.0, kind: GhostKind::Multiples, ..Ghosts::default() };
    let settings = Settings { ghosts, ..plain.clone() };
    let (Some(mut plain), Some(mut film)) = (film(Builtin::Spin, plain), film(Builtin::Spin, settings)) else {
        return;
    };
    let (without, with) = (plain.output(I, true), film.output(I, true));
    let (changed, deep) = changes(&mut film, &with, &without);
    assert!(changed.len() > 400 && changed.iter().all(|p| deep.binary_search(p).is_err()), "{}", changed.len());
    // Pixels at borders are covered in part.
    let opaque: Vec<usize> = changed.iter().copied().filter(|p| (with[*p][3] - 1.0).abs() < 1e-3).collect();
    assert!(opaque.len() * 10 > changed.len() * 8, "{} of {}", opaque.len(), changed.len());
    let is_ink = |p: &usize| with[*p][0] < 1e-3 && (with[*p][1] - 1.0).abs() < 1e-3;
    let inked = opaque.iter().filter(|p| is_ink(p)).count();
    assert!(inked > 100 && inked * 2 < opaque.len(), "{inked} of {}", opaque.len());
    // A line surrounds them: where a copy ends at what was there, ink is within its width, which is 0.75 pixels here.
    let width = SIZE[0] as usize;
    let is_open = |p: usize| with[p] == without[p] && without[p][3] < 0.6;
    for p in opaque.iter().filter(|p| [1, width].iter().any(|step| is_open(**p - step) || is_open(**p + step))) {
        assert!(with[*p][1] > 0.45, "pixel {p}: {:?}", with[*p]);
    }
}

/// Which bristles of a dry smear have left something, against f64: what is gone shows what is behind it.
#[test]
fn dry_smears_end_where_their_bristles_do() {
    let wet = Settings { strength: 1.5, ..Settings::default() };
    let dry = Settings { dry: 0.7, ..wet.clone() };
    let (Some(mut wet), Some(mut film)) = (film(Builtin::Run, wet), film(Builtin::Run, dry)) else { return };
    let _ = (wet.output(I, true), film.output(I, true));
    let [whole, left]: [Vec<u32>; 2] = [&mut wet, &mut film].map(|film| film.rig.layer(layout::DISTORTED_NAMES));
    let (vertices, finished) = (film.rig.vertices(), film.rig.finished());
    let interval = film.interval(I);
    let clusters: &[Cluster] = &interval.clusters;
    let brush = Brush {
        dry: 0.7,
        full: 2.0 * 12.0 * f64::from(SIZE[1]) / 1080.0,
        seed: film.rig.desc().seed,
        generation: interval.generation,
    };
    let (mut gone, mut stay) = (0, 0);
    for (pixel, name) in whole.iter().copied().enumerate().filter(|(_, name)| *name > 0) {
        let row = finished[name as usize - 1];
        let corners = [0, 1, 2].map(|i| vertices[row[i] as usize]);
        let at = [(pixel % SIZE[0] as usize) as f64 + 0.5, (pixel / SIZE[0] as usize) as f64 + 0.5];
        let drawn = corners.map(|v| v.drawn.map(f64::from));
        let cross = |p: [f64; 2], q: [f64; 2]| (p[0] - at[0]) * (q[1] - at[1]) - (p[1] - at[1]) * (q[0] - at[0]);
        let parts = [cross(drawn[1], drawn[2]), cross(drawn[2], drawn[0]), cross(drawn[0], drawn[1])];
        let sum: f64 = parts.iter().sum();
        let mean = |of: &dyn Fn(usize) -> f64| (0..3).map(|i| parts[i] / sum * of(i)).sum::<f64>();
        let label = corners[0].cluster;
        if label == 0 || label == u32::MAX || corners.iter().any(|v| v.cluster != label) {
            assert_eq!(left[pixel], name, "what is between clusters stays");
            continue;
        }
        let cluster = &clusters[label as usize - 1];
        let front = mean(&|i| Brush::front(corners[i].k.into(), corners[i].smoothing.into()));
        let back = mean(&|i| {
            let [vx, vy] = corners[i].velocity.map(f64::from);
            (1.0 - f64::from(corners[i].drawn_time)).max(0.0) * vx.hypot(vy)
        });
        let l = mean(&|i| corners[i].l.into());
        // Rasterisers interpolate to a few 1/1000 of what a triangle has; beside that they decide.
        let bristle = Brush::bristle(cluster, l);
        let margin = brush.left(cluster, front, l, back);
        if (bristle - bristle.round()).abs() < 0.02 || margin.abs() < 5e-3 {
            continue;
        }
        assert_eq!(left[pixel] == name, margin > 0.0, "pixel {pixel}: {margin} of {front} {l} {back}");
        *(if margin > 0.0 { &mut stay } else { &mut gone }) += 1;
    }
    assert!(gone > 100 && stay > 1000, "{gone} {stay}");
}
