//! Which bytes are refused as a checkpoint, and by what name: of something else, cut
//! short, changed, forged.

use std::collections::BTreeSet;

use sha2::{Digest, Sha256};
use signorini::scene::Shape;
use signorini::{CheckpointError, Origin, Scene, Session};

use super::common::scenes::{push, small_indentation};
use super::common::take;
use super::{Ground, advance, pressed};

#[test]
fn a_checkpoint_of_another_mesh_or_scene_is_refused_by_name() {
    let (_, scene, mut session) = pressed();
    let bytes = session.export();
    let (_, finer) = small_indentation(3);
    let origin = |ground: Ground| origin(ground.refusal(&bytes));
    assert_eq!(origin(Ground::new(&scene, &finer)), Some(Origin::Mesh));
    let (_, mesh) = small_indentation(2);
    let changes: [fn(&mut Scene); 5] = [
        |scene| scene.supports[0].displacement[2] = Some(0.01),
        |scene| scene.body_force = [0.0, 0.0, -1.0],
        |scene| scene.mesh_scale = Some(2.0),
        |scene| scene.solver.tolerance = 1e-9,
        |scene| {
            let (centre, radius) = ([0.45, 0.55, 2.0], 0.99);
            scene.obstacles[0].shape = Shape::Sphere { centre, radius };
        },
    ];
    for change in changes {
        let mut changed = scene.clone();
        change(&mut changed);
        assert_eq!(origin(Ground::new(&changed, &mesh)), Some(Origin::Scene));
    }
}

#[test]
fn neither_name_nor_time_limit_make_another_scene() {
    let (ground, mut scene, mut session) = pressed();
    scene.name.push_str(", later");
    scene.solver.max_wall_time = Some(3600.0);
    let ground = Ground::new(&scene, &ground.mesh);
    assert!(ground.import(&session.export()).is_ok());
}

/// `bytes` with a digest that fits.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len().saturating_sub(32);
    let digest = Sha256::digest(&bytes[..end]);
    bytes.truncate(end);
    bytes.extend(digest);
    bytes
}

/// `bytes` with `old` replaced by `new` once, sealed again.
fn forged(bytes: &[u8], old: &[u8], new: &[u8]) -> Vec<u8> {
    let mut windows = bytes.windows(old.len());
    let place = windows
        .position(|window| window == old)
        .expect("it is there");
    let mut forged = bytes.to_vec();
    forged.splice(place..place + old.len(), new.iter().copied());
    sealed(forged)
}

#[test]
fn forged_bytes_are_refused_by_the_name_of_what_is_wrong() {
    let (ground, _, mut session) = pressed();
    let bytes = session.export();
    let step = push("ball", [0.0, 0.0, -0.05]);
    let set = take(&mut session, &step).remove(0).instruction_set;
    let depth = (-0.05_f64).to_le_bytes();
    let not_a_number = f64::NAN.to_le_bytes();
    let set_with_length = [&[set.len() as u8], set.as_bytes()].concat();
    let refused = |old: &[u8], new: &[u8]| ground.refusal(&forged(&bytes, old, new)).to_string();
    let key = ground.plan.key().0;
    let cases = [
        (refused(b"signorini", b"signorino"), "not a checkpoint"),
        (refused(b"t\n\x01\0", b"t\n\x0a\0"), "version 10"),
        (refused(&key, &[0; 32]), "another prepared data"),
        (refused(&set_with_length, b"\x03neo"), "`neo`, here"),
        (refused(b"ball", b"bell"), "`obstacle` has another name"),
        (
            refused(&depth, &not_a_number),
            "of an obstacle` is not finite",
        ),
    ];
    for (message, expected) in cases {
        assert!(message.contains(expected), "{message}");
    }
    let longer = sealed([bytes.as_slice(), &[0]].concat());
    assert!(ground.refusal(&longer).to_string().contains("`end`"));
}

#[test]
fn a_checkpoint_cut_at_any_length_is_refused() {
    let (ground, _, mut session) = pressed();
    let bytes = session.export();
    for length in 0..bytes.len() {
        let expected = match length {
            0..21 => CheckpointError::NotACheckpoint,
            _ => CheckpointError::Damaged,
        };
        assert_eq!(ground.refusal(&bytes[..length]), expected, "{length}");
        // Whoever cuts it and seals it again is found out by the fields.
        assert!(ground.import(&sealed(bytes[..length].to_vec())).is_err());
    }
}

#[test]
fn a_checkpoint_with_any_bit_flipped_is_refused() {
    let (ground, _, mut session) = pressed();
    let mut bytes = session.export();
    for bit in 0..8 * bytes.len() {
        bytes[bit / 8] ^= 1 << (bit % 8);
        let refusal = ground.refusal(&bytes);
        let is_named = match bit / 8 {
            0..21 => refusal == CheckpointError::NotACheckpoint,
            // Another version that is known has another digest.
            21..25 if ![3, 5, 9].contains(&bytes[21]) => {
                matches!(refusal, CheckpointError::UnknownVersion { known: 9, .. })
            }
            _ => refusal == CheckpointError::Damaged,
        };
        assert!(is_named, "{bit}: {refusal}");
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

/// Splitmix64.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.roll() % end as u64) as usize
    }

    /// One to four changes of `bytes`, at random; most with a digest that fits.
    fn mutated(&mut self, mut bytes: Vec<u8>) -> Vec<u8> {
        for _ in 0..=self.below(4) {
            let place = self.below(bytes.len().max(1));
            let end = bytes.len().min(place + 1 + self.below(64));
            match self.below(8) {
                0 => bytes.truncate(place),
                1 => drop(bytes.drain(place..end)),
                2 => bytes.extend_from_within(place..end),
                3 => bytes.insert(place, self.roll() as u8),
                4 => bytes[place..end.min(place + 8)].fill(0xff),
                5 => bytes[place..end].fill(0),
                6 => bytes[place..end.min(place + 1)].fill(1),
                _ => {
                    let flip = 1 << self.below(8);
                    let one = bytes[place..].first_mut();
                    one.into_iter().for_each(|byte| *byte ^= flip);
                }
            }
        }
        match self.below(4) {
            0 => bytes,
            _ => sealed(bytes),
        }
    }
}

#[test]
fn a_hundred_thousand_mutated_checkpoints_cause_no_panic() {
    const TRIES: usize = 100_000;
    let (ground, _, mut session) = pressed();
    let bytes = session.export();
    let mut dice = Dice(1);
    let (mut kinds, mut accepted) = (BTreeSet::new(), 0);
    for _ in 0..TRIES {
        match ground.import(&dice.mutated(bytes.clone())) {
            Err(refusal) => {
                kinds.insert(kind(refusal));
            }
            Ok(mut imported) => {
                // Finite numbers are a state, however far from any equilibrium.
                if accepted % 1000 == 0 {
                    take_one(&mut imported);
                }
                accepted += 1;
            }
        }
    }
    assert!((1000..TRIES / 2).contains(&accepted), "{accepted}");
    for kind in [
        "NotACheckpoint",
        "Damaged",
        "mesh",
        "instruction set",
        "displacement",
        "end",
    ] {
        assert!(kinds.contains(kind), "{kind}: {kinds:?}");
    }
}

/// What was refused: the field, the origin, or the whole.
fn kind(refusal: CheckpointError) -> String {
    if let CheckpointError::Malformed { field, .. } = refusal {
        return field.to_owned();
    }
    let whole = format!("{refusal:?}");
    origin(refusal).map_or(whole, |origin| origin.to_string())
}

/// What the checkpoint is another one of, if that is why it is refused.
fn origin(refusal: CheckpointError) -> Option<Origin> {
    if let CheckpointError::Foreign { origin, .. } = refusal {
        return Some(origin);
    }
    None
}

fn take_one(session: &mut Session) {
    let step = push("ball", [0.0, 0.0, -0.06]);
    let mut run = session.begin_step(&step).expect("a valid step");
    assert!(advance(session, &mut run).is_some());
}
