//! Rigs: a solved face, from a file or from memory.
use crate::arguments::{array, free, give, object, out, path as path_of};
use crate::status::{Result, RhytidStatus, c_text, guarded, told};
use rhytid::Rig;
use rhytid::core::rig_file;
use std::ffi::{CString, c_char};
use std::ptr::null;
use std::sync::OnceLock;

/// A solved face. It never changes, so any number of threads may use it at the same time. Animators keep what
/// they need of it: it may be freed before them.
pub struct RhytidRig {
    pub(crate) rig: Rig,
    labels: Vec<CString>,
    triangle_uvs: OnceLock<Option<Vec<[f32; 2]>>>,
}

impl RhytidRig {
    fn new(rig: Rig) -> Self {
        let labels = rig.handles().labels.iter().map(|label| c_text(label)).collect();
        Self { rig, labels, triangle_uvs: OnceLock::new() }
    }

    /// Three for each triangle. `None` where the mesh has none.
    fn triangle_uvs(&self) -> Option<&[[f32; 2]]> {
        let uvs = self.triangle_uvs.get_or_init(|| {
            let surface = self.rig.surface();
            let uvs = surface.uvs.as_ref()?;
            let of = |entry: u32| uvs.values[entry as usize];
            Some(match &uvs.corners {
                None => surface.triangles.as_flattened().iter().map(|&vertex| of(vertex)).collect(),
                Some(entries) => {
                    let corners = surface.triangle_corners().ok()?;
                    corners.as_flattened().iter().map(|&corner| of(entries[corner as usize])).collect()
                }
            })
        });
        uvs.as_deref()
    }
}

/// Reads a rig file (.safetensors): a solved face.
///
/// path is UTF-8 (on Unix any bytes). *rig becomes the rig, to be freed by rhytid_rig_free(), or NULL after
/// an error: RHYTID_STATUS_IO, or RHYTID_STATUS_INPUT_… if the file is no rig or a damaged one.
///
/// # Safety
/// `path` leads to a text that ends with 0, and `rig` to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_open(path: *const c_char, rig: *mut *mut RhytidRig) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees both.
        let (rig, path) = unsafe { (out(rig, "rig", std::ptr::null_mut())?, path_of(path)?) };
        *rig = give(RhytidRig::new(rhytid::open_rig(path)?));
        Ok(())
    })
}

/// As rhytid_rig_open(), from the bytes of a rig file. The bytes may be freed or changed after the call.
///
/// # Safety
/// From `bytes` on there are `length` bytes, and `rig` leads to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_from_memory(
    bytes: *const u8,
    length: usize,
    rig: *mut *mut RhytidRig,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees both.
        let (rig, bytes) =
            unsafe { (out(rig, "rig", std::ptr::null_mut())?, array(bytes, length, "bytes")?) };
        *rig = give(RhytidRig::new(rig_file::decode(bytes, "a rig in memory")?));
        Ok(())
    })
}

/// Frees a rig. NULL is ignored.
///
/// # Safety
/// `rig` is null or a rig that nobody uses any more, nor memory that it lent.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_free(rig: *mut RhytidRig) {
    // SAFETY: the caller guarantees this.
    unsafe { free(rig) };
}

/// A fact of a rig that may be null.
///
/// # Safety
/// `rig` is null or a live rig.
unsafe fn fact<'a, T>(
    rig: *const RhytidRig,
    otherwise: T,
    tell: impl FnOnce(&'a RhytidRig) -> Option<T>,
) -> T {
    // SAFETY: the caller guarantees this.
    told(otherwise, || tell(unsafe { rig.as_ref() }?))
}

/// V, the number of vertices. 0 for NULL.
///
/// # Safety
/// `rig` is null or a live rig.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_vertices(rig: *const RhytidRig) -> usize {
    // SAFETY: the caller guarantees this.
    unsafe { fact(rig, 0, |rig| Some(rig.rig.vertices())) }
}

/// H, the number of handles: the markers that a frame gives. 0 for NULL.
///
/// # Safety
/// `rig` is null or a live rig.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_handles(rig: *const RhytidRig) -> usize {
    // SAFETY: the caller guarantees this.
    unsafe { fact(rig, 0, |rig| Some(rig.rig.handles().len())) }
}

/// The number of triangles. 0 for NULL.
///
/// # Safety
/// `rig` is null or a live rig.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_triangles(rig: *const RhytidRig) -> usize {
    // SAFETY: the caller guarantees this.
    unsafe { fact(rig, 0, |rig| Some(rig.rig.surface().triangles.len())) }
}

/// The metres in one mesh unit, such as 0.01 for centimetres. 0 for NULL.
///
/// # Safety
/// `rig` is null or a live rig.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_metres_per_unit(rig: *const RhytidRig) -> f64 {
    // SAFETY: the caller guarantees this.
    unsafe { fact(rig, 0.0, |rig| Some(rig.rig.surface().metres_per_unit)) }
}

/// The rest positions of the vertices, V × 3, in mesh units. The memory is the rig's. NULL for NULL.
///
/// # Safety
/// `rig` is null or a live rig.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_rest(rig: *const RhytidRig) -> *const f32 {
    // SAFETY: the caller guarantees this.
    unsafe { fact(rig, null(), |rig| Some(rig.rig.surface().rest.as_ptr().cast())) }
}

/// The vertices of the triangles, triangles × 3, an index buffer. The memory is the rig's. NULL for NULL.
///
/// # Safety
/// `rig` is null or a live rig.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_triangle_vertices(rig: *const RhytidRig) -> *const u32 {
    // SAFETY: the caller guarantees this.
    unsafe { fact(rig, null(), |rig| Some(rig.rig.surface().triangles.as_ptr().cast())) }
}

/// The texture coordinates of the corners of the triangles, triangles × 3 × 2, with (0, 0) at the lower left.
/// They are of corners because a vertex at a seam of the texture has several. The memory is the rig's. NULL
/// if the mesh has none, and for NULL.
///
/// # Safety
/// `rig` is null or a live rig.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_triangle_uvs(rig: *const RhytidRig) -> *const f32 {
    // SAFETY: the caller guarantees this.
    unsafe { fact(rig, null(), |rig| Some(rig.triangle_uvs()?.as_ptr().cast())) }
}

/// The rest positions of the handles, H × 3, in mesh units: a frame without motion. The memory is the rig's.
/// NULL for NULL.
///
/// # Safety
/// `rig` is null or a live rig.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_handle_rest(rig: *const RhytidRig) -> *const f32 {
    // SAFETY: the caller guarantees this.
    unsafe { fact(rig, null(), |rig| Some(rig.rig.handles().rest.as_ptr().cast())) }
}

/// The label of a handle, as the take's columns name it. Handles count from 0, in the order in which frames
/// give their positions. The memory is the rig's. NULL if there is no such handle, and for NULL.
///
/// # Safety
/// `rig` is null or a live rig.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_rig_handle_label(rig: *const RhytidRig, handle: usize) -> *const c_char {
    // SAFETY: the caller guarantees this.
    unsafe { fact(rig, null(), |rig| Some(rig.labels.get(handle)?.as_ptr())) }
}

/// The rig of an argument.
///
/// # Safety
/// `rig` is null or a live rig.
pub(crate) unsafe fn rig_of<'a>(rig: *const RhytidRig) -> Result<&'a RhytidRig> {
    // SAFETY: the caller guarantees this.
    unsafe { object(rig, "rig", "rhytid_rig_open()") }
}
