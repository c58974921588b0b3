//! Names for the places of a face, such as “left cheek” or “upper lip”, from where they are.
use crate::head::axes;
use crate::profile::{EARS, Profile};
use glam::{DMat3, DVec2, DVec3};
use rhytid_core::{Rig, SurfacePoint};
use rhytid_geometry::components;
use rhytid_kernels::Real;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Where eyes and mouth are where no opening shows them, from the tip of the nose, in heights of that tip
/// above the chin.
const EYES_ABOVE: f64 = 0.4;
const EYES_ASIDE: f64 = 0.4;
const MOUTH_BELOW: f64 = 0.5;
const MOUTH_ASIDE: f64 = 0.3;

/// The rims of an eye are in these distances above the tip of the nose and beside it, in the same heights.
const EYE_RIMS: [Range<f64>; 2] = [0.1..0.85, 0.08..0.85];
/// The rims of the lips are in these distances below the tip of the nose and beside it.
const LIP_RIMS: [Range<f64>; 2] = [0.28..0.75, 0.0..0.55];
/// Rims of eyes and lips are at most so far behind the tip of the nose.
const RIMS_BEHIND: f64 = 0.9;
/// The least and the largest width of the rims of an eye and of the lips.
const EYE_WIDTHS: Range<f64> = 0.12..0.7;
const LIP_WIDTHS: Range<f64> = 0.25..1.0;
/// The rims of an opening are at least so many vertices.
const LEAST_RIMS: usize = 6;
/// Both eyes are at about the same height and distance from the middle, in distances between them.
const UNEVEN: f64 = 0.2;

/// All the following are in distances between the middles of the eyes.
///
/// The lids reach so far above and below the middle of an eye, and so far to either side of it.
const LIDS: [f64; 2] = [0.24, 0.36];
/// The skin under an eye ends here.
const UNDER_EYE: f64 = 0.42;
/// Brows end so far above the middles of the eyes, and so far from the middle of the face.
const BROWS: [f64; 2] = [0.6, 0.95];
/// What is nearer to the middle is between the brows, and on the bridge of the nose.
const BETWEEN_BROWS: f64 = 0.15;
const BRIDGE: f64 = 0.2;
/// The ears end so far above the middles of the eyes.
const ABOVE_EARS: f64 = 0.5;
/// The forehead ends so far above the middles of the eyes.
const FOREHEAD: f64 = 1.15;
/// The middle of the forehead is so wide.
const MIDDLE_OF_FOREHEAD: f64 = 0.3;
/// The wings of the nose reach so far.
const WINGS: f64 = 0.3;
/// The chin reaches so far.
const CHIN: f64 = 0.42;

/// The nose ends at this part of the way from its tip to the mouth.
const BASE_OF_NOSE: f64 = 0.42;
/// The lower lip ends at this part of the way from the mouth to the chin.
const LOWER_LIP: f64 = 0.42;
/// The corners of the mouth are in these parts of half its width, and in this part of the height of the
/// upper lip.
const CORNERS: Range<f64> = 0.75..1.35;
const CORNER_HEIGHT: f64 = 0.45;
/// The chin's underside belongs to the chin so far below it, in heights of the chin.
const UNDER_CHIN: f64 = 0.15;

/// The back of the head begins so far behind the tip of the nose, in widths of the head.
const BACK: f64 = 0.8;

/// Where the parts of a face are.
///
/// Left and right are the person's own.
#[derive(Debug, Clone)]
pub struct FacePlaces {
    /// To the face's axes: its left, up and forward.
    to_face: DMat3,
    profile: Profile,
    /// The middle of the face, as x.
    middle: f64,
    /// The height of the eyes' middles, and the distance between them.
    eyes: f64,
    between_eyes: f64,
    /// The height of the mouth's corners, and half the mouth's width.
    mouth: f64,
    half_mouth: f64,
}

/// What is known of an opening: its middle, and its width.
struct Opening {
    middle: DVec2,
    width: f64,
}

impl FacePlaces {
    /// The places of a rig's face. `None` if its surface does not look like a face that looks ahead, along +Z
    /// where Y is up and along −Y where Z is up.
    pub fn of_rig<T: Real>(rig: &Rig<T>) -> Option<Self> {
        let surface = rig.surface();
        let to_face = axes(surface.up_axis).transpose();
        let points: Vec<DVec3> =
            surface.rest.iter().map(|x| to_face * DVec3::from_array(x.map(T::widen))).collect();
        let triangles = surface.joined_triangles();
        let (part_of, count) = components(points.len(), triangles.iter());
        let mut has_handle = vec![false; count];
        for v in rig.handles().points.iter().flat_map(SurfacePoint::triangle) {
            has_handle[part_of[surface.first(v.0) as usize] as usize] = true;
        }
        let is_skin = |t: &&[u32; 3]| has_handle[part_of[t[0] as usize] as usize];
        let skin: Vec<[u32; 3]> = triangles.iter().filter(is_skin).copied().collect();
        let corners: Vec<[DVec3; 3]> = skin.iter().map(|t| t.map(|v| points[v as usize])).collect();
        let profile = Profile::new(&corners)?;

        let mut rims: Vec<DVec3> = border(&skin).into_iter().map(|v| points[v as usize]).collect();
        let mut eyeballs: Vec<DVec3> = Vec::new();
        if let Some(learned) = rig.learned() {
            rims.extend(learned.contact.openings.rims.iter().map(|rim| points[rim.vertex.index()]));
            for eyeball in &learned.contact.eyeballs {
                let weighted = |(v, w): (&rhytid_core::VertexId, T)| points[v.index()] * w.widen();
                eyeballs.push(eyeball.corners.iter().zip(eyeball.weights).map(weighted).sum());
            }
        }
        Some(Self::new(to_face, profile, &rims, &eyeballs))
    }

    /// `rims` and `eyeballs` are in the face's axes.
    fn new(to_face: DMat3, profile: Profile, rims: &[DVec3], eyeballs: &[DVec3]) -> Self {
        let height = profile.nose.y - profile.chin.y;
        let opening = |side: f64, [along, aside]: &[Range<f64>; 2], widths: &Range<f64>, up: f64| {
            let mut found: Vec<DVec2> = Vec::new();
            for rim in rims {
                let from = (*rim - profile.nose) / height;
                let is_there = along.contains(&(up * from.y))
                    && (aside.contains(&(side * from.x)) || (side == 0.0 && from.x.abs() < aside.end))
                    && -from.z < RIMS_BEHIND;
                if is_there {
                    found.push(from.truncate());
                }
            }
            let low = found.iter().copied().reduce(DVec2::min)?;
            let high = found.iter().copied().reduce(DVec2::max)?;
            let width = high.x - low.x;
            (found.len() >= LEAST_RIMS && widths.contains(&width))
                .then(|| Opening { middle: 0.5 * (low + high), width })
        };
        let eye = |side: f64| {
            let of_side = |ball: &&DVec3| side * (ball.x - profile.nose.x) > 0.0;
            let ball = eyeballs.iter().find(of_side);
            let by_ball = ball.map(|ball| ((*ball - profile.nose) / height).truncate());
            by_ball.or_else(|| opening(side, &EYE_RIMS, &EYE_WIDTHS, 1.0).map(|opening| opening.middle))
        };
        let even = |[left, right]: [DVec2; 2]| {
            let between = left.x - right.x;
            (left.y - right.y).abs() < UNEVEN * between && (left.x + right.x).abs() < 2.0 * UNEVEN * between
        };
        let [left, right] = eye(1.0)
            .zip(eye(-1.0))
            .map(|(left, right)| [left, right])
            .filter(|eyes| even(*eyes))
            .unwrap_or([1.0, -1.0].map(|side| DVec2::new(side * EYES_ASIDE, EYES_ABOVE)));
        let mouth = opening(0.0, &LIP_RIMS, &LIP_WIDTHS, -1.0)
            .unwrap_or(Opening { middle: DVec2::new(0.0, -MOUTH_BELOW), width: 2.0 * MOUTH_ASIDE });
        Self {
            to_face,
            profile,
            middle: profile.nose.x + 0.5 * height * (left.x + right.x),
            eyes: profile.nose.y + 0.5 * height * (left.y + right.y),
            between_eyes: height * (left.x - right.x),
            mouth: profile.nose.y + height * mouth.middle.y,
            half_mouth: 0.5 * height * mouth.width,
        }
    }

    /// The name of the place at a point of the mesh's space, such as “left cheek”.
    ///
    /// `region` is what else is known: a region of the face that a label names, such as “brows”. It counts
    /// before the place.
    pub fn name(&self, point: [f64; 3], region: Option<&str>) -> String {
        let point = self.to_face * DVec3::from_array(point);
        let aside = point.x - self.middle;
        let sided = |what: &str| format!("{} {what}", if aside > 0.0 { "left" } else { "right" });
        let whole = str::to_owned;
        let far = aside.abs() / self.between_eyes;
        match region {
            Some("brows") if far < BETWEEN_BROWS => whole("between the brows"),
            Some("brows") => sided("brow"),
            Some("lids") if point.y >= self.eyes => sided("upper lid"),
            Some("lids") => sided("lower lid"),
            Some("lips") => self.lips(point).map_or_else(|| sided("corner of the mouth"), whole),
            Some("cheeks") => sided("cheek"),
            Some("jaw") if far < CHIN => whole("chin"),
            Some("jaw") => sided("jaw"),
            Some("ears") => sided("ear"),
            Some("forehead") if far < MIDDLE_OF_FOREHEAD => whole("forehead"),
            Some("forehead") => sided("side of the forehead"),
            Some(other) => whole(other),
            None => self.by_place(point, aside, far),
        }
    }

    /// Whether a point is as high and as near the middle as the mouth, so that what is hidden there is in it.
    pub(crate) fn is_at_mouth(&self, point: [f64; 3]) -> bool {
        let point = self.to_face * DVec3::from_array(point);
        let base = self.profile.nose.y + BASE_OF_NOSE * (self.mouth - self.profile.nose.y);
        point.y < base && point.y > self.profile.chin.y && (point.x - self.middle).abs() < self.between_eyes
    }

    fn by_place(&self, point: DVec3, aside: f64, far: f64) -> String {
        let sided = |what: &str| format!("{} {what}", if aside > 0.0 { "left" } else { "right" });
        let whole = str::to_owned;
        let Profile { nose, chin, width, .. } = self.profile;
        let behind = (nose.z - point.z) / width;
        let above_eyes = (point.y - self.eyes) / self.between_eyes;
        let chin_height = self.mouth - chin.y;
        if above_eyes > FOREHEAD {
            return whole(if behind > BACK { "back of the head" } else { "top of the head" });
        }
        if behind > BACK {
            return whole(if point.y < chin.y { "neck" } else { "back of the head" });
        }
        if point.y < chin.y - UNDER_CHIN * chin_height && !self.profile.is_above_jaw(point) {
            return whole("neck");
        }
        if behind > EARS {
            return sided(match above_eyes {
                above if above > ABOVE_EARS => "temple",
                _ if point.y > self.mouth => "ear",
                _ => "jaw",
            });
        }
        if above_eyes > BROWS[0] {
            return match far {
                far if far < MIDDLE_OF_FOREHEAD => whole("forehead"),
                far if far < BROWS[1] => sided("side of the forehead"),
                _ => sided("temple"),
            };
        }
        let from_eye = (far - 0.5).abs();
        if above_eyes > LIDS[0] {
            return match far {
                far if far < BETWEEN_BROWS => whole("between the brows"),
                far if far < BROWS[1] => sided("brow"),
                _ => sided("temple"),
            };
        }
        if above_eyes > -LIDS[0] && far > BRIDGE {
            return match from_eye {
                from if from < LIDS[1] => sided(if above_eyes >= 0.0 { "upper lid" } else { "lower lid" }),
                _ if above_eyes > 0.0 => sided("temple"),
                _ => sided("cheek"),
            };
        }
        let base = nose.y + BASE_OF_NOSE * (self.mouth - nose.y);
        if point.y > base {
            let wings = if point.y < 0.5 * (nose.y + self.eyes) { WINGS } else { BRIDGE };
            return match far {
                far if far < wings => whole("nose"),
                _ if above_eyes > -UNDER_EYE && from_eye < LIDS[1] => {
                    format!("skin under the {} eye", if aside > 0.0 { "left" } else { "right" })
                }
                _ => sided("cheek"),
            };
        }
        let lips_end = self.mouth - LOWER_LIP * chin_height;
        if point.y > lips_end {
            return match (self.lips(point), aside.abs() / self.half_mouth) {
                (Some(lip), part) if part < CORNERS.start => whole(lip),
                (None, part) if part < CORNERS.end => sided("corner of the mouth"),
                _ if !self.profile.is_above_jaw(point) => sided("jaw"),
                (Some(lip), part) if part < 1.0 => whole(lip),
                _ => sided("cheek"),
            };
        }
        match far {
            far if far < CHIN => whole("chin"),
            _ => sided("jaw"),
        }
    }

    /// The lip at a point beside the mouth. `None` at the corners.
    fn lips(&self, point: DVec3) -> Option<&'static str> {
        let above = (point.y - self.mouth) / (self.profile.nose.y - self.mouth);
        let part = (point.x - self.middle).abs() / self.half_mouth;
        if part > CORNERS.start && above.abs() < CORNER_HEIGHT {
            return None;
        }
        Some(if above >= 0.0 { "upper lip" } else { "lower lip" })
    }
}

/// The vertices at open edges, which have one triangle.
fn border(triangles: &[[u32; 3]]) -> BTreeSet<u32> {
    let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for [a, b, c] in triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *edges.entry([*from.min(to), *from.max(to)]).or_default() += 1;
        }
    }
    edges.into_iter().filter(|(_, count)| *count == 1).flat_map(|(edge, _)| edge).collect()
}
