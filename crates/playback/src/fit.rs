//! What is wrong with a take that fits a rig only in part: its times, its space, its strains, its noise.

use rhytid_capture::{
    Event, Misfit, TakeSpace, Target, gross_strain, gross_strain_events, marker_noise, misfit,
};
use rhytid_core::{Error, Remedy, Result, Rig, Take, Warning, human};

/// Markers with less noise than this, in millimetres, are as good as most, whatever the rig was solved for.
const NOISY: f64 = 0.15;

/// Markers are much noisier than the rig was solved for from this ratio on.
const MUCH_NOISIER: f64 = 2.0;

/// Fewer steps between frames do not show the unit of times.
const FEW_STEPS: usize = 10;

/// What is likely wrong with a clean take.
pub(crate) struct Fit {
    pub warnings: Vec<Warning>,
    /// Strains that no skin has. None where the take as a whole does not fit.
    pub strains: Vec<Event>,
}

/// Examines a clean take for `rig`. `given` is the space that the user says the take was in.
/// The take is in the rig's space by then.
///
/// # Errors
/// [`Error::Input`] if the take is recognisably in another space, and no space was given.
pub(crate) fn examine(take: &Take, rig: &Rig, given: Option<TakeSpace>) -> Result<Fit> {
    let mut warnings: Vec<Warning> = times(take).into_iter().collect();
    let mut strains = Vec::new();
    match misfit(take, &Target::from_rig(rig)) {
        None => {
            warnings.extend(gross_strain(take, rig).map(|strain| strain.warning(take)));
            strains.extend(gross_strain_events(take, rig).into_iter().flatten());
        }
        Some(misfit @ Misfit::Space(_)) if given.is_none() => {
            return Err(Error::mismatch(misfit.to_string()).with_remedies(&[Remedy::GiveTakeSpace]));
        }
        Some(misfit @ Misfit::Space(_)) => {
            warnings.push(Warning::from(misfit.to_string()).with_remedies(&[Remedy::GiveTakeSpace]));
        }
        Some(misfit @ Misfit::HeadMotion(_)) => {
            let warning = Warning::from(format!("{misfit}; take the head's motion out first"));
            warnings.push(warning.with_remedies(&[Remedy::CleanAsWorld]));
        }
        Some(misfit) => warnings.push(Warning::from(format!(
            "{misfit}; check that rig and take belong together, and that labels name the same places"
        ))),
    }
    Ok(Fit { warnings, strains })
}

/// A warning about markers that are much noisier than the rig was solved for.
pub(crate) fn noise(take: &Take, rig: &Rig) -> Option<Warning> {
    let millimetres = 1e3 * rig.surface().metres_per_unit;
    let noise = millimetres * marker_noise(take);
    let known = rig.learned().map_or(0.0, |learned| millimetres * learned.marker_noise);
    (noise > NOISY && noise > MUCH_NOISIER * known).then(|| {
        let noise = human::number((noise * 100.0).round() / 100.0);
        let sentence = format!(
            "its markers have {noise} mm of noise per axis, which the skin between them would follow; soft \
             markers take it out"
        );
        Warning::from(sentence).with_remedies(&[Remedy::SoftMarkers])
    })
}

/// A warning about times that look like numbers of frames or like milliseconds.
fn times(take: &Take) -> Option<Warning> {
    let steps: Vec<f64> = take.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.len() < FEW_STEPS {
        return None;
    }
    let whole = take.times.iter().all(|time| time.fract() == 0.0);
    let between = |range: std::ops::Range<f64>| {
        steps.iter().filter(|step| range.contains(step)).count() * 10 > steps.len() * 9
    };
    let what = match () {
        () if whole && between(0.999..1.001) => "numbers of frames",
        () if between(3.9..101.0) => "milliseconds",
        () => return None,
    };
    let warning = Warning::from(format!("its times look like {what}, expected seconds; give the frame rate"));
    Some(warning.with_remedies(&[Remedy::GiveRate]))
}
