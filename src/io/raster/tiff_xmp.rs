//! The XMP packet of a TIFF, however long it is: the decoder's limit on values follows the picture's size.

/// The tag of the packet.
const XMP: u64 = 700;
/// Types of bytes that nothing else is known of: BYTE and UNDEFINED.
const BYTES: [u64; 2] = [1, 7];

/// The packet in the first directory of a TIFF, of 32 or of 64 bits.
pub(super) fn packet(tiff: &[u8]) -> Option<&[u8]> {
    let is_little = match tiff.get(..2)? {
        b"II" => true,
        b"MM" => false,
        _ => return None,
    };
    let number = |at: u64, bytes: u64| {
        let at = usize::try_from(at).ok()?;
        let part = tiff.get(at..at.checked_add(bytes as usize)?)?;
        let join = |all: u64, byte: &u8| all << 8 | u64::from(*byte);
        Some(if is_little { part.iter().rev().fold(0, join) } else { part.iter().fold(0, join) })
    };
    // Bytes of an offset, of the count of entries, and of an entry.
    let (offset, entries, entry) = match number(2, 2)? {
        42 => (4, 2, 12),
        43 => (8, 8, 20),
        _ => return None,
    };
    let directory = number(offset, offset)?;
    let count = number(directory, entries)?.min(tiff.len() as u64 / entry);
    let first = directory + entries;
    let found = (0..count).map(|n| first + n * entry).find(|at| number(*at, 2) == Some(XMP))?;
    let length = number(found + 4, offset).filter(|length| *length > offset)?;
    let start =
        number(found + 4 + offset, offset).filter(|_| number(found + 2, 2).is_some_and(|of| BYTES.contains(&of)))?;
    tiff.get(usize::try_from(start).ok()?..usize::try_from(start.checked_add(length)?).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packet_is_found_and_offsets_beyond_the_file_are_none() {
        let mut tiff = b"MM\0\x2a\0\0\0\x08\0\x01\x02\xbc\0\x01\0\0\0\x06\0\0\0\x1a\0\0\0\0<x/>  ".to_vec();
        assert_eq!(packet(&tiff), Some(&b"<x/>  "[..]));
        for cut in 0..tiff.len() {
            assert_eq!(packet(&tiff[..cut]), None, "cut at {cut}");
        }
        tiff[4..8].fill(0xff);
        assert_eq!(packet(&tiff), None);
    }
}
