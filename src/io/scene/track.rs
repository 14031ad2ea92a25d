//! Animation of one property of one node: keys, and what is between them (glTF 2.0, section 3.11 and appendix C).

/// The target of a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
}

/// How values between keys come about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// Keys of one property of a node.
#[derive(Clone, Debug)]
pub(super) struct Track {
    pub(super) node: usize,
    pub(super) property: Property,
    pub(super) interpolation: Interpolation,
    /// Seconds, ascending, at least one.
    pub(super) times: Vec<f64>,
    /// A row of `width` numbers per key; for cubic splines three: in-tangent, value, out-tangent.
    pub(super) values: Vec<f64>,
    /// Numbers of a value: 3, for rotations 4 (x, y, z, w), for weights one per morph target.
    pub(super) width: usize,
}

impl Track {
    /// The value at a time, constant before the first key and after the last; `out` has `width` numbers. Rotations are of
    /// length 1.
    pub(super) fn sample(&self, seconds: f64, out: &mut [f64]) {
        let next = self.times.partition_point(|&time| time <= seconds);
        match next.checked_sub(1) {
            Some(key) if next < self.times.len() && self.interpolation != Interpolation::Step => {
                self.between(key, seconds, out);
            }
            key => out.copy_from_slice(self.value(key.unwrap_or(0))),
        }
        if self.property == Property::Rotation {
            normalize(out);
        }
    }

    /// The value at a time from `key` on and before the next one.
    fn between(&self, key: usize, seconds: f64, out: &mut [f64]) {
        // Not 0: the one key is not after `seconds`, the other is.
        let step = self.times[key + 1] - self.times[key];
        let u = (seconds - self.times[key]) / step;
        if self.interpolation == Interpolation::CubicSpline {
            return self.spline(key, step, u, out);
        }
        let (a, b) = (self.value(key), self.value(key + 1));
        let (from, to) = match self.property {
            Property::Rotation => slerp_shares(a, b, u),
            _ => (1.0 - u, u),
        };
        for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
            *out = from * a + to * b;
        }
    }

    /// Row number `row` of the values.
    fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.width..][..self.width]
    }

    fn value(&self, key: usize) -> &[f64] {
        match self.interpolation {
            Interpolation::CubicSpline => self.row(3 * key + 1),
            _ => self.row(key),
        }
    }

    /// The cubic Hermite spline between a key and the next one, `step` seconds later.
    fn spline(&self, key: usize, step: f64, u: f64, out: &mut [f64]) {
        let [a, leaving, arriving, b] = [3 * key + 1, 3 * key + 2, 3 * key + 3, 3 * key + 4].map(|row| self.row(row));
        let (u2, u3) = (u * u, u * u * u);
        for (i, out) in out.iter_mut().enumerate() {
            *out = (2.0 * u3 - 3.0 * u2 + 1.0) * a[i]
                + (u3 - 2.0 * u2 + u) * step * leaving[i]
                + (3.0 * u2 - 2.0 * u3) * b[i]
                + (u3 - u2) * step * arriving[i];
        }
    }
}

/// Shares of two unit quaternions in what is at `u` of the arc between them, the shorter way round.
fn slerp_shares(a: &[f64], b: &[f64], u: f64) -> (f64, f64) {
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let sign = if dot < 0.0 { -1.0 } else { 1.0 };
    let length = |sign: f64| a.iter().zip(b).map(|(a, b)| (a + sign * b).powi(2)).sum::<f64>().sqrt();
    // Exact for small angles too, where the arc cosine of the dot product is not.
    let angle = 2.0 * length(-sign).atan2(length(sign));
    match angle.sin() {
        sine if sine > 1e-9 => (((1.0 - u) * angle).sin() / sine, sign * (u * angle).sin() / sine),
        _ => (1.0 - u, sign * u),
    }
}

/// Makes a quaternion one of length 1; that of length 0 becomes no rotation.
fn normalize(q: &mut [f64]) {
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    match length > 0.0 {
        true => q.iter_mut().for_each(|x| *x /= length),
        false => q.copy_from_slice(&[0.0, 0.0, 0.0, 1.0]),
    }
}
