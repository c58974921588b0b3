//! The check that the parts of every rig have passed.
use crate::numbers::first_beyond;
use crate::rig::{MOST_AROUND_JOINED, RigParts};
use crate::{
    Error, HandleId, Learned, LearnedSettings, Result, StrainEdgeId, Surface, SurfacePoint, Table, VertexId,
};
use rhytid_kernels::Real;
use std::collections::HashSet;

impl<T: Real> RigParts<T> {
    /// Whether every array has the shape, and every number the range, that the parts promise. Any backend can
    /// evaluate parts that pass, without another check.
    ///
    /// # Errors
    /// [`Error::Input`] with the first array and element that does not fit.
    pub(crate) fn check(&self) -> Result<()> {
        let Self { surface, handles, examples, influences, fine_scale, .. } = self;
        let (v, h, f) = (surface.rest.len(), handles.len(), handles.strain_edges.len());
        let (k, n) = (influences.per_vertex(), examples.len() + 1);
        if v == 0 || h == 0 || surface.faces.is_empty() {
            return fail(format!(
                "a rig has vertices, handles and faces; found {v}, {h} and {}",
                surface.faces.len()
            ));
        }
        if u32::try_from(v).is_err() || u32::try_from(f).is_err() {
            return fail(format!("{v} vertices and {f} strain edges are more than 32 bits can count"));
        }
        if !(surface.metres_per_unit.is_finite() && surface.metres_per_unit > 0.0) {
            return fail(format!(
                "metres_per_unit is {}, expected a number above 0",
                surface.metres_per_unit
            ));
        }
        if !(self.bending_length.is_finite() && self.bending_length >= 0.0) {
            return fail(format!("bending_length is {}, expected 0 or more", self.bending_length));
        }
        // β is infinite where more than K edges tie.
        if influences.beta.is_nan() || influences.beta < 0.0 {
            return fail(format!("beta is {}, expected 0 or more", influences.beta));
        }
        // The names are those of the tensors in the rig file, which has an older name for the tangent
        // neighbours.
        counted("labels", handles.labels.len(), h)?;
        counted("handle_rest", handles.rest.len(), h)?;
        shaped("basis", &self.basis, v, h)?;
        shaped("influence_edges", &influences.edges, v, k)?;
        shaped("influence_weights", &influences.weights, v, k)?;
        counted("frame_neighbors", surface.tangent_neighbors.len(), v)?;
        shaped("pose_features", &fine_scale.pose_features, n, f)?;
        shaped("rbf_weights", &fine_scale.rbf_weights, v, n)?;
        shaped("example_handles", &examples.handles, n - 1, h)?;
        let beyond = |point: &SurfacePoint| point.triangle().into_iter().find(|vertex| vertex.index() >= v);
        let mut found = handles.points.iter().enumerate();
        if let Some((h, vertex)) = found.find_map(|(h, point)| Some((h, beyond(point)?))) {
            return fail(format!("handles[{h}] is {vertex}, expected an index below {v}"));
        }
        below("triangles", surface.triangles.as_flattened(), v)?;
        check_faces(surface)?;
        check_joined(surface)?;
        below("strain_edges", handles.edge_numbers().as_flattened(), h)?;
        below("influence_edges", StrainEdgeId::numbers(influences.edges.as_slice()), f)?;
        for (v, edges) in influences.edges.rows().enumerate() {
            if let Some([a, b]) = edges.array_windows().find(|[a, b]| a >= b) {
                return fail(format!(
                    "influence_edges of vertex {v} has {b} after {a}, expected ascending indices"
                ));
            }
        }
        below("frame_neighbors", VertexId::numbers(&surface.tangent_neighbors), v)?;
        finite("rest", surface.rest.as_flattened())?;
        within("basis", self.basis.as_slice(), LARGEST_RATIO)?;
        finite("influence_weights", influences.weights.as_slice())?;
        finite("pose_features", fine_scale.pose_features.as_slice())?;
        within("rbf_weights", fine_scale.rbf_weights.as_slice().as_flattened(), self.largest_weight())?;
        finite("example_handles", examples.handles.as_slice().as_flattened())?;
        self.learned.as_ref().map_or(Ok(()), |learned| self.check_learned(learned))?;
        ratios("influence_weights", influences.weights.as_slice())?;
        let mut seen = HashSet::new();
        if let Some(label) = handles.labels.iter().find(|l| !seen.insert(l.as_str())) {
            return fail(format!("labels has {label} twice, expected distinct labels"));
        }
        let mut seen = HashSet::new();
        let vertices = || handles.points.iter().filter_map(SurfacePoint::vertex);
        if let Some(vertex) = vertices().find(|v| !seen.insert(*v)) {
            return fail(format!("handles has vertex {vertex} twice, expected distinct vertices"));
        }
        if handles.rotations && vertices().count() < h {
            return fail("has handles that turn and are at no vertex, expected handles at vertices".into());
        }
        if let Some(i) = (0..h).find(|&i| handles.rest[i] != handles.points[i].at(&surface.rest)) {
            return fail(format!(
                "handle_rest[{i}] is not where its point is at rest ({})",
                handles.points[i]
            ));
        }
        let is_point = |&[a, b]: &[HandleId; 2]| handles.rest[a.index()] == handles.rest[b.index()];
        if let Some(i) = handles.strain_edges.iter().position(is_point) {
            return fail(format!("strain_edges[{i}] has no length at rest"));
        }
        Ok(())
    }

    /// The largest weight of an example that can be right, in mesh units.
    fn largest_weight(&self) -> f64 {
        let coordinates = self.surface.rest.as_flattened().iter();
        let farthest = coordinates.fold(0.0_f64, |most, x| most.max(x.widen().abs()));
        if farthest > 0.0 { LARGEST_WEIGHT * farthest } else { LARGEST }
    }

    fn check_learned(&self, learned: &Learned<T>) -> Result<()> {
        let (v, p, a) = (self.surface.rest.len(), self.examples.len(), learned.anchors_per_vertex());
        counted("variances", learned.variances.len(), v)?;
        learned.contact.check(v)?;
        if !learned.prior_lengths.is_empty() {
            counted("prior_lengths", learned.prior_lengths.len(), self.handles.features())?;
            finite("prior_lengths", &learned.prior_lengths)?;
        }
        shaped("anchors", &learned.anchors, v, a)?;
        shaped("anchor_weights", &learned.anchor_weights, v, a)?;
        shaped("feature_gains", &learned.feature_gains, v, self.influences.per_vertex() + a)?;
        shaped("example_weights", &learned.example_weights, v, if learned.share > 0.0 { p } else { 0 })?;
        let is_ridge = |ridge| ridge > 0.0 && ridge <= LearnedSettings::LARGEST_RIDGE;
        for (name, number, is_right) in [
            ("share", learned.share, (0.0..=1.0).contains(&learned.share)),
            ("ridge", learned.ridge, is_ridge(learned.ridge)),
            ("wrinkle_ridge", learned.wrinkle_ridge, is_ridge(learned.wrinkle_ridge)),
            (
                "marker_noise",
                learned.marker_noise,
                (0.0..=LearnedSettings::LARGEST_NOISE * 1e-3 / self.surface.metres_per_unit)
                    .contains(&learned.marker_noise),
            ),
        ] {
            if !(number.is_finite() && is_right) {
                return fail(format!("{name} is {}, which is out of its range", shown(number)));
            }
        }
        if learned.reach.is_nan() || learned.reach < 1.0 {
            return fail(format!("reach is {}, which must be 1 or more", learned.reach));
        }
        below("anchors", HandleId::numbers(learned.anchors.as_slice()), self.handles.len())?;
        finite("anchor_weights", learned.anchor_weights.as_slice())?;
        ratios("anchor_weights", learned.anchor_weights.as_slice())?;
        finite("feature_gains", learned.feature_gains.as_slice())?;
        let example_weights = learned.example_weights.as_slice().as_flattened();
        within("example_weights", example_weights, self.largest_weight())?;
        finite("variances", &learned.variances)
    }
}

fn check_faces<T: Real>(surface: &Surface<T>) -> Result<()> {
    let Surface { faces, uvs, materials, triangles, rest, .. } = surface;
    let corners = faces.indices.len();
    let counted: u64 = faces.counts.iter().map(|&n| u64::from(n)).sum();
    if let Some(f) = faces.counts.iter().position(|&n| n < 3) {
        return fail(format!("face_counts[{f}] is {}, expected at least 3", faces.counts[f]));
    }
    if counted != corners as u64 {
        return fail(format!("face_indices has {corners} elements, expected {counted}"));
    }
    below("face_indices", &faces.indices, rest.len())?;
    if faces.triangle_corners(triangles).is_none() {
        return fail("triangles is not made from the faces".into());
    }
    if let Some(fault) = materials.as_ref().and_then(|materials| materials.fault(faces)) {
        return fail(fault);
    }
    let Some(uvs) = uvs else { return Ok(()) };
    finite("uvs", uvs.values.as_flattened())?;
    match &uvs.corners {
        None if uvs.values.len() != rest.len() => {
            fail(format!("uvs has {} elements, expected {}", uvs.values.len(), rest.len()))
        }
        Some(indices) if indices.len() != corners => {
            fail(format!("uv_indices has {} elements, expected {corners}", indices.len()))
        }
        Some(indices) => below("uv_indices", indices, uvs.values.len()),
        None => Ok(()),
    }
}

fn check_joined<T: Real>(surface: &Surface<T>) -> Result<()> {
    let Some(joined) = &surface.joined else { return Ok(()) };
    let v = surface.rest.len();
    counted("joined_vertices", joined.len(), v)?;
    below("joined_vertices", VertexId::numbers(joined), v)?;
    let is_first = |v: VertexId| joined[v.index()] == v;
    if let Some(v) = (0..v).find(|&v| joined[v].index() > v || !is_first(joined[v])) {
        return fail(format!("joined_vertices[{v}] is {}, which is not the first of its point", joined[v]));
    }
    if let Some((v, first)) = surface.copies().find(|(v, first)| surface.at(&[*v]) != surface.at(&[*first])) {
        return fail(format!("joined_vertices[{v}] is {first}, which is elsewhere at rest"));
    }
    // A list for each vertex has all triangles around its point.
    let mut around = vec![0; v];
    surface.triangles.as_flattened().iter().for_each(|&v| around[surface.first(v) as usize] += 1);
    match surface.copies().find(|(_, first)| around[first.index()] > MOST_AROUND_JOINED) {
        Some((v, first)) => fail(format!(
            "joined_vertices[{v}] is {first}, a point with {} triangles, expected at most {MOST_AROUND_JOINED}",
            around[first.index()]
        )),
        None => Ok(()),
    }
}

pub(crate) fn fail(message: String) -> Result<()> {
    Err(Error::rig_damaged(message))
}

fn counted(name: &str, found: usize, expected: usize) -> Result<()> {
    if found != expected {
        return fail(format!("{name} has {found} elements, expected {expected}"));
    }
    Ok(())
}

fn shaped<E>(name: &str, table: &Table<E>, rows: usize, columns: usize) -> Result<()> {
    counted(name, table.as_slice().len(), rows.saturating_mul(columns))?;
    if (table.height(), table.columns()) != (rows, columns) {
        let (height, width) = (table.height(), table.columns());
        return fail(format!("{name} is {height} × {width}, expected {rows} × {columns}"));
    }
    Ok(())
}

pub(crate) fn below(name: &str, indices: &[u32], end: usize) -> Result<()> {
    match indices.iter().position(|&i| i as usize >= end) {
        Some(at) => fail(format!("{name}[{at}] is {}, expected an index below {end}", indices[at])),
        None => Ok(()),
    }
}

/// Larger numbers are those of no face. They overflow in float32 where they are multiplied.
const LARGEST: f64 = 1e15;

/// The most that a vertex can move where a handle moves by 1. In the basis of a face it is about 1.
const LARGEST_RATIO: f64 = 1e6;

/// The largest weight of an example, as a part of the face's size. Weights of a face are up to 1e6 where
/// hardly any strain tells its examples apart.
const LARGEST_WEIGHT: f64 = 1e9;

/// Whether all numbers are finite, and so small that frames can be computed.
pub(crate) fn finite<T: Real>(name: &str, numbers: &[T]) -> Result<()> {
    within(name, numbers, LARGEST)
}

fn within<T: Real>(name: &str, numbers: &[T], largest: f64) -> Result<()> {
    let Some(at) = first_beyond(numbers, largest) else { return Ok(()) };
    let expected = if numbers[at].widen().is_finite() { "a smaller number" } else { "a finite number" };
    fail(format!("{name}[{at}] is {}, expected {expected}", shown(numbers[at].widen())))
}

/// A number as people write it: large ones by their power of ten.
fn shown(number: f64) -> String {
    if number.is_finite() && number.abs() >= 1e9 { format!("{number:e}") } else { number.to_string() }
}

fn ratios<T: Real>(name: &str, numbers: &[T]) -> Result<()> {
    match numbers.iter().position(|x| !(0.0..=1.0).contains(&x.widen())) {
        Some(at) => fail(format!("{name}[{at}] is {}, expected 0 to 1", numbers[at])),
        None => Ok(()),
    }
}
