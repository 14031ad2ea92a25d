//! Splines through resident poses against f64: 1e-4 pixels for what is off from frame i.

use celfx::blur::motion::{Motion, Pose, Window};
use celfx::blur::settings::{Space, Trajectory};
use celfx::blur::{Desc, Settings};
use celfx::low_level::blur::params::Piece;

use crate::common::blur::{BlurRig, Shot, desc, incomplete};
use crate::common::scenes::random;
use crate::common::views;
use crate::scenes::{Animation, Change, grid, interval, natural, spline, swing};

/// What a piece is off from frame i in pixels, as the device computes it.
fn offset(start: [f32; 4], piece: &Piece, first: bool, screen: bool, u: f32) -> [f32; 2] {
    let c = 1.0 - u;
    let (from, to) = ((c * c * c - c) / 6.0, (u * u * u - u) / 6.0);
    let off = [0, 1, 2].map(|k| {
        let origin = if first { 0.0 } else { piece.origin[k] };
        origin + u * piece.step[k] + from * piece.bend_begin[k] + to * piece.bend_end[k]
    });
    match screen {
        true => [off[0], off[1]],
        false => [0, 1].map(|k| (off[k] - start[k] / start[2] * off[2]) / (start[2] + off[2])),
    }
}

/// The largest difference of what is off from frame i from f64, over points and times, in pixels.
fn worst(animation: &Animation, sides: [u32; 2], i: usize, space: Space) -> Option<f64> {
    let screen = space == Space::Screen;
    let mesh = grid(sides);
    let settings = Settings { space, strength: 3.0, ..incomplete() };
    let desc = Desc { frames_resident: 7, ..desc(animation.size, &mesh, settings) };
    let segments = desc.segments as usize;
    let mut rig = BlurRig::new(Desc { frames_resident: animation.poses.len() as u32, ..desc }, mesh)?;
    let labels = vec![1; animation.poses[0].len()];
    let interval = interval(animation, i, &labels, 0.5, 8, segments);
    let knots = animation.knots(i, segments);
    let shot = Shot {
        poses: Some((0, &animation.poses)),
        interval: Some(&interval),
        views: animation.views(i),
        knots: Some(&knots),
    };
    rig.frame(&shot).expect("a frame");
    let pieces: Vec<Vec<Piece>> = (0..segments).map(|s| rig.pieces(s)).collect();
    let mut worst = 0.0_f64;
    for point in 0..labels.len() {
        let values = animation.channels(point, screen);
        let bends = natural(&values);
        let pixel = |v: glam::DVec3| if screen { v.truncate() } else { v.truncate() / v.z };
        let start = pieces[0][point].origin;
        for (s, pieces) in pieces.iter().enumerate() {
            for step in 0..=8 {
                let u = step as f32 / 8.0;
                let (exact, _) = spline(&values, &bends, i, f64::from(u) - s as f64);
                let exact = pixel(exact) - pixel(values[i]);
                let found = offset(start, &pieces[point], s == 0, screen, u);
                let error = (exact.x - f64::from(found[0])).abs().max((exact.y - f64::from(found[1])).abs());
                assert!(error.is_finite());
                // Beyond that X and x W, which take most of each other away, are floats that are not finer.
                worst = worst.max(error / (exact.length() / 250.0).max(1.0));
            }
        }
        // Absolute positions to 2 ulp.
        let at = if screen { [start[0], start[1]] } else { [start[0] / start[2], start[1] / start[2]] };
        for (found, exact) in at.into_iter().zip(pixel(values[i]).to_array()) {
            let ulp = f64::from((exact as f32).abs().next_up() - (exact as f32).abs());
            assert!((f64::from(found) - exact).abs() <= 2.0 * ulp, "{found} is not {exact}");
        }
    }
    Some(worst)
}

/// As much as is rendered of pictures in which only trajectories are looked at.
const WINDOW: [u32; 2] = [32, 18];

#[test]
fn offsets_are_those_of_f64() {
    let animation = swing([9, 7], 26, [1920, 1080], 0.5).through_window(WINDOW);
    for space in [Space::Homogeneous, Space::Screen] {
        for i in [3, 12, 24] {
            let Some(worst) = worst(&animation, [9, 7], i, space) else { return };
            eprintln!("{space:?}, frame {i}: {worst:.2e} px");
            assert!(worst < 1e-4, "{space:?}, frame {i}: {worst}");
        }
    }
}

/// Points to 10,000 pixels from the corner, that move by up to 1000 pixels a frame, to the side and in depth.
#[test]
fn offsets_are_exact_far_from_the_picture() {
    let mut animation = swing([9, 7], 26, [1920, 1080], 0.3).through_window(WINDOW);
    for (frame, pose) in animation.poses.iter_mut().enumerate() {
        for (point, position) in pose.iter_mut().enumerate() {
            let point = point as u32;
            let (far, t) = (26.0 * (random(5, point, 0) - 0.5), frame as f32 * 0.2);
            position[0] += far;
            position[2] += 0.05 * (t + random(5, point, 1)).sin();
        }
    }
    for i in [3, 12, 24] {
        let Some(worst) = worst(&animation, [9, 7], i, Space::Homogeneous) else { return };
        eprintln!("far, frame {i}: {worst:.2e} px");
        assert!(worst < 1e-4, "frame {i}: {worst}");
    }
}

/// The device's pieces are the CPU's, over held frames and up to a cut.
#[test]
fn poses_make_the_pieces_of_the_interval() {
    let sides = [9, 7];
    let camera: Change = |view, _| view;
    for (strength, space, trajectory, held, cut, change) in [
        (1.0, Space::Homogeneous, Trajectory::Spline, 0..0, None, camera),
        (3.0, Space::Homogeneous, Trajectory::Spline, 4..7, None, camera),
        (2.0, Space::Screen, Trajectory::Spline, 10..11, Some(13), camera),
        (3.0, Space::Homogeneous, Trajectory::Spline, 0..0, Some(7), camera),
        (3.0, Space::Homogeneous, Trajectory::Past, 4..7, None, camera),
        (2.0, Space::Screen, Trajectory::Past, 0..0, Some(7), camera),
        (2.0, Space::Homogeneous, Trajectory::Spline, 4..7, None, |view, frame| {
            views::jittered(views::moved(view), frame)
        }),
        (2.0, Space::Homogeneous, Trajectory::Spline, 0..0, None, |view, frame| {
            views::jittered(views::parallel_around(views::mirrored(view), 4.0, 3.0), frame)
        }),
        (1.0, Space::Screen, Trajectory::Spline, 0..0, None, |view, _| views::moved(views::parallel(view, 4.0, 3.0))),
    ] {
        let animation = Animation { change, ..swing(sides, 16, [960, 540], 0.3) };
        let (mesh, mut animation) = (grid(sides), animation.through_window(WINDOW));
        for frame in held {
            animation.poses[frame] = animation.poses[frame - 1].clone();
            animation.cameras[frame] = animation.cameras[frame - 1];
        }
        let settings = Settings { strength, space, trajectory, ..incomplete() };
        let seen = animation.all_seen();
        let pose =
            |frame: usize| Pose { positions: &animation.poses[frame], view: &seen[frame], cut: cut == Some(frame) };
        let poses: Vec<Pose> = (0..16).map(pose).collect();
        let i = 8;
        let window = Window { frame: i as u32, poses: &poses, current: i, between: &[] };
        let mut motion = Motion::new(&settings, animation.size).expect("settings");
        let interval = motion.interval(&mesh, &window, 1).expect("an interval");
        let knots = motion.knots(&window).expect("knots");
        let desc = desc(animation.size, &mesh, settings);
        let Some(mut rig) = BlurRig::new(desc, mesh) else { return };
        let shot = Shot {
            poses: Some((0, &animation.poses)),
            interval: Some(&interval),
            views: animation.views(i),
            knots: Some(knots),
        };
        rig.frame(&shot).expect("a frame");
        let (points, screen) = (animation.poses[0].len(), space == Space::Screen || animation.is_parallel());
        let mut worst = 0.0_f32;
        for s in 0..interval.segments.len() {
            for (point, piece) in rig.pieces(s).iter().enumerate() {
                let expected = &interval.pieces[s * points + point];
                let start = interval.pieces[point].origin;
                for u in [0.0, 0.3, 0.5, 1.0] {
                    let [found, expected] = [piece, expected].map(|p| offset(start, p, s == 0, screen, u));
                    worst = worst.max((found[0] - expected[0]).hypot(found[1] - expected[1]));
                }
            }
        }
        eprintln!(
            "strength {strength}, {space:?}, {trajectory:?}: {} segments, {worst:.1e} px",
            interval.segments.len()
        );
        assert!(worst < 1e-4, "strength {strength}, {space:?}, {trajectory:?}: {worst}");
    }
}
