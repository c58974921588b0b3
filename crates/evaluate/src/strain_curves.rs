//! Curves of strain: the stretch and squeeze of each region of a face, frame by frame.

use crate::Regions;
use rhytid_core::{Result, Rig, VertexId, channel};
use rhytid_formats::export::Frame;
use rhytid_formats::tables;
use rhytid_geometry::{PrincipalStrains, StrainGauge};
use std::path::Path;

/// The curves of each region.
const CURVES: [&str; 3] = ["strain1", "strain2", "area"];

/// The means over the regions of a face of its principal strains and of the strain of its area, (1 + e₁)(1 +
/// e₂) − 1, frame after frame. A vertex is weighted by a third of its triangles' areas at rest.
pub struct StrainCurves<'a> {
    regions: &'a Regions,
    gauge: StrainGauge,
    areas: Vec<f64>,
    /// The area of each region.
    sums: Vec<f64>,
    strains: PrincipalStrains,
    /// frames × regions × [`CURVES`].
    values: Vec<f32>,
}

impl<'a> StrainCurves<'a> {
    /// For the vertices of `rig`, which `regions` are of.
    pub fn new(rig: &Rig, regions: &'a Regions) -> Self {
        let gauge = StrainGauge::of_surface(rig.surface());
        let areas: Vec<f64> = gauge.areas().collect();
        let mut sums = vec![0.0; regions.names().len()];
        for (v, area) in areas.iter().enumerate() {
            if let Some(region) = regions.of_vertex(VertexId::from_index(v)) {
                sums[region] += area;
            }
        }
        Self { regions, gauge, areas, sums, strains: PrincipalStrains::default(), values: Vec::new() }
    }

    /// Adds a frame. Strains that the frame lacks are computed.
    pub fn frame(&mut self, frame: &Frame<'_>) {
        let strains = match frame.get(&channel::STRAIN) {
            Some(strains) => strains.as_chunks().0,
            None => {
                self.gauge.measure(frame.positions().as_chunks().0, &mut self.strains);
                &self.strains.strains
            }
        };
        let mut means = vec![[0.0; CURVES.len()]; self.sums.len()];
        for (v, (strain, area)) in strains.iter().zip(&self.areas).enumerate() {
            if let Some(region) = self.regions.of_vertex(VertexId::from_index(v)) {
                let [first, second] = strain.map(f64::from);
                let of_area = (1.0 + first) * (1.0 + second) - 1.0;
                for (mean, x) in means[region].iter_mut().zip([first, second, of_area]) {
                    *mean += area * x;
                }
            }
        }
        for (mean, sum) in means.iter().zip(&self.sums) {
            self.values.extend(mean.map(|mean| if *sum > 0.0 { (mean / sum) as f32 } else { 0.0 }));
        }
    }

    /// Writes the curves as CSV, the first frame having the number `first`: columns `frame`, `time`, and of
    /// each region `REGION_strain1`, `REGION_strain2` and `REGION_area`.
    ///
    /// # Errors
    /// As [`tables::write_curves`].
    pub fn write(&self, path: &Path, first: usize, rate: f64) -> Result<()> {
        let names =
            self.regions.names().iter().flat_map(|name| CURVES.map(|curve| format!("{name}_{curve}")));
        tables::write_curves(path, &names.collect::<Vec<_>>(), first, rate, &self.values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use rhytid_core::NoProgress;

    #[test]
    fn a_face_that_grows_is_stretched_alike_in_every_region() {
        let face = rhytid_demo::face(1_000);
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let regions = Regions::by_labels(&rig);
        let mut curves = StrainCurves::new(&rig, &regions);
        let rest = rig.surface().rest.as_flattened();
        let larger: Vec<f32> = rest.iter().map(|x| 1.25 * x).collect();
        let strained = vec![[0.5, -0.2]; rig.vertices()].into_flattened();
        curves.frame(&Frame::new(rest));
        let frame = Frame::new(&larger);
        curves.frame(&frame);
        curves.frame(&frame.with(&channel::STRAIN, &strained));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("curves.csv");
        curves.write(&path, 7, 25.0).unwrap();

        let text = std::fs::read_to_string(&path).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!((rows.len(), &rows[0][..3]), (4, &["frame", "time", "brows_strain1"][..]), "{text}");
        assert_eq!(rows[0].len(), 2 + 3 * regions.names().len());
        for (i, expected) in [[0.0, 0.0, 0.0], [0.25, 0.25, 0.5625], [0.5, -0.2, 0.2]].iter().enumerate() {
            assert_eq!(rows[i + 1][..2], [(7 + i).to_string(), format!("{:.6}", (7 + i) as f64 / 25.0)]);
            for (cell, expected) in rows[i + 1][2..].iter().zip(expected.iter().cycle()) {
                assert!(
                    (cell.parse::<f64>().unwrap() - expected).abs() < 1e-5,
                    "{cell}, expected {expected}"
                );
            }
        }
    }

    /// One region of two, by an independent sum over triangles rather than vertices.
    #[test]
    fn means_are_weighted_by_area() {
        let face = rhytid_demo::face(1_000);
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let left: Vec<u32> =
            (0..rig.vertices() as u32).filter(|v| rig.surface().rest[*v as usize][0] > 0.0).collect();
        let inside = |v: u32| left.binary_search(&v).is_ok();
        let regions = Regions::by_groups(rig.vertices(), &[("left".to_owned(), left.clone())]).unwrap();
        let height = |v: u32| f64::from(rig.surface().rest[v as usize][1]);
        let strains: Vec<f32> = (0..rig.vertices() as u32).flat_map(|v| [height(v) as f32, 0.0]).collect();
        let mut curves = StrainCurves::new(&rig, &regions);
        let positions = rig.surface().rest.as_flattened();
        curves.frame(&Frame::new(positions).with(&channel::STRAIN, &strains));
        let (mut sum, mut area) = (0.0, 0.0);
        for triangle in &rig.surface().triangles {
            let [a, b, c] = triangle.map(|v| Vec3::from(rig.surface().rest[v as usize]).as_dvec3());
            let size = (b - a).cross(c - a).length();
            for v in triangle.iter().filter(|v| inside(**v)) {
                (sum, area) = (sum + size * height(*v), area + size);
            }
        }
        let [found, none, of_area] = curves.values[..] else { panic!("{:?}", curves.values) };
        assert!((f64::from(found) - sum / area).abs() < 1e-5, "{found}, expected {}", sum / area);
        assert!(none == 0.0 && (of_area - found).abs() < 1e-6);
    }
}
