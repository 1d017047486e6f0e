//! Pictures as files.

use std::path::Path;

use hoverlock_reference::image::plane::Plane;

/// Saves 16-bit samples as the file `name` in `folder`, in the format of its extension, and returns its path.
pub fn save(folder: &Path, name: &str, picture: &Plane<u16>) -> String {
    let path = folder.join(name);
    let (width, height) = (picture.width() as u32, picture.height() as u32);
    image::ImageBuffer::<image::Luma<u16>, _>::from_raw(width, height, picture.as_slice().to_vec())
        .unwrap()
        .save(&path)
        .unwrap();
    path.to_str().unwrap().to_owned()
}
