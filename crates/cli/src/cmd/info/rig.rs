//! `rhytid info` of a rig file.

use super::super::pack::Nearness;
use super::shape::{Shape, list, row, up};
use rhytid::core::Influences;
use rhytid::core::Mesh;
use rhytid::core::RigParts;
use rhytid::core::UpAxis;
use rhytid::core::human;
use rhytid::core::rig_file::Packing;
use rhytid::{BasisStorage, Rig};
use serde::Serialize;

#[derive(Serialize)]
pub(super) struct RigInfo {
    pub name: String,
    metres_per_unit: f64,
    up: UpAxis,
    #[serde(flatten)]
    shape: Shape,
    driven_vertices: usize,
    handles: usize,
    labels: Vec<String>,
    strain_edges: usize,
    examples: Vec<String>,
    centers: usize,
    influences: usize,
    method: &'static str,
    /// Null for the chapter's method, like the next key.
    share: Option<f64>,
    ridge: Option<f64>,
    bending_length: f64,
    rotations: bool,
    beta: f64,
    f16_error: f64,
    device_bytes: usize,
    device_bytes_per_frame: usize,
    /// Null for a rig that is not packed.
    packed: Option<PackedInfo>,
}

/// What a packed rig states of itself.
#[derive(Serialize)]
struct PackedInfo {
    #[serde(flatten)]
    nearness: Nearness,
    whole_rig: String,
}

impl RigInfo {
    pub(super) fn from_rig(rig: Rig, packing: Option<Packing>) -> Self {
        let (device_bytes, device_bytes_per_frame) =
            (rhytid::playback::rig_bytes(&rig), rhytid::playback::frame_bytes(&rig));
        let f16_error = BasisStorage::F16.largest_error(&rig);
        let driven = |row: &&[f32]| row.iter().any(|&b| b != 0.0);
        let driven_vertices = rig.basis().rows().filter(driven).count();
        let (centers, influences) = (rig.centers(), rig.influences().per_vertex());
        let RigParts {
            surface,
            handles,
            examples,
            bending_length,
            influences: Influences { beta, .. },
            learned,
            ..
        } = rig.into_parts();
        let neutral = Mesh {
            positions: surface.rest.iter().map(|p| p.map(f64::from)).collect(),
            faces: surface.faces,
            uvs: surface.uvs,
            materials: surface.materials,
        };
        Self {
            name: surface.name,
            metres_per_unit: surface.metres_per_unit,
            up: surface.up_axis,
            shape: Shape::from_mesh(&neutral),
            driven_vertices,
            handles: handles.len(),
            labels: handles.labels,
            strain_edges: handles.strain_edges.len(),
            examples: examples.names,
            centers,
            influences,
            method: if learned.is_some() { "learned" } else { "chapter" },
            share: learned.as_ref().map(|learned| learned.share),
            ridge: learned.as_ref().map(|learned| learned.ridge),
            bending_length,
            rotations: handles.rotations,
            beta,
            f16_error,
            device_bytes,
            device_bytes_per_frame,
            packed: packing.map(|packing| PackedInfo {
                nearness: Nearness::new(&packing, surface.metres_per_unit),
                whole_rig: packing.rig,
            }),
        }
    }

    fn method_in_words(&self) -> String {
        match (self.share, self.ridge) {
            (Some(share), Some(ridge)) => {
                format!("{}, share {}, ridge {}", self.method, human::number(share), human::number(ridge))
            }
            _ => self.method.to_owned(),
        }
    }

    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        let unit = human::unit(self.metres_per_unit);
        let mut rows = vec![row("units", format!("{unit}, {} up", up(self.up)))];
        rows.extend(self.shape.rows(&unit));
        rows.extend([
            row("driven vertices", human::count(self.driven_vertices)),
            row("handles", list(&self.labels)),
            row("strain edges", human::count(self.strain_edges)),
            row("examples", list(&self.examples)),
            row("influences", format!("{} per vertex", self.influences)),
            row("method", self.method_in_words()),
            row("bending length", format!("{} {unit}", human::number(self.bending_length))),
            row("rotations", if self.rotations { "yes" } else { "no" }.to_owned()),
            row("beta", format!("{} per {unit}", human::number(self.beta))),
            row(
                "basis as fp16",
                format!(
                    "moves no vertex by more than {} mm if handles move by up to {} mm",
                    human::number(1000.0 * self.metres_per_unit * self.f16_error),
                    BasisStorage::MOTION_MM
                ),
            ),
            row(
                "memory on a device",
                format!(
                    "{} and {} per frame of a batch",
                    human::bytes(self.device_bytes as u64),
                    human::bytes(self.device_bytes_per_frame as u64)
                ),
            ),
        ]);
        if let Some(packed) = &self.packed {
            rows.push(row("packed", packed.nearness.text().replace('\n', "; ")));
        }
        rows
    }
}
