//! The rig: a solved face as plain data.
mod examples;
mod fine_scale;
mod handle_set;
mod influences;
mod surface;

pub use examples::Examples;
pub use fine_scale::FineScale;
pub use handle_set::{HandleSet, Motions};
pub use influences::Influences;
pub use surface::{MOST_AROUND_JOINED, Surface};

use crate::{Learned, Result, Table};
use rhytid_kernels::Real;

/// A solved face: immutable plain data, the same for every backend.
///
/// Every rig is complete and sound. [`Rig::new`] checks every array once, and nothing else makes a rig from
/// outside numbers. Kernels do not check, so they may be given any rig.
///
/// Shapes use V vertices, H handles, F strain edges, P examples, N = P + 1 RBF centres (centre 0 is the rest
/// pose) and K influences per vertex. `Rig<f64>` is what the solve returns and the reference evaluates;
/// `Rig<f32>` is what is stored and uploaded. References are to `docs/method.md`.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig<T: Real = f32> {
    parts: RigParts<T>,
}

/// The parts of a rig: to make one, or to change one.
#[derive(Debug, Clone, PartialEq)]
pub struct RigParts<T: Real = f32> {
    /// The neutral mesh.
    pub surface: Surface<T>,
    /// The handles.
    pub handles: HandleSet<T>,
    /// The examples.
    pub examples: Examples<T>,
    /// ℓ in mesh units, as solved with (section 2).
    pub bending_length: f64,
    /// B, V×H (section 2), with ΔB of the learned method in it: identity rows at handles, zero rows at
    /// vertices that do not move.
    pub basis: Table<T>,
    /// The influences of each vertex.
    pub influences: Influences<T>,
    /// The wrinkles.
    pub fine_scale: FineScale<T>,
    /// What the learned method adds; `None` for the chapter's.
    pub learned: Option<Learned<T>>,
}

impl<T: Real> Rig<T> {
    /// The rig of these parts.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) with the first array and element whose shape or range is not
    /// what the parts promise.
    pub fn new(parts: RigParts<T>) -> Result<Self> {
        parts.check()?;
        Ok(Self { parts })
    }

    /// The rig of these parts, without a check. They must come from the parts of a rig, which are sound.
    pub(crate) fn of_sound(parts: RigParts<T>) -> Self {
        Self { parts }
    }

    /// The parts, to change one and make another rig with [`Rig::new`].
    pub fn into_parts(self) -> RigParts<T> {
        self.parts
    }

    /// The neutral mesh.
    pub fn surface(&self) -> &Surface<T> {
        &self.parts.surface
    }

    /// The handles.
    pub fn handles(&self) -> &HandleSet<T> {
        &self.parts.handles
    }

    /// The examples.
    pub fn examples(&self) -> &Examples<T> {
        &self.parts.examples
    }

    /// ℓ in mesh units, as solved with (section 2).
    pub fn bending_length(&self) -> f64 {
        self.parts.bending_length
    }

    /// B, V×H (section 2), with ΔB of the learned method in it: identity rows at handles, zero rows at
    /// vertices that do not move.
    pub fn basis(&self) -> &Table<T> {
        &self.parts.basis
    }

    /// The influences of each vertex.
    pub fn influences(&self) -> &Influences<T> {
        &self.parts.influences
    }

    /// The wrinkles.
    pub fn fine_scale(&self) -> &FineScale<T> {
        &self.parts.fine_scale
    }

    /// What the learned method adds; `None` for the chapter's.
    pub fn learned(&self) -> Option<&Learned<T>> {
        self.parts.learned.as_ref()
    }

    /// V.
    pub fn vertices(&self) -> usize {
        self.parts.surface.rest.len()
    }

    /// N: RBF centres, the rest pose included.
    pub fn centers(&self) -> usize {
        self.parts.examples.len() + 1
    }
}

impl Rig<f64> {
    /// The same rig in `f32`, each number rounded to nearest.
    ///
    /// # Errors
    /// As [`Rig::new`]. A number can be too large for `f32`, and a strain edge too short.
    pub fn rounded(&self) -> Result<Rig> {
        Rig::new(self.parts.cast())
    }
}

impl Rig {
    /// The same rig in `f64`, with the same numbers.
    pub fn widened(&self) -> Rig<f64> {
        Rig::of_sound(self.parts.cast())
    }
}

impl<T: Real> RigParts<T> {
    fn cast<U: Real>(&self) -> RigParts<U> {
        let surface: Surface<U> = self.surface.cast();
        RigParts {
            handles: self.handles.cast(&surface.rest),
            surface,
            examples: self.examples.cast(),
            bending_length: self.bending_length,
            basis: self.basis.map(|x| number(*x)),
            influences: self.influences.cast(),
            fine_scale: self.fine_scale.cast(),
            learned: self.learned.as_ref().map(Learned::cast),
        }
    }
}

/// The number in another precision, rounded to nearest.
pub(crate) fn number<T: Real, U: Real>(x: T) -> U {
    U::round_from(x.widen())
}
