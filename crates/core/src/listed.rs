//! Enums that list their values, or the names of these.

/// Makes an enum without fields, and `ALL` of its values in their order.
macro_rules! listed {
    ($(#[$meta:meta])* pub enum $name:ident { $($(#[$doc:meta])* $variant:ident,)+ }) => {
        $(#[$meta])*
        pub enum $name {
            $($(#[$doc])* $variant,)+
        }

        impl $name {
            /// All of them, in their order.
            pub const ALL: [Self; [$(stringify!($variant)),+].len()] = [$(Self::$variant),+];
        }
    };
}
pub(crate) use listed;

/// Makes an enum whose variants may have fields, and the names of its variants: other languages list them.
macro_rules! named {
    ($(#[$meta:meta])* pub enum $name:ident {
        $($(#[$doc:meta])* $variant:ident $({ $($(#[$of_field:meta])* $field:ident: $type:ty,)+ })?,)+
    }) => {
        $(#[$meta])*
        pub enum $name {
            $($(#[$doc])* $variant $({ $($(#[$of_field])* $field: $type,)+ })?,)+
        }

        impl $name {
            /// The names of all of them, in their order.
            pub const NAMES: [&'static str; [$(stringify!($variant)),+].len()] = [$(stringify!($variant)),+];

            /// Its own name, which is one of [`Self::NAMES`].
            pub const fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant $({ $($field: _,)+ })? => stringify!($variant),)+
                }
            }
        }
    };
}
pub(crate) use named;
