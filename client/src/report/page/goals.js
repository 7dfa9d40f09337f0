// How good goals are, and what they depend on.

function goals(last) {
  const refused = last.goals_refused ? [el("p", { class: "doubt" }, `Goals have no answer: ${last.goals_refused}`)] : [];
  const all = Object.entries(last.goals || {});
  if (!all.length) return refused;
  const table = (titles, rows) => el("table", { class: "words" },
    el("thead", {}, el("tr", {}, titles.map((text) => el("th", {}, text)))),
    el("tbody", {}, rows.map(([name, ...cells]) => el("tr", {}, el("th", {}, name), cells.map((text) => el("td", {}, text))))));
  const bounded = all.filter(([, one]) => one.bound).map(([name, { value, bound }]) =>
    [name, num(value), num(bound.total), num(bound.mesh), num(bound.solver), num(bound.geometry), num(bound.estimate)]);
  const derivatives = all.flatMap(([name, { derivatives }]) =>
    Object.entries(derivatives).map(([parameter, value]) => [name, parameter, num(value)]));
  return [
    ...(bounded.length ? [el("h2", {}, "How good it is"),
      table(["", "value", "error at most about", "of the mesh", "of the solver", "of flat facets", "estimated, with sign"], bounded)] : []),
    ...(derivatives.length ? [el("h2", {}, "What it depends on"), table(["", "by", "derivative"], derivatives)] : []),
    ...refused];
}

// Meshes that were refined until goals were known well enough.
function refinement(data) {
  const rounds = data.rounds || [];
  if (!rounds.length) return [];
  const names = Object.keys(rounds[0].goals);
  const end = rounds[rounds.length - 1];
  const charts = names.map((name) => chart({
    title: name, note: "bound of the error over the value", x: "mesh", y: "bound", log: true,
    limit: rounds[0].goals[name].tolerance,
    points: rounds.map(({ round, unknowns, goals }) =>
      ({ x: round, y: goals[name].bound / Math.abs(goals[name].value), name: `${unknowns} unknowns` })) }));
  const row = ({ round, cells, unknowns, seconds, goals }) => el("tr", {}, [round, cells, unknowns, num(seconds, 3),
    ...names.flatMap((name) => [num(goals[name].value, 6), percent(goals[name].bound / Math.abs(goals[name].value))])]
    .map((text) => el("td", {}, String(text))));
  const titles = ["mesh", "cells", "unknowns", "seconds", ...names.flatMap((name) => [name, "error at most about"])];
  return [el("h2", {}, "Refinement"),
    el("p", { class: end.end === "reached" ? "dim" : "doubt" }, end.why ? `${end.end === "reached" ? "Reached" : "Not reached"}: ${end.why}.` : ""),
    el("div", { class: "charts" }, charts),
    el("table", {}, el("thead", {}, el("tr", {}, titles.map((text) => el("th", {}, text)))), el("tbody", {}, rounds.map(row)))];
}
