//! What a file is, from its first bytes.

/// The formats that begin with something of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sniffed {
    Jpeg,
    Png,
    WebP,
    Tiff,
    Bmp,
    Gif,
    Pnm,
    Heif,
    Avif,
    Pfm,
    Lfp,
}

impl Sniffed {
    /// The name that people know.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Jpeg => "JPEG",
            Self::Png => "PNG",
            Self::WebP => "WebP",
            Self::Tiff => "TIFF",
            Self::Bmp => "BMP",
            Self::Gif => "GIF",
            Self::Pnm => "PNM",
            Self::Heif => "HEIC",
            Self::Avif => "AVIF",
            Self::Pfm => "PFM",
            Self::Lfp => "Lytro LFP",
        }
    }
}

/// The first bytes of Lytro's container.
pub(crate) const LFP_MAGIC: [u8; 12] = [0x89, b'L', b'F', b'P', 0x0d, 0x0a, 0x1a, 0x0a, 0, 0, 0, 1];

/// The format of some bytes, if it is known.
pub(crate) fn sniff(bytes: &[u8]) -> Option<Sniffed> {
    match bytes {
        [0xff, 0xd8, 0xff, ..] => Some(Sniffed::Jpeg),
        [0x89, b'P', b'N', b'G', ..] => Some(Sniffed::Png),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(Sniffed::WebP),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Some(Sniffed::Tiff),
        [b'B', b'M', ..] => Some(Sniffed::Bmp),
        [b'G', b'I', b'F', b'8', ..] => Some(Sniffed::Gif),
        [b'P', b'f' | b'F', b'\n' | b'\r' | b' ', ..] => Some(Sniffed::Pfm),
        [b'P', b'1'..=b'7', b'\n' | b'\r' | b' ', ..] => Some(Sniffed::Pnm),
        [a, b, c, d, b'f', b't', b'y', b'p', brands @ ..] => {
            let length = u32::from_be_bytes([*a, *b, *c, *d]) as usize;
            sniff_brands(&brands[..brands.len().min(length.saturating_sub(8))])
        }
        _ if bytes.starts_with(&LFP_MAGIC[..4]) => Some(Sniffed::Lfp),
        _ => None,
    }
}

/// The main brand, a version, then all brands; the main one may say only that it is some picture.
fn sniff_brands(brands: &[u8]) -> Option<Sniffed> {
    let (main, others) = (brands.first_chunk()?, brands.get(8..).unwrap_or_default());
    match main {
        b"avif" | b"avis" => Some(Sniffed::Avif),
        b"mif1" | b"mif2" | b"miaf" | b"msf1" if others.as_chunks().0.contains(b"avif") => Some(Sniffed::Avif),
        b"heic" | b"heix" | b"heim" | b"heis" | b"hevc" | b"hevx" | b"mif1" | b"mif2" | b"msf1" => Some(Sniffed::Heif),
        _ => None,
    }
}
