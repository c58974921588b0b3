//! The handles: the places of the markers.
use crate::grid::Grid;
use rhytid_core::{Handles, VertexId};

/// Markers on the midline: label and `up` in the domain.
const MIDDLE: [(&str, f64); 13] = [
    ("forehead_top", 6.0),
    ("forehead", 4.1),
    ("glabella", 2.1),
    ("nasion", 0.6),
    ("nose_bridge", -1.4),
    ("nose_tip", -3.4),
    ("subnasale", -4.8),
    ("lip_up", -6.05),
    ("lip_low", -6.9),
    ("chin_crease", -8.3),
    ("chin", -9.6),
    ("under_chin", -11.6),
    ("neck", -13.9),
];

/// Markers on the left: label, `across` and `up`. The right has the same, mirrored.
const LEFT: [(&str, f64, f64); 38] = [
    ("forehead_top_1", 2.3, 6.2),
    ("forehead_top_2", 4.8, 5.8),
    ("forehead_top_3", 7.4, 4.9),
    ("forehead_1", 2.0, 4.2),
    ("forehead_2", 4.1, 4.1),
    ("forehead_3", 6.2, 3.5),
    ("brow_1", 0.95, 2.1),
    ("brow_2", 2.3, 2.5),
    ("brow_3", 3.8, 2.6),
    ("brow_4", 5.3, 2.0),
    ("temple", 8.2, 2.0),
    ("lid_up_1", 2.5, 0.5),
    ("lid_up_2", 3.9, 0.5),
    ("lid_low_1", 2.5, -0.5),
    ("lid_low_2", 3.9, -0.5),
    ("eye_out", 5.9, 0.2),
    ("cheekbone_1", 2.2, -1.7),
    ("cheekbone_2", 3.9, -1.8),
    ("cheekbone_3", 5.8, -1.8),
    ("cheekbone_4", 8.2, -1.5),
    ("nose_side", 1.0, -1.9),
    ("nostril", 1.45, -3.75),
    ("nostril_base", 0.85, -4.75),
    ("cheek_1", 2.5, -3.5),
    ("cheek_2", 4.3, -3.8),
    ("cheek_3", 6.4, -4.0),
    ("ear", 8.6, -4.9),
    ("lip_up_1", 1.2, -6.03),
    ("laugh_line", 2.4, -5.2),
    ("mouth_corner", 2.95, -6.45),
    ("lip_low_1", 1.25, -6.9),
    ("jowl_1", 4.3, -6.2),
    ("jowl_2", 6.5, -6.8),
    ("chin_1", 1.6, -8.9),
    ("jaw_1", 2.5, -10.5),
    ("jaw_2", 3.7, -8.6),
    ("jaw_3", 5.6, -9.4),
    ("neck_1", 4.6, -13.0),
];

/// The handles of a grid: the vertices nearest to the markers.
pub(crate) fn handles(grid: &Grid) -> Handles {
    let mut out = Handles::default();
    let mut add = |label: String, across: f64, up: f64| {
        out.labels.push(label);
        out.points.push(VertexId::from_index(grid.nearest(across, up)).into());
    };
    for (label, up) in MIDDLE {
        add(label.into(), 0.0, up);
    }
    for (side, sign) in [("L", 1.0), ("R", -1.0)] {
        for (label, across, up) in LEFT {
            // brow_1 becomes brow_L1, temple becomes temple_L.
            let label = match label.rsplit_once('_') {
                Some((name, number)) if number.parse::<u8>().is_ok() => format!("{name}_{side}{number}"),
                _ => format!("{label}_{side}"),
            };
            add(label, sign * across, up);
        }
    }
    out
}
