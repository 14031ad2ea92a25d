//! A view of a picture, taken apart into what kernels work with.

use glam::{DMat3, DMat4, DVec2, DVec3};

use super::{FARTHEST, MOST_JITTER, NARROWEST, View, WIDEST, is_near};
use crate::error::{Error, Result};
use crate::shaders::shared::blocks::CameraRows;

/// How far rows of a rotation may be from length 1 and from right angles: what single floats leave of it.
const ROUNDING: f64 = 1e-5;
/// Share of a row of a projection below which an entry counts as none.
const NOTHING: f64 = 1e-6;
/// Share of an orthographic view's depth that its near plane is ahead of the eye, at least.
const LEAST_NEAR: f64 = 1e-3;

/// A [`View`] of a picture of so many pixels.
///
/// View space has x to the picture's right, y up and z ahead, in metres, whichever way the host's has them. A place (x, y, z) of it is
/// seen at `centre + focal * (x, -y) / w` pixels: w is its depth z, or 1 if the view is orthographic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Where depth is counted from. Of an orthographic view whose near plane is not ahead of its origin, a place so far behind
    /// that plane as the far one is ahead of it.
    pub eye: DVec3,
    /// Rows right, up and ahead, of length 1 and at right angles; mirrored views have them left-handed or right-handed alike.
    pub axes: DMat3,
    /// Pixels that a slope of 1 has to the right and up; orthographic: that a metre has.
    pub focal: DVec2,
    /// Where a slope of 0 is seen, in pixels; orthographic: what lies before the eye.
    pub centre: DVec2,
    /// The nearest depth that is seen, above 0.
    pub near: f64,
    /// The farthest; may be infinite.
    pub far: f64,
    /// Whether rays are parallel.
    pub is_orthographic: bool,
    /// What the host's depth images hold at depth z: `depth_terms[0] + depth_terms[1] / z`; orthographic: `... * z`.
    pub depth_terms: [f64; 2],
}

/// View space to clip coordinates: what is left of a projection without its scale.
struct Rows {
    across: [f64; 4],
    down: [f64; 4],
    depth: [f64; 4],
    is_orthographic: bool,
    /// 1 if view space's z axis points ahead, else -1.
    ahead: f64,
}

fn refuse<T>(name: &'static str, value: impl ToString, allowed: impl Into<String>) -> Result<T> {
    Err(Error::setting(name, value, allowed))
}

impl Projection {
    /// That of a view for a picture of `size` pixels; the error names the matrix.
    pub fn new(view: &View, size: [u32; 2]) -> Result<Projection> {
        let (rotation, origin) = motion_of(&view.world_to_view)?;
        let rows = Rows::new(view)?;
        let (axes, focal, centre) = rows.picture(view)?;
        let axes = DMat3::from_cols(
            rotation.transpose() * axes[0],
            rotation.transpose() * axes[1],
            rotation.transpose() * axes[2],
        );
        let depth_terms = [rows.depth[2], rows.depth[3]];
        let (near, far) = rows.range(view)?;
        let half = DVec2::from_array(size.map(f64::from)) / 2.0;
        if !(view.jitter.iter().all(|jitter| jitter.abs() <= MOST_JITTER)) {
            let allowed = format!("pixels to the right and down, none beyond {MOST_JITTER}");
            return refuse("view.jitter", format!("{:?}", view.jitter), allowed);
        }
        let mut projection = Projection {
            eye: origin,
            axes: axes.transpose(),
            focal: focal * half,
            centre: (centre + 1.0) * half + DVec2::from_array(view.jitter),
            near,
            far,
            is_orthographic: rows.is_orthographic,
            depth_terms,
        };
        projection.move_eye_back();
        if !is_near(projection.eye) {
            return refuse(
                "view.world_to_view",
                view.world_to_view,
                "an eye, none of whose coordinates is beyond 1e12 m",
            );
        }
        Ok(projection)
    }

    /// That of a view that has been validated; through another one nothing is at any place.
    pub fn of_valid(view: &View, size: [u32; 2]) -> Projection {
        Projection::new(view, size).unwrap_or(Projection {
            eye: DVec3::NAN,
            axes: DMat3::ZERO,
            focal: DVec2::NAN,
            centre: DVec2::NAN,
            near: f64::INFINITY,
            far: f64::INFINITY,
            is_orthographic: false,
            depth_terms: [0.0; 2],
        })
    }

    /// Effects count on depths above 0.
    fn move_eye_back(&mut self) {
        let range = self.far - self.near;
        if self.is_orthographic && self.near < LEAST_NEAR * range {
            let back = range - self.near;
            self.eye -= back * self.axes.row(2);
            self.near += back;
            self.far += back;
            self.depth_terms[0] -= self.depth_terms[1] * back;
        }
    }

    /// Whether triangles that run counter-clockwise in a right-handed world are seen clockwise.
    pub fn is_mirrored(&self) -> bool {
        self.axes.determinant() > 0.0
    }

    /// World to view space.
    pub fn to_view(&self, position: DVec3) -> DVec3 {
        self.axes * (position - self.eye)
    }

    /// The eye, homogeneous: where it is and 1; orthographic: the unit vector to it and 0.
    pub fn eye_terms(&self) -> [f32; 4] {
        let (way, w) = if self.is_orthographic { (-self.axes.row(2), 0.0) } else { (self.eye, 1.0) };
        way.extend(w).as_vec4().to_array()
    }

    /// What a slope of 1 has in metres, at a depth.
    pub fn widening(&self, depth: f64) -> f64 {
        if self.is_orthographic { 1.0 } else { depth }
    }

    /// The pixel that a place of view space is seen at; y down.
    pub fn pixel_of(&self, place: DVec3) -> DVec2 {
        self.centre + self.focal * DVec2::new(place.x, -place.y) / self.widening(place.z)
    }

    /// Slope of what is seen at a pixel, to the right and up; orthographic: metres.
    pub fn slope_at(&self, pixel: DVec2) -> DVec2 {
        (pixel - self.centre) / self.focal * DVec2::new(1.0, -1.0)
    }

    /// Where the ray through a pixel is at depth 0, and where it goes with each metre of depth, in view space.
    pub fn ray_at(&self, pixel: DVec2) -> [DVec3; 2] {
        let slope = self.slope_at(pixel);
        match self.is_orthographic {
            true => [slope.extend(0.0), DVec3::Z],
            false => [DVec3::ZERO, slope.extend(1.0)],
        }
    }

    /// Slopes at the left and upper, and at the right and lower border of a picture of `size` pixels.
    pub fn borders(&self, size: [u32; 2]) -> [DVec2; 2] {
        [DVec2::ZERO, DVec2::from_array(size.map(f64::from))].map(|corner| self.slope_at(corner))
    }

    /// [`Self::depth_terms`], rounded.
    pub(crate) fn terms(&self) -> [f32; 2] {
        self.depth_terms.map(|term| term as f32)
    }
}

/// The rotation of a rigid motion, and the place that it moves to the origin.
fn motion_of(motion: &DMat4) -> Result<(DMat3, DVec3)> {
    let rotation = DMat3::from_mat4(*motion);
    let off = rotation * rotation.transpose() - DMat3::IDENTITY;
    let off = off.to_cols_array().into_iter().fold(0.0, |most: f64, x| if x.abs() <= most { most } else { x.abs() });
    let last = motion.row(3) - glam::DVec4::W;
    if !(off <= ROUNDING && motion.is_finite() && last == glam::DVec4::ZERO) {
        let allowed =
            "a rotation and a translation in metres: rows of length 1 at right angles, the last one 0, 0, 0, 1";
        return refuse("view.world_to_view", motion, allowed);
    }
    // What is exact stays so.
    let rotation = if off < 1e-12 { rotation } else { upright(rotation) };
    Ok((rotation, -(rotation.transpose() * motion.w_axis.truncate())))
}

/// The rotation that is meant by one whose entries are rounded.
fn upright(rotation: DMat3) -> DMat3 {
    let [x, y, z] = [0, 1, 2].map(|row| rotation.row(row));
    let ahead = z.normalize();
    let right = (x - x.dot(ahead) * ahead).normalize();
    let up = y - y.dot(ahead) * ahead;
    let up = (up - up.dot(right) * right).normalize();
    DMat3::from_cols(right, up, ahead).transpose()
}

impl Rows {
    fn new(view: &View) -> Result<Rows> {
        let clip = &view.view_to_clip;
        let [across, down, depth, w] = [0, 1, 2, 3].map(|row| clip.row(row).to_array());
        let largest = w.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let is_none = |x: f64| x.abs() <= NOTHING * largest;
        let is_orthographic = is_none(w[2]);
        let scale = if is_orthographic { w[3] } else { w[2] };
        let others = if is_orthographic { [w[0], w[1], w[2]] } else { [w[0], w[1], w[3]] };
        if !(clip.is_finite() && largest > 0.0 && others.into_iter().all(is_none)) || is_orthographic && scale < 0.0 {
            let allowed =
                "a last row of 0, 0, 1, 0 or 0, 0, -1, 0 (perspective) or of 0, 0, 0, 1 (orthographic), in any scale";
            return refuse("view.view_to_clip", clip, allowed);
        }
        let by = |row: [f64; 4]| row.map(|x| x / scale.abs());
        let mut rows =
            Rows { across: by(across), down: by(down), depth: by(depth), is_orthographic, ahead: scale.signum() };
        if is_orthographic {
            // Where depth grows, or, reversed, falls.
            rows.ahead = if view.reversed { -rows.depth[2].signum() } else { rows.depth[2].signum() };
        }
        // From here on as if the z axis pointed ahead.
        for row in [&mut rows.across, &mut rows.down, &mut rows.depth] {
            row[2] *= rows.ahead;
        }
        if is_orthographic {
            rows.depth.swap(2, 3);
        }
        Ok(rows)
    }

    /// Axes of the picture in view space, what a unit along x and y has of half a picture, and what the axis ahead is seen at.
    fn picture(&self, view: &View) -> Result<([DVec3; 3], DVec2, DVec2)> {
        let wrong = |allowed: &str| refuse("view.view_to_clip", view.view_to_clip, allowed);
        let axis = |[x, y, ..]: [f64; 4]| DVec2::new(x, y);
        let (right, down) = (axis(self.across), axis(self.down));
        let focal = DVec2::new(right.length(), down.length());
        // Widths of half a picture: slopes, or metres.
        let allowed = match self.is_orthographic {
            true => 1e-12..=f64::from(FARTHEST),
            // Wide pictures are wider than high.
            false => (NARROWEST / 2.0).to_radians().tan() * 1e-5..=(WIDEST / 2.0).to_radians().tan() * 1e5,
        };
        if ![focal.x, focal.y].into_iter().all(|scale| allowed.contains(&scale.recip())) {
            return wrong("a picture that is 1e-9 to 180 - 1e-9 degrees wide and high, or 1e-12 to 1e12 m");
        }
        if right.dot(down).abs() > ROUNDING * focal.x * focal.y {
            return wrong("x and y of the picture at right angles");
        }
        let (moved, unused) = if self.is_orthographic { (3, 2) } else { (2, 3) };
        let centre = DVec2::new(self.across[moved], self.down[moved]);
        let (across, down) = (self.across[unused], self.down[unused]);
        if across.abs() > NOTHING * focal.x || down.abs() > NOTHING * focal.y {
            return wrong(
                "x and y of the picture that depend on depth only by the division, or not at all (orthographic)",
            );
        }
        if !is_near(centre.extend(0.0)) {
            return wrong("a picture off the axis by at most 1e12 of its halves");
        }
        let right = (right / focal.x).extend(0.0);
        let up = -(axis(self.down) / focal.y).extend(0.0);
        Ok(([right, up, DVec3::Z * self.ahead], focal, centre))
    }

    /// The depths at the near and far plane.
    fn range(&self, view: &View) -> Result<(f64, f64)> {
        let wrong = |allowed: &str| refuse("view.view_to_clip", view.view_to_clip, allowed);
        let [x, y, offset, factor] = self.depth;
        let (at_near, at_far) = if view.reversed { (1.0, 0.0) } else { (0.0, 1.0) };
        if x.abs().max(y.abs()) > NOTHING * offset.abs().max(factor.abs()) {
            return wrong("depth that does not depend on x and y");
        }
        let (near, far) = match self.is_orthographic {
            true => ((at_near - offset) / factor, (at_far - offset) / factor),
            false if (factor > 0.0) != view.reversed || factor == 0.0 => {
                let said = if view.reversed { "1 at the near plane" } else { "0 at the near plane" };
                return wrong(&format!("depth that is {said}, as view.reversed = {} has it", view.reversed));
            }
            false => (factor / (at_near - offset), factor / (at_far - offset)),
        };
        // What never gets as far as the far plane's depth is at infinity, or beyond.
        let is_infinite = !self.is_orthographic && (far.is_nan() || far <= 0.0);
        let far = if is_infinite { f64::INFINITY } else { far };
        let least = if self.is_orthographic { -f64::from(FARTHEST) } else { 1e-9 };
        let most = f64::from(FARTHEST);
        let is_far = far > near && (far <= most || !self.is_orthographic);
        match (least..=most).contains(&near) && is_far {
            true => Ok((near, far)),
            false => wrong(
                "a near plane 1e-9 to 1e12 m ahead (orthographic: at most 1e12 m away), and a far plane behind it",
            ),
        }
    }
}

impl CameraRows {
    pub(crate) fn new(projection: &Projection) -> CameraRows {
        let split = |v: DVec3| {
            let high = v.as_vec3();
            [high, (v - high.as_dvec3()).as_vec3()].map(|part| part.extend(0.0).to_array())
        };
        let [right, up, forward] = [0, 1, 2].map(|axis| split(projection.axes.row(axis)));
        let [eye, eye_low] = split(projection.eye);
        CameraRows {
            eye,
            eye_low,
            right: right[0],
            up: up[0],
            forward: forward[0],
            right_low: right[1],
            up_low: up[1],
            forward_low: forward[1],
        }
    }
}
