//! Encodes pictures as PNG `data:` URLs, so that a page needs no other files.

use crate::colour::Rgb;
use base64::Engine as _;
use hoverlock_reference::image::plane::Plane;
use image::{
    ExtendedColorType, ImageEncoder as _, ImageError,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};

/// Encodes a colour picture as `data:image/png;base64,...`.
///
/// # Errors
/// The PNG encoder fails.
pub(crate) fn colour_png(picture: &Plane<Rgb>) -> Result<String, ImageError> {
    let bytes: Vec<u8> = picture.as_slice().iter().flatten().copied().collect();
    let mut png = Vec::new();
    // These pictures have few colours and much noise. PNG filters would hide the repeated bytes from the compressor.
    let encoder = PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::NoFilter);
    encoder.write_image(&bytes, picture.width() as u32, picture.height() as u32, ExtendedColorType::Rgb8)?;
    Ok(address("image/png", &png))
}

/// Returns the `data:` URL of `bytes` with this media type.
pub fn address(media_type: &str, bytes: &[u8]) -> String {
    format!("data:{media_type};base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_embedded_picture_decodes_to_the_same_pixels() {
        let picture = Plane::from_fn(5, 3, |x, y| [x as u8, y as u8, 200]);
        let address = colour_png(&picture).unwrap();
        let encoded = address.strip_prefix("data:image/png;base64,").unwrap();
        let png = base64::engine::general_purpose::STANDARD.decode(encoded).unwrap();
        let decoded = image::load_from_memory(&png).unwrap().to_rgb8();
        assert_eq!(decoded.dimensions(), (5, 3));
        assert_eq!(decoded.get_pixel(4, 2).0, [4, 2, 200]);
    }
}
