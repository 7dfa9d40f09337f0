//! From which step on a linear body is solved by its response at the contact surface
//! (decision 46): from the first one where the scene asks for it, else where a session has
//! taken so many steps that what it saves has paid for the factor, if that is small.

use super::report::LaterBytes;
use super::{Plan, estimate};
use crate::scene::{ReportScope, ResponseMethod};

/// Bytes of the largest response that is made unasked.
const MOST_UNASKED: f64 = 6.4e7;
/// Estimated operations a second that factor and columns take: 104 + 243 Gflop in 11.9 s on
/// 40 602 unknowns, 0.6 + 1.1 in 0.11 s on 3286.
const RATE: f64 = 2.5e10;
/// Seconds of an application of the displacement preconditioner for each unknown.
const APPLICATION: f64 = 2e-7;
/// Applications of an update.
const APPLICATIONS: f64 = 13.0;
/// Steps that are taken by iterations however small the body: they tell how it went.
const FEWEST_STEPS: u32 = 9;
/// Share of the surface that presses.
const PRESSED: f64 = 1.0 / 3.0;

/// Bytes of whole columns over those of the factor at most.
const MOST_WHOLE: f64 = 2.0;

/// What all fields of an update come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum FieldsFrom {
    /// One solution with the factor.
    #[default]
    Factor,
    /// The columns that press, kept whole.
    Columns,
}

/// The choice.
#[derive(Clone, Debug, Default)]
pub(crate) struct ResponseChoice {
    /// The first step that is; none where none is.
    pub(crate) from: Option<u32>,
    /// What its fields come from.
    pub(crate) fields: FieldsFrom,
    /// Why.
    pub(super) reason: String,
}

impl ResponseChoice {
    /// The choice that is none, and why.
    fn none(reason: impl Into<String>) -> Self {
        Self {
            reason: reason.into(),
            ..Self::default()
        }
    }

    /// From that step on.
    fn from(plan: &Plan, step: u32, reason: &str) -> Self {
        Self {
            from: Some(step),
            fields: plan.fields_from(step),
            reason: reason.into(),
        }
    }
}

/// The choice that the scene names, or the one that its size asks for.
///
/// # Errors
/// Why a scene that asks for it has none.
pub(super) fn choose(plan: &Plan) -> Result<ResponseChoice, String> {
    let asked = plan.problem.scene.solver.response.named();
    if plan.problem.settings.report == ReportScope::Contact {
        return of_contact_alone(plan, asked);
    }
    match (asked, hindrance(plan)) {
        (Some(ResponseMethod::Iterative), _) => Ok(ResponseChoice::none("asked for")),
        (Some(ResponseMethod::Condensed), Some(hindrance)) => Err(hindrance),
        (Some(ResponseMethod::Condensed), None) => Ok(ResponseChoice::from(plan, 1, "asked for")),
        (None, Some(hindrance)) => Ok(ResponseChoice::none(hindrance)),
        (None, None) if plan.least_response_bytes() > MOST_UNASKED => {
            let gigabytes = 1e-9 * plan.least_response_bytes();
            let words = format!("factor and columns may take {gigabytes:.1} GB");
            Ok(ResponseChoice::none(words))
        }
        (None, None) => {
            let step = 1 + paid_after(plan).max(FEWEST_STEPS);
            let reason = "what it saves has paid for its factor by then";
            Ok(ResponseChoice::from(plan, step, reason))
        }
    }
}

/// The choice of a scene whose reports are on contact alone: from the first step on.
///
/// # Errors
/// Why it has none.
fn of_contact_alone(plan: &Plan, asked: Option<ResponseMethod>) -> Result<ResponseChoice, String> {
    let reasons = [
        (
            asked == Some(ResponseMethod::Iterative),
            "the response is `iterative`",
        ),
        (plan.problem.settings.verify, "residuals are verified"),
        (
            plan.problem.resolved.manufactured.is_some(),
            "errors against a field are asked for",
        ),
    ];
    let reason = reasons.into_iter().find(|(hinders, _)| *hinders);
    let reason = reason.map(|(_, reason)| reason.to_owned());
    match reason.or_else(|| hindrance(plan)) {
        Some(reason) => Err(format!("`report = \"contact\"` has no answer: {reason}")),
        None => Ok(ResponseChoice::from(
            plan,
            1,
            "reports are on contact alone",
        )),
    }
}

/// Steps after which what is saved has paid for factor and columns.
fn paid_after(plan: &Plan) -> u32 {
    let (bytes, flops) = plan.factor_of_body();
    // Two operations an entry in each of two triangles.
    let columns = 0.5 * bytes * PRESSED * plan.surface_unknowns();
    let unknowns = (plan.problem.unknowns.displacement + plan.problem.unknowns.pressure) as f64;
    ((flops + columns) / RATE / (APPLICATIONS * APPLICATION * unknowns)).ceil() as u32
}

impl Plan {
    /// Bytes of the factor of the body and operations to make it.
    fn factor_of_body(&self) -> (f64, f64) {
        estimate::saddle_factor(self.problem.units.dimension, self.problem.unknowns)
    }

    /// Unknowns of the surface at most: as many nodes as multipliers.
    fn surface_unknowns(&self) -> f64 {
        (self.problem.units.dimension as u64 * self.problem.unknowns.contact) as f64
    }

    /// Bytes of factor and columns at most, these on the surface alone.
    fn least_response_bytes(&self) -> f64 {
        self.factor_of_body().0 + 8.0 * self.surface_unknowns().powi(2)
    }

    /// Bytes of columns kept whole at most.
    fn whole_bytes(&self) -> f64 {
        let unknowns = (self.problem.unknowns.displacement + self.problem.unknowns.pressure) as f64;
        8.0 * self.surface_unknowns() * unknowns
    }

    /// What fields come from where the response begins at that step: whole columns are read
    /// once, a factor twice and by one thread, but there may be no room for them.
    fn fields_from(&self, step: u32) -> FieldsFrom {
        let (whole, factor) = (self.whole_bytes(), self.factor_of_body().0);
        let most = match step {
            1 => f64::INFINITY,
            _ => MOST_UNASKED,
        };
        let is_small = whole <= MOST_WHOLE * factor && self.least_response_bytes() + whole <= most;
        if is_small {
            FieldsFrom::Columns
        } else {
            FieldsFrom::Factor
        }
    }

    /// Bytes of the response that was chosen, at most.
    fn response_bytes(&self) -> f64 {
        let whole = match self.decisions.response.fields {
            FieldsFrom::Columns => self.whole_bytes(),
            FieldsFrom::Factor => 0.0,
        };
        self.least_response_bytes() + whole
    }

    /// The response in words: from which step on.
    pub(super) fn response_in_words(&self) -> Option<(String, &str)> {
        let from = self.decisions.response.from?;
        let words = match from {
            1 => "condensed on the contact surface".to_owned(),
            _ => format!("condensed on the contact surface from step {from} on"),
        };
        Some((words, &self.decisions.response.reason))
    }

    /// What sessions may take once they come to the step from which on they keep the response;
    /// none where they do from the first, or never.
    pub fn later_bytes(&self) -> Option<LaterBytes> {
        let from_step = self.decisions.response.from.filter(|&from| from > 1)?;
        let bytes = self.predicted_response_bytes();
        Some(LaterBytes { from_step, bytes })
    }

    /// Bytes that the response may take in a session.
    pub(super) fn predicted_response_bytes(&self) -> u64 {
        match self.decisions.response.from {
            Some(_) => self.response_bytes() as u64,
            None => 0,
        }
    }
}

/// Why a body has no response that could be kept; none where it has one.
fn hindrance(plan: &Plan) -> Option<String> {
    let reasons = [
        (plan.normal_multipliers() == 0, "no obstacle"),
        (plan.problem.resolved.is_rubber(), "the body is not linear"),
        (plan.has_friction(), "friction depends on the way"),
        (plan.is_floating(), "supports leave rigid modes"),
        (!plan.problem.pairs.is_empty(), "bodies touch each other"),
        (
            !plan.problem.ties.is_empty(),
            "bodies are tied to each other",
        ),
        (
            !plan.problem.resolved.pressures.is_empty(),
            "pressures follow the body",
        ),
        (
            !plan.problem.resolved.fluids.is_empty(),
            "a fluid changes what it presses on",
        ),
        (plan.penalty() > 0.0, "a penalty was asked for"),
        (!plan.names_no_method(), "another method was asked for"),
    ];
    let reason = reasons.into_iter().find(|(hinders, _)| *hinders);
    let flops = plan.factor_of_body().1;
    let is_dear = flops > estimate::MOST_RESPONSE_FLOPS;
    let [flops, most] = [flops, estimate::MOST_RESPONSE_FLOPS].map(|flops| 1e-9 * flops);
    let dear = || format!("the factor takes {flops:.0} Gflop, above {most:.0}");
    let reason = reason.map(|(_, reason)| reason.to_owned());
    reason.or_else(|| is_dear.then(dear))
}
