//! Materials as pictures.

use crate::picture::{Picture, from_srgb, to_srgb};
use rhytid_core::{Look, Materials, Result, Transparency};
use std::collections::HashMap;
use std::sync::Arc;

/// A picture of each material's look: its texture in its colour and with its opacity, or one pixel where it
/// has no texture. They are for [`crate::Surface::images`]. Roughness and metal are not shown.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if a texture cannot be decoded.
pub fn pictures(materials: &Materials) -> Result<Vec<Option<Arc<Picture>>>> {
    let mut decoded: HashMap<u32, Arc<Picture>> = HashMap::new();
    let mut pictures = Vec::new();
    for material in &materials.list {
        let look = material.look();
        let Some(texture) = look.texture else {
            pictures.push(Some(Arc::new(shown(&Picture::filled([1, 1], [255; 4]), &look))));
            continue;
        };
        let picture = match decoded.get(&texture) {
            Some(picture) => picture.clone(),
            None => {
                let found = &materials.textures[texture as usize];
                let read = Picture::decode(&found.bytes);
                let read = Arc::new(read.map_err(|error| error.in_file(&found.name))?);
                decoded.insert(texture, read.clone());
                read
            }
        };
        // A picture of many materials is on the device once, if it is shown as it is.
        let is_as_it_is = look.base_color == [1.0; 3]
            && match look.transparency {
                Transparency::Opaque => picture.is_opaque(),
                Transparency::Blend => look.opacity == 1.0,
                Transparency::Mask(_) => false,
            };
        pictures.push(Some(if is_as_it_is { picture } else { Arc::new(shown(&picture, &look)) }));
    }
    Ok(pictures)
}

/// The picture in the colour and with the opacity of a look.
fn shown(picture: &Picture, look: &Look) -> Picture {
    let mut pixels = picture.pixels.clone();
    // Every value of a channel in the look's colour.
    let tables: [Vec<u8>; 3] =
        look.base_color.map(|part| (0..=255).map(|value| to_srgb(part * from_srgb(value))).collect());
    for pixel in pixels.as_chunks_mut::<4>().0 {
        for (value, table) in pixel.iter_mut().zip(&tables) {
            *value = table[usize::from(*value)];
        }
        let opacity = look.opacity * f32::from(pixel[3]) / 255.0;
        pixel[3] = match look.transparency {
            Transparency::Opaque => 255,
            Transparency::Mask(cutoff) if opacity >= cutoff => 255,
            Transparency::Mask(_) => 0,
            Transparency::Blend => (255.0 * opacity).round() as u8,
        };
    }
    Picture { size: picture.size, pixels }
}
