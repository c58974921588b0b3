//! What is wrong with markers: wrong labels, gaps, and skin that stretches as no skin does.

use eframe::egui::Color32;
use glam::Vec3;
use rhytid_capture::{Kind, StrainLimit};
use rhytid_core::human;

/// A marker with a lower confidence is in doubt. A filled gap has this confidence, and a lost marker less.
pub(crate) const DOUBTFUL: f32 = 0.5;

/// The kind of a problem, which has a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProblemKind {
    /// A label that was on another marker, or may be.
    Label,
    /// A marker that was not seen, or not believed, so that its position was filled in.
    Gap,
    /// Skin between two markers that is stretched farther than any example shows.
    Strain,
}

/// Something that is wrong with markers in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// The kind.
    pub kind: ProblemKind,
    /// The markers, as handles of the rig: one, or the two ends of a strain.
    pub handles: Vec<usize>,
    /// A description for people.
    pub words: String,
}

impl ProblemKind {
    /// What an event of the clean-up is. `None` where nothing is wrong any more.
    pub(crate) fn of(kind: Kind, confidence: f32) -> Option<Self> {
        match kind {
            Kind::Swap | Kind::Shuffled | Kind::Slide | Kind::Step => Some(Self::Label),
            Kind::Strain => Some(Self::Strain),
            Kind::Lost | Kind::NeverSeen | Kind::Left => Some(Self::Gap),
            _ => (confidence < DOUBTFUL).then_some(Self::Gap),
        }
    }

    /// The meaning of its colour.
    pub(crate) fn meaning(self) -> String {
        match self {
            Self::Label => "label was on another marker".to_owned(),
            Self::Gap => format!("in doubt (confidence below {DOUBTFUL})"),
            Self::Strain => "strain that no skin has".to_owned(),
        }
    }

    /// Its colour in the window.
    pub(crate) fn colour(self) -> Color32 {
        match self {
            Self::Label => Color32::from_rgb(214, 40, 190),
            Self::Gap => Color32::from_rgb(240, 214, 40),
            Self::Strain => Color32::from_rgb(222, 24, 40),
        }
    }

    /// The same as linear red, green and blue.
    pub(crate) fn linear(self) -> [f32; 3] {
        let [r, g, b, _] = eframe::egui::Rgba::from(self.colour()).to_array();
        [r, g, b]
    }
}

/// The strains of `handles`, H positions in mesh units, that are beyond their `limits`. `rest` and `labels`
/// are those of the rig.
pub(crate) fn strains(
    limits: &[StrainLimit],
    handles: &[[f32; 3]],
    rest: &[[f32; 3]],
    labels: &[String],
) -> Vec<Problem> {
    let mut problems = Vec::new();
    for limit in limits {
        let length = |points: &[[f32; 3]]| {
            let [a, b] = limit.handles.map(|handle| Vec3::from(points[handle]));
            f64::from(a.distance(b))
        };
        let strain = length(handles) / length(rest) - 1.0;
        if strain > limit.most {
            let [a, b] = limit.handles.map(|handle| &labels[handle]);
            problems.push(Problem {
                kind: ProblemKind::Strain,
                handles: limit.handles.to_vec(),
                words: format!("the skin between {a} and {b} is stretched by {}", human::percent(strain, 0)),
            });
        }
    }
    problems
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_strain_beyond_its_limit_is_a_problem() {
        let labels = ["chin", "lip", "brow"].map(String::from);
        let limits = [[0, 1], [1, 2]].map(|handles| StrainLimit { handles, most: 1.2 });
        let rest = [[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        let at = |x: f32| [[0.0; 3], [x, 0.0, 0.0], [x + 2.0, 0.0, 0.0]];
        assert_eq!(strains(&limits, &at(2.1), &rest, &labels), []);
        let found = strains(&limits, &at(2.5), &rest, &labels);
        let words = "the skin between chin and lip is stretched by 150 %".to_owned();
        assert_eq!(found, [Problem { kind: ProblemKind::Strain, handles: vec![0, 1], words }]);
    }

    #[test]
    fn gaps_that_were_filled_are_no_problem() {
        assert_eq!(ProblemKind::of(Kind::Spline, 0.8), None);
        assert_eq!(ProblemKind::of(Kind::Model, 0.5), None);
        assert_eq!(ProblemKind::of(Kind::Outlier, 0.2), Some(ProblemKind::Gap));
        assert_eq!(ProblemKind::of(Kind::Lost, 0.0), Some(ProblemKind::Gap));
        assert_eq!(ProblemKind::of(Kind::Swap, 1.0), Some(ProblemKind::Label));
    }
}
