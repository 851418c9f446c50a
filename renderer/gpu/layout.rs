//! Rust structs that the GPU reads, and what a test needs to check them against the SPIR-V.

/// One field as Rust laid it out.
#[derive(Debug, Clone, Copy)]
pub struct Field {
    pub name: &'static str,
    /// Bytes from the start of the struct.
    pub offset: usize,
    /// Bytes.
    pub size: usize,
}

/// A `#[repr(C)]` struct whose GLSL twin has the same name and field names.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    pub name: &'static str,
    /// Bytes, and so the stride in an array.
    pub size: usize,
    pub fields: &'static [Field],
}

/// Implemented by [`gpu_struct!`](crate::gpu_struct).
pub trait GpuStruct: bytemuck::Pod {
    const LAYOUT: Layout;
}

/// Declares a struct that kernels read or write under the same name, field by field.
#[macro_export]
macro_rules! gpu_struct {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident: $type:ty,)* }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$field_meta])* pub $field: $type,)* }

        impl $crate::gpu::GpuStruct for $name {
            const LAYOUT: $crate::gpu::Layout = $crate::gpu::Layout {
                name: stringify!($name),
                size: size_of::<$name>(),
                fields: &[$($crate::gpu::Field {
                    name: stringify!($field),
                    offset: std::mem::offset_of!($name, $field),
                    size: size_of::<$type>(),
                },)*],
            };
        }
    };
}
