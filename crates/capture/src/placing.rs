//! The actor's place: the neutral frames, the unit, the axes, the size, and the markers' distances from their
//! handles.
use crate::neutral::{Neutral, Rival};
use crate::settings::{Settings, Step};
use crate::tracks::{Tracks, extent, seen};
use crate::{Axes, Target, neutral};
use glam::{DMat3, DVec3};
use rhytid_core::{Error, LengthUnit, Remedy, Result, Warning};
use rhytid_geometry::registration::Similarity;
use rhytid_geometry::registration::fit_robustly;
use std::ops::Range;

/// What the file says about its space.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stated {
    /// Metres in one unit, if the file says it.
    pub metres_per_unit: Option<f64>,
    /// Whether the markers are already on the rig.
    pub in_head_space: bool,
    /// Whether the take is from a video.
    pub is_video: bool,
}

/// A unit of length.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unit {
    /// Its length in metres.
    pub metres: f64,
    /// Whether that is a guess.
    pub is_guessed: bool,
}

impl Unit {
    /// A unit that is no guess.
    fn known(metres: f64) -> Self {
        Self { metres, is_guessed: false }
    }
}

/// How the file's space becomes the rig's, once the head's motion is taken out.
pub(crate) struct Place {
    /// The neutral frames.
    pub neutral: Range<usize>,
    /// Frames that may be neutral instead of them.
    pub rival: Option<Rival>,
    /// From the file's space to the rig's.
    pub to_rig: Similarity,
    /// The file's unit and axes to the mesh's.
    pub to_world: Similarity,
    /// The file's unit.
    pub unit: Unit,
    /// The file's axes.
    pub axes: Axes,
    /// H markers at neutral, on the rig. The handle's own position stands in where the marker was not seen,
    /// and for a take that is already on the rig.
    pub markers: Vec<DVec3>,
    /// Whether the file's markers are already on the rig.
    pub in_head_space: bool,
}

/// A marker may be off by this part of the face's extent before the alignment gives it less weight. Markers
/// are glued on by hand.
const TOLERANCE: f64 = 0.03;

impl Place {
    /// Finds what the settings do not give. `columns` are the handles'. `head` holds the head's motions, if
    /// they were taken out. `stated` is what the file says about its space.
    ///
    /// # Errors
    /// [`Error::Input`] if the settings' neutral frames are not in the take or show too little, or if none
    /// can be found.
    pub(crate) fn find(
        tracks: &Tracks,
        columns: &[Option<usize>],
        head: Option<&[Similarity]>,
        stated: Stated,
        target: &Target,
        settings: &Settings,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self> {
        let Neutral { frames: neutral, rival, is_doubtful } =
            neutral_frames(tracks, columns, target, settings)?;
        let pose = neutral::pose(tracks, columns, &neutral);
        let mesh = target.metres_per_unit;
        let (to_rig, to_world, unit, axes);
        if stated.in_head_space {
            (unit, axes) = (Unit::known(mesh), settings.axes.unwrap_or(Axes::SAME));
            (to_rig, to_world) = (Similarity::IDENTITY, Similarity::IDENTITY);
        } else if settings.skip.contains(&Step::Align) {
            // Without an alignment, the unit and the axes still apply.
            unit = Unit::known(settings.metres_per_unit.or(stated.metres_per_unit).unwrap_or(mesh));
            axes = settings.axes.unwrap_or(Axes::SAME);
            to_world = world(unit.metres / mesh, axes);
            to_rig = to_world;
        } else {
            warnings.extend(too_short(tracks));
            warnings.extend(unsure(&neutral, rival.as_ref(), is_doubtful));
            let tolerance = TOLERANCE * extent(target.rest.iter().copied());
            let (fitted, _) = fit_robustly(&pose, &target.rest, true, tolerance).ok_or_else(|| {
                Error::no_fit(
                    "the neutral frames show fewer than three markers, or markers on one line; say which frames are neutral",
                )
            })?;
            let turned = head.map_or(Similarity::IDENTITY, |head| head[(neutral.start + neutral.end) / 2]);
            unit = self::unit(stated, settings, mesh, &fitted, warnings);
            axes = settings.axes.unwrap_or_else(|| {
                Axes::nearest(DMat3::from_quat(fitted.rotation * turned.rotation.conjugate()))
            });
            (to_rig, to_world) = (fitted, world(unit.metres / mesh, axes));
        }
        let on_rig =
            |(p, r): (&DVec3, &DVec3)| if seen(*p) && !stated.in_head_space { to_rig.apply(*p) } else { *r };
        let markers = pose.iter().zip(&target.rest).map(on_rig).collect();
        Ok(Self {
            neutral,
            rival,
            to_rig,
            to_world,
            unit,
            axes,
            markers,
            in_head_space: stated.in_head_space,
        })
    }

    /// How large the actor is compared with the rig.
    pub(crate) fn scale(&self) -> f64 {
        self.to_world.scale / self.to_rig.scale
    }

    /// The frame in the middle of the neutral ones.
    pub(crate) fn neutral_frame(&self) -> usize {
        (self.neutral.start + self.neutral.end) / 2
    }
}

fn world(scale: f64, axes: Axes) -> Similarity {
    Similarity { scale, rotation: axes.rotation(), translation: DVec3::ZERO }
}

fn neutral_frames(
    tracks: &Tracks,
    columns: &[Option<usize>],
    target: &Target,
    settings: &Settings,
) -> Result<Neutral> {
    let frames = tracks.frames();
    match &settings.neutral {
        Some(range) if range.start < range.end && range.end <= frames => {
            Ok(Neutral { frames: range.clone(), rival: None, is_doubtful: false })
        }
        Some(range) => Err(Error::out_of_range(format!(
            "the neutral frames are {}..{}, expected a range within 0..{frames}",
            range.start, range.end
        ))),
        None => neutral::find(tracks, columns, target).ok_or_else(|| {
            Error::no_fit(
                "no half second of the take shows enough markers to find the neutral face; say which frames \
                 are neutral",
            )
        }),
    }
}

/// A warning where the take is too short for an average to be free of noise.
fn too_short(tracks: &Tracks) -> Option<Warning> {
    if tracks.frames() >= tracks.frames_in(neutral::LENGTH) {
        return None;
    }
    let frames = tracks.frames();
    let plural = if frames == 1 { "" } else { "s" };
    let seconds = frames as f64 / tracks.rate;
    Some(Warning::from(format!(
        "the take has {frames} frame{plural}, {seconds:.3} s, and half a second is needed to tell noise from \
         motion and a held expression from the neutral face; all markers may be some tenths of a millimetre \
         off; clean a longer take that holds the neutral face for half a second"
    )))
}

/// A warning where the take does not tell which frames are neutral.
fn unsure(neutral: &Range<usize>, rival: Option<&Rival>, is_doubtful: bool) -> Option<Warning> {
    let Range { start, end } = neutral;
    let sentence = match rival {
        _ if is_doubtful => format!(
            "no half second of the take is surely the neutral face: the one most like it, frames \
             {start}..{end}, moves or shows an expression, which would be taken out of all frames; say which \
             frames are neutral, or clean a take in which the actor holds the neutral face for half a second"
        ),
        Some(Rival { frames, apart_mm }) => format!(
            "frames {start}..{end} are taken for the neutral face, but frames {}..{} may be it as well; their \
             markers are {apart_mm:.1} mm apart; look at both, and say which frames are neutral",
            frames.start, frames.end
        ),
        None => return None,
    };
    Some(Warning::from(sentence).with_remedies(&[Remedy::GiveNeutral]))
}

/// The file's unit: the stated one, else the one that suits. `fitted` takes the file's space to the mesh's,
/// whose unit is `mesh` metres.
fn unit(
    stated: Stated,
    settings: &Settings,
    mesh: f64,
    fitted: &Similarity,
    warnings: &mut Vec<Warning>,
) -> Unit {
    if let Some(given) = settings.metres_per_unit {
        return Unit::known(given);
    }
    let scale = |unit: f64| unit / (mesh * fitted.scale);
    if stated.is_video && stated.metres_per_unit.is_none() {
        // A video tells no size, so the actor has the rig's.
        return Unit { metres: mesh * fitted.scale, is_guessed: true };
    }
    if let Some(stated) = stated.metres_per_unit {
        if (0.4..2.5).contains(&scale(stated)) {
            return Unit::known(stated);
        }
        warnings.push(
            format!(
                "the file says that its unit is {stated} m, which makes the actor {:.3} times the rig's size",
                scale(stated)
            )
            .into(),
        );
    }
    let unlike = |unit: &LengthUnit| scale(unit.metres).ln().abs();
    let all = LengthUnit::ALL;
    let LengthUnit { name, metres } =
        all.into_iter().min_by(|a, b| unlike(a).total_cmp(&unlike(b))).unwrap_or(all[0]);
    warnings.push(
        format!(
            "the unit is assumed to be {name}, which makes the actor {:.3} times the rig's size",
            scale(metres)
        )
        .into(),
    );
    Unit { metres, is_guessed: true }
}

/// Distance of each handle's marker from its handle, in millimetres; `None` where it was not seen at neutral.
/// Warns where the marker seems to have the wrong label.
pub(crate) fn offsets(
    pose: &[DVec3],
    rest: &[DVec3],
    millimetres: f64,
    labels: &[String],
    warnings: &mut Vec<Warning>,
) -> Vec<Option<f64>> {
    /// As a part of the face's extent.
    const LARGEST: f64 = 0.08;
    let largest = LARGEST * extent(rest.iter().copied()) * millimetres;
    let mut offsets = Vec::with_capacity(rest.len());
    for ((p, r), label) in pose.iter().zip(rest).zip(labels) {
        let offset = seen(*p).then(|| p.distance(*r) * millimetres);
        if let Some(offset) = offset.filter(|offset| *offset > largest) {
            warnings.push(
                format!(
                    "at neutral the marker of {label} is {offset:.1} mm from its handle: check that it is \
                     the right marker"
                )
                .into(),
            );
        }
        offsets.push(offset);
    }
    offsets
}
