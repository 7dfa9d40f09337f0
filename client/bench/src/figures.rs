//! The diagrams of a report, family by family.

use std::collections::BTreeSet;

use crate::axis::{Axis, MEMORY, SIZE, TIME};
use crate::chart::{Bar, Bars, Curve, Diagram, Kind, Level, Point, State, Stroke};
use crate::estimates;
use crate::families::FAMILIES;
use crate::family::{Family, Quantity};
use crate::increments;
use crate::limit::Limit;
use crate::measure::PHASES;
use crate::peers::Peer;
use crate::picture::Figure;
use crate::results::Results;
use crate::row::Row;
use crate::text::rounded;

/// The figures of one family.
#[derive(Clone, Debug)]
pub(crate) struct Chapter {
    pub(crate) family: &'static Family,
    pub(crate) figures: Vec<Figure>,
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

    fn figures(&self, family: &'static Family) -> Vec<Figure> {
        let mut diagrams = Vec::new();
        let times = family.quantities.iter().map(|quantity| (*quantity, TIME));
        // Memory is that of the mesh, whatever is read off the solution.
        let memory = family.quantities.iter().take(1);
        for (quantity, cost) in times.chain(memory.map(|quantity| (*quantity, MEMORY))) {
            let name = format!("{}-{}-{}", family.name, quantity.name(), cost.name);
            diagrams.push((name, self.error_against(family, quantity, &cost)));
        }
        // Against unknowns there is nothing to read off a single mesh.
        let against_unknowns = [
            ("time-unknowns", self.seconds_against_unknowns(family)),
            ("iterations", self.iterations(family)),
            ("increments", increments::diagram(self, family)),
            ("estimate", estimates::diagram(self, family)),
        ];
        let sloped = against_unknowns.into_iter();
        let sloped = sloped.filter(|(_, diagram)| diagram.has_slope());
        diagrams.extend(sloped.map(|(name, diagram)| (format!("{}-{name}", family.name), diagram)));
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
        let refined = self.refined_of(family);
        curves.extend(refined.into_iter().map(|strand| Curve {
            label: format!("Signorini, {}", strand.label),
            stroke: Stroke::Solid,
            points: strand.rows.iter().filter_map(|row| point(row)).collect(),
        }));
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

    fn error_against(&self, family: &'static Family, quantity: Quantity, cost: &Axis) -> Diagram {
        let limit = self.references.limit(family.name, quantity);
        let limit = limit.filter(|_| quantity.exact_norm().is_none());
        let uncertainty = limit.map_or(0.0, |limit| limit.relative());
        let point = |row: &Row| {
            let y = row.error(quantity);
            let state = state(row, y.is_some_and(|error| error < uncertainty));
            let (x, name) = ((cost.of)(row)?, row.case.level.to_string());
            let spread = (cost.spread)(row);
            let point = Point {
                x,
                y,
                state,
                name,
                spread,
            };
            (y.is_some() || state == State::Failed).then_some(point)
        };
        let peer_point = |peer: &Peer| {
            let y = peer.error(quantity, &self.references);
            point_of_peer(peer, (cost.of_peer)(peer)?, y, uncertainty)
        };
        Diagram {
            title: format!(
                "{}: error of the {} against {}",
                family.name,
                quantity.label(),
                cost.word
            ),
            x: (Kind::Logarithmic, cost.label.to_owned()),
            y: (Kind::Logarithmic, "relative error".to_owned()),
            curves: self.curves(family, point, peer_point),
            level: limit.filter(|limit| !limit.is_exact()).map(|limit| Level {
                value: limit.relative(),
                label: "uncertainty of the limit".to_owned(),
            }),
            footer: self.footer(
                limit.map(|limit| {
                    let origin = self.references.origin(family.name, quantity);
                    limit_note(&limit, &origin)
                }),
                &self.peers_of(family),
            ),
        }
    }

    fn seconds_against_unknowns(&self, family: &'static Family) -> Diagram {
        let point = |row: &Row| {
            let (state, name) = (state(row, false), row.case.level.to_string());
            let (x, y) = ((SIZE.of)(row)?, Some(row.numbers.seconds));
            Some(Point {
                x,
                y,
                state,
                name,
                spread: None,
            })
        };
        let peer_point = |peer: &Peer| point_of_peer(peer, peer.unknowns?, Some(peer.seconds), 0.0);
        Diagram {
            title: format!("{}: time", family.name),
            x: (Kind::Logarithmic, SIZE.label.to_owned()),
            y: (Kind::Logarithmic, "wall time (s)".to_owned()),
            curves: self.curves(family, point, peer_point),
            level: None,
            footer: self.footer(None, &self.peers_of(family)),
        }
    }

    fn iterations(&self, family: &'static Family) -> Diagram {
        let point = |row: &Row| {
            let (state, name) = (state(row, false), row.case.level.to_string());
            let (x, y) = ((SIZE.of)(row)?, Some(row.numbers.iterations as f64));
            Some(Point {
                x,
                y,
                state,
                name,
                spread: None,
            })
        };
        let peer_point =
            |peer: &Peer| point_of_peer(peer, peer.unknowns?, Some(peer.iterations?), 0.0);
        Diagram {
            title: format!("{}: iterations", family.name),
            x: (Kind::Logarithmic, SIZE.label.to_owned()),
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
}

fn limit_note(limit: &Limit, origin: &str) -> String {
    let (value, uncertainty) = (rounded(limit.value), limit.uncertainty);
    if limit.is_exact() {
        return format!("Error against the exact value {value}.");
    }
    format!("Error against the limit {value} ± {uncertainty:.1e}, {origin}.")
}

fn curve_label(row: &Row) -> String {
    format!(
        "Signorini {}, tolerance {:e}",
        row.case.method, row.case.tolerance
    )
}

/// How a row is drawn.
pub(crate) fn state(row: &Row, is_uncertain: bool) -> State {
    match (row.converged(), is_uncertain) {
        (false, _) => State::Failed,
        (true, true) => State::Uncertain,
        (true, false) => State::Good,
    }
}

/// A peer's point, uncertain below `uncertainty`; none where there is neither a value
/// nor a failure.
fn point_of_peer(peer: &Peer, x: f64, y: Option<f64>, uncertainty: f64) -> Option<Point> {
    let state = match (&peer.failure, y) {
        (Some(_), _) => State::Failed,
        (None, Some(y)) if y < uncertainty => State::Uncertain,
        (None, _) => State::Good,
    };
    let name = peer.level.to_string();
    (y.is_some() || state == State::Failed).then_some(Point {
        x,
        y,
        state,
        name,
        spread: None,
    })
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
        note: format!("{} s", rounded((row.numbers.seconds * 1e3).round() * 1e-3)),
    }
}

fn phase_label(phase: &str) -> String {
    match phase {
        "prepare" => "mesh, numbering, plan",
        "assemble" => "assembly",
        "factorise" => "factorisation",
        "krylov" => "iterations",
        "contact" => "contact and evaluation",
        "stability" => "certificate",
        other => other,
    }
    .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::parse;
    use crate::samples;

    #[test]
    fn failures_of_other_solvers_are_crosses_without_a_height() {
        let text = "scene,level,solver,unknowns,seconds,failure,value_force\n\
            cube-drag,n4,Other,2187,9,,0.0553\ncube-drag,n6,Other,,70,no convergence,\n";
        let peers = parse(text).unwrap();
        let results = samples::results(Vec::new());
        let error = |peer: &Peer| peer.error(Quantity::Force, &results.references);
        let good = point_of_peer(&peers[0], 9.0, error(&peers[0]), 0.0).unwrap();
        let failed = point_of_peer(&peers[1], 70.0, error(&peers[1]), 0.0).unwrap();
        assert_eq!((good.state, good.y.is_some()), (State::Good, true));
        assert_eq!((failed.state, failed.y), (State::Failed, None));
        // Neither a value nor a failure: nothing to draw.
        assert!(point_of_peer(&peers[0], 9.0, None, 0.0).is_none());
    }
}
