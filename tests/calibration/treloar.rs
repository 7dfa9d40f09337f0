//! Treloar's points: L. R. G. Treloar, Stress-strain data for vulcanised rubber under various types
//! of deformation, Trans. Faraday Soc. 40 (1944), in MPa as tabulated by P. Steinmann, M. Hossain,
//! G. Possart, Arch. Appl. Mech. 82 (2012); and fits to them by scipy's `least_squares` with the
//! textbook's formulas of the stresses and the same weights.

use signorini::calibration::{Test, TestKind};
use signorini::scene::RubberModel;

const UNIAXIAL: [[f64; 2]; 24] = [
    [1.01, 0.03],
    [1.12, 0.14],
    [1.24, 0.23],
    [1.39, 0.32],
    [1.61, 0.41],
    [1.89, 0.50],
    [2.17, 0.58],
    [2.42, 0.67],
    [3.01, 0.85],
    [3.58, 1.04],
    [4.03, 1.21],
    [4.76, 1.58],
    [5.36, 1.94],
    [5.76, 2.29],
    [6.16, 2.67],
    [6.40, 3.02],
    [6.62, 3.39],
    [6.87, 3.75],
    [7.05, 4.12],
    [7.16, 4.47],
    [7.27, 4.85],
    [7.43, 5.21],
    [7.50, 5.57],
    [7.61, 6.30],
];
const PLANAR: [[f64; 2]; 13] = [
    [1.06, 0.07],
    [1.14, 0.16],
    [1.21, 0.24],
    [1.32, 0.33],
    [1.46, 0.42],
    [1.87, 0.59],
    [2.40, 0.76],
    [2.98, 0.93],
    [3.48, 1.11],
    [3.96, 1.28],
    [4.36, 1.46],
    [4.69, 1.62],
    [4.96, 1.79],
];
const EQUIBIAXIAL: [[f64; 2]; 16] = [
    [1.04, 0.09],
    [1.08, 0.16],
    [1.12, 0.24],
    [1.14, 0.26],
    [1.20, 0.33],
    [1.31, 0.44],
    [1.42, 0.51],
    [1.69, 0.65],
    [1.94, 0.77],
    [2.49, 0.96],
    [3.03, 1.24],
    [3.43, 1.45],
    [3.75, 1.72],
    [4.03, 1.96],
    [4.26, 2.22],
    [4.44, 2.43],
];

/// All points.
pub(crate) fn points() -> Vec<Test> {
    let curves = [
        (TestKind::Uniaxial, &UNIAXIAL[..]),
        (TestKind::Planar, &PLANAR),
        (TestKind::Equibiaxial, &EQUIBIAXIAL),
    ];
    let of_curve = |(kind, rows): (TestKind, &'static [[f64; 2]])| {
        rows.iter().map(move |&[stretch, stress]| Test {
            kind,
            stretch,
            stress,
        })
    };
    curves.into_iter().flat_map(of_curve).collect()
}

/// Laws with the constants of the independent fit, terms of Ogden's law as (alpha, mu) in the order
/// of alpha, and the root of the mean square of the relative errors.
pub(crate) fn fits() -> [(RubberModel, Vec<f64>, f64); 3] {
    let any = |terms: usize| RubberModel::Ogden {
        mu: vec![0.3; terms],
        alpha: (1..=terms).map(|term| term as f64).collect(),
    };
    [
        (
            RubberModel::MooneyRivlin { c10: 1.0, c01: 0.0 },
            vec![0.181_393_3, 0.003_616_26],
            0.202_153_2,
        ),
        (
            RubberModel::Yeoh {
                c10: 1.0,
                c20: 0.0,
                c30: 0.0,
            },
            vec![0.182_022_44, -0.001_302_042, 3.804_382_8e-5],
            0.100_680_3,
        ),
        (
            any(3),
            vec![
                -1.764_050_2,
                -0.022_546_887,
                1.519_332_2,
                0.474_173_71,
                5.626_636_3,
                3.553_333_5e-4,
            ],
            0.046_407_1,
        ),
    ]
}
