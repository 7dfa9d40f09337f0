// Puts the page together.

// Intervals of contact that have a chart of their own.
const MOST_PATHS = 4;

function pick(name, options, chosen, change) {
  const select = el("select", { change: () => change(select.value) },
    options.map(([value, text]) => el("option", { value, selected: value === chosen }, text)));
  return el("label", {}, name, select);
}

function scaleBar() {
  const [low, high] = [el("span"), el("span")];
  const bar = el("div", { class: "scale" }, low, el("i", { style: `background: linear-gradient(90deg, ${COLOURS.join(",")})` }), high);
  return { bar, set: ([a, b]) => { low.textContent = num(a); high.textContent = num(b); } };
}

// A length in the picture: 1, 2 or 5 times a power of ten, at most a quarter of its width.
function rulerOf() {
  const [line, text] = [el("i"), el("span")];
  const draw = (pixels, width) => {
    const longest = (0.25 * width) / pixels;
    const power = 10 ** Math.floor(Math.log10(longest));
    const length = [5, 2, 1].find((factor) => factor * power <= longest * (1 + 1e-9)) * power;
    line.style.width = `${length * pixels}px`;
    text.textContent = behind(num(length), unit("length"));
  };
  return { bar: el("div", { class: "ruler" }, line, text), draw };
}

function stage(title) {
  const ruler = rulerOf();
  const canvas = el("canvas", { "aria-label": title, role: "img" });
  const scale = scaleBar();
  const controls = el("div", { class: "controls" });
  const figure = el("figure", {}, el("figcaption", {}, title), controls, el("div", { class: "stage" }, canvas, ruler.bar), scale.bar);
  return { canvas, scale, controls, figure, ruler: ruler.draw };
}

// The whole body as it is deformed.
function shapeView(data, body, ring) {
  const { picture } = data;
  const { canvas, scale, controls, figure, ruler } = stage("Deformed body");
  const view = new View(canvas, picture.dimension === 2 ? "y" : "z");
  view.ruler = ruler;
  const names = Object.keys(body.values);
  let field = ["displacement", "pressure", "contact_pressure"].find((name) => names.includes(name)) || names[0] || "";
  let turns = Boolean(ring);
  const show = () => {
    view.show(turns ? ring : body);
    scale.set(view.colour(field));
    view.hidden = turns || !shown.checked;
    if (turns) view.zoom = 1.4;
    view.lookFrom(turns ? [0.5, 0.6, 0.9] : picture.dimension === 2 ? [0, 0, 1] : [0.7, -1, 0.6]);
    view.draw();
  };
  const shown = el("input", { type: "checkbox", checked: true, change: () => { view.hidden = turns || !shown.checked; view.draw(); } });
  const amount = el("span", { class: "dim" }, "1");
  const slider = el("input", { type: "range", min: 0, max: 3, step: 0.05, value: 1, "aria-label": "factor of the displacement",
    input: () => { view.factor = Number(slider.value); amount.textContent = num(view.factor); view.draw(); } });
  controls.append(pick("colour", names.map((name) => [name, named(label(name), unitOf(name))]), field, (name) => {
    field = name;
    scale.set(view.colour(field));
    view.draw();
  }));
  if (picture.displacement) controls.append(el("label", {}, "displacement ×", slider, amount));
  if (picture.obstacles.length) controls.append(el("label", {}, shown, "obstacles"));
  if (ring) controls.append(el("label", {}, el("input", { type: "checkbox", checked: true, change: (event) => { turns = event.target.checked; show(); } }), "full turn"));
  show();
  for (const one of picture.obstacles) view.add(numbers(one.points), indices(one.triangles));
  for (const leak of data.leaks) view.addLine(leak.points);
  if (data.leaks.length) controls.append(el("span", { class: "leak small" }, `where ${data.leaks.map((leak) => leak.fluid).join(", ")} leaks first`));
  return figure;
}

// The contact of one obstacle, seen from where it presses.
function contactView(picture, body, last, kind) {
  const field = ["contact_pressure", "contact_pressure_deformed"].find((name) => body.values[name]);
  const touching = Object.entries(last.obstacles).filter(([, one]) => one.area > 0 && Math.hypot(...one.force) > 0);
  if (!field || !touching.length) return null;
  const { canvas, scale, controls, figure, ruler } = stage("Contact pressure");
  const view = new View(canvas, picture.dimension === 2 ? "y" : "z");
  view.ruler = ruler;
  view.show(body);
  scale.set(view.colour(field));
  const look = (name) => {
    const one = last.obstacles[name];
    view.lookFrom(picture.dimension === 2 ? [0, 0, 1] : one.force.map((x) => -x));
    const length = kind === "axisymmetric" ? one.area / (2 * Math.PI * Math.abs(one.centre[0]) || 1) : one.area;
    const radius = picture.dimension === 2 ? 0.75 * length : 2 * Math.sqrt(one.area / Math.PI);
    view.frame(one.centre, Math.min(radius, view.whole));
    view.draw();
  };
  const strongest = touching.reduce((a, b) => (Math.hypot(...b[1].force) > Math.hypot(...a[1].force) ? b : a))[0];
  if (touching.length > 1) controls.append(pick("under", touching.map(([name]) => [name, name]), strongest, look));
  controls.append(el("span", { class: "dim small" }, `${named(label(field), unitOf(field))}, seen ${picture.dimension === 2 ? "at the contact" : "from the obstacle"}`));
  look(strongest);
  return figure;
}

// Pressure against the arc length, for the longest intervals of contact.
function pathCharts({ paths }) {
  const charts = paths.slice(0, MOST_PATHS).map((path) => chart({
    title: `Pressure of ${path.obstacle} along the surface`, note: paths.length > 1 ? `interval from ${vector(path.points[0].slice(2))}` : "",
    x: named("arc length", unit("length")), y: named("pressure", unit("stress")),
    points: path.points.map(([x, y, ...place]) => ({ x, y, name: vector(place) })) }));
  const left = paths.length > MOST_PATHS
    ? [el("p", { class: "dim small" }, `${paths.length - MOST_PATHS} shorter intervals are in contact_path.csv beside this page.`)] : [];
  return charts.length ? [el("div", { class: "charts" }, charts), ...left] : [];
}

function pictures(data, last) {
  const { picture } = data;
  if (!picture || !last) return [];
  const body = bodyOf(picture);
  const kind = data.plan && data.plan.kind;
  const ring = kind === "axisymmetric" && picture.rim ? turned(body, [...indices(picture.rim)]) : null;
  const [whole, kept] = picture.nodes;
  const hint = "Drag to turn, shift and drag to move, pinch or (once clicked) wheel to zoom; arrows, + and - too.";
  const thinned = kept < whole ? ` The surface is thinned from ${whole} to ${kept} points; the files beside this page hold all.` : "";
  return [el("h2", {}, "Body and contact"),
    el("div", { class: "views" }, shapeView(data, body, ring), contactView(picture, body, last, kind)),
    el("p", { class: "dim small" }, hint + thinned), ...pathCharts(data)];
}

function page(data) {
  const { steps } = data;
  UNITS = (data.plan && data.plan.units) || {};
  const last = steps[steps.length - 1];
  const drawn = data.picture && (steps.filter((row) => Math.abs(row.time - data.picture.time) < 1e-9).pop() || last);
  return [head(data, last), cards(last), warnings(data), forces(steps, last), fluidCharts(steps, last), goals(last), refinement(data), pictures(data, drawn), convergence(data),
    increments(data), intervals(last), reactions(last), ran(data, last),
    el("p", { class: "dim small" }, `Signorini ${data.version}. The same numbers are in results.csv and results.jsonl, the fields in the files for ParaView.`)].flat();
}

const host = document.getElementById("page");
try {
  const parts = page(JSON.parse(document.getElementById("data").textContent));
  host.replaceChildren(...parts.filter((part) => part != null));
} catch (error) {
  host.replaceChildren(`This page cannot be drawn: ${error.message}`);
}
