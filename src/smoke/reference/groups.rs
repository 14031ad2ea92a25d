//! Depth groups of spheres, the ID mask of the paper (section 3.3): equal ranges of centre depth.

use glam::DVec3;

use super::particles::Origin;
use crate::smoke::settings::Settings;
use crate::view::{Projection, View};

/// Equal ranges of depth, one after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranges {
    /// Where the first begins, metres.
    pub start: f64,
    /// How wide each is, metres; 0 if all depths are one.
    pub width: f64,
    /// How many there are.
    pub count: u32,
}

impl Ranges {
    /// As the device has them: the width's inverse, 0 if there is none.
    pub fn of_device(start: f32, per_metre: f32, count: u32) -> Ranges {
        let width = if per_metre > 0.0 { f64::from(per_metre).recip() } else { 0.0 };
        Ranges { start: start.into(), width, count }
    }

    /// Where a depth lies, in widths from the start, between 0 and the number of ranges.
    pub fn coordinate(&self, depth: f64) -> f64 {
        let position = (depth - self.start) / self.width;
        if self.width > 0.0 { position.clamp(0.0, f64::from(self.count)) } else { 0.0 }
    }

    /// The range that a depth lies in, from 1.
    pub fn group(&self, depth: f64) -> u32 {
        (1 + self.coordinate(depth) as u32).min(self.count)
    }
}

/// Remembers the range and the groups of the last frame. A new one starts afresh.
#[derive(Clone, Debug, Default)]
pub struct Groups {
    range: Option<[f64; 2]>,
    /// That of the depths themselves.
    depths: Option<[f64; 2]>,
    groups: Vec<u32>,
}

impl Groups {
    /// Group of every sphere of this frame, 1 to [`Settings::group_count`]; 0 where the radius is 0.
    ///
    /// Under the soft mask no sphere keeps its group. `spheres` are centre and displayed radius in metres, `origins` what each was in the frame before.
    pub fn step(&mut self, settings: &Settings, view: &View, spheres: &[[f64; 4]], origins: &[Origin]) -> Vec<u32> {
        let depths = ahead(view, spheres);
        self.range = smoothed(self.range, depths, f64::from(settings.range_smoothing));
        self.regroup(settings, view, spheres, origins, depths)
    }

    /// The same in a frame of the same moment: what is smoothed moves as depths do with the camera.
    pub fn hold(&mut self, settings: &Settings, view: &View, spheres: &[[f64; 4]]) -> Vec<u32> {
        let depths = ahead(view, spheres);
        self.range = match (self.range, self.depths, depths) {
            (Some(range), Some(before), Some(now)) => Some([0, 1].map(|end| range[end] + now[end] - before[end])),
            _ => depths,
        };
        self.regroup(settings, view, spheres, &vec![Origin::Kept; spheres.len()], depths)
    }

    fn regroup(
        &mut self,
        settings: &Settings,
        view: &View,
        spheres: &[[f64; 4]],
        origins: &[Origin],
        depths: Option<[f64; 2]>,
    ) -> Vec<u32> {
        self.depths = depths;
        // Depth is the same whatever the picture's size.
        let projection = Projection::of_valid(view, [1, 1]);
        let depth = |[x, y, z, _]: &[f64; 4]| projection.to_view(DVec3::new(*x, *y, *z)).z;
        let ranges = self.ranges(settings);
        let previous = std::mem::take(&mut self.groups);
        let group = |(place, (sphere, origin)): (usize, (&[f64; 4], &Origin))| {
            if sphere[3] <= 0.0 {
                return 0;
            }
            let previous = match origin {
                _ if settings.is_soft() => None,
                Origin::Fresh => None,
                Origin::Kept => previous.get(place),
                Origin::Ghost(slot) => previous.get(*slot),
            };
            kept_group(&ranges, depth(sphere), previous.copied(), f64::from(settings.hysteresis))
        };
        self.groups = spheres.iter().zip(origins).enumerate().map(group).collect();
        self.groups.clone()
    }

    /// The ranges that groups are.
    pub fn ranges(&self, settings: &Settings) -> Ranges {
        let (start, width) = match (settings.group_depth, self.range) {
            (Some(depth), _) => (0.0, f64::from(depth)),
            (None, Some([z0, z1])) => (z0, (z1 - z0) / f64::from(settings.groups)),
            (None, None) => (0.0, 0.0),
        };
        Ranges { start, width, count: settings.group_count() }
    }

    /// The smoothed range of centre depth in metres; none while nothing is ahead of the near plane.
    pub fn range(&self) -> Option<[f64; 2]> {
        self.range
    }
}

/// The range of centre depth of what is ahead of the near plane.
fn ahead(view: &View, spheres: &[[f64; 4]]) -> Option<[f64; 2]> {
    let projection = Projection::of_valid(view, [1, 1]);
    let depths = spheres.iter().filter(|s| s[3] > 0.0).map(|s| projection.to_view(DVec3::new(s[0], s[1], s[2])).z);
    depths.filter(|z| *z >= projection.near).map(|z| [z, z]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// The next smoothed range: the share `kept` of the old one, unless there is none or they do not overlap.
fn smoothed(old: Option<[f64; 2]>, fresh: Option<[f64; 2]>, kept: f64) -> Option<[f64; 2]> {
    match (old, fresh) {
        (Some(old), Some(fresh)) if old[0] <= fresh[1] && fresh[0] <= old[1] => {
            Some([0, 1].map(|i| kept * old[i] + (1.0 - kept) * fresh[i]))
        }
        (_, fresh) => fresh,
    }
}

/// The group at a depth; the previous one within `hysteresis` of it.
fn kept_group(ranges: &Ranges, depth: f64, previous: Option<u32>, hysteresis: f64) -> u32 {
    let position = (depth - ranges.start) / ranges.width;
    match previous {
        Some(group @ 1..) if ranges.width > 0.0 => {
            let group_end = f64::from(group);
            let kept = group_end - 1.0 - hysteresis <= position && position <= group_end + hysteresis;
            if kept { group } else { ranges.group(depth) }
        }
        _ => ranges.group(depth),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smoke::settings::Mask;
    use crate::view::Camera;

    /// Looks along -z from the origin: a sphere at z = -d has depth d.
    fn camera() -> Camera {
        Camera { eye: DVec3::ZERO, target: -DVec3::Z, near: 0.5, ..Camera::default() }
    }

    fn at_depths(depths: &[f64]) -> Vec<[f64; 4]> {
        depths.iter().map(|d| [0.3, -0.2, -d, 1.0]).collect()
    }

    fn step(groups: &mut Groups, settings: &Settings, depths: &[f64], origin: Origin) -> Vec<u32> {
        groups.step(settings, &camera().view([1, 1]), &at_depths(depths), &vec![origin; depths.len()])
    }

    #[test]
    fn groups_are_equal_ranges_of_the_depths_ahead_of_the_near_plane() {
        let settings = Settings { groups: 4, ..Settings::default() };
        let mut groups = Groups::default();
        let mut spheres = at_depths(&[2.0, 3.0, 3.5, 4.0, 9.0, 10.0, 0.4, -7.0, 50.0]);
        spheres[8][3] = 0.0;
        let ids = groups.step(&settings, &camera().view([1, 1]), &spheres, &[Origin::Fresh; 9]);
        assert_eq!(groups.range(), Some([2.0, 10.0]));
        // Width 2; the two behind the near plane clamp to the first group; radius 0 has none.
        assert_eq!(ids, [1, 1, 1, 2, 4, 4, 1, 1, 0]);
    }

    #[test]
    fn one_depth_is_group_one_and_fixed_depths_count_from_the_camera() {
        let settings = Settings { groups: 5, ..Settings::default() };
        assert_eq!(step(&mut Groups::default(), &settings, &[3.0, 3.0], Origin::Fresh), [1, 1]);
        assert_eq!(step(&mut Groups::default(), &settings, &[-3.0, -2.0], Origin::Fresh), [1, 1]);
        let settings = Settings { group_depth: Some(0.5), ..settings };
        let ids = step(&mut Groups::default(), &settings, &[0.0, 0.6, 3.0, 1e6], Origin::Fresh);
        assert_eq!(ids, [1, 2, 7, 254]);
    }

    #[test]
    fn a_sphere_keeps_its_group_until_it_is_past_the_hysteresis() {
        // Spheres at 0.5 and 10.5 pin the range; width 1, hysteresis 0.2; group 3 is 2.5 to 3.5.
        let settings = Settings { groups: 10, mask: Mask::Groups, ..Settings::default() };
        let mut groups = Groups::default();
        let mut third = |depth, origin| step(&mut groups, &settings, &[0.5, 10.5, depth], origin)[2];
        assert_eq!(third(3.0, Origin::Fresh), 3);
        assert_eq!(third(3.65, Origin::Kept), 3);
        assert_eq!(third(2.35, Origin::Kept), 3);
        assert_eq!(third(3.75, Origin::Kept), 4);
        assert_eq!(third(3.35, Origin::Kept), 4);
        assert_eq!(third(3.35, Origin::Fresh), 3);
        assert_eq!(third(8.6, Origin::Kept), 9);
    }

    #[test]
    fn a_ghost_inherits_the_group_that_its_particle_had() {
        let settings = Settings { groups: 10, mask: Mask::Groups, ..Settings::default() };
        let mut groups = Groups::default();
        assert_eq!(step(&mut groups, &settings, &[0.5, 10.5, 3.0, 9.0], Origin::Fresh), [1, 10, 3, 9]);
        // Slot 2 died at 3.6 and was reborn at 3.6; its ghost takes the last place.
        let origins = [Origin::Kept, Origin::Kept, Origin::Fresh, Origin::Ghost(2)];
        let ids = groups.step(&settings, &camera().view([1, 1]), &at_depths(&[0.5, 10.5, 3.6, 3.6]), &origins);
        assert_eq!(ids, [1, 10, 4, 3]);
    }

    #[test]
    fn the_range_follows_slowly_and_restarts_where_it_does_not_overlap() {
        let settings = Settings { range_smoothing: 0.75, ..Settings::default() };
        let mut groups = Groups::default();
        step(&mut groups, &settings, &[2.0, 6.0], Origin::Fresh);
        step(&mut groups, &settings, &[4.0, 6.0], Origin::Kept);
        assert_eq!(groups.range(), Some([2.5, 6.0]));
        step(&mut groups, &settings, &[7.0, 9.0], Origin::Kept);
        assert_eq!(groups.range(), Some([7.0, 9.0]));
        step(&mut groups, &settings, &[], Origin::Kept);
        assert_eq!(groups.range(), None);
        step(&mut groups, &settings, &[1.0, 8.0], Origin::Kept);
        assert_eq!(groups.range(), Some([1.0, 8.0]));
    }
    #[test]
    fn in_a_held_moment_the_range_goes_with_the_camera() {
        let settings = Settings { range_smoothing: 0.75, ..Settings::default() };
        let mut groups = Groups::default();
        step(&mut groups, &settings, &[2.0, 6.0], Origin::Fresh);
        step(&mut groups, &settings, &[4.0, 6.0], Origin::Kept);
        let view = |back| Camera { eye: DVec3::Z * back, ..camera() }.view([1, 1]);
        for back in [0.0, 0.0, 1.5] {
            groups.hold(&settings, &view(back), &at_depths(&[4.0, 6.0]));
            assert_eq!(groups.range(), Some([2.5 + back, 6.0 + back]));
        }
    }
}
