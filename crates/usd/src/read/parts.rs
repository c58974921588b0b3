//! An animation in parts, one file each, which [`crate::stitch()`] joins.

use super::animation::Animation;
use super::clips::clips;
use super::open::open;
use rhytid_core::channel::Channel;
use rhytid_core::{Error, Remedy, Result};
use rhytid_export::{AnimationReader, Scene, StatedRecipe, Summary};
use std::path::{Path, PathBuf};

/// One file of the animation.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    pub(crate) path: PathBuf,
    /// Its first frame in the whole.
    pub(crate) begin: usize,
    pub(crate) first_time_code: f64,
    frames: usize,
    recipe: StatedRecipe,
}

/// Parts that follow one another, played as one animation. One file is open at a time.
pub(crate) struct Parts {
    parts: Vec<Part>,
    summary: Summary,
    /// The part that is open, by its place among all.
    open: Option<(usize, Animation)>,
    /// How the files that join the parts differ from what stitching writes.
    stitched: Vec<String>,
}

impl Parts {
    /// Opens each file once, and puts them in the order of their time codes.
    ///
    /// # Errors
    /// [`Error::Input`] if there is none, one cannot be read, two are not of the same rig and settings, or
    /// there is a gap or an overlap; [`Error::Io`].
    pub(crate) fn open(paths: &[PathBuf]) -> Result<Self> {
        let mut whole: Option<(&Path, Summary)> = None;
        let mut parts = Vec::new();
        for path in paths {
            let summary = open_part(path)?.summary().clone();
            let recipe = known_recipe(path, &summary)?.clone();
            match &whole {
                None => whole = Some((path, summary.clone())),
                Some((first, expected)) => {
                    if let Some(difference) = difference(expected, &summary) {
                        let (path, first) = (path.display(), first.display());
                        return Err(Error::mismatch(format!(
                            "{path} and {first} are not parts of one animation: {difference}; export both \
                             anew with the same rig and settings"
                        )));
                    }
                }
            }
            let Summary { frames, first_time_code, .. } = summary;
            parts.push(Part { path: path.clone(), begin: 0, first_time_code, frames, recipe });
        }
        let Some((_, mut summary)) = whole else {
            return Err(Error::empty("there are no parts to put together, expected at least one file"));
        };
        parts.sort_by(|a, b| a.first_time_code.total_cmp(&b.first_time_code));
        for i in 1..parts.len() {
            check_follows(&parts[i - 1], &parts[i])?;
            parts[i].begin = parts[i - 1].begin + parts[i - 1].frames;
        }
        let (first, last) = (&parts[0], &parts[parts.len() - 1]);
        summary.first_time_code = first.first_time_code;
        summary.frames = last.begin + last.frames;
        let recipe = first.recipe.clone();
        summary.recipe = Some(match last.recipe.get(END_FRAME) {
            Some(end) => recipe.with(END_FRAME, end.clone()),
            None => recipe,
        });
        Ok(Self { parts, summary, open: None, stitched: Vec::new() })
    }

    /// The files in the order of their time codes; at least one.
    pub(crate) fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The same, with differences of the files that join them.
    pub(crate) fn stitched(self, stitched: Vec<String>) -> Self {
        Self { stitched, ..self }
    }

    /// Opens the part that a frame is in, and says which of its frames it is.
    fn at(&mut self, frame: usize) -> Result<(&mut Animation, usize)> {
        let part = self.parts.partition_point(|part| part.begin <= frame) - 1;
        let Part { path, begin, .. } = &self.parts[part];
        let animation = match self.open.take() {
            Some((open, animation)) if open == part => animation,
            _ => open_part(path)?,
        };
        let (_, animation) = self.open.insert((part, animation));
        Ok((animation, frame - begin))
    }
}

impl AnimationReader for Parts {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn channel(&mut self, channel: &Channel, frame: usize, out: &mut Vec<f32>) -> Result<()> {
        let (animation, frame) = self.at(frame)?;
        animation.channel(channel, frame, out)
    }

    fn extent(&mut self, frame: usize) -> Result<Option<[[f32; 3]; 2]>> {
        let (animation, frame) = self.at(frame)?;
        animation.extent(frame)
    }

    fn head(&mut self, frame: usize) -> Result<Option<[[f64; 4]; 4]>> {
        let (animation, frame) = self.at(frame)?;
        animation.head(frame)
    }

    fn compare(&mut self, scene: &Scene<'_>) -> Result<Vec<String>> {
        let mut found = self.stitched.clone();
        for part in self.parts.clone() {
            let of_part = Scene {
                frames: part.frames,
                first_time_code: part.first_time_code,
                head: scene.head.and_then(|head| head.get(part.begin..part.begin + part.frames)),
                ..*scene
            };
            let (animation, _) = self.at(part.begin)?;
            let name = part.path.display().to_string();
            found.extend(animation.compare(&of_part)?.into_iter().map(|what| format!("{name}: {what}")));
        }
        Ok(found)
    }
}

fn open_part(path: &Path) -> Result<Animation> {
    let opened = open(path)?;
    if clips(&opened.layer).is_some() {
        return Err(Error::unsupported_format(format!(
            "{}: is stitched from parts itself; name its parts instead",
            path.display()
        )));
    }
    let animation = Animation::new(opened, path.display().to_string(), Some(path), None)?;
    if animation.summary().stated_error.is_some() {
        return Err(Error::conflict(format!(
            "{}: holds shapes with curves, and the shapes of each part would be different; export the parts \
             without shapes",
            path.display()
        ))
        .with_remedies(&[Remedy::NoShapes]));
    }
    if animation.summary().faces.is_empty() {
        return Err(Error::conflict(format!(
            "{}: holds samples for a mesh in another file; export the parts with their mesh",
            path.display()
        )));
    }
    Ok(animation)
}

fn known_recipe<'a>(path: &Path, summary: &'a Summary) -> Result<&'a StatedRecipe> {
    summary.recipe.as_ref().ok_or_else(|| {
        Error::unsupported_format(format!(
            "{}: does not say which rig and settings it was made with, expected an animation that Rhytid has written",
            path.display()
        ))
    })
}

/// The field of a recipe that says where an animation ends.
const END_FRAME: &str = "end_frame";

/// The fields that may differ between the recipes of two parts. Edits are told apart by their hash.
const OF_A_PART: [&str; 4] = ["version", "first_frame", END_FRAME, "edit"];

/// A difference of two parts that must be equal, as a phrase; `None` if there is none.
fn difference(a: &Summary, b: &Summary) -> Option<String> {
    let (x, y) = (a.recipe.as_ref()?, b.recipe.as_ref()?);
    if let Some([what, b, a]) = y.difference(x, &OF_A_PART) {
        return Some(format!("{what}: {b} and {a}"));
    }
    let rate = |fps: Option<f64>| fps.unwrap_or(0.0).to_string();
    let has = |yes: bool| if yes { "yes" } else { "no" }.to_owned();
    let pairs = [
        ("frames per second", b.rate.to_string(), a.rate.to_string()),
        ("framesPerSecond", rate(b.frames_per_second), rate(a.frames_per_second)),
        ("metres per unit", b.metres_per_unit.to_string(), a.metres_per_unit.to_string()),
        ("the up axis", format!("{:?}", b.up_axis), format!("{:?}", a.up_axis)),
        ("the mesh", b.name.clone(), a.name.clone()),
        ("the number of vertices", b.vertices.to_string(), a.vertices.to_string()),
        ("with extents", has(b.extents), has(a.extents)),
        ("with head motion", has(b.head), has(a.head)),
    ];
    if let Some((what, b, a)) = pairs.into_iter().find(|(_, b, a)| a != b) {
        return Some(format!("{what}: {b} and {a}"));
    }
    for channel in a.channels.iter().chain(&b.channels) {
        let name = &channel.name;
        match [b, a].map(|summary| summary.channels.iter().find(|known| known.name == *name)) {
            [Some(b), Some(a)] if a == b => {}
            [Some(_), Some(_)] => return Some(format!("the channel {name} is different in each")),
            [b, a] => return Some(format!("with {name}: {} and {}", has(b.is_some()), has(a.is_some()))),
        }
    }
    (a.faces != b.faces).then(|| "their faces are different".to_owned())
}

fn check_follows(before: &Part, after: &Part) -> Result<()> {
    let expected = before.first_time_code + before.frames as f64;
    let found = after.first_time_code;
    if found == expected {
        return Ok(());
    }
    let (last, before, after) = (expected - 1.0, before.path.display(), after.path.display());
    Err(Error::mismatch(if found > expected {
        format!(
            "the frames {expected} to {} are in no part: {before} ends with {last} and {after} begins with \
             {found}; export the missing frames, or leave out the parts after them",
            found - 1.0
        )
    } else {
        format!(
            "{before} and {after} overlap: the first ends with frame {last} and the second begins with {found}, \
             expected {expected}; export one of them anew"
        )
    }))
}
