//! What a message will take in memory when it is decoded, read off its bytes.
//!
//! Two bytes may become a structure of hundreds: an empty sub-message in a repeated
//! field. So the bytes are walked along the descriptors of the contract, without
//! decoding anything, and every structure that they announce is counted. Cost: one
//! pass over the bytes.

use std::collections::HashMap;

use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorSet};
use signorini_proto::FILE_DESCRIPTOR_SET;

/// Nesting beyond which a message is refused by the decoder (that of prost).
const DEEPEST: usize = 100;

/// Bytes of a structure, and of each of its fields: about what they take on a machine
/// of 64 bits, in a list that doubles as it grows.
const STRUCTURE_BYTES: u64 = 32;
const FIELD_BYTES: u64 = 32;
/// Of one more string in a list.
const STRING_BYTES: u64 = 64;

#[derive(Clone, Copy)]
enum Content {
    Structure(usize),
    Text,
    /// Numbers of one byte and more on the wire, of eight in memory.
    Varints,
    /// Numbers that take the same on the wire.
    Fixed,
}

struct Shape {
    fields: HashMap<u32, Content>,
    bytes: u64,
}

/// The messages of the contract.
pub(super) struct Shapes {
    shapes: Vec<Shape>,
    /// Input of a method by its path, and whether it is a stream.
    methods: HashMap<String, (usize, bool)>,
}

impl Shapes {
    /// Reads the descriptors.
    ///
    /// # Errors
    /// When they cannot be decoded, which no input can cause.
    pub(super) fn new() -> Result<Self, prost::DecodeError> {
        let set = FileDescriptorSet::decode(FILE_DESCRIPTOR_SET)?;
        let mut all = Vec::new();
        for file in &set.file {
            let scope = format!(".{}", file.package());
            for message in &file.message_type {
                collect(&scope, message, &mut all);
            }
        }
        let numbers: HashMap<&str, usize> = all
            .iter()
            .enumerate()
            .map(|(number, (name, _))| (name.as_str(), number))
            .collect();
        let shapes = all.iter().map(|(_, one)| shape(one, &numbers)).collect();
        let mut methods = HashMap::new();
        for file in &set.file {
            for service in &file.service {
                for method in &service.method {
                    if let Some(input) = numbers.get(method.input_type()) {
                        let (package, service) = (file.package(), service.name());
                        let path = format!("/{package}.{service}/{}", method.name());
                        methods.insert(path, (*input, method.client_streaming()));
                    }
                }
            }
        }
        Ok(Self { shapes, methods })
    }

    /// The message that a method takes, and whether it takes a stream of them.
    pub(super) fn method(&self, path: &str) -> Option<(usize, bool)> {
        self.methods.get(path).copied()
    }

    /// Bytes that `message` takes when it is decoded, counted up to `most`; bytes that
    /// are no message cost what was found before the fault.
    pub(super) fn cost(&self, shape: usize, message: &[u8], most: u64) -> u64 {
        let mut walk = Walk {
            all: self,
            cost: 0,
            most,
        };
        // What ends the walk is found again by the decoder, which tells the client.
        let _fault = walk.message(shape, message, 0);
        walk.cost
    }
}

fn collect<'a>(
    scope: &str,
    message: &'a DescriptorProto,
    all: &mut Vec<(String, &'a DescriptorProto)>,
) {
    let name = format!("{scope}.{}", message.name());
    for nested in &message.nested_type {
        collect(&name, nested, all);
    }
    all.push((name, message));
}

fn shape(message: &DescriptorProto, numbers: &HashMap<&str, usize>) -> Shape {
    let content = |field: &FieldDescriptorProto| match field.r#type() {
        Type::Message => numbers
            .get(field.type_name())
            .map_or(Content::Text, |number| Content::Structure(*number)),
        Type::String | Type::Bytes | Type::Group => Content::Text,
        Type::Double
        | Type::Float
        | Type::Fixed32
        | Type::Fixed64
        | Type::Sfixed32
        | Type::Sfixed64 => Content::Fixed,
        Type::Int32
        | Type::Int64
        | Type::Uint32
        | Type::Uint64
        | Type::Sint32
        | Type::Sint64
        | Type::Bool
        | Type::Enum => Content::Varints,
    };
    let fields = message.field.iter().filter_map(|field| {
        // A number that is not repeated has its place in the structure.
        let content = content(field);
        let is_list = field.label() == Label::Repeated;
        let counts = is_list || matches!(content, Content::Structure(_) | Content::Text);
        Some((u32::try_from(field.number()).ok()?, content)).filter(|_| counts)
    });
    Shape {
        bytes: STRUCTURE_BYTES + FIELD_BYTES * message.field.len() as u64,
        fields: fields.collect(),
    }
}

/// The bytes are no message, or cost more than may be.
struct Ended;

struct Walk<'a> {
    all: &'a Shapes,
    cost: u64,
    most: u64,
}

impl Walk<'_> {
    fn add(&mut self, bytes: u64) -> Result<(), Ended> {
        self.cost = self.cost.saturating_add(bytes);
        if self.cost > self.most {
            Err(Ended)
        } else {
            Ok(())
        }
    }

    fn message(&mut self, shape: usize, mut bytes: &[u8], depth: usize) -> Result<(), Ended> {
        let Some(shape) = self.all.shapes.get(shape).filter(|_| depth < DEEPEST) else {
            return Err(Ended);
        };
        self.add(shape.bytes)?;
        while !bytes.is_empty() {
            let key = varint(&mut bytes)?;
            let number = u32::try_from(key >> 3).map_err(|_| Ended)?;
            let content = shape.fields.get(&number);
            match key & 7 {
                0 => {
                    varint(&mut bytes)?;
                    self.number(content)?;
                }
                1 => {
                    part(&mut bytes, 8)?;
                    self.number(content)?;
                }
                5 => {
                    part(&mut bytes, 4)?;
                    self.number(content)?;
                }
                2 => {
                    let length = varint(&mut bytes)?;
                    let inner = part(&mut bytes, length)?;
                    self.part(content, inner, depth)?;
                }
                // Groups, which the contract does not have: their fields are skipped.
                3 | 4 => {}
                _ => return Err(Ended),
            }
        }
        Ok(())
    }

    /// One number of a list.
    fn number(&mut self, content: Option<&Content>) -> Result<(), Ended> {
        match content {
            Some(_) => self.add(16),
            None => Ok(()),
        }
    }

    fn part(&mut self, content: Option<&Content>, inner: &[u8], depth: usize) -> Result<(), Ended> {
        let length = inner.len() as u64;
        match content {
            None => Ok(()),
            Some(Content::Structure(shape)) => self.message(*shape, inner, depth + 1),
            Some(Content::Text) => self.add(STRING_BYTES + length),
            Some(Content::Fixed) => self.add(2 * length),
            Some(Content::Varints) => self.add(16 * length),
        }
    }
}

fn varint(bytes: &mut &[u8]) -> Result<u64, Ended> {
    let mut value = 0;
    for place in 0..10 {
        let (first, rest) = bytes.split_first().ok_or(Ended)?;
        *bytes = rest;
        value |= u64::from(first & 0x7f) << (7 * place);
        if first & 0x80 == 0 {
            return Ok(value);
        }
    }
    Err(Ended)
}

fn part<'a>(bytes: &mut &'a [u8], length: u64) -> Result<&'a [u8], Ended> {
    let length = usize::try_from(length).map_err(|_| Ended)?;
    let (part, rest) = bytes.split_at_checked(length).ok_or(Ended)?;
    *bytes = rest;
    Ok(part)
}

#[cfg(test)]
mod tests {
    use signorini_proto::v1 as wire;

    use super::*;

    const CREATE: &str = "/signorini.v1.SessionService/CreateSession";

    fn cost(message: &impl prost::Message, path: &str) -> u64 {
        let shapes = Shapes::new().unwrap();
        let (shape, _) = shapes.method(path).unwrap();
        shapes.cost(shape, &message.encode_to_vec(), u64::MAX)
    }

    fn with_obstacles(count: usize) -> wire::CreateSessionRequest {
        wire::CreateSessionRequest {
            scene: Some(wire::Scene {
                obstacles: vec![wire::Obstacle::default(); count],
                ..Default::default()
            }),
            ..Default::default()
        }
    }

    #[test]
    fn empty_structures_cost_what_they_become() {
        let [one, many] = [1, 10_001].map(|count| cost(&with_obstacles(count), CREATE));
        let each = (many - one) / 10_000;
        let size = size_of::<wire::Obstacle>() as u64;
        assert!(each >= size && each < 4 * size, "{each} for {size}");
    }

    #[test]
    fn no_message_of_the_contract_is_larger_than_it_counts() {
        let shapes = Shapes::new().unwrap();
        let counted = |path: &str| {
            let (shape, _) = shapes.method(path).unwrap();
            shapes.shapes[shape].bytes
        };
        let solve = counted("/signorini.v1.SessionService/Solve");
        let upload = counted("/signorini.v1.MeshService/UploadMesh");
        assert!(counted(CREATE) >= size_of::<wire::CreateSessionRequest>() as u64 / 4);
        assert!(solve > 0 && upload > 0);
        assert!(
            shapes
                .method("/signorini.v1.SessionService/Nothing")
                .is_none()
        );
    }

    #[test]
    fn bulk_data_cost_about_what_they_are() {
        let message = wire::UploadMeshRequest {
            part: Some(wire::upload_mesh_request::Part::Chunk(wire::MeshChunk {
                data: vec![0; 1 << 20].into(),
                ..Default::default()
            })),
        };
        let found = cost(&message, "/signorini.v1.MeshService/UploadMesh");
        assert!((1 << 20..(1 << 20) + 2000).contains(&found), "{found}");
    }

    #[test]
    fn counting_ends_at_the_limit_and_at_nonsense() {
        let shapes = Shapes::new().unwrap();
        let (shape, is_stream) = shapes.method(CREATE).unwrap();
        assert!(!is_stream);
        let bytes = with_obstacles(100_000).encode_to_vec();
        let found = shapes.cost(shape, &bytes, 1 << 20);
        assert!(found > 1 << 20 && found < (1 << 20) + 4096, "{found}");
        for bytes in [
            &[0xff; 20][..],
            &[0x0a, 0xff, 0xff, 0xff, 0xff, 0x0f],
            &[7, 7],
        ] {
            assert!(shapes.cost(shape, bytes, 1 << 20) < 4096);
        }
    }
}
