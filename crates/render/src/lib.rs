//! Draws faces with wgpu: shaded, as skin, as wire, and as heat maps.
//!
//! A [`Renderer`] draws the buffers in which a session of the wgpu backend leaves its results. It draws
//! without a copy, into any pass of the same device. An [`Offscreen`] is a pass of its own that gives a
//! [`Picture`]. [`FrameBuffers`] hold frames from elsewhere. A [`SkinRenderer`] draws frames as skin, after
//! lighting them.
//!
//! ```
//! use rhytid_backend_wgpu::Wgpu;
//! use rhytid_core::{Animator, Backend, Stage, UploadOptions};
//! use rhytid_render::{Camera, Look, Offscreen, Renderer, Vertices, View};
//!
//! # let face = rhytid_demo::face(2_000);
//! # let rig = rhytid_solve::solve(&face, &rhytid_core::NoProgress)?.rounded()?;
//! # let rest = rig.handles().rest.as_flattened();
//! // `rig` is a face's, and `rest` where its handles are at rest.
//! if let Some(info) = Wgpu::devices()?.into_iter().next() {
//!     let wgpu = Wgpu::open(&info)?;
//!     let mut animator = Animator::new(&wgpu, &rig, UploadOptions::frames(1))?;
//!     animator.evaluate(rest)?;
//!
//!     let (device, queue) = (wgpu.device(), wgpu.queue());
//!     let mut renderer = Renderer::new(device, queue, &rig.surface().faces, &rig.surface().triangles, Offscreen::TARGET)?;
//!     let page = Offscreen::new(device, queue, [320, 400])?;
//!     let camera = Camera::framing(&rig.surface().rest, rig.surface().up_axis, View::default(), page.aspect());
//!     renderer.show(&camera, page.aspect(), Look::Smooth);
//!     let result = |stage| animator.session().results(stage).next().expect("one frame").1.slice(..);
//!     let (positions, normals) = (result(Stage::Positions), result(Stage::Normals));
//!     let face = Vertices { positions, normals, numbers: None };
//!     let picture = page.draw([0; 4], |pass| renderer.draw(pass, face))?;
//!     assert_eq!(picture.pixel([160, 200])[3], 255, "the face is in the middle");
//!     std::fs::write(std::env::temp_dir().join("face.png"), picture.png()?).expect("a folder to write to");
//! }
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod animated_image;
mod animated_webp;
mod camera;
mod data_texture;
#[cfg(feature = "film")]
mod film;
mod frame_buffers;
mod heat;
mod image;
mod look;
mod marks;
mod matcap;
mod materials;
mod numbers;
mod offscreen;
mod overlay;
mod parts;
mod picture;
mod posed;
mod read_back;
mod renderer;
mod sheet;
mod skin;
mod target;
mod textured;
mod vertices;
mod words;
#[cfg(feature = "film")]
mod yuv;

pub use animated_image::{AnimatedImage, AnimatedImageFormat};
pub use animated_webp::AnimatedWebP;
pub use camera::{Camera, Sphere, View, around_handles};
#[cfg(feature = "film")]
pub use film::Film;
pub use frame_buffers::FrameBuffers;
pub use heat::Heat;
pub use look::Look;
pub use marks::{influence_marks, marker_marks, tangent_frame_marks};
pub use materials::pictures;
pub use numbers::{Strains, distances};
pub use offscreen::Offscreen;
pub use overlay::{Mark, Overlay};
pub use parts::{albedos, hide_parts};
pub use picture::{Picture, to_srgb};
pub use read_back::read_floats;
pub use renderer::Renderer;
pub use sheet::Sheet;
pub use skin::{Gaussian, Lights, SKIN_PROFILE, Skin, SkinRenderer, Sky, Tone};
pub use target::Target;
pub use textured::Surface;
pub use vertices::Vertices;
pub use words::{Anchor, LEGEND, LINE, SMALL, letter_scale};

use rhytid_core::{DeviceErrorKind, Error, Result, human};

/// Runs `calls` of wgpu. A fault that wgpu finds in them is an error.
fn checked<T>(device: &wgpu::Device, doing: &str, calls: impl FnOnce() -> T) -> Result<T> {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
    let done = calls();
    // Outside of browsers the errors are known at once.
    let [internal, validation, memory] = [internal, validation, memory].map(|scope| {
        let mut found = std::pin::pin!(scope.pop());
        match found.as_mut().poll(&mut std::task::Context::from_waker(std::task::Waker::noop())) {
            std::task::Poll::Ready(fault) => fault,
            std::task::Poll::Pending => None,
        }
    });
    let Some(fault) = memory.or(validation).or(internal) else { return Ok(done) };
    let (kind, message) = match fault {
        wgpu::Error::OutOfMemory { .. } => {
            (DeviceErrorKind::OutOfMemory, format!("out of memory while {doing}; ask for a smaller picture"))
        }
        other => {
            // The first lines say where the fault was found, and the last ones what it is.
            let causes =
                std::iter::successors(Some(&other as &dyn std::error::Error), |error| error.source());
            let cause = causes.last().map(ToString::to_string).unwrap_or_default();
            let cause = cause.split_whitespace().collect::<Vec<_>>().join(" ");
            (DeviceErrorKind::Driver, format!("{doing} was refused: {cause}"))
        }
    };
    Err(Error::Device { kind, device: name(device), message })
}

/// Refuses work that needs more than a device allows. Each of the `limits` has a name, the need, and what the
/// device has.
///
/// # Errors
/// [`Error::Input`], which ends with the `remedy`.
fn allowed(what: &str, limits: &[(&str, u64, u64)], remedy: &str) -> Result<()> {
    match limits.iter().find(|(_, needed, most)| needed > most) {
        None => Ok(()),
        Some((limit, needed, most)) => Err(Error::too_large(format!(
            "{what} needs a {limit} of {}, and this device allows {}; {remedy}",
            human::count(*needed as usize),
            human::count(*most as usize)
        ))),
    }
}

/// The remedy where a mesh is too large.
const FEWER: &str = "draw a mesh of fewer vertices";

fn name(device: &wgpu::Device) -> String {
    format!("wgpu ({})", device.adapter_info().name)
}
