//! What a plan says of rubber, and what it adds to the key of prepared data.

use sha2::{Digest, Sha256};

use super::Plan;
use crate::material::{Isochoric, Rubber};
use crate::scene::MaterialModel;

/// Adds the coefficients of a law, in units of `stress`.
pub(super) fn hash(rubber: &Rubber, stress: f64, hash: &mut Sha256) {
    match &rubber.isochoric {
        Isochoric::Invariants(law) => {
            hash.update(b"invariants");
            for coefficient in [law.c10, law.c01, law.c20, law.c30] {
                hash.update((coefficient / stress).to_le_bytes());
            }
        }
    }
}

impl Plan {
    /// Laws with their bulk moduli, each once.
    pub(super) fn rubber_laws(&self) -> String {
        let mut laws: Vec<String> = Vec::new();
        for material in &self.scene.materials {
            let MaterialModel::Rubber {
                model,
                bulk_modulus,
                ..
            } = &material.model
            else {
                continue;
            };
            let law = match bulk_modulus.filter(|bulk| bulk.is_finite()) {
                None => format!("{}, incompressible", model.name()),
                Some(bulk) => format!("{}, bulk modulus {bulk}", model.name()),
            };
            if !laws.contains(&law) {
                laws.push(law);
            }
        }
        laws.join("; ")
    }

    /// The rule that integrates stress and tangent.
    pub(super) fn rubber_rule(&self) -> (String, &'static str) {
        match self.scene.solver.quadrature_degree {
            Some(degree) => (format!("degree {degree}"), "asked for"),
            None => ("automatic degree".to_owned(), "error against run time"),
        }
    }

    /// Decisions that only rubber needs.
    pub(super) fn push_rubber(&self, push: &mut dyn FnMut(&str, String, &str)) {
        if !self.resolved.is_rubber() {
            return;
        }
        let reason = "isochoric energy and volume constraint at finite strain";
        push("material", self.rubber_laws(), reason);
        let (rule, reason) = self.rubber_rule();
        push("volume rule", rule, reason);
        push(
            "tangent",
            "from F and p at quadrature points, never stored as a matrix".into(),
            "both change with every iteration",
        );
        push(
            "refactorisation",
            "when a solve takes 1.5 times the applications of the first with this factor".into(),
            "a rule on counts, the same on every machine",
        );
    }
}
