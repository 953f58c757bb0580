//! What an XMP packet says about the photo that is no longer true of the picture made from it, taken out.

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, Writer};

/// Prefixes of edits, depth maps, originals, gain maps and containers: they belong to the photo's file, not to the picture.
const STALE: [&str; 11] = [
    "plenoscope:",
    "xmlns:plenoscope",
    "GDepth:",
    "GImage:",
    "GContainer:",
    "Container:",
    "Item:",
    "Device:",
    "hdrgm:",
    "HDRGainMap:",
    "xmpNote:",
];

/// The packet with orientation 1, without stale parts, and without the position if that is asked for.
/// None if it cannot be read.
pub fn edited(xmp: &[u8], strip_gps: bool) -> Option<Vec<u8>> {
    let text = std::str::from_utf8(xmp).ok()?.trim_end_matches('\0');
    let goes = |name: &str| STALE.iter().any(|p| name.starts_with(p)) || (strip_gps && name.starts_with("exif:GPS"));
    let mut reader = Reader::from_str(text);
    let mut writer = Writer::new(Vec::with_capacity(text.len()));
    let mut skipped = 0usize;
    let mut in_orientation = false;
    loop {
        let event = reader.read_event().ok()?;
        match event {
            Event::Eof => break,
            Event::Start(e) if skipped > 0 || goes(name(&e).as_str()) => {
                drop(e);
                skipped += 1;
            }
            Event::End(_) if skipped > 0 => skipped -= 1,
            _ if skipped > 0 => {}
            Event::Empty(e) if goes(name(&e).as_str()) => {}
            Event::Empty(e) => writer.write_event(Event::Empty(without(&e, &goes)?)).ok()?,
            Event::Start(e) => {
                in_orientation = name(&e) == "tiff:Orientation";
                writer.write_event(Event::Start(without(&e, &goes)?)).ok()?;
            }
            Event::Text(_) if in_orientation => {
                writer.write_event(Event::Text(quick_xml::events::BytesText::new("1"))).ok()?;
            }
            other => {
                in_orientation = false;
                writer.write_event(other).ok()?;
            }
        }
    }
    (skipped == 0).then(|| writer.into_inner())
}

fn name(element: &BytesStart) -> String {
    element.name().as_ref().to_owned()
}

/// The element without the attributes that go, and upright.
fn without(element: &BytesStart, goes: &impl Fn(&str) -> bool) -> Option<BytesStart<'static>> {
    let mut kept = BytesStart::new(name(element));
    for attribute in element.attributes() {
        let attribute = attribute.ok()?;
        let key: &str = attribute.key.as_ref();
        if key == "tiff:Orientation" {
            kept.push_attribute((key, "1"));
        } else if !goes(key) {
            kept.push_attribute(attribute);
        }
    }
    Some(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACKET: &str = r#"<?xpacket begin="" id="W5M0MpCehiHzreSzNTczkc9d"?><x:xmpmeta xmlns:x="adobe:ns:meta/">
<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description tiff:Orientation="6"
 exif:GPSLatitude="48,8N" dc:rights="A &amp; B" GDepth:Data="AAAA" xmpNote:HasExtendedXMP="1234">
<exif:GPSLongitude>2,3E</exif:GPSLongitude><Container:Directory><rdf:Seq><rdf:li/></rdf:Seq></Container:Directory>
<xmp:Rating>5</xmp:Rating></rdf:Description></rdf:RDF></x:xmpmeta><?xpacket end="w"?>"#;

    #[test]
    fn what_is_no_longer_true_goes_and_the_rest_stays() {
        let out = String::from_utf8(edited(PACKET.as_bytes(), true).unwrap()).unwrap();
        for gone in ["GPS", "GDepth", "Container", "HasExtendedXMP"] {
            assert!(!out.contains(gone), "{gone} is still in {out}");
        }
        for kept in ["tiff:Orientation=\"1\"", "A &amp; B", "<xmp:Rating>5</xmp:Rating>", "<?xpacket end"] {
            assert!(out.contains(kept), "{kept} is not in {out}");
        }
    }

    #[test]
    fn the_position_stays_where_it_is_not_asked_to_go() {
        let out = String::from_utf8(edited(PACKET.as_bytes(), false).unwrap()).unwrap();
        assert!(out.contains("exif:GPSLatitude") && out.contains("2,3E"));
    }

    #[test]
    fn a_broken_packet_is_refused() {
        assert!(edited(b"<a><b></a>", true).is_none());
        assert!(edited(&[0xff, 0xfe, 0], true).is_none());
    }
}
