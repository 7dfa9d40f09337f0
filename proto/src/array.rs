//! The one codec between bulk arrays and bytes on the wire.
//!
//! Values are little-endian and row-major. Arrays come as slices with an offset in
//! elements, which an [`Assembler`] puts together again; [`Progress`] checks the offsets for those who keep the values
//! in another form. Every length and shape is checked before anything is
//! allocated, and an assembler grows with the bytes that arrive, never with the
//! size that a peer announces. Cost: one pass and one copy.

mod assembler;

use bytes::Bytes;

use crate::CHUNK_BYTES;
use crate::v1::ElementType;

pub use assembler::{Assembler, Progress};

/// Largest number of extents in a shape.
pub const MAXIMUM_RANK: usize = 4;

/// A malformed array or slice.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ArrayError {
    /// The bytes are no whole number of elements.
    #[error("{bytes} bytes are no whole number of elements of {element_bytes} bytes")]
    PartialElement {
        /// Bytes received.
        bytes: usize,
        /// Bytes of one element.
        element_bytes: usize,
    },
    /// An extent is negative, there are too many, or their product overflows.
    #[error("shape {0:?} is not valid")]
    BadShape(Vec<i64>),
    /// The data do not fill the shape.
    #[error("{found} elements where the shape asks for {expected}")]
    WrongLength {
        /// Elements received.
        found: usize,
        /// Elements announced.
        expected: usize,
    },
    /// A slice leaves a gap or repeats elements.
    #[error("slice starts at element {found} where {expected} is next")]
    WrongOffset {
        /// Offset received.
        found: i64,
        /// Elements received so far.
        expected: usize,
    },
    /// A slice carries more than [`CHUNK_BYTES`].
    #[error("{0} bytes in one message; at most {CHUNK_BYTES} are allowed")]
    ChunkTooLarge(usize),
}

/// A number that can travel in an array.
pub trait Element: Copy + Sized {
    /// Its name on the wire.
    const TYPE: ElementType;
    /// Bytes on the wire.
    const SIZE: usize;
    /// Appends its bytes.
    fn put(self, out: &mut Vec<u8>);
    /// The bytes of all `values`.
    fn write(values: &[Self]) -> Vec<u8>;
    /// The values of the whole elements in `bytes`; a part of one at the end is
    /// left out.
    fn read(bytes: &[u8]) -> impl ExactSizeIterator<Item = Self> + Clone;
}

macro_rules! element {
    ($number:ty, $wire:ident) => {
        impl Element for $number {
            const TYPE: ElementType = ElementType::$wire;
            const SIZE: usize = size_of::<$number>();

            fn put(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }

            // Both loops have a fixed stride, so that they become block copies.
            fn write(values: &[Self]) -> Vec<u8> {
                let mut out = vec![0; size_of_val(values)];
                let (rows, _) = out.as_chunks_mut();
                for (row, value) in rows.iter_mut().zip(values) {
                    *row = value.to_le_bytes();
                }
                out
            }

            fn read(bytes: &[u8]) -> impl ExactSizeIterator<Item = Self> + Clone {
                let (rows, _) = bytes.as_chunks();
                rows.iter().map(|row| <$number>::from_le_bytes(*row))
            }
        }
    };
}

element!(f64, F64);
element!(f32, F32);
element!(i32, I32);
element!(i64, I64);

/// The bytes of `values`.
pub fn encode<E: Element>(values: &[E]) -> Bytes {
    E::write(values).into()
}

/// The values of whole elements.
///
/// # Errors
/// [`ArrayError::PartialElement`].
pub fn decode<E: Element>(bytes: &[u8]) -> Result<Vec<E>, ArrayError> {
    check_whole::<E>(bytes)?;
    Ok(E::read(bytes).collect())
}

/// Number of elements of a shape; the empty shape is one element.
///
/// # Errors
/// [`ArrayError::BadShape`].
pub fn element_count(shape: &[i64]) -> Result<usize, ArrayError> {
    let product = |count: usize, extent: &i64| count.checked_mul(usize::try_from(*extent).ok()?);
    let count = shape.iter().try_fold(1, product);
    match count {
        Some(count) if shape.len() <= MAXIMUM_RANK => Ok(count),
        _ => Err(ArrayError::BadShape(shape.to_vec())),
    }
}

/// One slice of encoded values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Elements before this slice.
    pub offset_elements: i64,
    /// Whole elements, at most [`CHUNK_BYTES`]; shares the encoded buffer.
    pub data: Bytes,
    /// Whether it is the last.
    pub last: bool,
}

/// Cuts encoded values of `element_bytes` each into slices; no values give one
/// empty slice. Copies nothing.
pub fn chunks(data: Bytes, element_bytes: usize) -> impl Iterator<Item = Chunk> {
    let size = element_bytes.max(1);
    let step = (CHUNK_BYTES / size).max(1) * size;
    let total = data.len();
    (0..total.max(1)).step_by(step).map(move |start| {
        let end = total.min(start + step);
        Chunk {
            offset_elements: (start / size) as i64,
            data: data.slice(start..end),
            last: end == total,
        }
    })
}

fn check_whole<E: Element>(bytes: &[u8]) -> Result<(), ArrayError> {
    if bytes.len().is_multiple_of(E::SIZE) {
        return Ok(());
    }
    Err(ArrayError::PartialElement {
        bytes: bytes.len(),
        element_bytes: E::SIZE,
    })
}

fn expect_length(found: usize, expected: usize) -> Result<(), ArrayError> {
    if found == expected {
        return Ok(());
    }
    Err(ArrayError::WrongLength { found, expected })
}

fn check_chunk(bytes: usize) -> Result<(), ArrayError> {
    if bytes <= CHUNK_BYTES {
        return Ok(());
    }
    Err(ArrayError::ChunkTooLarge(bytes))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn reassemble(values: &[f64]) -> Vec<f64> {
        let mut assembler = Assembler::new(values.len());
        for chunk in chunks(encode(values), 8) {
            assert!(chunk.data.len() <= CHUNK_BYTES);
            assembler.push(chunk.offset_elements, &chunk.data).unwrap();
            assert_eq!(chunk.last, assembler.is_complete());
        }
        assembler.finish().unwrap()
    }

    #[test]
    fn chunks_of_any_size_come_back_whole() {
        for count in [
            0,
            1,
            CHUNK_BYTES / 8 - 1,
            CHUNK_BYTES / 8,
            CHUNK_BYTES / 8 + 1,
            300_000,
        ] {
            let values: Vec<f64> = (0..count).map(|index| index as f64 + 0.5).collect();
            assert_eq!(reassemble(&values), values);
        }
    }

    #[test]
    fn bytes_are_little_endian() {
        assert_eq!(&encode(&[1_i32, -2])[..], [1, 0, 0, 0, 254, 255, 255, 255]);
        assert_eq!(&encode(&[1.0_f64])[..], [0, 0, 0, 0, 0, 0, 240, 63]);
    }

    #[test]
    fn shapes_that_overflow_or_are_negative_are_refused() {
        assert_eq!(element_count(&[2, 3]), Ok(6));
        assert_eq!(element_count(&[]), Ok(1));
        for shape in [&[-1, 3][..], &[i64::MAX, i64::MAX], &[1, 1, 1, 1, 1]] {
            assert_eq!(
                element_count(shape),
                Err(ArrayError::BadShape(shape.to_vec()))
            );
        }
    }

    proptest! {
        #[test]
        fn any_bytes_decode_or_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let whole = bytes.len() % 8 == 0;
            prop_assert_eq!(decode::<i64>(&bytes).is_ok(), whole);
            if let Ok(values) = decode::<i64>(&bytes) {
                prop_assert_eq!(&encode(&values)[..], &bytes[..]);
            }
        }
    }
}
