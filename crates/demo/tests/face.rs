//! The demo's mesh, handles, examples and performance have the properties that the solve and the exporters
//! need.
use glam::DVec3;
use rhytid_core::{Face, Mesh, VertexId};
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

const SIZE: usize = 20_000;

fn point(mesh: &Mesh, v: u32) -> DVec3 {
    DVec3::from_array(mesh.positions[v as usize])
}

/// Directed edges and how often each occurs.
fn directed_edges(mesh: &Mesh) -> BTreeMap<(u32, u32), usize> {
    let mut edges = BTreeMap::new();
    for face in mesh.faces.iter() {
        for (i, &a) in face.iter().enumerate() {
            *edges.entry((a, face[(i + 1) % face.len()])).or_default() += 1;
        }
    }
    edges
}

/// The boundary as closed loops of vertices.
fn boundary_loops(mesh: &Mesh) -> Vec<Vec<u32>> {
    let edges = directed_edges(mesh);
    let mut next: BTreeMap<u32, u32> = BTreeMap::new();
    for &(a, b) in edges.keys() {
        if !edges.contains_key(&(b, a)) {
            assert!(next.insert(a, b).is_none(), "the boundary touches itself at vertex {a}");
        }
    }
    let mut loops = Vec::new();
    while let Some((start, mut at)) = next.pop_first() {
        let mut ring = vec![start];
        while at != start {
            ring.push(at);
            at = next.remove(&at).expect("the boundary is closed");
        }
        loops.push(ring);
    }
    loops.sort_by_key(|ring| std::cmp::Reverse(ring.len()));
    loops
}

fn neighbours(mesh: &Mesh) -> Vec<BTreeSet<u32>> {
    let mut out = vec![BTreeSet::new(); mesh.positions.len()];
    for (a, b) in directed_edges(mesh).into_keys() {
        out[a as usize].insert(b);
        out[b as usize].insert(a);
    }
    out
}

fn handle(face: &Face, label: &str) -> usize {
    face.handles.labels.iter().position(|l| l == label).unwrap_or_else(|| panic!("no handle {label}"))
}

fn check_mesh(face: &Face, asked: usize) {
    let mesh = &face.neutral;
    let count = mesh.positions.len();
    assert!(count.abs_diff(asked) * 50 <= asked, "{count} vertices for {asked}");
    assert_eq!(mesh.uvs.as_ref().expect("texture coordinates").values.len(), count);
    assert!(mesh.uvs.iter().flat_map(|u| &u.values).flatten().all(|x| (0.0..=1.0).contains(x)));
    for corners in mesh.faces.iter() {
        let p: Vec<DVec3> = corners.iter().map(|&v| point(mesh, v)).collect();
        for k in 0..4 {
            let (a, b, c) = (p[k], p[(k + 1) % 4], p[(k + 2) % 4]);
            let cross = (b - a).cross(c - a);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            assert!(cross.length() > 1e-3 * longest * longest, "face {corners:?} is degenerate at {a}");
        }
    }
}

#[test]
fn has_the_vertices_asked_for_and_no_degenerate_face() {
    for asked in [2_000, 3_456, 5_000, 9_999, SIZE, 60_000, 530_000, 2_100_000] {
        check_mesh(&rhytid_demo::face(asked), asked);
    }
}

#[test]
fn is_one_oriented_manifold_with_four_openings() {
    for asked in [2_000, SIZE] {
        let face = rhytid_demo::face(asked);
        let mesh = &face.neutral;
        // Every directed edge occurs once. So an edge has at most two faces, with the same winding.
        assert!(directed_edges(mesh).values().all(|&n| n == 1));
        let around = neighbours(mesh);
        let (mut seen, mut stack) = (vec![false; around.len()], vec![0u32]);
        while let Some(v) = stack.pop() {
            if !std::mem::replace(&mut seen[v as usize], true) {
                stack.extend(&around[v as usize]);
            }
        }
        assert!(seen.iter().all(|&s| s), "one component");
        let loops = boundary_loops(mesh);
        assert_eq!(loops.len(), 4, "the outer rim, the mouth and two eyes");
        let centre = |ring: &[u32]| ring.iter().map(|&v| point(mesh, v)).sum::<DVec3>() / ring.len() as f64;
        let mut openings: Vec<DVec3> = loops[1..].iter().map(|ring| centre(ring)).collect();
        openings.sort_by(|a, b| a.x.total_cmp(&b.x));
        assert!(
            (openings[0].x + 3.0).abs() < 0.3 && openings[0].y.abs() < 0.3,
            "right eye at {}",
            openings[0]
        );
        assert!(openings[1].x.abs() < 1e-9 && (openings[1].y + 6.5).abs() < 0.3, "mouth at {}", openings[1]);
        assert!(
            (openings[2].x - 3.0).abs() < 0.3 && openings[2].y.abs() < 0.3,
            "left eye at {}",
            openings[2]
        );
        // Counter-clockwise from the front.
        let area = mesh.faces.iter().fold(DVec3::ZERO, |sum, f| {
            let p = |k: usize| point(mesh, f[k]);
            sum + (p(2) - p(0)).cross(p(3) - p(1)) * 0.5
        });
        assert!(area.z > 100.0, "{area}");
        let [low, high] = mesh.bounds().expect("vertices");
        assert!((16.0..22.0).contains(&(high[1] - low[1])), "{low:?} {high:?}");
    }
}

#[test]
fn is_the_same_surface_at_every_resolution() {
    let (coarse, fine) = (rhytid_demo::face(SIZE).neutral, rhytid_demo::face(80_000).neutral);
    for &p in coarse.positions.iter().step_by(97) {
        let p = DVec3::from_array(p);
        let nearest =
            fine.positions.iter().map(|&q| p.distance(DVec3::from_array(q))).fold(f64::MAX, f64::min);
        assert!(nearest < 0.12, "{p} is {nearest} cm from the finer mesh");
    }
}

#[test]
fn handles_are_distinct_and_mirrored() {
    for asked in [2_000, SIZE, 100_000] {
        let face = rhytid_demo::face(asked);
        assert_eq!(face.handles.len(), 89);
        assert_eq!(
            face.handles
                .points
                .iter()
                .map(rhytid_core::SurfacePoint::nearest_vertex)
                .collect::<BTreeSet<_>>()
                .len(),
            89,
            "at {asked}"
        );
        assert_eq!(face.handles.labels.iter().collect::<BTreeSet<_>>().len(), 89);
        let at = |h: usize| point(&face.neutral, face.handles.points[h].nearest_vertex().0);
        for (h, label) in face.handles.labels.iter().enumerate() {
            let Some((name, side)) = label.rsplit_once("_L") else { continue };
            let other = at(handle(&face, &format!("{name}_R{side}")));
            let mirrored = other * DVec3::new(-1.0, 1.0, 1.0);
            assert!(at(h).distance(mirrored) < 1e-9, "{label} at {}, its opposite at {other}", at(h));
            assert!(at(h).x > 0.0);
        }
        assert!(at(handle(&face, "nose_tip")).z > 1.5);
        assert!(at(handle(&face, "lip_up")).y > at(handle(&face, "lip_low")).y + 0.1);
    }
}

/// The pairs of handles whose cells touch, by distances along the mesh's edges and its faces' diagonals.
fn touching_cells(face: &Face) -> usize {
    let mesh = &face.neutral;
    let mut around: Vec<Vec<(u32, f64)>> = vec![Vec::new(); mesh.positions.len()];
    for f in mesh.faces.iter() {
        for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0), (0, 2), (1, 3)] {
            let length = point(mesh, f[i]).distance(point(mesh, f[j]));
            around[f[i] as usize].push((f[j], length));
            around[f[j] as usize].push((f[i], length));
        }
    }
    let mut owner = vec![usize::MAX; around.len()];
    let mut queue = BinaryHeap::new();
    for (h, v) in face.handles.points.iter().map(rhytid_core::SurfacePoint::nearest_vertex).enumerate() {
        queue.push((std::cmp::Reverse(0u64), v, h));
    }
    while let Some((std::cmp::Reverse(nanometres), v, h)) = queue.pop() {
        if owner[v.index()] == usize::MAX {
            owner[v.index()] = h;
            for &(w, length) in &around[v.index()] {
                queue.push((std::cmp::Reverse(nanometres + (length * 1e7) as u64), VertexId(w), h));
            }
        }
    }
    let mut pairs = BTreeSet::new();
    for f in mesh.faces.iter() {
        // Cells touch along an edge. Four cells that meet in a corner do not all touch.
        for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            let (a, b) = (owner[f[i] as usize], owner[f[j] as usize]);
            if a != b {
                pairs.insert((a.min(b), a.max(b)));
            }
        }
    }
    pairs.len()
}

#[test]
fn handles_are_spread_so_that_about_243_cells_touch() {
    let edges = touching_cells(&rhytid_demo::face(100_000));
    println!("{edges} pairs of cells touch");
    assert!((236..=250).contains(&edges), "{edges}");
}

/// The detail of a field: the field minus its average over neighbours, taken `rounds` times.
fn detail(field: &[DVec3], around: &[BTreeSet<u32>], rounds: usize) -> Vec<DVec3> {
    let mut smooth = field.to_vec();
    for _ in 0..rounds {
        smooth = around
            .iter()
            .zip(&smooth)
            .map(|(ring, &own)| {
                let mean = ring.iter().map(|&w| smooth[w as usize]).sum::<DVec3>() / ring.len() as f64;
                0.5 * (own + mean)
            })
            .collect();
    }
    field.iter().zip(&smooth).map(|(a, b)| *a - *b).collect()
}

#[test]
fn examples_move_markers_and_wrinkle_between_them() {
    let face = rhytid_demo::face(SIZE);
    let mesh = &face.neutral;
    let around = neighbours(mesh);
    let loops = boundary_loops(mesh);
    // Vertices near a rim, where the smoothing below has neighbours on one side only.
    let mut near_rim: BTreeSet<u32> = loops.iter().flatten().copied().collect();
    for _ in 0..7 {
        near_rim = near_rim
            .iter()
            .flat_map(|&v| around[v as usize].iter().copied())
            .chain(near_rim.iter().copied())
            .collect();
    }
    let names: Vec<&str> = face.examples.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["brow_raise", "frown", "smile", "squint", "pucker", "jaw_open"]);
    for example in &face.examples {
        let moved: Vec<DVec3> = example
            .positions
            .iter()
            .zip(&mesh.positions)
            .map(|(a, b)| DVec3::from_array(*a) - DVec3::from_array(*b))
            .collect();
        assert!(moved.iter().all(|d| d.is_finite()));
        let at_rim = loops[0].iter().map(|&v| moved[v as usize].length()).fold(0.0, f64::max);
        assert!(at_rim < 1e-3, "{}: the outer rim moves {at_rim} cm", example.name);
        let most = face
            .handles
            .points
            .iter()
            .map(rhytid_core::SurfacePoint::nearest_vertex)
            .map(|v| moved[v.index()].length())
            .fold(0.0, f64::max);
        assert!((0.3..3.2).contains(&most), "{}: markers move {most} cm", example.name);
        let wrinkles = detail(&moved, &around, 24);
        let deepest = (0..wrinkles.len() as u32)
            .filter(|v| !near_rim.contains(v))
            .map(|v| wrinkles[v as usize].length())
            .fold(0.0, f64::max);
        println!("{}: markers move up to {most:.2} cm, wrinkles up to {deepest:.3} cm", example.name);
        assert!((0.03..0.25).contains(&deepest), "{}: wrinkles of {deepest} cm", example.name);
        // No face is flipped.
        let normal = |positions: &dyn Fn(u32) -> DVec3, f: &[u32]| {
            (positions(f[2]) - positions(f[0])).cross(positions(f[3]) - positions(f[1]))
        };
        let turned = mesh
            .faces
            .iter()
            .filter(|f| !f.iter().any(|v| near_rim.contains(v)))
            .filter(|f| {
                let rest = normal(&|v| point(mesh, v), f);
                rest.dot(normal(&|v| DVec3::from_array(example.positions[v as usize]), f)) <= 0.0
            })
            .count();
        assert_eq!(turned, 0, "{}: faces turn over", example.name);
    }
}

#[test]
fn examples_are_continuous() {
    // At this size a step of 1 mm would be a slope of more than 3; wrinkles stay below 1.5. The lips'
    // corners, from which the mouth opens, are left out with the rims.
    let face = rhytid_demo::face(300_000);
    let mesh = &face.neutral;
    let around = neighbours(mesh);
    let mut near_rim: Vec<bool> = vec![false; around.len()];
    boundary_loops(mesh).iter().flatten().for_each(|&v| near_rim[v as usize] = true);
    for _ in 0..16 {
        let before = near_rim.clone();
        for (v, ring) in around.iter().enumerate() {
            near_rim[v] = before[v] || ring.iter().any(|&w| before[w as usize]);
        }
    }
    for example in &face.examples {
        let moved = |v: u32| DVec3::from_array(example.positions[v as usize]) - point(mesh, v);
        for (v, ring) in around.iter().enumerate().filter(|&(v, _)| !near_rim[v]) {
            for &w in ring {
                let slope =
                    moved(v as u32).distance(moved(w)) / point(mesh, v as u32).distance(point(mesh, w));
                assert!(slope < 1.5, "{}: a slope of {slope} at {}", example.name, point(mesh, w));
            }
        }
    }
}

#[test]
fn the_forehead_has_several_lines() {
    let face = rhytid_demo::face(60_000);
    let raised = &face.examples[0].positions;
    // Up the midline: heights of the forehead's displacement, and their local minima.
    let mut line: Vec<(f64, f64)> = face
        .neutral
        .positions
        .iter()
        .zip(raised)
        .filter(|(p, _)| p[0].abs() < 1e-9 && (2.6..6.6).contains(&p[1]) && p[2] > -1.5)
        .map(|(p, q)| (p[1], q[2] - p[2]))
        .collect();
    line.sort_by(|a, b| a.0.total_cmp(&b.0));
    let valleys = line.windows(5).filter(|w| {
        let middle = w[2].1;
        middle < w[0].1 - 0.01 && middle < w[4].1 - 0.01 && middle <= w[1].1 && middle <= w[3].1
    });
    let valleys = valleys.count();
    assert!((3..=7).contains(&valleys), "{valleys} forehead lines");
}

#[test]
fn the_performance_starts_and_ends_at_rest_and_passes_through_the_examples() {
    let face = rhytid_demo::face(5_000);
    let take = rhytid_demo::performance(&face);
    assert_eq!(take, rhytid_demo::performance(&face));
    assert_eq!(take.labels, face.handles.labels);
    assert_eq!(take.rate(), 30.0);
    let length = take.times[take.frames() - 1] - take.times[0];
    assert!((6.0..=8.0).contains(&length), "{length} s");
    assert!(take.positions.iter().flatten().all(|x| x.is_finite()));

    let markers = |positions: &[[f64; 3]]| -> Vec<[f64; 3]> {
        face.handles.points.iter().map(|point| point.at(positions)).collect()
    };
    let farthest = |a: &[[f64; 3]], b: &[[f64; 3]]| {
        a.iter()
            .zip(b)
            .map(|(p, q)| DVec3::from_array(*p).distance(DVec3::from_array(*q)))
            .fold(0.0, f64::max)
    };
    let frames: Vec<&[[f64; 3]]> = take.positions.chunks(89).collect();
    let rest = markers(&face.neutral.positions);
    assert_eq!(frames[0], rest);
    assert_eq!(frames[take.frames() - 1], rest);
    // There are no jumps: the motion in a frame is less than that of a blink.
    assert!(frames.windows(2).all(|w| farthest(w[0], w[1]) < 0.5));
    for example in &face.examples {
        let apex = markers(&example.positions);
        let nearest = frames.iter().map(|f| farthest(f, &apex)).fold(f64::MAX, f64::min);
        let size = farthest(&apex, &rest);
        if ["brow_raise", "smile", "jaw_open"].contains(&example.name.as_str()) {
            assert!(nearest < 1e-9, "{}: the take comes within {nearest} cm of its markers", example.name);
        } else {
            assert!(nearest < 0.7 * size, "{}: {nearest} of {size} cm", example.name);
        }
    }
}
