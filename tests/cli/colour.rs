//! Colours as people pick them, and pictures as displays show them.

use std::collections::BTreeMap;
use std::fs;

use super::run::{self, Folder, has_device};
use super::{fails, succeeds};

/// How many pixels of a PNG file have each colour.
fn codes(folder: &Folder, name: &str) -> BTreeMap<[u8; 3], usize> {
    let file = fs::File::open(folder.0.join(name)).expect(name);
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect(name);
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut pixels).expect(name);
    let mut all = BTreeMap::new();
    pixels.chunks_exact(4).for_each(|pixel| *all.entry([pixel[0], pixel[1], pixel[2]]).or_default() += 1);
    all
}

#[test]
fn picked_colours_arrive_unchanged() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let shot = "size = [96, 96]\nframes = [1, 12]\nbackground = \"#3D405B\"\n[light]\nambient = 0\nfill = 0\n[smoke]\n\
                tones = [[0.0, \"#81B29A\"], [0.4, \"#E07A5F\"]]\noutline.colour = \"#F2CC8F\"\noutline.width = 6\n\
                tone_softness = 0\n";
    folder.write("a.toml", shot);
    succeeds(&folder, &["render", "a.toml", "-q", "--frames", "12", "-o", "a.png", run::validate()]);
    let found = codes(&folder, "a.png");
    let most = |[r, g, b]: [u8; 3]| found.get(&[r, g, b]).copied().unwrap_or(0);
    for picked in [[0x3d, 0x40, 0x5b], [0x81, 0xb2, 0x9a], [0xe0, 0x7a, 0x5f], [0xf2, 0xcc, 0x8f]] {
        assert!(most(picked) > 50, "{picked:?}: {found:?}");
    }
}

#[test]
fn pictures_are_coded_for_the_display_that_is_asked_for() {
    let folder = Folder::new();
    folder.write("a.toml", "size = [32, 32]\nframes = [1, 2]\nbackground = [0.5, 0.25, 0.0]\n[output]\nview = \"sRGB\"\n[smoke]\nparticles = 0\n");
    folder.write("b.toml", "frames = [1, 2]\n[smoke]\nparticles = 0\n[output]\nview = \"P3\"\n");
    fails(&folder, &["render", "b.toml"], 2, &["b.toml:5: output.view = \"P3\"", "\"Rec.709\""]);
    fails(&folder, &["render", "a.toml", "--set", "output.view=P3"], 2, &["--set output.view", "\"Rec.709\""]);
    if !has_device() {
        return;
    }
    let render = |view: &str, name: &str, more: &[&str]| {
        let set = format!("output.view={view}");
        let all = ["render", "a.toml", "-q", "--set", &set, "-o", name, "--sheet", "sheet.png", "--resume"];
        succeeds(&folder, &[&all[..], more].concat());
    };
    // Half and a quarter of the light, by sRGB's curve and by a gamma of 2.4; kept frames are not coded twice.
    for (view, expected) in [("sRGB", [188, 137, 0]), ("Rec.709", [191, 143, 0])] {
        for name in ["####.png", "####.png", "####.exr", "####.exr"] {
            render(view, name, &[]);
            let sheet = codes(&folder, "sheet.png");
            assert_eq!(sheet.get(&expected), Some(&2048), "{view}, {name}: {sheet:?}");
        }
        assert_eq!(codes(&folder, "0001.png"), BTreeMap::from([(expected, 1024)]), "{view}");
        // And read back, each is the same light.
        let picture = celfx::io::picture::read(&folder.0.join("0001.png")).expect("a picture");
        assert!((picture.pixels[0][0] - 0.5).abs() < 0.005, "{view}: {:?}", picture.pixels[0]);
    }
}
