//! Decoders of all formats to luma, by rows or strips if the decoder allows it.

use std::io::{BufRead, Cursor, Read, Seek, SeekFrom};

use image::codecs::{bmp::BmpDecoder, pnm::PnmDecoder, tiff::TiffDecoder, webp::WebPDecoder};
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageError};
use tiff::decoder::{Decoder as Tiff, DecodingResult};
use tiff::tags::Tag;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::luma::{DecodeError, Decoded, Samples, truncated};
use crate::source::Source;
use crate::{Limits, jpeg, pnm};

/// The supported formats, as a remedy in messages.
const SUPPORTED_FORMATS: &str = "PNG, JPEG, TIFF, BMP, PNM or WebP";
/// The supported samples, as a remedy in messages.
const SUPPORTED_SAMPLES: &str = "integers of 8 or 16 bits, grey or RGB";

/// A source of bytes for any decoder.
trait Seekable: BufRead + Seek {}

impl<T: BufRead + Seek> Seekable for T {}

type Reader = Box<dyn Seekable>;

/// A decoder that has read the header of a picture.
pub(super) struct ImageReader {
    width: usize,
    height: usize,
    orientation: Orientation,
    decoder: Decoder,
}

/// The decoder of a format, before it decodes the pixels.
enum Decoder {
    Png(Box<png::Reader<Reader>>),
    /// The whole file.
    Jpeg(Vec<u8>),
    Tiff(Box<Tiff<Reader>>, Strips),
    Pnm(Box<PnmDecoder<Reader>>),
    /// A format that `image` decodes into one buffer.
    Buffered(Box<dyn ImageDecoder>),
}

/// The pixel layout of a TIFF that is read strip by strip.
#[derive(Clone, Copy)]
struct Strips {
    channels: usize,
    bits: u32,
}

impl ImageReader {
    /// Reads the header; the first bytes determine the format.
    pub(super) fn new(source: Source, limits: &Limits) -> Result<Self, DecodeError> {
        let mut reader: Reader = match source {
            Source::File(file) => Box::new(file) as Reader,
            Source::Memory(bytes) => Box::new(bytes),
        };
        let mut first = Vec::new();
        reader.by_ref().take(32).read_to_end(&mut first)?;
        reader.seek(SeekFrom::Start(0))?;
        match first[..] {
            [0x89, b'P', b'N', b'G', ..] => Self::png(reader),
            [0xff, 0xd8, ..] => Self::jpeg(reader),
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Self::tiff(reader, limits),
            [b'P', b'1'..=b'7', ..] => Self::pnm(reader),
            [b'B', b'M', ..] => Self::buffered(Box::new(BmpDecoder::new(reader).map_err(image_error)?)),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => {
                Self::buffered(Box::new(WebPDecoder::new(reader).map_err(image_error)?))
            }
            _ => Err(unsupported_format(&first)),
        }
    }

    /// Returns columns and rows as stored.
    pub(super) fn stored_size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Returns the orientation tag.
    pub(super) fn orientation(&self) -> Orientation {
        self.orientation
    }

    fn png(reader: Reader) -> Result<Self, DecodeError> {
        let mut decoder = png::Decoder::new(reader);
        decoder.set_transformations(png::Transformations::EXPAND);
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        // Otherwise only the chunks are checked, not the pixels.
        decoder.ignore_checksums(false);
        let reader = decoder.read_info().map_err(png_error)?;
        let info = reader.info();
        let exif = info.exif_metadata.as_deref().and_then(Orientation::from_exif_chunk);
        Ok(Self {
            width: info.width as usize,
            height: info.height as usize,
            orientation: exif.unwrap_or(Orientation::NoTransforms),
            decoder: Decoder::Png(Box::new(reader)),
        })
    }

    fn jpeg(mut reader: Reader) -> Result<Self, DecodeError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes)?;
        let header = jpeg::read_header(&bytes).map_err(DecodeError::Damaged)?;
        let exif = header.exif.and_then(|exif| Orientation::from_exif_chunk(&bytes[exif]));
        Ok(Self {
            width: header.width,
            height: header.height,
            orientation: exif.unwrap_or(Orientation::NoTransforms),
            decoder: Decoder::Jpeg(bytes),
        })
    }

    fn tiff(reader: Reader, limits: &Limits) -> Result<Self, DecodeError> {
        // A strip may be the whole picture: RGBA of 16 bits has 8 bytes a pixel.
        let max_bytes = usize::try_from(8 * limits.max_pixels).unwrap_or(usize::MAX);
        let mut within = tiff::decoder::Limits::default();
        (within.decoding_buffer_size, within.intermediate_buffer_size) = (max_bytes, max_bytes);
        let mut tiff = Tiff::new(reader).map_err(tiff_error)?.with_limits(within);
        let (width, height) = tiff.dimensions().map_err(tiff_error)?;
        let colour = tiff.colortype().map_err(tiff_error)?;
        let formats = tiff.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).map_err(tiff_error)?;
        match formats.iter().flatten().find(|&&format| format != 1) {
            Some(3) => {
                return Err(DecodeError::unsupported(
                    "a TIFF of floating-point samples, which have no full scale",
                    SUPPORTED_SAMPLES,
                ));
            }
            Some(2) => {
                return Err(DecodeError::unsupported(
                    "a TIFF of signed samples, which have no full scale",
                    SUPPORTED_SAMPLES,
                ));
            }
            Some(_) => {
                return Err(DecodeError::unsupported(
                    "a TIFF of samples that are no unsigned integers",
                    SUPPORTED_SAMPLES,
                ));
            }
            None => {}
        }
        let orientation = tiff.find_tag_unsigned::<u16>(Tag::Orientation).map_err(tiff_error)?;
        let orientation = orientation.and_then(|value| Orientation::from_exif(value.min(255) as u8));
        let planar = tiff.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).map_err(tiff_error)? == Some(2);
        let striped = tiff.get_chunk_type() == tiff::decoder::ChunkType::Strip;
        use tiff::ColorType::{CMYK, Gray, GrayA, RGB, RGBA};
        let strips = match colour {
            Gray(bits @ (8 | 16)) => Some(Strips { channels: 1, bits: bits.into() }),
            GrayA(bits @ (8 | 16)) => Some(Strips { channels: 2, bits: bits.into() }),
            RGB(bits @ (8 | 16)) => Some(Strips { channels: 3, bits: bits.into() }),
            RGBA(bits @ (8 | 16)) => Some(Strips { channels: 4, bits: bits.into() }),
            Gray(1) | CMYK(8 | 16) => None,
            other => {
                return Err(DecodeError::unsupported(format!("a TIFF of {}", tiff_colour(other)), SUPPORTED_SAMPLES));
            }
        };
        let orientation = orientation.unwrap_or(Orientation::NoTransforms);
        let decoder = match strips {
            Some(strips) if striped && !planar => Decoder::Tiff(Box::new(tiff), strips),
            _ => {
                let reader = std::mem::replace(tiff.inner(), Box::new(Cursor::new(Vec::new())));
                return Ok(Self { orientation, ..Self::buffered(Box::new(rewound(reader)?))? });
            }
        };
        Ok(Self { width: width as usize, height: height as usize, orientation, decoder })
    }

    fn pnm(reader: Reader) -> Result<Self, DecodeError> {
        let decoder = PnmDecoder::new(reader).map_err(image_error)?;
        let bitmap = decoder.header().as_bitmap().is_some();
        if bitmap {
            return Self::buffered(Box::new(decoder));
        }
        let (width, height) = decoder.dimensions();
        Ok(Self {
            width: width as usize,
            height: height as usize,
            orientation: Orientation::NoTransforms,
            decoder: Decoder::Pnm(Box::new(decoder)),
        })
    }

    fn buffered(mut decoder: Box<dyn ImageDecoder>) -> Result<Self, DecodeError> {
        let (width, height) = decoder.dimensions();
        // Unreadable metadata are ignored.
        let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
        Ok(Self { width: width as usize, height: height as usize, orientation, decoder: Decoder::Buffered(decoder) })
    }

    /// Decodes the pixels.
    pub(super) fn decode(self) -> Result<Decoded, DecodeError> {
        let pixels = self.width * self.height;
        match self.decoder {
            Decoder::Png(reader) => decode_png(*reader, pixels),
            Decoder::Jpeg(bytes) => decode_jpeg(&bytes, pixels),
            Decoder::Tiff(tiff, strips) => decode_tiff(*tiff, strips, pixels),
            Decoder::Pnm(decoder) => {
                let (reader, header) = decoder.into_inner();
                pnm::decode(reader, &header)
            }
            Decoder::Buffered(decoder) => decode_buffered(decoder, pixels),
        }
    }
}

/// Starts the TIFF decoder of `image` at the beginning of the file.
fn rewound(mut reader: Reader) -> Result<TiffDecoder<Reader>, DecodeError> {
    reader.seek(SeekFrom::Start(0))?;
    TiffDecoder::new(reader).map_err(image_error)
}

fn decode_png(mut reader: png::Reader<Reader>, pixels: usize) -> Result<Decoded, DecodeError> {
    let (colour, depth) = reader.output_color_type();
    let channels = colour.samples();
    let wide = depth == png::BitDepth::Sixteen;
    let mut decoded = Decoded::with_capacity(pixels, if wide { 16 } else { 8 });
    if reader.info().interlaced {
        // Interlaced pictures have seven passes, so all pixels are kept in memory.
        let size =
            reader.output_buffer_size().ok_or_else(|| DecodeError::damaged("its header has an impossible size"))?;
        let mut bytes = vec![0; size];
        reader.next_frame(&mut bytes).map_err(png_error)?;
        decoded.push(png_samples(&bytes, wide), channels);
    } else {
        while let Some(row) = reader.next_row().map_err(png_error)? {
            decoded.push(png_samples(row.data(), wide), channels);
        }
    }
    // The rest of the data contains the checksum of the pixels.
    reader.finish().map_err(png_error)?;
    Ok(decoded)
}

fn png_samples(bytes: &[u8], wide: bool) -> Samples<'_> {
    if wide { Samples::BigEndian(bytes) } else { Samples::U8(bytes) }
}

fn decode_jpeg(bytes: &[u8], pixels: usize) -> Result<Decoded, DecodeError> {
    let bytes = &bytes[..jpeg::check_complete(bytes).map_err(DecodeError::Damaged)?];
    let options = DecoderOptions::default().set_strict_mode(false).set_max_width(usize::MAX).set_max_height(usize::MAX);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    let damaged = |error: zune_jpeg::errors::DecodeErrors| DecodeError::damaged(one_line(&error.to_string()));
    decoder.decode_headers().map_err(damaged)?;
    let grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let to = if grey { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(decoder.options().jpeg_set_out_colorspace(to));
    let size = decoder.output_buffer_size().ok_or_else(truncated)?;
    let mut samples = vec![0; size];
    decoder.decode_into(&mut samples).map_err(damaged)?;
    drop(decoder);
    let mut decoded = Decoded::with_capacity(pixels, 8);
    decoded.push(Samples::U8(&samples), if grey { 1 } else { 3 });
    Ok(decoded)
}

fn decode_tiff(mut tiff: Tiff<Reader>, strips: Strips, pixels: usize) -> Result<Decoded, DecodeError> {
    let mut decoded = Decoded::with_capacity(pixels, strips.bits);
    for strip in 0..tiff.strip_count().map_err(tiff_error)? {
        match tiff.read_chunk(strip).map_err(tiff_error)? {
            DecodingResult::U8(samples) => decoded.push(Samples::U8(&samples), strips.channels),
            DecodingResult::U16(samples) => decoded.push(Samples::U16(&samples), strips.channels),
            _ => {
                return Err(DecodeError::unsupported(
                    "a TIFF of samples that are no unsigned integers",
                    SUPPORTED_SAMPLES,
                ));
            }
        }
    }
    Ok(decoded)
}

fn decode_buffered(decoder: Box<dyn ImageDecoder>, pixels: usize) -> Result<Decoded, DecodeError> {
    let (channels, wide) = match decoder.color_type() {
        ColorType::L8 => (1, false),
        ColorType::La8 => (2, false),
        ColorType::Rgb8 => (3, false),
        ColorType::Rgba8 => (4, false),
        ColorType::L16 => (1, true),
        ColorType::La16 => (2, true),
        ColorType::Rgb16 => (3, true),
        ColorType::Rgba16 => (4, true),
        _ => {
            return Err(DecodeError::unsupported(
                "a picture of floating-point samples, which have no full scale",
                SUPPORTED_SAMPLES,
            ));
        }
    };
    let mut bytes = vec![0; pixels * channels * if wide { 2 } else { 1 }];
    decoder.read_image_boxed(&mut bytes).map_err(image_error)?;
    let mut decoded = Decoded::with_capacity(pixels, if wide { 16 } else { 8 });
    decoded.push(if wide { Samples::NativeEndian(&bytes) } else { Samples::U8(&bytes) }, channels);
    Ok(decoded)
}

/// Returns the error for the first bytes of a file of a known format that is not decoded, or of an unknown one.
fn unsupported_format(first: &[u8]) -> DecodeError {
    let brand = first.get(4..12).unwrap_or_default();
    match first {
        [b'G', b'I', b'F', b'8', ..] => {
            DecodeError::unsupported("a GIF, which has at most 256 colours", SUPPORTED_FORMATS)
        }
        [0xff, 0x0a, ..] | [0, 0, 0, 12, b'J', b'X', b'L', b' ', ..] => {
            DecodeError::unsupported("a JPEG XL picture", SUPPORTED_FORMATS)
        }
        [0, 0, 0, 12, b'j', b'P', ..] => DecodeError::unsupported("a JPEG 2000 picture", SUPPORTED_FORMATS),
        _ if brand == b"ftypavif" || brand == b"ftypavis" => {
            DecodeError::unsupported("an AVIF picture", SUPPORTED_FORMATS)
        }
        _ if [&b"ftypheic"[..], b"ftypheix", b"ftypmif1", b"ftypmsf1"].contains(&brand) => {
            DecodeError::unsupported("a HEIF picture", SUPPORTED_FORMATS)
        }
        [b'%', b'P', b'D', b'F', ..] => DecodeError::unsupported("a PDF document", SUPPORTED_FORMATS),
        [0x76, 0x2f, 0x31, 0x01, ..] => {
            DecodeError::unsupported("an OpenEXR picture, which has no full scale", SUPPORTED_SAMPLES)
        }
        _ => DecodeError::UnknownFormat,
    }
}

fn png_error(error: png::DecodingError) -> DecodeError {
    match error {
        png::DecodingError::IoError(error) => error.into(),
        png::DecodingError::LimitsExceeded => DecodeError::damaged("its metadata are too large"),
        error => {
            let text = error.to_string();
            let reason = [
                ("CRC error", "the checksum of a chunk is wrong (CRC)"),
                ("WrongChecksum", "the checksum of the pixels is wrong (Adler-32)"),
                ("is invalid after", "a chunk stands where it must not"),
                ("must appear", "a chunk stands where it must not, or twice"),
                ("appeared before", "a chunk stands where it must not"),
                ("Corrupt deflate stream", "the compressed pixels are damaged"),
            ];
            let known = reason.into_iter().find(|(sign, _)| text.contains(sign)).map(|(_, reason)| reason.to_owned());
            DecodeError::Damaged(known.unwrap_or_else(|| one_line(&text)))
        }
    }
}

fn tiff_error(error: tiff::TiffError) -> DecodeError {
    use tiff::TiffUnsupportedError::InterpretationWithBits;
    use tiff::tags::PhotometricInterpretation::{CIELab, RGBPalette};
    match error {
        tiff::TiffError::IoError(error) => error.into(),
        tiff::TiffError::LimitsExceeded => DecodeError::damaged("a strip or a tag is larger than the picture can be"),
        tiff::TiffError::UnsupportedError(InterpretationWithBits(what, _)) => {
            let samples = match what {
                RGBPalette => "palette colours",
                CIELab => "CIE L*a*b* samples",
                _ => "samples that are neither grey nor RGB",
            };
            DecodeError::unsupported(format!("a TIFF of {samples}"), SUPPORTED_SAMPLES)
        }
        tiff::TiffError::UnsupportedError(what) => DecodeError::unsupported(
            format!("a TIFF that is not supported ({})", one_line(&what.to_string())),
            SUPPORTED_FORMATS,
        ),
        error => DecodeError::Damaged(one_line(&error.to_string())),
    }
}

/// Names samples that are not converted to luma.
fn tiff_colour(colour: tiff::ColorType) -> String {
    use tiff::ColorType::{CMYK, CMYKA, Gray, GrayA, Lab, RGB, RGBA, YCbCr};
    match colour {
        YCbCr(_) => "YCbCr samples".into(),
        Lab(_) => "CIE L*a*b* samples".into(),
        Gray(bits) | GrayA(bits) | RGB(bits) | RGBA(bits) | CMYK(bits) | CMYKA(bits) => format!("{bits}-bit samples"),
        _ => "several bands".into(),
    }
}

fn image_error(error: ImageError) -> DecodeError {
    match error {
        ImageError::IoError(error) => error.into(),
        ImageError::Unsupported(what) => DecodeError::unsupported(
            format!("a picture that is not supported ({})", one_line(&what.to_string())),
            SUPPORTED_FORMATS,
        ),
        error => DecodeError::Damaged(one_line(&error.to_string())),
    }
}

/// Shortens the message of a decoder to one line without debug output.
fn one_line(message: &str) -> String {
    let line = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let shown = match line.find(['{', '[']) {
        // The type name before the brace is part of the debug output.
        Some(at) => line[..at].trim_end().trim_end_matches(|c: char| !c.is_whitespace()),
        None => line.as_str(),
    };
    let shown = shown.trim_end_matches(['.', ':', ';', '(']).trim();
    if shown.is_empty() { "its content is damaged".to_owned() } else { shown.to_owned() }
}
