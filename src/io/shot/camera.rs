//! The camera of a shot: keyframes, the camera of a scene, or matrices.

use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3, DVec4};

use super::ShotError;
use super::keys::INSTEAD_OF_FILE;
use super::track::Track;
use super::tree::Tree;
use crate::io::ReadError;
use crate::io::array::{Archive, Array, Kind};
use crate::io::scene::{self, AnimatedMesh, Choice, Clock};
use crate::view::{self, Camera, MOST_SHIFT};

/// Most values of an array of matrices: those of the most frames of a shot.
const MAX_VALUES: u64 = 16 * 1_000_000;
const NAME: &str = "view_projection";
const MATRICES: &str = "[frames, 4, 4] of numbers, at least one for each frame of the shot";
/// By how much the rows of a matrix may be off those of a camera.
const TOLERANCE: f64 = 1e-3;
/// By how much, as a share, the shape of pictures may be off a matrix': whole pixels of small ones.
const ROUNDED: f64 = 0.01;

/// A camera over time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CameraTrack {
    source: Source,
    /// Nearest and farthest depth where the shot says them.
    near: Option<Track<f64>>,
    far: Option<Track<f64>>,
    /// By how much a lens is shifted beyond what its file says.
    shift: Track<DVec2>,
    pixel_aspect: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Source {
    Keys {
        eye: Track<DVec3>,
        target: Track<DVec3>,
        up: Track<DVec3>,
        vertical_fov: Track<f64>,
        orthographic: Option<Track<f64>>,
    },
    Scene(SceneCamera),
    /// One a frame, from the shot's first one on.
    Frames {
        first: u32,
        cameras: Vec<Camera>,
    },
}

/// The camera of a scene, which has one.
#[derive(Clone, Debug)]
struct SceneCamera {
    source: scene::Source,
    choice: Choice,
    clock: Clock,
    scene: Arc<AnimatedMesh>,
}

impl PartialEq for SceneCamera {
    fn eq(&self, other: &Self) -> bool {
        (&self.source, &self.choice, self.clock) == (&other.source, &other.choice, other.clock)
    }
}

impl CameraTrack {
    /// As the shot says it; `frames` are its first and last one, `size` its pictures' pixels.
    pub(super) fn new(
        tree: &Tree,
        folder: &Path,
        frames: [u32; 2],
        fps: f64,
        size: [u32; 2],
    ) -> Result<CameraTrack, ShotError> {
        let default = Camera::default();
        let given = |key: &str, default| tree.get(key).map(|_| tree.number(key, default)).transpose();
        let pixel_aspect = tree.ruled("camera.pixel_aspect", default.pixel_aspect, &view::pixel_aspect())?;
        let source = match tree.text("camera.file")? {
            Some(file) => {
                if let Some(key) = INSTEAD_OF_FILE.into_iter().find(|key| tree.get(key).is_some()) {
                    return Err(tree.wrong(key, format!("{key}: a camera is of a file or of keys, not both")));
                }
                Source::of_file(
                    tree,
                    &file,
                    folder,
                    frames,
                    fps,
                    pixel_aspect * f64::from(size[0]) / f64::from(size[1]),
                )?
            }
            None => Source::Keys {
                eye: tree.vector("camera.eye", default.eye)?,
                target: tree.vector("camera.target", default.target)?,
                up: tree.vector("camera.up", default.up)?,
                vertical_fov: tree.number("camera.vertical_fov", default.vertical_fov)?,
                orthographic: given("camera.orthographic", 1.0)?,
            },
        };
        if !matches!(&source, Source::Scene(camera) if matches!(camera.source, scene::Source::File(_))) {
            super::only_with_gltf(tree, "camera.name", "camera.file")?;
            super::only_with_gltf(tree, "camera.animation", "camera.file")?;
        }
        let (near, far) = (given("camera.near", default.near)?, given("camera.far", default.far)?);
        let shift = tree.pair("camera.shift", DVec2::ZERO, MOST_SHIFT)?;
        Ok(CameraTrack { source, near, far, shift, pixel_aspect })
    }

    /// The camera at a frame, which may lie between two. Matrices are those of the frame before.
    pub(super) fn at(&self, frame: f64) -> Camera {
        let own = match &self.source {
            Source::Keys { eye, target, up, vertical_fov, orthographic } => Camera {
                eye: eye.at(frame),
                target: target.at(frame),
                up: up.at(frame),
                vertical_fov: vertical_fov.at(frame),
                orthographic: orthographic.as_ref().map(|height| height.at(frame)),
                ..Camera::default()
            },
            Source::Scene(camera) => camera.scene.camera(frame).unwrap_or_default(),
            Source::Frames { first, cameras } => {
                let place = (frame - f64::from(*first)).max(0.0) as usize;
                cameras.get(place).or(cameras.last()).copied().unwrap_or_default()
            }
        };
        Camera {
            near: self.near.as_ref().map_or(own.near, |near| near.at(frame)),
            far: self.far.as_ref().map_or(own.far, |far| far.at(frame)),
            shift: own.shift + self.shift.at(frame),
            pixel_aspect: self.pixel_aspect,
            ..own
        }
    }

    /// The scene that it is of.
    pub(super) fn scene(&self) -> Option<&AnimatedMesh> {
        match &self.source {
            Source::Scene(camera) => Some(&camera.scene),
            _ => None,
        }
    }

    /// Whether it is the same at every frame, as far as the shot's text tells.
    pub(super) fn is_constant(&self) -> bool {
        let is_still = match &self.source {
            Source::Keys { eye, target, up, vertical_fov, orthographic } => {
                let lens = std::iter::once(vertical_fov).chain(orthographic);
                [eye, target, up].into_iter().all(Track::is_constant) && lens.into_iter().all(Track::is_constant)
            }
            _ => false,
        };
        let depths = [&self.near, &self.far].into_iter().flatten();
        is_still && self.shift.is_constant() && depths.into_iter().all(Track::is_constant)
    }
}

impl Source {
    /// `shape`: width of the pictures by their height, as they are looked at.
    fn of_file(
        tree: &Tree,
        file: &str,
        folder: &Path,
        frames: [u32; 2],
        fps: f64,
        shape: f64,
    ) -> Result<Source, ShotError> {
        let source = scene::Source::named(file, folder).map_err(|e| super::pattern_error(tree, "camera.file", &e))?;
        if let (scene::Source::File(path), true) = (&source, file.to_ascii_lowercase().ends_with(".npz")) {
            return Ok(Source::Frames { first: frames[0], cameras: matrices(path, frames, shape)? });
        }
        let (choice, clock) = (choice(tree, &source, folder)?, Clock { first: frames[0], fps });
        let scene = AnimatedMesh::open_any(&source, &choice, clock)?;
        if scene.camera(f64::from(frames[0])).is_none() {
            let expected = "a glTF file with a camera in its scene";
            return Err(ReadError::file(&folder.join(file), "has no camera".to_owned(), expected).into());
        }
        Ok(Source::Scene(SceneCamera { source, choice, clock, scene: Arc::new(scene) }))
    }
}

/// The animations and the camera that are used of the camera's file. Without a word on it they are those of the same
/// file for the blur, or else what moves the camera.
fn choice(tree: &Tree, source: &scene::Source, folder: &Path) -> Result<Choice, ShotError> {
    let camera = tree.picks("camera.name")?;
    if camera.len() > 1 {
        return Err(tree.not_allowed("camera.name"));
    }
    let own = tree.picks("camera.animation")?;
    let for_camera = own.is_empty();
    let blurred = tree.text("blur.scene")?.and_then(|name| scene::Source::named(&name, folder).ok());
    let animations = match for_camera && blurred.as_ref() == Some(source) {
        true => tree.picks("blur.animation")?,
        false => own,
    };
    Ok(Choice { animations, camera: camera.into_iter().next(), for_camera })
}

/// The cameras of an `.npz` file: `view_projection` [frames, 4, 4], which makes clip coordinates of column vectors.
/// `shape`: width of the shot's pictures by their height, as they are looked at.
fn matrices(path: &Path, [first, last]: [u32; 2], shape: f64) -> Result<Vec<Camera>, ReadError> {
    let mut archive = Archive::open(path)?;
    let count = (last - first) as usize + 1;
    let rows = archive.shape(NAME, 3, Kind::Any, MATRICES)?.ok_or_else(|| archive.missing(NAME, MATRICES))?;
    if !matches!(rows[..], [n, 4, 4] if n >= count as u64) {
        let expected = format!("[{count}, 4, 4] for frames {first} to {last} of the shot");
        return Err(archive.wrong_shape(NAME, &rows, &expected));
    }
    cameras(&mut archive, path, count, Some(shape))
}

/// How many cameras an `.npz` file holds; an error if one of them is none.
pub fn count_cameras(path: &Path) -> Result<usize, ReadError> {
    let mut archive = Archive::open(path)?;
    let shape = archive.shape(NAME, 3, Kind::Any, MATRICES)?.ok_or_else(|| archive.missing(NAME, MATRICES))?;
    match shape[..] {
        [_, 4, 4] => cameras(&mut archive, path, usize::MAX, None).map(|cameras| cameras.len()),
        _ => Err(archive.wrong_shape(NAME, &shape, MATRICES)),
    }
}

/// At most so many cameras of an array whose header has been read. Their pictures must have that shape, if one is told.
fn cameras(archive: &mut Archive, path: &Path, count: usize, shape: Option<f64>) -> Result<Vec<Camera>, ReadError> {
    let values = archive.read(NAME, MAX_VALUES)?.map(|array: Array<f64>| array.values).unwrap_or_default();
    let camera = |(row, matrix): (usize, &[f64])| {
        let rows: [DVec4; 4] = std::array::from_fn(|i| DVec4::from_slice(&matrix[4 * i..]));
        let fault = |why, expected| ReadError::at(path, format!("array `{NAME}`, row {row}"), why, expected);
        let (camera, own) = camera_of(rows).map_err(|why| {
            let expected = "the matrix of a perspective camera without shear; for others there are camera.eye and \
                            camera.orthographic";
            fault(why, expected)
        })?;
        match shape.filter(|shape| (own / shape - 1.0).abs() > ROUNDED) {
            None => Ok(camera),
            Some(shape) => {
                let why = format!("is of pictures {own:.4} times as wide as high, and the shot's are {shape:.4} times");
                Err(fault(
                    why,
                    "a size of that shape, or camera.pixel_aspect, which tells a pixel's width by its height",
                ))
            }
        }
    };
    values.chunks_exact(16).take(count).enumerate().map(camera).collect()
}

/// The camera with a matrix of these rows, X, Y, depth and W of a point, and the width of its pictures by their height. Y may
/// be up or down. What depth is made of is not looked at.
fn camera_of([x, y, _, w]: [DVec4; 4]) -> Result<(Camera, f64), String> {
    let scale = w.truncate().length();
    if !(scale > 0.0 && [x, y, w].into_iter().all(DVec4::is_finite)) {
        return Err("W does not depend on where a point is, or is not finite".to_owned());
    }
    let (x, y, w) = (x / scale, y / scale, w / scale);
    let rows = [x, y, w].map(DVec4::truncate);
    let [across, down, forward] = rows;
    // Y is down where the three are a left-handed system.
    let upward = if across.cross(down).dot(forward) > 0.0 { -down } else { down };
    let eye = DMat3::from_cols(across, down, forward).transpose();
    if eye.determinant().abs() < 1e-12 {
        return Err("its rows X, Y and W depend on each other".to_owned());
    }
    let eye = eye.inverse() * -DVec3::new(x.w, y.w, w.w);
    // What lies ahead is seen beside the middle by what a row has of W's.
    let [beside, above] = [across, upward].map(|row| row.dot(forward));
    let (right, up) = (across - beside * forward, upward - above * forward);
    let skew = right.dot(up).abs() / (right.length() * up.length());
    if skew > TOLERANCE {
        return Err(format!("its rows X and Y are not at right angles (off by {skew:.4})"));
    }
    let shape = up.length() / right.length();
    let vertical_fov = 2.0 * (1.0 / up.length()).atan().to_degrees();
    let shift = -0.5 * DVec2::new(shape * beside, above);
    Ok((Camera { eye, target: eye + forward, up: up.normalize(), vertical_fov, shift, ..Camera::default() }, shape))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::array::tests::{npy, write_archive};
    use crate::io::tests::Folder;

    /// The rows of a camera's matrix for pictures twice as wide as high.
    fn rows(camera: &Camera, down: f64) -> [DVec4; 4] {
        let rotation = camera.rotation();
        let half = camera.half_extent([2, 1]);
        let row = |axis: usize, scale: f64| {
            let row = rotation.row(axis) * scale;
            row.extend(-row.dot(camera.eye))
        };
        [row(0, 1.0 / half.x), row(1, down / half.y), DVec4::W, row(2, 1.0)]
    }

    #[test]
    fn a_matrix_is_taken_apart_whichever_way_y_is() {
        let camera = Camera { eye: DVec3::new(1.0, 2.0, 5.0), target: DVec3::new(0.5, 1.0, 0.0), ..Camera::default() };
        for down in [1.0, -1.0] {
            let (found, shape) = camera_of(rows(&camera, down).map(|row| row * 3.0)).unwrap();
            assert!((shape - 2.0).abs() < 1e-12);
            assert!((found.eye - camera.eye).length() < 1e-9, "{found:?}");
            assert!((found.vertical_fov - camera.vertical_fov).abs() < 1e-9);
            let differs = found.rotation() - camera.rotation();
            assert!(differs.to_cols_array().iter().all(|x| x.abs() < 1e-9), "{differs:?}");
        }
        assert!(camera_of([DVec4::ZERO; 4]).is_err());
        let mut sheared = rows(&camera, 1.0);
        sheared[0] += 0.1 * sheared[3];
        assert!(camera_of(sheared).is_ok(), "a lens that is shifted");
        sheared[0] += 0.1 * sheared[1];
        assert!(camera_of(sheared).unwrap_err().contains("right angles"));
    }

    /// What a camera makes is what it is found to be: the same matrices, of another shape of pixels, too.
    #[test]
    fn a_lens_that_is_shifted_and_wide_pixels_are_found() {
        let (eye, target) = (DVec3::new(1.0, 2.0, 5.0), DVec3::new(0.5, 1.0, 0.0));
        let shift = DVec2::new(0.3, -0.2);
        let camera = Camera { eye, target, shift, pixel_aspect: 2.0, ..Camera::default() };
        let whole = |camera: &Camera| {
            let view = camera.view([640, 480]);
            view.view_to_clip * view.world_to_view
        };
        let made = whole(&camera).transpose();
        let (found, shape) = camera_of([made.x_axis, made.y_axis, made.z_axis, made.w_axis]).unwrap();
        assert!((shape - 2.0 * 640.0 / 480.0).abs() < 1e-9 && (found.shift - shift).length() < 1e-9, "{found:?}");
        let again = whole(&Camera { pixel_aspect: 2.0, ..found });
        assert!(again.abs_diff_eq(whole(&camera), 1e-9), "{again} {}", whole(&camera));
    }

    #[test]
    fn matrices_come_one_a_frame() {
        let folder = Folder::new();
        let path = folder.0.join("camera.npz");
        let camera = Camera::default();
        let bytes: Vec<u8> =
            (0..2).flat_map(|_| rows(&camera, 1.0)).flat_map(|row| row.to_array()).flat_map(f64::to_le_bytes).collect();
        write_archive(&path, &[("view_projection", npy("'<f8'", false, "(2, 4, 4)", &bytes))]);
        assert_eq!(matrices(&path, [5, 6], 2.0).unwrap().len(), 2);
        let error = matrices(&path, [5, 6], 1.5).unwrap_err().to_string();
        let words = ["2.0000 times as wide as high", "1.5000 times", "camera.pixel_aspect"];
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
        let error = matrices(&path, [5, 7], 2.0).unwrap_err().to_string();
        assert!(error.contains("[2, 4, 4]") && error.contains("frames 5 to 7"), "{error}");
    }
}
