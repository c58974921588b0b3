//! The mesh's topology: a grid of quads over the domain, cut open along the eyes' and the mouth's lines.
use crate::shape::{BOTTOM, EYE_CUT, EYE_LINE, HALF_WIDTH, MOUTH_CUT, MOUTH_LINE, Site, TOP};
use rhytid_core::{Faces, Uvs};

/// Columns must fall on these, so that the cuts end at vertices.
const COLUMN_STOPS: [f64; 5] = [0.0, EYE_CUT[0], MOUTH_CUT, EYE_CUT[1], HALF_WIDTH];
/// Rows must fall on these.
const ROW_STOPS: [f64; 4] = [BOTTOM, MOUTH_LINE, EYE_LINE, TOP];

/// Samples of the domain and how they are joined.
#[derive(Debug)]
pub(crate) struct Grid {
    /// The distances from the midline of the columns, from the right temple to the left: odd in number.
    columns: Vec<f64>,
    /// `up` of the rows, from the neck to the hairline.
    rows: Vec<f64>,
    /// One per vertex: first the grid row by row, then the lower sides of the cuts.
    pub sites: Vec<Site>,
    /// Quads, counter-clockwise from the front.
    pub faces: Faces,
}

impl Grid {
    /// A grid of about square cells, with a number of vertices as near to `vertices` as possible.
    pub(crate) fn new(vertices: usize) -> Self {
        let (half_columns, row_cells) = cells(vertices);
        let half = stops(&COLUMN_STOPS, half_columns, column_size);
        let columns: Vec<f64> = half[1..].iter().rev().map(|a| -a).chain(half.iter().copied()).collect();
        let rows = stops(&ROW_STOPS, row_cells, row_size);
        let mut grid = Self { columns, rows, sites: Vec::new(), faces: Faces::default() };
        grid.fill();
        grid
    }

    fn fill(&mut self) {
        let (width, height) = (self.columns.len(), self.rows.len());
        for &up in &self.rows {
            for &across in &self.columns {
                let (above_eyes, above_mouth) = (up >= EYE_LINE, up >= MOUTH_LINE);
                self.sites.push(Site { across, up, above_eyes, above_mouth });
            }
        }
        // The vertex that the cell below a row uses: a copy of its own on a cut, otherwise the grid's.
        let mut below: Vec<u32> = (0..self.sites.len() as u32).collect();
        for vertex in &mut below {
            let site = self.sites[*vertex as usize];
            let side = site.across.abs();
            let eye = site.up == EYE_LINE && side > EYE_CUT[0] && side < EYE_CUT[1];
            let mouth = site.up == MOUTH_LINE && side < MOUTH_CUT;
            if eye || mouth {
                *vertex = self.sites.len() as u32;
                let (above_eyes, above_mouth) = (site.above_eyes && !eye, site.above_mouth && !mouth);
                self.sites.push(Site { above_eyes, above_mouth, ..site });
            }
        }
        for row in 0..height - 1 {
            for column in 0..width - 1 {
                let lower = row * width + column;
                let upper = lower + width;
                self.faces.push(&[lower as u32, lower as u32 + 1, below[upper + 1], below[upper]]);
            }
        }
    }

    /// Texture coordinates: the domain itself, scaled into the unit square without distortion.
    pub(crate) fn uvs(&self) -> Uvs {
        let size = (TOP - BOTTOM).max(2.0 * HALF_WIDTH);
        let values = self
            .sites
            .iter()
            .map(|s| [(0.5 + s.across / size) as f32, ((s.up - BOTTOM) / size) as f32])
            .collect();
        Uvs { values, corners: None }
    }

    /// The vertex nearest to a point of the domain that is not on a cut. Opposite points give opposite
    /// vertices.
    pub(crate) fn nearest(&self, across: f64, up: f64) -> usize {
        let middle = self.columns.len() / 2;
        let step = nearest(&self.columns[middle..], across.abs());
        let column = if across < 0.0 { middle - step } else { middle + step };
        nearest(&self.rows, up) * self.columns.len() + column
    }

    /// The largest distance of neighbouring columns or rows about the middle of the face.
    pub(crate) fn spacing(&self) -> f64 {
        let middle = self.columns.len() / 2;
        self.columns[middle + 1] - self.columns[middle]
    }
}

/// The index of the number closest to `x` in increasing `numbers`.
fn nearest(numbers: &[f64], x: f64) -> usize {
    let after = numbers.partition_point(|&n| n < x).clamp(1, numbers.len() - 1);
    if x - numbers[after - 1] < numbers[after] - x { after - 1 } else { after }
}

/// Relative width of the columns: wider where the face turns to the side.
fn column_size(across: f64) -> f64 {
    1.0 + 0.6 * (across / HALF_WIDTH).powi(2)
}

/// Relative height of the rows: lower at lids, lips and below the nose.
fn row_size(up: f64) -> f64 {
    let dense = |centre: f64, width: f64| (-((up - centre) / width).powi(2)).exp();
    1.15 - 0.5 * dense(EYE_LINE, 1.2) - 0.5 * dense(-4.3, 0.7) - 0.5 * dense(MOUTH_LINE, 1.0)
}

/// Cells between `stops`: their number from one end to the other if `size` were 1 cell.
fn measure(from: f64, to: f64, size: fn(f64) -> f64) -> f64 {
    const STEPS: usize = 200;
    let step = (to - from) / STEPS as f64;
    (0..STEPS).map(|i| step / size(from + (i as f64 + 0.5) * step)).sum()
}

/// `cells + 1` numbers from the first stop to the last, spaced by `size`, that meet every stop exactly.
fn stops(stops: &[f64], cells: usize, size: fn(f64) -> f64) -> Vec<f64> {
    let total = measure(stops[0], stops[stops.len() - 1], size);
    let mut out = vec![stops[0]];
    for pair in stops.windows(2) {
        let done = measure(stops[0], pair[1], size) / total * cells as f64;
        let count = (done.round() as usize + 1).saturating_sub(out.len()).max(1);
        let length = measure(pair[0], pair[1], size);
        let mut at = pair[0];
        for i in 1..count {
            // A few steps along the density: exact enough for a spacing, and the stops are met anyway.
            let target = length * i as f64 / count as f64;
            let mut travelled = measure(pair[0], at, size);
            for _ in 0..4 {
                at += (target - travelled) * size(at);
                travelled = measure(pair[0], at, size);
            }
            out.push(at);
        }
        out.push(pair[1]);
    }
    out
}

/// The numbers of columns per half and of rows, in cells, that come closest to `vertices` vertices.
fn cells(vertices: usize) -> (usize, usize) {
    let across = measure(0.0, HALF_WIDTH, column_size);
    let up = measure(BOTTOM, TOP, row_size);
    let ideal = (vertices as f64 / (2.0 * across * up)).sqrt();
    let mut best = (0, 0, f64::INFINITY);
    let around = (ideal * across).round() as usize;
    for half in around.saturating_sub(3).max(8)..=around + 3 {
        let columns = stops(&COLUMN_STOPS, half, column_size);
        let within = |from: f64, to: f64| columns.iter().filter(|&&c| c > from && c < to).count();
        let extra = 2 * within(EYE_CUT[0], EYE_CUT[1]) + 2 * within(0.0, MOUTH_CUT) + 1;
        let width = 2 * columns.len() - 1;
        let rows = (vertices.saturating_sub(extra) as f64 / width as f64).round().max(12.0) as usize;
        let error = (rows * width + extra).abs_diff(vertices) as f64;
        if error < best.2 {
            best = (half, rows - 1, error);
        }
    }
    (best.0, best.1)
}
