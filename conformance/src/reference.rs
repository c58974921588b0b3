//! The reference: the right result of each kernel for its inputs, in float64, with a bound for rounding.
//!
//! The inputs are the device's own, so that an error upstream is not blamed on a kernel downstream.
//! [`mod@tolerance`] has the numbers of roundings. This module has the sums that they multiply.
use crate::distances::Distances;
use crate::expected::Expected;
use crate::tolerance::{self, EPSILON, TINY, TINY_HALF, gamma};
use rayon::prelude::*;
use rhytid_core::{BasisStorage, ClusteredBasis, Result, Rig, Stage, StrainEdgeId, Table};
use rhytid_kernels::bands::kinds;
use rhytid_kernels::{detail, fine_scale, vec3};
use std::borrow::Cow;

/// A case, and a device's result of each stage.
#[derive(Debug)]
pub struct Found {
    /// The rig, with the numbers that a device keeps ([`Rig::as_stored`]).
    pub rig: Rig<f64>,
    /// How the basis is stored.
    pub basis: BasisStorage,
    /// The factors of the basis where it is stored in clusters.
    pub clusters: Option<ClusteredBasis>,
    /// frames × H.
    pub handle_positions: Vec<[f64; 3]>,
    /// In the order of [`Stage::ALL`], each as [`rhytid_core::Session::read`] gives it, and with the right
    /// length.
    pub stages: [Vec<f32>; 6],
}

impl Found {
    /// The results `stages` of a rig that was uploaded with this storage. `handle_positions` is
    /// frames × H × 3.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if a number is too large for fp16.
    pub fn new(
        rig: Rig,
        basis: BasisStorage,
        handle_positions: &[f32],
        stages: [Vec<f32>; 6],
    ) -> Result<Self> {
        let clusters = (basis == BasisStorage::Clustered).then(|| ClusteredBasis::new(&rig));
        let positions = handle_positions.as_chunks::<3>().0;
        Ok(Self {
            rig: rig.as_stored(basis)?.widened(),
            basis,
            clusters,
            handle_positions: positions.iter().map(|p| p.map(f64::from)).collect(),
            stages,
        })
    }

    /// One stage of the batch.
    pub fn stage(&self, stage: Stage) -> &[f32] {
        &self.stages[stage as usize]
    }

    /// Frames in the batch.
    pub fn frames(&self) -> usize {
        self.handle_positions.len() / self.rig.handles().len()
    }

    fn vectors(&self, stage: Stage) -> Vec<[f64; 3]> {
        self.stage(stage).as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect()
    }
}

/// The right values of `stage`, as many as the device gave.
pub fn reference(found: &Found, stage: Stage) -> Vec<Expected> {
    let vectors = |stage| found.vectors(stage);
    let numbers = match stage {
        Stage::Strain => return strains(&found.rig, &found.handle_positions),
        Stage::LargeScale => large_scale(found),
        Stage::LargeScaleNormals => vertex_normals(&found.rig, &vectors(Stage::LargeScale)),
        Stage::Detail => details(found),
        Stage::Positions => positions(
            &found.rig,
            &vectors(Stage::LargeScale),
            &vectors(Stage::LargeScaleNormals),
            &vectors(Stage::Detail),
        ),
        Stage::Normals => vertex_normals(&found.rig, &vectors(Stage::Positions)),
    };
    numbers.into_flattened()
}

fn strains(rig: &Rig<f64>, handle_positions: &[[f64; 3]]) -> Vec<Expected> {
    let lengths = rig.handles().rest_lengths();
    let rest = &rig.handles().rest;
    let mut expected = Vec::new();
    for p in handle_positions.chunks_exact(rig.handles().len()) {
        for (&edge, &l) in rig.handles().strain_edges.iter().zip(&lengths) {
            let [a, b] = edge.map(rhytid_core::HandleId::index);
            let (e, e_rest) = (vec3::sub(p[a], p[b]), vec3::sub(rest[a], rest[b]));
            let (u_a, u_b) = (vec3::sub(p[a], rest[a]), vec3::sub(p[b], rest[b]));
            let length = vec3::length(e);
            let value = (length - l) / l;
            let sizes = (0..3).map(|c| (u_a[c].abs() + u_b[c].abs()) * (e[c].abs() + e_rest[c].abs()));
            let products = gamma(tolerance::STRAIN_PRODUCTS) * sizes.sum::<f64>() + 3.0 * TINY;
            // Squares that are flushed to zero shorten the root.
            let flushed = 3.0 * TINY.sqrt().min(TINY / length.max(TINY)) / (length + l);
            let bound =
                products / (length + l) / l + (gamma(tolerance::STRAIN_QUOTIENT) + flushed) * value.abs();
            expected.push(Expected { value, bound: bound + TINY });
        }
    }
    expected
}

/// `at` for every vertex of every frame.
fn of_vertices(
    frames: usize,
    vertices: usize,
    at: impl Fn(usize, usize) -> [Expected; 3] + Sync,
) -> Vec<[Expected; 3]> {
    let numbers = (0..frames * vertices).into_par_iter().with_min_len(256);
    numbers.map(|i| at(i / vertices, i % vertices)).collect()
}

fn large_scale(found: &Found) -> Vec<[Expected; 3]> {
    let rig = &found.rig;
    let motions = rig.handles().motions(&found.handle_positions);
    let center = motions.center.map(|v| rig.surface().rest[v.index()]);
    // Rows of H vectors. The rows of a frame follow one another.
    let of_frame = motions.vectors.len() / found.handle_positions.len();
    let exact = |x: f64| Expected { value: x, bound: 0.0 };
    let of_handles: Vec<[Expected; 3]> = motions.vectors.iter().map(|u| u.map(exact)).collect();
    let mut motions: Vec<Vec<[Expected; 3]>> =
        of_handles.chunks_exact(rig.handles().len()).map(<[[Expected; 3]]>::to_vec).collect();
    if let Some(clusters) = &found.clusters {
        let factors = clusters.handle_factors().map(|w| f64::from(*w));
        for u in &mut motions {
            *u = factors.rows().map(|row| blended(row, u, 0.0)).collect();
        }
    }
    let smallest = if found.basis == BasisStorage::F16 { TINY_HALF } else { 0.0 };
    let band = linear_band(found);
    of_vertices(found.frames(), rig.vertices(), |frame, v| {
        let (row, range) = match &found.clusters {
            None => (Cow::Borrowed(rig.basis().row(v)), 0..rig.handles().len()),
            Some(clusters) => {
                let (cluster, in_cluster) = (v / ClusteredBasis::VERTICES, v % ClusteredBasis::VERTICES);
                let columns = clusters.clusters()[cluster].columns.iter();
                let row = columns.map(|column| f64::from(column[in_cluster])).collect();
                (Cow::Owned(row), clusters.rows_of(cluster))
            }
        };
        let of_frame = motions[frame * of_frame..(frame + 1) * of_frame].iter().map(|u| &u[range.clone()]);
        let blended: Vec<[Expected; 3]> = of_frame.map(|u| blended(&row, u, smallest)).collect();
        std::array::from_fn(|c| {
            let Expected { value: mut moved, bound: mut sum } = blended[0][c];
            if let Some(center) = center {
                let from_center = vec3::sub(rig.surface().rest[v], center);
                let mut sizes = moved.abs() + sum;
                for (column, x) in blended[1..].iter().zip(from_center) {
                    moved += column[c].value * x;
                    sum += (column[c].bound + TINY) * x.abs();
                    sizes += (column[c].value * x).abs() + column[c].bound * x.abs();
                }
                sum += gamma(tolerance::TURN) * sizes + TINY;
            }
            let value = rig.surface().rest[v][c] + moved;
            let bound = sum + tolerance::POSITION * EPSILON * (value.abs() + sum);
            let Some(band) = &band else { return Expected { value, bound } };
            // The band is added to the basis's result, which is already an f32 position.
            let offset = band[frame * rig.vertices() + v][c];
            let (value, bound) = (value + offset.value, bound + offset.bound);
            Expected { value, bound: bound + tolerance::POSITION * EPSILON * (value.abs() + bound) }
        })
    })
}

/// Σ_h B_vh u_h for a row of the basis, or the same sum for a row of one of its factors.
fn blended(row: &[f64], u: &[[Expected; 3]], smallest: f64) -> [Expected; 3] {
    let roundings = tolerance::large_scale(row.len());
    let (mut sum, mut sizes, mut flushed) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    let mut bounds = [0.0; 3];
    for (b, u) in row.iter().zip(u) {
        for c in 0..3 {
            let product = b * u[c].value;
            sum[c] += product;
            sizes[c] += product.abs();
            bounds[c] += b.abs() * u[c].bound;
            if b.abs() < smallest {
                flushed[c] += product.abs();
            }
        }
    }
    std::array::from_fn(|c| Expected {
        value: sum[c],
        bound: gamma(roundings) * (sizes[c] + bounds[c]) + bounds[c] + flushed[c] + roundings * TINY,
    })
}

/// The linear band's offset for every vertex of every frame; `None` if the rig has no bands.
fn linear_band(found: &Found) -> Option<Vec<[Expected; 3]>> {
    let rig = &found.rig;
    let distances = Distances::new(rig, &found.handle_positions)?;
    let examples = rig.examples().len();
    let weights = rig.band_weights();
    let kinds = kinds(rig.vector_wrinkles());
    let roundings = gamma(tolerance::bands(examples));
    Some(of_vertices(found.frames(), rig.vertices(), |frame, v| {
        let squares = distances.squares(frame, v);
        let (a, c) = (weights.row(v)[0], weights.row(v).iter().step_by(kinds).skip(1));
        let beyond = distances.beyond(frame, v);
        std::array::from_fn(|axis| {
            let (mut value, mut bound) = (a[axis], roundings * a[axis].abs() + TINY);
            for (c, square) in c.clone().zip(&squares[1..]) {
                let (along, c) = (squares[0].value - square.value, c[axis]);
                value += c * along;
                bound += (1.0 + roundings) * c.abs() * (squares[0].bound + square.bound)
                    + roundings * (c * along).abs()
                    + (c.abs() + 1.0) * TINY;
            }
            // A device may take it back from the position, too.
            let x = rig.surface().rest[v][axis].abs() + value.abs() + bound;
            let taken = if beyond[axis].bound > 0.0 { beyond[axis].bound + gamma(2.0) * x } else { 0.0 };
            Expected { value: value - beyond[axis].value, bound: bound + taken }
        })
    }))
}

/// The wrinkles of vector strains.
fn vector_wrinkles(found: &Found, distances: &Distances<'_>) -> Vec<[Expected; 3]> {
    let rig = &found.rig;
    let centers = rig.centers();
    let roundings = gamma(tolerance::bands(centers - 1));
    of_vertices(found.frames(), rig.vertices(), |frame, v| {
        let squares = distances.squares(frame, v);
        let roots: Vec<Expected> = squares
            .iter()
            .map(|&Expected { value, bound }| {
                let root = value.sqrt();
                // |√a − √b| is at most |a − b| / √a, and at most √|a − b|.
                let of_square = if bound > 0.0 { bound / root.max(bound.sqrt()) } else { 0.0 };
                Expected { value: root, bound: of_square + gamma(tolerance::DISTANCE) * (root + of_square) }
            })
            .collect();
        let weights = rig.fine_scale().rbf_weights.row(v);
        std::array::from_fn(|axis| {
            let b = weights[0][axis];
            let (mut value, mut bound) = (b, roundings * b.abs() + TINY);
            for (w, root) in weights.iter().zip(&roots).skip(1) {
                let (farther, w) = (root.value - roots[0].value, w[axis]);
                value += w * farther;
                bound += (1.0 + roundings) * w.abs() * (root.bound + roots[0].bound)
                    + roundings * (w * farther).abs()
                    + TINY;
            }
            Expected { value, bound }
        })
    })
}

/// `v / |v|`, where each component of v is known within `error`. The error is 0 for every v that must be 0.
fn unit(v: [f64; 3], error: [f64; 3]) -> [Expected; 3] {
    let direction = vec3::normalize(v);
    let (length, off) = (vec3::length(v), vec3::length(error));
    std::array::from_fn(|c| {
        let value = direction[c];
        // A vector within its own rounding has no direction: any unit vector is allowed.
        let turned = match off < length {
            true => (error[c] + value.abs() * off) / (length - off),
            false if off == 0.0 => 0.0,
            false => f64::INFINITY,
        };
        let bound = turned + gamma(tolerance::UNIT) * value.abs() + TINY;
        Expected { value, bound: bound.min(1.0 + value.abs() + 4.0 * EPSILON) }
    })
}

fn vertex_normals(rig: &Rig<f64>, positions: &[[f64; 3]]) -> Vec<[Expected; 3]> {
    let vertices = rig.vertices();
    let vertex_triangles = rig.surface().vertex_triangles();
    let positions = Table::new(positions.len() / vertices, vertices, positions.to_vec());
    of_vertices(positions.height(), vertices, |frame, v| {
        let p = positions.row(frame);
        let incident = vertex_triangles.at(v).iter().map(|&t| rig.surface().triangles[t as usize]);
        vertex_normal(incident.map(|triangle| triangle.map(|i| p[i as usize])))
    })
}

/// The normal of one vertex from the corners of its triangles. If rounding leaves it no direction, the bound
/// allows any normal.
pub fn vertex_normal(triangles: impl ExactSizeIterator<Item = [[f64; 3]; 3]>) -> [Expected; 3] {
    let roundings = tolerance::cross_products(triangles.len());
    let (mut sum, mut sizes) = ([0.0; 3], [0.0; 3]);
    for mut corners in triangles {
        let mut largest = [0.0f64; 3];
        // The area is the same from each corner, the products are not.
        for _ in corners {
            let (e, f) = (vec3::sub(corners[1], corners[0]), vec3::sub(corners[2], corners[0]));
            for (c, largest) in largest.iter_mut().enumerate() {
                let (i, j) = ((c + 1) % 3, (c + 2) % 3);
                *largest = largest.max((e[i] * f[j]).abs() + (e[j] * f[i]).abs());
            }
            corners.rotate_left(1);
        }
        let [a, b, c] = corners;
        let cross = vec3::cross(vec3::sub(b, a), vec3::sub(c, a));
        for c in 0..3 {
            sum[c] += cross[c];
            sizes[c] += largest[c];
        }
    }
    // Without products nothing can be flushed to zero.
    let flushed = if sizes == [0.0; 3] { 0.0 } else { 3.0 * roundings * TINY };
    unit(sum, sizes.map(|size| gamma(roundings) * size + flushed))
}

fn details(found: &Found) -> Vec<[Expected; 3]> {
    let rig = &found.rig;
    if rig.vector_wrinkles()
        && let Some(distances) = Distances::new(rig, &found.handle_positions)
    {
        return vector_wrinkles(found, &distances);
    }
    let (edges, k, n) = (rig.handles().strain_edges.len(), rig.influences().per_vertex(), rig.centers());
    let features = found.stage(Stage::Strain).iter().map(|&f| f64::from(f)).collect();
    let features = Table::new(found.frames(), edges, features);
    let roundings = gamma(tolerance::detail(n, k));
    let (_, pivots) = detail::pivoted(rig.fine_scale().rbf_weights.as_slice(), n);
    let zero_at_rest = rig.learned().is_some();
    // Squares that are flushed to zero shorten the root's distance.
    let flushed = (2.0 * k as f64 * TINY).sqrt();
    of_vertices(found.frames(), rig.vertices(), |frame, v| {
        let f = features.row(frame);
        let distances: Vec<f64> = (0..n)
            .map(|j| {
                detail::feature_distance(
                    StrainEdgeId::numbers(rig.influences().edges.row(v)),
                    rig.influences().weights.row(v),
                    f,
                    rig.fine_scale().pose_features.row(j),
                )
            })
            .collect();
        let w = rig.fine_scale().rbf_weights.row(v);
        let pivot = if zero_at_rest { 0 } else { pivots[v] as usize };
        let mut d = [Expected::default(); 3];
        for (c, d) in d.iter_mut().enumerate() {
            let others = || (0..n).filter(|&j| j != pivot);
            // The factor of the pivot's weight, and the value.
            let first = if zero_at_rest {
                d.value = w[0][c] + others().map(|j| w[j][c] * (distances[j] - distances[0])).sum::<f64>();
                (w[0][c].abs(), 1.0)
            } else {
                d.value = w.iter().zip(&distances).map(|(w, r)| w[c] * r).sum();
                (w.iter().map(|w| w[c]).sum::<f64>().abs(), distances[pivot])
            };
            let terms = others().map(|j| (w[j][c].abs(), distances[j] + distances[pivot]));
            d.bound = std::iter::once(first)
                .chain(terms)
                .map(|(w, r)| roundings * w * r + flushed * w + TINY)
                .sum();
        }
        d
    })
}

fn positions(
    rig: &Rig<f64>,
    large_scale: &[[f64; 3]],
    large_scale_normals: &[[f64; 3]],
    detail: &[[f64; 3]],
) -> Vec<[Expected; 3]> {
    let vertices = rig.vertices();
    of_vertices(large_scale.len() / vertices, vertices, |frame, v| {
        let first = frame * vertices;
        let (smooth, n, d) = (large_scale[first + v], large_scale_normals[first + v], detail[first + v]);
        if rig.vector_wrinkles() {
            return std::array::from_fn(|c| {
                let value = smooth[c] + d[c];
                Expected { value, bound: tolerance::POSITION * EPSILON * value.abs() + TINY }
            });
        }
        let e = vec3::sub(large_scale[first + rig.surface().tangent_neighbors[v].index()], smooth);
        let axes = fine_scale::tangent_frame(e, n);
        let x = fine_scale::add_detail(smooth, axes, d);

        let along: f64 = (0..3).map(|c| (e[c] * n[c]).abs()).sum();
        let flushed = if e == [0.0; 3] { 0.0 } else { 8.0 * TINY };
        let error = std::array::from_fn(|c| {
            gamma(tolerance::TANGENT_EDGE) * e[c].abs()
                + gamma(tolerance::TANGENT_ALONG) * along * n[c].abs()
                + flushed
        });
        let exact = vec3::dot(e, n);
        let t = unit(std::array::from_fn(|c| e[c] - exact * n[c]), error);
        std::array::from_fn(|c| {
            let (i, j) = ((c + 1) % 3, (c + 2) % 3);
            let b_products = (n[i] * t[j].value).abs() + (n[j] * t[i].value).abs();
            let b_error =
                n[i].abs() * t[j].bound + n[j].abs() * t[i].bound + gamma(tolerance::BITANGENT) * b_products;
            let sizes: f64 = (0..3).map(|axis| (axes[axis][c] * d[axis]).abs()).sum();
            let offset = gamma(tolerance::OFFSET) * sizes
                + (t[c].bound * d[0].abs() + b_error * d[1].abs()) * (1.0 + gamma(tolerance::OFFSET))
                + 6.0 * TINY;
            Expected { value: x[c], bound: offset + tolerance::POSITION * EPSILON * (x[c].abs() + offset) }
        })
    })
}
