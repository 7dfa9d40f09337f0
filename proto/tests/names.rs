//! Names of enum values carry their enum's name, as buf's STANDARD rules ask.

use prost::Message as _;
use prost_types::FileDescriptorSet;
use signorini_proto::FILE_DESCRIPTOR_SET;

fn upper_snake(name: &str) -> String {
    let mut out = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !out.is_empty() {
            out.push('_');
        }
        out.extend(letter.to_uppercase());
    }
    out
}

#[test]
fn enum_values_carry_the_name_of_their_enum() {
    let set = FileDescriptorSet::decode(FILE_DESCRIPTOR_SET).unwrap();
    let ours = set
        .file
        .iter()
        .filter(|file| file.package() == "signorini.v1");
    for kind in ours.flat_map(|file| &file.enum_type) {
        let prefix = upper_snake(kind.name()) + "_";
        for value in &kind.value {
            assert!(value.name().starts_with(&prefix), "{}", value.name());
        }
    }
}

#[test]
fn methods_have_their_own_requests_and_responses() {
    let set = FileDescriptorSet::decode(FILE_DESCRIPTOR_SET).unwrap();
    for service in set.file.iter().flat_map(|file| &file.service) {
        for method in &service.method {
            let own = |suffix| format!(".signorini.v1.{}{suffix}", method.name());
            assert_eq!(method.input_type(), own("Request"));
            assert_eq!(method.output_type(), own("Response"));
        }
    }
}
