//! Coverage by the chapter's method: what a take does that no example shows, by strains, and which of its
//! frames to scan next. `docs/coverage.md` says how to read it.
use rhytid_core::{Error, HandleId, Result, Rig, Take};
use serde::Serialize;

/// A frame is covered where its relative distance is at most this. A frame in the middle between two
/// neighbouring examples has this distance.
pub const COVERED: f64 = 0.5;

/// An edge is beyond every example where it exceeds them by more than this, in millimetres. The noise of
/// markers can reach this size.
pub const NOISE_MM: f64 = 0.5;

/// A marker whose confidence is at most this is a guess. Its motion does not count as an expression.
const GUESS: f32 = 0.5;

/// Strain edges that are named for an expression.
const NAMED: usize = 3;

/// A take compared with the centres of a rig: its examples and the rest pose.
///
/// The distance of two sets of strains is the root mean square of their differences over all F strain edges.
/// The difference of an edge with a guessed marker counts as 0.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coverage {
    /// Frames of the take.
    pub frames: usize,
    /// Frames that are covered. Without a spacing, those that are at a centre.
    pub covered: usize,
    /// The median over all centres of the distance to the nearest other centre, as a strain. `None` where no
    /// median above 0 exists.
    pub spacing: Option<f64>,
    /// For each frame the distance to the nearest centre, as a strain.
    pub distances: Vec<f64>,
    /// The frames that are worth a scan, the farthest first. Each frame counts as an example when the next
    /// one is chosen.
    pub expressions: Vec<Expression>,
    /// How many strain edges go beyond every centre in some frame.
    pub edges_beyond: usize,
    /// The edges that go farthest beyond, as strain.
    pub edges: Vec<Edge>,
}

/// A frame to scan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Expression {
    /// Counted from 0.
    pub frame: usize,
    /// In seconds.
    pub time: f64,
    /// Distance to the nearest centre or earlier expression, as a strain.
    pub distance: f64,
    /// The distance in spacings.
    pub relative: Option<f64>,
    /// The name of the nearest one: an example's, `rest`, or `expression 1` and so on.
    pub nearest: String,
    /// Frames that are covered once this expression and those before it are examples.
    pub covered: usize,
    /// The edges that differ most from the nearest one, the largest difference of strain first.
    pub edges: Vec<Difference>,
}

/// An edge of an expression.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// The labels of its two handles.
    pub handles: [String; 2],
    /// Its strain in the expression.
    pub strain: f64,
    /// Its strain minus the strain in the nearest centre or expression.
    pub difference: f64,
    /// The difference in millimetres.
    pub difference_mm: f64,
}

/// A strain edge that is longer or shorter in the take than in any centre, by more than [`NOISE_MM`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Edge {
    /// The labels of its two handles.
    pub handles: [String; 2],
    /// How far its strain goes beyond that of every centre. Above 0: longer than in any centre. Below 0:
    /// shorter than in any.
    pub beyond: f64,
    /// The same in millimetres.
    pub beyond_mm: f64,
    /// The smallest and the largest strain of the centres.
    pub examples: [f64; 2],
    /// The frame that goes farthest, counted from 0.
    pub frame: usize,
    /// Its time in seconds.
    pub time: f64,
    /// Frames that go beyond by more than [`NOISE_MM`].
    pub frames_beyond: usize,
}

/// Compares `take` with `rig`, and lists at most `top` expressions and edges.
///
/// # Errors
/// [`Error::Input`] if the take lacks handles of the rig, or the rig has no strain edges.
pub fn coverage(rig: &Rig<f64>, take: &Take, top: usize) -> Result<Coverage> {
    let edges = rig.handles().strain_edges.len();
    if edges == 0 {
        return Err(Error::rig_lacks(
            "the rig has no strain edges, so its examples cannot be compared with the take",
        ));
    }
    let strains = strains(rig, take)?;
    let shapes: Vec<&[f64]> = strains.chunks_exact(edges).collect();
    let to_mm: Vec<f64> =
        rig.handles().rest_lengths().iter().map(|l| l * rig.surface().metres_per_unit * 1e3).collect();
    let centers: Vec<&[f64]> = rig.fine_scale().pose_features.rows().collect();
    let spacing = spacing(&centers);

    // For each frame: the distance to the nearest centre and the index of that centre.
    let mut nearest = vec![(f64::INFINITY, 0); take.frames()];
    for (j, center) in centers.iter().enumerate() {
        approach(&mut nearest, &strains, center, j);
    }
    let covered_of = |nearest: &[(f64, usize)]| {
        nearest.iter().filter(|(distance, _)| is_covered(*distance, spacing)).count()
    };
    let covered = covered_of(&nearest);
    let distances = nearest.iter().map(|(distance, _)| *distance).collect();

    let mut known = centers;
    let mut expressions = Vec::new();
    while expressions.len() < top {
        let Some((frame, (distance, j))) = farthest(&nearest) else { break };
        if is_covered(distance, spacing) {
            break;
        }
        let shape = shapes[frame];
        approach(&mut nearest, &strains, shape, known.len());
        expressions.push(Expression {
            frame,
            time: take.times[frame],
            distance,
            relative: spacing.map(|spacing| distance / spacing),
            nearest: name(rig, j),
            covered: covered_of(&nearest),
            edges: differences(rig, shape, known[j], &to_mm),
        });
        known.push(shape);
    }
    let mut beyond = beyond_of(rig, take, &strains, &to_mm);
    let edges_beyond = beyond.len();
    beyond.truncate(top);
    Ok(Coverage {
        frames: take.frames(),
        covered,
        spacing,
        distances,
        expressions,
        edges_beyond,
        edges: beyond,
    })
}

/// frames × F strains, from the positions that the runtime gets; NaN where a marker of the edge is a guess.
fn strains(rig: &Rig<f64>, take: &Take) -> Result<Vec<f64>> {
    let positions = take.handle_positions(&rig.handles().labels)?;
    let positions: Vec<[f64; 3]> = positions.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect();
    let mut strains = rig.handles().strains(&positions);
    if let Some(confidence) = &take.confidence {
        let marker = |label: &String| take.labels.iter().position(|known| known == label);
        let markers: Vec<usize> = rig.handles().labels.iter().filter_map(marker).collect();
        let frames = strains.chunks_exact_mut(rig.handles().strain_edges.len());
        for (strains, confidence) in frames.zip(confidence.chunks_exact(take.labels.len())) {
            let is_guess = |handle: HandleId| confidence[markers[handle.index()]] <= GUESS;
            for (strain, [a, b]) in strains.iter_mut().zip(&rig.handles().strain_edges) {
                if is_guess(*a) || is_guess(*b) {
                    *strain = f64::NAN;
                }
            }
        }
    }
    Ok(strains)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).filter(|square| !square.is_nan());
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

/// The median over the centres of the distance to the nearest other one.
fn spacing(centers: &[&[f64]]) -> Option<f64> {
    let to_nearest = |i: usize| {
        let others = (0..centers.len()).filter(|&j| j != i).map(|j| distance(centers[i], centers[j]));
        others.fold(f64::INFINITY, f64::min)
    };
    let mut nearest: Vec<f64> = (0..centers.len()).map(to_nearest).collect();
    nearest.sort_by(f64::total_cmp);
    let n = nearest.len();
    let median = (nearest.get(n / 2)? + nearest.get(n.saturating_sub(1) / 2)?) / 2.0;
    (median > 0.0 && median.is_finite()).then_some(median)
}

fn is_covered(distance: f64, spacing: Option<f64>) -> bool {
    distance <= COVERED * spacing.unwrap_or(0.0)
}

/// Makes `center`, the `j`-th, the nearest one of each frame that is nearer to it than to all centres before.
fn approach(nearest: &mut [(f64, usize)], strains: &[f64], center: &[f64], j: usize) {
    for (nearest, frame) in nearest.iter_mut().zip(strains.chunks_exact(center.len())) {
        let distance = distance(frame, center);
        if distance < nearest.0 {
            *nearest = (distance, j);
        }
    }
}

/// The frame that is farthest from its nearest centre; the first of equals.
fn farthest(nearest: &[(f64, usize)]) -> Option<(usize, (f64, usize))> {
    nearest.iter().copied().enumerate().reduce(|best, next| if next.1.0 > best.1.0 { next } else { best })
}

fn name(rig: &Rig<f64>, center: usize) -> String {
    match center.checked_sub(1) {
        None => "rest".into(),
        Some(example) => match rig.examples().names.get(example) {
            Some(name) => name.clone(),
            None => format!("expression {}", center - rig.examples().names.len()),
        },
    }
}

fn handles(rig: &Rig<f64>, edge: usize) -> [String; 2] {
    rig.handles().strain_edges[edge].map(|h| rig.handles().labels[h.index()].clone())
}

fn differences(rig: &Rig<f64>, shape: &[f64], nearest: &[f64], to_mm: &[f64]) -> Vec<Difference> {
    let differences = shape.iter().zip(nearest).map(|(a, b)| a - b).enumerate();
    let mut differences: Vec<(usize, f64)> = differences.filter(|(_, d)| d.abs() > 0.0).collect();
    // Stable: equals stay in the order of the edges.
    differences.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    differences.truncate(NAMED);
    let named = |(edge, difference): (usize, f64)| Difference {
        handles: handles(rig, edge),
        strain: shape[edge],
        difference,
        difference_mm: difference * to_mm[edge],
    };
    differences.into_iter().map(named).collect()
}

/// All strain edges that go beyond every example of the rig in some frame of the take, the farthest first.
///
/// # Errors
/// [`Error::Input`] if the take lacks handles of the rig.
pub fn edges_beyond(rig: &Rig<f64>, take: &Take) -> Result<Vec<Edge>> {
    let to_mm: Vec<f64> =
        rig.handles().rest_lengths().iter().map(|l| l * rig.surface().metres_per_unit * 1e3).collect();
    Ok(match rig.handles().strain_edges.is_empty() {
        true => Vec::new(),
        false => beyond_of(rig, take, &strains(rig, take)?, &to_mm),
    })
}

/// The strain edges with the largest strains against rest, where the handles are at these H positions.
pub fn largest_strains(rig: &Rig<f64>, handle_positions: &[[f64; 3]]) -> Vec<Difference> {
    let to_mm: Vec<f64> =
        rig.handles().rest_lengths().iter().map(|l| l * rig.surface().metres_per_unit * 1e3).collect();
    let strains = rig.handles().strains(handle_positions);
    differences(rig, &strains, &vec![0.0; strains.len()], &to_mm)
}

fn beyond_of(rig: &Rig<f64>, take: &Take, strains: &[f64], to_mm: &[f64]) -> Vec<Edge> {
    let edges = rig.handles().strain_edges.len();
    let of_edge = |edge: usize| {
        let centers = || rig.fine_scale().pose_features.rows().map(|center| center[edge]);
        let (low, high) =
            (centers().fold(f64::INFINITY, f64::min), centers().fold(f64::NEG_INFINITY, f64::max));
        let (mut beyond, mut at, mut frames_beyond) = (0.0_f64, 0, 0);
        for (frame, &strain) in strains.iter().skip(edge).step_by(edges).enumerate() {
            // A strain of NaN is beyond nothing.
            let over = if strain > high {
                strain - high
            } else if strain < low {
                strain - low
            } else {
                0.0
            };
            frames_beyond += usize::from(over.abs() * to_mm[edge] > NOISE_MM);
            if over.abs() > beyond.abs() {
                (beyond, at) = (over, frame);
            }
        }
        (frames_beyond > 0).then(|| Edge {
            handles: handles(rig, edge),
            beyond,
            beyond_mm: beyond * to_mm[edge],
            examples: [low, high],
            frame: at,
            time: take.times[at],
            frames_beyond,
        })
    };
    let mut all: Vec<Edge> = (0..edges).filter_map(of_edge).collect();
    all.sort_by(|a, b| b.beyond.abs().total_cmp(&a.beyond.abs()));
    all
}
