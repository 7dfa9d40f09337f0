//! Compiles the `.proto` files without `protoc` and writes the descriptor set
//! that reflection and the compatibility test read.

use std::path::{Path, PathBuf};

use prost::Message as _;
use tonic_prost_build::Builder;

const ROOT: &str = "signorini/v1";

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Outcome<()> {
    // Printed here because the generator would name paths that do not exist and
    // so build on every call.
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed={ROOT}");
    println!("cargo:rerun-if-changed=google");
    let descriptors = protox::compile(proto_files()?, ["."])?;
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("signorini.binpb"), descriptors.encode_to_vec())?;
    let mut builder = tonic_prost_build::configure();
    if feature("SERDE") {
        builder = serialised(builder);
    }
    builder
        .build_client(feature("CLIENT"))
        .build_server(feature("SERVER"))
        .build_transport(false)
        .bytes(".")
        .btree_map(".")
        .extern_path(".google.rpc", "::tonic_types::pb")
        .emit_rerun_if_changed(false)
        .compile_fds(descriptors)?;
    Ok(())
}

/// Messages that become JSON as they are.
const SERIALISED: [&str; 26] = [
    "Attempt",
    "BodyContactResult",
    "BodyFriction",
    "CauseSite",
    "ContactInterval",
    "FluidResult",
    "GoalBound",
    "GoalResult",
    "IterationReport",
    "LeakPath",
    "ManufacturedErrors",
    "ObstaclePose",
    "ObstacleResult",
    "Plan",
    "PlanEntry",
    "PlanOmission",
    "SolverConstant",
    "ProbeResult",
    "Residuals",
    "Seconds",
    "Snapped",
    "StepReport",
    "SupportResult",
    "TieResult",
    "Unknowns",
    "Warning",
];

/// Fields that JSON spells otherwise than the wire; see `src/serialised.rs`.
const SPELLED: [(&str, &str); 14] = [
    ("Attempt.strategy", "strategy"),
    ("Attempt.cause", "cause"),
    ("Attempt.followed_by", "strategy"),
    ("StepReport.termination", "termination"),
    ("StepReport.cause", "cause"),
    ("StepReport.stability", "stability"),
    ("FluidResult.tightness", "tightness"),
    ("LeakPath.points", "vectors"),
    ("StepReport.seconds", "or_default"),
    ("StepReport.unknowns", "or_default"),
    ("StepReport.obstacle_poses", "poses"),
    ("Plan.kind", "scene_kind"),
    ("Plan.formulation", "formulation"),
    ("Plan.unknowns", "or_default"),
];

fn serialised(mut builder: Builder) -> Builder {
    for message in SERIALISED {
        let path = format!("signorini.v1.{message}");
        builder = builder.type_attribute(path, "#[derive(serde::Serialize)]");
    }
    for (field, function) in SPELLED {
        let attribute = format!("#[serde(serialize_with = \"crate::serialised::{function}\")]");
        builder = builder.field_attribute(format!("signorini.v1.{field}"), attribute);
    }
    builder
        .field_attribute("signorini.v1.ObstaclePose.name", "#[serde(skip)]")
        .field_attribute(
            "signorini.v1.StepReport.obstacle_poses",
            "#[serde(rename = \"poses\")]",
        )
        .field_attribute(
            "signorini.v1.StepReport.fluids",
            "#[serde(skip_serializing_if = \"std::collections::BTreeMap::is_empty\")]",
        )
        .field_attribute(
            "signorini.v1.StepReport.goals",
            "#[serde(skip_serializing_if = \"std::collections::BTreeMap::is_empty\")]",
        )
        .field_attribute(
            "signorini.v1.StepReport.goals_refused",
            "#[serde(skip_serializing_if = \"Option::is_none\")]",
        )
        .field_attribute(
            "signorini.v1.BodyContactResult.friction",
            "#[serde(skip_serializing_if = \"Option::is_none\")]",
        )
        .field_attribute(
            "signorini.v1.StepReport.contacts",
            "#[serde(skip_serializing_if = \"std::collections::BTreeMap::is_empty\")]",
        )
        .field_attribute(
            "signorini.v1.StepReport.ties",
            "#[serde(skip_serializing_if = \"std::collections::BTreeMap::is_empty\")]",
        )
}

fn proto_files() -> Outcome<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(Path::new(ROOT))? {
        let path = entry?.path();
        if path
            .extension()
            .is_some_and(|extension| extension == "proto")
        {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn feature(name: &str) -> bool {
    std::env::var_os(format!("CARGO_FEATURE_{name}")).is_some()
}
