// A surface that turns: WebGL 2 where there is one, else a painter's picture.

const COLOURS = ["#440154", "#3b528b", "#21918c", "#5ec962", "#fde725"];
const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);

const VERTEX = `#version 300 es
in vec3 point; in vec3 shift; in float value;
uniform mat3 turn; uniform vec3 target; uniform vec3 fit; uniform float factor;
out vec3 place; out float number;
void main() {
  place = turn * (point + factor * shift - target);
  number = value;
  gl_Position = vec4(place.xy * fit.xy, -place.z * fit.z, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 place; in float number;
uniform vec3 colours[5]; uniform vec2 limits; uniform vec4 tint; uniform vec4 bare;
out vec4 colour;
void main() {
  vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
  float light = 0.45 + 0.55 * abs(dot(normal, normalize(vec3(0.25, 0.35, 0.9))));
  float t = clamp((number - limits.x) / (limits.y - limits.x), 0.0, 1.0) * 3.9999;
  int i = int(t);
  vec3 c = mix(colours[i], colours[i + 1], t - float(i));
  if (bare.a > 0.0 && number <= limits.x + 1e-4 * (limits.y - limits.x)) c = bare.rgb;
  // A line has no side to be lit on.
  float lit = tint.a < 1.0 ? light : 1.0;
  colour = tint.a > 0.0 ? vec4(tint.rgb * lit * tint.a, tint.a) : vec4(c * lit, 1.0);
}`;

class View {
  constructor(canvas, up) {
    Object.assign(this, { canvas, up, azimuth: 0, elevation: 0, zoom: 1, factor: 1, target: [0, 0, 0], radius: 1 });
    this.gl = canvas.getContext("webgl2", { antialias: true, premultipliedAlpha: true });
    if (this.gl) this.program = this.compile();
    else this.flat = canvas.getContext("2d");
    this.extras = [];
    this.lines = [];
    this.listen();
    new ResizeObserver(() => this.draw()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  compile() {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const part = gl.createShader(kind);
      gl.shaderSource(part, source);
      gl.compileShader(part);
      gl.attachShader(program, part);
    }
    gl.linkProgram(program);
    return program;
  }

  // Centres and frames a body; its coordinates are kept from the middle, for 32 bits.
  show(body) {
    const [low, high] = [[1e300, 1e300, 1e300], [-1e300, -1e300, -1e300]];
    for (let i = 0; i < body.points.length; i++) {
      const x = body.points[i] + body.shift[i];
      low[i % 3] = Math.min(low[i % 3], x, body.points[i]);
      high[i % 3] = Math.max(high[i % 3], x, body.points[i]);
    }
    this.middle = low.map((x, i) => 0.5 * (x + high[i]));
    this.whole = 0.5 * Math.hypot(...high.map((x, i) => x - low[i])) || 1;
    this.body = this.pack(body.points, body.shift, body.triangles);
    this.values = body.values;
    this.frame(this.middle, this.whole);
  }

  frame(target, radius) {
    this.target = target.map((x, i) => x - this.middle[i]);
    this.radius = radius;
    this.zoom = 1;
  }

  pack(points, shift, triangles) {
    const centred = Float32Array.from(points, (x, i) => x - this.middle[i % 3]);
    const part = { points: centred, shift: Float32Array.from(shift), triangles: Uint32Array.from(triangles) };
    if (!this.gl) return part;
    const gl = this.gl;
    const buffer = (kind, data) => {
      const made = gl.createBuffer();
      gl.bindBuffer(kind, made);
      gl.bufferData(kind, data, gl.STATIC_DRAW);
      return made;
    };
    part.buffers = {
      point: buffer(gl.ARRAY_BUFFER, part.points),
      shift: buffer(gl.ARRAY_BUFFER, part.shift),
      value: buffer(gl.ARRAY_BUFFER, new Float32Array(points.length / 3)),
      order: buffer(gl.ELEMENT_ARRAY_BUFFER, part.triangles),
    };
    return part;
  }

  // An obstacle, and its rim: a plane that is seen from its side is a line.
  add(points, triangles) {
    const none = new Float32Array(points.length);
    const rim = this.pack(points, none, rimOf(triangles));
    this.extras.push({ ...this.pack(points, none, triangles), rim });
  }

  // A line through points, over everything.
  addLine(points) {
    const segments = points.slice(1).flatMap((_, i) => [i, i + 1]);
    this.lines.push(this.pack(points.flat(), new Float32Array(3 * points.length), segments));
  }

  colour(name) {
    const values = this.values[name] || new Float32Array(this.body.points.length / 3);
    let [low, high] = [Infinity, -Infinity];
    for (const value of values) [low, high] = [Math.min(low, value), Math.max(high, value)];
    this.isBare = name.startsWith("contact_pressure") && low >= 0;
    this.limits = [low, high > low ? high : low + 1];
    this.body.values = Float32Array.from(values);
    if (this.gl) {
      this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.body.buffers.value);
      this.gl.bufferData(this.gl.ARRAY_BUFFER, this.body.values, this.gl.STATIC_DRAW);
    }
    return [low, high];
  }

  // Rows of the rotation from the body to the screen; z points to the reader.
  turn() {
    const [ca, sa] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    const [ce, se] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    const rows = [[ca, 0, -sa], [-se * sa, ce, -se * ca], [ce * sa, se, ce * ca]];
    return this.up === "y" ? rows : rows.map(([x, y, z]) => [x, -z, y]);
  }

  // Looks from a direction.
  lookFrom([x, y, z]) {
    const [a, b, c] = this.up === "y" ? [x, y, z] : [x, z, -y];
    this.azimuth = Math.hypot(a, c) > 1e-9 ? Math.atan2(a, c) : 0;
    this.elevation = Math.atan2(b, Math.hypot(a, c));
  }

  draw() {
    cancelAnimationFrame(this.waiting);
    this.waiting = requestAnimationFrame(() => this.paint());
  }

  paint() {
    const { canvas } = this;
    const ratio = Math.min(2, devicePixelRatio || 1);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (!this.body || !this.limits) return;
    const fit = 0.92 * this.zoom * Math.min(canvas.width, canvas.height) / this.radius;
    if (this.gl) this.paintGl([fit / canvas.width, fit / canvas.height, 0.1 / this.whole]);
    else this.paintFlat(fit / 2);
    this.measured(fit / 2 / ratio);
  }

  // The length of a pixel is told to whoever draws the ruler; nobody needs to.
  measured(pixels) {
    if (this.ruler) this.ruler(pixels, this.canvas.clientWidth);
  }

  paintGl(fit) {
    const { gl, program } = this;
    const at = (name) => gl.getUniformLocation(program, name);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(program);
    gl.uniformMatrix3fv(at("turn"), true, this.turn().flat());
    gl.uniform3fv(at("target"), this.target);
    gl.uniform3fv(at("fit"), fit);
    gl.uniform3fv(at("colours"), COLOURS.flatMap(rgb));
    gl.uniform2fv(at("limits"), this.limits);
    gl.uniform4f(at("bare"), ...this.ink("--skin"), this.isBare ? 1 : 0);
    gl.uniform4f(at("tint"), 0, 0, 0, 0);
    gl.uniform1f(at("factor"), this.factor);
    this.paintPart(this.body, gl.TRIANGLES);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    gl.uniform1f(at("factor"), 0);
    for (const part of this.hidden ? [] : this.extras) {
      gl.uniform4f(at("tint"), ...this.ink("--dim"), 0.3);
      this.paintPart(part, gl.TRIANGLES);
      gl.uniform4f(at("tint"), ...this.ink("--text"), 1);
      this.paintPart(part.rim, gl.LINES);
    }
    gl.uniform4f(at("tint"), ...this.ink("--bad"), 1);
    this.lines.forEach((part) => this.paintLine(part, at("target"), fit));
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  // Lines of WebGL are a pixel wide: drawn nine times, a pixel apart.
  paintLine(part, target, fit) {
    const { gl } = this;
    const [right, up] = this.turn();
    const [wide, high] = [2 / (fit[0] * this.canvas.width), 2 / (fit[1] * this.canvas.height)];
    gl.disable(gl.DEPTH_TEST);
    for (let i = 0; i < 9; i++) {
      const [x, y] = [wide * ((i % 3) - 1), high * (Math.floor(i / 3) - 1)];
      gl.uniform3fv(target, this.target.map((value, k) => value + x * right[k] + y * up[k]));
      this.paintPart(part, gl.LINES);
    }
    gl.uniform3fv(target, this.target);
    gl.enable(gl.DEPTH_TEST);
  }

  paintPart(part, kind) {
    const { gl, program } = this;
    for (const [name, size] of [["point", 3], ["shift", 3], ["value", 1]]) {
      const place = gl.getAttribLocation(program, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, part.buffers[name]);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.buffers.order);
    gl.drawElements(kind, part.triangles.length, gl.UNSIGNED_INT, 0);
  }

  ink(name) {
    return rgb(getComputedStyle(this.canvas).getPropertyValue(name).trim());
  }

  // Triangles from back to front, each in one colour.
  paintFlat(fit) {
    const { flat, canvas, body, limits } = this;
    flat.clearRect(0, 0, canvas.width, canvas.height);
    const rows = this.turn();
    const seen = new Float64Array(body.points.length);
    for (let i = 0; i < seen.length; i += 3) {
      const offset = [0, 1, 2].map((k) => body.points[i + k] + this.factor * body.shift[i + k] - this.target[k]);
      rows.forEach((row, k) => { seen[i + k] = row[0] * offset[0] + row[1] * offset[1] + row[2] * offset[2]; });
    }
    const corner = (node) => [canvas.width / 2 + fit * seen[3 * node], canvas.height / 2 - fit * seen[3 * node + 1]];
    const faces = [];
    for (let i = 0; i < body.triangles.length; i += 3) {
      const nodes = [...body.triangles.slice(i, i + 3)];
      faces.push([nodes.reduce((sum, node) => sum + seen[3 * node + 2], 0), nodes]);
    }
    faces.sort((a, b) => a[0] - b[0]);
    for (const [, nodes] of faces) {
      const value = nodes.reduce((sum, node) => sum + body.values[node], 0) / 3;
      const t = 3.9999 * Math.min(1, Math.max(0, (value - limits[0]) / (limits[1] - limits[0])));
      const [a, b] = [rgb(COLOURS[Math.floor(t)]), rgb(COLOURS[Math.floor(t) + 1])];
      const bare = this.isBare && value <= limits[0] + 1e-4 * (limits[1] - limits[0]);
      const colour = bare ? this.ink("--skin") : a.map((x, k) => x + (t % 1) * (b[k] - x));
      flat.fillStyle = flat.strokeStyle = `rgb(${colour.map((x) => Math.round(255 * x)).join(" ")})`;
      flat.beginPath();
      nodes.forEach((node) => flat.lineTo(...corner(node)));
      flat.closePath();
      flat.fill();
      flat.stroke();
    }
    for (const { points } of this.lines) this.paintFlatLine(points, rows, fit);
  }

  paintFlatLine(points, rows, fit) {
    const { flat, canvas, target } = this;
    flat.strokeStyle = getComputedStyle(canvas).getPropertyValue("--bad").trim();
    flat.lineWidth = 3;
    flat.beginPath();
    for (let i = 0; i < points.length; i += 3) {
      const [x, y] = rows.map((row) => row.reduce((sum, value, k) => sum + value * (points[i + k] - target[k]), 0));
      flat.lineTo(canvas.width / 2 + fit * x, canvas.height / 2 - fit * y);
    }
    flat.stroke();
    flat.lineWidth = 1;
  }

  listen() {
    const { canvas } = this;
    const down = new Map();
    const spread = () => {
      const [a, b] = [...down.values()];
      return Math.hypot(a[0] - b[0], a[1] - b[1]);
    };
    canvas.tabIndex = 0;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      down.set(event.pointerId, [event.clientX, event.clientY]);
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => down.delete(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      const before = down.get(event.pointerId);
      if (!before) return;
      const wide = down.size === 2 ? spread() : 0;
      down.set(event.pointerId, [event.clientX, event.clientY]);
      if (wide) this.zoom *= spread() / wide;
      else if (event.shiftKey) this.slide(event.clientX - before[0], event.clientY - before[1]);
      else this.rotate(event.clientX - before[0], event.clientY - before[1]);
      this.draw();
    });
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas && !event.ctrlKey) return;
      event.preventDefault();
      this.zoom *= Math.exp(-0.0015 * event.deltaY);
      this.draw();
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const turns = { ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, -20], ArrowDown: [0, 20] };
      if (turns[event.key]) this.rotate(...turns[event.key]);
      else if (event.key === "+") this.zoom *= 1.2;
      else if (event.key === "-") this.zoom /= 1.2;
      else return;
      event.preventDefault();
      this.draw();
    });
  }

  rotate(right, down) {
    this.azimuth -= 0.008 * right;
    this.elevation = Math.min(1.57, Math.max(-1.57, this.elevation + 0.008 * down));
  }

  slide(right, down) {
    const unit = this.radius / (0.46 * this.zoom * Math.min(this.canvas.clientWidth, this.canvas.clientHeight));
    const [x, y] = this.turn();
    this.target = this.target.map((value, k) => value - unit * (right * x[k] - down * y[k]));
  }
}
