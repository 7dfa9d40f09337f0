//! The numbers of VTK arrays: their types by name, and their bytes.

/// How the bytes of a number follow one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

/// Type of the values of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    Signed(usize),
    Unsigned(usize),
    Float,
    Double,
}

impl Scalar {
    /// The type of a name in either form of the format.
    pub(super) fn of(name: &str) -> Option<Self> {
        Some(match name {
            "Int8" | "char" | "signed_char" => Self::Signed(1),
            "Int16" | "short" => Self::Signed(2),
            "Int32" | "int" => Self::Signed(4),
            "Int64" | "long" | "vtktypeint64" | "vtkIdType" | "vtkidtype" => Self::Signed(8),
            "UInt8" | "unsigned_char" => Self::Unsigned(1),
            "UInt16" | "unsigned_short" => Self::Unsigned(2),
            "UInt32" | "unsigned_int" => Self::Unsigned(4),
            "UInt64" | "unsigned_long" | "vtktypeuint64" => Self::Unsigned(8),
            "Float32" | "float" => Self::Float,
            "Float64" | "double" => Self::Double,
            _ => return None,
        })
    }

    /// Bytes of a value.
    pub(super) fn size(self) -> usize {
        match self {
            Self::Signed(size) | Self::Unsigned(size) => size,
            Self::Float => 4,
            Self::Double => 8,
        }
    }

    pub(super) fn is_integer(self) -> bool {
        matches!(self, Self::Signed(_) | Self::Unsigned(_))
    }

    /// Whole numbers from bytes; parts of numbers are cut off, and unsigned ones that are
    /// too large become negative, which no reader takes for an index.
    pub(super) fn integers(self, bytes: &[u8], order: ByteOrder) -> Vec<i64> {
        let size = self.size();
        let values = bytes.chunks_exact(size).map(|value| {
            let bits = bits(value, order);
            match self {
                Self::Signed(_) => {
                    let unused = 64 - 8 * size as u32;
                    (bits << unused).cast_signed() >> unused
                }
                Self::Unsigned(_) => bits.cast_signed(),
                Self::Float => f64::from(f32::from_bits(bits as u32)) as i64,
                Self::Double => f64::from_bits(bits) as i64,
            }
        });
        values.collect()
    }

    /// Real numbers from bytes; parts of numbers are cut off.
    pub(super) fn reals(self, bytes: &[u8], order: ByteOrder) -> Vec<f64> {
        match self {
            Self::Signed(_) | Self::Unsigned(_) => {
                let integers = self.integers(bytes, order).into_iter();
                integers.map(|value| value as f64).collect()
            }
            Self::Float => {
                let values = bytes.chunks_exact(4).map(|value| bits(value, order) as u32);
                values.map(|bits| f64::from(f32::from_bits(bits))).collect()
            }
            Self::Double => {
                let values = bytes.chunks_exact(8).map(|value| bits(value, order));
                values.map(f64::from_bits).collect()
            }
        }
    }
}

/// At most eight bytes as one number.
pub(super) fn bits(value: &[u8], order: ByteOrder) -> u64 {
    let join = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
    match order {
        ByteOrder::Big => value.iter().fold(0, join),
        ByteOrder::Little => value.iter().rev().fold(0, join),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_size_come_from_their_bytes() {
        let int = Scalar::of("Int32").unwrap();
        assert_eq!(
            int.integers(&[0xfe, 0xff, 0xff, 0xff, 9], ByteOrder::Little),
            [-2]
        );
        let byte = Scalar::of("unsigned_char").unwrap();
        assert_eq!(byte.integers(&[0xfe], ByteOrder::Big), [254]);
        let real = Scalar::of("double").unwrap();
        assert_eq!(
            real.reals(&(-1.5_f64).to_be_bytes(), ByteOrder::Big),
            [-1.5]
        );
        let real = Scalar::of("Float32").unwrap();
        assert_eq!(
            real.reals(&0.25_f32.to_le_bytes(), ByteOrder::Little),
            [0.25]
        );
    }
}
