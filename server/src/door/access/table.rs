//! Which role each method needs, in one place.

use super::Role;

/// What a method asks of its caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Need {
    /// Nothing: probes have no token.
    Nothing,
    /// An entry with this role or one above.
    Role(Role),
}

/// Whether a call leaves something changed, and so an audit line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    Looks,
    Changes,
}

/// A method by its path, what it asks and what it does.
pub(super) type Rule = (&'static str, Need, Effect);

const NOTHING: Need = Need::Nothing;
const READ: Need = Need::Role(Role::Read);
const SOLVE: Need = Need::Role(Role::Solve);
use Effect::{Changes, Looks};

/// Every method that is served.
pub(super) const TABLE: [Rule; 27] = [
    ("/grpc.health.v1.Health/Check", NOTHING, Looks),
    ("/grpc.health.v1.Health/Watch", NOTHING, Looks),
    (
        "/grpc.reflection.v1.ServerReflection/ServerReflectionInfo",
        READ,
        Looks,
    ),
    (
        "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
        READ,
        Looks,
    ),
    ("/signorini.v1.MeshService/UploadMesh", SOLVE, Changes),
    ("/signorini.v1.MeshService/GetMesh", READ, Looks),
    ("/signorini.v1.MeshService/ListMeshes", READ, Looks),
    ("/signorini.v1.MeshService/ReadMesh", READ, Looks),
    ("/signorini.v1.MeshService/DeleteMesh", SOLVE, Changes),
    ("/signorini.v1.MeshService/RefineMesh", SOLVE, Changes),
    ("/signorini.v1.SurfaceService/UploadSurface", SOLVE, Changes),
    ("/signorini.v1.SurfaceService/GetSurface", READ, Looks),
    ("/signorini.v1.SurfaceService/ListSurfaces", READ, Looks),
    ("/signorini.v1.SurfaceService/ReadSurface", READ, Looks),
    ("/signorini.v1.SurfaceService/DeleteSurface", SOLVE, Changes),
    ("/signorini.v1.SessionService/CreateSession", SOLVE, Changes),
    ("/signorini.v1.SessionService/GetSession", READ, Looks),
    ("/signorini.v1.SessionService/ListSessions", READ, Looks),
    ("/signorini.v1.SessionService/DeleteSession", SOLVE, Changes),
    ("/signorini.v1.SessionService/Solve", SOLVE, Changes),
    ("/signorini.v1.SessionService/Watch", READ, Looks),
    ("/signorini.v1.SessionService/CancelStep", SOLVE, Changes),
    ("/signorini.v1.SessionService/ReadStep", READ, Looks),
    ("/signorini.v1.SessionService/ExportState", READ, Looks),
    ("/signorini.v1.SessionService/SaveState", SOLVE, Changes),
    ("/signorini.v1.SessionService/RestoreState", SOLVE, Changes),
    ("/signorini.v1.SessionService/ImportState", SOLVE, Changes),
];

/// The rule of a path. What is not in the table, and so not served, only an administrator may ask.
pub(super) fn rule(path: &str) -> Rule {
    let known = TABLE.iter().find(|(known, ..)| *known == path);
    let unknown = ("", Need::Role(Role::Admin), Looks);
    known.copied().unwrap_or(unknown)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use prost::Message as _;
    use prost_types::FileDescriptorSet;

    use super::*;

    fn paths(set: &[u8]) -> Vec<String> {
        let mut all = Vec::new();
        for file in FileDescriptorSet::decode(set).unwrap().file {
            for service in &file.service {
                let name = format!("/{}.{}/", file.package(), service.name());
                let methods = service.method.iter();
                all.extend(methods.map(|method| format!("{name}{}", method.name())));
            }
        }
        all
    }

    #[test]
    fn every_method_of_the_contract_has_its_rule_and_no_other() {
        let served: BTreeSet<String> = [
            signorini_proto::FILE_DESCRIPTOR_SET,
            tonic_health::pb::FILE_DESCRIPTOR_SET,
            tonic_reflection::pb::v1::FILE_DESCRIPTOR_SET,
            tonic_reflection::pb::v1alpha::FILE_DESCRIPTOR_SET,
        ]
        .into_iter()
        .flat_map(paths)
        .collect();
        let told = TABLE.iter().map(|(path, ..)| (*path).to_owned());
        assert_eq!(told.collect::<BTreeSet<_>>(), served);
        assert_eq!(TABLE.len(), served.len());
        assert_eq!(
            rule("/signorini.v1.SessionService/New").1,
            Need::Role(Role::Admin)
        );
    }

    #[test]
    fn what_changes_something_needs_more_than_to_look() {
        for (path, need, effect) in TABLE {
            if effect == Changes {
                assert_eq!(need, SOLVE, "{path}");
            }
        }
    }
}
