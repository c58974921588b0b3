//! Transfer of one face's wrinkles to another face with another topology.
//!
//! The rest mesh of the first face is laid over the second's by a thin shell. The shell is drawn to
//! landmarks, and then to the closest points that face the same way. So each vertex of the second face has a
//! place on the first. The movements of that place in the first face's examples are carried over, turned and
//! scaled as the surface is. The results are examples for the second face, which is then solved as any other
//! face. Its markers are met exactly. `docs/transfer.md` describes how to use it.
//!
//! ```
//! use rhytid_core::NoProgress;
//! use rhytid_devices::{Guard, choose_devices};
//! use rhytid_transfer::{Settings, transfer};
//!
//! # let first = rhytid_demo::face(3_000);
//! # let rig = rhytid_solve::solve(&first, &NoProgress)?.rounded()?;
//! # let mut second = rhytid_demo::face(2_000);
//! # second.examples.clear();
//! // `rig` from rhytid_core::rig_file::read, `second` from rhytid_formats::project::read: a face without a scan but the neutral.
//! let devices = choose_devices("cpu:0", Guard::NONE, &NoProgress)?.devices;
//! let made = transfer(&rig, &second, &Settings::default(), &devices, &NoProgress)?;
//! assert_eq!(made.face.examples.len(), rig.examples().len());
//! assert!(made.report.covered > 0.9 && made.report.turned_over == 0);
//! let rig = rhytid_solve::solve(&made.face, &NoProgress)?;
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod correspondence;
mod examples;
mod gradients;
mod landmarks;
mod prior;
mod report;
mod shapes;
mod skin;
mod warp;

pub use correspondence::Missing;
pub use prior::read_face;
pub use report::{Bare, Maps, Spread, TransferReport};

use correspondence::{Place, correspondence, stretches};
use examples::{Corner, Known, Maker, carried_everywhere};
use glam::DVec3;
use landmarks::Landmarks;
use report::Measures;
use rhytid_core::{DeviceInfo, Example, Face, Progress, Result, Rig, VertexId};
use rhytid_geometry::{laplacian, triangulate};
use rhytid_solve::{Welded, check};

/// The settings of a transfer.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Settings {
    /// Handles that are at the same place: pairs of labels, of the first face and of the second. `None` for
    /// the handles with the same label.
    pub landmarks: Option<Vec<(String, String)>>,
    /// Whether the whole movement of the first face is carried over, and not only its wrinkles.
    pub linear_band: bool,
}

/// The result of a transfer.
#[derive(Debug, Clone, PartialEq)]
pub struct Transferred {
    /// The second face. The new examples come after its own.
    pub face: Face,
    /// The report of the transfer.
    pub report: TransferReport,
    /// The numbers of the report at each vertex.
    pub maps: Maps,
}

/// Makes examples for the face `to` from those of the rig `from`, which is evaluated on `devices`. An example
/// whose name `to` already has is not made.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if the rig has no examples, if there are too few landmarks, or if they lie
/// on a line. Also for a face that cannot be solved, and where the warp has no solution.
/// [`rhytid_core::Error::Device`]. [`rhytid_core::Error::Cancelled`].
pub fn transfer(
    from: &Rig,
    to: &Face,
    settings: &Settings,
    devices: &[DeviceInfo],
    progress: &dyn Progress,
) -> Result<Transferred> {
    check(to)?;
    let Some(welded) = Welded::new(to) else {
        return transfer_to_points(from, to, settings, devices, progress);
    };
    let made = transfer_to_points(from, &welded.face, settings, devices, progress)?;
    let mut face = to.clone();
    face.settings.align = made.face.settings.align;
    for example in made.face.examples.into_iter().skip(to.examples.len()) {
        face.examples.push(Example { positions: welded.each(&example.positions), ..example });
    }
    let maps =
        Maps { distance_mm: welded.each(&made.maps.distance_mm), stretch: welded.each(&made.maps.stretch) };
    Ok(Transferred { face, report: made.report, maps })
}

/// As [`transfer`], to a face each of whose vertices is a point of its own.
fn transfer_to_points(
    from: &Rig,
    to: &Face,
    settings: &Settings,
    devices: &[DeviceInfo],
    progress: &dyn Progress,
) -> Result<Transferred> {
    let landmarks = Landmarks::new(from, to, settings.landmarks.as_deref())?;
    let rest: Vec<DVec3> = from.surface().rest.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
    let to_rest: Vec<DVec3> = to.neutral.positions.iter().copied().map(DVec3::from_array).collect();
    let (overall, is_mirrored) = landmarks.similarity(&rest, &to_rest)?;
    let shapes = shapes::evaluated(from, devices, progress)?;
    let spacing = overall.scale * shapes::spacing(from);
    let mut found = correspondence(from, to, &landmarks, overall, spacing, progress)?;
    let triangles = triangulate(&to.neutral);
    if !found.same_topology {
        let at_vertices = from.surface().vertex_triangles();
        let moved = shapes.iter().map(|shape| {
            let of_first = stretches(&rest, &shape.full, &from.surface().triangles, &at_vertices);
            (carried_everywhere(&found, &shape.full, &rest), of_first)
        });
        let moved: Vec<(Vec<DVec3>, Vec<f64>)> = moved.collect();
        found.take_out_tears(&to.neutral.positions, &triangles, &moved);
    }
    let area = laplacian::laplacian(&to.neutral.positions, &triangles).mass;
    let measures = Measures { area: &area, spacing };
    let (mut report, maps) =
        TransferReport::new(from, to, &landmarks, is_mirrored, &found, &measures, settings.linear_band);
    let maker = Maker {
        from,
        rest: &rest,
        to,
        correspondence: &found,
        shapes: &shapes,
        triangles: &triangles,
        spacing,
    };
    let known = to.handles.points.iter().enumerate().filter_map(|(handle, point)| {
        // A landmark has the place that the user gave.
        if let Some(i) = landmarks.pairs.iter().position(|pair| pair[1] == *point) {
            let (place, local) = (Place::at(landmarks.pairs[i][0]), found.at_landmarks[i]);
            return Some(Known { handle, corners: vec![Corner { place, local, weight: 1.0 }] });
        }
        let corner = |(v, weight): (VertexId, f64)| {
            let place = *found.places[v.index()].as_ref().ok()?;
            Some(Corner { place, local: found.locals[v.index()], weight })
        };
        Some(Known { handle, corners: point.corners().map(corner).collect::<Option<_>>()? })
    });
    let base = maker.base(known.collect(), progress)?;
    let made = maker.examples(&base, settings.linear_band, progress)?;
    let mut face = to.clone();
    // The new examples are already in the neutral's place.
    face.settings.align &= !face.examples.is_empty();
    for example in made {
        if to.examples.iter().any(|own| own.name == example.name) {
            report.own.push(example.name);
        } else {
            report.examples.push(example.name.clone());
            face.examples.push(example);
        }
    }
    Ok(Transferred { face, report, maps })
}
