//! The report of a transfer: numbers, maps, and warnings with their remedies.
use crate::correspondence::{Correspondence, Missing};
use crate::landmarks::Landmarks;
use rhytid_core::{Face, Rig, human};
use serde::Serialize;

/// With fewer landmarks than this, the result depends too much on closest points.
const FEW: usize = 12;

/// The part of the skin without a counterpart from which on there is a warning.
const BARE: f64 = 0.25;

/// The stretch from which on there is a warning, as a ratio: the 95th percentile.
const STRETCHED: f64 = 1.0;

/// A landmark is at another place of the face if the warp leaves it farther from its partner than this, in
/// spacings of the handles.
const ASTRAY: f64 = 0.25;

/// The plausible ratios of the sizes of two heads.
const SIZES: [f64; 2] = [0.5, 2.0];

/// The most labels that one warning names.
const NAMED: usize = 5;

/// The distribution of numbers at vertices: the median, the 95th percentile, and the largest.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Spread {
    /// The median.
    pub median: f64,
    /// The 95th percentile.
    pub p95: f64,
    /// The largest.
    pub worst: f64,
}

impl Spread {
    fn new(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at =
            |part: f64| values.get((part * values.len().saturating_sub(1) as f64).round() as usize).copied();
        let [median, p95, worst] = [0.5, 0.95, 1.0].map(|part| at(part).unwrap_or_default());
        Self { median, p95, worst }
    }
}

/// The vertices without a counterpart for one reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Bare {
    /// The reason.
    pub why: Missing,
    /// The number of vertices.
    pub vertices: usize,
}

/// The report of a transfer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TransferReport {
    /// The first face.
    pub from: String,
    /// The second.
    pub to: String,
    /// The number of vertices of the second face.
    pub vertices: usize,
    /// Names of the examples that were made.
    pub examples: Vec<String>,
    /// Names of the first face's examples that the second face already has. Its own are kept.
    pub own: Vec<String>,
    /// Whether the linear band was transferred too.
    #[serde(rename = "smooth_band")]
    pub linear_band: bool,
    /// Labels of the landmarks on the second face.
    pub landmarks: Vec<String>,
    /// Whether both have the same faces, so that movements were copied vertex by vertex.
    pub same_topology: bool,
    /// The size of the second face relative to the first, in the same unit.
    pub scale: f64,
    /// The part of the skin's area that has a counterpart: 0 to 1. Parts without a landmark are no skin.
    pub covered: f64,
    /// The vertices without a counterpart, by reason.
    pub bare: Vec<Bare>,
    /// Handles of the second whose places on the first are not known.
    pub bare_handles: Vec<String>,
    /// The distances of vertices from their places once the faces lie on each other, in millimetres.
    pub distance_mm: Spread,
    /// The growth of the surface beyond the scale, or its shrinking, in the direction where it is largest:
    /// 0.1 for a tenth.
    pub stretch: Spread,
    /// The number of the first face's triangles that were turned over.
    pub turned_over: usize,
    /// What to look at.
    pub warnings: Vec<String>,
}

/// Numbers at the vertices of the second face; NaN where there is no counterpart.
#[derive(Debug, Clone, PartialEq)]
pub struct Maps {
    /// As [`TransferReport::distance_mm`].
    pub distance_mm: Vec<f32>,
    /// As [`TransferReport::stretch`].
    pub stretch: Vec<f32>,
}

/// The measures of the second face.
pub(crate) struct Measures<'a> {
    /// The area at each of its V vertices.
    pub area: &'a [f64],
    /// The distance between handles of the first face once it lies on the second, in mesh units.
    pub spacing: f64,
}

impl TransferReport {
    pub(crate) fn new(
        from: &Rig,
        to: &Face,
        landmarks: &Landmarks,
        is_mirrored: bool,
        found: &Correspondence,
        measures: &Measures<'_>,
        linear_band: bool,
    ) -> (Self, Maps) {
        let millimetres = to.metres_per_unit * 1e3;
        let of_places = found.places.iter().zip(&found.locals).map(|(place, local)| {
            place.as_ref().ok().map(|place| {
                let (own, longest) = (local.scale / found.overall.scale, local.anisotropy.sqrt());
                let stretch = (own * longest).max(longest / own) - 1.0;
                [place.distance * millimetres, stretch]
            })
        });
        let numbers: Vec<Option<[f64; 2]>> = of_places.collect();
        let map = |i: usize| numbers.iter().map(|n| n.map_or(f32::NAN, |n| n[i] as f32)).collect();
        let spread = |i: usize| Spread::new(numbers.iter().flatten().map(|n| n[i]).collect());
        let (mut skin, mut covered) = (0.0, 0.0);
        for (v, place) in found.places.iter().enumerate().filter(|(v, _)| found.takes_part[*v]) {
            let area = measures.area[v];
            skin += area;
            covered += if place.is_ok() { area } else { 0.0 };
        }
        let whys = [
            Missing::OtherPart,
            Missing::BeyondTheBorder,
            Missing::FacesAway,
            Missing::TooFar,
            Missing::Elsewhere,
        ];
        let bare =
            whys.map(|why| Bare { why, vertices: found.places.iter().filter(|p| **p == Err(why)).count() });
        let bare_handles = to.handles.labels.iter().zip(&to.handles.points).filter(|(_, point)| {
            point.corners().any(|(v, _)| found.places[v.index()].is_err())
                && !landmarks.pairs.iter().any(|pair| pair[1] == **point)
        });
        let mut report = Self {
            from: from.surface().name.clone(),
            to: to.name.clone(),
            vertices: found.places.len(),
            examples: Vec::new(),
            own: Vec::new(),
            linear_band,
            landmarks: landmarks.labels.clone(),
            same_topology: found.same_topology,
            scale: found.overall.scale * to.metres_per_unit / from.surface().metres_per_unit,
            covered: if skin > 0.0 { covered / skin } else { 0.0 },
            bare: bare.into_iter().filter(|bare| bare.vertices > 0).collect(),
            bare_handles: bare_handles.map(|(label, _)| label.clone()).collect(),
            distance_mm: spread(0),
            stretch: spread(1),
            turned_over: found.turned_over.len(),
            warnings: Vec::new(),
        };
        report.warn(found, landmarks, is_mirrored, measures.spacing, millimetres);
        (report, Maps { distance_mm: map(0), stretch: map(1) })
    }

    fn warn(
        &mut self,
        found: &Correspondence,
        landmarks: &Landmarks,
        is_mirrored: bool,
        spacing: f64,
        millimetres: f64,
    ) {
        let mut warn = |text: String| self.warnings.push(text);
        if is_mirrored {
            warn("the landmarks fit a mirror image of the first face much better: left and right are exchanged in the labels of one of the faces; exchange them back".into());
        }
        if !(SIZES[0]..SIZES[1]).contains(&self.scale) {
            warn(format!(
                "the second face is {} times as large as the first, which is not plausible for heads; check \
                 the units of both",
                human::number(rounded(self.scale, 3))
            ));
        }
        if landmarks.pairs.len() < FEW && !found.same_topology {
            warn(format!(
                "only {} are shared; add more, above all around the eyes and the mouth, by equal labels or \
                 in a table of landmarks",
                human::counted(landmarks.pairs.len(), "landmark")
            ));
        }
        let astray = landmarks.labels.iter().zip(&found.landmark_distances);
        let mut astray: Vec<(&String, &f64)> = astray.filter(|(_, far)| **far > ASTRAY * spacing).collect();
        astray.sort_by(|a, b| b.1.total_cmp(a.1));
        if !astray.is_empty() && !found.same_topology {
            let named = astray.iter().take(NAMED);
            let named: Vec<String> = named
                .map(|(label, far)| format!("{label} {} mm", human::number(rounded(*far * millimetres, 1))))
                .collect();
            warn(format!(
                "landmarks that do not fit their surroundings: {}; check that they are at the same place of \
                 both faces, or leave them out",
                named.join(", ")
            ));
        }
        if !found.turned_over.is_empty() {
            warn(format!(
                "the warp turns {} over; look at the map of stretches, and add landmarks where the stretch \
                 is largest",
                human::counted(found.turned_over.len(), "triangle")
            ));
        }
        if self.stretch.p95 > STRETCHED {
            warn(format!(
                "a twentieth of the surface is stretched by more than {} %; look at the map of stretches, \
                 and add landmarks where the stretch is largest",
                human::number((100.0 * self.stretch.p95).round())
            ));
        }
        if self.covered < 1.0 - BARE {
            warn(format!(
                "{} % of the skin has no counterpart and gets no wrinkles; look at the map of distances, and \
                 add landmarks near the edge of that area, which bring the faces nearer there",
                human::number((100.0 * (1.0 - self.covered)).round())
            ));
        }
    }
}

fn rounded(x: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    (x * scale).round() / scale
}
