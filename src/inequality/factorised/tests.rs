//! Motions that lower the energy, and the bound on a factor, of small problems.

use super::*;
use crate::inequality::QpStatus;
use crate::linalg::samples::rows;
use crate::linalg::{SparseRows, SparseRowsBuilder, Workspace};

/// Two unknowns, one of which lowers the energy.
fn unstable(contact: &SparseRows) -> Matrices<'_> {
    Matrices {
        stiffness: rows(&[vec![-1.0, 0.0], vec![0.0, 2.0]]),
        coupling: None,
        stabilisation: None,
        contact,
        places: vec![0, 1],
        has_rigid_modes: false,
        most_flops: f64::INFINITY,
    }
}

#[test]
fn a_factor_beyond_its_bound_is_not_made() {
    let contact = SparseRowsBuilder::new(2).finish();
    let matrices = Matrices {
        most_flops: 1.0,
        ..unstable(&contact)
    };
    assert_eq!(BodyFactor::new(&matrices).err(), Some(QpStatus::TooLarge));
}

#[test]
fn loads_without_a_potential_lead_back_what_lowers_the_energy_where_they_are_strong() {
    // Eigenvalues of [[-1, s], [-s, 2]]: one is negative for s^2 < 2, none for s^2 > 2.
    let contact = SparseRowsBuilder::new(2).finish();
    let matrices = unstable(&contact);
    for (strength, led_back) in [(0.5, 0), (1.4, 0), (1.42, 1), (3.0, 1)] {
        let skew = rows(&[vec![0.0, strength], vec![-strength, 0.0]]);
        let problem = (&matrices, Some(&skew));
        let found = inertia(problem, &[], &[1.0, 1.0], &mut Workspace::new()).expect("a factor");
        assert_eq!(
            (found.unstable, found.led_back),
            (1, Some(led_back)),
            "{strength}"
        );
    }
}
