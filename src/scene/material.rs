//! Constitutive laws as a caller writes them.
//!
//! Moduli are stresses in the caller's unit, Poisson's ratio is at most 1/2. A bulk modulus
//! that is left out means that the volume cannot change.

/// Stiffness of a linear elastic material: one modulus and Poisson's ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Modulus {
    /// Shear modulus mu, stress, above zero.
    Shear(f64),
    /// Young's modulus E, stress, above zero.
    Young(f64),
}

/// Which unknowns carry the volume constraint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Formulation {
    /// `Mixed` for Poisson's ratio of at least 0.45 and for rubber, else
    /// `Displacement`.
    #[default]
    Auto,
    /// Displacement and pressure: right for every compressibility, the incompressible
    /// included.
    Mixed,
    /// Displacement only, for compressible materials.
    Displacement,
}

/// Energy of a rubber, isochoric but of foams; i1 and i2 are invariants of F / J^(1/3).
#[derive(Clone, Debug, PartialEq)]
pub enum RubberModel {
    /// Mooney-Rivlin: C10 (i1 − 3) + C01 (i2 − 3).
    MooneyRivlin {
        /// Stress.
        c10: f64,
        /// Stress.
        c01: f64,
    },
    /// Neo-Hookean: ½ μ (i1 − 3).
    NeoHookean {
        /// μ, stress.
        shear_modulus: f64,
    },
    /// Yeoh: C10 (i1 − 3) + C20 (i1 − 3)² + C30 (i1 − 3)³.
    Yeoh {
        /// Stress.
        c10: f64,
        /// Stress.
        c20: f64,
        /// Stress.
        c30: f64,
    },
    /// Σ (μ/α) (λ1^α + λ2^α + λ3^α − 3) in the stretches λ of F / J^(1/3).
    Ogden {
        /// μ of each term, stress; one to three.
        mu: Vec<f64>,
        /// α of each term, not zero; as many.
        alpha: Vec<f64>,
    },
    /// Rivlin's polynomial: Σ c_ij (i1 − 3)^i (i2 − 3)^j, 1 ≤ i + j ≤ 3.
    Polynomial {
        /// c10, c01, c20, c11, c02, c30, c21, c12, c03, stress.
        coefficients: [f64; 9],
    },
    /// Gent: −½ μ J_m ln(1 − (i1 − 3) / J_m).
    Gent {
        /// μ, stress.
        shear_modulus: f64,
        /// J_m, the limit of i1 − 3, at least 1e-3.
        limit: f64,
    },
    /// Arruda-Boyce: five terms of the eight-chain model.
    ArrudaBoyce {
        /// μ of the series, stress.
        mu: f64,
        /// Locking stretch of the full model, above one.
        locking_stretch: f64,
    },
    /// Van der Waals: μ {−L (ln(1 − η) + η) − ⅔ a (x/2)^(3/2)}, x = (1 − β) i1 + β i2 − 3,
    /// η² = x / L, L = λ² − 3.
    VanDerWaals {
        /// μ, stress.
        shear_modulus: f64,
        /// Locking stretch λ, above √3.
        locking_stretch: f64,
        /// Interaction of the chains, at least zero.
        a: f64,
        /// Share of the second invariant, from zero to one.
        beta: f64,
    },
    /// Hyperfoam: Σ (2μ/α²) (λ1^α + λ2^α + λ3^α − 3 + (J^(−αβ) − 1)/β) in the stretches of F, with
    /// β = ν / (1 − 2ν); a foam, which has no bulk modulus beside it.
    Hyperfoam {
        /// μ of each term, stress; one to six.
        mu: Vec<f64>,
        /// α of each term, not zero; as many.
        alpha: Vec<f64>,
        /// ν of each term, above −1 and below ½; as many, or one for all.
        nu: Vec<f64>,
    },
    /// Blatz-Ko: ½ μ (I2/I3 + 2√I3 − 5); a foam, which has no bulk modulus beside it.
    BlatzKo {
        /// μ, stress.
        shear_modulus: f64,
    },
}

impl RubberModel {
    /// The name used in scenes.
    pub fn name(&self) -> &'static str {
        match self {
            Self::MooneyRivlin { .. } => "mooney-rivlin",
            Self::NeoHookean { .. } => "neo-hookean",
            Self::Yeoh { .. } => "yeoh",
            Self::Ogden { .. } => "ogden",
            Self::Polynomial { .. } => "polynomial",
            Self::Gent { .. } => "gent",
            Self::ArrudaBoyce { .. } => "arruda-boyce",
            Self::VanDerWaals { .. } => "van-der-waals",
            Self::Hyperfoam { .. } => "hyperfoam",
            Self::BlatzKo { .. } => "blatz-ko",
        }
    }
}

/// Constitutive law of one group of cells.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialModel {
    /// Linear elasticity: σ = 2μ ε(u) − p I, −div u − p/λ = 0.
    LinearElastic {
        /// Stiffness.
        modulus: Modulus,
        /// At most ½; ½ is incompressible.
        poisson_ratio: f64,
        /// Unknowns.
        formulation: Formulation,
    },
    /// σ = 2μ ε(u) − p I, −div u = 0, where u is a velocity.
    Stokes {
        /// μ, stress times time.
        viscosity: f64,
        /// A flow is always mixed.
        formulation: Formulation,
    },
    /// Isochoric energy − p (J − 1) − p²/(2K): −(J − 1) − p/K = 0. Of a foam the energy less
    /// K/2 (J − 1)² with a K of the solver's choice in the place of the isochoric one.
    Rubber {
        /// Energy.
        model: RubberModel,
        /// K, stress; `None` or infinite: the volume cannot change. `None` of a foam.
        bulk_modulus: Option<f64>,
        /// Rubber is always mixed.
        formulation: Formulation,
    },
}

impl MaterialModel {
    /// The name used in scenes.
    pub fn name(&self) -> &'static str {
        match self {
            Self::LinearElastic { .. } => "linear-elastic",
            Self::Stokes { .. } => "stokes",
            Self::Rubber { model, .. } => model.name(),
        }
    }

    /// Whether it is a rubber, for finite strain.
    pub fn is_rubber(&self) -> bool {
        matches!(self, Self::Rubber { .. })
    }
}

/// A material and the cell group it fills.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name of the group of cells that the material fills.
    pub group: String,
    /// Its constitutive law.
    pub model: MaterialModel,
}
