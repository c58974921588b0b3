//! The space of the neutral, and the way of an example's coordinates into it.
use super::sections::{ExampleSection, MeshSection, Units};
use rhytid_core::{Error, InputErrorKind, Result, UpAxis};
use rhytid_geometry::Axes;
use rhytid_meshes::Space;
use std::path::Path;

/// The space of a face, which is that of its neutral.
#[derive(Debug, Clone, Copy)]
pub(super) struct NeutralSpace {
    pub(super) metres_per_unit: f64,
    pub(super) up: UpAxis,
    /// What the neutral's file states, whatever the project says.
    stated: Space,
}

impl NeutralSpace {
    /// The space that the section says, else the one that the neutral's file states.
    ///
    /// # Errors
    /// [`Error::Input`] if neither says the unit.
    pub(super) fn new(section: &MeshSection, stated: Space, project: &Path) -> Result<Self> {
        let said = section.units.map(Units::metres_per_unit);
        let metres_per_unit = said.or(stated.metres_per_unit).ok_or_else(|| {
            Error::input(format!(
                "{}: [mesh] lacks the key units, and {} does not state its unit; add units = \"m\", \"cm\", \"mm\" or \
                 \"in\"",
                project.display(),
                section.neutral.display()
            ))
            .of_kind(InputErrorKind::MissingKey { key: "units".to_owned() })
        })?;
        Ok(Self { metres_per_unit, up: section.up.or(stated.up).unwrap_or_default(), stated })
    }

    /// Takes an example's positions from the space of its file to the neutral's.
    ///
    /// An example's own keys come first. If both files state their space, the example's stands to the
    /// neutral's as they say. If only the example's file states it, it is compared with the space that the
    /// project says of the neutral. Otherwise both are in the same space.
    pub(super) fn take_in(&self, positions: &mut [[f64; 3]], of_file: Space, example: &ExampleSection) {
        let unit = match (example.unit, of_file.metres_per_unit) {
            (Some(unit), _) => unit.metres_per_unit() / self.metres_per_unit,
            (None, Some(unit)) => unit / self.stated.metres_per_unit.unwrap_or(self.metres_per_unit),
            (None, None) => 1.0,
        };
        let factor = unit * example.scale.unwrap_or(1.0);
        let turned = of_file.up.map(|up| Axes::between(up, self.stated.up.unwrap_or(self.up)));
        let axes = example.axes.or(turned).unwrap_or(Axes::SAME);
        if factor != 1.0 || axes != Axes::SAME {
            positions.iter_mut().for_each(|x| *x = axes.apply(*x).map(|x| factor * x));
        }
    }
}
