//! What a session owns and changes: fields, multipliers, what drives them, and
//! the scales of its residuals.

use std::sync::Arc;

use super::drive::Drive;
use super::predictor::Trend;
use super::stability::Softest;
use super::upkeep::Upkeep;
use crate::assembly::strain::{Linearised, StrainGrid};
use crate::inequality::QpScales;
use crate::krylov::gcr::Directions;
use crate::plan::{Plan, TaylorHoodData};

/// Fields, multipliers, what drove them there and their scales, to return to.
#[derive(Clone, Debug)]
pub(crate) struct Snapshot {
    pub(super) displacement: Vec<f64>,
    pub(super) pressure: Vec<f64>,
    pub(super) multiplier: Vec<f64>,
    active: Vec<bool>,
    pub(super) drive: Drive,
    scales: QpScales,
    force_scale: f64,
    penalised: Option<Arc<StrainGrid>>,
}

impl Snapshot {
    pub(crate) fn bytes(&self) -> u64 {
        let numbers = self.displacement.len() + self.pressure.len() + self.multiplier.len();
        (8 * numbers + self.active.len()) as u64
    }
}

/// Non-dimensional state.
#[derive(Debug)]
pub(crate) struct State {
    /// Hierarchical displacement `[nodes * components]`.
    pub(crate) displacement: Vec<f64>,
    /// Pressure `[vertices]`; empty for displacement forms.
    pub(crate) pressure: Vec<f64>,
    /// Contact pressure of all obstacles, one after the other.
    pub(crate) multiplier: Vec<f64>,
    /// Multipliers in contact.
    pub(crate) active: Vec<bool>,
    /// Reached so far.
    pub(crate) drive: Drive,
    /// Of the residual blocks without a load of their own.
    pub(crate) scales: QpScales,
    /// Of the force residual when the present drive was reached.
    pub(crate) force_scale: f64,
    /// Krylov directions of earlier programs; products without contact.
    pub(crate) directions: Directions,
    /// The approximate inverse in use.
    pub(crate) upkeep: Upkeep,
    /// Cells of finite strain with a volume term; none where those of the prepared
    /// data serve.
    penalised: Option<Arc<StrainGrid>>,
    /// Of the last equilibrium; none for linear bodies.
    pub(crate) softest: Option<Softest>,
    /// How the last part moved it; none for linear bodies.
    pub(crate) trend: Option<Trend>,
    /// What the last tangent was taken about; empty for linear bodies.
    pub(crate) linearised: Arc<Linearised>,
}

impl State {
    pub(crate) fn undeformed(plan: &Plan) -> Self {
        let unknowns = plan.unknowns();
        Self {
            displacement: vec![0.0; unknowns.displacement as usize],
            pressure: vec![0.0; unknowns.pressure as usize],
            multiplier: vec![0.0; unknowns.contact as usize],
            active: vec![false; unknowns.contact as usize],
            drive: Drive::undeformed(plan.scene()),
            scales: QpScales::default(),
            force_scale: 0.0,
            directions: plan.directions(),
            upkeep: Upkeep::default(),
            softest: None,
            penalised: None,
            trend: None,
            linearised: Arc::default(),
        }
    }

    /// Cells of finite strain; none for linear bodies.
    pub(crate) fn cells<'a>(&'a self, prepared: &'a TaylorHoodData) -> Option<&'a Arc<StrainGrid>> {
        self.penalised.as_ref().or(prepared.strain.as_ref())
    }

    /// Weight of the volume term of rubber, in units of the shear modulus.
    pub(crate) fn penalty(&self) -> f64 {
        self.penalised.as_ref().map_or(0.0, |cells| cells.penalty())
    }

    /// Sets that weight.
    pub(crate) fn penalise(&mut self, prepared: &TaylorHoodData, weight: f64) {
        let cells = prepared.strain.as_ref();
        self.penalised = cells.map(|cells| Arc::new(cells.penalised(weight)));
    }

    /// Forgets what the solver has learnt beside the state itself.
    pub(crate) fn forget(&mut self, plan: &Plan) {
        self.directions = plan.directions();
        self.upkeep = Upkeep::default();
        self.softest = None;
        self.trend = None;
    }

    pub(crate) fn snapshot(&self) -> Snapshot {
        Snapshot {
            displacement: self.displacement.clone(),
            pressure: self.pressure.clone(),
            multiplier: self.multiplier.clone(),
            active: self.active.clone(),
            drive: self.drive.clone(),
            scales: self.scales,
            force_scale: self.force_scale,
            penalised: self.penalised.clone(),
        }
    }

    pub(crate) fn restore(&mut self, snapshot: &Snapshot) {
        self.displacement.copy_from_slice(&snapshot.displacement);
        self.pressure.copy_from_slice(&snapshot.pressure);
        self.multiplier.copy_from_slice(&snapshot.multiplier);
        self.active.copy_from_slice(&snapshot.active);
        self.drive = snapshot.drive.clone();
        self.scales = snapshot.scales;
        self.force_scale = snapshot.force_scale;
        self.penalised = snapshot.penalised.clone();
    }

    pub(crate) fn bytes(&self) -> u64 {
        let numbers = self.displacement.len() + self.pressure.len() + self.multiplier.len();
        (8 * numbers + self.active.len()) as u64
            + self.directions.bytes()
            + self.linearised.bytes()
            + self.upkeep.bytes()
            + self.softest.as_ref().map_or(0, Softest::bytes)
            + self.trend.as_ref().map_or(0, Trend::bytes)
    }
}
