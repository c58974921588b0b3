//! The limits that every kernel must keep, so that it runs on every device. `cargo xtask kernels --check`
//! checks that the sources agree with the table.
use rhytid_kernels::table::{Access, Buffer, Kernel, WORKGROUP_SIZE};
use rhytid_kernels::tile::TILE;
use std::collections::HashSet;

/// WebGPU's default limit: maxStorageBuffersPerShaderStage.
const STORAGE_BUFFERS: usize = 8;
/// Vulkan's guaranteed limit: maxPushConstantsSize, in bytes.
const PUSH_CONSTANTS: usize = 128;
/// Vulkan's guaranteed limit: maxComputeWorkGroupInvocations.
const INVOCATIONS: u32 = 128;

#[test]
fn kernels_fit_the_limits_that_every_device_has() {
    const { assert!(WORKGROUP_SIZE <= INVOCATIONS) };
    for kernel in Kernel::ALL.map(Kernel::entry) {
        assert!(kernel.bindings.len() <= STORAGE_BUFFERS, "{}", kernel.name);
        assert!(4 * kernel.params.len() <= PUSH_CONSTANTS, "{}", kernel.name);
    }
}

#[test]
fn a_workgroup_reads_whole_tiles() {
    for kernel in Kernel::ALL.map(Kernel::entry) {
        assert_eq!((WORKGROUP_SIZE * kernel.at_once) as usize % TILE, 0, "{}", kernel.name);
        // The vertices of an invocation belong to one tile.
        assert_eq!(TILE % kernel.at_once as usize, 0, "{}", kernel.name);
    }
}

#[test]
fn each_kernel_writes_its_last_buffers_alone() {
    for kernel in Kernel::ALL.map(Kernel::entry) {
        let written: Vec<_> = kernel.bindings.iter().map(|b| b.access != Access::Read).collect();
        assert!(written.is_sorted() && written.last() == Some(&true), "{}: {written:?}", kernel.name);
    }
}

#[test]
fn names_are_used_once() {
    let kernels: HashSet<&str> = Kernel::ALL.into_iter().map(Kernel::name).collect();
    assert_eq!(kernels.len(), Kernel::ALL.len());
    let buffers: HashSet<&str> = Buffer::ALL.into_iter().map(Buffer::name).collect();
    assert_eq!(buffers.len(), Buffer::ALL.len());
    for kernel in Kernel::ALL.map(Kernel::entry) {
        let buffers: HashSet<Buffer> = kernel.bindings.iter().map(|b| b.buffer).collect();
        let params: HashSet<&str> = kernel.params.iter().copied().collect();
        assert_eq!((buffers.len(), params.len()), (kernel.bindings.len(), kernel.params.len()));
    }
}

#[test]
fn the_spirv_has_been_made() {
    // The magic number, and version 1.3.
    for kernel in Kernel::ALL.map(Kernel::entry) {
        assert_eq!(kernel.spirv.get(..8), Some(&[3, 2, 0x23, 7, 0, 3, 1, 0][..]), "{}", kernel.name);
        assert_eq!(kernel.spirv.len() % 4, 0, "{}", kernel.name);
    }
}

#[test]
fn every_buffer_is_bound() {
    let mut bound: HashSet<Buffer> =
        Kernel::ALL.iter().flat_map(|kernel| kernel.entry().bindings).map(|b| b.buffer).collect();
    // It is bound in the place of the displacements.
    assert!(bound.insert(Buffer::Motions));
    assert_eq!(bound.len(), Buffer::ALL.len());
}
