use super::*;
use crate::io::scene::Clock;
use crate::simulate::mesh::Builtin;
use crate::view::Camera;
use glam::DVec3;

fn input(settings: &Settings, camera: impl Fn(f64) -> Camera + Send + 'static) -> BlurInput {
    let scene = AnimatedMesh::builtin(Builtin::Run, 500, Clock { first: 1, fps: 24.0 });
    let view = move |frame: f64| camera(frame).view([64, 64]);
    BlurInput::new(scene, view, [1, 40], settings, [64, 64], 1).expect("a runner")
}

fn camera(angle: f64) -> Camera {
    let target = DVec3::new(0.0, 1.0, 0.0);
    Camera { eye: target + 4.0 * DVec3::new(angle.sin(), 0.0, angle.cos()), target, ..Camera::default() }
}

/// Beside a cut there is no smear, no spline that goes through it, and nothing of another shot to look into: whether it is
/// given or found.
#[test]
fn nothing_is_known_of_what_is_behind_a_cut() {
    let cut_camera = |frame: f64| camera(if frame < 12.0 { 0.0 } else { 0.7 });
    let never = Settings { jump: 0.0, ..Settings::default() };
    let given = input(&never, |_| camera(0.0)).cut_at(&[12]);
    let found = input(&Settings::default(), cut_camera);
    for mut input in [given, found] {
        let at = |input: &mut BlurInput, frame| input.frame(frame).expect("a frame");
        let moves = |frame: &BlurFrame| !frame.interval.clusters.is_empty();
        let frames = [11, 12, 13].map(|frame| at(&mut input, frame));
        assert_eq!(frames.each_ref().map(moves), [true, false, true]);
        assert_eq!(frames[0].outer_images(), [Some(9), None]);
        assert_eq!(frames[2].outer_images(), [None, Some(14)]);
        for (frame, own) in [(&frames[0], 0..=11), (&frames[2], 12..=40)] {
            let knots = frame.knots.as_ref().expect("knots");
            assert!(knots.iter().all(|knot| own.contains(&knot.view.frame)), "{knots:?}");
        }
    }
    let mut uncut = input(&never, cut_camera);
    assert!(!uncut.frame(12).expect("a frame").interval.clusters.is_empty());
}

/// As many poses are read as trajectories need, and no more.
#[test]
fn poses_are_read_until_enough_of_what_moves_differ() {
    for turn in [0.0, 0.01] {
        let mut input = input(&Settings { jump: 0.0, ..Settings::default() }, move |frame| camera(turn * frame));
        let frame = input.frame(2).expect("a frame");
        assert_eq!(frame.poses.len(), 2 + WINDOW);
    }
}
