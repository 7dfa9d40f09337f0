use super::tests::{lattice, values};
use super::*;
use crate::geometry::vector3::{norm, sub};

#[test]
fn what_is_no_grid_is_refused_by_name() {
    let good = lattice(4, [0.0; 3], 1.0);
    let sphere = |x: [f64; 3]| norm(sub(x, [1.5; 3])) - 1.0;
    let refused = |lattice: Lattice<3>, values: &[f64]| {
        DistanceGrid::new(lattice, values).expect_err("refused")
    };
    let all = values(&good, sphere);
    let with = |change: fn(&mut Lattice<3>)| {
        let mut lattice = good;
        change(&mut lattice);
        refused(lattice, &all)
    };
    assert_eq!(
        with(|one| one.counts[1] = 3),
        GridError::FewNodes { axis: 1, count: 3 }
    );
    let limit = MOST_NODES;
    assert_eq!(
        with(|one| one.counts = [usize::MAX; 3]),
        GridError::ManyNodes { limit }
    );
    assert_eq!(
        with(|one| one.counts = [257, 256, 256]),
        GridError::ManyNodes { limit }
    );
    assert_eq!(
        with(|one| one.counts[2] = 5),
        GridError::OtherCount {
            there: 64,
            nodes: 80
        }
    );
    for spacing in [0.0, -1.0] {
        let mut lattice = good;
        lattice.spacing[2] = spacing;
        assert_eq!(
            refused(lattice, &all),
            GridError::Spacing { axis: 2, spacing }
        );
    }
    assert_eq!(
        with(|one| one.spacing[0] = f64::NAN),
        GridError::NotAPlace { axis: 0 }
    );
    assert_eq!(
        with(|one| one.spacing[0] = 1e308),
        GridError::NotAPlace { axis: 0 }
    );
    assert_eq!(
        with(|one| one.origin[1] = f64::INFINITY),
        GridError::NotAPlace { axis: 1 }
    );
    for bad in [f64::NAN, f64::INFINITY, 1e308] {
        let mut all = all.clone();
        all[4 * 4 + 2] = bad;
        let node = vec![1, 0, 2];
        assert_eq!(refused(good, &all), GridError::NotFinite { node });
    }
    let (above, below) = (vec![1.0; 64], vec![-1.0; 64]);
    assert_eq!(
        refused(good, &above),
        GridError::NoSurface { side: "below" }
    );
    assert_eq!(
        refused(good, &below),
        GridError::NoSurface { side: "above" }
    );
}

#[test]
fn a_grid_too_coarse_for_its_surface_is_refused_with_the_radius() {
    let distances = |radius: f64| {
        let lattice = lattice(25, [-1.2; 3], 0.1);
        let values = values(&lattice, |x| norm(sub(x, [0.01, 0.02, 0.03])) - radius);
        DistanceGrid::new(lattice, &values)
    };
    assert!(distances(0.32).is_ok());
    match distances(0.28) {
        Err(GridError::Coarse {
            radius, spacing, ..
        }) => {
            assert!(
                (radius - 0.28).abs() < 0.02 && (spacing - 0.1).abs() < 1e-12,
                "{radius}"
            );
        }
        other => panic!("{other:?}"),
    }
    let grid = lattice(25, [-1.2; 3], 0.1);
    let edges = |[x, y, z]: [f64; 3]| x.abs().max(y.abs()).max(z.abs()) - 0.75;
    let cube = DistanceGrid::new(grid, &values(&grid, edges));
    assert!(matches!(cube, Err(GridError::Coarse { .. })), "{cube:?}");
    let squares = |x: [f64; 3]| 9.0 * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] - 0.64);
    let squares = DistanceGrid::new(grid, &values(&grid, squares));
    assert!(matches!(squares, Err(GridError::NotADistance { slope, .. }) if slope > 10.0));
    let steep = lattice(9, [0.0; 2], 0.25);
    let step = |[x, _]: [f64; 2]| if x > 1.1 { 0.5 } else { 0.0 };
    let step = HeightField::new(steep, &values(&steep, step));
    assert!(
        matches!(step, Err(GridError::Coarse { ref node, .. }) if node.len() == 2),
        "{step:?}"
    );
}
