//! Cylinders pressed and slid against each other, beside an independent code.
//!
//! That code has straight cells with curved gaps, and closest points in place of rays: forces differ
//! by what the mesh resolves, some 1e-3.

use super::scenes::{between, rubber};
use crate::common::meshes::curved_file;
use crate::common::scenes::{HELD_IN_PLANE, pull, support};
use crate::common::{assert_converged, close, solve};
use signorini::scene::SupportTarget;
use signorini::{Scene, Step, StepReport, Termination};

/// Quarters of two cylinders of radius one, the carrier `s` above, 0.1 nearer to each other.
fn pressed(moduli: [f64; 2], carrier: [&str; 2]) -> StepReport {
    let scene = Scene {
        supports: vec![
            support("s_eq", [None, Some(0.0), None]),
            support("m_eq", [None, Some(0.0), None]),
            support("s_axis", [Some(0.0), None, None]),
            support("m_axis", [Some(0.0), None, None]),
        ],
        contacts: between(carrier[0], carrier[1]),
        ..rubber([("slave", moduli[0]), ("master", moduli[1])], None)
    };
    let target = |name: &str, way: f64| SupportTarget {
        name: name.to_owned(),
        displacement: [None, Some(way), None],
        ..SupportTarget::default()
    };
    let step = Step {
        supports: vec![target("s_eq", -0.05), target("m_eq", 0.05)],
        ..Step::default()
    };
    let mut reports = solve(&scene, &[step], &curved_file("pair_discs"));
    let report = reports.remove(0);
    assert!(report.sqp_iterations <= 6, "{}", report.sqp_iterations);
    assert_eq!(
        (report.termination, report.cause),
        (Termination::Converged, None)
    );
    let [above, below] = ["s_eq", "m_eq"].map(|name| report.supports[name].force[1]);
    assert!(
        (above + below).abs() < 1e-6 * above.abs(),
        "{above} {below}"
    );
    report
}

/// Force of the contact across its middle, of the first group.
fn force(report: &StepReport) -> f64 {
    report.contacts["pair"].force[1].abs()
}

#[test]
fn two_cylinders_press_as_an_independent_code_has_it() {
    // Reference of that code on a mesh of h = .008.
    let fine = 0.064032485;
    for carrier in [["s_con", "m_con"], ["m_con", "s_con"]] {
        let report = pressed([1.0, 1.0], carrier);
        assert!(
            close(force(&report), fine, 5e-3),
            "{carrier:?} {}",
            force(&report)
        );
        assert!(close(report.strain_energy, 0.00286257132089, 5e-3));
        // Hertz, p0^2 = F E* / (pi R): whole cylinders, E* = 2 mu, R = 1/2.
        let hertz = (2.0 * force(&report) * 2.0 / std::f64::consts::PI / 0.5).sqrt();
        let peak = report.contacts["pair"].peak_pressure;
        assert!(close(peak, hertz, 0.01), "{peak} {hertz}");
    }
}

#[test]
fn a_stiff_cylinder_presses_into_a_soft_one_from_either_side() {
    let mut found = Vec::new();
    for carrier in [["s_con", "m_con"], ["m_con", "s_con"]] {
        found.push(force(&pressed([1.0, 10.0], carrier)));
    }
    assert!(close(found[0], 0.117380718144, 1e-2), "{found:?}");
    assert!(close(found[1], found[0], 1e-2), "{found:?}");
}

#[test]
fn a_half_disc_slides_over_a_slab_as_an_independent_code_has_it() {
    let scene = Scene {
        supports: vec![
            support("s_bot", HELD_IN_PLANE),
            support("d_top", HELD_IN_PLANE),
        ],
        contacts: between("d_con", "s_top"),
        ..rubber([("disc", 1.0), ("slab", 1.0)], None)
    };
    let steps = [
        pull("d_top", [Some(0.0), Some(-0.08), None], 1),
        pull("d_top", [Some(0.1), Some(-0.08), None], 1),
    ];
    let reports = solve(&scene, &steps, &curved_file("pair_slide"));
    for report in &reports {
        assert_eq!(report.termination, Termination::Converged);
    }
    let [fx, fy, _] = reports[1].contacts["pair"].force;
    assert!(close(fy, 0.218568182272, 5e-3), "{fy}");
    assert!(fx.abs() < 5e-3 * fy, "{fx}");
    let programs = [0, 1].map(|k: usize| reports[k].sqp_iterations);
    assert!(programs[0] <= 6 && programs[1] <= 4, "{programs:?}");
}

/// Applications of the preconditioner to press a cylinder of that modulus into one of modulus one,
/// led from its own side, and to press it further.
fn applications_to_lead(modulus: f64) -> [u32; 2] {
    let scene = Scene {
        supports: vec![
            support("s_eq", [Some(0.0), Some(0.0), None]),
            support("m_eq", HELD_IN_PLANE),
        ],
        contacts: between("m_con", "s_con"),
        ..rubber([("slave", modulus), ("master", 1.0)], None)
    };
    let step = pull("s_eq", [None, Some(-0.1), None], 2);
    let reports = solve(&scene, &[step], &curved_file("pair_discs"));
    reports.iter().for_each(assert_converged);
    [0, 1].map(|increment| reports[increment].preconditioner_applications)
}

#[test]
fn a_stiff_cylinder_that_is_led_costs_about_what_a_soft_one_does() {
    let even = applications_to_lead(1.0);
    for modulus in [1e2, 1e4, 1e6] {
        let found = applications_to_lead(modulus);
        for (found, even) in found.iter().zip(even) {
            assert!(10 * found <= 18 * even, "{modulus}: {found} beside {even}");
        }
    }
}
