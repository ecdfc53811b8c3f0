//! Mutated inputs, each a function of its number.

use crate::structured::Layout;

/// Largest input; those of readers that grow with a power of it would be late without a fault.
pub(crate) const MAX_BYTES: usize = 1 << 14;

/// Numbers at the limits of types and formats.
const NUMBERS: [&str; 28] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "0.5",
    "1e-320",
    "5e-324",
    "1e308",
    "1.8e308",
    "1e999",
    "-1e999",
    "nan",
    "inf",
    "-inf",
    "255",
    "256",
    "65535",
    "65536",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775808",
    "18446744073709551615",
    "18446744073709551616",
    "1e400",
    "00000000000000000000001",
];

/// Whole numbers to be written over binary fields.
pub(crate) const FIELDS: [u64; 12] =
    [0, 1, 2, 0x7f, 0x80, 0xff, 0x7fff, 0xffff, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, u64::MAX];

/// Makes inputs out of valid ones.
pub(crate) struct Mutator {
    seeds: Vec<Vec<u8>>,
    /// Words of the seeds.
    tokens: Vec<Vec<u8>>,
    stream: u64,
    /// The layout that most inputs keep, if the format has one.
    layout: Option<Layout>,
}

/// The generator splitmix64.
pub(crate) struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`, 0 if that is 0.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.next() % (end.max(1) as u64)).unwrap_or(0)
    }

    pub(crate) fn byte(&mut self) -> u8 {
        self.next().to_le_bytes()[0]
    }

    pub(crate) fn choose<'a, T>(&mut self, list: &'a [T]) -> Option<&'a T> {
        list.get(self.below(list.len()))
    }

    /// A range of a text of `len` bytes, short ones more often.
    fn range(&mut self, len: usize) -> std::ops::Range<usize> {
        let start = self.below(len + 1);
        let longest = [4, 16, 64, len][self.below(4)];
        start..(start + self.below(longest + 1)).min(len)
    }
}

impl Mutator {
    /// Of valid inputs; `name` sets the random numbers apart from those of others. Three quarters of the inputs keep
    /// the layout, if there is one.
    pub(crate) fn new(name: &str, seeds: Vec<Vec<u8>>, layout: Option<Layout>) -> Self {
        let is_word = |b: &u8| b.is_ascii_alphanumeric() || b"_-.".contains(b);
        let mut tokens: Vec<Vec<u8>> = seeds
            .iter()
            .flat_map(|seed| seed.chunk_by(|a, b| is_word(a) == is_word(b)))
            .filter(|token| token.len() < 40)
            .map(<[u8]>::to_vec)
            .collect();
        tokens.sort();
        tokens.dedup();
        let stream =
            name.bytes().fold(0, |hash: u64, b| hash.wrapping_mul(31).wrapping_add(b.into()));
        Self { seeds, tokens, stream, layout }
    }

    /// Input `number`. The first ones are the valid inputs unchanged.
    pub(crate) fn input(&self, number: u64) -> Vec<u8> {
        if let Some(seed) = usize::try_from(number).ok().and_then(|i| self.seeds.get(i)) {
            return seed.clone();
        }
        let mut random = Random(number.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ self.stream);
        let mut input = random.choose(&self.seeds).cloned().unwrap_or_default();
        // One change in half of the inputs, two in a quarter, and so on.
        let changes = 1 + (random.next() | 1 << 8).trailing_zeros();
        let kept = self.layout.filter(|_| random.below(4) > 0);
        for _ in 0..changes {
            match kept {
                Some(layout) => {
                    layout
                        .change(&mut input, &mut random, |text, random| self.change(text, random));
                }
                None => self.change(&mut input, &mut random),
            }
        }
        input.truncate(MAX_BYTES);
        input
    }

    fn change(&self, input: &mut Vec<u8>, random: &mut Random) {
        let at = random.below(input.len());
        match random.below(13) {
            0 => {
                if let Some(b) = input.get_mut(at) {
                    *b ^= 1 << random.below(8);
                }
            }
            1 => {
                if let Some(b) = input.get_mut(at) {
                    *b = random.byte();
                }
            }
            2 => {
                let range = random.range(input.len());
                input.drain(range);
            }
            3 => input.truncate(at),
            4 => {
                // A piece again, up to 64 times.
                let range = random.range(input.len());
                let piece = input[range.clone()].repeat(1 << random.below(7));
                input.splice(range.end..range.end, piece.into_iter().take(MAX_BYTES));
            }
            5 => {
                let bytes: Vec<u8> = (0..random.below(9)).map(|_| random.byte()).collect();
                input.splice(at..at, bytes);
            }
            6 => {
                let token = random.choose(&self.tokens).cloned().unwrap_or_default();
                input.splice(at..at, token);
            }
            7 => {
                // The beginning of this one and the end of another.
                if let Some(other) = random.choose(&self.seeds) {
                    let from = random.below(other.len());
                    input.truncate(at);
                    input.extend(&other[from..]);
                }
            }
            8 => {
                let field = FIELDS[random.below(FIELDS.len())];
                let width = [1, 2, 4, 8][random.below(4)];
                let bytes = field.to_le_bytes();
                let mut bytes = bytes[..width].to_vec();
                if random.below(2) == 0 {
                    bytes.reverse();
                }
                let end = (at + width).min(input.len());
                let len = end - at;
                input[at..end].copy_from_slice(&bytes[..len]);
            }
            9 => {
                // Lines in another order.
                let mut lines: Vec<Vec<u8>> =
                    input.split_inclusive(|&b| b == b'\n').map(<[u8]>::to_vec).collect();
                let (a, b) = (random.below(lines.len()), random.below(lines.len()));
                if !lines.is_empty() {
                    lines.swap(a, b);
                }
                *input = lines.concat();
            }
            10 => {
                let range = token_at(input, at, |b| b.is_ascii_alphabetic());
                let token = random.choose(&self.tokens).cloned().unwrap_or_default();
                input.splice(range, token);
            }
            _ => {
                // A number for a number.
                let range = token_at(input, at, |b| b.is_ascii_digit() || b"+-.eE".contains(&b));
                let number = NUMBERS[random.below(NUMBERS.len())];
                input.splice(range, number.bytes());
            }
        }
    }
}

/// The first run of such bytes at or after a place; empty if there is none.
fn token_at(input: &[u8], at: usize, is_part: impl Fn(u8) -> bool) -> std::ops::Range<usize> {
    let rest = input.get(at..).unwrap_or_default();
    let Some(start) = rest.iter().position(|&b| is_part(b)) else { return at..at };
    let len = rest[start..].iter().take_while(|&&b| is_part(b)).count();
    at + start..at + start + len
}
