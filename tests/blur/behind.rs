//! What is drawn behind the mesh: speed lines and after-images.

use celfx::blur::Settings;
use celfx::blur::settings::{Ghosts, Lines};
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
    Ghosts { count: 3, step: 0.5, opacity: 0.6 }
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
    let settings = Settings { ghosts: Ghosts { count: 2, step: 1.0, opacity: 0.6 }, ..plain.clone() };
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
