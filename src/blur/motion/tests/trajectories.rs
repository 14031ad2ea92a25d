//! Splines through poses, against those of the reference.

use super::*;

fn path_of(interval: &Interval, point: usize, on_screen: bool) -> (Vec<Piece>, bool) {
    let points = interval.motion.len();
    ((0..interval.segments.len()).map(|s| interval.pieces[s * points + point]).collect(), on_screen)
}

/// Compares all points with the reference: offsets from frame i to 1e-4 pixels, motion to rounding.
fn check_trajectories(shot: &Shot, settings: &Settings, frame: usize, times: &[f32]) {
    let on_screen = settings.space == Space::Screen;
    let interval = shot.interval(settings, frame);
    let mut known = shot.clone();
    if settings.trajectory == Trajectory::Past {
        known.poses.truncate(frame + 2);
        known.cameras.truncate(frame + 2);
        assert_eq!(known.interval(settings, frame), interval, "what comes changes nothing");
    }
    for point in 0..shot.mesh.points() {
        let exact =
            |time: f32| known.exact_along(settings.trajectory, point, frame as f64 + f64::from(time), on_screen);
        let [x, y, vx, vy] = interval.motion[point].map(f64::from);
        let at = exact(settings.reference_time);
        assert!((DVec2::new(x, y) - at.position).abs().max_element() < 1e-4, "{x} {y} {at:?}");
        assert!((DVec2::new(vx, vy) - at.velocity).abs().max_element() < 1e-4, "{vx} {vy} {at:?}");
        let (pieces, on_screen) = path_of(&interval, point, on_screen);
        let path = path::Path { segments: &interval.segments, pieces: &pieces, on_screen };
        for time in times {
            let moved = DVec2::from_array(path.moved(*time).map(f64::from));
            let expected = exact(*time).position - exact(0.0).position;
            assert!((moved - expected).abs().max_element() < 1e-4, "{point} {time}: {moved} {expected}");
        }
    }
}

#[test]
fn trajectories_are_those_of_the_reference() {
    let mut shot = wandering(40);
    for (f, camera) in shot.cameras.iter_mut().enumerate() {
        camera.eye.x = 0.1 * f as f64;
        camera.vertical_fov += 0.2 * f as f64;
    }
    for (settings, frame) in [
        (Settings::default(), 20),
        (Settings { reference_time: 0.0, ..Settings::default() }, 20),
        (Settings { space: Space::Screen, ..Settings::default() }, 14),
    ] {
        check_trajectories(&shot, &settings, frame, &[0.0, 0.25, 0.5, 0.75, 1.0]);
        let still_camera = Shot { cameras: vec![camera(); 40], ..shot.clone() };
        check_trajectories(&still_camera, &settings, frame, &[0.0, 0.3, 1.0]);
    }
}

#[test]
fn ends_and_short_sequences_are_natural() {
    for (frames, frame) in [(2, 0), (3, 0), (3, 1), (4, 1), (30, 0), (30, 28)] {
        check_trajectories(&wandering(frames), &Settings::default(), frame, &[0.0, 0.5, 1.0]);
    }
}

#[test]
fn past_trajectories_know_nothing_of_what_comes() {
    let past = Settings { trajectory: Trajectory::Past, strength: 2.5, ..Settings::default() };
    for frame in [0, 1, 2, 14, 28] {
        for space in [Space::Homogeneous, Space::Screen] {
            check_trajectories(
                &wandering(30),
                &Settings { space, ..past.clone() },
                frame,
                &[-1.4, -0.5, 0.0, 0.5, 1.0],
            );
        }
    }
    let mut on_twos = wandering(30);
    (0..30).for_each(|f| on_twos.poses[f] = on_twos.poses[f / 2 * 2].clone());
    check_trajectories(&on_twos, &past, 19, &[-1.4, -0.5, 0.0, 0.5, 1.0]);
}

#[test]
fn strength_above_one_reaches_back_and_goes_on_straight() {
    let settings = Settings { strength: 3.5, ..Settings::default() };
    for (frame, segments) in [(20, 4), (2, 3), (1, 2), (0, 1)] {
        let shot = wandering(34);
        assert_eq!(shot.interval(&settings, frame).segments.len(), segments);
        check_trajectories(&shot, &settings, frame, &[1.0, 0.0, -0.5, -1.0, -1.25, -2.5]);
    }
}

#[test]
fn a_held_pose_is_one_knot() {
    let mut shot = wandering(60);
    // On threes.
    for f in 0..60 {
        shot.poses[f] = shot.poses[f / 3 * 3].clone();
    }
    for frame in [29, 32] {
        check_trajectories(&shot, &Settings { strength: 4.0, ..Settings::default() }, frame, &[0.5, -0.5, -1.5, -2.9]);
    }
    for frame in [30, 31] {
        let interval = shot.interval(&Settings::default(), frame);
        assert!(interval.clusters.is_empty() && interval.labels == [0; 5]);
        for point in 0..5 {
            let [x, y, vx, vy] = interval.motion[point];
            let exact = shot.exact(point, 30.0, false).position;
            assert!((DVec2::new(x.into(), y.into()) - exact).length() < 2e-4 && vx == 0.0 && vy == 0.0);
        }
    }
    // Where the camera moves nothing is held.
    (0..60).for_each(|f| shot.cameras[f].eye.y = 0.1 * f as f64);
    assert!(!shot.interval(&Settings::default(), 30).clusters.is_empty());
}

#[test]
fn sub_frame_poses_are_passed_through() {
    let turn = |p: usize, t: f64| {
        let (y, x) = (1.3 * t + p as f64).sin_cos();
        at_pixel(900.0 + 300.0 * x, 500.0 + 300.0 * y)
    };
    let shot = Shot::new(mesh(3, &[[0, 1, 2]], None), 9, |p, f| turn(p, f as f64));
    let between: Vec<Vec<[f32; 3]>> =
        (1..8).map(|k| (0..3).map(|p| turn(p, 4.0 + f64::from(k) / 8.0)).collect()).collect();
    let view = camera().view(SIZE);
    let between: Vec<Pose> = between.iter().map(|p| Pose { positions: p, view: &view, cut: false }).collect();
    let views = shot.views();
    let poses = shot.poses(&views);
    let window = Window { frame: 4, poses: &poses, current: 4, between: &between };
    let error = |trajectory| {
        let settings = Settings { trajectory, strength: 2.0, ..Settings::default() };
        let interval = Motion::new(&settings, SIZE).unwrap().interval(&shot.mesh, &window, 1).unwrap();
        check_invariants(&shot.mesh, &interval);
        let (pieces, on_screen) = path_of(&interval, 1, false);
        let path = path::Path { segments: &interval.segments, pieces: &pieces, on_screen };
        let errors = (0..=16).map(|k| {
            let (y, x) = (1.3 * (4.0 + f64::from(k) / 16.0) + 1.0).sin_cos();
            let found = DVec2::from_array(path.at(k as f32 / 16.0).position.map(f64::from));
            (found - DVec2::new(900.0 + 300.0 * x, 500.0 + 300.0 * y)).length()
        });
        (errors.fold(0.0, f64::max), interval.segments.len())
    };
    let (exact, segments) = error(Trajectory::Exact);
    assert_eq!(segments, 9);
    assert!(exact < 0.1, "{exact}");
    let (spline, segments) = error(Trajectory::Spline);
    assert_eq!(segments, 2);
    assert!(spline > 1.0, "{spline}");
}

#[test]
fn offsets_are_exact_where_coordinates_are_large() {
    // 10,000 pixels from the corner, while depth changes by a twentieth in a frame: that alone is 500 pixels.
    let shot = Shot::new(mesh(9, &grid(3, 3), None), 30, |p, f| {
        let [x, y, _] = at_pixel(1e4 - 40.0 * p as f64, 9e3 - 7.0 * f as f64 + p as f64);
        [x + 0.2 * f as f32, y, 0.7 * (f as f32 * 0.9).sin()]
    });
    let interval = shot.interval(&Settings::default(), 14);
    let mut worst = 0.0_f64;
    for point in 0..9 {
        let (pieces, on_screen) = path_of(&interval, point, false);
        let path = path::Path { segments: &interval.segments, pieces: &pieces, on_screen };
        for k in 0..=32_u8 {
            let time = f32::from(k) / 32.0;
            let moved = DVec2::from_array(path.moved(time).map(f64::from));
            let exact = shot.exact(point, 14.0 + f64::from(time), false).position;
            worst = worst.max((moved - (exact - shot.exact(point, 14.0, false).position)).abs().max_element());
        }
    }
    assert!(worst < 1e-4, "{worst}");
}
