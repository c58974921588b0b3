//! Numbers that name one thing of a kind, a type for each kind.
use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Pod, Zeroable, Serialize, Deserialize,
        )]
        #[repr(transparent)]
        #[serde(transparent)]
        pub struct $name(pub u32);

        impl $name {
            /// Its index, counted from 0.
            pub const fn index(self) -> usize {
                self.0 as usize
            }

            /// The numbers of these, as in kernels and files.
            pub fn numbers(ids: &[Self]) -> &[u32] {
                bytemuck::cast_slice(ids)
            }

            /// The one at `index`, which is below 2³².
            ///
            /// # Panics
            /// If `index` is 2³² or more. Readers make sure that no mesh and no rig has as many.
            pub const fn from_index(index: usize) -> Self {
                assert!(index as u64 <= u32::MAX as u64, "an index is below 2³²");
                Self(index as u32)
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.0.fmt(f)
            }
        }
    };
}

id! {
    /// A vertex of the neutral mesh.
    VertexId
}
id! {
    /// A handle, counted as the labels are.
    HandleId
}
id! {
    /// A strain edge, counted as the rig's are.
    StrainEdgeId
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_their_numbers() {
        let id = VertexId::from_index(7);
        assert_eq!((id, id.index(), id.to_string()), (VertexId(7), 7, "7".to_owned()));
        assert_eq!(HandleId::numbers(&[HandleId(1), HandleId(2)]), [1, 2]);
        assert_eq!(serde_json::to_string(&StrainEdgeId(3)).unwrap(), "3");
    }
}
