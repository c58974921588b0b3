//! Parameter blocks.
/// Defines a kernel's parameter block: `u32` fields in one order for every backend, and their names.
macro_rules! parameter_block {
    ($($(#[$meta:meta])* $field:ident),* $(,)?) => {
        /// The parameter block: a push-constant block in Vulkan, a uniform buffer in WebGPU, the last
        /// argument in OpenCL.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
        #[repr(C)]
        pub struct Params {
            $($(#[$meta])* pub $field: u32),*
        }

        impl Params {
            /// The names of the fields, in order.
            pub const FIELDS: &'static [&'static str] = &[$(stringify!($field)),*];
        }
    };
}
pub(crate) use parameter_block;
