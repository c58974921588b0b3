//! An actor's poses: frames in which the actor does what an example of the rig shows. The poses say how the
//! actor's motion becomes the rig's, region by region.
use crate::tracks::extent;
use glam::{DMat3, DVec3};
use rhytid_core::{Error, InputErrorKind, Result};
use serde::Serialize;
use std::collections::BTreeMap;

/// Neighbours within about this part of the face's extent are of the same region.
const REGION: f64 = 0.12;

/// Directions along which the poses move a region less than this part of its whole motion stay nearly
/// unchanged.
const RIDGE: f64 = 0.02;

/// Motion of a region below this part of the face's extent is ignored.
const STILL: f64 = 0.002;

/// Largest Frobenius distance of a map from the identity.
const FARTHEST: f64 = 1.5;

/// An actor's pose.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pose {
    /// The example that the pose shows.
    pub example: String,
    /// The frame.
    pub frame: usize,
    /// How alike the pose and its example are: the cosine of the angle between the displacements of all
    /// handles. 1 means that they differ in size alone.
    pub likeness: f64,
}

/// The named poses, and for each handle the map from the actor's displacements to the rig's. `columns` holds
/// the actor's displacements. `examples` holds the rig's: one displacement per handle. `rest` holds the
/// handles' rest positions.
///
/// # Errors
/// [`Error::Input`] if there is no such example or frame.
pub(crate) fn find(
    poses: &BTreeMap<String, usize>,
    columns: &[Vec<DVec3>],
    examples: &[(String, Vec<DVec3>)],
    rest: &[DVec3],
) -> Result<(Vec<Pose>, Vec<DMat3>)> {
    let frames = columns.first().map_or(0, Vec::len);
    let mut found = Vec::new();
    let mut pairs: Vec<(Vec<DVec3>, &[DVec3])> = Vec::new();
    for (name, &frame) in poses {
        let Some((_, shown)) = examples.iter().find(|(example, _)| example == name) else {
            let names: Vec<&str> = examples.iter().map(|(name, _)| &name[..]).collect();
            return Err(Error::input(format!(
                "a pose is named “{name}”, which is no example of the rig; it has {}",
                if names.is_empty() { "none".to_owned() } else { names.join(", ") }
            ))
            .of_kind(InputErrorKind::UnknownName { name: name.clone() }));
        };
        if frame >= frames {
            return Err(Error::out_of_range(format!(
                "the pose “{name}” is in frame {frame}, but the take has frames 0..{frames}"
            )));
        }
        let actor: Vec<DVec3> = columns.iter().map(|column| column[frame]).collect();
        let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
        let size = (dot(&actor, &actor) * dot(shown, shown)).sqrt();
        let likeness = if size > 0.0 { dot(&actor, shown) / size } else { 0.0 };
        found.push(Pose { example: name.clone(), frame, likeness });
        pairs.push((actor, shown));
    }
    Ok((found, maps(&pairs, rest)))
}

/// For each handle, the linear map from the actor's displacements to the rig's that fits the poses best over
/// its region.
///
/// `M = (Σ w D dᵀ + λ I) (Σ w d dᵀ + λ I)⁻¹`, with the actor's displacements d, the examples' D and a weight
/// w that falls with the distance at rest. Where the poses say nothing, M is the identity.
fn maps(pairs: &[(Vec<DVec3>, &[DVec3])], rest: &[DVec3]) -> Vec<DMat3> {
    let extent = extent(rest.iter().copied());
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    let of_handle = |j: usize| {
        let (mut cross, mut square, mut total) = (DMat3::ZERO, DMat3::ZERO, 0.0);
        for k in 0..rest.len() {
            let weight = (-0.5 * (rest[j].distance(rest[k]) / (REGION * extent)).powi(2)).exp();
            for (actor, shown) in pairs {
                cross += weight * outer(shown[k], actor[k]);
                square += weight * outer(actor[k], actor[k]);
                total += weight;
            }
        }
        let trace = square.x_axis.x + square.y_axis.y + square.z_axis.z;
        let ridge = RIDGE * trace + total * (STILL * extent).powi(2);
        if ridge <= 0.0 {
            return DMat3::IDENTITY;
        }
        let ridge = DMat3::from_diagonal(DVec3::splat(ridge));
        let change = (cross + ridge) * (square + ridge).inverse() - DMat3::IDENTITY;
        let size = change.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
        DMat3::IDENTITY + (FARTHEST / size.max(FARTHEST)) * change
    };
    (0..rest.len()).map(of_handle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_found_where_poses_tell_it_and_nowhere_else() {
        let rest: Vec<DVec3> =
            (0..40).map(|i| DVec3::new(f64::from(i % 8), f64::from(i / 8), 0.0) * 2.0).collect();
        let pose = |k: f64| -> Vec<DVec3> {
            rest.iter().map(|r| DVec3::new((k * r.x).sin(), (k * r.y).cos() - 1.0, 0.0)).collect()
        };
        let shown = [pose(0.3), pose(0.7), pose(1.1)];
        let half = |p: &DVec3| DVec3::new(p.x, 0.5 * p.y, p.z);
        let pairs: Vec<(Vec<DVec3>, &[DVec3])> =
            shown.iter().map(|d| (d.iter().map(half).collect(), &d[..])).collect();
        for map in maps(&pairs, &rest) {
            let to = map * DVec3::new(0.3, 0.2, 0.1);
            assert!(to.distance(DVec3::new(0.3, 0.4, 0.1)) < 0.04, "{to}");
        }
        let still = vec![DVec3::ZERO; 40];
        assert!(
            maps(&[(still.clone(), &still)], &rest).iter().all(|map| map.abs_diff_eq(DMat3::IDENTITY, 1e-12))
        );
        let columns: Vec<Vec<DVec3>> = shown[1].iter().map(|d| vec![DVec3::ZERO, *d]).collect();
        let examples = [("smile".to_owned(), shown[1].clone())];
        let of =
            |name: &str, frame| find(&BTreeMap::from([(name.to_owned(), frame)]), &columns, &examples, &rest);
        let (poses, maps) = of("smile", 1).unwrap();
        assert!((poses[0].likeness - 1.0).abs() < 1e-12);
        assert!(maps.iter().all(|map| map.abs_diff_eq(DMat3::IDENTITY, 1e-9)));
        assert!(of("smile", 2).unwrap_err().to_string().contains("the take has frames 0..2"));
        assert!(of("frown", 1).unwrap_err().to_string().contains("no example of the rig; it has smile"));
    }
}
