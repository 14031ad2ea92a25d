//! Frames that the effect draws itself: tones and ink against f64, and what decides that a frame is drawn at all.

use ash::vk;
use celfx::blur::motion::{Motion, Window};
use celfx::blur::reference::texture::Levels;
use celfx::blur::settings::{Ink, Toon};
use celfx::blur::{Background, Interval, Mesh, MeshInput, Settings, Texture, Wrap, texture_rows};
use celfx::effect::Effort;
use celfx::io::scene::{AnimatedMesh, Clock};
use celfx::simulate::mesh::Builtin;
use celfx::toon::{Operator, Outline, Tone};
use celfx::view::{Light, LightSource, Projection, SecondLight};
use glam::{DVec2, DVec3};

use crate::common::blur::{BlurRig, Shot, desc};
use crate::common::scenes::random;
use crate::common::views;
use crate::scenes::{Animation, Change};

pub const GREY: [f32; 4] = [0.1, 0.2, 0.3, 0.5];

/// A builtin mesh, some of its frames, and an effect that draws them.
pub struct Film {
    pub mesh: Mesh,
    pub animation: Animation,
    pub settings: Settings,
    /// Of the file: triangles and colours.
    pub triangles: Vec<[u32; 3]>,
    pub colours: Vec<[f32; 3]>,
    /// The texture of all triangles, and where vertices are in it.
    pub texture: Option<(Levels, Vec<[f32; 2]>)>,
    pub rig: BlurRig,
    light: Light,
}

impl Film {
    /// `turned`: vertices and triangles in the opposite order.
    pub fn new(
        which: Builtin,
        vertices: u32,
        size: [u32; 2],
        frames: std::ops::Range<u32>,
        settings: Settings,
        turned: bool,
    ) -> Option<Film> {
        Film::make(which, vertices, frames, (turned, Effort::Needed), |mesh| celfx::blur::Desc {
            toon: true,
            ..desc(size, mesh, settings)
        })
    }

    /// One whose target has another format.
    pub fn with_format(
        which: Builtin,
        vertices: u32,
        size: [u32; 2],
        frames: std::ops::Range<u32>,
        target_format: vk::Format,
    ) -> Option<Film> {
        Film::make(which, vertices, frames, (false, Effort::Needed), |mesh| celfx::blur::Desc {
            toon: true,
            target_format,
            ..desc(size, mesh, Settings::default())
        })
    }

    /// One of an effect of the test's own.
    pub fn described(
        which: Builtin,
        vertices: u32,
        frames: std::ops::Range<u32>,
        describe: impl FnOnce(&Mesh) -> celfx::blur::Desc,
    ) -> Option<Film> {
        Film::make(which, vertices, frames, (false, Effort::Needed), describe)
    }

    /// One that keeps no layers, and leaves out what a frame does not need, or nothing.
    pub fn without_layers(
        vertices: u32,
        size: [u32; 2],
        frames: std::ops::Range<u32>,
        settings: Settings,
        effort: Effort,
    ) -> Option<Film> {
        Film::make(Builtin::Crossing, vertices, frames, (false, effort), |mesh| celfx::blur::Desc {
            toon: true,
            layers: false,
            ..desc(size, mesh, settings)
        })
    }

    fn make(
        which: Builtin,
        vertices: u32,
        frames: std::ops::Range<u32>,
        (turned, effort): (bool, Effort),
        describe: impl FnOnce(&Mesh) -> celfx::blur::Desc,
    ) -> Option<Film> {
        let scene = AnimatedMesh::builtin(which, vertices, Clock { first: 0, fps: which.fps() });
        let count = scene.vertices();
        let order: Vec<usize> = if turned { (0..count).rev().collect() } else { (0..count).collect() };
        let weld = scene.weld();
        let topology = scene.topology();
        let weld: Vec<u32> = order.iter().map(|v| weld[*v]).collect();
        let objects: Vec<u32> = order.iter().map(|v| topology.object[*v]).collect();
        let normals: Vec<[f32; 3]> = order.iter().map(|v| topology.normal[*v]).collect();
        let colours: Vec<[f32; 3]> = order.iter().map(|v| topology.colour[*v]).collect();
        let place = |v: u32| if turned { count as u32 - 1 - v } else { v };
        let mut triangles: Vec<[u32; 3]> = topology.triangles.iter().map(|t| t.map(place)).collect();
        if turned {
            triangles.reverse();
        }
        let mesh = Mesh::new(&MeshInput {
            vertices: count,
            triangles: &triangles,
            objects: Some(&objects),
            weld: Some(&weld),
            normals: Some(&normals),
            rest: None,
        })
        .expect("a mesh");
        let poses = frames.clone().map(|frame| {
            let pose = scene.pose(f64::from(frame)).expect("a pose");
            mesh.gather(&order.iter().map(|v| pose[*v]).collect::<Vec<_>>()).expect("a pose")
        });
        let cameras = frames.clone().map(|frame| scene.camera(f64::from(frame)).expect("a camera"));
        let desc = describe(&mesh);
        let settings = desc.settings.clone();
        let animation = Animation::new(poses.collect(), cameras.collect(), desc.size);
        let mut rig = BlurRig::with_effort(desc, mesh.clone(), effort)?;
        rig.colours = colours.clone();
        let light = Light::default();
        let mut film = Film { mesh, animation, settings, triangles, colours, texture: None, rig, light };
        film.set_light(light, Background::Clear(GREY));
        Some(film)
    }

    pub fn set_light(&mut self, light: Light, background: Background) {
        self.light = light;
        self.rig.toon = Some((light, background));
    }

    pub fn interval(&self, i: usize) -> Interval {
        let animation = &self.animation;
        let seen = animation.all_seen();
        let window = Window { frame: i as u32, poses: &animation.poses(&seen), current: i, between: &[] };
        let motion = Motion::new(&self.settings, animation.size).expect("settings");
        motion.interval(&self.mesh, &window, 1).expect("an interval")
    }

    /// Output i + 1: from an interval, or as if nothing moved.
    pub fn output(&mut self, i: usize, moves: bool) -> Vec<[f32; 4]> {
        let interval = moves.then(|| self.interval(i));
        let poses = self.rig.steps().is_empty().then_some((0, &self.animation.poses[..]));
        let views = self.animation.views(i);
        let shot = Shot { poses, interval: interval.as_ref(), views, knots: None };
        self.rig.frame(&shot).expect("a frame");
        self.rig.picture()
    }

    /// As [`Film::output`] of what moves, with the mesh and the poses that are there.
    pub fn again(&mut self, i: usize) -> Vec<[f32; 4]> {
        let interval = self.interval(i);
        let views = self.animation.views(i);
        let shot = Shot { poses: None, interval: Some(&interval), views, knots: None };
        self.rig.frame(&shot).expect("a frame");
        self.rig.picture()
    }

    pub fn reasons(&self) -> Vec<&'static str> {
        let skipped = self.rig.blur().skipped();
        skipped.filter(|(name, _)| *name == "blur.toon").map(|(_, reason)| reason).collect()
    }

    /// Unit normals of the corners of each triangle in a frame.
    pub fn normals(&self, frame: usize) -> Vec<[DVec3; 3]> {
        let at = |point: u32| DVec3::from_array(self.animation.poses[frame][point as usize].map(f64::from));
        let area = |t: &u32| {
            let [a, b, c] = self.mesh.triangles()[*t as usize].map(at);
            (b - a).cross(c - a)
        };
        let normal = |group: u32| {
            self.mesh.group_triangles().of(group as usize).iter().map(area).sum::<DVec3>().normalize_or_zero()
        };
        self.mesh.normal_groups().iter().map(|groups| groups.map(normal)).collect()
    }

    /// What each sample of a frame sees.
    fn samples(&self, frame: usize) -> Vec<Seen> {
        let [width, height] = self.animation.size.map(|side| 2 * side as usize);
        let place = |point: &u32| self.animation.pixel(frame, *point as usize);
        let corners: Vec<[DVec3; 3]> = self.mesh.triangles().iter().map(|t| [0, 1, 2].map(|i| place(&t[i]))).collect();
        let (is_mirrored, is_parallel) = (self.animation.is_mirrored(), self.animation.is_parallel());
        let normals = self.normals(frame);
        let mut nearest = vec![(0.0, None, false); width * height];
        for (index, corners) in corners.iter().enumerate() {
            let pixels = corners.map(DVec3::truncate);
            let low = pixels.iter().fold(DVec2::INFINITY, |a, b| a.min(*b));
            let high = pixels.iter().fold(DVec2::NEG_INFINITY, |a, b| a.max(*b));
            for y in (2.0 * low.y - 2.0).max(0.0) as usize..((2.0 * high.y + 2.0).max(0.0) as usize).min(height) {
                for x in (2.0 * low.x - 2.0).max(0.0) as usize..((2.0 * high.x + 2.0).max(0.0) as usize).min(width) {
                    let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / 2.0;
                    let slot = &mut nearest[y * width + x];
                    let [p, q, r] = pixels.map(|pixel| pixel - at);
                    let parts = [q.perp_dot(r), r.perp_dot(p), p.perp_dot(q)];
                    let sides = [(r - q).length(), (p - r).length(), (q - p).length()];
                    let area: f64 = parts.iter().sum();
                    let distance = (0..3).map(|i| parts[i] * area.signum() / sides[i]).fold(f64::INFINITY, f64::min);
                    slot.2 |= distance.abs() < 1.0 / 64.0;
                    let weights =
                        DVec3::from_array([0, 1, 2].map(|i| parts[i] / if is_parallel { 1.0 } else { corners[i].z }));
                    let shares = weights / weights.element_sum();
                    let near = 1.0 / (0..3).map(|i| shares[i] * corners[i].z).sum::<f64>();
                    if distance > 0.0 && near > slot.0 {
                        (slot.0, slot.1) = (near, Some((index, shares, weights.element_sum())));
                    }
                }
            }
        }
        let seen = |(_, found, unsure): &(f64, Option<(usize, DVec3, f64)>, bool)| {
            let Some((index, shares, area)) = *found else { return Seen { unsure: *unsure, ..Seen::default() } };
            self.seen(frame, index, shares, (area > 0.0) != is_mirrored, &normals[index], *unsure)
        };
        nearest.iter().map(seen).collect()
    }

    /// The colour of a place of a triangle in a frame; none where rounding may decide.
    pub fn tone(&self, frame: usize, index: usize, shares: DVec3, normals: &[[DVec3; 3]]) -> Option<[f64; 4]> {
        let place = |point: &u32| self.animation.pixel(frame, *point as usize);
        let corners = [0, 1, 2].map(|i| place(&self.mesh.triangles()[index][i]));
        let [p, q, r] = corners.map(DVec3::truncate);
        let away = ((q - p).perp_dot(r - p) > 0.0) != self.animation.is_mirrored();
        let seen = self.seen(frame, index, shares, away, &normals[index], false);
        (!seen.unsure).then_some(seen.colour)
    }

    fn seen(&self, frame: usize, index: usize, shares: DVec3, away: bool, normals: &[DVec3; 3], unsure: bool) -> Seen {
        let mix = |of: &dyn Fn(usize) -> DVec3| (0..3).map(|i| shares[i] * of(i)).sum::<DVec3>();
        let normal = mix(&|i| normals[i]).normalize_or_zero() * if away { -1.0 } else { 1.0 };
        let point = |i: usize| {
            DVec3::from_array(self.animation.poses[frame][self.mesh.triangles()[index][i] as usize].map(f64::from))
        };
        let towards = |source| match source {
            LightSource::Direction(way) => -way.normalize(),
            LightSource::Position(place) => (place - mix(&point)).normalize(),
        };
        let projection = Projection::of_valid(&self.animation.seen(frame), self.animation.size);
        let eye = if projection.is_orthographic { -projection.axes.row(2) } else { projection.eye - mix(&point) };
        let facing = normal.dot(towards(self.light.source));
        let second = self.light.second.map_or(0.0, |second| normal.dot(towards(second.source)));
        let luminance = self.light.luminance(facing, 1.0, normal.dot(self.light.up.normalize()));
        let away = Light::turned_away(facing, normal.dot(eye.normalize()));
        let luminance = self.light.with_rim(self.light.with_second(luminance, second), away);
        let tones = &self.settings.toon.tones;
        let tone = tones.iter().skip(1).rfind(|tone| luminance >= f64::from(tone.from)).unwrap_or(&tones[0]);
        let near_a_tone = tones.iter().skip(1).any(|tone| (luminance - f64::from(tone.from)).abs() < 1e-4);
        let vertices = self.triangles[index];
        let base = mix(&|i| DVec3::from_array(self.colours[vertices[i] as usize].map(f64::from)));
        let (texture, is_unsure) = self.texture(frame, index, shares);
        let (base, unsure) = (base * texture, unsure || is_unsure);
        let colour = DVec3::from_array(tone.colour.map(f64::from)) * base;
        let object = 1 + self.mesh.triangle_objects()[index];
        Seen { object, colour: colour.extend(1.0).to_array(), unsure: unsure || near_a_tone }
    }

    /// What the texture is at a place of a triangle that a frame sees, and whether rounding may decide that; white without one.
    fn texture(&self, frame: usize, index: usize, shares: DVec3) -> (DVec3, bool) {
        let Some((levels, places)) = &self.texture else { return (DVec3::ONE, false) };
        let place = self.triangles[index].map(|vertex| DVec2::from_array(places[vertex as usize].map(f64::from)));
        let at = |shares: DVec3| shares.x * place[0] + shares.y * place[1] + shares.z * place[2];
        // How many texels a sample has: from where the triangle's plane is seen a little to the right, and down.
        let corners = [0, 1, 2].map(|i| self.animation.pixel(frame, self.mesh.triangles()[index][i] as usize));
        let is_parallel = self.animation.is_parallel();
        let own = (0..3).map(|i| shares[i] * corners[i].z).sum::<f64>();
        let weights =
            DVec3::from_array([0, 1, 2].map(|i| shares[i] * if is_parallel { 1.0 } else { corners[i].z / own }));
        let pixel = (0..3).map(|i| weights[i] * corners[i].truncate()).sum::<DVec2>();
        let seen_at = |pixel: DVec2| {
            let [p, q, r] = corners.map(|corner| corner.truncate() - pixel);
            let parts = DVec3::new(q.perp_dot(r), r.perp_dot(p), p.perp_dot(q));
            let parts = if is_parallel { parts } else { parts / DVec3::from_array(corners.map(|corner| corner.z)) };
            at(parts / parts.element_sum())
        };
        let off = 1e-4;
        let [right, down] =
            [DVec2::X, DVec2::Y].map(|way| (seen_at(pixel + off * way) - seen_at(pixel - off * way)) / (2.0 * off));
        let size = DVec2::from_array(levels.size());
        let texels = 0.25 * (right * size).perp_dot(down * size).abs();
        let (colour, is_unsure) = levels.at(at(shares).to_array(), texels);
        (colour, is_unsure)
    }

    /// The picture of a frame where it is sure, with a line where objects change only.
    fn expected(&self, frame: usize) -> Vec<Option<[f64; 4]>> {
        let samples = self.samples(frame);
        let size = self.animation.size.map(|side| 2 * side as i32);
        let at = |x: i32, y: i32| &samples[(y.clamp(0, size[1] - 1) * size[0] + x.clamp(0, size[0] - 1)) as usize];
        let outline = &self.settings.toon.outline;
        let width = 2.0 * outline.width * self.animation.size[1] as f32 / 1080.0;
        let (width, reach) = (f64::from(width), width.ceil() as i32 - 1);
        let line = |x: i32, y: i32| {
            let own = at(x, y).object;
            own > 0 && [(-1, 1), (1, -1), (-1, -1), (1, 1)].iter().any(|(i, j)| at(x + i, y + j).object != own)
        };
        let sample = |x: i32, y: i32| -> Option<[f64; 4]> {
            let mut opacity: f64 = 0.0;
            for (j, i) in (-reach..=reach).flat_map(|j| (-reach..=reach).map(move |i| (j, i))) {
                let inside = (0..size[0]).contains(&(x + i)) && (0..size[1]).contains(&(y + j));
                let is_line = outline.strength > 0.0 && inside && line(x + i, y + j);
                let share = (width - f64::from(i * i + j * j).sqrt()).clamp(0.0, 1.0);
                opacity = opacity.max(if is_line { share } else { 0.0 });
            }
            let near = (-reach - 1..=reach + 1).flat_map(|j| (-reach - 1..=reach + 1).map(move |i| (i, j)));
            if near.map(|(i, j)| at(x + i, y + j)).any(|seen| seen.unsure && outline.strength > 0.0) || at(x, y).unsure
            {
                return None;
            }
            if at(x, y).object == 0 {
                return Some(GREY.map(f64::from));
            }
            let ink = outline.colour.map(f64::from);
            let colour = at(x, y).colour;
            Some([0, 1, 2, 3].map(|c| if c < 3 { colour[c] * (1.0 - opacity) + ink[c] * opacity } else { 1.0 }))
        };
        let pixel = |index: i32| {
            let (x, y) = (index % (size[0] / 2) * 2, index / (size[0] / 2) * 2);
            let parts = [sample(x, y)?, sample(x + 1, y)?, sample(x, y + 1)?, sample(x + 1, y + 1)?];
            Some([0, 1, 2, 3].map(|c| parts.iter().map(|part| part[c]).sum::<f64>() / 4.0))
        };
        (0..size[0] * size[1] / 4).map(pixel).collect()
    }
}

/// What a sample sees.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// Its object, from 1; 0: none.
    object: u32,
    colour: [f64; 4],
    /// Whether rounding may decide.
    unsure: bool,
}

fn toon(strength: f32, width: f32) -> Toon {
    let tone = |from, colour| Tone::new(from, colour);
    let tones = vec![tone(0.0, [0.2, 0.25, 0.5]), tone(0.4, [0.6, 0.5, 0.5]), tone(0.8, [1.0, 1.0, 0.9])];
    // Widths of the picture's 180 lines.
    let outline = Outline { strength, width: 6.0 * width, colour: [0.02, 0.0, 0.1], operator: Operator::Roberts };
    Toon { tones, ink: Ink::Before, outline }
}

/// A rim, and a second light.
fn more_light(source: LightSource) -> Light {
    Light { rim: 0.8, second: Some(SecondLight { source, strength: 0.4 }), ..Light::default() }
}

#[test]
fn tones_and_ink_are_those_of_f64() {
    let place = LightSource::Position(DVec3::new(1.0, 2.0, 2.5));
    for (which, vertices, strength, width, light) in [
        (Builtin::Crossing, 1500, 0.0, 1.5, Light::default()),
        (Builtin::Run, 1500, 0.0, 1.5, Light { source: place, ambient: 0.1, fill: 0.0, ..Light::default() }),
        (Builtin::Run, 1500, 0.0, 1.5, more_light(place)),
        // So weak that depth alone makes no line; and few triangles, because what is near an edge is not looked at.
        (Builtin::Crossing, 100, 1e-9, 1.0, Light::default()),
        (Builtin::Run, 200, 1e-9, 1.75, Light::default()),
    ] {
        let settings = Settings { toon: toon(strength, width), ..Settings::default() };
        let Some(mut film) = Film::new(which, vertices, [320, 180], 22..26, settings, false) else { return };
        film.set_light(light, Background::Clear(GREY));
        compare_with_f64(&format!("{which:?}, strength {strength}"), &mut film);
    }
}

#[test]
fn tones_and_ink_are_those_of_f64_through_other_views() {
    let changes: [(&str, Change); 3] = [
        ("moved", |view, frame| views::jittered(views::moved(view), frame)),
        ("mirrored", |view, _| views::mirrored(views::squeezed(view))),
        ("orthographic", |view, frame| views::jittered(views::parallel_around(view, 4.0, 3.0), frame)),
    ];
    for (name, change) in changes {
        for (vertices, strength) in [(1500, 0.0), (100, 1e-9)] {
            let settings = Settings { toon: toon(strength, 1.5), ..Settings::default() };
            let film = Film::new(Builtin::Crossing, vertices, [320, 180], 22..26, settings, false);
            let Some(mut film) = film else { return };
            film.animation.change = change;
            compare_with_f64(&format!("{name}, strength {strength}"), &mut film);
            film.set_light(more_light(LightSource::Direction(DVec3::new(1.0, 0.5, 1.0))), Background::Clear(GREY));
            compare_with_f64(&format!("{name}, strength {strength}, more light"), &mut film);
        }
    }
}

fn compare_with_f64(name: &str, film: &mut Film) {
    let picture = film.output(1, false);
    let expected = film.expected(2);
    let (mut looked, mut wrong, mut worst) = (0, 0, 0.0_f64);
    for (found, expected) in picture.iter().zip(&expected) {
        let Some(expected) = expected else { continue };
        let off = (0..4).map(|c| (f64::from(found[c]) - expected[c]).abs()).fold(0.0, f64::max);
        looked += 1;
        wrong += usize::from(off > 1e-5);
        worst = worst.max(off);
    }
    eprintln!("{name}: {looked} pixels, {wrong} differ, at most by {worst:.1e}");
    let covered = expected.iter().flatten().filter(|colour| colour[3] == 1.0).count();
    assert!(looked > 40_000 && covered > 40, "{name}: {looked}, {covered}");
    assert_eq!(wrong, 0, "{name}");
}

/// Textures at each sample, magnified and made smaller, against f64.
#[test]
fn textures_are_those_of_f64() {
    const VERTICES: u32 = 600;
    for (size, wrap, is_nearest, scale) in [
        ([8, 4], [Wrap::Repeat, Wrap::Mirror], false, 1.0),
        ([5, 7], [Wrap::Clamp, Wrap::Repeat], true, 1.3),
        ([256, 64], [Wrap::Mirror, Wrap::Clamp], false, 3.0),
    ] {
        let count = size[0] * size[1];
        let texel = |i: u32| [0, 1, 2].map(|c| (random(7, i, c) * 256.0) as u8);
        let texture = Texture { size, texels: (0..count).map(texel).collect(), wrap, is_nearest };
        let scene =
            AnimatedMesh::builtin(Builtin::Crossing, VERTICES, Clock { first: 0, fps: Builtin::Crossing.fps() });
        let rest = scene.pose(0.0).expect("a pose");
        let places: Vec<[f32; 2]> =
            rest.iter().map(|[x, y, z]| [scale * (x + 0.3 * z) - 0.4, scale * 1.3 * y + 0.2 * x]).collect();
        let mut rows = Vec::new();
        let film = Film::described(Builtin::Crossing, VERTICES, 0..4, |mesh| {
            rows = texture_rows(mesh, std::slice::from_ref(&texture), &vec![Some(0); places.len()], &places);
            let settings = Settings { toon: toon(0.0, 1.0), ..Settings::default() };
            celfx::blur::Desc { toon: true, texture_rows: rows.len() as u32, ..desc([320, 180], mesh, settings) }
        });
        let Some(mut film) = film else { return };
        film.rig.textures = rows;
        film.texture = Some((Levels::new(&texture), places));
        let picture = film.output(1, false);
        let (mut looked, mut worst) = (0, 0.0_f64);
        for (found, expected) in picture.iter().zip(film.expected(2)).filter(|(found, _)| found[3] == 1.0) {
            let Some(expected) = expected else { continue };
            looked += 1;
            worst = (0..3).map(|c| (f64::from(found[c]) - expected[c]).abs()).fold(worst, f64::max);
        }
        eprintln!("{size:?}: {looked} pixels, at most {worst:.1e} off");
        // Texels have 10 bits of their square roots: 1e-3 of light.
        assert!(looked > 1500 && worst < 1.5e-3, "{size:?}: {looked} pixels, {worst} off");
    }
}

#[test]
fn depth_makes_lines_and_slopes_none() {
    let mut settings = Settings { toon: toon(1.0, 1.7), ..Settings::default() };
    settings.toon.outline.operator = Operator::Second;
    let dark = |settings: &Settings| {
        let mut film = Film::new(Builtin::Spin, 1500, [192, 108], 0..4, settings.clone(), false)?;
        let picture = film.output(1, false);
        Some(picture.iter().filter(|c| c[3] > 0.9 && c[0] + c[1] < 0.06).count())
    };
    let Some(second) = dark(&settings) else { return };
    settings.toon.outline.strength = 0.0;
    let none = dark(&settings).expect("a device");
    assert!(second > none + 200 && second < none + 4000, "{second}, {none}");
}
