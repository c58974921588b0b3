//! The channels of a frame: the stages give some, and this module computes the others, each kind in one
//! place.

mod uncertainty;
mod wrinkles;

pub(crate) use uncertainty::Uncertainty;

use rhytid_core::{Channel, ChannelKind, Error, Result, Rig};
use rhytid_formats::export::{Frame, Recipe};
use rhytid_geometry::{PrincipalStrains, StrainGauge};
use wrinkles::WrinkleActivations;

/// The results of the stages for a frame.
pub(crate) struct EvaluatedFrame<'f> {
    /// The frame's number in the take that is played.
    pub number: usize,
    /// H positions.
    pub pose: &'f [[f32; 3]],
    /// V.
    pub positions: &'f [[f32; 3]],
    /// V; empty where they are not wanted.
    pub normals: &'f [[f32; 3]],
    /// V in mesh units per second; empty where they are not wanted.
    pub velocities: &'f [[f32; 3]],
}

/// The channels that frames of this recipe have in addition to positions.
///
/// # Errors
/// [`Error::Input`] if the recipe asks for wrinkles and the rig has no examples, or if a group names an
/// unknown example or an example of another group.
pub fn of_recipe(rig: &Rig, recipe: &Recipe) -> Result<Vec<Channel>> {
    let names = match recipe.has(ChannelKind::Wrinkles) {
        true => wrinkles::names(rig, &recipe.wrinkle_groups)?,
        false => Vec::new(),
    };
    Ok(recipe.channels.kinds().flat_map(|kind| kind.channels(&names)).collect())
}

/// The computation of one kind of channels.
enum Source {
    Normals,
    Velocities,
    Sigma { uncertainty: Uncertainty, sigma: Vec<f32> },
    Strain { gauge: StrainGauge, strains: PrincipalStrains },
    Wrinkles(WrinkleActivations),
}

impl Source {
    /// For a take with these frames × H handle positions.
    fn new(kind: ChannelKind, rig: &Rig, recipe: &Recipe, handles: &[f32]) -> Result<Self> {
        Ok(match kind {
            ChannelKind::Normals => Self::Normals,
            ChannelKind::Velocities => Self::Velocities,
            ChannelKind::Sigma => {
                let uncertainty = Uncertainty::new(rig, handles)?.ok_or_else(|| {
                    Error::rig_lacks(
                        "the rig cannot say how uncertain it is: this needs the learned method and an \
                         example",
                    )
                })?;
                Self::Sigma { uncertainty, sigma: Vec::new() }
            }
            ChannelKind::Strain => Self::Strain {
                gauge: StrainGauge::of_surface(rig.surface()),
                strains: PrincipalStrains::default(),
            },
            ChannelKind::Wrinkles => Self::Wrinkles(WrinkleActivations::new(rig, &recipe.wrinkle_groups)?),
        })
    }

    fn compute(&mut self, rig: &Rig, given: &EvaluatedFrame<'_>) {
        match self {
            Self::Normals | Self::Velocities => {}
            Self::Sigma { uncertainty, sigma } => uncertainty.sigma(given.number, sigma),
            Self::Strain { gauge, strains } => gauge.measure(given.positions, strains),
            Self::Wrinkles(wrinkles) => wrinkles.measure(rig, given.pose),
        }
    }

    /// The numbers of each channel of this kind, in the order of [`ChannelKind::channels`].
    fn numbers<'f>(&'f self, given: &EvaluatedFrame<'f>) -> Vec<&'f [f32]> {
        match self {
            Self::Normals => vec![given.normals.as_flattened()],
            Self::Velocities => vec![given.velocities.as_flattened()],
            Self::Sigma { sigma, .. } => vec![sigma],
            Self::Strain { strains, .. } => vec![
                strains.strains.as_flattened(),
                strains.first.as_flattened(),
                strains.second.as_flattened(),
            ],
            Self::Wrinkles(wrinkles) => wrinkles.activations().collect(),
        }
    }
}

/// The computation of the channels of a recipe's frames, one after the other.
pub(crate) struct ChannelSources<'a> {
    rig: &'a Rig,
    channels: Vec<Channel>,
    sources: Vec<Source>,
}

impl<'a> ChannelSources<'a> {
    /// For a take with these frames × H handle positions.
    ///
    /// # Errors
    /// [`Error::Input`] if the rig has no data for a channel, or if a group names an unknown example.
    pub(crate) fn new(rig: &'a Rig, recipe: &Recipe, handles: &[f32]) -> Result<Self> {
        let sources = recipe.channels.kinds().map(|kind| Source::new(kind, rig, recipe, handles));
        Ok(Self { rig, channels: of_recipe(rig, recipe)?, sources: sources.collect::<Result<_>>()? })
    }

    /// The frame with all of its channels.
    pub(crate) fn frame<'f>(&'f mut self, given: &EvaluatedFrame<'f>) -> Frame<'f> {
        self.sources.iter_mut().for_each(|source| source.compute(self.rig, given));
        let numbers = self.sources.iter().flat_map(|source| source.numbers(given));
        let positions = Frame::new(given.positions.as_flattened());
        self.channels
            .iter()
            .zip(numbers)
            .fold(positions, |frame, (channel, numbers)| frame.with(channel, numbers))
    }
}
