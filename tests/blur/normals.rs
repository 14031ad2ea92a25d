//! Normals of places where many triangles meet, against f64.

use celfx::blur::{Background, Desc, Settings};
use celfx::low_level::blur::layout;
use celfx::view::{Camera, Light};
use glam::DVec3;

use crate::common::blur::{BlurRig, Shot, desc};
use crate::scenes::{Animation, interval, mesh};

const SIZE: [u32; 2] = [64, 48];

/// Normals of a fan's first point in two frames, on the device and in f64. What comes after the first 20,000 triangles
/// stands steeper. `turned`: triangles in the opposite order.
fn fan(count: u32, turned: bool) -> Option<[[DVec3; 2]; 2]> {
    let mut triangles: Vec<[u32; 3]> = (1..=count).map(|i| [0, i, i + 1]).collect();
    if turned {
        triangles.reverse();
    }
    let pose = |frame: u32| {
        let rim = |i: u32| {
            let (sin, cos) = (i as f32 / (count + 1) as f32 * std::f32::consts::TAU).sin_cos();
            let height = if i > 20_000 { 0.8 + 0.1 * frame as f32 } else { 0.2 };
            [cos + 0.1 * frame as f32, sin, height]
        };
        [[[0.1 * frame as f32, 0.0, 0.0]].to_vec(), (1..=count + 1).map(rim).collect()].concat()
    };
    let poses: Vec<Vec<[f32; 3]>> = (0..4).map(pose).collect();
    let animation = Animation::new(poses, vec![Camera::default(); 4], SIZE);
    let mesh = mesh(count as usize + 2, &triangles);
    let labels: Vec<u32> = (0..count + 2).map(|point| u32::from((1..9).contains(&point))).collect();
    let interval = interval(&animation, 1, &labels, 0.5, 5, 1);
    let desc = Desc { frames_resident: 4, layers: false, toon: true, ..desc(SIZE, &mesh, Settings::default()) };
    let group = mesh.normal_groups()[if turned { count as usize - 1 } else { 0 }][0] as usize;
    let groups = desc.groups as usize;
    let mut rig = BlurRig::new(desc, mesh)?;
    // Drawn frames need normals, and no light has to be found in images.
    rig.toon = Some((Light::default(), Background::Keep));
    let knots = animation.knots(1, 1);
    let poses = Some((0, &animation.poses[..]));
    let shot = Shot { poses, interval: Some(&interval), views: animation.views(1), knots: Some(&knots) };
    rig.frame(&shot).expect("a frame");
    let rows: Vec<[f32; 4]> = rig.read(layout::NORMALS, 2 * groups);
    let exact = |frame: usize| -> DVec3 {
        let at = |point: u32| DVec3::from_array(animation.poses[frame][point as usize].map(f64::from));
        triangles.iter().map(|[a, b, c]| (at(*b) - at(*a)).cross(at(*c) - at(*a))).sum()
    };
    let found = |row: [f32; 4]| DVec3::new(row[0].into(), row[1].into(), row[2].into());
    Some([[found(rows[group]), exact(1)], [found(rows[groups + group]), exact(2)]])
}

#[test]
fn all_triangles_count_however_many_meet() {
    for count in [900, 1024, 1025, 30_000, 70_000] {
        let Some(normals) = fan(count, false) else { return };
        for [found, exact] in normals {
            let off = (found - exact).length() / exact.length();
            eprintln!("{count} triangles: {off:.1e} off");
            // Products of two sides are rounded to 2^-24 of 1, where they are as little as 2^-13.
            assert!(off < 1e-5, "{count} triangles: {found}, not {exact}");
        }
        let turned = fan(count, true).expect("a device");
        let same = (0..2).all(|frame| turned[frame][0] == normals[frame][0]);
        assert!(same, "{count} triangles: sums depend on their order");
    }
}
