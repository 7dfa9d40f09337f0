//! Makes inputs by changing good ones, in ways that a parser's structure asks for.
//!
//! Each case has a generator of its own, made of the seed and its number, so
//! that one case can be run alone. The environment sets a campaign:
//! `SIGNORINI_FUZZ_CASES` (10 000), `SIGNORINI_FUZZ_SEED`, and
//! `SIGNORINI_FUZZ_FIRST`, the number of the first case.

#[path = "wire.rs"]
mod wire;

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use fastrand::Rng;

const CASES: u64 = 10_000;
const SEED: u64 = 0x5167_6e6f_7269_6e69;
/// Longest part of an input that a failure shows, bytes.
const SHOWN_BYTES: usize = 2000;
/// Inputs end here: what is tested is form, not size.
const LONGEST_BYTES: usize = 32 << 10;

/// Numbers at the edges of the types that read them.
const NUMBERS: [&str; 18] = [
    "0",
    "-1",
    "1",
    "-0.0",
    "1e308",
    "-1e308",
    "1e-320",
    "1e999",
    "nan",
    "inf",
    "-inf",
    "255",
    "65536",
    "2147483647",
    "2147483648",
    "-2147483648",
    "9223372036854775807",
    "18446744073709551616",
];

/// The same for numbers in binary.
const INTEGERS: [u64; 12] = [
    0,
    1,
    2,
    0x7f,
    0xff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    0x7ff0_0000_0000_0000,
    u64::MAX,
];

/// How many cases, from which, by which seed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Campaign {
    pub(crate) seed: u64,
    pub(crate) first: u64,
    pub(crate) cases: u64,
}

impl Campaign {
    pub(crate) fn from_environment() -> Self {
        Self {
            seed: variable("SIGNORINI_FUZZ_SEED", SEED),
            first: variable("SIGNORINI_FUZZ_FIRST", 0),
            cases: variable("SIGNORINI_FUZZ_CASES", CASES),
        }
    }

    pub(crate) fn numbers(self) -> std::ops::Range<u64> {
        self.first..self.first + self.cases
    }

    /// The generator of one case.
    pub(crate) fn generator(self, case: u64) -> Rng {
        // An odd factor keeps the seeds of neighbours apart.
        Rng::with_seed(self.seed ^ case.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// Runs `target` on every case; a panic is told with the input that caused it.
    pub(crate) fn run(self, corpus: &Corpus, mut target: impl FnMut(&[u8], &mut Rng)) {
        for case in self.numbers() {
            let mut rng = self.generator(case);
            let input = corpus.input(&mut rng);
            let outcome = catch_unwind(AssertUnwindSafe(|| target(&input, &mut rng)));
            if let Err(panic) = outcome {
                eprintln!("{}", self.describe(case, &input));
                resume_unwind(panic);
            }
        }
    }

    /// What is needed to run a case again.
    pub(crate) fn describe(self, case: u64, input: &[u8]) -> String {
        let shown = &input[..input.len().min(SHOWN_BYTES)];
        format!(
            "SIGNORINI_FUZZ_SEED={} SIGNORINI_FUZZ_FIRST={case} SIGNORINI_FUZZ_CASES=1\n\
             input of {} bytes: {}",
            self.seed,
            input.len(),
            shown.escape_ascii()
        )
    }
}

fn variable(name: &str, default: u64) -> u64 {
    match std::env::var(name) {
        Ok(text) => text
            .parse()
            .unwrap_or_else(|_| panic!("{name} is no count: {text}")),
        Err(_) => default,
    }
}

/// What the inputs of a corpus are.
#[allow(dead_code, reason = "a binary may use one of them")]
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// Text, or bytes of a format of their own.
    File,
    /// Protobuf messages.
    Messages,
}

/// Good inputs and the words of their language.
pub(crate) struct Corpus {
    form: Form,
    seeds: Vec<Vec<u8>>,
    words: Vec<&'static str>,
}

impl Corpus {
    pub(crate) fn new(form: Form, seeds: Vec<Vec<u8>>, words: &[&'static str]) -> Self {
        assert!(!seeds.is_empty(), "a campaign needs seeds");
        Self {
            form,
            seeds,
            words: words.to_vec(),
        }
    }

    /// A seed with one to seven changes, mostly few.
    pub(crate) fn input(&self, rng: &mut Rng) -> Vec<u8> {
        let mut input = self.seed(rng).to_vec();
        for _ in 0..1 + rng.usize(..8) * rng.usize(..8) / 8 {
            self.change(&mut input, rng);
        }
        input.truncate(LONGEST_BYTES);
        input
    }

    fn seed(&self, rng: &mut Rng) -> &[u8] {
        &self.seeds[rng.usize(..self.seeds.len())]
    }

    fn change(&self, input: &mut Vec<u8>, rng: &mut Rng) {
        // Most changes keep a message whole, for its decoder refuses the others.
        let whole = self.form == Form::Messages && rng.u32(..16) > 0;
        if whole && wire::change(input, rng) {
            return;
        }
        match rng.u32(..12) {
            0 => flip(input, rng),
            1 => overwrite(input, rng),
            2 => delete(input, rng),
            3 => repeat(input, rng),
            4 => self.splice(input, rng),
            5..=7 => replace_number(input, rng),
            8 => binary_number(input, rng),
            9 => self.word(input, rng),
            10 => move_line(input, rng),
            _ => truncate(input, rng),
        }
    }

    /// Part of another seed in place of a part.
    fn splice(&self, input: &mut Vec<u8>, rng: &mut Rng) {
        let other = self.seed(rng);
        let piece = other[range(other.len(), rng)].to_vec();
        let place = range(input.len(), rng);
        input.splice(place, piece);
    }

    fn word(&self, input: &mut Vec<u8>, rng: &mut Rng) {
        if let Some(word) = rng.choice(&self.words) {
            insert(input, word.as_bytes(), rng);
        }
    }
}

/// A range of at most 64 bytes, seldom any.
fn range(length: usize, rng: &mut Rng) -> std::ops::Range<usize> {
    let start = rng.usize(..=length);
    let longest = match rng.u32(..8) {
        0 => length - start,
        _ => (length - start).min(64),
    };
    start..start + rng.usize(..=longest)
}

fn insert(input: &mut Vec<u8>, piece: &[u8], rng: &mut Rng) {
    let at = rng.usize(..=input.len());
    input.splice(at..at, piece.iter().copied());
}

fn flip(input: &mut [u8], rng: &mut Rng) {
    if let Some(byte) = rng.choice(input) {
        *byte ^= 1 << rng.u32(..8);
    }
}

fn overwrite(input: &mut [u8], rng: &mut Rng) {
    let place = range(input.len(), rng);
    for byte in &mut input[place] {
        *byte = rng.u8(..);
    }
}

fn delete(input: &mut Vec<u8>, rng: &mut Rng) {
    let place = range(input.len(), rng);
    input.drain(place);
}

/// One part several times, up to many: nesting and long lists.
fn repeat(input: &mut Vec<u8>, rng: &mut Rng) {
    let piece = input[range(input.len(), rng)].to_vec();
    let most = match rng.u32(..8) {
        0 => 300,
        _ => 3,
    };
    let times = 1 + rng.usize(..most);
    insert(
        input,
        &piece.repeat(times.min(1 + LONGEST_BYTES / (1 + piece.len()))),
        rng,
    );
}

/// A run of digits becomes a number at the edge of some type.
fn replace_number(input: &mut Vec<u8>, rng: &mut Rng) {
    let from = rng.usize(..=input.len());
    let Some(found) = input[from..].iter().position(u8::is_ascii_digit) else {
        return;
    };
    let start = from + found;
    let number = |byte: &u8| byte.is_ascii_digit() || b".+-eE_".contains(byte);
    let length = input[start..]
        .iter()
        .take_while(|byte| number(byte))
        .count();
    let new = NUMBERS[rng.usize(..NUMBERS.len())];
    input.splice(start..start + length, new.bytes());
}

/// Four or eight bytes, or a varint, become an integer at the edge of some type.
fn binary_number(input: &mut Vec<u8>, rng: &mut Rng) {
    let number = INTEGERS[rng.usize(..INTEGERS.len())];
    let at = rng.usize(..=input.len());
    let (new, old) = match rng.u32(..3) {
        0 => (number.to_le_bytes()[..4].to_vec(), 4),
        1 => (number.to_le_bytes().to_vec(), 8),
        _ => (varint(number), 1),
    };
    let end = (at + old).min(input.len());
    input.splice(at..end, new);
}

fn varint(mut number: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while number >= 0x80 {
        bytes.push(0x80 | (number & 0x7f) as u8);
        number >>= 7;
    }
    bytes.push(number as u8);
    bytes
}

fn move_line(input: &mut Vec<u8>, rng: &mut Rng) {
    let from = rng.usize(..=input.len());
    let tail = &input[from..];
    let length = tail.iter().position(|byte| *byte == b'\n');
    let line: Vec<u8> = input
        .drain(from..from + length.map_or(tail.len(), |end| end + 1))
        .collect();
    insert(input, &line, rng);
}

fn truncate(input: &mut Vec<u8>, rng: &mut Rng) {
    input.truncate(rng.usize(..=input.len()));
}
