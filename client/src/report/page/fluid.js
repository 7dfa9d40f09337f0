// Whether fluids leak: a sentence, and margin and pressure against time.

function tightness(name, one) {
  const stress = (value) => behind(num(value), unit("stress"));
  if (one.leaks) return `${name} leaks ${one.bracket ? `between ${stress(one.bracket[0])} and ${stress(one.bracket[1])}` : `at ${stress(one.pressure)}`}.`;
  const margin = one.margin == null ? "" : `: on the path where it leaks first, contact presses with ${stress(one.margin)}, ${stress(one.over)} more than the fluid`;
  return `${name} is tight at ${stress(one.pressure)}${margin}.`;
}

function verdicts(last) {
  return Object.entries(last.fluids).map(([name, one]) => el("p", { class: one.leaks ? "doubt" : "" }, tightness(name, one)));
}

function fluidCard(name, one) {
  return [`fluid ${name}`, one.leaks ? "leaks" : "tight", `pressure ${behind(num(one.pressure), unit("stress"))}`,
    one.margin == null ? null : `margin ${behind(num(one.margin), unit("stress"))} over a width of ${behind(num(one.width), unit("length"))}`,
    `wet area ${num(one.area)}, force ${vector(one.force)}`,
    one.flow == null ? null : `flow rate ${num(one.flow)}`];
}

// Where the two curves meet, the fluid leaks.
function fluidCharts(steps, last) {
  const charts = Object.keys(last.fluids).map((name) => {
    const rows = steps.filter((row) => row.fluids[name]);
    const points = (key) => rows.filter((row) => row.fluids[name][key] != null).map((row) => ({
      x: row.time, y: row.fluids[name][key], name: `step ${row.step}.${row.increment}` }));
    const [margin, pressure] = [points("margin"), points("pressure")];
    const spec = { title: `Margin of ${name}`, x: "time (steps)", y: named("pressure", unit("stress")) };
    if (!margin.length) return chart({ ...spec, title: `Pressure of ${name}`, points: pressure });
    return chart({ ...spec, note: "dashed: the pressure of the fluid", points: margin, other: pressure });
  });
  return charts.length && steps.length > 1 ? [el("h2", {}, "Fluids"), el("div", { class: "charts" }, charts)] : [];
}
