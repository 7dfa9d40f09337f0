//! Both ways through the fields of a checkpoint: into bytes, and from bytes into places
//! that are already there.

use crate::saddle::Status;
use std::convert::Infallible;

use super::CheckpointError;
use crate::scene::validate::{Spread, Table};

/// Meets every field of a checkpoint in the order of its bytes.
pub(super) trait Fields {
    /// Why a field is refused.
    type Error;

    /// How many of something follow.
    fn length(&mut self, field: &'static str, length: usize) -> Result<(), Self::Error>;

    /// A name that both sides know.
    fn name(&mut self, field: &'static str, name: &str) -> Result<(), Self::Error>;

    /// A number of things, u32.
    fn count(&mut self, field: &'static str, count: &mut u32) -> Result<(), Self::Error>;

    /// Finite numbers, their count first.
    fn numbers(&mut self, field: &'static str, values: &mut [f64]) -> Result<(), Self::Error>;

    /// A finite number that is not negative.
    fn magnitude(&mut self, field: &'static str, value: &mut f64) -> Result<(), Self::Error>;

    /// Yes or no, one byte each, their count first.
    fn flags(&mut self, field: &'static str, values: &mut [bool]) -> Result<(), Self::Error>;

    /// Values by numbers, as many as there are: their count, and two tables each.
    fn spreads(&mut self, field: &'static str, list: &mut Vec<Spread>) -> Result<(), Self::Error>;

    /// Open 0, stick 1, slip 2, one byte each, their count first.
    fn statuses(&mut self, field: &'static str, values: &mut [Status]) -> Result<(), Self::Error>;
}

/// Appends to its bytes.
pub(super) struct Writer {
    /// Written so far.
    pub(super) bytes: Vec<u8>,
}

impl Fields for Writer {
    type Error = Infallible;

    fn length(&mut self, _: &'static str, length: usize) -> Result<(), Infallible> {
        self.bytes.extend((length as u64).to_le_bytes());
        Ok(())
    }

    fn name(&mut self, field: &'static str, name: &str) -> Result<(), Infallible> {
        self.length(field, name.len())?;
        self.bytes.extend(name.as_bytes());
        Ok(())
    }

    fn count(&mut self, _: &'static str, count: &mut u32) -> Result<(), Infallible> {
        self.bytes.extend(count.to_le_bytes());
        Ok(())
    }

    fn numbers(&mut self, field: &'static str, values: &mut [f64]) -> Result<(), Infallible> {
        self.length(field, values.len())?;
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        self.bytes.extend(bytes);
        Ok(())
    }

    fn magnitude(&mut self, _: &'static str, value: &mut f64) -> Result<(), Infallible> {
        self.bytes.extend(value.to_le_bytes());
        Ok(())
    }

    fn flags(&mut self, field: &'static str, values: &mut [bool]) -> Result<(), Infallible> {
        self.length(field, values.len())?;
        self.bytes.extend(values.iter().map(|&flag| u8::from(flag)));
        Ok(())
    }

    fn spreads(&mut self, field: &'static str, list: &mut Vec<Spread>) -> Result<(), Infallible> {
        self.length(field, list.len())?;
        for table in list.iter().flat_map(|one| [&one.nodes, &one.parts]) {
            self.length(field, table.keys.len())?;
            let keys = table.keys.iter().flat_map(|key| key.to_le_bytes());
            self.bytes.extend(keys);
            let values = table.rows.as_flattened().iter();
            self.bytes
                .extend(values.flat_map(|value| value.to_le_bytes()));
        }
        Ok(())
    }

    fn statuses(&mut self, field: &'static str, values: &mut [Status]) -> Result<(), Infallible> {
        self.length(field, values.len())?;
        self.bytes.extend(values.iter().map(|status| match status {
            Status::Open => 0,
            Status::Stick => 1,
            Status::Slip => 2,
        }));
        Ok(())
    }
}

/// Takes from the front of its bytes.
pub(super) struct Reader<'a> {
    /// Not read yet.
    pub(super) rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Bytes whose count, one byte, stands before them.
    pub(super) fn short(&mut self, field: &'static str) -> Result<&'a [u8], CheckpointError> {
        let [length] = self.array(field)?;
        self.take(field, usize::from(length))
    }

    /// Fails if anything is left.
    pub(super) fn end(self) -> Result<(), CheckpointError> {
        if self.rest.is_empty() {
            Ok(())
        } else {
            Err(malformed("end", "is followed by more bytes"))
        }
    }

    fn take(&mut self, field: &'static str, count: usize) -> Result<&'a [u8], CheckpointError> {
        let split = self.rest.split_at_checked(count);
        let (taken, rest) = split.ok_or(malformed(field, "is cut short"))?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], CheckpointError> {
        let split = self.rest.split_first_chunk();
        let (taken, rest) = split.ok_or(malformed(field, "is cut short"))?;
        self.rest = rest;
        Ok(*taken)
    }

    /// A count of entries of `size` bytes, of which as many follow.
    fn counted(&mut self, field: &'static str, size: usize) -> Result<usize, CheckpointError> {
        let count = usize::try_from(u64::from_le_bytes(self.array(field)?));
        let bytes = count.ok().and_then(|count| count.checked_mul(size));
        match bytes.filter(|&bytes| bytes <= self.rest.len()) {
            Some(bytes) => Ok(bytes / size),
            None => Err(malformed(field, "is cut short")),
        }
    }

    /// Rows by ascending numbers.
    fn table(&mut self, field: &'static str) -> Result<Table, CheckpointError> {
        let count = self.counted(field, ROW_BYTES)?;
        let mut keys = Vec::with_capacity(count);
        for _ in 0..count {
            keys.push(u32::from_le_bytes(self.array(field)?));
        }
        if !keys.is_sorted_by(|a, b| a < b) {
            return Err(malformed(field, "has numbers that do not ascend"));
        }
        let mut rows = vec![[0.0; 3]; count];
        for value in rows.as_flattened_mut() {
            *value = self.number(field)?;
        }
        Ok(Table {
            keys: keys.into(),
            rows: rows.into(),
        })
    }

    fn number(&mut self, field: &'static str) -> Result<f64, CheckpointError> {
        let value = f64::from_le_bytes(self.array(field)?);
        if value.is_finite() {
            Ok(value)
        } else {
            Err(malformed(field, "is not finite"))
        }
    }
}

/// Bytes of a number and its row.
const ROW_BYTES: usize = 4 + 3 * 8;
/// Bytes of two empty tables.
const SPREAD_BYTES: usize = 2 * 8;

impl Fields for Reader<'_> {
    type Error = CheckpointError;

    fn length(&mut self, field: &'static str, length: usize) -> Result<(), CheckpointError> {
        if u64::from_le_bytes(self.array(field)?) == length as u64 {
            Ok(())
        } else {
            Err(malformed(field, "has another length than in the plan"))
        }
    }

    fn name(&mut self, field: &'static str, name: &str) -> Result<(), CheckpointError> {
        self.length(field, name.len())?;
        if self.take(field, name.len())? == name.as_bytes() {
            Ok(())
        } else {
            Err(malformed(field, "has another name than in the plan"))
        }
    }

    fn count(&mut self, field: &'static str, count: &mut u32) -> Result<(), CheckpointError> {
        *count = u32::from_le_bytes(self.array(field)?);
        Ok(())
    }

    fn numbers(&mut self, field: &'static str, values: &mut [f64]) -> Result<(), CheckpointError> {
        self.length(field, values.len())?;
        for value in values {
            *value = self.number(field)?;
        }
        Ok(())
    }

    fn magnitude(&mut self, field: &'static str, value: &mut f64) -> Result<(), CheckpointError> {
        *value = self.number(field)?;
        if *value >= 0.0 {
            Ok(())
        } else {
            Err(malformed(field, "is negative"))
        }
    }

    fn flags(&mut self, field: &'static str, values: &mut [bool]) -> Result<(), CheckpointError> {
        self.length(field, values.len())?;
        for value in values {
            let [byte] = self.array(field)?;
            *value = match byte {
                0 => false,
                1 => true,
                2.. => return Err(malformed(field, "is neither yes nor no")),
            };
        }
        Ok(())
    }

    fn spreads(
        &mut self,
        field: &'static str,
        list: &mut Vec<Spread>,
    ) -> Result<(), CheckpointError> {
        let count = self.counted(field, SPREAD_BYTES)?;
        list.clear();
        for _ in 0..count {
            list.push(Spread {
                nodes: self.table(field)?,
                parts: self.table(field)?,
            });
        }
        Ok(())
    }

    fn statuses(
        &mut self,
        field: &'static str,
        values: &mut [Status],
    ) -> Result<(), CheckpointError> {
        self.length(field, values.len())?;
        for value in values {
            let [byte] = self.array(field)?;
            *value = match byte {
                0 => Status::Open,
                1 => Status::Stick,
                2 => Status::Slip,
                3.. => return Err(malformed(field, "is neither open nor stick nor slip")),
            };
        }
        Ok(())
    }
}

fn malformed(field: &'static str, fault: &'static str) -> CheckpointError {
    CheckpointError::Malformed { field, fault }
}
