//! The bytes of arrays in XML files: base64, block headers, zlib.
//!
//! An array begins with its size in bytes, or, compressed, with the number of blocks, the
//! size of a block and of the last one, and the compressed size of each:
//!
//! ```text
//! plain       [bytes] data
//! compressed  [blocks][block bytes][last block bytes][compressed bytes ...] blocks
//! ```
//!
//! Restored data are bounded by a multiple of the size of the file.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;

use super::error::VtkFault;
use super::scalar::{ByteOrder, bits};

/// Restored bytes for each byte of the file. A constant array shrinks to a thousandth,
/// but stands beside points and cells that do not.
const MOST_GROWTH: usize = 64;

/// How the arrays of a file are written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packing {
    pub(super) order: ByteOrder,
    /// Bytes of the numbers of a header, 4 or 8.
    pub(super) header_bytes: usize,
    pub(super) compression: Compression,
    /// Size of the file, bytes.
    pub(super) file_bytes: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Zlib,
}

impl Packing {
    /// The data at the beginning of some bytes.
    pub(super) fn unpack(&self, bytes: &[u8]) -> Result<Vec<u8>, VtkFault> {
        match self.compression {
            Compression::None => self.plain(bytes),
            Compression::Zlib => self.compressed(bytes),
        }
    }

    /// A number of a header, and what follows it.
    fn number<'a>(&self, bytes: &'a [u8]) -> Result<(usize, &'a [u8]), VtkFault> {
        let split = bytes.split_at_checked(self.header_bytes);
        let (number, rest) = split.ok_or(VtkFault::Truncated("the size of an array"))?;
        let declared = bits(number, self.order);
        let number = usize::try_from(declared).map_err(|_| VtkFault::Count { declared })?;
        Ok((number, rest))
    }

    fn plain(&self, bytes: &[u8]) -> Result<Vec<u8>, VtkFault> {
        let (size, data) = self.number(bytes)?;
        let data = data.get(..size).ok_or(VtkFault::Count {
            declared: size as u64,
        })?;
        Ok(data.to_vec())
    }

    fn compressed(&self, bytes: &[u8]) -> Result<Vec<u8>, VtkFault> {
        let (blocks, rest) = self.number(bytes)?;
        let (block_bytes, rest) = self.number(rest)?;
        let (last_bytes, rest) = self.number(rest)?;
        let sizes = blocks.checked_mul(self.header_bytes);
        let split = sizes.and_then(|sizes| rest.split_at_checked(sizes));
        let (sizes, mut data) = split.ok_or(VtkFault::Count {
            declared: blocks as u64,
        })?;
        let most = self.file_bytes.saturating_mul(MOST_GROWTH);
        let mut restored = Vec::new();
        for (block, size) in sizes.chunks_exact(self.header_bytes).enumerate() {
            let (size, _) = self.number(size)?;
            let split = data.split_at_checked(size);
            let (packed, next) = split.ok_or(VtkFault::Truncated("a compressed block"))?;
            let is_last = block + 1 == blocks && last_bytes > 0;
            let expected = if is_last { last_bytes } else { block_bytes };
            let limit = expected.min(most.saturating_sub(restored.len()));
            let whole = decompress_to_vec_zlib_with_limit(packed, limit);
            let whole = whole.map_err(|_| VtkFault::Compression)?;
            if whole.len() != expected {
                return Err(VtkFault::Compression);
            }
            restored.extend(whole);
            data = next;
        }
        Ok(restored)
    }
}

/// The bytes of base64 text with blanks in it. Padding may stand in the middle, where
/// header and data were encoded apart.
pub(super) fn base64(text: &[u8]) -> Result<Vec<u8>, VtkFault> {
    let blank = |byte: &&u8| !byte.is_ascii_whitespace();
    let text: Vec<u8> = text.iter().filter(blank).copied().collect();
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let mut rest = text.as_slice();
    while !rest.is_empty() {
        let padding = rest.iter().position(|byte| *byte == b'=');
        let whole = padding.map_or(rest.len(), |at| (at / 4 + 1) * 4);
        let (part, next) = rest.split_at_checked(whole).ok_or(VtkFault::Base64)?;
        let decoded = STANDARD.decode_vec(part, &mut bytes);
        decoded.map_err(|_| VtkFault::Base64)?;
        rest = next;
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packing(compression: Compression) -> Packing {
        Packing {
            order: ByteOrder::Little,
            header_bytes: 4,
            compression,
            file_bytes: 100,
        }
    }

    #[test]
    fn header_and_data_may_be_encoded_apart() {
        assert_eq!(base64(b"AwAA\n AA==AQID").unwrap(), [3, 0, 0, 0, 1, 2, 3]);
        assert_eq!(base64(b"AwAAAAECAw==").unwrap(), [3, 0, 0, 0, 1, 2, 3]);
        assert_eq!(base64(b"A===").unwrap_err(), VtkFault::Base64);
        assert_eq!(base64(b"AAA").unwrap_err(), VtkFault::Base64);
    }

    #[test]
    fn sizes_beyond_the_data_are_refused() {
        let plain = packing(Compression::None);
        assert_eq!(plain.unpack(&[2, 0, 0, 0, 7, 8]).unwrap(), [7, 8]);
        assert!(plain.unpack(&[3, 0, 0, 0, 7, 8]).is_err());
        assert!(plain.unpack(&[3, 0]).is_err());
    }

    #[test]
    fn blocks_are_restored_and_bombs_refused() {
        let zlib = packing(Compression::Zlib);
        let packed = miniz_oxide::deflate::compress_to_vec_zlib(&[5; 300], 6);
        let file = |size: u32| {
            let header = [1, size, size, packed.len() as u32];
            let header = header.iter().flat_map(|number| number.to_le_bytes());
            header.chain(packed.iter().copied()).collect::<Vec<u8>>()
        };
        assert_eq!(zlib.unpack(&file(300)).unwrap(), [5; 300]);
        assert_eq!(zlib.unpack(&file(301)), Err(VtkFault::Compression));
        let small = Packing {
            file_bytes: 4,
            ..zlib
        };
        assert_eq!(small.unpack(&file(300)), Err(VtkFault::Compression));
    }
}
