//! The frame does not matter to rubber: a bonded body under a ball, turned and
//! carried elsewhere with all that acts on it, gives the same numbers after as many
//! iterations.

use crate::common::meshes::{cube, irregular, mesh, moved};
use crate::common::scenes::{
    HELD, mooney_rivlin, obstacle, probe, push, rubber, support, traction,
};
use crate::common::solve_one;
use signorini::StepReport;
use signorini::geometry::{Matrix3, rotation_matrix};
use signorini::scene::Shape;

/// x -> R x + t.
struct Frame {
    rotation: Matrix3,
    origin: [f64; 3],
}

impl Frame {
    fn new(rotation: [f64; 3], origin: [f64; 3]) -> Self {
        let rotation = rotation_matrix(rotation);
        Self { rotation, origin }
    }

    fn vector(&self, x: [f64; 3]) -> [f64; 3] {
        let row = |row: [f64; 3]| row.iter().zip(x).map(|(r, x)| r * x).sum();
        self.rotation.map(row)
    }

    fn point(&self, x: [f64; 3]) -> [f64; 3] {
        let turned = self.vector(x);
        [0, 1, 2].map(|i| turned[i] + self.origin[i])
    }
}

/// A bonded block, pressed at an angle by a ball and pulled at its side.
fn solve(frame: &Frame) -> StepReport {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.solver.tolerance = 1e-11;
    scene.supports = vec![support("z0", HELD)];
    scene.tractions = vec![traction("x1", frame.vector([0.05, 0.1, -0.05]))];
    let shape = Shape::Sphere {
        centre: frame.point([0.45, 0.55, 2.0]),
        radius: 1.0,
    };
    scene.obstacles = vec![obstacle("ball", "z1", shape)];
    scene.probes = vec![probe("inside", frame.point([0.6, 0.5, 0.7]))];
    let step = push("ball", frame.vector([0.02, 0.0, -0.15]));
    let parts = moved(irregular(cube(3), 3), |x| frame.point(x));
    solve_one(&scene, &step, &mesh(parts))
}

fn assert_close(name: &str, value: &[f64], expected: &[f64]) {
    let size = expected.iter().map(|x| x * x).sum::<f64>().sqrt();
    for (value, expected) in value.iter().zip(expected) {
        let error = (value - expected).abs() / size;
        assert!(error <= 1e-9, "{name}: {value} not {expected}, {error:e}");
    }
}

#[test]
fn a_turned_and_carried_body_gives_the_same_numbers() {
    let at_home = solve(&Frame::new([0.0; 3], [0.0; 3]));
    assert!(at_home.active_vertices > 0);
    for (rotation, origin) in [
        ([0.3, -1.1, 2.0], [0.0; 3]),
        ([0.0; 3], [5.0, -3.0, 11.0]),
        ([-2.2, 0.4, 0.9], [-40.0, 25.0, 8.0]),
    ] {
        let frame = Frame::new(rotation, origin);
        let away = solve(&frame);
        assert!(away.sqp_iterations.abs_diff(at_home.sqp_iterations) <= 1);
        assert!(
            away.preconditioner_applications
                .abs_diff(at_home.preconditioner_applications)
                <= 3,
            "{} {}",
            away.preconditioner_applications,
            at_home.preconditioner_applications
        );
        assert_eq!(away.active_vertices, at_home.active_vertices);
        assert_close("energy", &[away.strain_energy], &[at_home.strain_energy]);
        let jacobian = |report: &StepReport| report.min_jacobian.expect("a rubber");
        assert_close("jacobian", &[jacobian(&away)], &[jacobian(&at_home)]);
        let (new, old) = (&away.obstacles["ball"], &at_home.obstacles["ball"]);
        assert_close("force", &new.force, &frame.vector(old.force));
        assert_close("peak", &[new.max_pressure], &[old.max_pressure]);
        let areas = [new, old].map(|ball| ball.deformed_contact_area);
        assert_close("extent", &areas[..1], &areas[1..]);
        let centre = frame.point(old.centre_of_pressure);
        assert_close("centre", &new.centre_of_pressure, &centre);
        let reaction = frame.vector(at_home.supports["z0"].force);
        assert_close("reaction", &away.supports["z0"].force, &reaction);
        let (new, old) = (&away.probes["inside"], &at_home.probes["inside"]);
        assert_close(
            "displacement",
            &new.displacement,
            &frame.vector(old.displacement),
        );
        assert_close("pressure", new.pressure.as_slice(), old.pressure.as_slice());
    }
}
