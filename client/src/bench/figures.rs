//! The diagrams of a report, family by family.

use std::collections::BTreeSet;

use super::chart::{Bar, Bars, Curve, Diagram, Kind, Level, Point, State, Stroke};
use super::estimates;
use super::families::FAMILIES;
use super::family::{Family, Quantity};
use super::increments;
use super::limit::Limit;
use super::machine::Machine;
use super::measure::PHASES;
use super::peers::{Peer, Peers};
use super::plan::Place;
use super::reference::References;
use super::row::Row;
use crate::text::number;

/// What figures are drawn from.
#[derive(Debug)]
pub(crate) struct Results {
    pub(crate) rows: Vec<Row>,
    pub(crate) peers: Peers,
    pub(crate) references: References,
    pub(crate) machine: Machine,
}

/// A picture and the stem of its file name.
#[derive(Clone, Debug)]
pub(crate) struct Figure {
    pub(crate) name: String,
    pub(crate) svg: String,
}

/// The figures of one family.
#[derive(Clone, Debug)]
pub(crate) struct Chapter {
    pub(crate) family: &'static Family,
    pub(crate) figures: Vec<Figure>,
}

/// What a point has across: a name for files, and a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cost {
    Seconds,
    Memory,
}

impl Cost {
    fn name(self) -> &'static str {
        match self {
            Self::Seconds => "seconds",
            Self::Memory => "memory",
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::Seconds => "time",
            Self::Memory => "memory",
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Seconds => "wall time of the solve, cold process (s)",
            Self::Memory => "peak memory of the process (MB)",
        }
    }

    fn of(self, row: &Row) -> Option<f64> {
        match self {
            Self::Seconds => Some(row.numbers.seconds),
            Self::Memory => row.peak_memory_mb(),
        }
    }

    fn of_peer(self, peer: &Peer) -> Option<f64> {
        match self {
            Self::Seconds => Some(peer.seconds),
            Self::Memory => peer.peak_memory_mb,
        }
    }
}

impl Results {
    /// All figures.
    pub(crate) fn chapters(&self) -> Vec<Chapter> {
        let families = FAMILIES
            .iter()
            .filter(|family| !self.curves_of(family).is_empty());
        let chapter = |family| Chapter {
            family,
            figures: self.figures(family),
        };
        families.map(chapter).collect()
    }

    /// Instruction sets that the rows name.
    pub(crate) fn instruction_sets(&self) -> String {
        let sets = self
            .rows
            .iter()
            .map(|row| row.numbers.instruction_set.as_str());
        let sets: BTreeSet<&str> = sets.filter(|set| !set.is_empty()).collect();
        sets.into_iter().collect::<Vec<_>>().join(" and ")
    }

    fn figures(&self, family: &'static Family) -> Vec<Figure> {
        let mut diagrams = Vec::new();
        for cost in [Cost::Seconds, Cost::Memory] {
            for quantity in family.quantities {
                let name = format!("{}-{}-{}", family.name, quantity.name(), cost.name());
                diagrams.push((name, self.error_against(family, *quantity, cost)));
            }
        }
        diagrams.push((
            format!("{}-time-unknowns", family.name),
            self.seconds_against_unknowns(family),
        ));
        diagrams.push((
            format!("{}-iterations", family.name),
            self.iterations(family),
        ));
        diagrams.push((
            format!("{}-increments", family.name),
            increments::diagram(self, family),
        ));
        diagrams.push((
            format!("{}-estimate", family.name),
            estimates::diagram(self, family),
        ));
        let drawn = diagrams
            .into_iter()
            .filter(|(_, diagram)| !diagram.is_empty());
        let mut figures: Vec<Figure> = drawn
            .map(|(name, diagram)| Figure {
                name,
                svg: diagram.svg(),
            })
            .collect();
        figures.push(Figure {
            name: format!("{}-phases", family.name),
            svg: self.phases(family).svg(),
        });
        figures
    }

    /// Rows of a family, curve by curve, without methods that are not there.
    pub(super) fn curves_of(&self, family: &Family) -> Vec<Vec<&Row>> {
        let mut curves: Vec<Vec<&Row>> = Vec::new();
        let rows = self.rows.iter();
        let rows = rows
            .filter(|row| row.case.place == Place::Chapter && !row.outcome.refuses_the_method());
        for row in rows.filter(|row| row.case.family.name == family.name) {
            let of_row = |curve: &&mut Vec<&Row>| {
                curve
                    .first()
                    .is_some_and(|first| first.case.is_curve_of(&row.case))
            };
            match curves.iter_mut().find(of_row) {
                Some(curve) => curve.push(row),
                None => curves.push(vec![row]),
            }
        }
        curves
    }

    /// Peers of a family, solver by solver.
    fn peers_of(&self, family: &Family) -> Vec<Vec<&Peer>> {
        let mut curves: Vec<Vec<&Peer>> = Vec::new();
        for peer in self
            .peers
            .rows
            .iter()
            .filter(|peer| peer.scene == family.name)
        {
            let same = |curve: &&mut Vec<&Peer>| {
                curve
                    .first()
                    .is_some_and(|first| first.solver == peer.solver)
            };
            match curves.iter_mut().find(same) {
                Some(curve) => curve.push(peer),
                None => curves.push(vec![peer]),
            }
        }
        curves
    }

    /// Curves of rows and, dashed, of peers. Those without points keep their
    /// place, so that a method has the same colour in all figures of a family.
    fn curves(
        &self,
        family: &Family,
        point: impl Fn(&Row) -> Option<Point>,
        peer_point: impl Fn(&Peer) -> Option<Point>,
    ) -> Vec<Curve> {
        let mut curves = Vec::new();
        for rows in self.curves_of(family) {
            curves.push(Curve {
                label: rows
                    .first()
                    .map_or_else(String::new, |row| curve_label(row)),
                stroke: Stroke::Solid,
                points: rows.iter().filter_map(|row| point(row)).collect(),
            });
        }
        for peers in self.peers_of(family) {
            curves.push(Curve {
                label: peers
                    .first()
                    .map_or_else(String::new, |peer| peer.solver.clone()),
                stroke: Stroke::Dashed,
                points: peers.iter().filter_map(|peer| peer_point(peer)).collect(),
            });
        }
        curves
    }

    fn error_against(&self, family: &'static Family, quantity: Quantity, cost: Cost) -> Diagram {
        let limit = self.references.limit(family.name, quantity);
        let limit = limit.filter(|_| quantity.exact_norm().is_none());
        let uncertainty = limit.map_or(0.0, |limit| limit.relative());
        let point = |row: &Row| {
            let y = row.error(quantity);
            let state = state(row, y.is_some_and(|error| error < uncertainty));
            let (x, name) = (cost.of(row)?, row.case.level.to_string());
            (y.is_some() || state == State::Failed).then_some(Point { x, y, state, name })
        };
        let peer_point = |peer: &Peer| {
            let y = peer.error(quantity, &self.references)?;
            Some(point_of_peer(peer, cost.of_peer(peer)?, y, uncertainty))
        };
        Diagram {
            title: format!(
                "{}: error of the {} against {}",
                family.name,
                quantity.label(),
                cost.word()
            ),
            x: (Kind::Logarithmic, cost.label().to_owned()),
            y: (Kind::Logarithmic, "relative error".to_owned()),
            curves: self.curves(family, point, peer_point),
            level: limit.filter(|limit| !limit.is_exact()).map(|limit| Level {
                value: limit.relative(),
                label: "uncertainty of the limit".to_owned(),
            }),
            footer: self.footer(
                limit.map(|limit| {
                    let finest = self.references.finest(family.name, quantity);
                    limit_note(&limit, &finest)
                }),
                &self.peers_of(family),
            ),
        }
    }

    fn seconds_against_unknowns(&self, family: &'static Family) -> Diagram {
        let point = |row: &Row| {
            let (state, name) = (state(row, false), row.case.level.to_string());
            let (x, y) = (row.unknowns(), Some(row.numbers.seconds));
            (x > 0.0).then_some(Point { x, y, state, name })
        };
        let peer_point = |peer: &Peer| Some(point_of_peer(peer, peer.unknowns, peer.seconds, 0.0));
        Diagram {
            title: format!("{}: time", family.name),
            x: (Kind::Logarithmic, UNKNOWNS.to_owned()),
            y: (Kind::Logarithmic, "wall time (s)".to_owned()),
            curves: self.curves(family, point, peer_point),
            level: None,
            footer: self.footer(None, &self.peers_of(family)),
        }
    }

    fn iterations(&self, family: &'static Family) -> Diagram {
        let point = |row: &Row| {
            let (state, name) = (state(row, false), row.case.level.to_string());
            let (x, y) = (row.unknowns(), Some(row.numbers.iterations as f64));
            (x > 0.0).then_some(Point { x, y, state, name })
        };
        let peer_point =
            |peer: &Peer| Some(point_of_peer(peer, peer.unknowns, peer.iterations?, 0.0));
        Diagram {
            title: format!("{}: iterations", family.name),
            x: (Kind::Logarithmic, UNKNOWNS.to_owned()),
            y: (Kind::Linear, "Krylov iterations".to_owned()),
            curves: self.curves(family, point, peer_point),
            level: None,
            footer: self.footer(None, &self.peers_of(family)),
        }
    }

    /// Shares of the phases, for each method at its first tolerance.
    fn phases(&self, family: &'static Family) -> Bars {
        let mut methods = BTreeSet::new();
        let mut bars = Vec::new();
        for curve in self.curves_of(family) {
            let Some(first) = curve.first() else { continue };
            if methods.insert(first.case.method.clone()) {
                bars.extend(
                    curve
                        .iter()
                        .filter(|row| row.converged())
                        .map(|row| bar(row)),
                );
            }
        }
        let mut parts = PHASES.map(phase_label).to_vec();
        parts.push("the rest".to_owned());
        Bars {
            title: format!("{}: where the time goes", family.name),
            parts,
            bars,
            footer: self.footer(None, &[]),
        }
    }

    /// Small print: where the numbers come from; `peers` are those that are drawn.
    pub(super) fn footer(&self, first: Option<String>, peers: &[Vec<&Peer>]) -> Vec<String> {
        let mut lines: Vec<String> = first.into_iter().collect();
        let repeats = self.rows.iter().map(|row| row.repeats).max().unwrap_or(1);
        let machine = self.machine.line(&self.instruction_sets());
        let runs = match repeats {
            1 => "one run each".to_owned(),
            repeats => format!("median of up to {repeats} runs"),
        };
        lines.push(format!("{machine}; {runs}."));
        if !peers.is_empty() {
            lines.push("Dashed: other solvers, from the file of --peers.".to_owned());
        }
        lines
    }
}

pub(super) const UNKNOWNS: &str = "unknowns (displacement, pressure, contact)";

fn limit_note(limit: &Limit, finest: &str) -> String {
    let (value, uncertainty) = (number(limit.value), limit.uncertainty);
    if limit.is_exact() {
        return format!("Error against the exact value {value}.");
    }
    format!(
        "Error against the limit {value} ± {uncertainty:.1e}, extrapolated from the meshes of the family (to {finest})."
    )
}

fn curve_label(row: &Row) -> String {
    format!(
        "Signorini {}, tolerance {:e}",
        row.case.method, row.case.tolerance
    )
}

/// How a row is drawn.
pub(super) fn state(row: &Row, is_uncertain: bool) -> State {
    match (row.converged(), is_uncertain) {
        (false, _) => State::Failed,
        (true, true) => State::Uncertain,
        (true, false) => State::Good,
    }
}

/// A peer's point, uncertain below `uncertainty`.
fn point_of_peer(peer: &Peer, x: f64, y: f64, uncertainty: f64) -> Point {
    let state = if y < uncertainty {
        State::Uncertain
    } else {
        State::Good
    };
    let (y, name) = (Some(y), peer.level.to_string());
    Point { x, y, state, name }
}

fn bar(row: &Row) -> Bar {
    let mut parts = row.numbers.phases.to_vec();
    let rest = row.numbers.seconds - parts.iter().sum::<f64>();
    parts.push(rest.max(0.0));
    let method = row.case.method.to_string();
    let method = method.rsplit('=').next().unwrap_or_default();
    Bar {
        name: format!("{} {method}", row.case.level),
        parts,
        note: format!("{} s", number((row.numbers.seconds * 1e3).round() * 1e-3)),
    }
}

fn phase_label(phase: &str) -> String {
    match phase {
        "prepare" => "mesh, numbering, plan",
        "assemble" => "assembly",
        "factorise" => "factorisation",
        "krylov" => "iterations",
        "contact" => "contact and evaluation",
        other => other,
    }
    .to_owned()
}
