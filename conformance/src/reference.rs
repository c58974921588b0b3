//! What each kernel must give for the inputs it had, and how far rounding may take it from there.
//!
//! The bounds are those of a sum of products, `n ε Σ|aᵢ bᵢ|`, with ε the unit roundoff of f32 and n the number of
//! roundings on the way of one term, and what they become in the rest of the kernel. They hold for any order of
//! the sums and with fused operations, so for every device.
use rhytid_core::Rig;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::{fine_scale, normals, strain, vec3};

/// The unit roundoff of f32: half a unit in the last place.
const EPSILON: f64 = (f32::EPSILON / 2.0) as f64;

/// The smallest normal f32: what may be lost where a device flushes smaller numbers to zero.
const TINY: f64 = f32::MIN_POSITIVE as f64;

/// Exact values in float64, and the largest difference allowed for each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reference {
    /// As [`rhytid_core::Session::read`] orders them.
    pub values: Vec<f64>,
    /// As many.
    pub bounds: Vec<f64>,
}

impl Reference {
    fn push(&mut self, value: f64, bound: f64) {
        self.values.push(value);
        self.bounds.push(bound + TINY);
    }
}

/// The kernel `strain` for frames × H handle positions.
pub fn strain(rig: &Rig<f64>, handle_positions: &[[f64; 3]]) -> Reference {
    let lengths = strain::rest_lengths(&rig.rest, &rig.handles, &rig.strain_edges);
    let mut reference = Reference::default();
    for p in handle_positions.chunks_exact(rig.handles.len()) {
        for (&[a, b], l) in rig.strain_edges.iter().zip(&lengths) {
            let length = vec3::length(vec3::sub(p[a as usize], p[b as usize]));
            // Both lengths are rounded (difference, three squares, two sums, root), then the two are subtracted
            // and divided.
            reference.push((length - l) / l, (5.0 * (length + l) + 2.0 * (length - l).abs()) * EPSILON / l);
        }
    }
    reference
}

/// The kernel `large_scale` for frames × H handle positions.
pub fn large_scale(rig: &Rig<f64>, handle_positions: &[[f64; 3]]) -> Reference {
    let handles = rig.handles.len();
    let mut reference = Reference::default();
    for p in handle_positions.chunks_exact(handles) {
        let u: Vec<[f64; 3]> =
            p.iter().zip(&rig.handles).map(|(p, &v)| vec3::sub(*p, rig.rest[v as usize])).collect();
        for (rest, row) in rig.rest.iter().zip(rig.basis.chunks_exact(handles)) {
            for (c, rest) in rest.iter().enumerate() {
                let products = || row.iter().zip(&u).map(|(b, u)| b * u[c]);
                let sum: f64 = products().sum();
                let sizes: f64 = products().map(f64::abs).sum();
                let terms = handles as f64 + 2.0;
                reference.push(rest + sum, terms * EPSILON * sizes + EPSILON * (rest + sum).abs());
            }
        }
    }
    reference
}

/// The kernel `normals` for frames × V positions.
pub fn normals(rig: &Rig<f64>, positions: &[[f64; 3]]) -> Reference {
    let vertex_triangles = VertexTriangles::new(rig.vertices(), &rig.triangles);
    let mut reference = Reference::default();
    for p in positions.chunks_exact(rig.vertices()) {
        for v in 0..rig.vertices() {
            let incident = vertex_triangles.at(v);
            let normal = normals::vertex_normal(p, &rig.triangles, incident);
            let (mut sum, mut sizes) = ([0.0; 3], 0.0);
            for &t in incident {
                let [a, b, c] = rig.triangles[t as usize].map(|i| p[i as usize]);
                let (e, f) = (vec3::sub(b, a), vec3::sub(c, a));
                let cross = vec3::cross(e, f);
                sum = std::array::from_fn(|i| sum[i] + cross[i]);
                sizes += vec3::length(e) * vec3::length(f);
            }
            let area = vec3::length(sum);
            // Each component of a cross product has two products of two rounded differences.
            let error = (incident.len() as f64 + 6.0) * EPSILON * 2.0 * sizes;
            // A sum within its own rounding has no direction: anything up to a unit vector will do.
            let bound = match area > 4.0 * error {
                true => 2.0 * error / area + 6.0 * EPSILON,
                false if area == 0.0 && sizes == 0.0 => 0.0,
                false => 2.0,
            };
            normal.iter().for_each(|&n| reference.push(n, bound));
        }
    }
    reference
}

/// The detail of the kernel `fine_scale` for frames × F strains.
pub fn detail(rig: &Rig<f64>, strain: &[f64], frames: usize) -> Reference {
    let (edges, k, n) = (rig.strain_edges.len(), rig.influences(), rig.centers());
    let mut reference = Reference::default();
    for frame in 0..frames {
        let f = &strain[frame * edges..][..edges];
        for v in 0..rig.vertices() {
            let (mut sum, mut sizes) = ([0.0; 3], [0.0; 3]);
            for j in 0..n {
                let r = fine_scale::feature_distance(
                    &rig.influence_edges[v * k..][..k],
                    &rig.influence_weights[v * k..][..k],
                    f,
                    &rig.pose_features[j * edges..][..edges],
                );
                for c in 0..3 {
                    let product = rig.rbf_weights[v * n + j][c] * r;
                    sum[c] += product;
                    sizes[c] += product.abs();
                }
            }
            // The root halves the relative error of its K terms, each of four roundings.
            let terms = n as f64 + (k as f64 + 4.0) / 2.0 + 2.0;
            for c in 0..3 {
                reference.push(sum[c], terms * EPSILON * sizes[c]);
            }
        }
    }
    reference
}

/// The positions of the kernel `fine_scale`, for frames × V large-scale positions, their normals and the detail.
pub fn positions(
    rig: &Rig<f64>,
    large_scale: &[[f64; 3]],
    large_scale_normals: &[[f64; 3]],
    detail: &[[f64; 3]],
) -> Reference {
    let vertices = rig.vertices();
    let mut reference = Reference::default();
    for (i, smooth) in large_scale.iter().enumerate() {
        let (first, v) = (i / vertices * vertices, i % vertices);
        let neighbor = large_scale[first + rig.frame_neighbors[v] as usize];
        let (e, n) = (vec3::sub(neighbor, *smooth), large_scale_normals[i]);
        let frame = fine_scale::local_frame(e, n);
        let x = fine_scale::add_detail(*smooth, frame, detail[i]);
        let along = vec3::dot(e, n);
        let tangential = vec3::length(std::array::from_fn(|c| e[c] - along * n[c]));
        // t is a difference of vectors as long as e, normalised: what is left of it decides how well it is known.
        let frame_error = match tangential > 0.0 {
            true => (8.0 * EPSILON * vec3::length(e) / tangential + 6.0 * EPSILON).min(2.0),
            false => 0.0,
        };
        let size = vec3::length(detail[i]);
        let bound = size * (2.0 * frame_error + 8.0 * EPSILON);
        x.iter().for_each(|&x| reference.push(x, bound + EPSILON * x.abs()));
    }
    reference
}
