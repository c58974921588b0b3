//! Distances between the frames of a rig and the correct ones: over all vertices, by region and by vertex.

use crate::Regions;
use glam::Vec3;
use rhytid_core::VertexId;
use rhytid_solve::FacePart;
use serde::Serialize;

/// How far vertices are from where they should be, in millimetres.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Errors {
    /// The root of the mean square.
    pub rms_mm: f64,
    /// The 95th percentile: 950 of 1000 distances are at most this.
    pub p95_mm: f64,
    /// The 99.9th percentile.
    pub p99_9_mm: f64,
    /// The largest.
    pub worst_mm: f64,
    /// The frame of the largest distance, counted from 0 among the compared ones.
    pub frame: usize,
    /// The vertex of the largest distance.
    pub vertex: usize,
    /// The RMS of each region, the largest first.
    pub regions: Vec<RegionError>,
    /// Over the skin alone, without the mouth's inside, eyes, teeth and other parts.
    pub skin: SkinErrors,
    /// The RMS of all that is not skin. `None` if the mesh has nothing else, or if it does not count.
    pub others_rms_mm: Option<f64>,
}

impl Errors {
    /// The regions of the skin, the largest RMS first.
    pub fn skin_regions(&self) -> impl Iterator<Item = &RegionError> {
        let is_part = |name: &str| FacePart::ALL.into_iter().any(|part| part.name() == name);
        self.regions.iter().filter(move |region| !is_part(&region.region))
    }
}

/// How far vertices of the skin are from where they should be, in millimetres.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct SkinErrors {
    /// The root of the mean square.
    pub rms_mm: f64,
    /// The 95th percentile.
    pub p95_mm: f64,
    /// The 99.9th percentile.
    pub p99_9_mm: f64,
    /// The largest.
    pub worst_mm: f64,
}

/// The error of a region.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RegionError {
    /// Its name.
    pub region: String,
    /// The root of the mean square.
    pub rms_mm: f64,
    /// The largest.
    pub worst_mm: f64,
}

/// Sums up distances, frame by frame.
pub(crate) struct Sum<'a> {
    regions: &'a Regions,
    /// V.
    parts: &'a [FacePart],
    /// V: how much each vertex counts. A vertex of weight 0 is not compared.
    weights: Vec<f64>,
    /// Millimetres in a mesh unit.
    millimetres: f64,
    /// Of all frames × vertices, for the quantiles.
    all: Vec<f32>,
    squares: Vec<f64>,
    worst: (f64, usize, usize),
    worst_of_skin: f64,
    worst_of_region: Vec<f64>,
    frames: usize,
}

impl<'a> Sum<'a> {
    /// Every vertex counts the same.
    pub(crate) fn new(regions: &'a Regions, parts: &'a [FacePart], millimetres: f64) -> Self {
        Self::weighted(regions, parts, vec![1.0; parts.len()], millimetres)
    }

    /// Each vertex counts by its weight.
    pub(crate) fn weighted(
        regions: &'a Regions,
        parts: &'a [FacePart],
        weights: Vec<f64>,
        millimetres: f64,
    ) -> Self {
        Self {
            regions,
            parts,
            millimetres,
            all: Vec::new(),
            squares: vec![0.0; weights.len()],
            weights,
            worst: (0.0, 0, 0),
            worst_of_skin: 0.0,
            worst_of_region: vec![0.0; regions.names().len()],
            frames: 0,
        }
    }

    /// The next frame: the V distances, in mesh units.
    pub(crate) fn add(&mut self, distances: impl Iterator<Item = f64>) {
        for (v, distance) in distances.enumerate() {
            let distance = distance * self.millimetres;
            self.all.push(distance as f32);
            self.squares[v] += distance * distance;
            if self.weights[v] == 0.0 {
                continue;
            }
            // NaN also counts as the worst, and stays.
            if distance > self.worst.0 || distance.is_nan() {
                self.worst = (distance, self.frames, v);
            }
            if self.parts[v] == FacePart::Skin && (distance > self.worst_of_skin || distance.is_nan()) {
                self.worst_of_skin = distance;
            }
            if let Some(region) = self.regions.of_vertex(VertexId::from_index(v)) {
                let worst = &mut self.worst_of_region[region];
                *worst = worst.max(distance);
            }
        }
        self.frames += 1;
    }

    /// The RMS over the frames at each vertex, in millimetres.
    pub(crate) fn by_vertex(&self) -> Vec<f32> {
        self.squares.iter().map(|square| (square / self.frames.max(1) as f64).sqrt() as f32).collect()
    }

    pub(crate) fn finish(mut self) -> Errors {
        let count = self.regions.names().len();
        let frames = self.frames.max(1) as f64;
        let (mut squares, mut weights) = (vec![0.0; count], vec![0.0; count]);
        for (v, (square, weight)) in self.squares.iter().zip(&self.weights).enumerate() {
            if let Some(region) = self.regions.of_vertex(VertexId::from_index(v)) {
                squares[region] += weight * square;
                weights[region] += weight;
            }
        }
        let rms = |squares: f64, weight: f64| match weight > 0.0 {
            true => (squares / (weight * frames)).sqrt(),
            false => 0.0,
        };
        let of_region = |(i, region): (usize, &String)| RegionError {
            region: region.clone(),
            rms_mm: rms(squares[i], weights[i]),
            worst_mm: self.worst_of_region[i],
        };
        let mut regions: Vec<RegionError> = self.regions.names().iter().enumerate().map(of_region).collect();
        regions.sort_by(|a, b| b.rms_mm.total_cmp(&a.rms_mm));
        let total: f64 = self.weights.iter().sum();
        let all = self.squares.iter().zip(&self.weights).map(|(square, weight)| weight * square).sum();
        let [mut of_skin, mut skin_weight] = [0.0; 2];
        for (v, _) in self.parts.iter().enumerate().filter(|(_, part)| **part == FacePart::Skin) {
            of_skin += self.weights[v] * self.squares[v];
            skin_weight += self.weights[v];
        }
        let has_others = total > skin_weight;
        let skin_quantiles = has_others.then(|| self.skin_quantiles());
        let quantiles = [self.quantile(0.95), self.quantile(0.999)];
        let [skin_p95_mm, skin_p99_9_mm] = skin_quantiles.unwrap_or(quantiles);
        let [p95_mm, p99_9_mm] = quantiles;
        let (worst_mm, frame, vertex) = self.worst;
        let skin = SkinErrors {
            rms_mm: rms(of_skin, skin_weight),
            p95_mm: skin_p95_mm,
            p99_9_mm: skin_p99_9_mm,
            worst_mm: self.worst_of_skin,
        };
        let others_rms_mm = has_others.then(|| rms(all - of_skin, total - skin_weight));
        Errors {
            rms_mm: rms(all, total),
            p95_mm,
            p99_9_mm,
            worst_mm,
            frame,
            vertex,
            regions,
            skin,
            others_rms_mm,
        }
    }

    /// The 95th and the 99.9th percentile of the skin. The distances have to be in their order still.
    fn skin_quantiles(&self) -> [f64; 2] {
        let is_skin: Vec<bool> = self.parts.iter().map(|part| *part == FacePart::Skin).collect();
        let of_skin = |(x, is_skin): (&f32, &bool)| is_skin.then_some(*x);
        let weights = self.weights.iter().zip(&is_skin).filter(|(_, is_skin)| **is_skin);
        let mut skin = Self {
            all: self.all.iter().zip(is_skin.iter().cycle()).filter_map(of_skin).collect(),
            weights: weights.map(|(weight, _)| *weight).collect(),
            squares: Vec::new(),
            worst_of_region: Vec::new(),
            ..*self
        };
        [skin.quantile(0.95), skin.quantile(0.999)]
    }

    /// The smallest distance that at least `part` of the weight does not exceed.
    fn quantile(&mut self, part: f64) -> f64 {
        if self.weights.iter().all(|weight| *weight == 1.0) {
            // Selecting needs no memory, and a take has 10⁸ distances.
            let at = (self.all.len() as f64 * part).ceil().max(1.0) as usize - 1;
            return match self.all.is_empty() {
                true => 0.0,
                false => f64::from(*self.all.select_nth_unstable_by(at, f32::total_cmp).1),
            };
        }
        let weights = self.weights.iter().cycle();
        let mut all: Vec<(f32, f64)> = self.all.iter().copied().zip(weights.copied()).collect();
        all.retain(|(_, weight)| *weight > 0.0);
        all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = all.iter().map(|(_, weight)| weight).sum();
        let mut sum = 0.0;
        let found = all.iter().find(|(_, weight)| {
            sum += weight;
            sum >= part * total
        });
        found.or(all.last()).map_or(0.0, |(distance, _)| f64::from(*distance))
    }
}

/// The distance of each vertex between two fields of 3V numbers.
pub(crate) fn distances(a: &[f32], b: &[f32]) -> impl Iterator<Item = f64> {
    let pairs = a.as_chunks::<3>().0.iter().zip(b.as_chunks::<3>().0);
    pairs.map(|(a, b)| Vec3::from(*a).as_dvec3().distance(Vec3::from(*b).as_dvec3()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_summed_up() {
        let groups = [("left".to_owned(), vec![0, 1]), ("right".to_owned(), vec![2])];
        let regions = Regions::by_groups(4, &groups).unwrap();
        let skin = [FacePart::Skin; 4];
        let mut sum = Sum::new(&regions, &skin, 10.0);
        sum.add([0.1, 0.2, 0.5, 0.0].into_iter());
        sum.add([0.3, 0.2, 0.1, 0.4].into_iter());
        let by_vertex = sum.by_vertex();
        assert!((f64::from(by_vertex[0]) - (10.0_f64 / 2.0).sqrt()).abs() < 1e-6, "{by_vertex:?}");
        let errors = sum.finish();
        assert!((errors.rms_mm - (60.0_f64 / 8.0).sqrt()).abs() < 1e-12, "{errors:?}");
        assert_eq!((errors.worst_mm, errors.frame, errors.vertex), (5.0, 0, 2));
        assert_eq!((errors.p95_mm, errors.p99_9_mm), (5.0, 5.0));
        assert_eq!(errors.regions[0].region, "right");
        assert!(
            (errors.regions[1].rms_mm - (18.0_f64 / 4.0).sqrt()).abs() < 1e-12
                && errors.regions[1].worst_mm == 3.0
        );
        // Weights: the third vertex counts three times, the first not at all.
        let mut sum = Sum::weighted(&regions, &skin, vec![0.0, 1.0, 3.0, 1.0], 10.0);
        sum.add([9.0, 0.2, 0.1, 0.4].into_iter());
        let errors = sum.finish();
        assert!((errors.rms_mm - (23.0_f64 / 5.0).sqrt()).abs() < 1e-12, "{errors:?}");
        assert_eq!((errors.worst_mm, errors.vertex, errors.p95_mm), (4.0, 3, 4.0));
        assert_eq!(
            (errors.skin.rms_mm, errors.skin.p95_mm, errors.others_rms_mm),
            (errors.rms_mm, 4.0, None)
        );
        // Eyes and teeth are apart from the skin.
        let parts = [FacePart::Skin, FacePart::Eyes, FacePart::Skin, FacePart::Teeth];
        let mut sum = Sum::new(&regions, &parts, 10.0);
        sum.add([0.1, 9.0, 0.5, 8.0].into_iter());
        sum.add([0.2, 0.0, 0.1, 0.0].into_iter());
        let errors = sum.finish();
        let [skin, others] = [31.0 / 4.0, 14500.0 / 4.0_f64].map(f64::sqrt);
        assert!((errors.skin.rms_mm - skin).abs() < 1e-12, "{errors:?}");
        assert!((errors.others_rms_mm.unwrap() - others).abs() < 1e-12, "{errors:?}");
        assert_eq!((errors.skin.p95_mm, errors.skin.p99_9_mm, errors.skin.worst_mm), (5.0, 5.0, 5.0));
        assert_eq!((errors.worst_mm, errors.p95_mm), (90.0, 90.0));
        let apart: Vec<f64> =
            distances(&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0], &[3.0, 0.0, 4.0, 1.0, 1.0, 1.0]).collect();
        assert_eq!(apart, [5.0, 0.0]);
    }
}
