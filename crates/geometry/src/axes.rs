//! The axes of a file.
use glam::{DMat3, DQuat, DVec3};
use rhytid_core::UpAxis;
use std::fmt;
use std::str::FromStr;

/// Which axes of a file the mesh's x, y and z are. Files may use one of the 24 rotations that map axes to
/// axes. Takes may also use a mirror image of one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Axes([(usize, bool); 3]);

impl Axes {
    /// The file has the mesh's axes.
    pub const SAME: Self = Self([(0, false), (1, false), (2, false)]);

    /// From a file whose y points up to a mesh whose z does.
    pub const Y_UP_TO_Z_UP: Self = Self([(0, false), (2, true), (1, false)]);

    /// From a file whose z points up to a mesh whose y does.
    pub const Z_UP_TO_Y_UP: Self = Self([(0, false), (2, false), (1, true)]);

    /// From a file with the first axis up to a mesh with the second axis up.
    pub fn between(file: UpAxis, mesh: UpAxis) -> Self {
        match (file, mesh) {
            (UpAxis::Y, UpAxis::Z) => Self::Y_UP_TO_Z_UP,
            (UpAxis::Z, UpAxis::Y) => Self::Z_UP_TO_Y_UP,
            _ => Self::SAME,
        }
    }

    /// The 24 rotations.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::with_mirror_images().filter(|axes| !axes.is_mirror_image())
    }

    /// The 24 rotations and their 24 mirror images.
    pub fn with_mirror_images() -> impl Iterator<Item = Self> {
        let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        orders.into_iter().flat_map(|order| {
            (0..8).map(move |signs| Self(std::array::from_fn(|i| (order[i], signs >> i & 1 == 1))))
        })
    }

    /// Whether left and right change sides.
    pub fn is_mirror_image(&self) -> bool {
        self.matrix().determinant() < 0.0
    }

    /// Where a point of the file is in the mesh's axes.
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        self.0.map(|(axis, negative)| if negative { -point[axis] } else { point[axis] })
    }

    /// The axes that are nearest to a rotation from the file's axes to the mesh's, or to a mirror image of
    /// one.
    pub fn nearest(wanted: DMat3) -> Self {
        let likeness = |axes: &Self| -> f64 {
            let matrix = axes.matrix();
            (0..3).map(|i| matrix.col(i).dot(wanted.col(i))).sum()
        };
        let all = Self::with_mirror_images();
        all.max_by(|a, b| likeness(a).total_cmp(&likeness(b))).unwrap_or(Self::SAME)
    }

    /// The rotation from the file's axes to the mesh's.
    pub fn rotation(&self) -> DQuat {
        DQuat::from_mat3(&self.matrix())
    }

    /// The matrix from the file's axes to the mesh's.
    pub fn matrix(&self) -> DMat3 {
        let row = |(axis, negative): (usize, bool)| {
            let mut row = DVec3::ZERO;
            row[axis] = if negative { -1.0 } else { 1.0 };
            row
        };
        DMat3::from_cols(row(self.0[0]), row(self.0[1]), row(self.0[2])).transpose()
    }
}

impl fmt::Display for Axes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|&(axis, negative)| {
            write!(f, "{}{}", if negative { '-' } else { '+' }, ["x", "y", "z"][axis])
        })
    }
}

impl FromStr for Axes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::with_mirror_images().find(|axes| axes.to_string() == text).ok_or_else(|| {
            format!(
                "“{text}” does not name three axes, expected the file's axes that become the mesh's x, y and \
                 z, such as +x+z-y for a file with Z up"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_24_and_each_is_read_back() {
        let all: Vec<Axes> = Axes::all().collect();
        assert_eq!(all.len(), 24);
        for axes in all {
            assert_eq!(axes.to_string().parse::<Axes>().unwrap(), axes);
            let slightly = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.5);
            let turned = DMat3::from_quat(slightly) * axes.matrix();
            assert_eq!(Axes::nearest(turned), axes);
            let mirrored = "-x+y+z".parse::<Axes>().unwrap().matrix();
            assert!(Axes::nearest(turned * mirrored).is_mirror_image());
        }
        assert!("-x+y+z".parse::<Axes>().unwrap().is_mirror_image());
        assert_eq!(Axes::with_mirror_images().count(), 48);
        for wrong in ["", "xyz", "+x+x+y"] {
            assert!(wrong.parse::<Axes>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn z_up_becomes_y_up() {
        let axes: Axes = "+x+z-y".parse().unwrap();
        let turned = axes.rotation() * DVec3::new(1.0, 2.0, 3.0);
        assert!(turned.distance(DVec3::new(1.0, 3.0, -2.0)) < 1e-12, "{turned}");
        assert_eq!(axes.apply([1.0, 2.0, 3.0]), [1.0, 3.0, -2.0]);
    }
}
