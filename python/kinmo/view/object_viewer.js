// Viewer of one articulated object in WebGL 2: orbit, sliders, animation. It needs no library and fetches nothing.
// kinmoViewer.mount(element, scene) fills an element. `scene` is the JSON of kinmo.view.object_scene; its geometry is GLB.
"use strict";
const kinmoViewer = (() => {
  const TURN = 2 * Math.PI, CREASE = Math.cos(0.6), EDGE = Math.cos(0.4), MOST_EDGES = 400000, LOW = 0.5;
  const add = (a, b, s = 1) => a.map((x, i) => x + s * b[i]), dot = (a, b) => a.reduce((t, x, i) => t + x * b[i], 0);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => { const n = Math.hypot(...a) || 1; return a.map((x) => x / n); };

  // Matrices are arrays of 16 numbers by columns, as WebGL has them.
  const EYE = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  const multiply = (a, b) => EYE.map((_, i) => { let t = 0; for (let k = 0; k < 4; k++) t += a[i % 4 + 4 * k] * b[4 * (i >> 2) + k]; return t; });
  const apply = (m, p) => [0, 1, 2].map((i) => m[i] * p[0] + m[i + 4] * p[1] + m[i + 8] * p[2] + m[i + 12]);
  const moved = (t) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, ...t, 1];
  const basis = (x, y, z, t) => [...x, 0, ...y, 0, ...z, 0, ...t, 1];
  function turned(axis, pivot, angle) {
    const c = Math.cos(angle), s = Math.sin(angle);
    const column = (e) => add(add(e.map((x) => c * x), axis, (1 - c) * dot(axis, e)), cross(axis, e), s);
    const rotation = basis(column([1, 0, 0]), column([0, 1, 0]), column([0, 0, 1]), [0, 0, 0]);
    return multiply(multiply(moved(pivot), rotation), moved(pivot.map((x) => -x)));
  }
  function nodeMatrix(node) {
    if (node.matrix) return node.matrix;
    const [x, y, z, w] = node.rotation || [0, 0, 0, 1], s = node.scale || [1, 1, 1];
    const r = [[1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
      [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)], [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)]];
    return basis(...r.map((column, i) => column.map((v) => v * s[i])), node.translation || [0, 0, 0]);
  }

  // GLB: the parts by the name of their node, with positions in the pose of the file.
  function readGlb(bytes) {
    const view = new DataView(bytes.buffer, bytes.byteOffset), size = view.getUint32(12, true);
    const gltf = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + size)));
    const binary = bytes.subarray(28 + size);
    const part = (index) => { const v = gltf.bufferViews[index]; return [binary.byteOffset + (v.byteOffset || 0), v.byteLength, v.byteStride || 0]; };
    function floats(index) {
      const a = gltf.accessors[index], [start, , stride] = part(a.bufferView), width = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 }[a.type];
      const [read, length, most] = { 5120: ["getInt8", 1, 127], 5121: ["getUint8", 1, 255], 5122: ["getInt16", 2, 32767],
        5123: ["getUint16", 2, 65535], 5125: ["getUint32", 4, 1], 5126: ["getFloat32", 4, 1] }[a.componentType];
      const data = new DataView(bytes.buffer), out = new Float64Array(a.count * width);
      for (let i = 0; i < a.count; i++) for (let k = 0; k < width; k++)
        out[i * width + k] = data[read](start + (a.byteOffset || 0) + i * (stride || width * length) + k * length, true) / (a.normalized ? most : 1);
      return { data: out, width, count: a.count };
    }
    const parts = {}, texture = (info) => { if (!info) return null; const image = gltf.images[gltf.textures[info.index].source];
      const [start, length] = part(image.bufferView); return new Blob([new Uint8Array(bytes.buffer, start, length)], { type: image.mimeType }); };
    const visit = (index, above) => {
      const node = gltf.nodes[index], pose = multiply(above, nodeMatrix(node));
      if (node.mesh !== undefined) parts[node.name] = gltf.meshes[node.mesh].primitives.map((primitive) => {
        const own = primitive.attributes, get = (name) => own[name] === undefined ? null : floats(own[name]);
        const position = get("POSITION"), material = (gltf.materials || [])[primitive.material] || {}, pbr = material.pbrMetallicRoughness || {};
        const index = primitive.indices === undefined ? Float64Array.from({ length: position.count }, (_, i) => i) : floats(primitive.indices).data;
        for (let i = 0; i < position.count; i++) position.data.set(apply(pose, position.data.subarray(3 * i, 3 * i + 3)), 3 * i);
        return { position: position.data, index, uv: get("TEXCOORD_0"), color: get("COLOR_0"), factor: (pbr.baseColorFactor || [1, 1, 1, 1]).map((x, i) => i < 3 ? x ** (1 / 2.2) : material.alphaMode ? x : 1),
          image: texture(pbr.baseColorTexture), hasLook: Boolean(pbr.baseColorFactor || pbr.baseColorTexture || own.COLOR_0 !== undefined) };
      });
      for (const child of node.children || []) visit(child, pose);
    };
    for (const node of gltf.scenes[gltf.scene || 0].nodes) visit(node, EYE);
    return parts;
  }

  // Corners of all triangles with smooth normals up to a crease, and the lines along creases.
  function surface(primitive) {
    const { position, index } = primitive, triangles = index.length / 3, low = [1, 1, 1].map(() => Infinity), high = low.map((x) => -x);
    for (let i = 0; i < position.length; i++) { low[i % 3] = Math.min(low[i % 3], position[i]); high[i % 3] = Math.max(high[i % 3], position[i]); }
    const step = Math.max(...add(high, low, -1), 1e-30) / 1e5, weld = new Map(), same = new Int32Array(position.length / 3);
    for (let v = 0; v < same.length; v++) {
      const key = [0, 1, 2].map((k) => Math.round((position[3 * v + k] - low[k]) / step)).join();
      if (!weld.has(key)) weld.set(key, weld.size);
      same[v] = weld.get(key);
    }
    const at = (v) => [position[3 * v], position[3 * v + 1], position[3 * v + 2]], faceNormals = [], around = Array.from({ length: weld.size }, () => []);
    const corners = new Float32Array(9 * triangles), normals = new Float32Array(9 * triangles), edges = new Map();
    for (let f = 0; f < triangles; f++) {
      const [a, b, c] = [0, 1, 2].map((k) => at(index[3 * f + k]));
      corners.set([...a, ...b, ...c], 9 * f);
      faceNormals.push(cross(add(b, a, -1), add(c, a, -1)));
      for (let k = 0; k < 3; k++) {
        const u = same[index[3 * f + k]], v = same[index[3 * f + (k + 1) % 3]], key = Math.min(u, v) * weld.size + Math.max(u, v);
        around[u].push(f);
        if (triangles < MOST_EDGES && u !== v) { if (!edges.has(key)) edges.set(key, [index[3 * f + k], index[3 * f + (k + 1) % 3]]); edges.get(key).push(f); }
      }
    }
    const directions = faceNormals.map(unit), lines = [];
    for (let c = 0; c < index.length; c++) {
      const own = directions[Math.floor(c / 3)];
      let sum = [0, 0, 0];
      for (const f of around[same[index[c]]]) if (dot(directions[f], own) > CREASE) sum = add(sum, faceNormals[f]);
      normals.set(unit(sum), 3 * c);
    }
    for (const [a, b, ...faces] of edges.values())
      if (faces.length === 1 || faces.some((f) => Math.abs(dot(directions[f], directions[faces[0]])) < EDGE)) lines.push(...at(a), ...at(b));
    const pick = (values, width, fill) => { const out = new Float32Array(width * index.length).fill(fill);
      if (values) for (let c = 0; c < index.length; c++) for (let k = 0; k < Math.min(width, values.width); k++) out[c * width + k] = values.data[index[c] * values.width + k];
      return out; };
    return { corners, normals, lines: new Float32Array(lines), uvs: pick(primitive.uv, 2, 0), colors: pick(primitive.color, 4, 1), low, high };
  }

  const VERTEX = `#version 300 es
    in vec3 position; in vec3 normal; in vec2 uv; in vec4 tint; uniform mat4 project, view, model; uniform float nearer;
    out vec3 n, p; out vec2 t; out vec4 c;
    void main() { vec4 q = view * model * vec4(position, 1.); n = mat3(view * model) * normal; p = q.xyz; t = uv; c = tint;
      gl_Position = project * q; gl_Position.z -= nearer * gl_Position.w; }`;
  const FRAGMENT = `#version 300 es
    precision highp float; in vec3 n, p; in vec2 t; in vec4 c; uniform vec4 color; uniform float lit, looks, textured; uniform sampler2D image; out vec4 result;
    void main() { vec4 base = color; if (looks > .5) { base *= vec4(pow(c.rgb, vec3(1. / 2.2)), c.a); if (textured > .5) { vec4 s = texture(image, t); base *= s; } if (base.a < .05) discard; }
      float shade = 1.; if (lit > .5) { vec3 m = normalize(n); if (dot(m, p) > 0.) m = -m;
        shade = .50 + .10 * m.y + .46 * max(dot(m, normalize(vec3(.45, .40, .90))), 0.) + .08 * max(dot(m, normalize(vec3(-.8, .1, .4))), 0.); }
      result = vec4(base.rgb * min(shade, 1.12), base.a); }`;

  function program(gl) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind); gl.shaderSource(shader, text); gl.compileShader(shader); gl.attachShader(made, shader);
    }
    ["position", "normal", "uv", "tint"].forEach((name, place) => gl.bindAttribLocation(made, place, name));
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
    gl.useProgram(made);
    return made;
  }
  function buffers(gl, arrays) { // a vertex array from [data, width] by place; null where a constant is used
    const array = gl.createVertexArray(); gl.bindVertexArray(array);
    arrays.forEach((entry, place) => { if (!entry) return;
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer()); gl.bufferData(gl.ARRAY_BUFFER, entry[0], gl.STATIC_DRAW);
      gl.enableVertexAttribArray(place); gl.vertexAttribPointer(place, entry[1], gl.FLOAT, false, 0, 0); });
    return { array, count: arrays[0][0].length / 3 };
  }
  function arrow(gl) { // along z from -1 to 1, with radius 1: scaled for each axis
    const corners = [], ring = (i, r, z) => [r * Math.cos(i * TURN / 16), r * Math.sin(i * TURN / 16), z];
    const strip = (r0, z0, r1, z1) => { for (let i = 0; i < 16; i++)
      corners.push(...ring(i, r0, z0), ...ring(i + 1, r0, z0), ...ring(i, r1, z1), ...ring(i, r1, z1), ...ring(i + 1, r0, z0), ...ring(i + 1, r1, z1)); };
    strip(1, -1, 1, 0.8); strip(3, 0.8, 0, 1); strip(0, 0.8, 3, 0.8);
    return buffers(gl, [[new Float32Array(corners), 3], null, null, null]);
  }
  async function decode(text) {
    const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Uint8Array(await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer());
  }

  function element(tag, properties = {}, ...children) {
    const made = Object.assign(document.createElement(tag), properties);
    for (const [name, value] of Object.entries(properties)) if (name.includes("-")) made.setAttribute(name, value);
    made.append(...children);
    return made;
  }

  async function mount(root, scene) {
    const canvas = element("canvas", { tabIndex: 0, "aria-label": `3D view of ${scene.name}. Drag or use the arrow keys to turn it, + and - to zoom.`, role: "img" });
    const panel = element("div", { className: "kv-panel" }), stage = element("div", { className: "kv-stage" }, canvas);
    root.classList.add("kinmo-viewer"); root.replaceChildren(stage, panel);
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: false });
    if (!gl) { stage.replaceChildren(element("p", { className: "kv-note", textContent: "This browser shows no 3D: WebGL 2 is off or missing." })); }
    const bodies = scene.bodies.map((body) => ({ ...body, value: 0, option: body.options[body.chosen] || null, low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity], draws: [], lines: [] }));
    const state = { look: false, axes: true, edges: true, focus: -1, playing: new Set(), disposed: false };
    let low = [Infinity, Infinity, Infinity], high = low.map((x) => -x), hasLooks = false, uniforms, tip, asked = false;
    if (gl) {
      const made = program(gl), parts = readGlb(await decode(scene.glb));
      uniforms = Object.fromEntries(["project", "view", "model", "nearer", "color", "lit", "looks", "textured"].map((n) => [n, gl.getUniformLocation(made, n)]));
      tip = arrow(gl);
      for (const body of bodies) for (const part of body.parts) for (const primitive of parts[part.node] || []) {
        const s = surface(primitive);
        [body.low, low] = [body.low, low].map((old) => old.map((x, i) => Math.min(x, s.low[i])));
        [body.high, high] = [body.high, high].map((old) => old.map((x, i) => Math.max(x, s.high[i])));
        const draw = { ...buffers(gl, [[s.corners, 3], [s.normals, 3], [s.uvs, 2], [s.colors, 4]]), factor: primitive.factor, texture: null };
        if (primitive.image) upload(primitive.image, draw);
        hasLooks ||= primitive.hasLook;
        body.draws.push(draw);
        if (s.lines.length) body.lines.push(buffers(gl, [[s.lines, 3], null, null, null]));
      }
    }
    if (!(low[0] <= high[0])) [low, high] = [[-1, -1, -1], [1, 1, 1]];
    const middle = add(low, high).map((x) => x / 2), radius = Math.max(Math.hypot(...add(high, low, -1)) / 2, 1e-9);
    const front = scene.front, heading = Math.atan2(front[0], front[2]);
    const start = { turn: heading - 0.5, lift: 0.42, zoom: 1, shift: [0, 0] }, camera = { ...start, shift: [0, 0] };

    async function upload(blob, draw) {
      try {
        const image = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
        draw.texture = gl.createTexture(); gl.bindTexture(gl.TEXTURE_2D, draw.texture);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image); gl.generateMipmap(gl.TEXTURE_2D);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR); redraw();
      } catch (error) { note.textContent = "A texture of this object cannot be shown."; }
    }
    function poses() {
      const found = [];
      const pose = (index) => found[index] ||= (() => {
        const body = bodies[index], above = body.parent === null ? EYE : pose(body.parent), { option, value } = body;
        if (!option || !option.kind) return above;
        return multiply(above, option.kind === "hinge" ? turned(option.axis, option.pivot, value) : moved(option.axis.map((x) => x * value)));
      })();
      bodies.forEach((_, index) => pose(index));
      return found;
    }
    function axisMatrix(body) { // of the arrow that shows a joint: through the body for sliders
      const { option } = body, ends = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [i & 1, i & 2, i & 4].map((bit, k) => (bit ? body.high : body.low)[k]));
      const centre = body.low[0] <= body.high[0] ? add(body.low, body.high).map((x) => x / 2) : option.pivot;
      const through = option.kind === "slider" ? centre : option.pivot, along = ends.map((e) => dot(add(e, through, -1), option.axis)).filter(isFinite);
      const [from, to] = along.length ? [Math.min(...along) - 0.14 * radius, Math.max(...along) + 0.14 * radius] : [-0.3 * radius, 0.3 * radius];
      const z = option.axis, x = unit(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z)), y = cross(z, x), r = 0.011 * radius;
      return basis(x.map((v) => v * r), y.map((v) => v * r), z.map((v) => v * (to - from) / 2), add(through, z, (from + to) / 2));
    }
    function redraw() { if (!asked && !state.disposed) { asked = true; requestAnimationFrame(draw); } }
    function draw(time) {
      asked = false;
      if (!gl || state.disposed) return;
      for (const index of state.playing) animate(index, time);
      const scale = Math.min(window.devicePixelRatio || 1, 2), width = Math.max(1, Math.round(canvas.clientWidth * scale)), height = Math.max(1, Math.round(canvas.clientHeight * scale));
      if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
      gl.viewport(0, 0, width, height); gl.clearColor(0, 0, 0, 0); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST); gl.enable(gl.BLEND); gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      const { turn, lift, zoom, shift } = camera, back = [Math.sin(turn) * Math.cos(lift), Math.sin(lift), Math.cos(turn) * Math.cos(lift)];
      const right = [Math.cos(turn), 0, -Math.sin(turn)], up = cross(back, right), far = 4.2 * radius / zoom, f = 3.1, aspect = width / height, fit = Math.min(aspect, 1);
      const eye = add(add(add(middle, right, -shift[0] * radius), up, -shift[1] * radius), back, far);
      const view = basis(...[0, 1, 2].map((i) => [right[i], up[i], back[i]]), [-dot(right, eye), -dot(up, eye), -dot(back, eye)]);
      const near = Math.max(far - 3 * radius, 0.02 * radius), last = far + 4 * radius;
      gl.uniformMatrix4fv(uniforms.project, false, [f * fit / aspect, 0, 0, 0, 0, f * fit, 0, 0, 0, 0, -(last + near) / (last - near), -1, 0, 0, -2 * last * near / (last - near), 0]);
      gl.uniformMatrix4fv(uniforms.view, false, view);
      const found = poses(), set = (name, value) => gl.uniform1f(uniforms[name], value);
      const show = (mesh, kind, model, color) => { gl.uniformMatrix4fv(uniforms.model, false, model); gl.uniform4fv(uniforms.color, color); gl.bindVertexArray(mesh.array); gl.drawArrays(kind, 0, mesh.count); };
      set("lit", 1); set("nearer", 0);
      for (const isGlass of [false, true]) { // glass comes last and hides nothing
        gl.depthMask(!isGlass);
        bodies.forEach((body, index) => { const glow = index === state.focus ? 0.25 : 0;
          set("nearer", body.option?.kind ? 0.00005 : 0); // of surfaces in one place, that of the moving body is seen
          for (const mesh of body.draws) {
            const base = state.look ? mesh.factor : [...body.color, 1];
            if ((base[3] < 0.99) !== isGlass) continue;
            set("looks", state.look ? 1 : 0); set("textured", state.look && mesh.texture ? 1 : 0); gl.bindTexture(gl.TEXTURE_2D, mesh.texture);
            show(mesh, gl.TRIANGLES, found[index], base.map((x, i) => i < 3 ? x + (1 - x) * glow : x));
          } });
      }
      gl.depthMask(true);
      set("lit", 0); set("looks", 0); set("textured", 0);
      if (!state.look) { set("nearer", 0.0003); bodies.forEach((body, index) => { for (const mesh of body.lines) show(mesh, gl.LINES, found[index], [...body.color.map((x) => 0.45 * x), 0.8]); }); set("nearer", 0); }
      if (state.axes) for (const alpha of [1, 0.3]) {
        if (alpha < 1) gl.disable(gl.DEPTH_TEST);
        bodies.forEach((body, index) => { if (body.option && body.option.kind)
          show(tip, gl.TRIANGLES, multiply(body.parent === null ? EYE : found[body.parent], axisMatrix(body)), [...body.color.map((x) => 0.5 * x), alpha]); });
      }
      if (state.playing.size) redraw();
      root.dataset.state = "ready"; root.dataset.frame = Number(root.dataset.frame || 0) + 1;
    }

    // The panel.
    const note = element("p", { className: "kv-note", role: "status" }), rows = new Map();
    const limits = (option) => { const all = option.kind === "hinge" ? Math.PI : radius; return [option.lower ?? -all, option.upper ?? all]; };
    const number = (option, value) => option.kind === "hinge" ? Math.round(value * 180 / Math.PI) : Number(value.toPrecision(3));
    const shown = (option, value) => `${number(option, value)}${option.kind === "hinge" ? "°" : ` ${scene.unit}`}`;
    function setValue(index, value) {
      const body = bodies[index], row = rows.get(index);
      body.value = value;
      if (row) { row.slider.value = value; row.output.textContent = shown(body.option, value); row.slider.setAttribute("aria-valuetext", row.output.textContent); }
      redraw();
    }
    function animate(index, time) {
      const [from, to] = limits(bodies[index].option), row = rows.get(index);
      row.since ??= time;
      const phase = (time - row.since) / 1600, begin = to > from ? Math.acos(1 - 2 * Math.min(Math.max((row.first - from) / (to - from), 0), 1)) : 0;
      setValue(index, from + (to - from) * (0.5 - 0.5 * Math.cos(begin + phase)));
    }
    function play(index, wanted) {
      const row = rows.get(index);
      if (!row || row.slider.disabled) return;
      if (wanted) { state.playing.add(index); row.since = null; row.first = bodies[index].value; } else state.playing.delete(index);
      row.button.setAttribute("aria-pressed", String(wanted)); row.button.textContent = wanted ? "❚❚" : "▶";
      redraw();
    }
    function choose(index, place) {
      const body = bodies[index], row = rows.get(index);
      play(index, false);
      body.option = body.options[place];
      const moves = Boolean(body.option.kind), [from, to] = moves ? limits(body.option) : [0, 1];
      Object.assign(row.slider, { min: from, max: to, step: "any", disabled: !moves });
      row.slider.setAttribute("aria-label", `${body.name}: ${moves ? body.option.kind : "fixed"}`);
      row.button.disabled = !moves;
      row.fact.textContent = moves ? `${body.option.kind}, ${body.option.lower === null ? "without limits" : `${number(body.option, from)} to ${shown(body.option, to)}`}` : "does not move";
      const p = body.option.probability;
      row.badge.textContent = body.option.byHand ? "by hand" : p === null ? "" : `${Math.round(100 * p)} %`;
      row.badge.classList.toggle("kv-low", p !== null && p < LOW && !body.option.byHand);
      row.badge.title = row.badge.classList.contains("kv-low") ? "uncertain" : "probability";
      if (row.badge.classList.contains("kv-low")) row.badge.textContent += " uncertain";
      body.value = 0;
      if (moves) setValue(index, 0); else { row.output.textContent = ""; redraw(); }
      const changed = bodies.filter((b) => b.option && b.key && b.option !== b.options[b.chosen] && b.option.rank);
      fix.hidden = !changed.length;
      fixText.textContent = changed.map((b) => `[bodies.${JSON.stringify(b.key)}]\nalternative = ${b.option.rank}\n`).join("\n");
    }
    const counted = (names) => [...new Set(names)].map((name) => { const n = names.filter((x) => x === name).length; return n > 1 ? `${name} ×${n}` : name; }).join(", ");
    function swatch(color) { return element("i", { className: "kv-swatch", style: `background: rgb(${color.map((x) => Math.round(255 * x)).join()})` }); }
    const fixText = element("pre"), fix = element("div", { className: "kv-fix", hidden: true }, element("p", { textContent: "To keep this choice, add to overrides.toml:" }), fixText);
    const list = element("ul", { className: "kv-joints" });
    bodies.forEach((body, index) => {
      if (!body.options.some((option) => option.kind)) return;
      const row = { slider: element("input", { type: "range" }), output: element("output"), badge: element("span", { className: "kv-badge" }), fact: element("span", { className: "kv-fact" }),
        button: element("button", { type: "button", textContent: "▶", "aria-label": `Play ${body.name}`, "aria-pressed": "false" }) };
      rows.set(index, row);
      row.slider.oninput = () => { play(index, false); setValue(index, Number(row.slider.value)); };
      row.button.onclick = () => play(index, !state.playing.has(index));
      const item = element("li", {}, element("div", { className: "kv-title" }, swatch(body.color), element("b", { textContent: body.name }), row.badge), row.fact,
        element("div", { className: "kv-slide" }, row.button, row.slider, row.output));
      if (body.options.length > 1) {
        const select = element("select", { "aria-label": `Joint of ${body.name}` }, ...body.options.map((option, place) => element("option", { value: place, textContent: option.label, selected: place === body.chosen })));
        select.onchange = () => choose(index, Number(select.value));
        item.append(select);
      }
      for (const [name, focus] of [["pointerenter", index], ["pointerleave", -1], ["focusin", index], ["focusout", -1]]) item.addEventListener(name, () => { state.focus = focus; redraw(); });
      list.append(item);
      choose(index, body.chosen);
    });
    const button = (text, action) => element("button", { type: "button", textContent: text, onclick: action });
    const check = (text, key) => { const box = element("input", { type: "checkbox", checked: state[key], onchange: () => { state[key] = box.checked; redraw(); } }); return element("label", {}, box, text); };
    const tools = element("div", { className: "kv-tools" });
    if (rows.size) tools.append(button("Play all", () => { const any = state.playing.size > 0; for (const index of rows.keys()) play(index, !any); }));
    tools.append(button("Reset", () => { for (const index of rows.keys()) { play(index, false); if (bodies[index].option.kind) setValue(index, 0); } Object.assign(camera, start, { shift: [0, 0] }); redraw(); }));
    if (rows.size) tools.append(check("Axes", "axes"));
    if (hasLooks) tools.append(check("Textures", "look"));
    const legend = element("ul", { className: "kv-parts" }, ...bodies.filter((body) => body.parts.length).map((body) =>
      element("li", {}, swatch(body.color), element("b", { textContent: body.name }), ` ${counted(body.parts.map((part) => part.name))}`)));
    panel.append(element("h2", { textContent: scene.name }), element("p", { className: "kv-fact", textContent: scene.facts }), tools,
      ...(rows.size ? [list, fix] : [element("p", { textContent: "No joints." })]), note,
      element("details", { open: bodies.length <= 8 }, element("summary", { textContent: "Parts" }), legend),
      ...(scene.notes.length ? [element("details", {}, element("summary", { textContent: "Notes" }), element("ul", {}, ...scene.notes.map((text) => element("li", { textContent: text }))))] : []));

    // Mouse, touch and keys.
    const pointers = new Map(), clamp = (x, a, b) => Math.min(Math.max(x, a), b);
    const zoomBy = (factor) => { camera.zoom = clamp(camera.zoom * factor, 0.3, 12); redraw(); };
    canvas.addEventListener("pointerdown", (event) => { pointers.set(event.pointerId, [event.clientX, event.clientY]); canvas.setPointerCapture(event.pointerId); });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (!pointers.has(event.pointerId)) return;
      const old = pointers.get(event.pointerId), now = [event.clientX, event.clientY], other = [...pointers].find(([id]) => id !== event.pointerId);
      pointers.set(event.pointerId, now);
      const [dx, dy] = add(now, old, -1);
      if (other) { const gap = (p) => Math.hypot(...add(p, other[1], -1)) || 1; zoomBy(gap(now) / gap(old)); }
      if (other || event.buttons === 2 || event.shiftKey) { const unitLength = 2.5 / camera.zoom / canvas.clientHeight; camera.shift = add(camera.shift, [dx * unitLength, -dy * unitLength], other ? 0.5 : 1); }
      else { camera.turn -= 0.008 * dx; camera.lift = clamp(camera.lift + 0.008 * dy, -1.5, 1.5); }
      redraw();
    });
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoomBy(Math.exp(-0.0012 * event.deltaY)); }, { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("keydown", (event) => {
      const keys = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }, step = keys[event.key];
      if (step) { camera.turn += step[0]; camera.lift = clamp(camera.lift + step[1], -1.5, 1.5); redraw(); event.preventDefault(); }
      if (event.key === "+" || event.key === "-") zoomBy(event.key === "+" ? 1.15 : 1 / 1.15);
    });
    const observer = new ResizeObserver(redraw);
    observer.observe(canvas);
    redraw();
    return { setValue, dispose() { state.disposed = true; observer.disconnect(); gl?.getExtension("WEBGL_lose_context")?.loseContext(); root.replaceChildren(); delete root.dataset.state; } };
  }
  return { mount };
})();
