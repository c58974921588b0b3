//! Parallel projection of the face onto a picture.

use rhytid_core::UpAxis;

/// A direction to look from, and what of the world the picture shows.
pub(crate) struct Camera {
    /// The picture's right, its up, and towards the viewer, in the mesh's axes: lengths 1, at right angles.
    axes: [[f64; 3]; 3],
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Pixels in one mesh unit.
    pub scale: f64,
    /// What is in the picture's middle, along `axes`.
    middle: [f64; 2],
}

impl Camera {
    /// Looks at the face from its front, turned by `degrees` towards the mesh's +x, so that `points` fill a picture of `size`
    /// pixels but for a margin of a sixth.
    pub(crate) fn new(
        up: UpAxis,
        degrees: f64,
        size: [usize; 2],
        points: impl Iterator<Item = [f64; 3]>,
    ) -> Self {
        let (up, front) = match up {
            UpAxis::Y => ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
            UpAxis::Z => ([0.0, 0.0, 1.0], [0.0, -1.0, 0.0]),
        };
        let (sin, cos) = degrees.to_radians().sin_cos();
        let along = |right: f64, toward: f64| [right, toward * front[1], toward * front[2]];
        let axes = [along(cos, -sin), up, along(sin, cos)];
        let mut camera = Self { axes, size, scale: 1.0, middle: [0.0; 2] };
        let (mut least, mut greatest) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            let seen = [camera.along(0, point), camera.along(1, point)];
            least = [0, 1].map(|axis| seen[axis].min(least[axis]));
            greatest = [0, 1].map(|axis| seen[axis].max(greatest[axis]));
        }
        let extent = |axis: usize| greatest[axis] - least[axis];
        let scale = (0..2).map(|axis| size[axis] as f64 / (extent(axis) * 1.4)).fold(f64::INFINITY, f64::min);
        if scale.is_finite() && scale > 0.0 {
            camera.scale = scale;
            camera.middle = [0, 1].map(|axis| (least[axis] + greatest[axis]) / 2.0);
        }
        camera
    }

    fn along(&self, axis: usize, p: [f64; 3]) -> f64 {
        (0..3).map(|c| self.axes[axis][c] * p[c]).sum()
    }

    /// A direction of the world along right, up and towards the viewer.
    pub(crate) fn turn(&self, v: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.along(axis, v))
    }

    /// A point in pixels: right, down from the upper left corner, and towards the viewer.
    pub(crate) fn project(&self, p: [f64; 3]) -> [f64; 3] {
        let [right, up, toward] = self.turn(p);
        [
            self.size[0] as f64 / 2.0 + (right - self.middle[0]) * self.scale,
            self.size[1] as f64 / 2.0 - (up - self.middle[1]) * self.scale,
            toward * self.scale,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_face_looks_at_the_viewer_whichever_axis_is_up() {
        // Chin, brow, nose tip and the face's left (the mesh's +x), the same face in both axes.
        let y_up = [[0.0, -3.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 2.0], [2.5, 0.0, 0.0]];
        let z_up = y_up.map(|[x, y, z]| [x, -z, y]);
        for degrees in [0.0, 35.0] {
            let [a, b] = [(UpAxis::Y, y_up), (UpAxis::Z, z_up)].map(|(up, face)| {
                let camera = Camera::new(up, degrees, [300, 400], face.into_iter());
                face.map(|p| camera.project(p))
            });
            for (p, q) in a.iter().zip(&b) {
                assert!(p.iter().zip(q).all(|(x, y)| (x - y).abs() < 1e-9), "{a:?} {b:?}");
            }
            let [chin, brow, nose, left] = a;
            assert!(chin[1] > brow[1] && nose[2] > chin[2] && left[0] > chin[0]);
            assert!(a.iter().all(|p| p[0] >= 0.0 && p[0] <= 300.0 && p[1] >= 0.0 && p[1] <= 400.0));
            // Turned towards +x, the nose points to the picture's left.
            assert!(if degrees == 0.0 { nose[0] == chin[0] } else { nose[0] < chin[0] });
        }
    }
}
