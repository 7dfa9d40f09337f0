//! Names and encodings of fields.

use bytes::Bytes;
use signorini::report::{FieldData, FieldName};
use signorini_proto::array;
use signorini_proto::v1 as wire;

use super::wide;
use crate::fault::Fault;

/// Most numbers in one request for fields.
const MAXIMUM_FIELDS: usize = 100;

/// Number type of fields on one stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Encoding {
    #[default]
    Double,
    Single,
}

/// A field as it is kept: encoded once, sliced for every reader.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct KeptField {
    pub(crate) name: FieldName,
    rows: u64,
    components: u64,
    /// Little-endian doubles, row-major.
    pub(crate) data: Bytes,
}

impl KeptField {
    /// Encodes a field.
    pub(crate) fn new(field: &FieldData) -> Self {
        let components = field.components.max(1);
        Self {
            name: field.name,
            rows: (field.values.len() / components) as u64,
            components: components as u64,
            data: array::encode(&field.values),
        }
    }

    /// Rows and columns.
    pub(crate) fn shape(&self) -> (u64, u64) {
        (self.rows, self.components)
    }

    /// As it was taken apart before; `None` where the parts do not fit.
    pub(crate) fn from_parts(number: i32, shape: (u64, u64), data: Bytes) -> Option<Self> {
        let name = wire::FieldName::try_from(number).ok().and_then(domain)?;
        let (rows, components) = shape;
        let bytes = rows.checked_mul(components)?.checked_mul(8)?;
        (bytes == data.len() as u64).then_some(Self {
            name,
            rows,
            components,
            data,
        })
    }

    /// Its messages, in order.
    pub(crate) fn chunks(
        &self,
        sequence: i64,
        event: i64,
        encoding: Encoding,
    ) -> impl Iterator<Item = wire::FieldChunk> + use<> {
        let (field, shape) = (
            name(self.name),
            vec![wide(self.rows), wide(self.components)],
        );
        array::chunks(self.data.clone(), size_of::<f64>()).map(move |chunk| {
            let (data, kind) = encoded(chunk.data, encoding);
            wire::FieldChunk {
                sequence,
                event,
                field: field.into(),
                element_type: kind.into(),
                shape: shape.clone(),
                offset_elements: chunk.offset_elements,
                data,
                last: chunk.last,
            }
        })
    }
}

/// A slice of doubles as a reader wants it.
fn encoded(doubles: Bytes, encoding: Encoding) -> (Bytes, wire::ElementType) {
    match encoding {
        Encoding::Double => (doubles, wire::ElementType::F64),
        Encoding::Single => (single(&doubles), wire::ElementType::F32),
    }
}

fn single(doubles: &[u8]) -> Bytes {
    // The bytes were encoded from doubles, so they decode.
    let values: Vec<f64> = array::decode(doubles).unwrap_or_default();
    let values: Vec<f32> = values.into_iter().map(|value| value as f32).collect();
    array::encode(&values)
}

/// The encoding that a reader asks for.
///
/// # Errors
/// For integers and unknown numbers.
pub(crate) fn encoding(number: i32) -> Result<Encoding, Fault> {
    match wire::ElementType::try_from(number) {
        Ok(wire::ElementType::Unspecified | wire::ElementType::F64) => Ok(Encoding::Double),
        Ok(wire::ElementType::F32) => Ok(Encoding::Single),
        Ok(wire::ElementType::I32 | wire::ElementType::I64) | Err(_) => {
            Err(Fault::request("element_type", "fields come as F64 or F32"))
        }
    }
}

/// Fields by their numbers, each once, in order of the request.
///
/// # Errors
/// For an unknown number and for more than [`MAXIMUM_FIELDS`].
pub(crate) fn names(numbers: &[i32], path: &str) -> Result<Vec<FieldName>, Fault> {
    if numbers.len() > MAXIMUM_FIELDS {
        let count = numbers.len();
        let message = format!("has {count} entries, at most {MAXIMUM_FIELDS} are allowed");
        return Err(Fault::request(path, message));
    }
    let mut fields = Vec::new();
    for number in numbers {
        let known = wire::FieldName::try_from(*number).ok().and_then(domain);
        let field = known.ok_or_else(|| {
            Fault::request(path, format!("field number {number} is not known here"))
        })?;
        if !fields.contains(&field) {
            fields.push(field);
        }
    }
    Ok(fields)
}

/// The wire's name of a field.
pub(crate) fn name(field: FieldName) -> wire::FieldName {
    match field {
        FieldName::Displacement => wire::FieldName::Displacement,
        FieldName::Pressure => wire::FieldName::Pressure,
        FieldName::ContactPressure => wire::FieldName::ContactPressure,
        FieldName::Gap => wire::FieldName::Gap,
        FieldName::ContactState => wire::FieldName::ContactState,
        FieldName::Stress => wire::FieldName::Stress,
        FieldName::Jacobian => wire::FieldName::Jacobian,
        FieldName::ErrorEstimate => wire::FieldName::ErrorEstimate,
        FieldName::ContactPressureDeformed => wire::FieldName::ContactPressureDeformed,
        FieldName::ContactPressureUndeformed => wire::FieldName::ContactPressureUndeformed,
        FieldName::FrictionTraction => wire::FieldName::FrictionTraction,
        FieldName::Slip => wire::FieldName::Slip,
        FieldName::LowestMode => wire::FieldName::LowestMode,
        FieldName::NodalForce => wire::FieldName::NodalForce,
        FieldName::ContactPath => wire::FieldName::ContactPath,
        FieldName::ErrorDensity => wire::FieldName::ErrorDensity,
        FieldName::MeshGradient => wire::FieldName::MeshGradient,
    }
}

fn domain(field: wire::FieldName) -> Option<FieldName> {
    FieldName::ALL
        .into_iter()
        .find(|known| name(*known) == field)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_has_its_own_number_and_unknown_ones_are_refused() {
        let numbers: Vec<i32> = FieldName::ALL
            .iter()
            .map(|field| name(*field).into())
            .collect();
        assert_eq!(names(&numbers, "fields"), Ok(FieldName::ALL.to_vec()));
        for unknown in [0, 99, -1] {
            assert!(names(&[unknown], "fields").is_err());
        }
    }

    #[test]
    fn a_field_is_sliced_with_its_shape_in_both_encodings() {
        let values: Vec<f64> = (0..300_000).map(f64::from).collect();
        let field = FieldData {
            name: FieldName::Displacement,
            components: 3,
            values,
        };
        let kept = KeptField::new(&field);
        for (encoding, size) in [(Encoding::Double, 8), (Encoding::Single, 4)] {
            let chunks: Vec<_> = kept.chunks(2, 5, encoding).collect();
            let bytes: usize = chunks.iter().map(|chunk| chunk.data.len()).sum();
            assert_eq!(bytes, 300_000 * size);
            assert_eq!(chunks.iter().filter(|chunk| chunk.last).count(), 1);
            assert!(chunks.iter().all(|chunk| chunk.shape == [100_000, 3]));
        }
    }
}
