//! Landmarks: handles of both faces that are at the same place, and the similarity between them.
use glam::DVec3;
use rhytid_core::{Error, Face, InputErrorKind, Result, Rig, SurfacePoint};
use rhytid_geometry::registration::Similarity;
use rhytid_geometry::registration::fit;

/// The fewest landmarks that determine the similarity of the faces.
pub(crate) const LEAST: usize = 4;

/// Pairs of points at the same place of the two faces, and their labels.
pub(crate) struct Landmarks {
    pub labels: Vec<String>,
    pub pairs: Vec<[SurfacePoint; 2]>,
}

/// Where a point is on a mesh with these positions.
pub(crate) fn at_point(point: &SurfacePoint, positions: &[DVec3]) -> DVec3 {
    point.corners().map(|(v, weight)| positions[v.index()] * weight).sum()
}

impl Landmarks {
    /// The handles with the same label, or those of `named`: pairs of labels, of the first face and of the
    /// second.
    ///
    /// # Errors
    /// [`Error::Input`] if a face has no handle of a named label, or if there are fewer than four pairs.
    pub(crate) fn new(from: &Rig, to: &Face, named: Option<&[(String, String)]>) -> Result<Self> {
        let of_rig = |label: &String| {
            from.handles().labels.iter().position(|l| l == label).map(|h| from.handles().points[h])
        };
        let handles = &to.handles;
        let of_face =
            |label: &String| handles.labels.iter().position(|l| l == label).map(|h| handles.points[h]);
        let same: Vec<(String, String)>;
        let pairs = match named {
            Some(pairs) => pairs,
            None => {
                let shared = from.handles().labels.iter().filter(|label| to.handles.labels.contains(label));
                same = shared.map(|label| (label.clone(), label.clone())).collect();
                &same
            }
        };
        let mut found = Self { labels: Vec::new(), pairs: Vec::new() };
        for (a, b) in pairs {
            let lacks = |name: &str, label: &str| {
                Error::input(format!(
                    "{name} has no handle called “{label}”; landmarks are pairs of handles, one of each face"
                ))
                .of_kind(InputErrorKind::UnknownMarkers { labels: vec![label.to_owned()] })
            };
            let a_point = of_rig(a).ok_or_else(|| lacks(&from.surface().name, a))?;
            let b_point = of_face(b).ok_or_else(|| lacks(&to.name, b))?;
            found.labels.push(b.clone());
            found.pairs.push([a_point, b_point]);
        }
        match found.pairs.len() {
            n if n >= LEAST => Ok(found),
            n => Err(Error::no_fit(format!(
                "{} and {} share {n} landmarks, expected at least {LEAST}: give handles that are at the same place the same label, or say which belong together in a table of landmarks",
                from.surface().name,
                to.name
            ))),
        }
    }

    /// The similarity from the first face to the second, and whether a mirror image would fit much better.
    ///
    /// # Errors
    /// [`Error::Input`] if they lie on a line.
    pub(crate) fn similarity(&self, from: &[DVec3], to: &[DVec3]) -> Result<(Similarity, bool)> {
        let at = |points: &[DVec3], side: usize| -> Vec<DVec3> {
            self.pairs.iter().map(|pair| at_point(&pair[side], points)).collect()
        };
        let (a, b) = (at(from, 0), at(to, 1));
        let weights = vec![1.0; a.len()];
        let mirrored: Vec<DVec3> = a.iter().map(|p| DVec3::new(-p.x, p.y, p.z)).collect();
        let off = |points: &[DVec3], motion: &Similarity| -> f64 {
            points.iter().zip(&b).map(|(p, q)| motion.apply(*p).distance_squared(*q)).sum()
        };
        let line =
            || Error::no_fit("the landmarks lie on a line or at one place; choose some across the face");
        let motion = fit(&a, &b, &weights, true).filter(|motion| motion.scale > 0.0).ok_or_else(line)?;
        // Half the distance is a quarter of the squares.
        let is_mirrored = fit(&mirrored, &b, &weights, true)
            .is_some_and(|other| off(&mirrored, &other) < 0.25 * off(&a, &motion));
        Ok((motion, is_mirrored && a.len() > LEAST))
    }
}
