//! The unit of a neutral, from its size.

use crate::args;
use rhytid::core::Mesh;
use rhytid::core::human;
use rhytid::formats::mesh::Space;
use rhytid::formats::project::Units;
use rhytid::solve::head::Region;
use rhytid::{Error, Result};

/// Units of meshes, in the order in which they are tried.
const UNITS: [Units; 6] = [
    Units::Centimetres,
    Units::Millimetres,
    Units::Metres,
    Units::MetresPerUnit(0.1),
    Units::Inches,
    Units::MetresPerUnit(0.3048),
];

/// The size of faces and heads, with or without shoulders: the diagonal of the bounding box, in metres.
const SIZES: std::ops::Range<f64> = 0.15..0.9;

/// Vertices beyond this share on each side, along an axis, do not count for the size.
const STRAY: f64 = 0.002;

/// A unit, and what is to be said of it.
pub(super) struct Unit {
    pub(super) units: Units,
    pub(super) warning: Option<String>,
}

/// The unit that was given, else the one that the file states if a head has this size in it, else the one in
/// which the head has the size of a head.
///
/// `head` is the head, if the neutral alone shows it.
///
/// # Errors
/// [`Error::Input`] if it has the size of a head in no unit.
pub(super) fn unit(neutral: &Mesh, stated: Space, head: Option<&Region>, args: &args::New) -> Result<Unit> {
    if let Some(units) = args.unit {
        return Ok(Unit { units, warning: None });
    }
    let size = head.map_or_else(|| size(neutral), |head| head.size);
    let across = size.iter().map(|length| length * length).sum::<f64>().sqrt();
    let is_head = |units: &Units| SIZES.contains(&(across * units.metres_per_unit()));
    let of_size = UNITS.into_iter().find(is_head);
    let Some(stated) = stated.metres_per_unit.map(named) else {
        let units = of_size.ok_or_else(|| {
            Error::out_of_range(format!(
                "{}: its surface has a diagonal of {} units, the size of a head in no unit; say which with --unit, or \
                 scale it",
                args.neutral.display(),
                human::number(across)
            ))
        })?;
        return Ok(Unit { units, warning: None });
    };
    if is_head(&stated) {
        return Ok(Unit { units: stated, warning: None });
    }
    let metres = human::number(across * stated.metres_per_unit());
    let Some(units) = of_size else {
        let warning = format!(
            "warning: {}: is {metres} m across by the unit that it states, which is no head's size; check it, or say \
             the unit with --unit",
            args.neutral.display()
        );
        return Ok(Unit { units: stated, warning: Some(warning) });
    };
    let warning = format!(
        "warning: {}: is {metres} m across by the unit that it states, so {} is taken; say another with --unit",
        args.neutral.display(),
        human::unit(units.metres_per_unit())
    );
    Ok(Unit { units, warning: Some(warning) })
}

/// The unit of so many metres, by its name if it has one.
fn named(metres: f64) -> Units {
    UNITS.into_iter().find(|units| units.metres_per_unit() == metres).unwrap_or(Units::MetresPerUnit(metres))
}

/// The size of the surface along x, y and z: of the vertices of its faces, without a few strays.
fn size(mesh: &Mesh) -> [f64; 3] {
    let mut used = mesh.faces.indices.clone();
    used.sort_unstable();
    used.dedup();
    if used.is_empty() {
        return [0.0; 3];
    }
    [0, 1, 2].map(|c| {
        let mut along: Vec<f64> = used.iter().map(|v| mesh.positions[*v as usize][c]).collect();
        along.sort_by(f64::total_cmp);
        let strays = (STRAY * along.len() as f64) as usize;
        along[along.len() - 1 - strays] - along[strays]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid::core::Faces;

    #[test]
    fn strays_do_not_count_for_the_size() {
        let mut mesh = Mesh::default();
        for i in 0..1000 {
            mesh.positions.push([f64::from(i), 0.0, 2.0 * f64::from(i)]);
        }
        // One vertex without a face, and one at the end of a long spike.
        mesh.positions.push([1e6, 1e6, 1e6]);
        mesh.positions.push([0.0, -1e6, 0.0]);
        mesh.faces = Faces::default();
        for v in 0..998 {
            mesh.faces.push(&[v, v + 1, v + 2]);
        }
        mesh.faces.push(&[0, 1, 1001]);
        let [x, y, z] = size(&mesh);
        assert!((990.0..=1000.0).contains(&x) && y == 0.0 && (1980.0..=2000.0).contains(&z), "{x} {y} {z}");
    }
}
