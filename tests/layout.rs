//! Sizes and limits, without a device.
#![cfg(feature = "cli")]

use ash::vk;
use celfx::blur::{self, Blur};
use celfx::effect::{DeviceTraits, Inventory};
use celfx::error::Error;
use celfx::flame::{self, Flame};
use celfx::host::Memory;
use celfx::low_level::shaders::smoke as shaders;
use celfx::low_level::shaders::smoke::constants::BLOCK;
use celfx::low_level::smoke::layout::{self, Layout};
use celfx::low_level::smoke::limits::{LOOP_BUDGET, LUMINANCE_ENTRIES};
use celfx::low_level::smoke::params::{Particle, SLOT_PIXELS, TILE, TILE_BLOCKS};
use celfx::low_level::smoke::search::{Pyramid, growth_rows};
use celfx::smoke::settings::{Emitter, Grow, LINES, Mask, Outline, Radius, RadiusFrom, Shadow};
use celfx::smoke::{Desc, Settings, Shape, Smoke};
use celfx::toon::Tone;

/// Lavapipe's range of a storage buffer; the least that Vulkan allows is 128 MiB, too.
const TRAITS: DeviceTraits = DeviceTraits::LAVAPIPE;
/// Lavapipe ends an invocation's loops after 65,535 iterations in all. What is cut into parts of [`LOOP_BUDGET`] leaves room
/// below this for what leads up to it.
const BUDGET: u64 = 50_000;

fn desc(size: [u32; 2], dimensions: [u32; 3], settings: Settings) -> Desc {
    let new = Desc::new(size, dimensions, settings);
    Desc { lines: Some(LINES), target_format: vk::Format::R8G8B8A8_SRGB, velocity: true, layers: true, ..new }
}

fn many(particles: u32, fade: u32) -> Settings {
    Settings { particles, fade, ..Settings::default() }
}

#[test]
fn sizes_follow_from_counts() {
    let made = desc([200, 150], [33, 20, 10], Settings { mask: Mask::Groups, ..many(500, 6) });
    let layout = Layout::new(&made, &TRAITS).unwrap();
    assert_eq!((layout.spheres, layout.tiles), (3500, [7, 5]));
    assert_eq!(layout.size(layout::PARTICLES), 500 * size_of::<Particle>() as u64);
    assert_eq!(layout.size(layout::SPHERES), 3500 * 16);
    assert_eq!(layout.size(layout::DYING), 3000 * 16);
    assert_eq!(layout.size(layout::DENSITY), 6600 * 4);
    assert_eq!(layout.size(layout::VELOCITY), 6600 * 12);
    assert_eq!(layout.size(layout::PICTURE), 30_000 * 16);
    assert_eq!(layout.size(layout::TILE_GROUPS), 35 * 32);
    // Eight groups, one batch: numerator and denominator for each pixel of each tile.
    assert_eq!((layout.batches, layout.batch_groups), (1, 8));
    assert_eq!(layout.size(layout::ROW_SUMS), 8 * 35 * u64::from(SLOT_PIXELS) * 8);
    assert_eq!(layout.window_blocks, 3, "a window of 24 pixels");
    for buffer in layout.buffers(&made) {
        assert!(buffer.size >= 16 && buffer.size % 16 == 0, "{}: {}", buffer.name, buffer.size);
    }
}

#[test]
fn what_is_switched_off_takes_no_room() {
    let settings = Settings {
        sigma: 0.0,
        shadow: Shadow::None,
        outline: Outline { strength: 0.0, ..Outline::default() },
        ..many(500, 0)
    };
    let off = Desc { layers: false, velocity: false, ..desc([200, 150], [33, 20, 10], settings) };
    let layout = Layout::new(&off, &TRAITS).unwrap();
    for id in [
        layout::VELOCITY,
        layout::DYING,
        layout::CELLS,
        layout::CASTERS,
        layout::SHADOW,
        layout::SMOOTH,
        layout::ROW_SUMS,
        layout::ROW_ITEMS,
        layout::LINES,
        layout::CHANNELS,
        layout::SMOOTH_CHANNELS,
        layout::TONE_LAYER,
        layout::OVERLAY_LAYER,
        layout::MATTE_LAYER,
    ] {
        assert_eq!(layout.size(id), 16, "{id:?}");
    }
    let on = Smoke::memory(&desc([200, 150], [33, 20, 10], many(500, 6)), &TRAITS).unwrap();
    let memory = Smoke::memory(&off, &TRAITS).unwrap();
    assert!(memory.total() < on.total() && memory.history < on.history);
}

#[test]
fn memory_is_what_buffers_and_images_take() {
    for shadow in [Shadow::Exact, Shadow::Map] {
        let desc = Desc { point_light: true, ..desc([64, 64], [8; 3], Settings { shadow, ..many(100, 6) }) };
        let layout = Layout::new(&desc, &TRAITS).unwrap();
        let buffers: u64 = layout.buffers(&desc).iter().map(|buffer| buffer.size).sum();
        let images = layout.images(&desc);
        let pixels = images.iter().map(|i| u64::from(i.extent[0] * i.extent[1] * i.layers)).sum::<u64>();
        assert_eq!(Smoke::memory(&desc, &TRAITS).unwrap().total(), buffers + 4 * pixels);
        assert_eq!(images[2].layers, 6, "a point light has six faces");
    }
}

#[test]
fn groups_go_in_batches_of_64_mib() {
    for (size, groups) in [([1920, 1080], 8), ([1920, 1080], 254), ([64, 64], 254), ([3000, 2700], 20)] {
        // Ranges have a plane of the soft mask more than they are, and pixels need two of them at a time.
        for (mask, summed, least) in [(Mask::Groups, groups, 1), (Mask::Soft, groups + 1, 2)] {
            let settings = Settings { groups, mask, ..many(10, 0) };
            let layout = Layout::new(&desc(size, [8; 3], settings), &TRAITS).unwrap();
            let bytes = layout.size(layout::ROW_SUMS);
            let one = u64::from(layout.tiles[0] * layout.tiles[1] * SLOT_PIXELS) * 8;
            assert!(bytes <= 64 << 20 || bytes == least * one, "{size:?}: {bytes}");
            let added = layout.batches * layout.batch_groups;
            assert!(added >= summed && added - layout.batch_groups < summed, "{size:?}, {mask:?}");
        }
    }
}

/// The error of a description that does not fit.
fn limit(desc: &Desc) -> (&'static str, u64, u64, String) {
    match Smoke::memory(desc, &TRAITS) {
        Err(error @ Error::Limit { what, needed, limit, .. }) => (what, needed, limit, error.to_string()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_too_large_is_refused_by_name() {
    let (what, needed, allowed, text) = limit(&desc([16_384, 16_384], [8; 3], many(10, 0)));
    assert!(what.starts_with("smoke's buffer ") && needed > allowed && allowed == TRAITS.storage_range, "{text}");
    assert!(text.contains("render a smaller picture"), "{text}");
    let (what, needed, _, text) = limit(&desc([64, 64], [8; 3], many(1_000_000, 64)));
    assert!(what.starts_with("smoke's buffer "), "{text}");
    assert!(needed > TRAITS.storage_range && text.contains("fewer particles"), "{text}");
    let (_, needed, allowed, text) = limit(&desc([64, 64], [512; 3], many(10, 0)));
    assert!(needed > allowed && text.contains("use a smaller volume"), "{text}");
    // The pyramid has twelve levels: 2048 rows.
    assert!(Smoke::memory(&desc([64, 64], [1, 2048, 2], many(10, 0)), &TRAITS).is_ok());
    let (what, needed, allowed, _) = limit(&desc([64, 64], [1, 2049, 2], many(10, 0)));
    assert_eq!((what, needed, allowed), ("the volume's height or depth in voxels", 2049, 2048));
    // Workgroups along an axis, on a device whose buffers are large enough.
    let huge = Desc { velocity: false, ..desc([64, 64], [2048; 3], many(10, 0)) };
    match Smoke::memory(&huge, &DeviceTraits { storage_range: u64::MAX, ..TRAITS }) {
        Err(Error::Limit { needed, limit: 65_535, .. }) => assert!(needed > 65_535),
        other => panic!("{other:?}"),
    }
    // Exact shadows may take a coarser grid before they are refused.
    let layout = Layout::new(&desc([64, 64], [8; 3], many(1_000_000, 1)), &TRAITS).unwrap();
    assert_eq!(layout.cells_across, 1);
}

#[test]
fn pyramids_halve_rows_along_y_and_z() {
    let pyramid = Pyramid::new([70, 5, 9]);
    let sizes: Vec<[u32; 2]> = pyramid.levels[..pyramid.count as usize].iter().map(|l| [l.rows_y, l.rows_z]).collect();
    assert_eq!(sizes, [[5, 9], [3, 5], [2, 3], [1, 2], [1, 1]]);
    assert_eq!(pyramid.row_words, 3);
    let words: Vec<u32> = pyramid.levels[..5].iter().map(|l| l.first_word).collect();
    assert_eq!(words, [0, 135, 180, 198, 204]);
    assert_eq!(pyramid.words, 207);
    assert_eq!(pyramid.leaves(), 256);
    assert_eq!((Pyramid::new([1; 3]).count, Pyramid::new([1; 3]).leaves()), (1, 1));
}

/// Iterations of all loops of one invocation, at the worst.
#[test]
fn loops_stay_within_their_budget() {
    assert!(u64::from(LOOP_BUDGET) <= BUDGET);
    for x in [1, 31, 32, 33, 512, 4096, 65_536] {
        let pyramid = Pyramid::new([x, 100, 100]);
        // Each iteration of a search may look at every word of a row, to the left and to the right; the first dispatch looks
        // at the particle's own row before.
        let turn = 1 + 2 * u64::from(pyramid.row_words);
        let worst = u64::from(pyramid.iterations(&TRAITS)) * turn + turn;
        assert!(worst <= BUDGET, "{x} voxels along x: {worst} iterations");
    }
    // An invocation of `luminance` shades the pixels of a tile that are as many rows apart as its workgroup is high,
    // and walks over the levels for each.
    let rows = u64::from(TILE / shaders::luminance_exact::SHADER.local_size[1]);
    for (particles, fade) in [(1, 0), (500, 6), (20_000, 6), (1_000_000, 0)] {
        let layout = Layout::new(&desc([64, 64], [8; 3], many(particles, fade)), &TRAITS).unwrap();
        assert!(rows * (1 + u64::from(LUMINANCE_ENTRIES + layout.light_levels)) <= BUDGET);
        assert!(u64::from(layout.luminance_parts) * u64::from(LUMINANCE_ENTRIES) >= u64::from(layout.spheres));
    }
    // Rows and columns: blocks to each side of the window. Each loads its taps and their weights, and adds all taps to each
    // result; results are cleared before and written after.
    let wide = Settings { sigma: 64.0, cutoff: 4.0, ..many(10, 0) };
    let blocks = u64::from(Layout::new(&desc([64, 64], [8; 3], wide), &TRAITS).unwrap().window_blocks);
    let taps = u64::from(BLOCK);
    let block = taps + (2 * taps - 1) + taps * (1 + taps);
    assert!((blocks + 1) * (1 + 2 * (1 + block)) + 2 * taps <= BUDGET);
    // Items: all tiles of a batch, a workgroup's at a time, each looking up and down, and a prefix sum that doubles.
    let lanes = u64::from(shaders::items::SHADER.local_size[0]);
    let settings = Settings { sigma: 64.0, cutoff: 4.0, groups: 254, ..many(10, 0) };
    for size in [[64, 64], [1000, 1000], [2800, 2900]] {
        let layout = Layout::new(&desc(size, [8; 3], settings.clone()), &TRAITS).unwrap();
        let runs = u64::from(layout.batch_capacity).div_ceil(lanes);
        let reach = u64::from(layout.window_blocks).div_ceil(TILE_BLOCKS.into());
        assert!(runs * (1 + 2 * reach + 1 + u64::from(lanes.ilog2())) <= BUDGET, "{size:?}");
    }
}

#[test]
fn searches_have_as_many_dispatches_as_they_may_need() {
    for dimensions in [[1; 3], [256; 3], [8, 256, 256], [500, 30, 200]] {
        for (grow, radius) in [(Grow::Pyramid, Radius::Ball), (Grow::Growth, Radius::Ball)] {
            let settings = Settings { grow, radius, radius_from: RadiusFrom::Voxels, ..many(10, 0) };
            let layout =
                Layout::new(&Desc { velocity: false, ..desc([64, 64], dimensions, settings) }, &TRAITS).unwrap();
            let pyramid = Pyramid::new(dimensions);
            let iterations = u64::from(layout.search_parts) * u64::from(pyramid.iterations(&TRAITS));
            let shape = Shape { dimensions, voxel_size: [1.0; 3], origin: [0.0; 3] };
            // Nodes of the whole walk: leaves and a third of that above them.
            let needed = match grow {
                Grow::Growth => u64::from(growth_rows(&shape)),
                _ => (0..pyramid.count).map(|level| u64::from(pyramid.leaves()) >> (2 * level)).sum(),
            };
            assert!(iterations >= needed, "{dimensions:?}, {grow:?}: {iterations} of {needed}");
            assert_eq!(layout.size(layout::CONTINUATIONS), 16 * u64::from(layout.search_parts));
        }
    }
}

#[test]
fn settings_out_of_range_are_refused_by_key() {
    let s = Settings::default;
    let tone = |from: f32| Tone::new(from, [0.5; 3]);
    let cases = [
        ("smoke.threshold", Settings { threshold: f32::NAN, ..s() }),
        ("smoke.particles", Settings { particles: 1_000_001, ..s() }),
        ("smoke.emitter", Settings { emitter: Some(Emitter { min: [1.0; 3], max: [0.0; 3] }), ..s() }),
        ("smoke.still", Settings { still: -1.0, ..s() }),
        ("smoke.lifetime", Settings { lifetime: Some(0), ..s() }),
        ("smoke.fade", Settings { fade: 65, ..s() }),
        ("smoke.scale", Settings { scale: 0.0, ..s() }),
        ("smoke.grow", Settings { radius_from: RadiusFrom::Voxels, grow: Grow::Field, radius: Radius::Ball, ..s() }),
        ("smoke.detail", Settings { detail: Some(-1.0), ..s() }),
        ("smoke.radius_smoothing", Settings { radius_smoothing: 0.96, ..s() }),
        ("smoke.boil", Settings { boil: 1.1, ..s() }),
        ("smoke.softness", Settings { softness: 1.1, ..s() }),
        ("smoke.gradient", Settings { gradient: [1.0, 0.5], ..s() }),
        ("smoke.gradient", Settings { gradient: [f32::NAN, 0.5], ..s() }),
        ("smoke.tones_above", Settings { tones_above: Some(Vec::new()), ..s() }),
        ("smoke.tones", Settings { tones: vec![Tone { shadow: Some([-1.0; 3]), ..tone(0.0) }], ..s() }),
        ("smoke.shadow_map", Settings { shadow_map: 8, ..s() }),
        ("smoke.shadow_filter", Settings { shadow_filter: 2, ..s() }),
        ("smoke.groups", Settings { groups: 255, ..s() }),
        ("smoke.group_depth", Settings { group_depth: Some(0.0), ..s() }),
        ("smoke.range_smoothing", Settings { range_smoothing: 1.0, ..s() }),
        ("smoke.hysteresis", Settings { hysteresis: f32::NAN, ..s() }),
        ("smoke.sigma", Settings { sigma: 0.05, ..s() }),
        ("smoke.sigma", Settings { sigma: 65.0, ..s() }),
        ("smoke.sigma", Settings { sigma: f32::NAN, ..s() }),
        ("smoke.cutoff", Settings { cutoff: 0.5, ..s() }),
        ("smoke.tones", Settings { tones: vec![], ..s() }),
        ("smoke.tones", Settings { tones: vec![tone(0.5), tone(0.5)], ..s() }),
        ("smoke.tones", Settings { tones: vec![tone(0.0), tone(1.5)], ..s() }),
        ("smoke.tone_softness", Settings { tone_softness: f32::INFINITY, ..s() }),
        ("smoke.outline.width", Settings { outline: Outline { width: 0.5, ..Outline::default() }, ..s() }),
        ("smoke.outline.strength", Settings { outline: Outline { strength: -1.0, ..Outline::default() }, ..s() }),
        ("smoke.outline.colour", Settings { outline: Outline { colour: [f32::NAN; 3], ..Outline::default() }, ..s() }),
    ];
    for (key, settings) in cases {
        match Smoke::memory(&desc([64, 64], [8; 3], settings), &TRAITS) {
            Err(Error::Setting { name, allowed, .. }) => {
                assert!(name == key && !allowed.is_empty(), "{name}: {allowed}")
            }
            other => panic!("{key}: {other:?}"),
        }
    }
    assert!(Smoke::memory(&desc([0, 64], [8; 3], s()), &TRAITS).is_err());
    assert!(Smoke::memory(&desc([64, 64], [8, 0, 8], s()), &TRAITS).is_err());
    assert!(Smoke::memory(&desc([64, 64], [8, 1 << 17, 8], s()), &TRAITS).is_err());
}

#[test]
fn looking_at_light_space_lists_keeps_the_loop_budget() {
    for point_light in [false, true] {
        for particles in [1, 500, 10_000, 1_000_000] {
            let desc = Desc { point_light, ..desc([64, 64], [8; 3], many(particles, 0)) };
            let layout = Layout::new(&desc, &TRAITS).unwrap();
            // `occupied_sum`: a single workgroup of the smallest picture goes over all lists.
            let [lanes, ..] = shaders::occupied_sum::SHADER.local_size;
            let lists = (layout.light_cells * layout.light_faces).div_ceil(lanes);
            assert!(u64::from(lists + lanes.ilog2()) <= BUDGET, "{particles}, {point_light}: {lists}");
        }
    }
}

/// What all three take at 1920 x 1080, in the README's rows: what is kept of each, and the scratch memory of the largest.
#[test]
fn three_effects_share_scratch() {
    let size = [1920, 1080];
    let mesh = |target_format, outer, toon| {
        let settings = blur::Settings::default();
        blur::Desc {
            size,
            target_format,
            points: 10_000,
            triangles: 20_000,
            neighbours: 60_000,
            texture_rows: 0,
            surfaces: 1,
            groups: 10_000,
            group_triangles: 60_000,
            outer,
            toon,
            depth: None,
            occluders: None,
            most_triangles: blur::MOST_TRIANGLES,
            segments: blur::Desc::segments_of(&settings),
            frames_resident: 48,
            parts: None,
            sources: Vec::new(),
            temporal: Default::default(),
            seed: 0,
            settings,
            layers: false,
        }
    };
    let all = |target_format, mode, outer, toon| {
        let settings = Settings { particles: 2000, ..Settings::default() };
        let of_smoke = Desc { target_format, layers: false, ..desc(size, [128; 3], settings) };
        let settings = flame::Settings { spread: Some(0.1), mode, ..flame::Settings::default() };
        let of_flame = flame::Desc { target_format, ..flame::Desc::new(size, 10_000, settings) };
        let of_blur = mesh(target_format, outer, toon);
        let found =
            [Smoke::memory(&of_smoke, &TRAITS), Flame::memory(&of_flame, &TRAITS), Blur::memory(&of_blur, &TRAITS)]
                .map(|memory| memory.expect("a size"));
        let history: u64 = found.iter().map(|memory| memory.history).sum();
        let scratch = found.iter().map(|memory| memory.scratch).max().unwrap_or(0);
        let [mib, apart] =
            [history + scratch, found.iter().map(Memory::total).sum()].map(|bytes| bytes as f64 / 1048576.0);
        println!("{target_format:?}, {mode:?}, outer {outer}, drawn {toon}: {mib:.1} MiB shared, {apart:.1} apart");
        for memory in found {
            let [history, scratch] = [memory.history, memory.scratch].map(|bytes| bytes as f64 / 1048576.0);
            println!("    {history:.1} kept, {scratch:.1} scratch");
        }
        mib
    };
    let (half, float) = (vk::Format::R16G16B16A16_SFLOAT, vk::Format::R32G32B32A32_SFLOAT);
    let [stochastic, expected] = [flame::settings::Mode::Stochastic, flame::settings::Mode::Expected];
    for (mode, toon) in [(stochastic, false), (stochastic, true), (expected, false)] {
        // Of the 8 MiB that the smoothed density takes beside the host's, 2 are made up for by the field that nobody searches.
        // Ink of smears needs its lines, 16 bytes a pixel, until the picture is composed.
        let of_ink = if toon { 32.0 } else { 0.0 };
        assert!(all(half, mode, false, toon) <= 501.0 + of_ink);
    }
    // The table of the expected image and two drawn frames are kept; images of 16 bytes a pixel, and of four frames instead of
    // two, are larger by themselves.
    for (format, mode, outer, toon) in [
        (half, expected, false, true),
        (half, stochastic, true, false),
        (float, stochastic, false, false),
        (float, stochastic, true, false),
    ] {
        assert!(all(format, mode, outer, toon) <= 611.0);
    }
}
