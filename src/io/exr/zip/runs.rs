//! Deflate that looks for runs of one byte alone, as [RFC 1951] stores them: lengths at distance 1.
//!
//! 20 layers of shape of a render of 1920x1080 become 22.1 %, as by zlib-rs told to look for runs alone, at 2.8 times
//! its speed: whether a run begins is found for many bytes at a time, and bytes outside runs are counted and coded in
//! loops that do nothing else.
//!
//! [RFC 1951]: https://www.rfc-editor.org/rfc/rfc1951

use super::sized;
use zlib_rs::adler32::adler32;

/// Bytes that share a code. For half as many the code takes its time twice; with twice as many it fits less well.
const SEGMENT: usize = 1 << 16;
/// Bits of the longest code of a byte or length, so that four codes and a rest fit into a word. It may have 15; 12 lose
/// less than a thousandth.
const MOST_BITS: usize = 12;
/// Bits of the longest code of a code's length.
const MOST_LENGTH_BITS: usize = 7;

/// Symbols: bytes, the end of a segment, and classes of lengths.
const SYMBOLS: usize = 286;
const END: usize = 256;
const FIRST_LENGTH: usize = 257;
/// The shortest run that has a length, and the longest.
const LEAST_RUN: usize = 3;
const MOST_RUN: usize = 258;

/// Symbols that tell the lengths of codes: a length, repeats of the last, or zeros.
const LENGTH_SYMBOLS: usize = 19;
const SAME: usize = 16;
const FEW_ZEROS: usize = 17;
const MANY_ZEROS: usize = 18;
/// The order in which the lengths of their own codes come.
const LENGTH_ORDER: [usize; LENGTH_SYMBOLS] = [
    16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15,
];

/// Compressor with its working memory.
#[derive(Default)]
pub(super) struct Runs {
    /// Whether four equal bytes begin at each of a segment.
    equal: Vec<u8>,
    /// Bytes as they are, and how often the last of them is repeated then.
    stretches: Vec<(usize, usize)>,
}

impl Runs {
    /// Compresses `bytes` into `into`, as zlib does; returns the number of compressed bytes, `None` if they do not fit.
    pub(super) fn deflate(&mut self, bytes: &[u8], into: &mut [u8]) -> Option<usize> {
        let mut bits = Bits::new(into);
        // zlib's header: deflate, a window of 32 KiB, quick.
        bits.put(0x78, 8);
        bits.put(0x01, 8);
        let segments = bytes.chunks(SEGMENT);
        let last = segments.len().checked_sub(1)?;
        for (i, segment) in segments.enumerate() {
            self.put_segment(segment, i == last, &mut bits)?;
        }
        bits.finish(&adler32(1, bytes).to_be_bytes())
    }

    fn put_segment(&mut self, bytes: &[u8], is_last: bool, bits: &mut Bits) -> Option<()> {
        let lengths = code_lengths(&self.counts(bytes), MOST_BITS);
        let codes = codes(&lengths);
        bits.put(u64::from(is_last), 1);
        bits.put(2, 2); // with codes of its own
        put_code_lengths(&lengths, bits)?;
        let byte_codes: &[Code; 256] = codes.first_chunk().expect("there are more in all");
        let mut rest = bytes;
        for &(plain, repeats) in &self.stretches {
            let (fours, few) = rest[..plain].as_chunks::<4>();
            for four in fours {
                for &byte in four {
                    bits.put_code(byte_codes[usize::from(byte)]);
                }
                bits.flush()?;
            }
            for &byte in few {
                bits.put_code(byte_codes[usize::from(byte)]);
            }
            bits.flush()?;
            for run in runs_of(repeats) {
                let class = LengthClass::of(run);
                bits.put_code(codes[class.symbol]);
                bits.put(class.rest, class.rest_bits);
                bits.put(0, 1); // the only distance
                bits.flush()?;
            }
            rest = &rest[plain + repeats..];
        }
        bits.put_code(codes[END]);
        bits.flush()
    }

    /// Divides a segment into stretches; returns how often each symbol occurs.
    fn counts(&mut self, bytes: &[u8]) -> [u32; SYMBOLS] {
        // A word beyond the last, so that words can be read anywhere.
        let equal = sized(&mut self.equal, bytes.len() + 8);
        let marked = mark_equal(bytes, equal);
        equal[marked..].fill(0);
        self.stretches.clear();
        // Neighbours are counted apart, so that equal ones need not wait for each other.
        let mut counts = [[0; SYMBOLS]; 2];
        let [even, odd] = &mut counts;
        let mut rest = bytes;
        while !rest.is_empty() {
            let at = bytes.len() - rest.len();
            // The first of four equal bytes is no repeat.
            let (plain, repeats) = match next_marked(&equal[at..]) {
                Some(first) => (first + 1, run_length(&rest[first..]) - 1),
                None => (rest.len(), 0),
            };
            let (pairs, single) = rest[..plain].as_chunks::<2>();
            for &[first, second] in pairs {
                even[usize::from(first)] += 1;
                odd[usize::from(second)] += 1;
            }
            for &byte in single {
                even[usize::from(byte)] += 1;
            }
            for run in runs_of(repeats) {
                even[LengthClass::of(run).symbol] += 1;
            }
            self.stretches.push((plain, repeats));
            rest = &rest[plain + repeats..];
        }
        even[END] = 1;
        std::array::from_fn(|symbol| even[symbol] + odd[symbol])
    }
}

/// Marks with 1 where four equal bytes begin, the shortest run that is worth a length after its first byte, and others
/// with 0; returns how many are marked, of which there are three less.
fn mark_equal(bytes: &[u8], marks: &mut [u8]) -> usize {
    let count = bytes.len().saturating_sub(LEAST_RUN);
    if count > 0 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|by| &bytes[by..][..count]);
        let marks = &mut marks[..count];
        for i in 0..count {
            let differ = (a[i] ^ b[i]) | (b[i] ^ c[i]) | (c[i] ^ d[i]);
            marks[i] = u8::from(differ == 0);
        }
    }
    count
}

/// The first place that is marked.
fn next_marked(marks: &[u8]) -> Option<usize> {
    let (words, _) = marks.as_chunks::<8>();
    let words = words.iter().map(|&word| u64::from_le_bytes(word));
    let (number, word) = words.enumerate().find(|&(_, word)| word != 0)?;
    Some(8 * number + word.trailing_zeros() as usize / 8)
}

/// How many bytes equal the first.
fn run_length(bytes: &[u8]) -> usize {
    let first = bytes[0];
    let (words, _) = bytes.as_chunks::<8>();
    let equal = words.iter().take_while(|&&word| word == [first; 8]).count();
    let rest = bytes[8 * equal..].iter();
    8 * equal + rest.take_while(|&&byte| byte == first).count()
}

/// Repeats of a byte, divided into runs that have a length: none, or three at least.
fn runs_of(repeats: usize) -> impl Iterator<Item = usize> {
    let mut left = repeats;
    std::iter::from_fn(move || {
        let run = match left {
            0 => return None,
            1..=MOST_RUN => left,
            // Leaves enough for another.
            _ => MOST_RUN.min(left - LEAST_RUN),
        };
        left -= run;
        Some(run)
    })
}

/// A length: the symbol of its class, and its place in the class.
struct LengthClass {
    symbol: usize,
    rest: u64,
    rest_bits: u32,
}

impl LengthClass {
    /// The class of a length from 3 to 258: up to 10 each its own, then four classes for each number of further bits; the
    /// last has its own again.
    fn of(length: usize) -> Self {
        let more = length - LEAST_RUN;
        let rest_bits = match more {
            0..8 => 0,
            255 => {
                return Self {
                    symbol: SYMBOLS - 1,
                    rest: 0,
                    rest_bits: 0,
                };
            }
            _ => more.ilog2() - 2,
        };
        Self {
            symbol: FIRST_LENGTH + 4 * rest_bits as usize + (more >> rest_bits),
            rest: more as u64 & ((1 << rest_bits) - 1),
            rest_bits,
        }
    }
}

/// Bits of a code, the first one lowest, and their number.
#[derive(Clone, Copy, Default)]
struct Code {
    bits: u16,
    count: u8,
}

/// Lengths of the codes of symbols that occur so often, at most so long and otherwise the best ones; 0 for those that do
/// not occur. At least two must.
fn code_lengths<const N: usize>(counts: &[u32; N], most: usize) -> [u8; N] {
    let mut symbols: Vec<(u32, usize)> = counts.iter().copied().zip(0..N).collect();
    symbols.retain(|&(count, _)| count > 0);
    symbols.sort_unstable();
    // Huffman's tree: the two rarest become one, again and again. Those made are rarer than later ones, so both queues
    // are sorted: symbols, and behind them the nodes made of two.
    let leaves = symbols.len();
    let nodes = 2 * leaves - 1;
    let mut weights: Vec<u32> = symbols.iter().map(|&(count, _)| count).collect();
    let mut parents = vec![0; nodes];
    let (mut leaf, mut inner) = (0, leaves);
    for made in leaves..nodes {
        let mut weight = 0;
        for _ in 0..2 {
            let takes_leaf = leaf < leaves && (inner == made || weights[leaf] <= weights[inner]);
            let next = if takes_leaf { &mut leaf } else { &mut inner };
            weight += weights[*next];
            parents[*next] = made;
            *next += 1;
        }
        weights.push(weight);
    }
    // Depths in the tree are lengths of codes: how many there are of each, none longer than allowed.
    let mut depths = vec![0; nodes];
    let mut of_length = vec![0; most + 1];
    for node in (0..nodes - 1).rev() {
        depths[node] = depths[parents[node]] + 1;
        if node < leaves {
            of_length[depths[node].min(most)] += 1;
        }
    }
    // Shortened codes take more room than there is: one of them goes beside the longest of the others, made longer.
    let room: usize = (1..=most).map(|l| of_length[l] << (most - l)).sum();
    for _ in 1 << most..room {
        let longest = (1..most).rev().find(|&l| of_length[l] > 0);
        let longest = longest.expect("there are fewer symbols than codes");
        of_length[most] -= 1;
        of_length[longest] -= 1;
        of_length[longest + 1] += 2;
    }
    let mut lengths = [0; N];
    let rarest_first = (1..=most)
        .rev()
        .flat_map(|l| (0..of_length[l]).map(move |_| l));
    for ((_, symbol), length) in symbols.into_iter().zip(rarest_first) {
        lengths[symbol] = length as u8;
    }
    lengths
}

/// The codes of these lengths: numbers in the order of lengths, then of symbols, the highest bit first.
fn codes<const N: usize>(lengths: &[u8; N]) -> [Code; N] {
    let mut of_length = [0; 16];
    for &length in lengths.iter().filter(|&&length| length > 0) {
        of_length[usize::from(length)] += 1;
    }
    let mut next = [0_u16; 16];
    for length in 1..16 {
        next[length] = (next[length - 1] + of_length[length - 1]) << 1;
    }
    lengths.map(|count| {
        let next = &mut next[usize::from(count)];
        let bits = next.reverse_bits().unbounded_shr(16 - u32::from(count));
        *next += 1;
        Code { bits, count }
    })
}

/// Writes the lengths of a segment's codes, and that of its only distance, in a code of their own.
fn put_code_lengths(lengths: &[u8; SYMBOLS], bits: &mut Bits) -> Option<()> {
    let used = lengths.iter().rposition(|&l| l > 0)? + 1;
    let told = told_lengths(&[&lengths[..used], &[1]].concat());
    let mut counts = [0; LENGTH_SYMBOLS];
    told.iter().for_each(|&(symbol, ..)| counts[symbol] += 1);
    let own = code_lengths(&counts, MOST_LENGTH_BITS);
    let codes = codes(&own);
    let kept = LENGTH_ORDER.iter().rposition(|&symbol| own[symbol] > 0)? + 1;
    bits.put((used - FIRST_LENGTH) as u64, 5);
    bits.put(0, 5);
    bits.put(kept as u64 - 4, 4);
    for &symbol in &LENGTH_ORDER[..kept] {
        bits.put(own[symbol].into(), 3);
        bits.flush()?;
    }
    for (symbol, rest, rest_bits) in told {
        bits.put_code(codes[symbol]);
        bits.put(rest, rest_bits);
        bits.flush()?;
    }
    Some(())
}

/// Lengths of codes as symbols, each with further bits and their number.
fn told_lengths(lengths: &[u8]) -> Vec<(usize, u64, u32)> {
    let mut told = Vec::new();
    for equal in lengths.chunk_by(|a, b| a == b) {
        let length = usize::from(equal[0]);
        let mut left = equal.len();
        // Symbols for so many repeats, and their further bits.
        let repeats = match length {
            0 => [(MANY_ZEROS, 11..=138, 7), (FEW_ZEROS, 3..=10, 3)],
            _ => {
                told.push((length, 0, 0));
                left -= 1;
                [(SAME, 3..=6, 2), (SAME, 3..=6, 2)]
            }
        };
        for (symbol, counts, rest_bits) in repeats {
            while left >= *counts.start() {
                let count = left.min(*counts.end());
                told.push((symbol, (count - counts.start()) as u64, rest_bits));
                left -= count;
            }
        }
        told.extend(std::iter::repeat_n((length, 0, 0), left));
    }
    told
}

/// Bits written one after the other, the first one lowest.
struct Bits<'b> {
    into: &'b mut [u8],
    /// Bytes that are written.
    written: usize,
    /// Bits that are not, and their number.
    held: u64,
    count: u32,
}

impl<'b> Bits<'b> {
    fn new(into: &'b mut [u8]) -> Self {
        Self {
            into,
            written: 0,
            held: 0,
            count: 0,
        }
    }

    /// Adds bits; with those held since the last flush they must be 64 at most.
    #[inline(always)]
    fn put(&mut self, bits: u64, count: u32) {
        self.held |= bits << self.count;
        self.count += count;
    }

    #[inline(always)]
    fn put_code(&mut self, code: Code) {
        self.put(code.bits.into(), code.count.into());
    }

    /// Writes the bits held, but for the last up to seven; `None` if there is no room for a word.
    #[inline(always)]
    fn flush(&mut self) -> Option<()> {
        let word = self.into.get_mut(self.written..)?.first_chunk_mut()?;
        *word = self.held.to_le_bytes();
        self.written += self.count as usize / 8;
        self.held >>= self.count & !7;
        self.count %= 8;
        Some(())
    }

    /// Fills the last byte, and adds these; returns the number of all.
    fn finish(mut self, last: &[u8; 4]) -> Option<usize> {
        self.count = self.count.next_multiple_of(8);
        self.put(u32::from_le_bytes(*last).into(), 32);
        self.flush()?;
        Some(self.written)
    }
}

#[cfg(test)]
mod tests {
    use super::super::inflate;
    use super::*;

    /// Compresses and decompresses; returns the compressed size.
    fn round_trip(bytes: &[u8]) -> usize {
        let mut into = vec![0; 2 * bytes.len() + 400];
        let size = Runs::default().deflate(bytes, &mut into).unwrap();
        let mut back = vec![0; bytes.len()];
        inflate(&into[..size], &mut back).unwrap();
        assert!(back == bytes, "{} bytes", bytes.len());
        size
    }

    #[test]
    fn runs_of_every_length_come_back() {
        for length in 1..=600 {
            let runs = [vec![7; length], vec![8], vec![9; length]].concat();
            round_trip(&runs);
            round_trip(&runs[..length]);
        }
        // Across segments, and up to the last byte of one.
        for length in [SEGMENT - 3, SEGMENT, SEGMENT + 1, 3 * SEGMENT + 2] {
            // A code of two bits at most for 258 bytes each, and less than 200 bytes for the codes of a segment.
            let size = round_trip(&vec![200; length]);
            assert!(
                size < length / 258 + 200 * length.div_ceil(SEGMENT),
                "{size}"
            );
        }
    }

    #[test]
    fn lengths_have_the_classes_of_the_standard() {
        // From its table: the first of each class, and the last.
        for (length, symbol, rest, rest_bits) in [
            (3, 257, 0, 0),
            (10, 264, 0, 0),
            (11, 265, 0, 1),
            (12, 265, 1, 1),
            (34, 272, 3, 2),
            (35, 273, 0, 3),
            (227, 284, 0, 5),
            (257, 284, 30, 5),
            (258, 285, 0, 0),
        ] {
            let class = LengthClass::of(length);
            let found = (class.symbol, class.rest, class.rest_bits);
            assert_eq!(found, (symbol, rest, rest_bits), "{length}");
        }
    }

    #[test]
    fn codes_are_the_best_unless_too_long() {
        // Each as rare as all before together: lengths 1, 2, 3, and the two rarest share the last.
        let doubling: [u32; 8] = std::array::from_fn(|i| 1 << i);
        assert_eq!(code_lengths(&doubling, 12), [7, 7, 6, 5, 4, 3, 2, 1]);
        // With at most 4 bits all room is used still, and no symbol has a shorter code than a more frequent one.
        let lengths = code_lengths(&doubling, 4);
        let room: u32 = lengths.iter().map(|&l| 16 >> l).sum();
        assert_eq!(room, 16, "{lengths:?}");
        assert!(lengths.is_sorted_by(|a, b| a >= b) && lengths[0] == 4);
        // Equally many: all codes are equally long, and absent symbols have none.
        assert_eq!(code_lengths(&[5, 0, 5, 5, 5], 12), [2, 0, 2, 2, 2]);
    }

    #[test]
    fn bytes_with_codes_too_long_come_back() {
        // 16 bytes, each twice as often as the one before, mixed: their best codes have up to 15 bits.
        let mut bytes: Vec<u8> = (0..16_u8)
            .flat_map(|byte| std::iter::repeat_n(byte, 1 << byte))
            .collect();
        let count = bytes.len();
        for i in 0..count {
            bytes.swap(i, i * 7919 % count);
        }
        round_trip(&bytes);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let bytes: Vec<u8> = (0..5000_u32).map(|i| (i * i / 7) as u8).collect();
        let size = round_trip(&bytes);
        let mut into = vec![0; size - 1];
        assert_eq!(Runs::default().deflate(&bytes, &mut into), None);
        assert_eq!(Runs::default().deflate(&bytes, &mut []), None);
    }
}
