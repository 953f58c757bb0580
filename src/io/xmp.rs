//! XMP packets, flattened: every property with its namespace, its value, and the element that it belongs to.

use std::collections::HashMap;
use std::sync::Arc;

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

/// One property: an attribute, or an element with text.
#[derive(Debug)]
struct Property {
    namespace: Arc<str>,
    name: String,
    value: String,
    /// The element that an attribute stands in, or that encloses a text element.
    owner: usize,
}

/// A flattened packet.
#[derive(Debug, Default)]
pub(crate) struct Xmp {
    properties: Vec<Property>,
}

/// Elements inside one another beyond this are not XMP.
const MAX_DEPTH: usize = 64;
/// Properties beyond this are not a photo's.
const MAX_PROPERTIES: usize = 100_000;

/// An element that is open while the packet is read.
struct Open {
    name: String,
    id: usize,
    text: String,
}

impl Xmp {
    /// Reads a packet. Entities other than XML's own five are not expanded.
    ///
    /// # Errors
    /// Why it is no XML.
    pub(crate) fn parse(packet: &[u8]) -> Result<Self, String> {
        let text = std::str::from_utf8(packet).map_err(|error| format!("its XMP is not UTF-8 ({error})"))?;
        let mut reader = Reader::from_str(text.trim_end_matches('\0'));
        let mut xmp = Self::default();
        let mut prefixes = HashMap::new();
        let mut open: Vec<Open> = Vec::new();
        let mut next_id = 0;
        loop {
            if xmp.properties.len() > MAX_PROPERTIES {
                return Err(format!("its XMP has more than {MAX_PROPERTIES} properties"));
            }
            match reader.read_event().map_err(|error| format!("its XMP is not XML ({error})"))? {
                Event::Start(start) => {
                    next_id += 1;
                    xmp.attributes(&start, next_id, &mut prefixes)?;
                    open.push(Open { name: start.name().0.to_owned(), id: next_id, text: String::new() });
                    if open.len() > MAX_DEPTH {
                        return Err("its XMP is nested too deeply".into());
                    }
                }
                Event::Empty(start) => {
                    next_id += 1;
                    xmp.attributes(&start, next_id, &mut prefixes)?;
                }
                Event::Text(text) => open.last_mut().map(|element| element.text.push_str(&text)).unwrap_or_default(),
                Event::CData(text) => open.last_mut().map(|element| element.text.push_str(&text)).unwrap_or_default(),
                Event::End(_) => {
                    let Some(element) = open.pop() else { continue };
                    if !element.text.trim().is_empty() {
                        let owner = open.last().map_or(0, |parent| parent.id);
                        xmp.push(&element.name, element.text.trim().to_owned(), owner, &prefixes);
                    }
                }
                Event::Eof if open.is_empty() => return Ok(xmp),
                Event::Eof => return Err("its XMP is cut off".into()),
                _ => {}
            }
        }
    }

    fn attributes(
        &mut self,
        start: &BytesStart,
        id: usize,
        prefixes: &mut HashMap<String, Arc<str>>,
    ) -> Result<(), String> {
        let broken = |error: &dyn std::fmt::Display| format!("its XMP is not XML ({error})");
        let mut found = Vec::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|error| broken(&error))?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|error| broken(&error))?;
            match attribute.key.0.strip_prefix("xmlns:") {
                Some(prefix) => {
                    prefixes.insert(prefix.to_owned(), value.into());
                }
                None => found.push((attribute.key.0.to_owned(), value.into_owned())),
            }
        }
        for (name, value) in found {
            self.push(&name, value, id, prefixes);
        }
        Ok(())
    }

    fn push(&mut self, qualified: &str, value: String, owner: usize, prefixes: &HashMap<String, Arc<str>>) {
        let (prefix, name) = qualified.split_once(':').unwrap_or(("", qualified));
        let namespace = prefixes.get(prefix).cloned().unwrap_or_default();
        self.properties.push(Property { namespace, name: name.to_owned(), value, owner });
    }

    /// The first property of a name.
    pub(crate) fn get(&self, namespace: &str, name: &str) -> Option<&str> {
        let found = self.properties.iter().find(|p| p.name == name && &*p.namespace == namespace)?;
        Some(&found.value)
    }

    /// The first property of a name, as a number.
    pub(crate) fn number(&self, namespace: &str, name: &str) -> Option<f32> {
        self.get(namespace, name)?.trim().parse().ok().filter(|n: &f32| n.is_finite())
    }

    /// The first property of a name, decoded from base64.
    pub(crate) fn base64(&self, namespace: &str, name: &str) -> Option<Result<Vec<u8>, String>> {
        let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
        let engine = GeneralPurpose::new(&base64::alphabet::STANDARD, config.with_decode_allow_trailing_bits(true));
        let text: String = self.get(namespace, name)?.chars().filter(|c| !c.is_whitespace()).collect();
        Some(engine.decode(text).map_err(|error| format!("{name} is not base64 ({error})")))
    }

    /// Whether anything of a namespace is there.
    pub(crate) fn has(&self, namespace: &str) -> bool {
        self.properties.iter().any(|p| &*p.namespace == namespace)
    }

    /// The elements that own properties of a namespace, each as its name and value pairs, in file order.
    pub(crate) fn groups(&self, namespace: &str) -> Vec<Vec<(&str, &str)>> {
        let mut groups: Vec<(usize, Vec<(&str, &str)>)> = Vec::new();
        for p in self.properties.iter().filter(|p| &*p.namespace == namespace) {
            match groups.iter_mut().find(|(owner, _)| *owner == p.owner) {
                Some((_, group)) => group.push((&p.name, &p.value)),
                None => groups.push((p.owner, vec![(&p.name, &p.value)])),
            }
        }
        groups.into_iter().map(|(_, group)| group).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ITEM: &str = "http://ns.google.com/photos/dd/1.0/item/";

    fn packet(body: &str) -> String {
        format!(r#"<x:xmpmeta xmlns:x="adobe:ns:meta/"><r xmlns:I="{ITEM}">{body}</r></x:xmpmeta>"#)
    }

    #[test]
    fn attributes_and_elements_say_the_same() {
        for body in [
            r#"<I:a I:Length="7" I:Mime="image/png"/><I:a I:Length="9"/>"#,
            "<a><I:Length>7</I:Length><I:Mime>image/png</I:Mime></a><a><I:Length> 9\n</I:Length></a>",
        ] {
            let xmp = Xmp::parse(packet(body).as_bytes()).unwrap();
            assert_eq!(xmp.groups(ITEM), [vec![("Length", "7"), ("Mime", "image/png")], vec![("Length", "9")]]);
            assert_eq!(xmp.number(ITEM, "Length"), Some(7.0));
        }
    }

    #[test]
    fn what_is_not_xml_is_refused() {
        let whole = packet(r#"<a I:Length="7"/>"#);
        for end in (1..whole.len()).filter(|&end| whole.is_char_boundary(end)) {
            assert!(Xmp::parse(&whole.as_bytes()[..end]).is_err(), "cut at {end}");
        }
        assert!(Xmp::parse(&"<a>".repeat(10_000).into_bytes()).is_err());
        assert!(Xmp::parse(b"\xff\xfe").is_err());
    }
}
