//! The current proto still serves every client built against the released one:
//! `released.binpb` is the descriptor set of the last release.
//!
//! `UPDATE_RELEASED=1 cargo test -p signorini-proto --test compatibility` takes
//! the current proto as released.

use std::collections::BTreeMap;

use prost::Message as _;
use prost_types::{
    DescriptorProto, EnumDescriptorProto, FieldDescriptorProto, FileDescriptorSet,
    MethodDescriptorProto,
};
use signorini_proto::FILE_DESCRIPTOR_SET;

/// Everything a peer relies on: what, and how it is defined.
type Contract = BTreeMap<String, String>;

fn contract(set: &FileDescriptorSet) -> Contract {
    let mut all = Contract::new();
    let ours = |name: &str| name == "signorini.v1";
    for file in set.file.iter().filter(|file| ours(file.package())) {
        let package = file.package();
        for message in &file.message_type {
            add_message(&mut all, package, message);
        }
        for kind in &file.enum_type {
            add_enum(&mut all, package, kind);
        }
        for service in &file.service {
            for method in &service.method {
                let name = format!("{package}.{}/{}", service.name(), method.name());
                all.insert(name, method_form(method));
            }
        }
    }
    all
}

fn add_message(all: &mut Contract, scope: &str, message: &DescriptorProto) {
    let name = format!("{scope}.{}", message.name());
    for field in &message.field {
        all.insert(
            format!("{name}#{}", field.number()),
            field_form(message, field),
        );
    }
    for nested in &message.nested_type {
        add_message(all, &name, nested);
    }
    for kind in &message.enum_type {
        add_enum(all, &name, kind);
    }
}

fn add_enum(all: &mut Contract, scope: &str, kind: &EnumDescriptorProto) {
    for value in &kind.value {
        let key = format!("{scope}.{}={}", kind.name(), value.number());
        all.insert(key, value.name().to_owned());
    }
}

fn field_form(message: &DescriptorProto, field: &FieldDescriptorProto) -> String {
    let group = field
        .oneof_index
        .and_then(|index| message.oneof_decl.get(index as usize))
        .map_or("", |group| group.name());
    format!(
        "{} {:?} {:?} {} in '{group}'",
        field.name(),
        field.label(),
        field.r#type(),
        field.type_name()
    )
}

fn method_form(method: &MethodDescriptorProto) -> String {
    format!(
        "{} stream={} -> {} stream={}",
        method.input_type(),
        method.client_streaming(),
        method.output_type(),
        method.server_streaming()
    )
}

fn breaks(released: &FileDescriptorSet, current: &FileDescriptorSet) -> Vec<String> {
    let current = contract(current);
    contract(released)
        .into_iter()
        .filter(|(what, form)| current.get(what) != Some(form))
        .map(|(what, form)| {
            let now = current.get(&what).map_or("gone", String::as_str);
            format!("{what}: was {form}, is {now}")
        })
        .collect()
}

fn current() -> FileDescriptorSet {
    FileDescriptorSet::decode(FILE_DESCRIPTOR_SET).unwrap()
}

fn without_comments(mut set: FileDescriptorSet) -> FileDescriptorSet {
    for file in &mut set.file {
        file.source_code_info = None;
    }
    set
}

#[test]
fn current_proto_keeps_the_released_contract() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/released.binpb");
    if std::env::var_os("UPDATE_RELEASED").is_some() {
        std::fs::write(path, without_comments(current()).encode_to_vec()).unwrap();
    }
    let released = FileDescriptorSet::decode(&std::fs::read(path).unwrap()[..]).unwrap();
    let broken = breaks(&released, &current());
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn a_renumbered_field_and_a_removed_method_are_breaks() {
    let mut changed = current();
    let ours = changed
        .file
        .iter_mut()
        .find(|file| file.name().ends_with("session_service.proto"))
        .unwrap();
    ours.service[0].method.pop();
    ours.message_type[0].field[0].number = Some(77);
    assert_eq!(breaks(&current(), &changed).len(), 2);
    assert_eq!(breaks(&changed, &changed).len(), 0);
}

#[test]
fn no_field_is_unsigned_and_every_enum_starts_unspecified() {
    for (what, form) in contract(&current()) {
        assert!(
            !form.contains(" Uint") && !form.contains(" Fixed"),
            "{what}: {form}"
        );
        if what.ends_with("=0") {
            assert!(form.ends_with("_UNSPECIFIED"), "{what}: {form}");
        }
    }
}
