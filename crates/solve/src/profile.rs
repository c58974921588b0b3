//! The tip of the nose, the chin and the width of a head, from the outlines of its mesh.
use glam::DVec3;
use std::ops::RangeInclusive;

/// The height of a step along an outline, in widths of the head.
const STEP: f64 = 0.04;

/// The outlines reach so far down from the top, in widths of the head: shoulders and chest are below.
const DOWN: f64 = 2.2;

/// The outlines beside the middle are so far from it, in widths of the head: beside the wings of the nose.
const BESIDE: f64 = 0.16;

/// The outlines beside count up to so many steps above and below: the jaw beside a chin is higher than it.
const NEAR: usize = 4;

/// The tip of the nose stands out from both outlines beside it by at least this, in widths of the head.
const STANDS_OUT: f64 = 0.045;

/// The tip of the nose is at least this far below the top, in widths of the head.
const BELOW_TOP: f64 = 0.25;

/// The throat is at least this far behind the tip of the nose, in widths of the head.
const THROAT: f64 = 0.3;

/// The throat stays back for so many steps below the chin.
const STAYS: usize = 4;

/// The least and the largest height of the tip of the nose above the chin, in widths of the head.
const HEIGHTS: RangeInclusive<f64> = 0.12..=0.8;

/// The face ends at the top so far above the tip of the nose, in heights of that tip above the chin.
const FOREHEAD: [f64; 2] = [1.1, 1.5];

/// The hairline of an adult, as a part of the way from the chin to the top of the head.
const HAIRLINE: f64 = 0.78;

/// The ears begin so far behind the tip of the nose, in widths of the head.
pub(crate) const EARS: f64 = 0.52;

/// The line of the jaw begins so far behind the tip of the nose, in widths of the head.
const JAW: f64 = 0.2;

/// The line of the jaw rises by this towards the ears.
const JAW_RISES: f64 = 0.5;

/// How much wider the head is taken to be at each next try.
const WIDER: f64 = 1.15;

/// The most tries.
const TRIES: usize = 12;

/// Where the parts of a face are. Points are in the face's axes: right, up and forward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Profile {
    /// The tip of the nose.
    pub nose: DVec3,
    /// The underside of the chin.
    pub chin: DVec3,
    /// The highest vertex's height.
    pub top: f64,
    /// The width of the head at the cheeks, with its ears.
    pub width: f64,
    /// Whether the mesh goes on below the chin, with a throat.
    pub has_throat: bool,
}

impl Profile {
    /// The profile of the part whose corners the triangles have. `None` if it looks like no head: expected
    /// is an upright one that looks forward, with a nose between its cheeks and a throat below its chin. A
    /// mask may end at the chin.
    pub(crate) fn new(triangles: &[[DVec3; 3]]) -> Option<Self> {
        let mut corners: Vec<DVec3> = triangles.iter().flatten().copied().collect();
        corners.sort_by(|a, b| b.y.total_cmp(&a.y));
        let top = corners.first()?.y;
        // The head is as high as it is wide at a height above its shoulders.
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut least, mut tries) = (0.0, 0);
        for corner in &corners {
            (low, high) = (low.min(corner.x), high.max(corner.x));
            let width = high - low;
            if width > least && top - corner.y >= width && tries < TRIES {
                if let Some(found) = Self::of_width(triangles, top, 0.5 * (low + high), width) {
                    return Some(found);
                }
                (least, tries) = (WIDER * width, tries + 1);
            }
        }
        // A mask can be wider than it is high.
        Self::of_width(triangles, top, 0.5 * (low + high), high - low)
    }

    /// Whether a point of the skin is on the front of the face: below the hairline, before the ears, and
    /// above the line from the chin along the jaw.
    pub(crate) fn has_in_front(&self, point: DVec3) -> bool {
        let height = self.nose.y - self.chin.y;
        let hairline = HAIRLINE * (self.top - self.chin.y) - height;
        let top = self.nose.y + hairline.clamp(FOREHEAD[0] * height, FOREHEAD[1] * height);
        point.y <= top && self.is_above_jaw(point) && self.nose.z - point.z <= EARS * self.width
    }

    /// Whether a point is above the line from the chin along the jaw.
    pub(crate) fn is_above_jaw(&self, point: DVec3) -> bool {
        let behind = self.nose.z - point.z;
        point.y >= self.chin.y + JAW_RISES * (behind - JAW * self.width).max(0.0)
    }

    fn of_width(triangles: &[[DVec3; 3]], top: f64, middle: f64, width: f64) -> Option<Self> {
        let outline = |x: f64| outline(triangles, middle + x * width, top, STEP * width);
        let (between, sides) = (outline(0.0), [outline(-BESIDE), outline(BESIDE)]);
        let stands_out = |step: usize| {
            let near = step.saturating_sub(NEAR)..(step + NEAR + 1).min(between.len());
            let beside =
                |side: &Vec<f64>| side[near.clone()].iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let [left, right] = [beside(&sides[0]), beside(&sides[1])];
            let out = between[step] - left.max(right);
            (out.is_finite() && left.is_finite() && right.is_finite()).then_some(out / width)
        };
        let first = (BELOW_TOP / STEP) as usize;
        let out = (first..between.len()).filter_map(|step| Some((stands_out(step)?, step)));
        let (found, bridge) = out.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))?;
        if found < STANDS_OUT {
            return None;
        }
        let near = bridge.saturating_sub(2)..(bridge + 3).min(between.len());
        let tip = near.max_by(|&a, &b| between[a].total_cmp(&between[b]).then(b.cmp(&a)))?;
        let at = |step: usize, z: f64| DVec3::new(middle, top - (step as f64 + 0.5) * STEP * width, z);
        let nose = at(tip, between[tip]);
        // The gap between the lips may be empty, or lead into the mouth.
        let is_back = |step: &usize| between[*step] < nose.z - THROAT * width;
        let last = (tip..between.len()).rev().find(|step| between[*step].is_finite())?;
        let chin = (tip..=last).find(|&step| {
            step + 1 > last || (step + 1..=(step + STAYS).min(last)).all(|step| is_back(&step))
        })?;
        let has_throat = chin + STAYS <= last;
        let chin = at(chin, between[chin].max(nose.z - THROAT * width)) - DVec3::Y * 0.5 * STEP * width;
        let height = (nose.y - chin.y) / width;
        if !HEIGHTS.contains(&height) {
            return None;
        }
        // The width again, now at the height of the cheeks.
        let cheeks = nose.y..nose.y + (nose.y - chin.y);
        let at_cheeks = triangles.iter().flatten().filter(|corner| cheeks.contains(&corner.y));
        let near = at_cheeks.filter(|corner| (corner.x - middle).abs() < width).map(|corner| corner.x);
        let (low, high) = near.fold((middle, middle), |(low, high), x| (low.min(x), high.max(x)));
        Some(Self { nose, chin, top, width: high - low, has_throat })
    }
}

/// How far forward a mesh reaches in the plane of a given x, at each step down from the top. It is minus
/// infinity where the plane misses the mesh.
fn outline(triangles: &[[DVec3; 3]], x: f64, top: f64, step: f64) -> Vec<f64> {
    let mut outline = vec![f64::NEG_INFINITY; (DOWN / STEP) as usize];
    for [a, b, c] in triangles {
        // A triangle with an edge in the plane has three such points.
        let mut ends: Option<[DVec3; 2]> = None;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if (from.x - x) * (to.x - x) > 0.0 {
                continue;
            }
            let share = if from.x == to.x { 0.0 } else { (x - from.x) / (to.x - from.x) };
            let point = from.lerp(*to, share);
            let [upper, lower] = ends.unwrap_or([point; 2]);
            ends = Some([
                if point.y > upper.y { point } else { upper },
                if point.y < lower.y { point } else { lower },
            ]);
        }
        let Some([upper, lower]) = ends else { continue };
        let steps = [upper, lower].map(|point| ((top - point.y) / step).max(0.0) as usize);
        for (number, reach) in outline.iter_mut().enumerate().take(steps[1].saturating_add(1)).skip(steps[0])
        {
            let middle = top - (number as f64 + 0.5) * step;
            let share = match upper.y - lower.y {
                height if height > 0.0 => ((upper.y - middle) / height).clamp(0.0, 1.0),
                _ => 0.0,
            };
            *reach = reach.max(upper.lerp(lower, share).z);
        }
    }
    outline
}
