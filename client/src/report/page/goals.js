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
