//! Trajectories beside cuts, snaps and poses that are held.

use super::*;

/// A part of a shot.
fn part(shot: &Shot, frames: std::ops::Range<usize>) -> Shot {
    Shot { poses: shot.poses[frames.clone()].to_vec(), cameras: shot.cameras[frames].to_vec(), ..shot.clone() }
}

/// What is left of a shot in these frames: the pose of the one, seen through the camera of the other.
fn joined(shot: &Shot, frames: &[(usize, usize)]) -> Shot {
    Shot {
        poses: frames.iter().map(|(pose, _)| shot.poses[*pose].clone()).collect(),
        cameras: frames.iter().map(|(_, camera)| shot.cameras[*camera]).collect(),
        ..shot.clone()
    }
}

fn without_frame(interval: Interval) -> Interval {
    Interval { generation: 0, ..interval }
}

/// Trajectories of the interval from a frame on are those of another shot's.
fn check_same(shot: &Shot, frame: usize, other: &Shot, other_frame: usize) {
    for space in [Space::Homogeneous, Space::Screen] {
        let settings = Settings { space, ..Settings::default() };
        let [found, expected] = [shot.interval(&settings, frame), other.interval(&settings, other_frame)];
        assert!(!expected.clusters.is_empty(), "{frame}: nothing moves");
        assert_eq!(without_frame(found), without_frame(expected), "{frame}");
    }
}

/// A mesh that wanders 1/20 as far, thrown 3.6 metres, a third of the picture, in one frame.
fn snapping(at: usize) -> Shot {
    let mut shot = wandering(30);
    for (f, pose) in shot.poses.iter_mut().enumerate() {
        let thrown = if f >= at { 3.6 } else { 0.0 };
        pose.iter_mut().for_each(|p| *p = [0.05 * p[0] + thrown, 0.05 * p[1], 0.05 * p[2]]);
    }
    shot
}

#[test]
fn what_snaps_is_straight_and_nothing_beside_it_knows_of_it() {
    let shot = snapping(15);
    for frame in [10, 12, 13] {
        check_same(&shot, frame, &part(&shot, 0..15), frame);
    }
    for frame in [15, 16, 20] {
        check_same(&shot, frame, &part(&shot, 15..30), frame - 15);
    }
    check_same(&shot, 14, &part(&shot, 14..16), 0);
    // It is still smeared: it is no cut.
    assert_eq!(shot.interval(&Settings::default(), 14).labels, [1; 5]);
}

/// One of a hundred points is data that is wrong, and not a reason to straighten the others' arcs.
#[test]
fn a_single_point_that_snaps_breaks_nothing() {
    let turning = |p: usize, f: usize| {
        let (y, x) = (0.3 * f as f64 + 0.01 * p as f64).sin_cos();
        at_pixel(900.0 + 200.0 * x, 500.0 + 200.0 * y)
    };
    let even = Shot::new(mesh(100, &grid(10, 10), None), 30, turning);
    let mut one = even.clone();
    (15..30).for_each(|f| one.poses[f][7] = one.poses[f][7].map(|x| x + 4.0));
    let of_others = |shot: &Shot| {
        let pieces = shot.interval(&Settings::default(), 13).pieces;
        pieces.into_iter().enumerate().filter(|(p, _)| *p != 7).map(|(_, piece)| piece).collect::<Vec<_>>()
    };
    assert_eq!(of_others(&one), of_others(&even));
    assert!(of_others(&even).iter().any(|piece| piece.bend_begin[0].abs() > 1.0));
}

#[test]
fn a_snap_of_the_camera_is_one_too() {
    let mut shot = snapping(30);
    for (f, camera) in shot.cameras.iter_mut().enumerate() {
        camera.eye.x = 0.01 * f as f64;
        camera.target.x = if f < 15 { 0.0 } else { 2.0 };
    }
    check_same(&shot, 13, &part(&shot, 0..15), 13);
    check_same(&shot, 15, &part(&shot, 15..30), 0);
    check_same(&shot, 14, &part(&shot, 14..16), 0);
}

/// The case of the file: 1 pixel a frame to the right, and once a third of the picture's height.
#[test]
fn beside_a_snap_the_velocity_has_the_motions_sign() {
    let square = |x: f64, p: usize| at_pixel(x + 50.0 * (p % 2) as f64, 300.0 + 50.0 * (p / 2) as f64);
    let thrown = |f: usize| if f < 4 { 0.0 } else { 360.0 };
    let shot = Shot::new(mesh(4, &grid(2, 2), None), 8, |p, f| square(300.0 + f as f64 + thrown(f), p));
    for frame in 0..7 {
        let expected = if frame == 3 { 361.0 } else { 1.0 };
        for [_, _, vx, vy] in shot.interval(&Settings::default(), frame).motion {
            assert!((vx - expected).abs() < 1e-2 && vy.abs() < 1e-2, "{frame} {vx} {vy}");
        }
    }
}

#[test]
fn what_comes_to_rest_is_a_break_and_what_is_on_twos_is_none() {
    let moving = wandering(12);
    let frames = |list: &[usize]| list.iter().map(|f| (*f, *f)).collect::<Vec<_>>();
    // Stands for five frames.
    let rests = joined(&moving, &frames(&[0, 1, 2, 3, 4, 4, 4, 4, 4, 5, 6, 7, 8]));
    check_same(&rests, 3, &part(&moving, 0..5), 3);
    check_same(&rests, 8, &part(&moving, 4..9), 0);
    assert!(rests.interval(&Settings::default(), 6).clusters.is_empty());
    // On twos, and once on threes.
    let twos = joined(&moving, &frames(&[0, 0, 1, 1, 2, 2, 2, 3, 3, 4, 4, 5, 5]));
    check_same(&twos, 3, &part(&moving, 0..6), 1);
    check_same(&twos, 6, &part(&moving, 0..6), 2);
}

/// Poses on twos under a camera on ones: where the mesh is held the camera alone moves, and where it changes neither stutters.
#[test]
fn poses_on_twos_move_with_the_camera_only() {
    let mut shot = wandering(24);
    for (f, camera) in shot.cameras.iter_mut().enumerate() {
        camera.eye.x = 0.05 * f as f64 * (1.0 + 0.01 * f as f64);
    }
    let on_twos = joined(&shot, &(0..24).map(|f| (f / 2 * 2, f)).collect::<Vec<_>>());
    let held = joined(&shot, &(0..24).map(|f| (10, f)).collect::<Vec<_>>());
    check_same(&on_twos, 10, &held, 10);
    // From frame 11 to frame 12: poses 10 and 12 are those of knots beside each other, and each side has its next.
    let changing: Vec<(usize, usize)> = (0..6).map(|k| (2 * k, 6 + k)).chain((6..12).map(|k| (2 * k, 6 + k))).collect();
    check_same(&on_twos, 11, &joined(&shot, &changing), 5);
}

#[test]
fn fast_motion_on_twos_is_no_cut() {
    let shot = wandering(40);
    let on_twos = Shot::new(mesh(4, &grid(2, 2), None), 12, |p, f| {
        at_pixel(1200.0 * (f / 2) as f64 - 2000.0 + 50.0 * (p % 2) as f64, 300.0 + 50.0 * (p / 2) as f64)
    });
    assert!(!on_twos.interval(&Settings::default(), 5).clusters.is_empty());
    assert!(!shot.interval(&Settings::default(), 5).clusters.is_empty());
}

/// From the front to the side, with the subject in the middle of both: the camera says so.
#[test]
fn a_camera_that_cuts_around_its_subject_is_a_cut() {
    let mut shot = wandering(24);
    let turned = |angle: f64| Camera { eye: DVec3::new(10.0 * angle.sin(), 0.0, 10.0 * angle.cos()), ..camera() };
    (0..24).for_each(|f| shot.cameras[f] = turned(if f < 12 { 0.01 } else { 0.8 } * (1.0 + 0.01 * f as f64)));
    assert!(shot.interval(&Settings::default(), 11).clusters.is_empty());
    assert!(!shot.interval(&Settings { jump: 0.0, ..Settings::default() }, 11).clusters.is_empty(), "never");
    for space in [Space::Homogeneous, Space::Screen] {
        let settings = Settings { space, ..Settings::default() };
        let [found, alone] = [shot.interval(&settings, 12), part(&shot, 12..24).interval(&settings, 0)];
        assert_eq!(without_frame(found), without_frame(alone));
    }
    // A camera that goes around at 25 degrees a frame is none.
    (0..24).for_each(|f| shot.cameras[f] = turned(0.44 * f as f64));
    assert!(!shot.interval(&Settings::default(), 11).clusters.is_empty());
}
