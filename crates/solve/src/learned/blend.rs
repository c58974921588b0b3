//! The basis rows of parts without a handle that are not rigid (step 1 of the learned method): how much of
//! the closest skin's motion each vertex has.
use super::linear_band::{LinearSettings, leave_one_out};
use super::neighborhoods::LinearInfluences;
use super::parts::{FreeMotion, FreePart, centroid};
use super::residual;
use super::vector_strains::VectorStrains;
use crate::Shell;
use crate::bind::bind_nearest;
use rhytid_core::{Example, Result, Table, VertexId};
use rhytid_kernels::vec3;

/// The linear band that predicts left-out examples. With few examples, it is also the one that is taken.
const LEFT_OUT: LinearSettings =
    LinearSettings { share: 0.2, ridge: 1e-2, marker_noise: 0.0, reach: f64::INFINITY };

/// A vertex counts as if it had followed the skin by this part of L. Where the examples say little, it
/// follows the skin.
const ASSUMED: f64 = 0.002;

/// A part is a blend only if its squared errors are below this part of those with all of the skin's motion.
const BETTER: f64 = 0.5;

/// Gives the vertices of parts that follow the skin their rows of the basis, and those of blends their
/// influences.
///
/// A part that may be a blend has all of the skin's motion and listens to the handles near the closest skin,
/// as `influences` have it. Or it is a blend, and listens to the handles around its centroid. It is a blend
/// if that predicts left-out examples much better. `mean` is L in mesh units.
///
/// # Errors
/// [`rhytid_core::Error::Internal`] if a system has no solution in floating point.
pub(crate) fn bind(
    shell: &mut Shell,
    examples: &[Example],
    strains: &VectorStrains,
    influences: &mut LinearInfluences,
    parts: &mut [FreePart],
    mean: f64,
) -> Result<()> {
    let Shell { surface, parts: components, pinned, basis, .. } = shell;
    let members = components.without_handle();
    let of_part = |part: &FreePart| &*members[components.component[part.first_vertex.index()] as usize];
    let mut follows = vec![false; surface.rest.len()];
    for part in parts.iter().filter(|part| part.motion.follows_skin()) {
        of_part(part).iter().for_each(|v| follows[v.index()] = !pinned[v.index()]);
    }
    bind_nearest(&surface.rest, &surface.triangles, &components.driven, |v| follows[v], basis);
    if examples.is_empty() {
        return Ok(());
    }
    let mut blends: Vec<(&mut FreePart, &[VertexId])> = Vec::new();
    for part in parts.iter_mut().filter(|part| matches!(part.motion, FreeMotion::Blend { .. })) {
        let members = of_part(part);
        blends.push((part, members));
    }
    if blends.is_empty() {
        return Ok(());
    }
    let left = residual(shell, examples);
    let mut moved = Table::filled(left.height(), left.columns(), [0.0; 3]);
    let rest = &shell.surface.rest;
    for v in blends.iter().flat_map(|(_, members)| *members) {
        for (moved, example) in moved.row_mut(v.index()).iter_mut().zip(examples) {
            *moved = vec3::sub(example.positions[v.index()], rest[v.index()]);
        }
    }
    let of_examples = OfExamples { moved, left, strains, assumed: ASSUMED * mean };
    for (part, vertices) in blends {
        let near_skin = influences.of(vertices);
        let of_skin = of_examples.errors(&of_examples.left, influences, vertices)?;
        influences.around(&shell.handles, centroid(rest, vertices).to_array(), vertices, mean);
        let blend = of_examples.blend(influences, vertices)?;
        if blend.squares >= BETTER * squares(&of_skin) {
            part.motion = FreeMotion::Skin;
            influences.set(vertices, &near_skin);
            continue;
        }
        for (v, skin) in vertices.iter().zip(&blend.skin) {
            shell.basis.row_mut(v.index()).iter_mut().for_each(|b| *b *= skin);
        }
        part.motion = FreeMotion::Blend { skin: blend.skin.iter().sum::<f64>() / vertices.len() as f64 };
    }
    Ok(())
}

/// How the vertices of blends move in the examples.
struct OfExamples<'a> {
    /// V×P in mesh units: how far vertices are from rest. 0 outside of blends.
    moved: Table<[f64; 3]>,
    /// W where blends have all of the skin's motion, V×P in mesh units.
    left: Table<[f64; 3]>,
    strains: &'a VectorStrains,
    /// [`ASSUMED`] in mesh units.
    assumed: f64,
}

/// How much of the skin's motion the vertices of a part have.
struct Blend {
    /// w, 0 to 1.
    skin: Vec<f64>,
    /// The sum of the squared errors of left-out examples, in mesh units squared.
    squares: f64,
}

impl OfExamples<'_> {
    /// The error of each left-out example at `vertices`, where the linear band learns from `of`, V×P.
    ///
    /// # Errors
    /// As [`leave_one_out`].
    fn errors(
        &self,
        of: &Table<[f64; 3]>,
        influences: &LinearInfluences,
        vertices: &[VertexId],
    ) -> Result<Table<[f64; 3]>> {
        leave_one_out(self.strains, influences, of, LEFT_OUT, vertices)
    }

    /// w of each of `vertices`.
    ///
    /// A vertex has w times the motion of the skin, and the linear band learns what is left. If an example is
    /// left out, its error is linear in w: `e(w) = e(0) − w (e(0) − e(1))`. So the w that leaves least is
    /// `Σ e(0)·(e(0) − e(1)) / Σ |e(0) − e(1)|²`, over all examples.
    ///
    /// # Errors
    /// As [`leave_one_out`].
    fn blend(&self, influences: &LinearInfluences, vertices: &[VertexId]) -> Result<Blend> {
        let without = self.errors(&self.moved, influences, vertices)?;
        let with = self.errors(&self.left, influences, vertices)?;
        let mut found = Blend { skin: Vec::new(), squares: 0.0 };
        for (without, with) in without.rows().zip(with.rows()) {
            let assumed = self.assumed * self.assumed;
            let (mut square, mut product, mut of_skin) = (assumed, assumed, assumed);
            for (without, with) in without.iter().zip(with) {
                let skin = vec3::sub(*without, *with);
                square += vec3::dot(*without, *without);
                product += vec3::dot(*without, skin);
                of_skin += vec3::dot(skin, skin);
            }
            let w = (product / of_skin).clamp(0.0, 1.0);
            found.skin.push(w);
            found.squares += square - 2.0 * w * product + w * w * of_skin;
        }
        Ok(found)
    }
}

fn squares(errors: &Table<[f64; 3]>) -> f64 {
    errors.as_slice().iter().map(|e| vec3::dot(*e, *e)).sum()
}
