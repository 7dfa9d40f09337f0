// The parts of the page, each from the data alone.

const words = (text) => (text || "").replace(/_/g, " ");
const vector = (values) => `(${(values || []).map((x) => num(x)).join(", ")})`;
const LABELS = {
  contact_pressure: "contact pressure",
  contact_pressure_deformed: "contact pressure, per deformed area",
  contact_pressure_undeformed: "contact pressure, per undeformed area",
  pressure: "pressure inside",
  von_mises: "von Mises stress",
  displacement: "displacement",
  gap: "gap",
  jacobian: "change of volume (det F)",
  error_estimate: "error estimate by cell",
  error_density: "error of the goal by volume",
  mesh_gradient: "derivative of the goal by places",
};
const label = (name) => LABELS[name] || words(name);

// What the scene calls the unit of a quantity; empty where it does not.
const QUANTITIES = {
  length: ["displacement", "gap", "slip"],
  stress: ["pressure", "contact_pressure", "contact_pressure_deformed", "contact_pressure_undeformed", "friction_traction", "stress", "von_mises"],
  force: ["nodal_force"],
};
let UNITS = {};
const unit = (quantity) => UNITS[quantity] || "";
const unitOf = (field) => unit(Object.keys(QUANTITIES).find((quantity) => QUANTITIES[quantity].includes(field)));
const behind = (text, name) => (name ? `${text} ${name}` : text);
const named = (text, name) => (name ? `${text} (${name})` : text);

function head(data, last) {
  const { plan, summary, step_count } = data;
  const good = last.termination === "converged";
  const name = (plan && plan.name) || "scene";
  document.title = `${name} · Signorini`;
  const facts = [
    words(plan && plan.kind),
    `step ${last.step}, increment ${last.increment}, load ${num(last.load)}`,
    step_count > 1 ? `${step_count} increments` : null,
    summary ? `${num(summary.wall_seconds, 3)} s` : "cut off before its end",
  ];
  return [
    el("header", {}, el("h1", {}, name),
      el("span", { class: `verdict ${good ? "good" : "bad"}` }, words(last.termination) + (last.cause ? `: ${words(last.cause)}` : ""))),
    el("p", { class: "dim" }, facts.filter(Boolean).join(" · ")),
    ...verdicts(last),
    last.why ? el("p", {}, `Why: ${last.why}`) : null,
    last.place && last.place.point.length ? el("p", {}, `Where: at ${vector(last.place.point)}` +
      (last.place.motion.length ? `, along ${vector(last.place.motion)}` : "")) : null,
  ];
}

function cards(last) {
  const card = (title, big, ...small) =>
    el("div", { class: "card" }, el("span", { class: "dim" }, title), el("b", {}, big),
      ...small.filter(Boolean).map((text) => el("div", { class: "small dim" }, text)));
  const all = Object.entries(last.obstacles).map(([name, one]) =>
    card(name, behind(withError(one.along, one.error), unit("force")),
      one.travel == null ? "size of its force; it stands still" : `force along its travel of ${behind(num(one.travel), unit("length"))}`,
      `force ${vector(one.force)}`,
      `contact area ${num(one.area)}, pressure ${behind(num(one.pressure), unit("stress"))} at most`,
      ...extent(one)));
  for (const [name, [motion, pressure]] of Object.entries(last.probes)) {
    all.push(card(`probe ${name}`, vector(motion), "displacement", pressure == null ? null : `pressure ${num(pressure)}`));
  }
  for (const [name, one] of Object.entries(last.contacts)) {
    all.push(card(`contact ${name}`, `force ${vector(one.force)}`, "on the body named first",
      one.mean_pressure == null ? "no contact" : `width ${behind(num(one.contact_width), unit("length"))}, pressure ` +
        `${behind(num(one.mean_pressure), unit("stress"))} in the mean, ${behind(num(one.peak_pressure), unit("stress"))} at most`));
  }
  for (const [name, one] of Object.entries(last.ties)) {
    all.push(card(`tie ${name}`, `force ${vector(one.force)}`, "on the body named first",
      `moment ${vector(one.moment)}`, `largest traction ${behind(num(one.peak_traction), unit("stress"))}`));
  }
  for (const [name, one] of Object.entries(last.fluids)) all.push(card(...fluidCard(name, one)));
  if (last.error != null) all.push(card("error estimate", percent(last.error), "of the deformation, in energy: what the mesh leaves out"));
  if (Object.keys(last.obstacles).length) {
    all.push(card("penetration", behind(num(last.penetration), unit("length")), "at most, between nodes: it shrinks with the mesh size"));
  }
  if (last.min_jacobian != null) all.push(card("least det F", num(last.min_jacobian), "0 would turn a cell inside out"));
  all.push(card("strain energy", num(last.energy), last.stability ? equilibrium(last.stability) : null));
  return el("div", { class: "cards" }, all);
}

// How far contact extends over the deformed surface, and where it presses most.
function extent(one) {
  if (one.mean == null) return [];
  const parts = one.intervals.length > 1 ? ` in ${one.intervals.length} intervals` : "";
  const width = one.width == null ? "" : `, width ${behind(num(one.width), unit("length"))}${parts}`;
  return [`deformed area ${num(one.deformed_area)}${width}`, `mean pressure ${behind(num(one.mean), unit("stress"))}`,
    `peak ${behind(num(one.peak), unit("stress"))} at ${vector(one.place)}`];
}

function intervals(last) {
  const head = el("thead", {}, el("tr", {}, ["", "from", "to", named("width", unit("length")), named("force", unit("force"))].map((text) => el("th", {}, text))));
  const rows = Object.entries(last.obstacles).flatMap(([name, one]) => one.intervals.map(({ start, end, width, force }) =>
    el("tr", {}, el("th", {}, name), el("td", {}, vector(start)), el("td", {}, vector(end)), el("td", {}, num(width)), el("td", {}, vector(force)))));
  return rows.length ? [el("h2", {}, "Intervals of contact"), el("table", { class: "words" }, head, el("tbody", {}, rows))] : [];
}

const equilibrium = (word) => (word === "not_determined" ? "not checked for stability" : `${word} of the energy`);

function warnings(data) {
  if (!data.warnings.length) return [];
  return [el("h2", {}, "Warnings"), el("ul", {}, data.warnings.map((text) => el("li", { class: "doubt" }, text)))];
}

// Whether an obstacle moves along one line.
function isMover(steps, name) {
  const all = steps.map((row) => row.obstacles[name]).filter(Boolean);
  const travels = all.map((one) => one.travel ?? 0);
  const [low, high] = [Math.min(...travels), Math.max(...travels)];
  const largest = Math.max(-low, high);
  const straight = all.every((one) => one.aside <= 1e-6 * largest);
  return straight && (high > low || (steps.length === 1 && largest > 0));
}

// Against its own travel where it has one, else against that of the only mover.
function forceChart(steps, name, movers, against) {
  const along = against === "time" ? null : movers.includes(name) ? name : movers.length === 1 ? movers[0] : null;
  const points = steps.filter((row) => row.obstacles[name]).map((row) => ({
    x: along ? row.obstacles[along].travel : row.time,
    y: row.obstacles[name].along,
    error: row.obstacles[name].error,
    name: `step ${row.step}.${row.increment}`,
  }));
  const x = along ? named(along === name ? "travel" : `travel of ${along}`, unit("length")) : "time (steps)";
  const stands = steps[steps.length - 1].obstacles[name].travel == null;
  return chart({ title: name, note: stands ? "size of its force" : "force along its travel", x, y: named("force", unit("force")), points });
}

// Of a body that only supports move: the size of the force of each of them.
function reactionCharts(steps, last) {
  const size = (force) => Math.hypot(...force);
  const charts = Object.keys(last.supports).map((name) => chart({
    title: name, note: "size of the support's force", x: "time (steps)", y: named("force", unit("force")),
    points: steps.filter((row) => row.supports[name]).map((row) => ({
      x: row.time, y: size(row.supports[name].force), name: `step ${row.step}.${row.increment}` })),
  }));
  return charts.length && steps.length > 1 ? [el("h2", {}, "Force"), el("div", { class: "charts" }, charts)] : [];
}

function forces(steps, last) {
  const names = Object.keys(last.obstacles);
  if (!names.length) return reactionCharts(steps, last);
  const movers = names.filter((name) => isMover(steps, name));
  // A force that grows while nothing moves is a curve against time only.
  const rests = steps.slice(1).some((row, i) => movers.every((name) => row.obstacles[name].travel === steps[i].obstacles[name].travel));
  const host = el("div", { class: "charts" });
  const fill = (against) => host.replaceChildren(...names.map((name) => forceChart(steps, name, movers, against)));
  const first = rests ? "time" : "travel";
  fill(first);
  const banded = steps.some((row) => names.some((name) => row.obstacles[name] && row.obstacles[name].error > 0));
  return [el("h2", {}, "Force"),
    el("div", { class: "controls" },
      movers.length ? pick("against", [["travel", "travel"], ["time", "time"]], first, fill) : null,
      banded ? el("span", { class: "dim small" }, "Bands and whiskers: the estimated error of the mesh.") : null),
    host];
}

function convergence(data) {
  const { steps } = data;
  const charts = [];
  if (data.convergence.length > 1) {
    const points = data.convergence.map(([x, y, name]) => ({ x, y, name: `step ${name}` }));
    const limit = steps[steps.length - 1].tolerance;
    charts.push(chart({ title: "Residual", note: "dashed: the tolerance", x: "iterations", y: "largest residual", log: true, whole: true, limit, points }));
  }
  const points = steps.map((row, i) => ({ x: i + 1, y: row.iterations, name: `step ${row.step}.${row.increment}` }));
  charts.push(chart({ title: "Iterations of each increment", x: "increment", y: "iterations", bars: true, whole: true, points }));
  return [el("h2", {}, "Convergence"), el("div", { class: "charts" }, charts)];
}

function failed(attempt) {
  const next = attempt.followed_by ? `then ${words(attempt.followed_by)}` : "the end";
  return `${words(attempt.strategy)}: ${words(attempt.cause || "no cause")}, ${next}`;
}

function increments(data) {
  const names = Object.keys(data.steps[data.steps.length - 1].obstacles);
  const header = ["step", "incr", "load", ...names.flatMap((name) => [`${name} travel`, `${name} force`]),
    "error", "touching", "iterations", "failed attempts", "seconds", "", ""];
  const rows = data.steps.map((row) => [row.step, row.increment, num(row.load),
    ...names.flatMap((name) => {
      const one = row.obstacles[name];
      return one ? [num(one.travel), withError(one.along, one.error)] : ["–", "–"];
    }),
    percent(row.error), row.touching, row.iterations, row.attempts.map(failed).join("; "), num(row.seconds, 3),
    row.termination === "converged" ? "" : words(row.termination), row.snapped ? "snapped" : ""]);
  const table = el("table", {}, el("thead", {}, el("tr", {}, header.map((text) => el("th", {}, text)))),
    el("tbody", {}, rows.map((cells) => el("tr", {}, cells.map((text) => el("td", {}, String(text)))))));
  const left = data.step_count - data.steps.length;
  return [el("details", {}, el("summary", {}, "All increments" + (left ? ` (${left} left out, evenly)` : "")), el("div", { class: "scroll" }, table))];
}

function reactions(last) {
  const moves = ({ translation, rotation }) => [...translation, ...rotation].some((value) => value !== 0);
  const isMoved = Object.values(last.supports).some(moves);
  const titles = ["", named("force", unit("force")), named("moment", unit("force") && unit("length") && `${unit("force")} ${unit("length")}`)];
  const motion = isMoved ? [named("translation", unit("length")), "rotation (rad)"] : [];
  const head = el("thead", {}, el("tr", {}, [...titles, ...motion].map((text) => el("th", {}, text))));
  const rows = Object.entries(last.supports).map(([name, one]) => {
    const cells = [one.force, one.moment, ...(isMoved ? [one.translation, one.rotation] : [])];
    return el("tr", {}, el("th", {}, name), cells.map((cell) => el("td", {}, vector(cell))));
  });
  return rows.length ? [el("h2", {}, "Reactions of the supports"), el("table", { class: "words" }, head, el("tbody", {}, rows))] : [];
}

function ran(data, last) {
  const { plan, summary } = data;
  if (!plan) return [];
  const row = (name, text) => el("tr", {}, el("th", {}, words(name)), el("td", {}, text));
  const unknowns = plan.unknowns || {};
  const rows = [row("unknowns", `${unknowns.displacement} displacement, ${unknowns.pressure} pressure, ${unknowns.contact} contact`)];
  for (const one of plan.decisions || []) rows.push(row(one.what, one.reason ? `${one.choice}: ${one.reason}` : one.choice));
  if (summary && summary.peak_memory_bytes) rows.push(row("memory", `${num(summary.peak_memory_bytes / 2 ** 20, 3)} MiB at most`));
  if (last.residual != null) rows.push(row("largest residual", `${num(last.residual, 2)}, tolerance ${num(last.tolerance, 2)}`));
  const omitted = (plan.left_out || []).map((one) => row(one.what, one.reason));
  return [el("h2", {}, "What ran, and why"), el("table", { class: "words" }, el("tbody", {}, rows)),
    omitted.length ? el("details", {}, el("summary", {}, "What this scene did not need"), el("table", { class: "words" }, el("tbody", {}, omitted))) : null];
}
