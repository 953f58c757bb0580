//! What a picture takes along of how it was made: properties of its XMP, and the segments of a JPEG that hold them.
//!
//! Our properties have a namespace of their own; depth is GDepth, which other programs read. What is too large for one
//! segment of a JPEG goes into the extended packet (XMP specification, part 3, 1.1.3.1).

use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::{Format, gdepth};
use crate::field::DisparityMap;
use crate::io::carried::{self, PhotoTag};
use crate::markup::escaped;

/// Longest content of a segment of a JPEG.
pub(super) const SEGMENT_BYTES: usize = 65_533;
/// Longest piece of extended XMP in one segment.
const CHUNK_BYTES: usize = 65_400;
const XMP: &[u8] = b"http://ns.adobe.com/xap/1.0/\0";
const EXTENDED_XMP: &[u8] = b"http://ns.adobe.com/xmp/extension/\0";
/// A GUID as long as all are.
const ANY_GUID: &str = "00000000000000000000000000000000";

/// What a picture takes along of how it was made.
#[derive(Clone, Debug, Default)]
pub struct Carry {
    /// The recipe, JSON in one line.
    pub recipe: Option<String>,
    /// Which photo the picture was made of.
    pub photo: Option<PhotoTag>,
    /// That photo's file.
    pub file: Option<Arc<[u8]>>,
    /// The disparity of what the picture shows, stretched to it.
    pub depth: Option<Arc<DisparityMap>>,
}

/// A namespace that is written: its prefix and its address.
type Space = (&'static str, &'static str);
/// This program's own.
const OWN: Space = ("plenoscope", carried::NAMESPACE);
const DEPTH: Space = ("GDepth", "http://ns.google.com/photos/1.0/depthmap/");
const NOTE: Space = ("xmpNote", "http://ns.adobe.com/xmp/note/");

/// One property: its namespace, its name and its value.
type Property = (Space, &'static str, String);

/// The properties by where they may stand.
struct Sorted {
    /// In the main packet.
    small: Vec<Property>,
    /// There too, where it fits.
    recipe: Option<Property>,
    /// Wherever there is room.
    large: Vec<Property>,
}

impl Carry {
    fn is_empty(&self) -> bool {
        self.recipe.is_none() && self.photo.is_none() && self.file.is_none() && self.depth.is_none()
    }

    /// The XMP as a file of a format holds it, with what the photo says: the contents of a JPEG's segments, else at most
    /// one packet.
    ///
    /// # Errors
    /// The map's encoder's.
    pub(super) fn blocks(&self, photos: Option<&str>, format: Format) -> std::io::Result<Vec<Vec<u8>>> {
        Ok(match (photos, format) {
            (None, _) if self.is_empty() => Vec::new(),
            (Some(photos), Format::Jpeg) if self.is_empty() => segment(photos).into_iter().collect(),
            (Some(photos), _) if self.is_empty() => vec![photos.as_bytes().to_vec()],
            (_, Format::Jpeg) => self.segments(photos)?,
            (..) => vec![self.packet(photos)?.into_bytes()],
        })
    }

    /// One packet with everything, for files whose XMP may be of any length.
    fn packet(&self, photos: Option<&str>) -> std::io::Result<String> {
        let Sorted { small, recipe, large } = self.sorted()?;
        Ok(packet(photos, small.iter().chain(&recipe).chain(&large)))
    }

    /// The contents of a JPEG's segments (APP1).
    ///
    /// # Errors
    /// The map's encoder's.
    pub(crate) fn segments(&self, photos: Option<&str>) -> std::io::Result<Vec<Vec<u8>>> {
        let Sorted { mut small, recipe, mut large } = self.sorted()?;
        let note = |guid: &str| (NOTE, "HasExtendedXMP", guid.to_owned());
        let fits = |photos, small: &[Property], recipe: &Option<Property>| {
            let longest = packet(photos, small.iter().chain(recipe).chain(&[note(ANY_GUID)]));
            XMP.len() + longest.len() <= SEGMENT_BYTES
        };
        // A packet of the photo's that leaves no room stays out: without ours the way back would be lost.
        let photos = photos.filter(|_| fits(photos, &small, &None));
        if fits(photos, &small, &recipe) {
            small.extend(recipe);
        } else {
            large.extend(recipe);
        }
        let extended = if large.is_empty() { String::new() } else { packet(None, &large) };
        let guid = format!("{:X}", md5::compute(extended.as_bytes()));
        if !large.is_empty() {
            small.push(note(&guid));
        }
        let main = segment(&packet(photos, &small));
        let length = (extended.len() as u32).to_be_bytes();
        let chunk = |(n, data): (usize, &[u8])| {
            let offset = ((n * CHUNK_BYTES) as u32).to_be_bytes();
            [EXTENDED_XMP, guid.as_bytes(), &length, &offset, data].concat()
        };
        Ok(main.into_iter().chain(extended.as_bytes().chunks(CHUNK_BYTES).enumerate().map(chunk)).collect())
    }

    fn sorted(&self) -> std::io::Result<Sorted> {
        let (mut small, mut large) = (Vec::new(), Vec::new());
        let Self { recipe, photo, file, depth } = self;
        if recipe.is_some() || file.is_some() {
            small.push((OWN, "Version", carried::VERSION.to_string()));
        }
        if let Some(PhotoTag { name, sha256, bytes }) = photo {
            small.push((OWN, carried::PHOTO_NAME, name.clone()));
            small.push((OWN, carried::PHOTO_SHA256, sha256.clone()));
            small.push((OWN, carried::PHOTO_BYTES, bytes.to_string()));
        }
        if let Some(depth) = depth {
            small.extend(gdepth::HEAD.map(|(name, value)| (DEPTH, name, value.to_owned())));
            large.push((DEPTH, "Data", STANDARD.encode(gdepth::png(depth)?)));
        }
        large.extend(file.as_ref().map(|file| (OWN, carried::PHOTO, STANDARD.encode(file))));
        let recipe = recipe.as_ref().map(|text| (OWN, carried::RECIPE, text.clone()));
        Ok(Sorted { small, recipe, large })
    }
}

/// The content of the segment that holds a packet, where it fits.
pub(super) fn segment(packet: &str) -> Option<Vec<u8>> {
    Some([XMP, packet.as_bytes()].concat()).filter(|segment| segment.len() <= SEGMENT_BYTES)
}

/// A packet of these properties, within the photo's own where it has one that can take them.
fn packet<'a>(photos: Option<&str>, properties: impl IntoIterator<Item = &'a Property>) -> String {
    let (mut spaces, mut values) = (Vec::new(), String::new());
    for (space, name, value) in properties {
        if !spaces.contains(space) {
            spaces.push(*space);
        }
        values.push_str(&format!(" {}:{name}=\"{}\"", space.0, escaped(value)));
    }
    let spaces: String = spaces.iter().map(|(prefix, address)| format!(" xmlns:{prefix}=\"{address}\"")).collect();
    let rdf = "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\"";
    let ours = format!("<rdf:Description {rdf} rdf:about=\"\"{spaces}{values}/>");
    let end = photos.and_then(|text| Some((text, text.rfind(":RDF>").and_then(|at| text[..at].rfind("</"))?)));
    match end {
        Some((text, end)) => [&text[..end], &ours, &text[end..]].concat(),
        None => format!("<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF {rdf}>{ours}</rdf:RDF></x:xmpmeta>"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PHOTOS: &str = r#"<?xpacket begin=""?><x:xmpmeta xmlns:x="adobe:ns:meta/"><q:RDF xmlns:q="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><q:Description q:about="" xmlns:dc="http://purl.org/dc/elements/1.1/" dc:rights="mine"/></q:RDF></x:xmpmeta><?xpacket end="w"?>"#;

    fn carry(recipe: &str) -> Carry {
        let photo = PhotoTag { name: "a \"b\".jpg".to_owned(), sha256: "0".repeat(64), bytes: 5 };
        Carry { recipe: Some(recipe.to_owned()), photo: Some(photo), ..Carry::default() }
    }

    #[test]
    fn the_photos_own_words_stay_beside_ours() {
        let text = carry(r#"{"a": "<&>"}"#).packet(Some(PHOTOS)).unwrap();
        let at = |what: &str| text.find(what).unwrap_or_else(|| panic!("{what} is not in {text}"));
        assert!(at("dc:rights=\"mine\"") < at("plenoscope:Recipe=\"{&quot;a&quot;: &quot;&lt;&amp;&gt;&quot;}\""));
        assert!(at("plenoscope:PhotoName=\"a &quot;b&quot;.jpg\"") < at("</q:RDF>") && text.ends_with("end=\"w\"?>"));
    }

    #[test]
    fn no_segment_is_too_long_whatever_goes_along() {
        let long = "x".repeat(70_000);
        let photos = format!("{PHOTOS}{}", " ".repeat(65_000));
        let file: Arc<[u8]> = vec![7; 200_000].into();
        for (recipe, file, photos, segments) in [
            ("{}", None, None, 1),
            ("{}", None, Some(PHOTOS), 1),
            (&*long, None, Some(PHOTOS), 3),
            (&*long, Some(file), Some(&*photos), 7),
        ] {
            let made = Carry { file, ..carry(recipe) }.segments(photos).unwrap();
            assert_eq!(made.len(), segments);
            assert!(made.iter().all(|segment| segment.len() <= SEGMENT_BYTES));
            assert_eq!(made.len() > 1, String::from_utf8_lossy(&made[0]).contains("HasExtendedXMP"));
        }
    }
}
