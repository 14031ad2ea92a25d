//! Front and rear of rows, against brute force and closed forms.

use super::*;
use crate::blur::settings::Extent;

/// Position, k and l of each point.
struct Row {
    place: [f64; 2],
    k: f64,
    l: f64,
}

fn rows_of(shot: &Shot, settings: &Settings, frame: usize) -> (Interval, Vec<Row>) {
    let interval = shot.interval(settings, frame);
    let row = |point: usize| {
        let (motion, cluster) = (interval.motion[point], interval.cluster(interval.labels[point]).unwrap());
        let [k, l] = extent::extent_in(motion, cluster, interval.bounds_of(cluster)).map(f64::from);
        Row { place: [motion[0].into(), motion[1].into()], k, l }
    };
    let rows = (0..shot.mesh.points()).map(row).collect();
    (interval, rows)
}

/// A sheet of vertices that moves 40 pixels a frame to the right: where the vertex in column u and row v (0 to 1) is in frame 1.
fn sheet(columns: u32, rows: u32, at: impl Fn(f64, f64) -> [f64; 2]) -> Shot {
    let count = (columns * rows) as usize;
    Shot::new(mesh(count, &grid(columns, rows), None), 4, |p, f| {
        let [u, v] = [p as u32 % columns, p as u32 / columns].map(f64::from);
        let [x, y] = at(u / f64::from(columns - 1), v / f64::from(rows - 1));
        at_pixel(400.0 + x + 40.0 * (f as f64 - 1.0), 300.0 + y)
    })
}

/// Every row has the bounds that all points and edges of its cluster say, in f64.
pub(super) fn check_rows(mesh: &Mesh, interval: &Interval) {
    for (label, cluster) in (1..).zip(&interval.clusters).filter(|(_, cluster)| cluster.has_rows()) {
        let members: Vec<usize> = (0..mesh.points()).filter(|point| interval.labels[*point] == label).collect();
        let places: Vec<[f64; 2]> = members
            .iter()
            .map(|point| [interval.motion[*point][0].into(), interval.motion[*point][1].into()])
            .collect();
        let edges = members.iter().enumerate().flat_map(|(at, point)| {
            let others = mesh.neighbours().of(*point).iter();
            others.filter_map(|other| members.binary_search(&(*other as usize)).ok()).map(move |other| [at, other])
        });
        let (edges, bounds): (Vec<[usize; 2]>, _) = (edges.collect(), interval.bounds_of(cluster));
        let far = places.iter().flatten().fold(1.0, |far: f64, c| far.max(c.abs()));
        for (row, expected) in extent::rows(cluster, &places, &edges, bounds.len()).into_iter().enumerate() {
            for side in 0..2 {
                let off = (f64::from(bounds[row][side]) - expected[side]).abs();
                // Half an ulp of the float that is kept.
                assert!(off <= 1e-7 * far * 2.0, "row {row} of {}: {:?}, {expected:?}", bounds.len(), bounds[row]);
            }
        }
    }
}

#[test]
fn what_leads_in_its_row_leads() {
    // A bar that leans by 45 degrees: each row has a front of its own.
    let shot = sheet(9, 201, |u, v| [300.0 * v + 30.0 * u, 300.0 * v]);
    let front = |settings: &Settings| {
        let (_, rows) = rows_of(&shot, settings, 1);
        let [front, rear] =
            [8, 0].map(|column| rows.iter().skip(column).step_by(9).map(|row| row.k).collect::<Vec<_>>());
        [front.iter().copied().fold(1.0, f64::min), rear.iter().copied().fold(0.0, f64::max)]
    };
    let [least, most] = front(&Settings::default());
    // A row is 3 pixels: where it is nearer to its neighbour, its front is 1.5 pixels farther, of 30.
    assert!(least > 0.94 && most < 0.06, "{least}, {most}");
    let [least, most] = front(&Settings { extent: Extent::Part, ..Settings::default() });
    assert!(least < 0.1 && most > 0.85, "{least}, {most}");
}

#[test]
fn of_what_is_straight_k_is_the_papers() {
    let shot = sheet(12, 7, |u, v| [90.0 * u, 1.5 * v]);
    for (row, whole) in rows_of(&shot, &Settings::default(), 1)
        .1
        .iter()
        .zip(rows_of(&shot, &Settings { extent: Extent::Part, ..Settings::default() }, 1).1)
    {
        // Floats of 500 pixels, of 90.
        assert!((row.k - whole.k).abs() < 1e-6 && (row.l - whole.l).abs() < 1e-4, "{} {}", row.k, whole.k);
    }
}

/// A peg of a third of the height stands out to the front: beside it front and k change by shares of half a tooth, not at once.
#[test]
fn k_does_not_jump_beside_what_sticks_out() {
    let shot = sheet(61, 241, |u, v| {
        let is_peg = (v - 0.5).abs() < 1.0 / 6.0;
        [100.0 * u * if is_peg { 2.0 } else { 1.0 }, 120.0 * v]
    });
    let (interval, rows) = rows_of(&shot, &Settings::default(), 1);
    let last = (interval.bounds.len() - 1) as f64;
    let middle: Vec<&Row> = rows.iter().filter(|row| (row.place[0] - 470.0).abs() < 1e-3).collect();
    assert!(middle.len() > 150);
    for pair in middle.windows(2) {
        // Of five rows that a mean is of, one more has a front of 200 instead of 100 pixels.
        let most = (0.5 - 0.25) / 5.0 * 2.2 * (pair[1].l - pair[0].l).abs() * last + 1e-6;
        assert!((pair[1].k - pair[0].k).abs() <= most, "{:?} {} {}", pair[0].place, pair[0].k, pair[1].k);
    }
    let at = |y: f64| middle.iter().min_by(|a, b| (a.place[1] - y).abs().total_cmp(&(b.place[1] - y).abs())).unwrap().k;
    assert!((at(310.0) - 0.5).abs() < 1e-3 && (at(360.0) - 0.25).abs() < 1e-3, "{} {}", at(310.0), at(360.0));
}

/// Where nothing of a part is in a row, as between pieces that only their nearness joins, bounds lie between those beside it.
#[test]
fn rows_with_nothing_lie_between_others() {
    let shot = sheet(2, 2, |u, v| [10.0 * u + 20.0 * v, 90.0 * v]);
    let apart = Shot { mesh: mesh(4, &[[0, 1, 0], [2, 3, 2]], None), ..shot };
    let near = Settings { angle: 180.0, clusters: settings::Clusters::Ldf, ..Settings::default() };
    let (interval, _) = rows_of(&apart, &near, 1);
    assert_eq!(interval.clusters.len(), 1);
    let bounds = interval.bounds_of(&interval.clusters[0]);
    let (first, last) = (bounds[3], bounds[bounds.len() - 4]);
    for (row, found) in bounds.iter().enumerate().skip(3).take(bounds.len() - 6) {
        let share = (row - 3) as f32 / (bounds.len() - 7) as f32;
        for side in 0..2 {
            let expected = first[side] + share * (last[side] - first[side]);
            assert!((found[side] - expected).abs() < 1e-3, "{row}: {found:?} {expected}");
        }
    }
}

/// What turns about its middle has no common direction: its k is that of the whole part.
#[test]
fn what_goes_all_ways_has_no_rows() {
    let shot = Shot::new(mesh(40, &grid(20, 2), None), 4, |p, f| {
        let (radius, turn) =
            (20.0 + 5.0 * (p / 20) as f64, (p % 20) as f64 / 20.0 * std::f64::consts::TAU + 0.2 * f as f64);
        at_pixel(900.0 + radius * turn.cos(), 500.0 + radius * turn.sin())
    });
    let settings = Settings { angle: 180.0, clusters: settings::Clusters::Ldf, ..Settings::default() };
    let (interval, _) = rows_of(&shot, &settings, 1);
    let whole = shot.interval(&Settings { extent: Extent::Part, ..settings }, 1);
    let without = interval.clusters.iter().filter(|cluster| !cluster.has_rows()).count();
    assert!(without > 0 || interval.clusters.len() > 1);
    assert_eq!(interval.labels, whole.labels);
    for (own, whole) in interval.clusters.iter().zip(&whole.clusters).filter(|(own, _)| !own.has_rows()) {
        assert_eq!(interval.bounds_of(own), &whole_bounds(&shot, own, &interval)[..]);
        assert_eq!((own.teeth, own.ahead), (whole.teeth, [0.0; 2]));
    }
}

fn whole_bounds(shot: &Shot, cluster: &Cluster, interval: &Interval) -> Vec<[f32; 2]> {
    let label = 1 + interval.clusters.iter().position(|other| other == cluster).unwrap() as u32;
    let members = (0..shot.mesh.points()).filter(|point| interval.labels[*point] == label);
    outline(&members.map(|point| [interval.motion[point][0], interval.motion[point][1]]).collect::<Vec<_>>())
}

/// Parts that are very wide have coarser rows, so that there is room for all.
#[test]
fn there_is_room_for_all_rows() {
    let settings = Settings { clusters: settings::Clusters::Ldf, ..Settings::default() };
    let wide = |p: usize, f: usize| at_pixel(300.0 + 40.0 * f as f64, 1e5 * (p / 3) as f64 + 7.0 * (p % 3) as f64);
    let objects: Vec<u32> = (0..4).flat_map(|object| [object; 6]).collect();
    let triangles: Vec<[u32; 3]> = (0..8).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let shot = Shot::new(mesh(24, &triangles, Some(&objects)), 4, wide);
    let interval = shot.interval(&settings, 1);
    assert_eq!(interval.bounds.len() as u64, most_bounds(24), "three parts have two rows a point, one has all else");
    assert!(interval.clusters.iter().all(Cluster::has_rows));
}
