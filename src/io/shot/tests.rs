use std::fs;

mod builtin;
mod documents;

use super::*;
use crate::flame::settings::Colour;
use crate::io::scene;
use crate::io::tests::Folder;
use crate::io::volume::Grids;
use crate::program::{self, blur::Blur, flame::Flame, smoke::Smoke};
use crate::smoke::{Settings, settings};
use crate::srgb::linear_from_srgb;

fn load(text: &str, sets: &[&str]) -> Result<Shot, ShotError> {
    let folder = Folder::new();
    let path = folder.0.join("shot.toml");
    fs::write(&path, text).expect("temporary folder");
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    program::load(path.to_str().expect("UTF-8"), &sets)
}

/// The message of a shot that must be refused, without the folder of its file.
fn refused(text: &str, sets: &[&str]) -> String {
    let message = load(text, sets).expect_err(text).to_string();
    message.split_once("/shot.toml").map_or(message.clone(), |(_, rest)| format!("shot.toml{rest}"))
}

/// The smoke of a shot that has some.
fn smoke_of(shot: &Shot) -> &Smoke {
    shot.part().expect("smoke")
}

/// The fire of a shot that has some.
fn flame_of(shot: &Shot) -> &Flame {
    shot.part().expect("fire")
}

#[test]
fn an_empty_table_has_every_default() {
    let shot = load("[smoke]", &[]).expect("a shot");
    assert_eq!((shot.size, shot.frames, shot.fps, shot.seed), ([512, 512], [1, 48], 24.0, 0));
    assert_eq!(shot.background, Background::Colour([0.55, 0.70, 0.90]));
    assert_eq!((shot.camera(7), shot.light(7)), (Camera::default(), Light::default()));
    let smoke = Smoke {
        volume: "builtin:plume".to_owned(),
        grids: Grids::default(),
        hold: false,
        volume_fps: None,
        exposure: Exposure::new(1, 1),
        settings: Settings::default(),
    };
    assert_eq!((shot.part(), shot.has("flame")), (Some(&smoke), false));

    let shot = load("[flame]", &[]).expect("a shot");
    let flame = Flame {
        particles: "builtin:random".to_owned(),
        hold: false,
        exposure: Exposure::new(1, 1),
        settings: crate::flame::Settings::default(),
    };
    assert_eq!((shot.has("smoke"), shot.part()), (false, Some(&flame)));

    let both = load("[flame]\n[smoke]", &[]).expect("a shot");
    assert_eq!((both.part(), both.part()), (Some(&smoke), Some(&flame)));
}

#[test]
fn unknown_keys_name_file_line_and_the_nearest_key() {
    for (text, message) in [
        ("[smoke]\n\nsigmaa = 4", "shot.toml:3: smoke.sigmaa: unknown key; did you mean smoke.sigma?"),
        ("sise = [8, 8]\n[smoke]", "shot.toml:1: sise: unknown key; did you mean size?"),
        (
            "[smoke.outline]\ncolor = [0, 0, 0]",
            "shot.toml:2: smoke.outline.color: unknown key; did you mean smoke.outline.colour?",
        ),
        (
            "[smoke]\noutline = { with = 2 }",
            "shot.toml:2: smoke.outline.with: unknown key; did you mean smoke.outline.width?",
        ),
        ("[smok]", "shot.toml:1: smok: unknown key; did you mean smoke?"),
        ("[flame]\nrepetition = 4", "shot.toml:2: flame.repetition: unknown key; did you mean flame.repetitions?"),
        ("[blur]\nstrenght = 2", "shot.toml:2: blur.strenght: unknown key; did you mean blur.strength?"),
        ("[blur.lines]\nlenth = 2", "shot.toml:2: blur.lines.lenth: unknown key; did you mean blur.lines.length?"),
        ("[flame.size]\nx = 4", "shot.toml:1: flame.size = { ... }: allowed: metres, 0 to 1e6"),
    ] {
        assert_eq!(refused(text, &[]), message);
    }
}

#[test]
fn wrong_values_name_file_line_key_and_what_is_allowed() {
    for (text, place, allowed) in [
        ("[smoke]\nsigma = 100", "shot.toml:2: smoke.sigma = 100: ", "0.1 to 64"),
        ("[smoke]\nsigma = \"soft\"", "shot.toml:2: smoke.sigma = \"soft\": ", "0.1 to 64"),
        ("[smoke]\nsigma = nan", "shot.toml:2: smoke.sigma = NaN: ", "0.1 to 64"),
        ("[smoke]\nparticles = -1", "shot.toml:2: smoke.particles = -1: ", "0 to 1000000"),
        ("[smoke]\nparticles = 99999999999999999999", "shot.toml:2: smoke.particles = ", "0 to 1000000"),
        ("[smoke]\nplacement = \"cover\"", "shot.toml:2: smoke.placement = \"cover\": ", "allowed: \"random\""),
        ("[smoke]\nshadow = \"soft\"", "shot.toml:2: smoke.shadow = \"soft\": ", "\"exact\", \"map\" or \"none\""),
        ("[smoke]\noutline = 3", "shot.toml:2: smoke.outline = 3: ", "a table"),
        ("[smoke]\noutline.width = 0.5", "shot.toml:2: smoke.outline.width = 0.5: ", "1 to 16"),
        ("[smoke]\noutline.colour = [0, 0]", "shot.toml:2: smoke.outline.colour = [0, 0]: ", "[red, green, blue]"),
        ("[smoke]\nemitter = { min = [0, 0, 0] }", "shot.toml:2: smoke.emitter = { ... }: ", "max"),
        ("[smoke]\nsigma = { x = 1 }", "shot.toml:2: smoke.sigma = { ... }: ", "0.1 to 64"),
        ("[smoke]\ntones = []", "shot.toml:2: smoke.tones = 0 tones: ", "1 to 256"),
        ("[smoke]\ntones = [[0.5, [1, 1, 1]], [0.2, [1, 1, 1]]]", "shot.toml:2: smoke.tones = ", "ascending"),
        ("[smoke]\nvolume = \"builtin:plum\"", "shot.toml:2: smoke.volume = \"builtin:plum\": ", "builtin:plume"),
        ("[flame]\nrepetitions = 0", "shot.toml:2: flame.repetitions = 0: ", "1 to 1048576"),
        ("[flame]\ntones = [[0.0, [1, 1, 1]]]", "shot.toml:2: flame.tones = 0: ", "above 0"),
        ("[flame]\ntones = [[0.5, [1, 1, 1]], [900.0, [1, 1, 1]]]", "shot.toml:2: flame.tones = 900: ", "hotter"),
        ("[flame]\nrepetitions = 1.5", "shot.toml:2: flame.repetitions = 1.5: ", "a whole number"),
        ("[flame]\ncount = 1e9", "shot.toml:2: flame.count = 1000000000: ", "0 to 32768"),
        ("[flame]\nmode = \"exact\"", "shot.toml:2: flame.mode = \"exact\": ", "\"stochastic\" or \"expected\""),
        ("[flame]\nthreshold = nan", "shot.toml:2: flame.threshold = NaN: ", "a finite number"),
        ("[flame]\nsize = -1", "shot.toml:2: flame.size = -1: ", "metres, 0 to 1e6"),
        ("[flame]\nsize = 1\nsize_pixels = 3", "shot.toml:3: flame.size_pixels = 3: ", "flame.size"),
        ("[flame]\nmode = \"expected\"\nsize_pixels = 3", "shot.toml:3: flame.size_pixels = 3: ", "metres"),
        ("[flame]\nhottest = 600", "shot.toml:2: flame.hottest = 600: ", "kelvin, 700 to"),
        ("[flame]\nsampling = \"sobol\"", "shot.toml:2: flame.sampling = \"sobol\": ", "\"shuffled_sobol\""),
        ("[flame]\ncolour = \"phsyical\"", "shot.toml:2: flame.colour = \"phsyical\": ", "\"physical\", \"displ"),
        ("[flame]\ncolour = [1, 0, 0]", "shot.toml:2: flame.colour = [1, 0, 0]: ", "an image file"),
        ("[flame]\nhold = 1", "shot.toml:2: flame.hold = 1: ", "true or false"),
        ("[flame]\nparticles = 3", "shot.toml:2: flame.particles = 3: ", "\"builtin:random\""),
        ("[flame]\nparticles = \"builtin:sph\"", "shot.toml:2: flame.particles = \"builtin:sph\": ", "not built yet"),
        ("[flame]\nparticles = \"#.%d.npz\"", "shot.toml:2: flame.particles = \"#.%d.npz\": ", "one is allowed"),
        ("[blur]\nstrength = 5", "shot.toml:2: blur.strength = 5: ", "frames, 0 (off) to 4"),
        ("[blur]\nstrength = \"soft\"", "shot.toml:2: blur.strength = \"soft\": ", "frames, 0 (off) to 4"),
        ("[blur]\nteeth = 3\ntooth_width = 3", "shot.toml:2: blur.teeth = 3: ", "not together"),
        ("[blur]\nclusters = \"lda\"", "shot.toml:2: blur.clusters = \"lda\": ", "\"ldf\""),
        ("[blur]\nlines = { count = -1 }", "shot.toml:2: blur.lines.count = -1: ", "0 (off) to 1024"),
        ("[blur]\nghosts = { count = 16, step = 1 }", "shot.toml:2: blur.ghosts.count = 16: ", "8 frames"),
        ("[blur.toon]\ntones = [[2, [0, 0, 0]]]", "shot.toml:2: blur.toon.tones", "0 to 1"),
        (
            "[blur.toon.outline]\nwidth = 0",
            "shot.toml:2: blur.toon.outline.width = 0: ",
            "pixels at 1080 lines, 0.1 to 16",
        ),
        ("[blur]\nscene = \"builtin:rum\"", "shot.toml:2: blur.scene = \"builtin:rum\": ", "builtin:run"),
        ("[blur]\nscene = \"no.####.npz\"", "shot.toml:2: blur.scene = \"no.####.npz\": ", "no sequences of files"),
        ("[blur]\nscene = \"no.%d.glb\"", "shot.toml:2: blur.scene = \"no.%d.glb\": ", "no sequences of files"),
        ("[blur]\ncuts = [12, 7]", "shot.toml:2: blur.cuts = [12, 7]: ", "ascending"),
        ("[blur]\nshares = [[\"Head\", 2]]", "shot.toml:2: blur.shares = ", "shares of strength, 0 to 1"),
        ("[blur]\ncurve = [[5, 1], [5, 0]]", "shot.toml:2: blur.curve = 5: ", "ascending"),
        ("[blur]\nlead = 2", "shot.toml:2: blur.lead = 2: ", "0 (off) to 1"),
        ("[blur]\ncuts = 12", "shot.toml:2: blur.cuts = 12: ", "a list of frames"),
        ("[blur]\nimages = \"a.png\"", "shot.toml:2: blur.images = \"a.png\": ", "####"),
        ("[blur]\nanimation = \"Run\"", "shot.toml:2: blur.animation = \"Run\": ", "only with a glTF file"),
        ("[blur]\nanimation = []", "shot.toml:2: blur.animation = []: ", "a list of names and numbers"),
        ("[blur]\nanimation = [-1]", "shot.toml:2: blur.animation = [-1]: ", "its number, from 0"),
        ("[blur]\nanimation = [\"Run\", 2]", "shot.toml:2: blur.animation = [\"Run\", 2]: ", "only with a glTF file"),
        (
            "[smoke]\n[camera]\nname = \"Top\"",
            "shot.toml:3: camera.name = \"Top\": ",
            "only with a glTF file as camera.file",
        ),
        (
            "[smoke]\n[camera]\nfile = \"builtin:run\"\nanimation = 1",
            "shot.toml:4: camera.animation = 1: ",
            "only with",
        ),
        ("[smoke]\n[camera]\nfile = \"a.glb\"\nname = [0, 1]", "shot.toml:4: camera.name = [0, 1]: ", "its number"),
        ("[blur]\nscene = \"a.npz\"\ntrajectory = \"exact\"", "shot.toml:3: blur.trajectory = \"exact\": ", ".npz"),
        ("[blur.passes]\ncolour = \"a.####.exr\"", "shot.toml:2: blur.passes.colour: ", "blur.passes.depth is missing"),
        (
            "[blur]\nscene = \"builtin:run\"\n[blur.passes]\nid = \"a.####.exr\"",
            "shot.toml:2: blur.scene: ",
            "not together with blur.passes.id",
        ),
        (
            "[blur.passes]\ndepth = \"a.exr\"\ncolour = \"b.exr\"",
            "shot.toml:3: blur.passes.colour = \"b.exr\": ",
            "####",
        ),
        ("[blur.passes]\nvectors = \"maya\"", "shot.toml:2: blur.passes.vectors = \"maya\": ", "\"arnold\""),
        ("[blur.passes]\nscale = 1e4", "shot.toml:2: blur.passes.scale = 10000.0: ", "-1000 to 1000"),
        ("blur = 3", "shot.toml:1: blur = 3: ", "a table"),
        ("flame = 3", "shot.toml:1: flame = 3: ", "a table"),
        ("smoke = 3", "shot.toml:1: smoke = 3: ", "a table"),
        ("size = [0, 64]\n[smoke]", "shot.toml:1: size = [0, 64]: ", "1 to 16384"),
        ("size = [1000000, 64]\n[smoke]", "shot.toml:1: size = [1000000, 64]: ", "1 to 16384"),
        ("size = [64.0, 64]\n[smoke]", "shot.toml:1: size = [64.0, 64]: ", "whole numbers"),
        ("frames = [4, 1]\n[smoke]", "shot.toml:1: frames = [4, 1]: ", "first not above last"),
        ("fps = 0\n[smoke]", "shot.toml:1: fps = 0: ", "0.001 to"),
        ("seed = -1\n[smoke]", "shot.toml:1: seed = -1: ", "0 to 4294967295"),
        ("background = [1, 2]\n[smoke]", "shot.toml:1: background = [1, 2]: ", "linear"),
        ("background = [nan, 0, 0]\n[smoke]", "shot.toml:1: background = [nan, 0, 0]: ", "linear"),
        ("[smoke]\n[camera]\nvertical_fov = 180", "shot.toml:3: camera.vertical_fov = 180: ", "1e-9 to 179.999999999"),
        ("[smoke]\n[camera]\neye = [[2, [0, 1, 4]], [1, [0, 1, 5]]]", "shot.toml:3: camera.eye = ", "ascending"),
        ("[smoke]\n[camera]\neye = [0, 1, 0]", "shot.toml:2: camera.target = ", "differ from camera.eye"),
        ("[smoke]\n[camera]\nfile = \"builtin:ran\"", "shot.toml:3: camera.file = \"builtin:ran\": ", "builtin:run"),
        ("[smoke]\n[camera]\nfile = \"no.####.npz\"", "shot.toml:3: camera.file = ", "no sequences of files"),
        ("[smoke]\n[camera]\neye = [0, 1e30, 4]", "shot.toml:3: camera.eye = ", "none beyond 1e12"),
        ("[smoke]\n[light]\nposition = [0, 1e30, 4]", "shot.toml:3: light.position = ", "none beyond 1e12"),
        ("background = [0, 1e38, 0]\n[smoke]", "shot.toml:1: background = ", "0 to 1e6"),
        ("[smoke]\ntones = [[0, [1e38, 1, 1]]]", "shot.toml:2: smoke.tones = ", "0 to 1e6"),
        ("[smoke]\noutline.colour = [0, 2e6, 0]", "shot.toml:2: smoke.outline.colour = ", "0 to 1e6"),
        ("[smoke]\ngroup_depth = 1e38", "shot.toml:2: smoke.group_depth = ", "at most 1e12"),
        ("[smoke]\nstill = 1e38", "shot.toml:2: smoke.still = ", "0 to 1e6"),
        (
            "[smoke]\nemitter = { min = [0, 0, 0], max = [1, 1, 1e38] }",
            "shot.toml:2: smoke.emitter",
            "none beyond 1e12",
        ),
        ("[blur.lines]\ncolour = [0, 0, 1e38]", "shot.toml:2: blur.lines.colour = ", "0 to 1e6"),
        ("[blur.toon]\ntones = [[0, [0, 1e38, 0]]]", "shot.toml:2: blur.toon.tones = ", "0 to 1e6"),
        ("[smoke]\n[camera]\nfile = \"a.glb\"\nup = [0, 1, 0]", "shot.toml:4: camera.up: ", "not both"),
        ("[smoke]\n[light]\nambient = 2", "shot.toml:3: light.ambient = 2: ", "0 to 1"),
        ("[smoke]\n[light]\ndirection = [0, 0, 0]", "shot.toml:3: light.direction = ", "not all 0"),
    ] {
        let message = refused(text, &[]);
        assert!(message.starts_with(place) && message[place.len()..].contains(allowed), "{text}\n{message}");
    }
}

#[test]
fn a_shot_without_effects_is_told_which_there_are() {
    let message = refused("size = [8, 8]", &[]);
    assert!(
        message.contains("holds no effect")
            && ["[smoke]", "[flame]", "[blur]"].iter().all(|table| message.contains(table)),
        "{message}"
    );
}

#[test]
fn text_that_is_not_toml_names_the_line() {
    assert!(refused("[smoke]\nsigma = = 4", &[]).starts_with("shot.toml:2: "));
    assert!(refused("[smoke]\nsigma = 4\nsigma = 5", &[]).starts_with("shot.toml:3: "));
    let folder = Folder::new();
    let path = folder.0.join("shot.toml");
    fs::write(&path, b"[smoke]\n\xff").expect("temporary folder");
    let message = program::load(path.to_str().expect("UTF-8"), &[]).expect_err("binary").to_string();
    assert!(message.contains("not UTF-8 text at byte 8"), "{message}");
}

#[test]
fn a_missing_shot_is_unreadable_and_a_missing_built_in_suggests_one() {
    let missing = program::load("/nonexistent/shot.toml", &[]).expect_err("missing");
    assert!(matches!(&missing, ShotError::Read { .. }) && missing.to_string().contains("/nonexistent/shot.toml"));
    let message = program::load("builtin:smok", &[]).expect_err("unknown").to_string();
    assert!(message.contains("did you mean builtin:smoke?"), "{message}");
}

#[test]
fn keys_can_be_overridden() {
    let text = "[smoke]\nsigma = 2\n[light]\ndirection = [0, -1, 0]";
    let sets = [
        "smoke.sigma=8",
        "smoke.shadow=map",
        "smoke.outline.width = 3",
        "camera.far=inf",
        "size=[64, 32]",
        "light.position=[1, 2, 3]",
        "background=none",
        "smoke.fade=1_0",
    ];
    let shot = load(text, &sets).expect("a shot");
    let settings = &smoke_of(&shot).settings;
    assert_eq!((settings.sigma, settings.shadow, settings.fade), (8.0, settings::Shadow::Map, 10));
    assert_eq!((settings.outline.width, settings.outline.strength), (3.0, 1.0));
    assert_eq!((shot.size, shot.camera(1).far, &shot.background), ([64, 32], f64::INFINITY, &Background::None));
    assert_eq!(shot.light(1).source, LightSource::Position(DVec3::new(1.0, 2.0, 3.0)));
    let shot = load("[flame]\nsize = 2", &["flame.size=0.5", "flame.mode=expected", "flame.colour=physical"]);
    let settings = &flame_of(shot.as_ref().expect("a shot")).settings;
    assert_eq!((settings.size, settings.mode), (Some(0.5), crate::flame::settings::Mode::Expected));
    assert_eq!(settings.colour, Colour::Physical);
    for (set, message) in [
        ("smoke.sigmaa=4", "--set smoke.sigmaa=4: smoke.sigmaa: unknown key; did you mean smoke.sigma?"),
        ("smoke.sigma", "--set smoke.sigma: expected KEY=VALUE, for example smoke.sigma=4"),
        (
            "smoke.sigma=100",
            "--set smoke.sigma: smoke.sigma = 100: allowed: pixels at 1080 lines, 0 (off) or 0.1 to 64",
        ),
        ("smoke=3", "--set smoke: smoke = 3: allowed: a table"),
        ("size.x=3", "--set size.x=3: size.x: unknown key; did you mean size?"),
    ] {
        assert_eq!(refused(text, &[set]), message);
    }
    assert!(refused(text, &["size=[1,"]).starts_with("--set size=[1,: "));
    assert!(refused("[smoke]\n[light]\ndirection=[0,-1,0]\nposition=[0,1,0]", &[]).contains("not both"));
}

#[test]
fn keyframes_move_camera_and_light() {
    let text = "[smoke]\n[camera]\neye = [[1, [0, 1, 4]], [5, [4, 1, 4]]]\nfar = [[1, 10], [3, inf]]\n\
                [light]\nambient = [[1, 0], [5, 1]]\nposition = [[1, [0, 0, 0]], [5, [0, 8, 0]]]";
    let shot = load(text, &[]).expect("a shot");
    assert_eq!([1, 2, 5, 9].map(|f| shot.camera(f).eye.x), [0.0, 1.0, 4.0, 4.0]);
    assert_eq!([1, 3].map(|f| shot.camera(f).far), [10.0, f64::INFINITY]);
    assert_eq!(shot.light(2), Light { source: LightSource::Position(DVec3::new(0.0, 2.0, 0.0)), ..Light::default() });
    let second = "[smoke]\n[light]\nrim = [[1, 0], [5, 1]]\n[light.second]\nposition = [[1, [0, 0, 0]], [5, [0, 8, 0]]]\n\
                  strength = [[1, 0], [5, 1]]";
    let light = load(second, &[]).expect("a shot").light(2);
    let expected = SecondLight { source: LightSource::Position(DVec3::new(0.0, 2.0, 0.0)), strength: 0.25 };
    assert_eq!((light.rim, light.second), (0.25, Some(expected)));
    let direction = load(second, &["light.second.direction=[0, -1, 0]"]).expect("instead").light(1).second;
    assert_eq!(direction.map(|light| light.source), Some(LightSource::Direction(DVec3::NEG_Y)));
    assert_eq!(load("[smoke]\n[light.second]\nstrength = 1", &[]).expect("a shot").light(1).second, None);
    assert!(refused(second, &["light.second.strength=2"]).contains("light.second.strength = 2"));
    assert!(refused("[smoke]\n[light.second]\ndirection=[0,-1,0]\nposition=[0,1,0]", &[]).contains("not both"));
    let through = "[smoke]\n[camera]\ntarget = [0, 1, 0]\neye = [[1, [0, 1, 4]], [9, [0, 1, -4]]]";
    assert!(refused(through, &[]).contains("(at frame 5)"), "{}", refused(through, &[]));
}

#[test]
fn a_camera_can_be_a_scenes() {
    let text = "frames = [3, 9]\n[blur]\n[camera]\nfile = \"builtin:run\"\nfar = 50";
    let shot = load(text, &[]).expect("a shot");
    let scene = shot.part::<Blur>().expect("a blur").mesh(&shot).expect("built in");
    for frame in [3.0, 4.5, 9.0] {
        let expected = Camera { far: 50.0, ..scene.camera(frame).expect("its own") };
        assert_eq!(shot.camera(frame), expected, "{frame}");
    }
    assert_ne!(shot.camera(3).eye, shot.camera(4).eye);
    assert_eq!(load(text, &["camera.eye=[9, 1, 0]"]).expect("instead").camera(3).eye.x, 9.0);
    assert!(load(text, &["blur.teeth=3"]).is_ok());
    let missing = load("[blur]\n[camera]\nfile = \"a.npz\"", &[]).expect_err("missing");
    assert!(matches!(&missing, ShotError::Input(e) if e.path.ends_with("a.npz")), "{missing}");
}

#[test]
fn paths_are_relative_to_the_shot() {
    let folder = Folder::new();
    fs::create_dir(folder.0.join("shots")).expect("temporary folder");
    let file = folder.0.join("shots/a.toml");
    fs::write(&file, "background = \"sky.png\"\n[smoke]\ntones = \"t.png\"\nvolume = \"v.####.npz\"")
        .expect("temporary folder");
    let load = || program::load(file.to_str().expect("UTF-8"), &[]);
    let missing = load().expect_err("no tones yet");
    assert!(matches!(&missing, ShotError::Input(e) if e.path == folder.0.join("shots/t.png")), "{missing}");

    let pixels = [
        [0, 0, 0, 255],
        [0, 0, 0, 255],
        [255, 255, 255, 255],
        [255, 0, 0, 255],
        [9, 9, 9, 9],
        [9, 9, 9, 9],
        [9, 9, 9, 9],
        [9, 9, 9, 9],
    ];
    crate::io::image::write_png8(&folder.0.join("shots/t.png"), [4, 2], &pixels).expect("temporary folder");
    let shot = load().expect("a shot");
    let tones: Vec<_> = smoke_of(&shot).settings.tones.iter().map(|t| (t.from, t.colour)).collect();
    assert_eq!(tones, [(0.0, [0.0; 3]), (0.5, [1.0; 3]), (0.75, [1.0, 0.0, 0.0])]);
    assert_eq!(shot.background, Background::Image(folder.0.join("shots/sky.png")));
    assert_eq!(shot.folder, folder.0.join("shots"));
    let mut volumes = smoke_of(&shot).volumes(&shot).expect("a pattern");
    assert_eq!(volumes.frame(3).expect_err("missing").path, folder.0.join("shots/v.0003.npz"));

    fs::write(&file, "[flame]\ncolour = \"t.png\"\nparticles = \"p.####.npz\"").expect("temporary folder");
    let shot = load().expect("a shot");
    let ramp = vec![[0.0; 3], [0.0; 3], [1.0; 3], [1.0, 0.0, 0.0]];
    assert_eq!(flame_of(&shot).settings.colour, Colour::Ramp(ramp));
    let mut particles = flame_of(&shot).particles(&shot).expect("a pattern");
    assert_eq!(particles.frame(3).expect_err("missing").path, folder.0.join("shots/p.0003.npz"));
    fs::write(&file, "[blur]\nscene = \"a.glb\"\nimages = \"i/####.jpg\"\n[blur.toon]\ntones = \"t.png\"")
        .expect("temporary folder");
    let blur = load().expect("a shot").part::<Blur>().expect("a blur").clone();
    assert_eq!(blur.scene, scene::Source::File(folder.0.join("shots/a.glb")));
    assert_eq!(blur.images.expect("images").path(7), folder.0.join("shots/i/0007.jpg"));
    assert_eq!(blur.settings.toon.tones.len(), 3);
    fs::write(&file, "[flame]\ncolour = \"u.png\"").expect("temporary folder");
    let missing = load().expect_err("no ramp");
    assert!(matches!(&missing, ShotError::Input(e) if e.path == folder.0.join("shots/u.png")), "{missing}");
    crate::io::image::write_exr(&folder.0.join("shots/u.exr"), [2, 1], &[[0.0f32, 1.0, 2.0], [-1.0, 0.0, 0.0]])
        .expect("temporary folder");
    fs::write(&file, "[flame]\ncolour = \"u.exr\"").expect("temporary folder");
    let message = load().expect_err("negative").to_string();
    assert!(message.contains("a.toml:2: flame.colour = -1: allowed: linear RGB"), "{message}");
}

/// A glTF file of a mesh, and cameras `Main`, `Top` (orthographic) and `Side`. `BoxAction` moves the mesh and `MainAction`
/// the first camera, from x = 0 to x = 4 in a second.
fn film() -> String {
    let numbers = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 5.0, 4.0, 0.0, 5.0];
    let bytes: String = numbers.iter().flat_map(|x| x.to_le_bytes()).map(|byte| format!("%{byte:02x}")).collect();
    let action = |name: &str, node: u32| {
        serde_json::json!({
            "name": name, "samplers": [{"input": 1, "output": 2}],
            "channels": [{"sampler": 0, "target": {"node": node, "path": "translation"}}],
        })
    };
    let perspective = serde_json::json!({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}});
    let orthographic =
        serde_json::json!({"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 1.5, "zfar": 9, "znear": 0}});
    serde_json::json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1, 2, 3]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "name": "Main"}, {"camera": 1, "name": "Top"}, {"camera": 0, "name": "Side"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "cameras": [perspective, orthographic],
        "animations": [action("BoxAction", 0), action("MainAction", 1)],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
            {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "type": "SCALAR", "count": 2},
            {"bufferView": 0, "byteOffset": 44, "componentType": 5126, "type": "VEC3", "count": 2},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 68}],
        "buffers": [{"byteLength": 68, "uri": format!("data:application/octet-stream,{bytes}")}],
    })
    .to_string()
}

#[test]
fn a_camera_of_a_file_moves_whatever_else_is_played() {
    let folder = Folder::new();
    fs::write(folder.0.join("film.gltf"), film()).expect("temporary folder");
    fs::copy(folder.0.join("film.gltf"), folder.0.join("other.gltf")).expect("temporary folder");
    let path = folder.0.join("shot.toml");
    fs::write(&path, "fps = 2\nframes = [1, 3]\n[camera]\nfile = \"film.gltf\"\n[blur]\nscene = \"film.gltf\"\n")
        .expect("temporary folder");
    let load = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
        program::load(path.to_str().expect("UTF-8"), &sets)
    };
    // Where the camera and the mesh are in the last frame.
    let ends = |sets: &[&str]| {
        let shot = load(sets).expect("a shot");
        let mesh = shot.part::<Blur>().expect("a blur").mesh(&shot).expect("a mesh");
        (shot.camera(3).eye.x, mesh.pose(3.0).expect("a pose")[0][0])
    };
    for (sets, expected) in [
        (&[][..], (4.0, 4.0)),
        (&["blur.animation=BoxAction"], (4.0, 4.0)),
        (&["blur.animation=MainAction"], (4.0, 0.0)),
        (&["blur.animation=1"], (4.0, 0.0)),
        (&["blur.animation=[\"MainAction\", 0]"], (4.0, 4.0)),
        (&["blur.animation=*"], (4.0, 4.0)),
        (&["blur.animation=MainAction", "camera.file=other.gltf"], (4.0, 0.0)),
        (&["camera.animation=BoxAction"], (0.0, 4.0)),
        (&["camera.animation=MainAction", "blur.animation=0"], (4.0, 4.0)),
        (&["camera.name=Side"], (0.0, 4.0)),
        (&["camera.name=2", "blur.animation=MainAction"], (0.0, 0.0)),
    ] {
        assert_eq!(ends(sets), expected, "{sets:?}");
    }
    for (set, words) in [
        ("camera.name=Rear", &["none is called `Rear`", "`Main`, `Top`, `Side`"][..]),
        ("camera.animation=Fly", &["none is called `Fly`", "`BoxAction`, `MainAction`"]),
        ("camera.animation=2", &["no number 2", "0 to 1"]),
    ] {
        let error = load(&[set]).expect_err(set).to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{set}: {error}");
    }
    let only_top = film().replace("{\"camera\":0,", "{").replace("\"nodes\":[0,1,2,3]", "\"nodes\":[0,2]");
    fs::write(folder.0.join("other.gltf"), only_top).expect("temporary folder");
    // What there is besides is looked through, too.
    let top = load(&["camera.file=other.gltf", "camera.shift=[0.5, 0]"]).expect("a camera").camera(1);
    assert_eq!((top.orthographic, top.near, top.far, top.shift.x), (Some(3.0), 1e-6, 9.0, 0.5));
    assert!(load(&["camera.name=Top"]).is_ok_and(|shot| shot.camera(1).orthographic == Some(3.0)));
    assert_eq!(load(&[]).expect("a shot").camera(1).orthographic, None);
}

#[test]
fn colours_may_be_picked_from_a_screen() {
    let picked = load("background = \"#e07A5F\"\n[smoke]\ntones = [[0, \"#000000\"], [0.5, \"#ffffff\"]]", &[]);
    let picked = picked.expect("a shot");
    let [r, g, b] = [0xe0, 0x7a, 0x5f].map(|code| linear_from_srgb(f64::from(code) / 255.0) as f32);
    assert_eq!(picked.background, Background::Colour([r, g, b]));
    let tones: Vec<_> = smoke_of(&picked).settings.tones.iter().map(|tone| tone.colour).collect();
    assert_eq!(tones, [[0.0; 3], [1.0; 3]]);
    let set = load("[smoke]", &["smoke.outline.colour=#808080"]).expect("a shot");
    assert!((smoke_of(&set).settings.outline.colour[0] - 0.2159).abs() < 1e-4);
    for wrong in ["#e07a5", "#e07a5f0", "#e07a5g", "#+07a5f", "e07a5f"] {
        load(&format!("[smoke]\noutline.colour = \"{wrong}\""), &[]).expect_err(wrong);
    }
    // A name is a name.
    let named = load("[blur]\nshares = [[\"#e07A5F\", 0.5]]", &[]).expect("a shot");
    assert_eq!(named.part::<Blur>().expect("a blur").shares, [("#e07A5F".to_owned(), 0.5)]);
}

#[test]
fn drawings_last_as_the_shot_says_or_the_effect() {
    let on = |text: &str| {
        let shot = load(text, &[]).expect(text);
        let of_smoke = shot.part().map_or(0, |smoke: &Smoke| smoke.exposure.on());
        [of_smoke, shot.part().map_or(0, |flame: &Flame| flame.exposure.on())]
    };
    assert_eq!(on("[smoke]\n[flame]"), [1, 1]);
    assert_eq!(on("on = 2\n[smoke]\n[flame]\non = 1"), [2, 1]);
    assert_eq!(on("[smoke]\non = 3\n[flame]"), [3, 1]);
    assert_eq!(refused("on = 4\n[smoke]", &[]), "shot.toml:1: on = 4: allowed: 1, 2 or 3 frames");
    assert_eq!(refused("[flame]\non = 0", &[]), "shot.toml:2: flame.on = 0: allowed: 1, 2 or 3 frames");
}
