// The body as the page holds it: numbers from base64, a section turned into a ring.

function numbers(coded) {
  const raw = atob(coded.data);
  const bytes = Uint8Array.from(raw, (c) => c.charCodeAt(0));
  const [codes, columns] = [new Uint16Array(bytes.buffer), coded.low.length];
  return Float64Array.from(codes, (code, i) => coded.low[i % columns] + (coded.span / 65535) * code);
}
const indices = (data) => new Uint16Array(Uint8Array.from(atob(data), (c) => c.charCodeAt(0)).buffer);

// A body: {points, shift, values: {name: numbers}, triangles}, lengths as they are.
function bodyOf(picture) {
  const points = numbers(picture.points);
  const shift = picture.displacement ? numbers(picture.displacement) : new Float64Array(points.length);
  const values = {};
  for (const field of picture.fields) values[field.name] = numbers(field.values);
  const sizes = Float64Array.from({ length: points.length / 3 }, (_, i) =>
    Math.hypot(shift[3 * i], shift[3 * i + 1], shift[3 * i + 2]));
  if (picture.displacement) values.displacement = sizes;
  return { points, shift, values, triangles: indices(picture.triangles) };
}

// A section turned about x = 0 by three quarters, its two ends closed.
function turned(body, rim, around = 72) {
  const [points, shift, triangles, origin] = [[], [], [], []];
  const put = (node, angle) => {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const spin = (from, to) => to.push(from[3 * node] * c, from[3 * node + 1], -from[3 * node] * s);
    spin(body.points, points);
    spin(body.shift, shift);
    origin.push(node);
    return origin.length - 1;
  };
  const nodes = [...new Set(rim)];
  const rings = [];
  for (let k = 0; k <= around; k++) {
    const angle = (1.5 * Math.PI * k) / around;
    rings.push(new Map(nodes.map((node) => [node, put(node, angle)])));
  }
  for (let k = 0; k < around; k++) {
    for (let i = 0; i < rim.length; i += 2) {
      const [a, b] = [rings[k].get(rim[i]), rings[k].get(rim[i + 1])];
      const [c, d] = [rings[k + 1].get(rim[i]), rings[k + 1].get(rim[i + 1])];
      triangles.push(a, b, d, a, d, c);
    }
  }
  for (const angle of [0, 1.5 * Math.PI]) {
    const first = origin.length;
    for (let node = 0; node < body.points.length / 3; node++) put(node, angle);
    for (const node of body.triangles) triangles.push(first + node);
  }
  const values = {};
  for (const [name, all] of Object.entries(body.values)) values[name] = origin.map((node) => all[node]);
  return { points, shift, values, triangles: Uint32Array.from(triangles) };
}

// Edges that one triangle has alone, as pairs of nodes.
function rimOf(triangles) {
  const once = new Map();
  for (let i = 0; i < triangles.length; i++) {
    const [a, b] = [triangles[i], triangles[i % 3 === 2 ? i - 2 : i + 1]];
    const key = `${Math.min(a, b)} ${Math.max(a, b)}`;
    once.set(key, once.has(key) ? null : [a, b]);
  }
  return [...once.values()].filter(Boolean).flat();
}
