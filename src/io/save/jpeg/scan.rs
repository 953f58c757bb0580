//! The entropy-coded data of a scan: symbol by symbol, and written anew with other tables (T.81, annex F).

use super::huffman::{TABLES, Table};

/// A symbol of a run of 16 zeros.
const ZEROS: u8 = 0xF0;

/// Calls for every symbol of a scan of luma and two chroma blocks in turn: its table, itself, the bits that follow it, and
/// their number.
pub(super) fn each_symbol(
    scan: &[u8],
    blocks: usize,
    tables: &[Table; TABLES],
    mut call: impl FnMut(usize, u8, u32, u8),
) {
    let mut reader = Reader { bytes: scan.iter(), bits: 0, count: 0 };
    for block in 0..blocks {
        let of_component = if block % 3 == 0 { 0 } else { 2 };
        let mut next = |table: usize| {
            let symbol = reader.symbol(&tables[table]);
            let count = symbol & 15;
            call(table, symbol, reader.take(count), count);
            symbol
        };
        next(of_component);
        let mut at = 1;
        while at < 64 {
            let symbol = next(of_component + 1);
            // Without a value behind it: sixteen zeros, or zeros to the end.
            if symbol & 15 == 0 && symbol != ZEROS {
                break;
            }
            at += usize::from(symbol >> 4) + 1;
        }
    }
}

/// The same data with other tables.
pub(super) fn rewritten(scan: &[u8], blocks: usize, tables: &[Table; TABLES], best: &[Table; TABLES]) -> Vec<u8> {
    let mut writer = Writer { bytes: Vec::with_capacity(scan.len()), bits: 0, count: 0 };
    each_symbol(scan, blocks, tables, |table, symbol, value, count| {
        let (code, length) = best[table].code(symbol);
        writer.put(code.into(), length);
        writer.put(value, count);
    });
    writer.finish()
}

/// Bits of a scan.
struct Reader<'a> {
    bytes: std::slice::Iter<'a, u8>,
    /// Those that are read already, from the top.
    bits: u64,
    count: u32,
}

impl Reader<'_> {
    #[inline]
    fn fill(&mut self) {
        while self.count <= 56 {
            // Behind the end there are zeros.
            let byte = self.bytes.next().copied().unwrap_or(0);
            if byte == 0xFF {
                // A zero is put behind it, so that it is no marker.
                self.bytes.next();
            }
            self.bits |= u64::from(byte) << (56 - self.count);
            self.count += 8;
        }
    }

    #[inline]
    fn symbol(&mut self, table: &Table) -> u8 {
        if self.count < 32 {
            self.fill();
        }
        let (symbol, length) = table.symbol((self.bits >> 48) as u16);
        self.skip(length);
        symbol
    }

    /// Up to 15 bits behind a symbol.
    #[inline]
    fn take(&mut self, count: u8) -> u32 {
        let value = ((self.bits >> 48) as u32) >> (16 - u32::from(count));
        self.skip(count);
        value
    }

    #[inline]
    fn skip(&mut self, count: u8) {
        self.bits <<= count;
        self.count -= u32::from(count);
    }
}

/// Bits of a scan to be.
struct Writer {
    bytes: Vec<u8>,
    /// From the top.
    bits: u64,
    count: u32,
}

impl Writer {
    #[inline]
    fn put(&mut self, value: u32, count: u8) {
        // At most 7 bits are left from before, and 16 come.
        if count > 0 {
            self.bits |= u64::from(value) << (64 - self.count - u32::from(count));
            self.count += u32::from(count);
        }
        while self.count >= 8 {
            let byte = (self.bits >> 56) as u8;
            self.bytes.push(byte);
            if byte == 0xFF {
                self.bytes.push(0);
            }
            self.bits <<= 8;
            self.count -= 8;
        }
    }

    /// The last byte is filled up with ones.
    fn finish(mut self) -> Vec<u8> {
        let open = (8 - self.count % 8) % 8;
        self.put((1 << open) - 1, open as u8);
        self.bytes
    }
}
