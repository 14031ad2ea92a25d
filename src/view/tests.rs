use glam::{DMat3, DMat4, DQuat, DVec2, DVec3, DVec4};

use super::*;
use crate::random::{hash, unit};

const SIZE: [u32; 2] = [160, 90];

fn draw(index: u32, dimension: u32) -> f64 {
    f64::from(unit(hash(3, index, 0, dimension)))
}

/// A rotation and a translation; every other one is mirrored.
fn motion(index: u32) -> DMat4 {
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 7.0 * draw(index, 0), 7.0 * draw(index, 1), 7.0 * draw(index, 2));
    let mirror = DMat3::from_diagonal(DVec3::new(if index.is_multiple_of(2) { 1.0 } else { -1.0 }, 1.0, 1.0));
    let place = 10.0 * DVec3::new(draw(index, 3), draw(index, 4), draw(index, 5)) - 5.0;
    DMat4::from_mat3_translation(DMat3::from_quat(turn) * mirror, place)
}

/// Every kind of projection: either handedness, either direction of depth, y up or down, off-centre, with pixels that are not square,
/// turned about the axis, and in any scale.
fn views() -> impl Iterator<Item = View> {
    (0..256).map(|index: u32| {
        let bit = |place: u32| if index >> place & 1 == 1 { -1.0 } else { 1.0 };
        let (is_orthographic, is_infinite, reversed) = (index & 32 != 0, index & 64 != 0, index & 128 != 0);
        let (near, far) = (0.3 + draw(index, 6), 7.0 + 20.0 * draw(index, 7));
        let (at_near, at_far) = if reversed { (1.0, 0.0) } else { (0.0, 1.0) };
        let ahead = bit(1);
        let depth = match (is_orthographic, is_infinite) {
            (true, _) => {
                let factor = (at_far - at_near) / (far - near);
                DVec4::new(0.0, 0.0, factor * ahead, at_near - factor * near)
            }
            (false, true) => DVec4::new(0.0, 0.0, at_far * ahead, near * (at_near - at_far)),
            (false, false) => {
                let offset = (at_far * far - at_near * near) / (far - near);
                DVec4::new(0.0, 0.0, offset * ahead, near * (at_near - offset))
            }
        };
        let (sin, cos) = if index & 16 != 0 { (6.0 * draw(index, 8)).sin_cos() } else { (0.0, 1.0) };
        let [x, y] = [1.2, 1.9].map(|scale| scale + 0.3 * draw(index, 9));
        let moved = 0.7 * DVec2::new(draw(index, 10) - 0.5, draw(index, 11) - 0.5);
        let off = |moved: f64| if is_orthographic { (0.0, moved) } else { (moved * ahead, 0.0) };
        let row = |a: f64, b: f64, (c, d): (f64, f64)| DVec4::new(a, b, c, d);
        let across = row(x * cos, x * sin, off(moved.x));
        let down = row(-y * bit(2) * sin, y * bit(2) * cos, off(moved.y));
        let w = if is_orthographic { DVec4::W } else { DVec4::Z * ahead };
        let scale = 0.5 + 3.0 * draw(index, 12);
        View {
            world_to_view: motion(index),
            view_to_clip: (scale * DMat4::from_cols(across, down, depth, w)).transpose(),
            jitter: [draw(index, 13) - 0.5, draw(index, 14) - 0.5],
            reversed,
        }
    })
}

/// A place of the world that is seen, by clip coordinates.
fn seen(view: &View, x: f64, y: f64, depth: f64) -> DVec3 {
    (view.view_to_clip * view.world_to_view).inverse().project_point3(DVec3::new(x, y, depth))
}

#[test]
fn a_view_taken_apart_sees_what_its_matrices_see() {
    for (index, view) in (0..).zip(views()) {
        let projection = Projection::new(&view, SIZE).unwrap_or_else(|error| panic!("{index}: {error}"));
        assert!((projection.axes * projection.axes.transpose() - DMat3::IDENTITY).abs_diff_eq(DMat3::ZERO, 1e-12));
        for k in 0..12 {
            let [x, y] = [20, 21].map(|d| 2.0 * draw(100 * index + k, d) - 1.0);
            let stored = 0.02 + 0.96 * draw(100 * index + k, 22);
            let position = seen(&view, x, y, stored);
            let place = projection.to_view(position);
            let expected = (DVec2::new(x, y) + 1.0) * DVec2::new(80.0, 45.0) + DVec2::from_array(view.jitter);
            // The inverse of a matrix in f64, at depths up to some hundred metres.
            let off = (projection.pixel_of(place) - expected).length();
            assert!(off < 1e-8, "{index}: {off} pixels");
            let by = if projection.is_orthographic { place.z } else { place.z.recip() };
            let held = projection.depth_terms[0] + projection.depth_terms[1] * by;
            assert!((held - stored).abs() < 1e-9, "{index}: {held} {stored}");
            assert!(place.z > projection.near && place.z < projection.far && projection.near > 0.0);
            let [from, way] = projection.ray_at(expected);
            assert!((from + way * place.z - place).length() < 1e-8 * place.length(), "{index}: {place}");
        }
    }
}

#[test]
fn triangles_turn_over_in_mirrored_views_alone() {
    for (index, view) in (0..).zip(views()) {
        let projection = Projection::of_valid(&view, SIZE);
        let corners = [[0.1, 0.1], [0.4, 0.1], [0.1, 0.4]].map(|[x, y]| seen(&view, x, y, 0.5));
        // Towards the eye if it runs counter-clockwise from there.
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let [from, way] = projection.ray_at(DVec2::new(100.0, 50.0));
        let to_place = projection.axes.transpose() * way;
        let is_towards = normal.dot(to_place) < 0.0;
        // In pixels, y down, those corners run clockwise.
        assert_eq!(is_towards, projection.is_mirrored(), "{index} {from}");
    }
}

#[test]
fn the_near_and_far_plane_are_where_depth_says() {
    for (index, view) in (0..).zip(views()) {
        let projection = Projection::of_valid(&view, SIZE);
        let [at_near, at_far] = if view.reversed { [1.0, 0.0] } else { [0.0, 1.0] };
        for (stored, depth) in [(at_near, projection.near), (at_far, projection.far)] {
            if depth.is_finite() {
                let by = if projection.is_orthographic { depth } else { depth.recip() };
                let held = projection.depth_terms[0] + projection.depth_terms[1] * by;
                assert!((held - stored).abs() < 1e-9, "{index}: {held} at {depth}");
            }
        }
        assert!(projection.far.is_finite() || !projection.is_orthographic);
    }
}

#[test]
fn depth_can_go_the_other_way() {
    for view in views() {
        let (one, other) = (Projection::of_valid(&view, SIZE), view.with_reversed(!view.reversed));
        let other = Projection::new(&other, SIZE).unwrap();
        // 1 less what depth was, rounded once more.
        let same = |a: f64, b: f64| a == b || (a - b).abs() < 1e-9 * a.abs();
        assert!(same(one.near, other.near) && same(one.far, other.far), "{one:?} {other:?}");
        assert!((one.depth_terms[0] + other.depth_terms[0] - 1.0).abs() < 1e-9);
        assert!((one.depth_terms[1] + other.depth_terms[1]).abs() < 1e-9);
        assert_eq!((one.focal, one.centre, one.is_orthographic), (other.focal, other.centre, other.is_orthographic));
    }
}

#[test]
fn a_camera_is_a_view() {
    for far in [100.0, f64::INFINITY] {
        let camera =
            Camera { eye: DVec3::new(0.3, 2.0, -7.0), up: DVec3::new(0.2, 1.0, 0.0), far, ..Camera::default() };
        let projection = Projection::new(&camera.view(SIZE), SIZE).unwrap();
        assert!(projection.axes.abs_diff_eq(camera.rotation(), 1e-15) && projection.eye.abs_diff_eq(camera.eye, 1e-14));
        assert!((projection.near - camera.near).abs() < 1e-15);
        assert!(projection.far == far || (projection.far / far - 1.0).abs() < 1e-12);
        let [low, high] = projection.borders(SIZE);
        let half = camera.half_extent(SIZE);
        assert!((high.x - half.x).abs() < 1e-15 && (low.y - half.y).abs() < 1e-15 && !projection.is_mirrored());
    }
}

#[test]
fn what_is_no_view_is_refused_by_name() {
    let good = Camera::default().view(SIZE);
    let said = |view: View| view.validate().expect_err("it is refused").to_string();
    let with_motion = |change: fn(&mut DMat4)| {
        let mut view = good;
        change(&mut view.world_to_view);
        said(view)
    };
    for motion in [
        with_motion(|m| *m *= DMat4::from_scale(DVec3::splat(1.001))),
        with_motion(|m| m.x_axis.y += 0.01),
        with_motion(|m| m.x_axis.w = 0.5),
        with_motion(|m| m.w_axis.x = f64::NAN),
        with_motion(|m| m.w_axis.x = 1e14),
    ] {
        assert!(motion.starts_with("view.world_to_view = "), "{motion}");
    }
    let with_clip = |change: fn(&mut DMat4)| {
        let mut view = good;
        change(&mut view.view_to_clip);
        said(view)
    };
    for clip in [
        with_clip(|m| m.w_axis.w = 1.0),
        with_clip(|m| m.x_axis.w = 0.1),
        with_clip(|m| m.x_axis.z = 0.1),
        with_clip(|m| m.x_axis.y = 0.1),
        with_clip(|m| m.w_axis.x = 0.1),
        with_clip(|m| m.x_axis = DVec4::ZERO),
        with_clip(|m| m.z_axis.z = f64::INFINITY),
        with_clip(|m| *m = DMat4::ZERO),
        with_clip(|m| m.w_axis.z = 0.0),
    ] {
        assert!(clip.starts_with("view.view_to_clip = "), "{clip}");
    }
    assert!(said(View { reversed: false, ..good }).contains("view.reversed"));
    for jitter in [[17.0, 0.0], [0.0, f64::NAN]] {
        assert!(said(View { jitter, ..good }).starts_with("view.jitter = "));
    }
}

/// As hosts have them that work in single precision.
#[test]
fn rotations_in_single_precision_are_taken_as_what_they_mean() {
    for view in views() {
        let rounded = View { world_to_view: view.world_to_view.as_mat4().as_dmat4(), ..view };
        let [exact, rounded] = [view, rounded].map(|view| Projection::new(&view, SIZE).expect("a view"));
        assert!((rounded.axes * rounded.axes.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-14));
        assert!(exact.axes.abs_diff_eq(rounded.axes, 1e-6));
    }
}

#[test]
fn cameras_and_lights_beyond_what_floats_hold_are_refused_by_name() {
    let usual = Camera::default();
    let refused = |camera: Camera| camera.validate().expect_err("it is refused").to_string();
    for fov in [1e-30, 1e-10, 0.0, -1.0, 180.0, 180.0 - 1e-10, f64::NAN] {
        assert!(refused(Camera { vertical_fov: fov, ..usual }).contains("camera.vertical_fov"));
    }
    for near in [0.0, 1e-30, 1e13, f64::INFINITY, f64::NAN] {
        assert!(refused(Camera { near, far: f64::INFINITY, ..usual }).contains("camera.near"));
    }
    assert!(refused(Camera { eye: DVec3::splat(1e300), ..usual }).contains("camera.eye"));
    let ends = [(NARROWEST, 1e-9), (WIDEST, f64::from(FARTHEST))];
    for (vertical_fov, near) in ends {
        let camera = Camera { vertical_fov, near, far: f64::INFINITY, ..usual };
        assert!(camera.validate().is_ok() && camera.view(SIZE).validate().is_ok());
    }
    let light = |source| Light { source, ambient: 0.0, ..Light::default() };
    for way in [DVec3::ZERO, DVec3::splat(1e200), DVec3::splat(1e-200), DVec3::NAN] {
        assert!(light(LightSource::Direction(way)).validate().is_err(), "{way}");
    }
    assert!(light(LightSource::Position(DVec3::splat(1e20))).validate().is_err());
    let why = |light: Light| light.validate().expect_err("wrong").to_string();
    assert!(why(Light { fill: 1.5, ..Light::default() }).contains("light.fill"));
    assert!(why(Light { up: DVec3::ZERO, ..Light::default() }).contains("light.up"));
}

#[test]
fn filled_light_keeps_white_and_gives_form_to_what_is_dark() {
    let light = |fill| Light { ambient: 0.25, fill, ..Light::default() };
    // Without a fill it is the papers'.
    for (facing, arriving, up, expected) in [(0.5, 1.0, 0.3, 0.625), (0.5, 0.5, 1.0, 0.4375), (-0.7, 1.0, 1.0, 0.25)] {
        assert!((light(0.0).luminance(facing, arriving, up) - expected).abs() < 1e-15);
    }
    for fill in [0.2, 0.35, 1.0] {
        let luminance = |facing, arriving, up| light(fill).luminance(facing, arriving, up);
        assert!((luminance(1.0, 1.0, 1.0) - 1.0).abs() < 1e-15);
        assert!((luminance(-1.0, 1.0, -1.0) - 0.25).abs() < 1e-15);
        assert!(luminance(-0.5, 1.0, 0.5) > luminance(-0.5, 1.0, -0.5) + 0.15 * fill, "above is lighter");
        assert!(luminance(-0.2, 1.0, 0.0) > luminance(-0.8, 1.0, 0.0) + 0.05 * fill, "it wraps around");
        // Where shadow ends in a surface's own dark nothing jumps.
        assert!((luminance(1e-9, 0.0, 0.4) - luminance(-1e-9, 1.0, 0.4)).abs() < 1e-9);
    }
}

#[test]
fn more_light_takes_its_share_of_what_is_missing_to_white() {
    let second = |strength| Some(SecondLight { source: LightSource::Direction(DVec3::X), strength });
    let light = Light { rim: 0.5, second: second(0.4), ..Light::default() };
    assert!((light.with_second(0.5, 0.5) - 0.6).abs() < 1e-15);
    assert_eq!([light.with_second(0.5, -0.5), light.with_second(1.0, 1.0)], [0.5, 1.0]);
    // Seen from ahead, from beside towards the light, and away from it.
    assert_eq!([(-1.0, 1.0), (1.0, 0.0), (-1.0, 0.0)].map(|(d, v)| Light::turned_away(d, v)), [0.0, 0.0, 1.0]);
    assert!((Light::turned_away(0.0, 0.5) - 0.0625).abs() < 1e-15);
    for (away, expected) in [(0.0, 0.5), (0.06, 0.5), (0.11, 0.625), (0.16, 0.75), (1.0, 0.75)] {
        // The borders are single floats.
        assert!((light.with_rim(0.5, away) - expected).abs() < 1e-6);
    }
    let none = Light::default();
    assert_eq!((none.with_second(0.3, 1.0), none.with_rim(0.3, 1.0)), (0.3, 0.3));
    let why = |light: Light| light.validate().expect_err("wrong").to_string();
    assert!(why(Light { rim: 1.5, ..none }).starts_with("light.rim"));
    assert!(why(Light { second: second(-0.1), ..none }).starts_with("light.second.strength"));
    let nowhere = SecondLight { source: LightSource::Direction(DVec3::ZERO), strength: 0.5 };
    assert!(why(Light { second: Some(nowhere), ..none }).starts_with("light.second.direction"));
    let fire = FireLight { position: DVec3::ZERO, colour: [1.0; 3], reach: 2.0 };
    assert!(fire.validate().is_ok() && fire.falloff(2.0) == 0.5 && fire.falloff(0.0) == 1.0);
    assert!(FireLight { reach: 0.0, ..fire }.validate().is_err());
    assert!(FireLight { colour: [f32::NAN; 3], ..fire }.validate().is_err());
    assert!(FireLight { position: DVec3::splat(1e13), ..fire }.validate().is_err());
}

/// Where lenses that are shifted, wide pixels and views without perspective see a place.
#[test]
fn a_camera_s_lens_is_as_it_says() {
    let eye = DVec3::new(0.0, 1.0, 4.0);
    let camera = Camera { eye, target: DVec3::Y, vertical_fov: 90.0, ..Camera::default() };
    let size = [400, 200];
    // 2 m ahead, 1 m to the right and half a metre up.
    let place = |camera: &Camera| {
        let clip = (camera.view(size).view_to_clip * camera.view(size).world_to_view) * DVec4::new(1.0, 1.5, 2.0, 1.0);
        let [x, y] = [clip.x, clip.y].map(|c| 0.5 + 0.5 * c / clip.w);
        [400.0 * x, 200.0 * y]
    };
    let near = |a: [f64; 2], b: [f64; 2]| assert!((0..2).all(|i| (a[i] - b[i]).abs() < 1e-9), "{a:?} {b:?}");
    near(place(&camera), [250.0, 75.0]);
    // The picture's middle goes right and up by a quarter and half of its height: what is seen the other way.
    let shift = DVec2::new(0.25, 0.5);
    near(place(&Camera { shift, ..camera }), [200.0, 175.0]);
    // Twice as wide as they are high: what is seen is twice as wide.
    near(place(&Camera { pixel_aspect: 2.0, ..camera }), [225.0, 75.0]);
    near(place(&Camera { pixel_aspect: 2.0, shift, ..camera }), [200.0, 175.0]);
    let parallel = Camera { orthographic: Some(4.0), ..camera };
    near(place(&parallel), [250.0, 75.0]);
    near(place(&Camera { shift, ..parallel }), [200.0, 175.0]);
    let projection = Projection::new(&parallel.view(size), size).expect("a view");
    assert!(projection.is_orthographic && (projection.far - projection.near - 99.9).abs() < 1e-9, "{projection:?}");
    let why = |camera: Camera| camera.validate().expect_err("wrong").to_string();
    assert!(why(Camera { far: f64::INFINITY, ..parallel }).starts_with("camera.far"));
    assert!(why(Camera { shift: DVec2::new(0.0, f64::NAN), ..camera }).starts_with("camera.shift"));
    assert!(why(Camera { pixel_aspect: 0.0, ..camera }).starts_with("camera.pixel_aspect"));
    assert!(why(Camera { orthographic: Some(0.0), ..camera }).starts_with("camera.orthographic"));
}
