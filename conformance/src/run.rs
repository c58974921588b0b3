use crate::case::Case;
use crate::reference::{self, Reference};
use rhytid_core::{Animator, Result, Rig, Session, Stage};

/// How one stage of one case went.
#[derive(Debug, Clone, PartialEq)]
pub struct StageResult {
    /// The stage.
    pub stage: Stage,
    /// The largest difference from the reference, as a part of what is allowed there: at most 1 passes. Infinite
    /// where the stage has another length than it should, NaN where another stage has and nothing was compared.
    pub worst: f64,
    /// The index at which that is.
    pub index: usize,
}

impl StageResult {
    /// Whether every number was within its bound.
    pub fn passed(&self) -> bool {
        self.worst <= 1.0
    }
}

/// Evaluates `case` and compares every stage with what its kernel should have made of the device's own inputs to
/// it. `animator` holds the case's rig.
///
/// # Errors
/// What the session fails with.
pub fn run<S: Session>(animator: &mut Animator<S>, case: &Case) -> Result<Vec<StageResult>> {
    animator.evaluate(&case.handle_positions)?;
    let mut read = |stage| -> Result<Vec<f32>> {
        let mut out = Vec::new();
        animator.read(stage, &mut out)?;
        Ok(out)
    };
    let found = [
        read(Stage::Strain)?,
        read(Stage::LargeScale)?,
        read(Stage::LargeScaleNormals)?,
        read(Stage::Detail)?,
        read(Stage::Positions)?,
        read(Stage::Normals)?,
    ];
    let [strain, large_scale, large_scale_normals, detail, positions, _] = &found;
    let rig: Rig<f64> = case.rig.cast();
    let handles = vectors(&case.handle_positions);
    let frames = handles.len() / rig.handles.len();
    let whole = |stage: Stage, found: &[f32]| found.len() == frames * stage.values_per_frame(&rig);
    if Stage::ALL.iter().zip(&found).any(|(&stage, found)| !whole(stage, found)) {
        let worst = |stage, found| if whole(stage, found) { f64::NAN } else { f64::INFINITY };
        let results = Stage::ALL.iter().zip(&found);
        return Ok(results
            .map(|(&stage, f)| StageResult { stage, worst: worst(stage, f), index: 0 })
            .collect());
    }
    let strain: Vec<f64> = strain.iter().map(|&x| f64::from(x)).collect();
    let references = [
        reference::strain(&rig, &handles),
        reference::large_scale(&rig, &handles),
        reference::normals(&rig, &vectors(large_scale)),
        reference::detail(&rig, &strain, frames),
        reference::positions(&rig, &vectors(large_scale), &vectors(large_scale_normals), &vectors(detail)),
        reference::normals(&rig, &vectors(positions)),
    ];
    let results = Stage::ALL.iter().zip(&found).zip(&references);
    Ok(results.map(|((&stage, found), reference)| compare(stage, found, reference)).collect())
}

fn vectors(numbers: &[f32]) -> Vec<[f64; 3]> {
    numbers.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect()
}

fn compare(stage: Stage, found: &[f32], reference: &Reference) -> StageResult {
    let mut result = StageResult { stage, worst: 0.0, index: 0 };
    for (index, (&found, (value, bound))) in
        found.iter().zip(reference.values.iter().zip(&reference.bounds)).enumerate()
    {
        let part = (f64::from(found) - value).abs() / bound;
        let part = if part.is_nan() { f64::INFINITY } else { part };
        if part > result.worst {
            result.worst = part;
            result.index = index;
        }
    }
    result
}
