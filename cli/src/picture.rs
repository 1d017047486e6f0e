//! A picture as the integers take it.

use hoverlock_reference::image::picture::{Frame, Picture};

/// The picture, or where it is larger than the frame its centre, which is then said on stderr.
pub fn cropped(picture: &Picture) -> Frame {
    let frame = picture.frame();
    if frame.is_cropped_from(picture) {
        let (width, height) = (picture.luma.width(), picture.luma.height());
        let (to_width, to_height) = (frame.luma.width(), frame.luma.height());
        eprintln!(
            "hoverlock: {}: {width}x{height} is larger than the frame; taking its centre {to_width}x{to_height} at ({}, {})",
            picture.path.display(),
            frame.x,
            frame.y
        );
    }
    frame
}
