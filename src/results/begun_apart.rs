//! Linear bodies that press each other though they were apart at rest, or inside each other. Their gaps are
//! linear about rest,
//!
//! ```text
//! G(u) = G(0) + C u,   C = dG at rest
//! ```
//!
//! and C has parts that grow with the gap there: what surfaces between which volume lies stretch and turn by.
//! Two blocks that close a gap of .05, .1, .3 of their side press by 4, 11, 43 % too little (E = 1, nu = .3;
//! measured), balls by 51 % too much at .1. Rubber has gaps of the deformed bodies and nothing of this. Cost: one
//! evaluation of the residuals an increment of linear bodies in contact.

use crate::linalg::Workspace;
use crate::model::Model;
use crate::model::evaluate::evaluate;
use crate::model::interfaces::Interface;
use crate::model::state::State;
use crate::report::{Seconds, Warning, WarningKind};

/// Gap at rest over the length of the body from which on a word is due: forces are then off by some
/// tenths of a per cent or more.
const APART: f64 = 2e-3;

/// A warning for each contact between linear bodies whose pressed parts were apart at rest.
pub(crate) fn begun_apart(model: &Model<'_>, state: &State) -> Vec<Warning> {
    let pairs = model.interfaces.list.iter();
    let pairs: Vec<&Interface> = pairs.filter(|one| one.pair().is_some()).collect();
    if !model.is_linear() || pairs.is_empty() {
        return Vec::new();
    }
    let mut rest = state.clone();
    rest.displacement.fill(0.0);
    let work = &mut Workspace::new();
    let gaps = evaluate(model, &rest, &mut Seconds::default(), work).gap;
    let widest = |interface: &Interface| {
        let own = interface.places().zip(&interface.surface.weights);
        let pressed = own.filter(|(place, _)| state.multiplier[*place] > 0.0);
        let depths = pressed.map(|(place, weight)| (gaps[place] / weight).abs());
        depths.fold(0.0, f64::max)
    };
    let all = pairs.into_iter().map(|one| (one, widest(one)));
    let apart = all.filter(|(_, gap)| *gap > APART);
    apart.map(|(one, gap)| warning(model, (one, gap))).collect()
}

fn warning(model: &Model<'_>, (interface, gap): (&Interface, f64)) -> Warning {
    let name = &interface.name;
    let (percent, width) = (100.0 * gap, gap * model.plan.problem.units.length);
    Warning::new(
        WarningKind::LargeStrain,
        name,
        Some(gap),
        format!(
            "contact `{name}`: what presses was {width:.2e} apart or overlapped at rest, {percent:.1} % of the body: gaps of \
             linear bodies are linear about rest, and forces are off by about as much of themselves; let them \
             begin in touch, or use a law of rubber"
        ),
    )
}
