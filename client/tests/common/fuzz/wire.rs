//! Changes of protobuf messages that keep tags and lengths in step, so that they
//! reach what lies behind the decoder.

use fastrand::Rng;

use super::{INTEGERS, LONGEST_BYTES};

/// Deepest messages that are taken apart.
const DEEPEST: u32 = 8;

/// Doubles at the edges of their type.
const REALS: [f64; 9] = [
    0.0,
    -0.0,
    -1.0,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN_POSITIVE / 2.0,
    1e-300,
];

#[derive(Clone)]
enum Value {
    Varint(u64),
    Double([u8; 8]),
    Single([u8; 4]),
    Bytes(Vec<u8>),
    Message(Vec<Field>),
}

#[derive(Clone)]
struct Field {
    number: u64,
    value: Value,
}

/// Changes one field of a message, at any depth; false when the bytes are none.
pub(super) fn change(input: &mut Vec<u8>, rng: &mut Rng) -> bool {
    let Some(mut fields) = parse(input, DEEPEST) else {
        return false;
    };
    change_among(&mut fields, rng);
    input.clear();
    encode(&fields, input);
    true
}

fn parse(mut bytes: &[u8], depth: u32) -> Option<Vec<Field>> {
    let mut fields = Vec::new();
    while !bytes.is_empty() {
        let key = take_varint(&mut bytes)?;
        let number = Some(key >> 3).filter(|number| *number > 0)?;
        let value = match key & 7 {
            0 => Value::Varint(take_varint(&mut bytes)?),
            1 => Value::Double(take(&mut bytes)?),
            2 => delimited(&mut bytes, depth)?,
            5 => Value::Single(take(&mut bytes)?),
            _ => return None,
        };
        fields.push(Field { number, value });
    }
    Some(fields)
}

/// A message where the bytes can be read as one, which names sometimes can.
fn delimited(bytes: &mut &[u8], depth: u32) -> Option<Value> {
    let length = usize::try_from(take_varint(bytes)?).ok()?;
    let (data, rest) = bytes.split_at_checked(length)?;
    *bytes = rest;
    let nested = (depth > 0 && !data.is_empty()).then(|| parse(data, depth - 1));
    Some(match nested.flatten() {
        Some(fields) => Value::Message(fields),
        None => Value::Bytes(data.to_vec()),
    })
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (data, rest) = bytes.split_first_chunk::<N>()?;
    *bytes = rest;
    Some(*data)
}

fn take_varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut number = 0;
    for shift in (0..64).step_by(7) {
        let [byte] = take(bytes)?;
        number |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(number);
        }
    }
    None
}

fn encode(fields: &[Field], out: &mut Vec<u8>) {
    for field in fields {
        let (kind, data) = match &field.value {
            Value::Varint(number) => (0, super::varint(*number)),
            Value::Double(data) => (1, data.to_vec()),
            Value::Single(data) => (5, data.to_vec()),
            Value::Bytes(data) => (2, with_length(data)),
            Value::Message(nested) => {
                let mut data = Vec::new();
                encode(nested, &mut data);
                (2, with_length(&data))
            }
        };
        out.extend(super::varint(field.number << 3 | kind));
        out.extend(data);
    }
}

fn with_length(data: &[u8]) -> Vec<u8> {
    [&super::varint(data.len() as u64), data].concat()
}

fn change_among(fields: &mut Vec<Field>, rng: &mut Rng) {
    if fields.is_empty() {
        fields.push(Field {
            number: 1 + rng.u64(..8),
            value: Value::Varint(edge(rng)),
        });
        return;
    }
    let at = rng.usize(..fields.len());
    match rng.u32(..12) {
        0 => drop(fields.remove(at)),
        1 => repeat(fields, at, rng),
        2 => {
            let other = rng.usize(..fields.len());
            fields.swap(at, other);
        }
        3 => fields[at].number = 1 + rng.u64(..16),
        _ => change_value(&mut fields[at].value, rng),
    }
}

/// One field many times: long lists of what is short.
fn repeat(fields: &mut Vec<Field>, at: usize, rng: &mut Rng) {
    let field = fields[at].clone();
    let mut bytes = Vec::new();
    encode(std::slice::from_ref(&field), &mut bytes);
    let most = if rng.u32(..8) == 0 { 300 } else { 2 };
    let times = most.min(1 + LONGEST_BYTES / 4 / bytes.len());
    let copies = vec![field; 1 + rng.usize(..times)];
    fields.splice(at..at, copies);
}

fn change_value(value: &mut Value, rng: &mut Rng) {
    match value {
        Value::Varint(number) => *number = edge(rng),
        Value::Double(data) => *data = real(rng),
        Value::Single(data) => *data = (edge(rng) as u32).to_le_bytes(),
        Value::Bytes(data) => change_bytes(data, rng),
        Value::Message(fields) => change_among(fields, rng),
    }
}

/// Names, packed numbers, arrays.
fn change_bytes(data: &mut Vec<u8>, rng: &mut Rng) {
    let words = data.len() / 8;
    match rng.u32(..10) {
        0 => data.clear(),
        1 => *data = "\u{20ac}".repeat(1 + rng.usize(..200)).into_bytes(),
        2 => data.extend(real(rng)),
        3..=6 if words > 0 => {
            let at = 8 * rng.usize(..words);
            data[at..at + 8].copy_from_slice(&real(rng));
        }
        7 if data.len() >= 4 => data.truncate(data.len() - 4),
        _ => super::flip(data, rng),
    }
}

/// A small number or one at the edge of some type.
fn edge(rng: &mut Rng) -> u64 {
    match rng.u32(..3) {
        0 => rng.u64(..12),
        _ => INTEGERS[rng.usize(..INTEGERS.len())],
    }
}

fn real(rng: &mut Rng) -> [u8; 8] {
    let number = match rng.u32(..3) {
        0 => 4.0 * rng.f64() - 2.0,
        _ => REALS[rng.usize(..REALS.len())],
    };
    number.to_le_bytes()
}
