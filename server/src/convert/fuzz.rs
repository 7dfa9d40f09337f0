//! No bytes make decoding, conversion and planning panic: each is taken or
//! refused with a reason, in a status that fits into trailers.

#[path = "../../../client/tests/common/fuzz/engine.rs"]
mod engine;

use bytes::Bytes;
use prost::Message;
use signorini::mesh::{CellKind, EdgeOffset, Group, GroupKind, Mesh, MeshParts};
use signorini::plan::Plan;
use signorini::report::FieldName;
use signorini_proto::array;
use signorini_proto::v1::{self as wire, upload_mesh_request::Part};

use self::engine::{Campaign, Corpus, Form};
use super::mesh::{Header, Upload};
use super::{field, report, scene, step};
use crate::config::Compared;
use crate::fault::Fault;
use crate::fault::status::rpc_status;

/// Tags and lengths of nested messages, and names of the seeds.
const WORDS: [&str; 10] = [
    "\n\u{0}",
    "\u{1a}\u{2}",
    "*\u{0}",
    "R\u{4}",
    "\u{8}\u{1}",
    "\u{b}\u{c}",
    "\u{12}\u{7f}",
    "\n\u{4}body",
    "\u{12}\u{3}top",
    "\n\u{4}ball",
];

/// Tag of field 1 with a length.
const FRAME: u8 = 0x0a;

/// A tetrahedron on the plane z = 0 with its facet there and the opposite one.
fn parts() -> MeshParts {
    let group = |name: &str, kind, member| Group {
        name: name.into(),
        kind,
        members: vec![member],
    };
    MeshParts {
        cell_kind: CellKind::Tetrahedron,
        coordinates: vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ],
        cells: vec![0, 1, 2, 3],
        facets: vec![0, 2, 1, 1, 2, 3],
        groups: vec![
            group("body", GroupKind::Cells, 0),
            group("base", GroupKind::Facets, 0),
            group("top", GroupKind::Facets, 1),
        ],
    }
}

fn ball() -> wire::Obstacle {
    let sphere = wire::Sphere {
        centre: vec![2.0, 2.0, 2.0],
        radius: Some(1.0),
    };
    wire::Obstacle {
        name: "ball".into(),
        on: vec!["top".into()],
        shape: Some(wire::Shape {
            kind: Some(wire::shape::Kind::Sphere(sphere)),
            inside: false,
        }),
        ..Default::default()
    }
}

/// The same row for each of so many.
fn given(place: wire::ValuePlace, count: usize) -> wire::Values {
    let numbers = if place == wire::ValuePlace::Facets {
        Bytes::new()
    } else {
        array::encode(&(0..count as i32).collect::<Vec<_>>())
    };
    wire::Values {
        place: place.into(),
        numbers,
        rows: array::encode(&vec![0.5; 3 * count]),
    }
}

fn load_step() -> wire::LoadStep {
    let held = Some(wire::Components {
        x: Some(0.0),
        y: None,
        z: Some(0.1),
    });
    wire::LoadStep {
        increments: Some(3),
        load: Some(0.5),
        obstacles: vec![wire::ObstacleTarget {
            name: "ball".into(),
            translation: vec![0.0, 0.0, -0.5],
            rotation: vec![0.0, 0.0, 1.0],
            ..Default::default()
        }],
        supports: vec![wire::SupportTarget {
            name: "base".into(),
            displacement: held,
            ..Default::default()
        }],
        tractions: vec![wire::TractionTarget {
            name: "wind".into(),
            values: Some(given(wire::ValuePlace::Facets, 1)),
        }],
        body_force: Some(given(wire::ValuePlace::Nodes, 4)),
        fluids: Vec::new(),
    }
}

/// Every key of contacts and of a tie between bodies.
fn paired_scene(mesh: &Mesh) -> wire::Scene {
    let seat = wire::BodyContact {
        name: "seat".into(),
        between: vec!["top".into(), "base".into()],
        carries: "base".into(),
        friction: Some(0.3),
        tresca: None,
        itself: false,
    };
    let fold = wire::BodyContact {
        name: "fold".into(),
        between: vec!["top".into()],
        carries: String::new(),
        friction: None,
        tresca: Some(0.5),
        itself: true,
    };
    let bond = wire::Tie {
        name: "bond".into(),
        between: vec!["top".into(), "base".into()],
        carries: "base".into(),
    };
    wire::Scene {
        contacts: vec![seat, fold],
        ties: vec![bond],
        ..good_scene(mesh)
    }
}

/// Every key of a fluid, and both that a step may ask of it.
fn wet_scene(mesh: &Mesh) -> wire::Scene {
    use wire::fluid_target::Load;

    let mut scene = rubber_scene(mesh);
    let water = wire::Fluid {
        name: "water".into(),
        on: vec!["top".into()],
        from: vec!["base".into()],
        dry: Vec::new(),
        pressure: Some(0.5),
        threshold: Some(0.25),
        film: wire::Film::SqueezedOut.into(),
        blow_off_tolerance: Some(0.02),
        viscosity: Some(1e-3),
    };
    let oil = wire::Fluid {
        name: "oil".into(),
        on: vec!["top".into()],
        from: vec!["top".into()],
        dry: vec!["base".into()],
        ..Default::default()
    };
    scene.fluids = vec![water, oil];
    let target = |name: &str, load| wire::FluidTarget {
        name: name.into(),
        load: Some(load),
    };
    scene.steps[0].fluids = vec![
        target("water", Load::Pressure(1.0)),
        target("oil", Load::ToBlowOff(9.0)),
    ];
    scene
}

fn good_scene(mesh: &Mesh) -> wire::Scene {
    let law = wire::LinearElastic {
        modulus: Some(wire::linear_elastic::Modulus::YoungModulus(3.0)),
        poisson_ratio: Some(0.5),
    };
    wire::Scene {
        name: "corner".into(),
        mesh: format!("meshes/{}", mesh.id()),
        mesh_scale: Some(2.0),
        units: Some(wire::UnitNames {
            length: "mm".into(),
            force: "N".into(),
            stress: "MPa".into(),
        }),
        kind: wire::SceneKind::Solid.into(),
        materials: vec![wire::Material {
            group: "body".into(),
            model: Some(wire::material::Model::LinearElastic(law)),
            ..Default::default()
        }],
        supports: vec![wire::Support {
            name: "base".into(),
            on: vec!["base".into()],
            displacement: Some(wire::Components {
                x: Some(0.0),
                y: Some(0.0),
                z: Some(0.0),
            }),
            normal: None,
            profile: wire::SupportProfile::Parabolic.into(),
            values: None,
            load: None,
        }],
        tractions: vec![wire::Traction {
            on: vec!["top".into()],
            value: vec![0.0, 0.0, -1.0],
            name: "wind".into(),
            values: Some(given(wire::ValuePlace::Facets, 1)),
        }],
        body_force_values: Some(given(wire::ValuePlace::Cells, 1)),
        body_force: vec![0.0, 0.0, -9.81],
        obstacles: vec![ball()],
        steps: vec![load_step()],
        solver: Some(wire::SolverOptions {
            tolerance: Some(1e-8),
            quadrature_degree: Some(8),
            max_wall_time: Some(60.0),
            saddle: "gcr".into(),
            ..Default::default()
        }),
        probes: vec![wire::Probe {
            name: "tip".into(),
            point: vec![0.5, 0.5, 0.5],
        }],
        gradients: vec![wire::Gradient {
            of: vec!["force.ball.z".into(), "displacement.tip.x".into()],
            to: vec!["material.body.young_modulus".into(), "load".into()],
            at: 2,
        }],
        accuracy: Some(wire::Accuracy {
            bound: vec!["reaction.base.z".into()],
            ..Default::default()
        }),
        output: Some(wire::Output {
            fields: vec![1, 2, 3],
            every: Some(2),
        }),
        ..Default::default()
    }
}

/// Rubber under a follower pressure.
fn rubber_scene(mesh: &Mesh) -> wire::Scene {
    let mut scene = good_scene(mesh);
    let law = wire::Ogden {
        mu: vec![2.0, 1.0],
        alpha: vec![2.0, -2.0],
        bulk_modulus: Some(10.0),
    };
    scene.materials[0].model = Some(wire::material::Model::Ogden(law));
    scene.pressures = vec![wire::Pressure {
        on: vec!["top".into()],
        value: Some(0.1),
    }];
    scene.steps[0].supports[0] = wire::SupportTarget {
        name: "base".into(),
        translation: vec![0.0, 0.0, 0.1],
        rotation: vec![0.0, 0.0, 20.0],
        about: vec![0.5, 0.5, 0.0],
        ..Default::default()
    };
    scene.supports[0].profile = 0;
    scene
}

/// A foam of two terms.
fn foam_scene(mesh: &Mesh) -> wire::Scene {
    let mut scene = rubber_scene(mesh);
    let law = wire::Hyperfoam {
        mu: vec![2.0, 1.0],
        alpha: vec![8.0, -2.0],
        nu: vec![0.1, 0.0],
    };
    scene.materials[0].model = Some(wire::material::Model::Hyperfoam(law));
    scene
}

/// Shapes and keys that come later are converted, too, as far as they go.
fn later_scene(mesh: &Mesh) -> wire::Scene {
    let mut scene = good_scene(mesh);
    let shape = scene.obstacles[0].shape.as_mut().unwrap();
    shape.kind = Some(wire::shape::Kind::Torus(wire::Torus::default()));
    scene.supports[0].normal = Some(0.0);
    scene
}

/// The messages of an upload as the fields of one that repeats them.
fn upload() -> Vec<u8> {
    let bent = EdgeOffset {
        ends: [0, 1],
        offset: [0.0, -0.1, 0.0],
    };
    let (parts, mesh) = (parts(), Mesh::second_order(parts(), vec![bent]).unwrap());
    let header = wire::MeshHeader {
        digest: mesh.id().to_string(),
        cell_kind: wire::CellKind::Tetrahedron.into(),
        vertex_count: 4,
        cell_count: 1,
        facet_count: 2,
        groups: super::mesh::mesh(&mesh, &unused()).groups,
        curved_edge_count: 1,
        edge_count: 0,
    };
    let indices =
        |values: &[u32]| array::encode(&values.iter().map(|v| *v as i32).collect::<Vec<_>>());
    let chunk = |array: wire::MeshArray, group_index, data| wire::MeshChunk {
        array: array.into(),
        group_index,
        offset_elements: 0,
        data,
    };
    let mut chunks = vec![
        chunk(
            wire::MeshArray::Coordinates,
            0,
            array::encode(parts.coordinates.as_flattened()),
        ),
        chunk(wire::MeshArray::Cells, 0, indices(&parts.cells)),
        chunk(wire::MeshArray::Facets, 0, indices(&parts.facets)),
        chunk(wire::MeshArray::CurvedEdges, 0, indices(&bent.ends)),
        chunk(wire::MeshArray::EdgeOffsets, 0, array::encode(&bent.offset)),
    ];
    for (index, group) in (0..).zip(&parts.groups) {
        chunks.push(chunk(
            wire::MeshArray::GroupMembers,
            index,
            indices(&group.members),
        ));
    }
    let all = std::iter::once(Part::Header(header)).chain(chunks.into_iter().map(Part::Chunk));
    let framed = |part| {
        let message = wire::UploadMeshRequest { part: Some(part) };
        let mut bytes = vec![FRAME];
        bytes.extend(message.encode_length_delimited_to_vec());
        bytes
    };
    all.flat_map(framed).collect()
}

fn unused() -> super::mesh::MeshUse {
    super::mesh::MeshUse {
        sessions: 0,
        created: std::time::UNIX_EPOCH,
        used: std::time::UNIX_EPOCH,
    }
}

/// A refusal has a reason and fits into trailers.
fn check(fault: &Fault) {
    let status = rpc_status(fault);
    assert!(!matches!(fault, Fault::Internal));
    assert!(status.encoded_len() + status.message.len() < 4096);
    assert!(!status.details.is_empty());
}

fn planned(message: wire::Scene, mesh: &Mesh) -> Result<(), Fault> {
    let request = scene::scene(message, &Default::default())?;
    let plan = request.plan(mesh, &Compared::default())?;
    report::plan(plan.report());
    Ok(())
}

#[test]
fn every_scene_is_planned_or_refused() {
    let mesh = Mesh::new(parts()).unwrap();
    let seeds = [
        good_scene(&mesh),
        rubber_scene(&mesh),
        foam_scene(&mesh),
        wet_scene(&mesh),
        paired_scene(&mesh),
        later_scene(&mesh),
    ];
    assert_eq!(planned(seeds[0].clone(), &mesh), Ok(()));
    let corpus = Corpus::new(
        Form::Messages,
        seeds.map(|scene| scene.encode_to_vec()).into(),
        &WORDS,
    );
    let (mut plans, mut refused) = (0, 0);
    Campaign::from_environment().run(&corpus, |input, _| {
        let Ok(message) = wire::Scene::decode(input) else {
            return;
        };
        match planned(message, &mesh) {
            Ok(()) => plans += 1,
            Err(fault) => {
                refused += 1;
                check(&fault);
            }
        }
    });
    eprintln!("{plans} scenes planned, {refused} refused");
    assert!(plans > 0 || refused < 1000);
}

#[test]
fn every_update_is_checked_or_refused() {
    let mesh = Mesh::new(parts()).unwrap();
    let base = scene::scene(good_scene(&mesh), &Default::default()).unwrap();
    let plan = Plan::new(&base.scene, &base.steps, &mesh).unwrap();
    let load = wire::LoadStepUpdate {
        sequence: 1,
        step: Some(load_step()),
        max_wall_time: Some(prost_types::Duration::default()),
    };
    let obstacle = wire::ObstacleUpdate {
        sequence: 1,
        obstacles: load_step().obstacles,
        increments: Some(2),
        max_wall_time: None,
    };
    let corpus = Corpus::new(
        Form::Messages,
        vec![load.encode_to_vec(), obstacle.encode_to_vec()],
        &WORDS,
    );
    let (mut taken, mut refused) = (0, 0);
    Campaign::from_environment().run(&corpus, |input, _| {
        let load = wire::LoadStepUpdate::decode(input)
            .map(|message| step::load_step(&message, Bytes::new()));
        let moved = wire::ObstacleUpdate::decode(input)
            .map(|message| step::obstacle_update(message, Bytes::new()));
        for update in [load, moved].into_iter().flatten() {
            let checked = update.and_then(|update| {
                let one = std::slice::from_ref(&update.step);
                Ok(Plan::new(plan.scene(), one, &mesh).map(drop)?)
            });
            match checked {
                Ok(()) => taken += 1,
                Err(fault) => {
                    refused += 1;
                    check(&fault);
                }
            }
        }
    });
    eprintln!("{taken} updates taken, {refused} refused");
    assert!(taken > 0 || refused < 1000);
}

/// Reads an upload as the service does.
fn uploaded(mut input: &[u8]) -> Result<Mesh, Fault> {
    let undecodable = |error: prost::DecodeError| Fault::request("upload", error.to_string());
    let mut next = || {
        let Some((_, mut rest)) = input.split_first() else {
            return Ok(None);
        };
        let message = wire::UploadMeshRequest::decode_length_delimited(&mut rest);
        input = rest;
        message.map(|message| message.part).map_err(undecodable)
    };
    let Some(Part::Header(header)) = next()? else {
        return Err(Fault::request("header", "must be the first message"));
    };
    let header = Header::new(header)?;
    assert!(header.array_bytes() < u64::MAX / 8);
    let mut upload = Upload::new(header);
    while let Some(Part::Chunk(chunk)) = next()? {
        upload.push(&chunk)?;
    }
    let invalid = |error: signorini::MeshError| Fault::MeshInvalid(error.to_string());
    let (parts, offsets) = upload.finish()?;
    Mesh::second_order(parts, offsets).map_err(invalid)
}

#[test]
fn every_upload_is_a_mesh_or_refused() {
    let corpus = Corpus::new(Form::Messages, vec![upload()], &WORDS);
    assert_eq!(uploaded(&upload()).unwrap().edge_offsets().len(), 1);
    let (mut meshes, mut refused) = (0, 0);
    Campaign::from_environment().run(&corpus, |input, _| match uploaded(input) {
        Ok(mesh) => {
            meshes += 1;
            super::mesh::mesh(&mesh, &unused());
        }
        Err(fault) => {
            refused += 1;
            check(&fault);
        }
    });
    eprintln!("{meshes} meshes, {refused} uploads refused");
    assert!(meshes > 0 || refused < 1000);
}

#[test]
fn every_list_of_fields_is_taken_or_refused() {
    let numbers = wire::ReadStepRequest {
        fields: (1..=FieldName::ALL.len() as i32).collect(),
        ..Default::default()
    };
    let corpus = Corpus::new(Form::Messages, vec![numbers.encode_to_vec()], &WORDS);
    Campaign::from_environment().run(&corpus, |input, _| {
        let Ok(request) = wire::ReadStepRequest::decode(input) else {
            return;
        };
        match field::names(&request.fields, "fields") {
            Ok(fields) => assert!(fields.len() <= FieldName::ALL.len()),
            Err(fault) => check(&fault),
        }
        field::encoding(request.element_type).ok();
    });
}
