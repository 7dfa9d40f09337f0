//! Slices of one array back into the whole.

use super::{ArrayError, Element, check_chunk, check_whole, expect_length};

/// Follows the slices of one array: each begins where the one before ended.
#[derive(Clone, Debug)]
pub struct Progress {
    expected: usize,
    received: usize,
}

impl Progress {
    /// Of an array that shall get `expected` elements.
    pub fn new(expected: usize) -> Self {
        Self {
            expected,
            received: 0,
        }
    }

    /// Elements received.
    pub fn received(&self) -> usize {
        self.received
    }

    /// Accepts a slice of elements `E`; returns their number.
    ///
    /// # Errors
    /// `WrongOffset`, `WrongLength` beyond the announced end, `PartialElement`,
    /// `ChunkTooLarge`; the progress then stays as it was.
    pub fn accept<E: Element>(
        &mut self,
        offset_elements: i64,
        data: &[u8],
    ) -> Result<usize, ArrayError> {
        if usize::try_from(offset_elements) != Ok(self.received) {
            return Err(ArrayError::WrongOffset {
                found: offset_elements,
                expected: self.received,
            });
        }
        check_chunk(data.len())?;
        let count = data.len() / E::SIZE;
        let found = self.received + count;
        if found > self.expected {
            let expected = self.expected;
            return Err(ArrayError::WrongLength { found, expected });
        }
        check_whole::<E>(data)?;
        self.received = found;
        Ok(count)
    }

    /// Whether every announced element has arrived.
    pub fn is_complete(&self) -> bool {
        self.received == self.expected
    }

    /// Checks that every announced element has arrived.
    ///
    /// # Errors
    /// [`ArrayError::WrongLength`] when elements are missing.
    pub fn finish(&self) -> Result<(), ArrayError> {
        expect_length(self.received, self.expected)
    }
}

/// Puts slices of one array together.
#[derive(Clone, Debug)]
pub struct Assembler<E> {
    progress: Progress,
    values: Vec<E>,
}

impl<E: Element> Assembler<E> {
    /// An empty array that shall get `expected` elements.
    pub fn new(expected: usize) -> Self {
        Self {
            progress: Progress::new(expected),
            values: Vec::new(),
        }
    }

    /// Appends a slice.
    ///
    /// # Errors
    /// Those of [`Progress::accept`]; the array then stays as it was.
    pub fn push(&mut self, offset_elements: i64, data: &[u8]) -> Result<(), ArrayError> {
        self.progress.accept::<E>(offset_elements, data)?;
        self.values.extend(E::read(data));
        Ok(())
    }

    /// Whether every announced element has arrived.
    pub fn is_complete(&self) -> bool {
        self.progress.is_complete()
    }

    /// The whole array.
    ///
    /// # Errors
    /// [`ArrayError::WrongLength`] when elements are missing.
    pub fn finish(self) -> Result<Vec<E>, ArrayError> {
        self.progress.finish()?;
        Ok(self.values)
    }
}

#[cfg(test)]
mod tests {
    use super::super::encode;
    use super::*;
    use crate::CHUNK_BYTES;

    #[test]
    fn gap_overlap_excess_and_large_slices_are_refused() {
        let mut assembler = Assembler::<i32>::new(4);
        assembler.push(0, &encode(&[1, 2])).unwrap();
        let wrong = |found| ArrayError::WrongOffset { found, expected: 2 };
        assert_eq!(assembler.push(3, &encode(&[1])), Err(wrong(3)));
        assert_eq!(assembler.push(0, &encode(&[1])), Err(wrong(0)));
        assert_eq!(assembler.push(-1, &encode(&[1])), Err(wrong(-1)));
        let excess = ArrayError::WrongLength {
            found: 5,
            expected: 4,
        };
        assert_eq!(assembler.push(2, &encode(&[1, 2, 3])), Err(excess));
        let large = vec![0; CHUNK_BYTES + 4];
        assert_eq!(
            assembler.push(2, &large),
            Err(ArrayError::ChunkTooLarge(large.len()))
        );
        assert!(assembler.finish().is_err());
    }
}
