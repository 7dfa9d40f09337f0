// Elements, numbers for people, and charts as SVG: axes, curves, bands, bars.

function el(tag, attributes, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name === "class") element.className = value;
    else if (typeof value === "function") element.addEventListener(name, value);
    else if (value !== false && value != null) element.setAttribute(name, value === true ? "" : value);
  }
  for (const child of children.flat()) if (child != null) element.append(child);
  return element;
}

function num(value, digits = 4) {
  if (value == null || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size < 1e-3 || size >= 1e6) return value.toExponential(digits - 1).replace(/\.?0+e/, "e");
  return String(Number(value.toPrecision(digits)));
}

function withError(value, error) {
  if (!(error > 0) || !Number.isFinite(value)) return num(value, 6);
  const size = Math.max(Math.abs(value), error);
  const exponent = size >= 1e-3 && size < 1e6 ? 0 : Math.floor(Math.log10(size));
  const unit = 10 ** exponent;
  const decimals = Math.min(9, Math.max(0, 1 - Math.floor(Math.log10(error / unit))));
  const text = `${(value / unit).toFixed(decimals)} ± ${(error / unit).toFixed(decimals)}`;
  return exponent ? `(${text})e${exponent}` : text;
}

const percent = (ratio) => (ratio == null ? "–" : `${num(100 * ratio, 2)} %`);

function shape(tag, attributes, text) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  if (text != null) element.textContent = text;
  return element;
}

function ticks(low, high, wanted) {
  const raw = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= raw) * power;
  const all = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) all.push(i * step);
  return all;
}

function decades(low, high, wanted) {
  const [first, last] = [Math.ceil(Math.log10(low) - 1e-9), Math.floor(Math.log10(high) + 1e-9)];
  const step = Math.max(1, Math.ceil((last - first + 1) / wanted));
  const all = [];
  for (let i = first; i <= last; i += step) all.push(10 ** i);
  return all;
}

// spec: {title, note, x, y, log, bars, limit, points: [{x, y, error, name}], other: [{x, y}]}
function chart(spec) {
  const svg = shape("svg", { role: "img", "aria-label": `${spec.title}: ${spec.y} against ${spec.x}` });
  const readout = el("div", { class: "readout" });
  const caption = el("figcaption", {}, spec.title, el("span", {}, spec.note ? ` ${spec.note}` : ""));
  const figure = el("figure", { style: "--ink: var(--a)" }, caption, svg, readout);
  let drawn = 0;
  const draw = () => {
    const width = Math.max(260, Math.round(figure.clientWidth || 480));
    if (width === drawn) return;
    drawn = width;
    drawChart(svg, readout, spec, width, Math.min(300, Math.max(210, Math.round(0.6 * width))));
  };
  new ResizeObserver(draw).observe(figure);
  return figure;
}

function range(values, log) {
  let [low, high] = [Math.min(...values), Math.max(...values)];
  if (log) return [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high) + 1e-9)];
  const pad = high > low ? 0.04 * (high - low) : 0.5 * Math.abs(high) || 1;
  if (low >= 0 && low < 0.4 * high) low = 0;
  else low -= pad;
  if (high <= 0 && high > 0.4 * low) high = 0;
  else high += pad;
  return [low, high];
}

function drawChart(svg, readout, spec, width, height) {
  svg.replaceChildren();
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.setAttribute("height", height);
  const points = spec.points;
  const heights = points.flatMap((p) => (p.error > 0 ? [p.y - p.error, p.y + p.error] : [p.y]));
  if (spec.limit) heights.push(spec.limit);
  if (spec.other) heights.push(...spec.other.map((p) => p.y));
  if (spec.bars) heights.push(0);
  const [low, high] = range(heights, spec.log);
  const [left, right] = range([...points, ...(spec.other || [])].map((p) => p.x), false);
  const marks = spec.log ? decades(low, high, 6) : ticks(low, high, 5);
  const gutter = 14 + 7 * Math.max(...marks.map((mark) => num(mark).length));
  const box = { left: gutter, right: width - 10, top: 22, bottom: height - 36 };
  const map = (value, from, to, a, b) => a + ((value - from) / (to - from)) * (b - a);
  const sx = (x) => map(x, left, right, box.left, box.right);
  const sy = (y) => spec.log
    ? map(Math.log(Math.max(y, low)), Math.log(low), Math.log(high), box.bottom, box.top)
    : map(y, low, high, box.bottom, box.top);
  const add = (tag, attributes, text) => svg.append(shape(tag, attributes, text));
  for (const mark of marks) {
    add("line", { class: "grid", x1: box.left, x2: box.right, y1: sy(mark), y2: sy(mark) });
    add("text", { x: box.left - 6, y: sy(mark) + 4, "text-anchor": "end" }, num(mark));
  }
  let xMarks = ticks(left, right, Math.max(2, Math.floor(width / 110)));
  if (spec.whole) xMarks = xMarks.filter(Number.isInteger);
  for (const mark of xMarks) {
    add("line", { class: "grid", x1: sx(mark), x2: sx(mark), y1: box.bottom, y2: box.bottom + 4 });
    add("text", { x: sx(mark), y: box.bottom + 16, "text-anchor": "middle" }, num(mark));
  }
  add("text", { x: box.right, y: height - 4, "text-anchor": "end" }, spec.x);
  add("text", { x: 0, y: 12 }, spec.y);
  if (spec.limit) add("line", { class: "limit", x1: box.left, x2: box.right, y1: sy(spec.limit), y2: sy(spec.limit) });
  if (spec.other) add("polyline", { class: "limit", fill: "none", points: spec.other.map((p) => `${sx(p.x).toFixed(1)},${sy(p.y).toFixed(1)}`).join(" ") });
  drawCurve(add, spec, points, sx, sy, box);
  listen(svg, readout, spec, points, sx, width);
}

function drawCurve(add, spec, points, sx, sy, box) {
  const at = (p, y) => `${sx(p.x).toFixed(1)},${sy(y).toFixed(1)}`;
  if (spec.bars) {
    const wide = Math.max(1, Math.min(28, (0.7 * (box.right - box.left)) / points.length));
    for (const p of points) {
      add("rect", { class: "bar", x: sx(p.x) - wide / 2, y: sy(p.y), width: wide, height: Math.max(0, box.bottom - sy(p.y)) });
    }
    return;
  }
  const banded = points.filter((p) => p.error > 0);
  if (banded.length > 1) {
    const upper = banded.map((p) => at(p, p.y + p.error));
    const lower = banded.map((p) => at(p, p.y - p.error)).reverse();
    add("polygon", { class: "band", points: upper.concat(lower).join(" ") });
  }
  for (const p of banded.length > 60 ? [] : banded) {
    add("line", { class: "whisker", x1: sx(p.x), x2: sx(p.x), y1: sy(p.y - p.error), y2: sy(p.y + p.error) });
  }
  add("polyline", { class: "curve", points: points.map((p) => at(p, p.y)).join(" ") });
  for (const p of points.length > 60 ? [] : points) add("circle", { class: "dot", cx: sx(p.x), cy: sy(p.y), r: 3 });
}

// The point nearest to the pointer, in words.
function listen(svg, readout, spec, points, sx, width) {
  svg.onpointerleave = () => { readout.textContent = ""; };
  svg.onpointermove = (event) => {
    const frame = svg.getBoundingClientRect();
    const x = ((event.clientX - frame.left) / frame.width) * width;
    const near = points.reduce((best, p) => (Math.abs(sx(p.x) - x) < Math.abs(sx(best.x) - x) ? p : best));
    readout.textContent = `${near.name}: ${spec.x} ${num(near.x)}, ${spec.y} ${withError(near.y, near.error)}`;
  };
}
