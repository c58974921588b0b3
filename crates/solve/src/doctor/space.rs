//! Examples that are in another space than the neutral: in another unit, with other axes, or mirrored.
use super::finding::Finding;
use super::impossible::error;
use super::words::length;
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use rhytid_core::numbers::median;
use rhytid_core::{Example, Face};
use rhytid_geometry::Axes;
use rhytid_geometry::registration::{Similarity, fit_robustly};

/// The number of vertices that are compared.
const COMPARED: usize = 300;

/// An example whose median vertex moves by less than this is in the neutral's space. Lengths here are parts
/// of the neutral's size.
const SAME: f64 = 0.01;

/// Vertices that are off by more than this count less in a fit.
const TOLERANCE: f64 = 0.01;

/// The median vertex of an example is at most so far off in the space that the example is in.
const FITS: f64 = 0.05;

/// In another space, the median vertex is off by at most this part of what it was.
const CLEARER: f64 = 0.5;

/// An example that is larger or smaller by less than this factor has the neutral's unit.
const LARGER: f64 = 1.04;

/// A turn within this angle of one that exchanges axes is taken for that one, as a cosine: 20°.
const NEAR_AXES: f64 = 0.94;

/// Units that people export meshes in, as the value of the key `unit`.
const UNITS: [(&str, &str, f64); 6] = [
    ("metres", "\"m\"", 1.0),
    ("decimetres", "0.1", 0.1),
    ("centimetres", "\"cm\"", 0.01),
    ("millimetres", "\"mm\"", 0.001),
    ("inches", "\"in\"", 0.0254),
    ("feet", "0.3048", 0.3048),
];

/// How much larger or smaller than its name says a unit may come out.
const UNIT_WITHIN: f64 = 0.025;

/// How to take an example to the neutral's space.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Space {
    /// What its coordinates are to be multiplied by.
    scale: f64,
    axes: Axes,
}

impl Space {
    const SAME: Self = Self { scale: 1.0, axes: Axes::SAME };
}

/// An example that is clearly in another space than the neutral.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExampleSpace {
    /// The number of the example in the face.
    pub example: usize,
    /// What is other, as a phrase without its subject.
    pub said: String,
    /// The keys of a project's `[[example]]` that take it to the neutral's space, such as `unit = "m"`.
    pub keys: Vec<String>,
}

pub(super) fn examples_in_another_space(face: &Face) -> Vec<Finding> {
    let finding = |ExampleSpace { example, said, keys }: ExampleSpace| {
        let (name, keys) = (&face.examples[example].name, keys.join(" and "));
        error(
            "example-in-another-space",
            format!(
                "example {name} {said}; export it from the same scene as the neutral, or write {keys} at its \
                 [[example]]"
            ),
        )
    };
    example_spaces(face).into_iter().map(finding).collect()
}

/// The examples that are clearly in another space than the neutral: in another unit, with other axes or
/// mirrored. Robust fits compare each with the neutral, vertex by vertex.
pub fn example_spaces(face: &Face) -> Vec<ExampleSpace> {
    let whole = |example: &Example| example.positions.len() == face.neutral.positions.len();
    let finite = |example: &Example| example.positions.iter().flatten().all(|x| x.is_finite());
    let examples = face.examples.par_iter().enumerate().filter(|(_, e)| whole(e) && finite(e));
    let mut found: Vec<(usize, Space)> =
        examples.map(|(i, example)| (i, space(face, example))).filter(|(_, s)| *s != Space::SAME).collect();
    // Scans of one scanner have one size, which several of them show better than one.
    let scales: Vec<f64> = found.iter().map(|(_, space)| space.scale).filter(|scale| *scale != 1.0).collect();
    if !scales.is_empty() {
        let typical = median(&mut scales.clone());
        let is_typical = |scale: f64| (scale / typical - 1.0).abs() < UNIT_WITHIN;
        found.iter_mut().filter(|(_, s)| is_typical(s.scale)).for_each(|(_, s)| s.scale = rounded(typical));
    }
    found.into_iter().map(|(example, space)| in_words(face, example, space)).collect()
}

fn in_words(face: &Face, example: usize, Space { scale, axes }: Space) -> ExampleSpace {
    let mut said = Vec::new();
    let mut keys = Vec::new();
    if scale != 1.0 {
        let metres = scale * face.metres_per_unit;
        let unit = UNITS.iter().find(|(_, _, unit)| (metres / unit - 1.0).abs() < UNIT_WITHIN);
        let exact = unit.map_or(scale, |(_, _, unit)| unit / face.metres_per_unit);
        let size = match exact > 1.0 {
            true => format!("is {} times smaller than the neutral", length(exact)),
            false => format!("is {} times larger than the neutral", length(1.0 / exact)),
        };
        match unit {
            Some((unit, value, _)) => {
                said.push(format!("{size}, as if it were in {unit}"));
                keys.push(format!("unit = {value}"));
            }
            None => {
                said.push(size);
                keys.push(format!("scale = {scale}"));
            }
        }
    }
    if axes.is_mirror_image() {
        said.push(
            "is a mirror image of the neutral, as if an axis were negated or left and right vertices were \
             exchanged"
                .to_owned(),
        );
    } else if axes != Axes::SAME {
        said.push("has other axes than the neutral".to_owned());
    }
    if axes != Axes::SAME {
        keys.push(format!("axes = \"{axes}\""));
    }
    ExampleSpace { example, said: said.join(" and "), keys }
}

/// The space that an example is in, as far as it is clear.
fn space(face: &Face, example: &Example) -> Space {
    let rest = &face.neutral.positions;
    let [low, high] = face.neutral.bounds().unwrap_or_default().map(DVec3::from_array);
    let size = high.distance(low);
    let step = rest.len().div_ceil(COMPARED).max(1);
    let sampled = |positions: &[[f64; 3]]| -> Vec<DVec3> {
        positions.iter().step_by(step).copied().map(DVec3::from_array).collect()
    };
    let (to, here) = (sampled(rest), sampled(&example.positions));
    let off = |by: &dyn Fn(DVec3) -> DVec3| {
        median(&mut here.iter().zip(&to).map(|(x, rest)| by(*x).distance(*rest)).collect::<Vec<_>>())
    };
    if off(&|x| x) <= SAME * size {
        return Space::SAME;
    }
    // Each with its error: the example in its own size, in any size, and mirrored in any size.
    let fitted = |mirrors: bool, with_scale: bool| {
        let mirrored = |x: DVec3| if mirrors { DVec3::new(-x.x, x.y, x.z) } else { x };
        let from: Vec<DVec3> = here.iter().map(|x| mirrored(*x)).collect();
        let (motion, _) = fit_robustly(&from, &to, with_scale, TOLERANCE * size)?;
        Some((off(&|x| motion.apply(mirrored(x))), motion))
    };
    let (Some(plain), Some(mirrored)) = (fitted(false, true), fitted(true, true)) else { return Space::SAME };
    let mirrors = mirrored.0 < CLEARER * plain.0;
    let (error, motion) = if mirrors { mirrored } else { plain };
    if error > FITS * size {
        return Space::SAME;
    }
    let is_of_its_size = |(of_its_size, _): (f64, Similarity)| error > CLEARER * of_its_size;
    let has_scale = !(1.0 / LARGER..LARGER).contains(&motion.scale)
        && !fitted(mirrors, false).is_some_and(is_of_its_size);
    let mirror = DMat3::from_diagonal(DVec3::new(if mirrors { -1.0 } else { 1.0 }, 1.0, 1.0));
    let turn = DMat3::from_quat(motion.rotation) * mirror;
    Space { scale: if has_scale { motion.scale } else { 1.0 }, axes: nearest_axes(turn) }
}

/// The axes that a turn exchanges, with or without a mirror. Those of the space itself where it is another
/// turn without a mirror, as of a head that moved between two scans.
fn nearest_axes(turn: DMat3) -> Axes {
    let axes = Axes::nearest(turn);
    let between = turn.transpose() * axes.matrix();
    let trace = between.x_axis.x + between.y_axis.y + between.z_axis.z;
    let is_near = 0.5 * (trace - 1.0) > NEAR_AXES;
    if is_near || axes.is_mirror_image() { axes } else { Axes::SAME }
}

/// A factor without what the fit cannot tell: with four digits.
fn rounded(scale: f64) -> f64 {
    let digits = 10_f64.powi(3 - scale.log10().floor() as i32);
    (scale * digits).round() / digits
}
