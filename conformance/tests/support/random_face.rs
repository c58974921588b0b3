//! Random faces for property tests: sheets with holes, obtuse triangles and several components.
use proptest::prelude::*;
use rhytid_conformance::Numbers;
use rhytid_core::{
    Example, Face, Faces, Handles, LearnedSettings, Mesh, Method, Settings, SurfacePoint, UpAxis, VertexId,
    WrinkleStrains,
};

/// A sheet of about `n × n` sheared and jittered vertices with a hole, triangles and quads.
fn add_sheet(mesh: &mut Mesh, n: usize, center: [f64; 3], shear: f64, numbers: &mut Numbers) {
    let first = mesh.positions.len() as u32;
    for i in 0..n {
        for j in 0..n {
            let (u, v) = (i as f64 + 0.25 * numbers.signed(), j as f64 + 0.25 * numbers.signed());
            let (x, y) = (u + shear * v, v);
            mesh.positions.push([
                center[0] + x,
                center[1] + y,
                center[2] + 0.15 * (0.7 * x).sin() * y + 0.1 * numbers.signed(),
            ]);
        }
    }
    let hole = (1 + numbers.below(n - 3), 1 + numbers.below(n - 3));
    for i in 0..n - 1 {
        for j in 0..n - 1 {
            if (i, j) == hole {
                continue;
            }
            let at = |i: usize, j: usize| first + (i * n + j) as u32;
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if numbers.unit() < 0.5 {
                mesh.faces.push(&quad);
            } else {
                mesh.faces.push(&[quad[0], quad[1], quad[2]]);
                mesh.faces.push(&[quad[0], quad[2], quad[3]]);
            }
        }
    }
}

/// A point inside a face of which at most one corner is `taken`, or on an edge of it.
fn inside_a_face(mesh: &Mesh, driven: usize, taken: &[bool], numbers: &mut Numbers) -> Option<SurfacePoint> {
    let faces: Vec<&[u32]> = mesh.faces.iter().collect();
    let face = faces[numbers.below(faces.len())];
    let corners = [face[0], face[1], face[2]];
    let is_taken = corners.iter().filter(|v| taken[**v as usize]).count() > 1;
    if is_taken || corners.iter().any(|&v| v as usize >= driven) {
        return None;
    }
    let on_an_edge = numbers.below(4) == 0;
    let weights =
        [0.1 + numbers.unit(), 0.1 + numbers.unit(), if on_an_edge { 0.0 } else { 0.1 + numbers.unit() }];
    SurfacePoint::new(corners.map(VertexId), weights)
}

/// A face of two driven sheets, one sheet without handles and an isolated vertex. With `inside`, half of the
/// handles are inside triangles.
pub(crate) fn random_face(
    seed: u64,
    n: usize,
    handles: usize,
    examples: usize,
    shear: f64,
    inside: bool,
) -> Face {
    let mut numbers = Numbers::new(seed);
    let mut mesh = Mesh { faces: Faces::default(), ..Mesh::default() };
    add_sheet(&mut mesh, n, [0.0; 3], shear, &mut numbers);
    add_sheet(&mut mesh, 5, [20.0, 0.0, 1.0], 0.3, &mut numbers);
    let driven = mesh.positions.len();
    add_sheet(&mut mesh, 4, [0.0, 20.0, -1.0], 0.0, &mut numbers);
    mesh.positions.push([5.0, 5.0, 5.0]);

    // At least one handle on each driven sheet.
    let mut points: Vec<SurfacePoint> =
        [numbers.below(n * n), n * n + numbers.below(25)].map(|v| VertexId::from_index(v).into()).to_vec();
    let mut taken = vec![false; mesh.positions.len()];
    points.iter().for_each(|point| taken[point.nearest_vertex().index()] = true);
    let mut tries = 0;
    while points.len() < handles && tries < 1000 {
        tries += 1;
        let point = if inside && points.len().is_multiple_of(2) {
            inside_a_face(&mesh, driven, &taken, &mut numbers)
        } else {
            let v = numbers.below(driven);
            (!taken[v]).then(|| VertexId::from_index(v).into())
        };
        if let Some(point) = point {
            point.corners().for_each(|(v, _)| taken[v.index()] = true);
            points.push(point);
        }
    }
    let examples = (0..examples)
        .map(|j| {
            let (a, b, c) = (numbers.signed(), numbers.signed(), numbers.signed());
            let positions = mesh
                .positions
                .iter()
                .map(|p| {
                    let bump = |k: f64| 0.3 * (k * p[0] + a).sin() * (0.6 * p[1] + b).cos();
                    [
                        p[0] + bump(0.5 + 0.1 * j as f64) + 0.02 * numbers.signed(),
                        p[1] + 0.3 * c * (0.4 * p[0]).sin() + 0.02 * numbers.signed(),
                        p[2] + bump(0.9) + 0.05 * numbers.signed(),
                    ]
                })
                .collect();
            Example { name: format!("pose {j}"), positions, mirror: false, noise: Some(0.0) }
        })
        .collect();
    Face {
        name: "random".into(),
        neutral: mesh,
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: Handles { labels: (0..points.len()).map(|h| format!("m{h}")).collect(), points },
        examples,
        // Not aligned: any rigid motion that fits random examples to the neutral is chance.
        prior: None,
        settings: Settings {
            method: Method::Chapter,
            max_influences: 6,
            align: false,
            ..Settings::default()
        },
    }
}

/// Faces for both methods. The learned part must not depend on the size of the mesh or the order of its
/// vertices. Therefore nothing is chosen by a sample of vertices, and there is no noise.
pub(crate) fn faces_for_both_methods() -> impl Strategy<Value = Face> {
    let learned = LearnedSettings {
        share: Some(0.2),
        ridge: Some(1e-2),
        reach: Some(1.0),
        fade: false,
        marker_noise: 0.0,
        ..LearnedSettings::default()
    };
    let lengths = LearnedSettings { wrinkle_strains: WrinkleStrains::Lengths, ..learned };
    let methods = [Method::Chapter, Method::Learned(learned), Method::Learned(lengths)];
    (faces(), prop::sample::select(methods.to_vec())).prop_map(|(mut face, method)| {
        face.settings.method = method;
        face
    })
}

/// Faces of every kind that [`random_face`] makes, for the chapter's method.
pub(crate) fn faces() -> impl Strategy<Value = Face> {
    (any::<u64>(), 5usize..11, 4usize..14, 0usize..5, -1.5f64..1.5, any::<bool>()).prop_map(
        |(seed, n, handles, examples, shear, inside)| random_face(seed, n, handles, examples, shear, inside),
    )
}
