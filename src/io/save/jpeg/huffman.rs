//! Huffman tables of a JPEG: read, made for counts of symbols, and written (T.81, annexes B, C and K).

/// Tables of a picture: for the constant and for the other values of luma, then of chroma.
pub(super) const TABLES: usize = 4;
/// The longest code.
const MOST_BITS: usize = 16;
/// The classes and numbers of the tables, as the segments name them.
const NUMBERS: [u8; TABLES] = [0x00, 0x10, 0x01, 0x11];

/// How often each symbol of each table occurs.
pub(super) struct Counts([[u32; 256]; TABLES]);

impl Default for Counts {
    fn default() -> Self {
        Self([[0; 256]; TABLES])
    }
}

impl Counts {
    #[inline]
    pub(super) fn add(&mut self, table: usize, symbol: u8) {
        self.0[table][usize::from(symbol)] += 1;
    }

    pub(super) fn plus(mut self, other: Self) -> Self {
        self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened()).for_each(|(a, b)| *a += b);
        self
    }

    /// The tables with which they take the fewest bits.
    pub(super) fn tables(&self) -> [Table; TABLES] {
        self.0.each_ref().map(Table::best)
    }
}

/// A table: how many codes there are of each length, and the symbols in the order of their codes.
pub(super) struct Table {
    lengths: [u8; MOST_BITS],
    symbols: Vec<u8>,
    /// Code and its length of each symbol.
    codes: [(u16, u8); 256],
    /// The symbol and the length of its code, for each 16 bits that begin with it; length 0: none does.
    found: Vec<(u8, u8)>,
}

impl Table {
    fn new(lengths: [u8; MOST_BITS], symbols: Vec<u8>) -> Self {
        let mut codes = [(0, 0); 256];
        let mut found = vec![(0, 0); 1 << MOST_BITS];
        let mut left = symbols.iter();
        let mut code = 0usize;
        for (bits, count) in (1..).zip(lengths) {
            for &symbol in left.by_ref().take(count.into()) {
                codes[usize::from(symbol)] = (code as u16, bits as u8);
                let first = code << (MOST_BITS - bits);
                if let Some(found) = found.get_mut(first..first + (1 << (MOST_BITS - bits))) {
                    found.fill((symbol, bits as u8));
                }
                code += 1;
            }
            code <<= 1;
        }
        Self { lengths, symbols, codes, found }
    }

    /// The table of a segment's content, and its place among [`TABLES`].
    pub(super) fn read(content: &[u8]) -> Option<(usize, Self)> {
        let (number, rest) = content.split_first()?;
        let (lengths, symbols) = rest.split_first_chunk::<MOST_BITS>()?;
        Some((NUMBERS.iter().position(|n| n == number)?, Self::new(*lengths, symbols.to_vec())))
    }

    /// Its segment, with the marker.
    pub(super) fn segment(&self, place: usize) -> Vec<u8> {
        let length = (2 + 1 + MOST_BITS + self.symbols.len()) as u16;
        [&[0xFF, super::HUFFMAN], &length.to_be_bytes()[..], &[NUMBERS[place]], &self.lengths, &self.symbols].concat()
    }

    #[inline]
    pub(super) fn code(&self, symbol: u8) -> (u16, u8) {
        self.codes[usize::from(symbol)]
    }

    /// The symbol that 16 bits begin with, and the length of its code.
    #[inline]
    pub(super) fn symbol(&self, bits: u16) -> (u8, u8) {
        self.found[usize::from(bits)]
    }

    /// The table with which symbols of these counts take the fewest bits (T.81, K.2): Huffman's, of at most 16 bits a
    /// code, and no code of ones alone.
    fn best(counts: &[u32; 256]) -> Self {
        // One symbol more takes the code of ones alone.
        let mut nodes: Vec<(u64, Vec<usize>)> = vec![(1, vec![256])];
        nodes.extend(counts.iter().enumerate().filter(|(_, n)| **n > 0).map(|(i, n)| (u64::from(*n) + 1, vec![i])));
        let mut bits = [0usize; 257];
        while nodes.len() > 1 {
            nodes.sort_by_key(|(count, _)| std::cmp::Reverse(*count));
            let (Some(a), Some(b)) = (nodes.pop(), nodes.pop()) else { break };
            let joined = [a.1, b.1].concat();
            joined.iter().for_each(|&symbol| bits[symbol] += 1);
            nodes.push((a.0 + b.0, joined));
        }
        let lengths = limited(&bits);
        let mut symbols: Vec<usize> = (0..256).filter(|&symbol| bits[symbol] > 0).collect();
        symbols.sort_by_key(|&symbol| bits[symbol]);
        Self::new(lengths, symbols.into_iter().map(|symbol| symbol as u8).collect())
    }
}

/// How many codes of each length there are when none is longer than 16 bits (T.81, figure K.3), without that of ones.
fn limited(bits: &[usize; 257]) -> [u8; MOST_BITS] {
    let mut counts = vec![0usize; 258];
    bits.iter().filter(|bits| **bits > 0).for_each(|&bits| counts[bits] += 1);
    for long in (MOST_BITS + 1..counts.len()).rev() {
        while counts[long] > 0 {
            // Two siblings: one takes their parent's place, the other goes below a shorter code, beside what was there.
            let Some(short) = (1..long - 1).rev().find(|&short| counts[short] > 0) else { break };
            counts[long] -= 2;
            counts[long - 1] += 1;
            counts[short + 1] += 2;
            counts[short] -= 1;
        }
    }
    if let Some(longest) = counts.iter().rposition(|&count| count > 0) {
        counts[longest] -= 1;
    }
    std::array::from_fn(|i| counts[i + 1] as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts that grow as Fibonacci's numbers make the longest codes that there are.
    #[test]
    fn no_code_is_longer_than_16_bits_and_none_begins_another() {
        let mut counts = [0u32; 256];
        let (mut a, mut b) = (1u32, 1u32);
        for count in &mut counts[..40] {
            *count = a;
            (a, b) = (b, a + b);
        }
        let table = Table::best(&counts);
        let used: Vec<(u16, u8)> = (0..40).map(|symbol| table.code(symbol)).collect();
        assert!(used.iter().all(|(_, bits)| (1..=16).contains(bits)));
        let share: f64 = used.iter().map(|(_, bits)| 0.5f64.powi((*bits).into())).sum();
        assert!(share < 1.0, "the code of ones alone is free: {share}");
        for symbol in 0..40 {
            let (code, bits) = table.code(symbol);
            assert_eq!(table.symbol(code << (16 - bits)), (symbol, bits));
        }
    }

    #[test]
    fn what_is_frequent_is_short_and_one_symbol_alone_has_a_code() {
        let mut counts = [0u32; 256];
        counts[3] = 1000;
        assert_eq!(Table::best(&counts).code(3).1, 1);
        counts[7] = 10;
        counts[250] = 1;
        let table = Table::best(&counts);
        assert!(table.code(3).1 < table.code(7).1 && table.code(7).1 <= table.code(250).1);
    }
}
