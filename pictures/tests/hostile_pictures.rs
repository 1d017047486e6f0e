//! Untrusted picture files: damaged, truncated, too large, of other formats. Valid ones are decoded correctly, others
//! are rejected with a reason, and reading never hangs.

use std::fs;
use std::io::Cursor;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hoverlock_pictures::folder::remarks;
use hoverlock_pictures::{Limits, Picture, PictureError, PictureFile, data_dir, demo_dir};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb, Rgba};
use tempfile::TempDir;

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn put(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    }
}

fn texture(x: u32, y: u32) -> u8 {
    (x.wrapping_mul(2_654_435_761).wrapping_add(y.wrapping_mul(40_503).wrapping_mul(x + 7)) >> 11) as u8
}

fn encoded(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// Computes the luma from the pixels that `image` decodes.
fn expected(picture: &DynamicImage) -> Vec<u16> {
    let of = |r: u32, g: u32, b: u32| (299 * r + 587 * g + 114 * b + 500) / 1000;
    let eight = |v: u32| (257 * v) as u16;
    match picture {
        DynamicImage::ImageLuma8(p) => p.pixels().map(|p| eight(p.0[0].into())).collect(),
        DynamicImage::ImageLuma16(p) => p.pixels().map(|p| p.0[0]).collect(),
        DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_) => {
            picture.to_rgb8().pixels().map(|p| eight(of(p.0[0].into(), p.0[1].into(), p.0[2].into()))).collect()
        }
        DynamicImage::ImageRgb16(_) | DynamicImage::ImageRgba16(_) => {
            picture.to_rgb16().pixels().map(|p| of(p.0[0].into(), p.0[1].into(), p.0[2].into()) as u16).collect()
        }
        other => panic!("{:?}", other.color()),
    }
}

/// Returns one small picture of each pixel type.
fn kinds() -> [DynamicImage; 6] {
    let eight = |x, y| [texture(x, y), texture(y, x), texture(x + 9, y), texture(x, y + 9)];
    let sixteen = |x, y| eight(x, y).map(|v| u16::from(v) * 251 + 13);
    let (w, h) = (37, 29);
    let rgb = |v: [u8; 4]| Rgb([v[0], v[1], v[2]]);
    let wide = |v: [u16; 4]| Rgb([v[0], v[1], v[2]]);
    [
        DynamicImage::ImageLuma8(ImageBuffer::from_fn(w, h, |x, y| Luma([texture(x, y)]))),
        DynamicImage::ImageLuma16(ImageBuffer::from_fn(w, h, |x, y| Luma([sixteen(x, y)[0]]))),
        DynamicImage::ImageRgb8(ImageBuffer::from_fn(w, h, |x, y| rgb(eight(x, y)))),
        DynamicImage::ImageRgba8(ImageBuffer::from_fn(w, h, |x, y| Rgba(eight(x, y)))),
        DynamicImage::ImageRgb16(ImageBuffer::from_fn(w, h, |x, y| wide(sixteen(x, y)))),
        DynamicImage::ImageRgba16(ImageBuffer::from_fn(w, h, |x, y| Rgba(sixteen(x, y)))),
    ]
}

#[test]
fn every_format_and_depth_decodes_to_the_same_luma() {
    let folder = Folder::new();
    for (index, picture) in kinds().iter().enumerate() {
        for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::Pnm, ImageFormat::Bmp, ImageFormat::WebP] {
            let mut bytes = Cursor::new(Vec::new());
            if picture.write_to(&mut bytes, format).is_err() {
                // This format does not support the pixel type.
                continue;
            }
            let bytes = bytes.into_inner();
            let decoded = Picture::open(folder.put("picture", &bytes)).unwrap();
            let by_image = image::load_from_memory_with_format(&bytes, format).unwrap();
            assert_eq!(decoded.luma.as_slice(), expected(&by_image), "{format:?} {index}");
            assert_eq!((decoded.luma.width(), decoded.luma.height()), (37, 29), "{format:?} {index}");
        }
    }
}

#[test]
fn real_photographs_decode_as_image_decodes_them() {
    let Some(folder) = demo_dir() else {
        writeln!(
            std::io::stderr(),
            "SKIPPED: real_photographs_decode_as_image_decodes_them: run `make demo` for the photographs"
        )
        .expect("stderr is open");
        return;
    };
    for name in ["aero1.jpg", "aero3.jpg", "aloeL.jpg", "graf1.png"] {
        let picture = Picture::open(folder.join(name)).unwrap();
        assert_eq!(picture.luma.as_slice(), expected(&image::open(folder.join(name)).unwrap()), "{name}");
    }
}

#[test]
fn every_kind_of_real_picture_opens() {
    let Some(data) = data_dir() else {
        writeln!(
            std::io::stderr(),
            "SKIPPED: every_kind_of_real_picture_opens: set HOVERLOCK_DATA to the picture folder"
        )
        .expect("stderr is open");
        return;
    };
    let listed = fs::read_dir(data.join("textures")).unwrap().map(|entry| entry.unwrap().path());
    for path in listed.filter(|path| path.extension().is_some_and(|e| e == "png" || e == "jpg")) {
        Picture::open(&path).unwrap();
    }
}

/// Returns a PNG with the given pixels and extra chunks, each with a correct checksum.
fn png(width: u32, height: u32, pixels: &[u8], after_header: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut header = Vec::new();
    header.extend(width.to_be_bytes());
    header.extend(height.to_be_bytes());
    header.extend([8, 0, 0, 0, 0]);
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |kind: &[u8; 4], body: &[u8]| {
        bytes.extend((body.len() as u32).to_be_bytes());
        let summed = [kind, body].concat();
        bytes.extend(&summed);
        bytes.extend(crc32(&summed).to_be_bytes());
    };
    chunk(b"IHDR", &header);
    for (kind, body) in after_header {
        chunk(kind, body);
    }
    chunk(b"IDAT", pixels);
    chunk(b"IEND", &[]);
    bytes
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 })
    })
}

fn adler32(bytes: &[u8]) -> u32 {
    let (mut a, mut b) = (1u32, 0u32);
    for &byte in bytes {
        a = (a + u32::from(byte)) % 65521;
        b = (b + a) % 65521;
    }
    (b << 16) | a
}

/// Returns rows without a filter in one stored zlib block, with an error of `adler_off_by` in the checksum.
fn stored(width: u32, height: u32, adler_off_by: u32) -> Vec<u8> {
    let rows: Vec<u8> =
        (0..height).flat_map(|y| std::iter::once(0).chain((0..width).map(move |x| texture(x, y)))).collect();
    let length = rows.len() as u16;
    let mut zlib = vec![0x78, 0x01, 0x01];
    zlib.extend(length.to_le_bytes());
    zlib.extend((!length).to_le_bytes());
    zlib.extend(&rows);
    zlib.extend((adler32(&rows) ^ adler_off_by).to_be_bytes());
    zlib
}

#[test]
fn a_png_with_a_wrong_checksum_is_rejected_with_a_plain_message() {
    let folder = Folder::new();
    let good = png(64, 48, &stored(64, 48, 0), &[]);
    Picture::open(folder.put("good.png", &good)).unwrap();
    let adler = png(64, 48, &stored(64, 48, 1), &[]);
    let mut crc = good.clone();
    let at = crc.len() - 12 - 30;
    crc[at] ^= 0x40;
    let mut header = good.clone();
    header[20] ^= 1;
    let mut critical = png(64, 48, &stored(64, 48, 0), &[(b"QQQQ", b"x")]);
    for (bytes, sign) in [(&adler, "Adler"), (&crc, ""), (&header, "CRC"), (&critical, "critical")] {
        let rejected = Picture::open(folder.put("bad.png", bytes)).unwrap_err().to_string();
        assert!(rejected.contains(sign) && rejected.contains("cannot be decoded"), "{rejected}");
        assert!(!rejected.contains(['{', '}', '[', '_']) && !rejected.contains("ChunkType"), "{rejected}");
    }
    critical.truncate(good.len() - 20);
    for length in [30, good.len() / 2, good.len() - 1] {
        let rejected = Picture::open(folder.put("cut.png", &good[..length])).unwrap_err();
        assert!(matches!(rejected, PictureError::Damaged { .. }), "{length}: {rejected}");
    }
}

/// Returns Exif data with the orientation as their only entry.
fn exif(orientation: u8) -> Vec<u8> {
    [&b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0"[..], &[orientation, 0, 0, 0, 0, 0, 0, 0]].concat()
}

#[test]
fn an_orientation_is_honoured_in_jpeg_png_and_tiff() {
    let folder = Folder::new();
    let wide = DynamicImage::ImageLuma8(ImageBuffer::from_fn(64, 48, |x, y| Luma([(2 * x + y) as u8])));
    let plain = encoded(&wide, ImageFormat::Jpeg);
    let segment = [&b"Exif\0\0"[..], &exif(6)].concat();
    let mut turned = plain[..2].to_vec();
    turned.extend([0xff, 0xe1]);
    turned.extend((segment.len() as u16 + 2).to_be_bytes());
    turned.extend(&segment);
    turned.extend(&plain[2..]);
    let file = PictureFile::open(folder.put("a.jpg", &turned), &Limits::default()).unwrap();
    assert_eq!((file.size(), file.orientation()), ((48, 64), Some("turned by 90 degrees clockwise")));
    let sensor = PictureFile::open(folder.put("a.jpg", &turned), &Limits::default()).unwrap().as_stored();
    assert_eq!((sensor.size(), sensor.orientation()), ((64, 48), None));
    assert!(remarks(&sensor, None)[0].contains("taken as stored, not as its orientation tag asks"));
    let (stored, turned) = (Picture::open(folder.put("b.jpg", &plain)).unwrap(), file.decode().unwrap());
    assert_eq!(sensor.decode().unwrap().luma.as_slice(), stored.luma.as_slice());
    assert_eq!((turned.luma.width(), turned.luma.height()), (48, 64));
    // The lower left corner becomes the upper left one.
    assert_eq!(turned.luma[(0, 0)], stored.luma[(0, 47)]);
    assert_eq!(turned.luma[(47, 0)], stored.luma[(0, 0)]);

    let bytes = png(64, 48, &stored_png(), &[(b"eXIf", &exif(3))]);
    let file = PictureFile::open(folder.put("a.png", bytes), &Limits::default()).unwrap();
    assert_eq!((file.size(), file.orientation()), ((64, 48), Some("turned by 180 degrees")));
    assert_eq!(file.decode().unwrap().luma[(63, 47)], 257 * u16::from(texture(0, 0)));

    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut bytes).unwrap();
    let mut image = encoder.new_image::<tiff::encoder::colortype::Gray8>(64, 48).unwrap();
    image.encoder().write_tag(tiff::tags::Tag::Orientation, 3u16).unwrap();
    image.write_data(wide.as_bytes()).unwrap();
    let file = PictureFile::open(folder.put("a.tiff", bytes.into_inner()), &Limits::default()).unwrap();
    assert_eq!((file.size(), file.orientation()), ((64, 48), Some("turned by 180 degrees")));
    assert_eq!(file.decode().unwrap().luma[(63, 0)], 257 * 47);
}

#[test]
fn a_tiff_with_a_palette_is_named_as_such() {
    let folder = Folder::new();
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut bytes).unwrap();
    encoder.write_image::<tiff::encoder::colortype::Gray8>(64, 48, &[7; 64 * 48]).unwrap();
    let mut bytes = bytes.into_inner();
    // The tag of the photometric interpretation: one short, black is zero; a palette is 3.
    let tag = [0x06, 0x01, 0x03, 0x00, 1, 0, 0, 0, 1, 0];
    let at = bytes.windows(tag.len()).position(|window| window == tag).unwrap();
    bytes[at + 8] = 3;
    let refused = Picture::open(folder.put("a.tiff", bytes)).unwrap_err().to_string();
    assert!(
        refused.contains("a TIFF of palette colours; convert it to integers of 8 or 16 bits, grey or RGB"),
        "{refused}"
    );
}

fn stored_png() -> Vec<u8> {
    stored(64, 48, 0)
}

#[test]
fn a_jpeg_is_accepted_only_if_its_scans_are_complete() {
    let folder = Folder::new();
    let rgb = DynamicImage::ImageRgb8(ImageBuffer::from_fn(160, 120, |x, y| Rgb([texture(x, y), x as u8, y as u8])));
    let whole = encoded(&rgb, ImageFormat::Jpeg);
    let luma = Picture::open(folder.put("whole.jpg", &whole)).unwrap().luma;
    // A motion photo has a film after the image, whose bytes may contain markers.
    let film: Vec<u8> = (0..20_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    for after in [&b"\xff\xd8\xff\xda"[..], &film, &whole, &whole[..whole.len() / 2]] {
        let motion = folder.put("motion.jpg", [&whole[..], after].concat());
        assert_eq!(Picture::open(motion).unwrap().luma, luma);
    }
    for part in [2, 3, 4, 10] {
        let half = whole.len() - whole.len() / part;
        let closed = folder.put("half.jpg", [&whole[..half], &[0x12, 0xff, 0xd9]].concat());
        let rejected = Picture::open(closed).unwrap_err().to_string();
        assert!(rejected.contains("cut short"), "{rejected}");
        let rejected = Picture::open(folder.put("open.jpg", &whole[..half])).unwrap_err().to_string();
        assert!(rejected.contains("cut short"), "{rejected}");
    }
}

#[test]
fn samples_above_the_stated_maximum_are_rejected() {
    let folder = Folder::new();
    let pixels = [1, 2, 3, 100, 7, 6];
    for (name, header, samples) in [
        ("binary.pgm", "P5 3 2 100\n", pixels.to_vec()),
        ("text.pgm", "P2 3 2 100\n", b"1 2 3 # the last of the row\n100 7 6\n".to_vec()),
        ("binary.ppm", "P6 2 1 100\n", pixels.to_vec()),
        ("text.ppm", "P3 2 1 100\n", b"1 2 3 100 7 6".to_vec()),
        ("grey.pam", "P7\nWIDTH 3\nHEIGHT 2\nDEPTH 1\nMAXVAL 100\nTUPLTYPE GRAYSCALE\nENDHDR\n", pixels.to_vec()),
    ] {
        let bytes = [header.as_bytes(), &samples].concat();
        let picture = Picture::open(folder.put(name, &bytes)).unwrap_or_else(|error| panic!("{error}"));
        if picture.luma.width() == 3 {
            // 100 of 100 is full scale, 7 of 100 is 18 of 255.
            assert_eq!((picture.luma[(0, 1)], picture.luma[(1, 1)]), (65535, 18 * 257), "{name}");
        }
        let rejected =
            Picture::open(folder.put(
                name,
                String::from_utf8_lossy(&bytes).replacen("100\n", "99\n", 1).replacen("VAL 100", "VAL 99", 1),
            ))
            .unwrap_err()
            .to_string();
        assert!(rejected.contains("100") && rejected.contains("at most 99"), "{name}: {rejected}");
        let cut = folder.put(name, &bytes[..bytes.len() - 2]);
        assert!(Picture::open(cut).unwrap_err().to_string().contains("cut short"), "{name}");
    }
    let wide = [&b"P5 2 1 1000\n"[..], &[0x03, 0xe8, 0x00, 0x01]].concat();
    assert_eq!(Picture::open(folder.put("wide.pgm", wide)).unwrap().luma.as_slice(), [65535, 66]);
    let wide = [&b"P5 2 1 1000\n"[..], &[0x03, 0xe9, 0x00, 0x01]].concat();
    assert!(Picture::open(folder.put("wide.pgm", wide)).unwrap_err().to_string().contains("1001"));
}

#[test]
fn a_huge_picture_is_rejected_by_its_header() {
    let folder = Folder::new();
    let bmp = {
        let mut bytes = encoded(&kinds()[2], ImageFormat::Bmp);
        bytes[18..22].copy_from_slice(&30_000u32.to_le_bytes());
        bytes[22..26].copy_from_slice(&30_000u32.to_le_bytes());
        bytes
    };
    let mut jpeg = encoded(&kinds()[2], ImageFormat::Jpeg);
    let frame = jpeg.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
    jpeg[frame + 5..frame + 9].copy_from_slice(&[0x75, 0x30, 0x75, 0x30]);
    for (name, bytes) in [
        ("a.png", png(30_000, 30_000, &stored(64, 48, 0), &[])),
        ("a.jpg", jpeg),
        ("a.bmp", bmp),
        ("a.pgm", b"P5 30000 30000 255\n12345".to_vec()),
    ] {
        let rejected = Picture::open(folder.put(name, bytes)).unwrap_err();
        assert!(
            matches!(rejected, PictureError::TooManyPixels { width: 30_000, height: 30_000, limit_megapixels: 50, .. }),
            "{rejected}"
        );
        let text = rejected.to_string();
        assert!(text.contains("900.0 megapixels") && text.contains("--max-megapixels"), "{text}");
        assert!(!text.contains("again"), "{text}");
    }
    let small = folder.put("b.pgm", [&b"P5 1200 1000 255\n"[..], &[7; 1_200_000]].concat());
    assert!(matches!(PictureFile::open(&small, &Limits::from_megapixels(1)), Err(PictureError::TooManyPixels { .. })));
    assert!(PictureFile::open(&small, &Limits::from_megapixels(2)).is_ok());
    let small_files = Limits { max_bytes: 1_000_000, ..Limits::default() };
    assert!(matches!(PictureFile::open(&small, &small_files), Err(PictureError::FileTooLarge { .. })));
}

#[test]
fn files_that_are_not_regular_are_rejected_at_once() {
    let folder = Folder::new();
    let fifo = folder.0.path().join("fifo.png");
    assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let started = Instant::now();
    for path in [fifo.as_path(), Path::new("/dev/zero"), Path::new("/dev/urandom"), Path::new("/dev/null")] {
        let rejected = Picture::open(path).unwrap_err();
        assert!(matches!(rejected, PictureError::NotRegularFile { .. }), "{rejected}");
    }
    assert!(started.elapsed() < Duration::from_secs(2));
}

#[test]
fn unsupported_formats_are_named_with_a_remedy() {
    let folder = Folder::new();
    let floats = |size| DynamicImage::ImageRgb32F(ImageBuffer::from_pixel(size, size, Rgb([0.5, 0.25, 1.0])));
    for (name, bytes, what) in [
        ("a.gif", b"GIF89a\x01\0\x01\0\0\0\0;".to_vec(), "GIF"),
        ("a.avif", b"\0\0\0\x20ftypavif\0\0\0\0avifmif1miafMA1B".to_vec(), "AVIF"),
        ("a.heic", b"\0\0\0\x20ftypheic\0\0\0\0mif1heic".to_vec(), "HEIF"),
        ("a.jxl", b"\xff\x0a\xfa\x7f\x01\x90\x08\x06\x01\0".to_vec(), "JPEG XL"),
        ("a.tiff", encoded(&floats(9), ImageFormat::Tiff), "floating-point"),
        ("grey.tiff", grey_float_tiff(), "floating-point"),
    ] {
        let rejected = Picture::open(folder.put(name, bytes)).unwrap_err().to_string();
        assert!(rejected.contains("convert it to") && rejected.contains(what), "{rejected}");
        assert!(!rejected.contains("Unknown") && !rejected.contains("again"), "{rejected}");
    }
}

/// Returns a TIFF of 32-bit floating-point grey pixels, which no picture type of `image` represents.
fn grey_float_tiff() -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut bytes).unwrap();
    encoder.write_image::<tiff::encoder::colortype::Gray32Float>(2, 2, &[0.0, 0.25, 0.5, 1.0]).unwrap();
    bytes.into_inner()
}
