//! How many commands a frame in a sequence takes on a GPU, whose drivers end no loops: dependent steps cost it some
//! microseconds each, however little they do.

use celfx::blur::{self, BlurKind};
use celfx::effect::{DeviceTraits, Effort, Inventory, Kind, describe};
use celfx::flame::settings::Mode;
use celfx::flame::{self, FlameKind, ParticleInput};
use celfx::host::{Background, ImageState};
use celfx::low_level::barrier::Tracker;
use celfx::low_level::plan::{ImageId, Plan};
use celfx::smoke::{self, SmokeKind, VolumeInput};
use celfx::view::{Camera, Light};

use crate::kinds::{FORMAT, SIZE, buffer, clusters, image, mesh, segments};

/// Steps and barriers of the last of these frames.
fn commands<K: Kind>(desc: &K::Desc, frames: &[K::Frame<'_>]) -> (usize, u32) {
    let mut kind = K::new(desc, &DeviceTraits::LEAST, Effort::Needed).expect("it can be made");
    let description = describe(&mut kind, desc, Effort::Needed);
    let mut plan = Plan::for_passes(&description.passes);
    for frame in frames {
        plan.clear();
        let recorded = kind.plan(desc, frame, &mut plan).expect("a frame");
        kind.recorded(desc, recorded);
    }
    let buffers = description.buffers.len() + K::Layout::HOST_BUFFERS;
    let images = description.images.len() + K::Layout::HOST_IMAGES;
    let mut tracker = Tracker::new(buffers, images).with_overlays(&description.overlays);
    tracker.begin(&plan, &description.passes);
    let of_host = (description.images.len()..images).map(|index| (ImageId(index as u16), ImageState::default()));
    of_host.clone().for_each(|(image, state)| tracker.take_image(image, state));
    for (index, step) in plan.steps.iter().enumerate() {
        let mark = if tracker.before(&plan, index, &description.passes).is_empty() { " " } else { "|" };
        let pass = &description.passes[usize::from(step.pass.0)];
        let shaders: Vec<_> = pass.shaders().into_iter().flatten().map(|shader| shader.file).collect();
        println!("{mark} {:<20} {shaders:?} {:?}", pass.name, step.command);
    }
    tracker.end(of_host);
    println!("{} steps, {} barriers", plan.steps.len(), tracker.count());
    (plan.steps.len(), tracker.count())
}

#[test]
fn a_frame_of_smoke() {
    let dimensions = [64; 3];
    let desc = smoke::Desc { target_format: FORMAT, dimensions, ..crate::desc(smoke::Settings::default()) };
    let velocity = Some(buffer());
    let volume = VolumeInput { dimensions, voxel_size: [0.1; 3], origin: [0.0; 3], density: buffer(), velocity };
    let first = smoke::Frame {
        sequence: smoke::Sequence::Restart,
        dt: 0.04,
        view: Camera::default().view(SIZE),
        light: Light::default(),
        fire: None,
        volume: Some(volume),
        target: Some(image(FORMAT)),
        background: Background::Clear([1.0; 4]),
        depth: None,
        edges: None,
        temporal: Default::default(),
    };
    let next = smoke::Frame { sequence: smoke::Sequence::Advance, ..first };
    let (_, barriers) = commands::<SmokeKind>(&desc, &[first, next]);
    // Two of them are for `detail`, which is smoothed in each new volume: along x and y, and along z. The surface is searched
    // in what is made beside the births.
    assert!(barriers <= 22, "{barriers}");
    let held = smoke::Frame { sequence: smoke::Sequence::Advance, volume: None, ..first };
    let (_, of_held) = commands::<SmokeKind>(&desc, &[first, next, held]);
    assert!(of_held <= 17, "{of_held} without a new volume");
}

#[test]
fn a_frame_of_fire() {
    for mode in [Mode::Stochastic, Mode::Expected] {
        let settings = flame::Settings { mode, spread: Some(0.1), ..Default::default() };
        let hottest = settings.hottest;
        let desc = flame::Desc {
            size: SIZE,
            lines: None,
            target_format: FORMAT,
            scene: None,
            accumulates: false,
            particles: 50_000,
            hottest,
            seed: 1,
            settings,
            layers: false,
            temporal: Default::default(),
        };
        let particles = ParticleInput {
            count: 50_000,
            hottest,
            position_temperature: buffer(),
            ids: Some(buffer()),
            previous: None,
            velocity: None,
        };
        let first = flame::Frame {
            view: Camera::default().view(SIZE),
            particles: Some(particles),
            spread: None,
            number: 0,
            accumulate: false,
            target: image(FORMAT),
            background: Background::Clear([0.0; 4]),
            scene: None,
            temporal: Default::default(),
        };
        let (_, barriers) = commands::<FlameKind>(&desc, &[first, first]);
        assert!(barriers <= 14, "{mode:?}: {barriers}");
    }
}

#[test]
fn a_frame_of_blur() {
    let knots = [blur::Knot {
        view: blur::FrameView { frame: 1, view: Camera::default().view(SIZE) },
        weights: [[0.0; 4]; 12],
    }; 10];
    let view = |frame| blur::FrameView { frame, view: Camera::default().view(SIZE) };
    let settings = blur::Settings::default();
    let desc = blur::Desc {
        texture_rows: 0,
        occluders: None,
        size: SIZE,
        target_format: FORMAT,
        points: 10_000,
        triangles: 19_000,
        neighbours: 58_000,
        surfaces: 1,
        groups: 11_000,
        group_triangles: 57_000,
        outer: true,
        toon: true,
        depth: None,
        most_triangles: 100_000,
        segments: blur::Desc::segments_of(&settings),
        frames_resident: 16,
        parts: None,
        sources: Vec::new(),
        seed: 0,
        settings,
        layers: false,
        temporal: Default::default(),
    };
    let segments = segments(&desc);
    let frame = |number: u32| blur::Frame {
        mesh: (number == 0).then(mesh),
        poses: Some(blur::PoseInput { first: number + 3, count: 1, positions: buffer() }),
        skinned: None,
        interval: Some(blur::IntervalInput {
            counts: blur::Counts { clusters: 3, bounds: 100, seams: 7, farthest: 500.0, ..Default::default() },
            segments: &segments,
            views: [view(number), view(number + 1), view(number + 2), view(number + 3)],
            trajectories: blur::Trajectories::Poses(&knots),
            clusters: Some(clusters()),
        }),
        images: None,
        toon: Some(blur::ToonInput { view: view(number + 2), light: Light::default() }),
        occluders: [None; 4],
        outer: [None; 2],
        target: image(FORMAT),
        depth: None,
        background: Background::Clear([1.0; 4]),
        temporal: Default::default(),
    };
    let poses = Some(blur::PoseInput { first: 0, count: 10, positions: buffer() });
    let first = blur::Frame { poses, ..frame(0) };
    let (_, barriers) = commands::<BlurKind>(&desc, &[first, frame(1), frame(2)]);
    assert!(barriers <= 60, "{barriers}");
}
