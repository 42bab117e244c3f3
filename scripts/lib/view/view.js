// Shows a run of contensou: what scripts/view has packed, drawn by three.js. SI units throughout.
(() => {
  "use strict";

  const { byId, clamp, PALETTE, problem, unpack, locate, share } = page;
  const PULL = "#d43a3a", RUB = "#1f8f4d";
  // Of more bodies than this those that look alike are drawn at once.
  const CROWD = 40;

  // ---- What was packed -------------------------------------------------------------------------

  // A number of 16 bits.
  function half(bits) {
    const sign = bits & 0x8000 ? -1 : 1, exponent = (bits >> 10) & 31, fraction = bits & 1023;
    return exponent ? sign * 2 ** (exponent - 15) * (1 + fraction / 1024) : sign * 2 ** -24 * fraction;
  }

  // The quaternion of a rotation vector.
  function turning(x, y, z, into) {
    const angle = Math.hypot(x, y, z), factor = angle > 1e-9 ? Math.sin(angle / 2) / angle : 0.5;
    return into.set(x * factor, y * factor, z * factor, Math.cos(angle / 2));
  }

  // The motion of a body: straight lines between positions; between two attitudes it turns as often
  // as its angular velocity tells, and by the small rest.
  class Motion {
    constructor(head, data) {
      const body = head.body;
      this.at = data.times(body.at);
      this.position = data.array(body.position);
      this.turnedAt = data.times(body.turned_at);
      this.quaternion = data.array(body.quaternion);
      this.turn = data.array(body.turn);
      this.i = 0;
      this.j = 0;
      this.restOf = -1;
      this.rest = new THREE.Vector3();
      this.first = new THREE.Quaternion();
      this.q = new THREE.Quaternion();
    }

    attitude(j, into) {
      const q = this.quaternion;
      return into.set(q[4 * j + 1], q[4 * j + 2], q[4 * j + 3], q[4 * j]).normalize();
    }

    place(t, position, quaternion) {
      const i = this.i = locate(this.at, t, this.i), s = share(this.at, i, t), p = this.position;
      const k = 3 * i, n = i + 1 < this.at.length ? k + 3 : k;
      position.set(p[k] + s * (p[n] - p[k]), p[k + 1] + s * (p[n + 1] - p[k + 1]), p[k + 2] + s * (p[n + 2] - p[k + 2]));
      if (!quaternion) return;
      const j = this.j = locate(this.turnedAt, t, this.j), r = share(this.turnedAt, j, t), w = this.turn;
      if (this.restOf !== j) this.findRest(j);
      turning(r * w[3 * j], r * w[3 * j + 1], r * w[3 * j + 2], quaternion).multiply(this.first);
      if (r > 0) quaternion.premultiply(turning(r * this.rest.x, r * this.rest.y, r * this.rest.z, this.q));
    }

    // What is left of the rotation from key j to the next one after its turns.
    findRest(j) {
      this.restOf = j;
      this.attitude(j, this.first);
      this.rest.set(0, 0, 0);
      if (j + 1 >= this.turnedAt.length) return;
      const w = this.turn, near = turning(w[3 * j], w[3 * j + 1], w[3 * j + 2], new THREE.Quaternion()).multiply(this.first);
      const q = this.attitude(j + 1, new THREE.Quaternion()).multiply(near.invert());
      if (q.w < 0) q.set(-q.x, -q.y, -q.z, -q.w);
      const sine = Math.hypot(q.x, q.y, q.z), angle = 2 * Math.atan2(sine, q.w);
      if (sine > 1e-12) this.rest.set(q.x, q.y, q.z).multiplyScalar(angle / sine);
    }
  }

  // A contact: normal force, friction along the axes of the spot, its torque, slip along them, spin,
  // semi-axes.
  class Contact {
    constructor(head, data, scales) {
      this.name = head.name;
      this.on = head.on;
      this.at = data.times(head.at);
      this.closed = data.array(head.closed);
      this.positions = data.array(head.point);
      this.frames = data.array(head.frame);
      const bits = data.array(head.values);
      this.numbers = Float32Array.from(bits, (b, i) => half(b) * scales[i % 9]);
      this.i = 0;
      this.open = true;
      this.point = new THREE.Vector3();
      this.frame = new THREE.Quaternion();
      this.next = new THREE.Quaternion();
      this.values = new Float32Array(9);
    }

    place(t) {
      const i = this.i = locate(this.at, t, this.i);
      this.open = !this.closed[i];
      if (this.open) return;
      let s = share(this.at, i, t), n = i + 1 < this.at.length ? i + 1 : i;
      if (!this.closed[n]) n = i;
      const p = this.positions, f = this.frames, v = this.numbers;
      const a = 3 * i, b = 3 * n;
      this.point.set(p[a] + s * (p[b] - p[a]), p[a + 1] + s * (p[b + 1] - p[a + 1]), p[a + 2] + s * (p[b + 2] - p[a + 2]));
      this.frame.set(f[4 * i + 1], f[4 * i + 2], f[4 * i + 3], f[4 * i]).normalize();
      if (n !== i) this.frame.slerp(this.next.set(f[4 * n + 1], f[4 * n + 2], f[4 * n + 3], f[4 * n]).normalize(), s);
      for (let k = 0; k < 9; k++) this.values[k] = v[9 * i + k] + s * (v[9 * n + k] - v[9 * i + k]);
    }
  }

  // ---- Shapes ----------------------------------------------------------------------------------

  // Triangles of a grid of points f(u, v), coloured by fields; of them the front is drawn, which is
  // the side out of the material: a hollow is cut open wherever one looks through it from behind.
  function grid(f, nu, nv, fields, colours, flip) {
    const points = [], normals = [], tints = [], e = 1e-4;
    const least = 1e-9 * f(0.13, 1).distanceTo(f(0.57, 0.31));
    const normal = (u, v) => {
      const low = Math.max(v - e, 0), high = Math.min(v + e, 1);
      const a = f(u - e, clamp(v, e, 1 - e)), b = f(u + e, clamp(v, e, 1 - e)), c = f(u, low), d = f(u, high);
      const n = new THREE.Vector3().subVectors(b, a).cross(d.sub(c)).normalize();
      return flip ? n.negate() : n;
    };
    // Neighbouring triangles of one colour share their corners.
    const corners = [new Map(), new Map()], triangles = [];
    const corner = (i, j, k) => {
      const place = i * (nv + 1) + j;
      if (!corners[k].has(place)) {
        const u = i / nu, v = j / nv, p = f(u, v), n = normal(u, v);
        corners[k].set(place, points.length / 3);
        points.push(p.x, p.y, p.z);
        normals.push(n.x, n.y, n.z);
        tints.push(colours[k].r, colours[k].g, colours[k].b);
      }
      return corners[k].get(place);
    };
    for (let i = 0; i < nu; i++) for (let j = 0; j < nv; j++) {
      const k = (Math.floor((i + 0.5) / nu * fields[0]) + Math.floor((j + 0.5) / nv * fields[1])) % 2;
      const a = corner(i, j, k), b = corner(i + 1, j, k), c = corner(i + 1, j + 1, k), d = corner(i, j + 1, k);
      // At a pole, one of the two triangles has no area.
      for (const corners of flip ? [[c, b, a], [d, c, a]] : [[a, b, c], [a, c, d]]) {
        const places = corners.map((n) => [0, 1, 2].map((x) => Math.round(points[3 * n + x] / least)).join());
        if (new Set(places).size === 3) triangles.push(...corners);
      }
    }
    const geometry = new THREE.BufferGeometry();
    for (const [name, list] of [["position", points], ["normal", normals], ["color", tints]]) {
      geometry.setAttribute(name, new THREE.Float32BufferAttribute(list, 3));
    }
    geometry.setIndex(triangles);
    return geometry;
  }

  const round = (radius, z) => (u) => new THREE.Vector3(radius * Math.cos(2 * Math.PI * u), radius * Math.sin(2 * Math.PI * u), z);

  // The grids of a surface in its own frame.
  function shapeGrids(surface, scale, colours, fine) {
    const s = surface.sizes, inside = surface.inside, n = fine;
    const put = (f, nu, nv, fields) => grid(f, nu, nv, fields, colours, inside);
    const disc = (radius, z, up) => grid((u, v) => round(radius * v, z)(up ? u : -u), n, 2, [1, 1], colours, true);
    const length = surface.length || 4 * (s.radius || scale);
    switch (surface.shape) {
      case "sphere": case "ellipsoid": {
        const a = s.semi_axes || [s.radius, s.radius, s.radius];
        const low = surface.part === "lower_half" ? 0.5 : 0, high = surface.part === "upper_half" ? 0.5 : 1;
        const f = (u, v) => {
          const polar = Math.PI * (1 - (low + v * (high - low))), turn = 2 * Math.PI * u;
          return new THREE.Vector3(a[0] * Math.sin(polar) * Math.cos(turn), a[1] * Math.sin(polar) * Math.sin(turn), a[2] * Math.cos(polar));
        };
        const grids = [put(f, n, n / 2, [n % 6 ? 4 : 6, high - low < 1 ? 1 : 2])];
        if (high - low < 1) {
          const cap = (u, v) => new THREE.Vector3(a[0] * v * Math.cos(2 * Math.PI * u), a[1] * v * Math.sin(2 * Math.PI * u), 0);
          grids.push(grid((u, v) => cap(low ? u : -u, v), n, 2, [6, 1], colours, true));
        }
        return grids;
      }
      case "torus": {
        const [middle, wide] = surface.band || [0, Math.PI];
        const f = (u, v) => {
          const tube = middle + wide * (2 * v - 1), rho = s.major_radius + s.minor_radius * Math.cos(tube);
          return new THREE.Vector3(rho * Math.cos(2 * Math.PI * u), rho * Math.sin(2 * Math.PI * u), s.minor_radius * Math.sin(tube));
        };
        return [put(f, 2 * n, n / 2, [12, surface.band ? 1 : 2])];
      }
      case "cylinder": {
        const grids = [put((u, v) => round(s.radius, (v - 0.5) * length)(u), n, 4, [6, 2])];
        if (!inside) grids.push(disc(s.radius, length / 2, true), disc(s.radius, -length / 2, false));
        return grids;
      }
      case "cone": {
        const height = surface.length || scale, slope = Math.tan(s.half_angle);
        const grids = [put((u, v) => round(v * height * slope, v * height)(u), n, 4, [6, 1])];
        if (!inside) grids.push(disc(height * slope, height, true));
        return grids;
      }
      case "paraboloid": {
        const height = surface.length || Math.max(scale, s.vertex_radius) / 2, wide = Math.sqrt(2 * s.vertex_radius * height);
        const grids = [put((u, v) => round(v * wide, v * v * height)(u), n, n / 2, [6, 1])];
        if (!inside) grids.push(disc(wide, height, true));
        return grids;
      }
      case "mesh": return [meshGrid(surface.mesh)];
      default: return [];
    }
  }

  // Triangles as they are given, coloured by how high they are.
  function meshGrid({ points, triangles }) {
    const geometry = new THREE.BufferGeometry(), tints = [];
    for (let k = 2; k < points.length; k += 3) {
      const tint = new THREE.Color().setHSL(0.62 - 0.62 * clamp(0.5 + 0.5 * points[k], 0, 1), 0.7, 0.55);
      tints.push(tint.r, tint.g, tint.b);
    }
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(tints, 3));
    geometry.setIndex([...triangles]);
    geometry.computeVertexNormals();
    return geometry;
  }

  // Words that stand at a place of the picture, whatever the camera does.
  function sign(text, place, size) {
    const canvas = document.createElement("canvas"), pen = canvas.getContext("2d");
    canvas.width = 512;
    canvas.height = 64;
    pen.font = "40px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.lineWidth = 10;
    pen.lineJoin = "round";
    pen.strokeStyle = "#ffffff";
    pen.fillStyle = "#1c2230";
    pen.strokeText(text, 256, 46);
    pen.fillText(text, 256, 46);
    const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: new THREE.CanvasTexture(canvas), depthTest: false, transparent: true }));
    sprite.position.copy(place);
    sprite.scale.set(8 * size, size, 1);
    sprite.renderOrder = 4;
    return sprite;
  }

  // A plane: a chequered rectangle as wide as the run.
  function planeGrid(middle, wide, high, colours) {
    const least = Math.min(wide, high), power = 10 ** Math.floor(Math.log10(least / 6));
    let cell = power * (least / power > 30 ? 5 : least / power > 12 ? 2 : 1);
    const cells = (size) => 2 * Math.ceil(size / cell / 2);
    while (cells(wide) * cells(high) > 600) cell *= 2;
    const [nu, nv] = [cells(wide), cells(high)];
    const x = Math.round(middle.x / cell) * cell, y = Math.round(middle.y / cell) * cell;
    return grid((u, v) => new THREE.Vector3(x + (u - 0.5) * nu * cell, y + (v - 0.5) * nv * cell, 0), nu, nv, [nu, nv], colours, false);
  }

  // Many copies of one shape, put in their places here and drawn at once: a processor that draws
  // takes as long for each thing as for hundreds of triangles.
  class Copies extends THREE.Mesh {
    constructor(shape, material, most) {
      const geometry = new THREE.BufferGeometry(), each = shape.getAttribute("position").count, index = shape.index.array;
      super(geometry, material);
      this.shape = shape;
      this.each = each;
      this.faces = index.length / 3;
      this.matrices = new Float32Array(16 * most);
      this.frustumCulled = false;
      const repeated = (array, Kind, add) => {
        const all = new Kind(array.length * most);
        for (let i = 0; i < most; i++) for (let k = 0; k < array.length; k++) all[i * array.length + k] = array[k] + i * add;
        return all;
      };
      geometry.setIndex(new THREE.BufferAttribute(repeated(index, Uint32Array, each), 1));
      for (const name of material.isMeshLambertMaterial ? ["position", "normal"] : ["position"]) {
        geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * each * most), 3).setUsage(THREE.DynamicDrawUsage));
      }
      if (shape.getAttribute("color")) geometry.setAttribute("color", new THREE.BufferAttribute(repeated(shape.getAttribute("color").array, Float32Array, 0), 3));
      this.finish(0);
    }

    set(i, matrix) {
      const m = matrix.elements;
      this.matrices.set(m, 16 * i);
      for (const name of ["position", "normal"]) {
        const into = this.geometry.getAttribute(name)?.array, from = this.shape.getAttribute(name)?.array;
        if (!into) continue;
        const w = name === "position" ? 1 : 0, dx = w * m[12], dy = w * m[13], dz = w * m[14];
        let k = 3 * this.each * i;
        for (let n = 0; n < from.length; n += 3, k += 3) {
          const x = from[n], y = from[n + 1], z = from[n + 2];
          into[k] = m[0] * x + m[4] * y + m[8] * z + dx;
          into[k + 1] = m[1] * x + m[5] * y + m[9] * z + dy;
          into[k + 2] = m[2] * x + m[6] * y + m[10] * z + dz;
        }
      }
    }

    // So many of them there are now.
    finish(count) {
      this.visible = count > 0;
      this.count = count;
      this.geometry.setDrawRange(0, 3 * this.faces * count);
      this.geometry.boundingSphere = null;
      for (const name of ["position", "normal"]) {
        const attribute = this.geometry.getAttribute(name);
        if (!attribute) continue;
        attribute.clearUpdateRanges();
        attribute.addUpdateRange(0, 3 * this.each * count);
        attribute.needsUpdate = true;
      }
    }
  }

  // ---- The view --------------------------------------------------------------------------------

  // Whether WebGL is computed by the processor, which takes its time for each pixel.
  function drawnByProcessor() {
    const probe = document.createElement("canvas").getContext("webgl2");
    if (!probe) return false;
    let name = probe.getParameter(probe.RENDERER);
    const more = /^webkit/i.test(name) && probe.getExtension("WEBGL_debug_renderer_info");
    if (more) name = probe.getParameter(more.UNMASKED_RENDERER_WEBGL);
    probe.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
  }

  async function main() {
    const { head, array } = await unpack();
    const data = {
      array,
      times(place) {
        const steps = array(place), times = new Float64Array(steps.length);
        let ticks = 0;
        steps.forEach((step, i) => { ticks += step; times[i] = head.start + ticks * head.tick; });
        return times;
      },
    };
    const span = head.end - head.start;
    const motions = head.bodies.map((body) => new Motion({ body }, data));
    const contacts = head.contacts.map((contact) => new Contact(contact, data, head.forces));
    const events = { time: array(head.events.time), touch: array(head.events.touch), contact: array(head.events.contact) };
    const up = new THREE.Vector3(...head.up);
    document.title = head.title;
    byId("title").textContent = head.title;
    byId("about").textContent = head.about || `${head.file} · contensou ${head.program}` +
      (head.status && head.status !== "complete" ? ` · ${head.status} at ${head.end.toPrecision(4)} s` : "") +
      ` · ${head.rows} rows, drawn within ${+head.angle.toPrecision(2)}° and ${+(1e3 * head.length).toPrecision(2)}‰ of the scene` +
      (head.drawn ? "" : " · without contact_geometry: no forces and spots");
    byId("scene").textContent = head.scene;

    const software = drawnByProcessor();
    let renderer;
    try {
      // Colours are as written here, without a conversion of each pixel.
      THREE.ColorManagement.enabled = false;
      renderer = new THREE.WebGLRenderer({ canvas: byId("stage"), antialias: !software });
    } catch {
      problem("This browser shows no WebGL, which the bodies need. Allow hardware acceleration, or use another browser.");
      return;
    }
    renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(35, 1, 1e-3, 1e3);
    camera.up.copy(up);
    scene.add(new THREE.HemisphereLight("#ffffff", "#9aa0ab", 2.1));
    const lamp = new THREE.DirectionalLight("#ffffff", 1.3);
    scene.add(lamp, lamp.target);

    // Bodies and the ground, each a group that has the name of its body.
    const crowded = head.bodies.length > CROWD, curved = head.surfaces.filter((surface) => surface.shape !== "plane").length;
    const fine = curved > 400 ? 8 : curved > 40 ? 12 : curved > 12 ? 20 : curved > 4 ? 24 : 36;
    const groups = head.bodies.map((body, i) => Object.assign(new THREE.Group(), { name: body.name, userData: { body: i } }));
    const ground = Object.assign(new THREE.Group(), { name: "ground" });
    const box = new THREE.Box3(), p = new THREE.Vector3(), q3 = new THREE.Vector3(), q = new THREE.Quaternion();
    motions.forEach((motion) => {
      for (let k = 0; k < motion.position.length; k += 3) box.expandByPoint(p.fromArray(motion.position, k));
    });
    if (box.isEmpty()) box.expandByPoint(p.set(0, 0, 0));
    const middle = box.getCenter(new THREE.Vector3()), travel = box.getSize(new THREE.Vector3()).length();
    const sizes = head.surfaces.filter((surface) => surface.body >= 0).map((surface) => Math.max(surface.sizes.radius || 0, ...(surface.sizes.semi_axes || [])));
    const largest = Math.max(...sizes, 0) || head.scale;
    const kept = new Map(), alike = new Map();
    const soft = new THREE.MeshLambertMaterial({ vertexColors: true });
    // Planes fill most of the picture: no light is computed for them, as it is the same all over.
    const flat = new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    const glass = new THREE.MeshBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.25, depthWrite: false });
    const seen = new Map(), unknown = [];
    head.surfaces.forEach((surface) => {
      if (surface.mesh) surface.mesh = { points: array(surface.mesh.points), triangles: array(surface.mesh.triangles) };
      const order = surface.body < 0 ? 0 : seen.get(surface.body) || 0;
      seen.set(surface.body, order + 1);
      const body = new THREE.Color(surface.body < 0 ? "#9aa3b2" : PALETTE[(surface.body + 3 * order) % PALETTE.length]);
      const colours = surface.shape === "plane" && surface.body < 0
        ? [new THREE.Color("#aab3c0"), new THREE.Color("#9aa4b3")] : [body, body.clone().lerp(new THREE.Color("#ffffff"), 0.55)];
      const axes = surface.axes, centre = new THREE.Vector3(...surface.centre);
      const pose = new THREE.Matrix4().makeBasis(p.fromArray(axes, 0).clone(), p.fromArray(axes, 3).clone(), p.fromArray(axes, 6).clone()).setPosition(centre);
      let grids, material = soft;
      if (surface.shape === "plane") {
        const normal = p.fromArray(axes, 6).clone(), upright = normal.dot(up) < 0.7;
        const corner = box.getSize(new THREE.Vector3()), along = (k) => Math.abs(corner.x * axes[3 * k]) + Math.abs(corner.y * axes[3 * k + 1]) + Math.abs(corner.z * axes[3 * k + 2]);
        let [wide, high] = [0, 1].map((k) => surface.body < 0 ? Math.max(5 * head.scale, 1.4 * along(k), 0.1 * travel) : 2 * head.scale);
        if (surface.body < 0 && upright) {
          // A wall: as high as what moves, and its sides upright.
          const y = up.clone().addScaledVector(normal, -up.dot(normal));
          if (y.lengthSq() > 1e-6) {
            y.normalize();
            pose.makeBasis(y.clone().cross(normal), y, normal).setPosition(centre);
            wide = Math.max(5 * head.scale, 1.4 * travel);
            high = Math.min(wide, Math.abs(corner.x * y.x) + Math.abs(corner.y * y.y) + Math.abs(corner.z * y.z) + 4 * largest);
          }
        }
        const own = surface.body < 0 ? middle.clone().applyMatrix4(pose.clone().invert()) : new THREE.Vector3();
        grids = [planeGrid(own, wide, high, colours)];
        material = surface.body < 0 && !upright ? flat : glass;
      } else {
        const key = JSON.stringify([surface.shape, surface.inside, surface.part, surface.length, surface.sizes, surface.band, colours.map((c) => c.getHex())]);
        if (!kept.has(key)) kept.set(key, shapeGrids(surface, head.scale, colours, fine));
        grids = kept.get(key);
      }
      if (crowded && surface.body >= 0 && !surface.touched) {
        for (const geometry of grids) {
          if (!alike.has(geometry)) alike.set(geometry, { material, of: [] });
          alike.get(geometry).of.push({ group: groups[surface.body], pose });
        }
        return;
      }
      if (surface.touched) {
        // Nobody told the page this shape: it draws where the surface was touched, in the frame of its body.
        const dots = new THREE.BufferGeometry(), places = array(surface.touched);
        dots.setAttribute("position", new THREE.BufferAttribute(places, 3));
        const points = new THREE.Points(dots, new THREE.PointsMaterial({ color: body, size: 5, sizeAttenuation: false }));
        points.name = surface.name;
        (surface.body < 0 ? ground : groups[surface.body]).add(points);
        unknown.push(`${surface.name} (${surface.shape})`);
      }
      for (const geometry of grids) {
        const mesh = new THREE.Mesh(geometry, material);
        mesh.name = surface.name;
        mesh.applyMatrix4(pose);
        mesh.userData = { shape: surface.shape, inside: surface.inside };
        (surface.body < 0 ? ground : groups[surface.body]).add(mesh);
      }
    });
    if (unknown.length) {
      const few = unknown.slice(0, 3).join(", ") + (unknown.length > 3 ? ` and ${unknown.length - 3} more` : "");
      byId("about").textContent += ` · drawn only where touched, as their shape is not known here: ${few}`;
    }
    scene.add(ground, ...groups);
    const crowds = [...alike].map(([geometry, { material, of }]) => {
      const mesh = new Copies(geometry, material, of.length);
      mesh.userData = { of };
      scene.add(mesh);
      return mesh;
    });

    // Axes of the bodies.
    const axesOf = groups.map((group) => {
      const lines = new THREE.AxesHelper(0.5 * head.scale);
      lines.visible = false;
      if (!crowded) group.add(lines);
      return lines;
    });
    const asked = head.asked && { ...head.asked, slip: array(head.asked.slip), wrench: array(head.asked.wrench) };
    if (asked) {
      document.documentElement.classList.add("still");
      asked.labels.forEach((text, i) => scene.add(sign(text, new THREE.Vector3().setComponent(i, 1.35), 0.11)));
    }

    // Trails of the centres of mass.
    const trails = new THREE.Group();
    motions.forEach((motion, i) => {
      if (motion.at.length < 2) return;
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(motion.position, 3));
      const line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: PALETTE[i % PALETTE.length] }));
      line.frustumCulled = false;
      line.userData = { motion, group: groups[i] };
      trails.add(line);
    });
    // From the last key to where the bodies are.
    const trailEnds = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ vertexColors: true }));
    trailEnds.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(6 * trails.children.length), 3));
    trailEnds.geometry.setAttribute("color", new THREE.Float32BufferAttribute(trails.children.flatMap((line) => { const c = line.material.color; return [c.r, c.g, c.b, c.r, c.g, c.b]; }), 3));
    trailEnds.frustumCulled = false;
    scene.add(trails, trailEnds);

    // Arrows of the forces and spots, one of each for a contact.
    const count = Math.max(contacts.length, 1), sides = count > 400 ? 3 : count > 100 ? 4 : count > 8 ? 6 : 10, [around, across] = count > 400 ? [8, 1] : count > 100 ? [8, 2] : count > 8 ? [16, 4] : [32, 8];
    const shaft = new THREE.CylinderGeometry(0.018, 0.018, 1, sides, 1, true).translate(0, 0.5, 0).rotateX(Math.PI / 2);
    const tip = new THREE.ConeGeometry(0.05, 0.14, sides, 1, count > 100).translate(0, 0.07, 0).rotateX(Math.PI / 2);
    const arrows = (colour, name) => {
      const light = { color: colour, depthTest: false };
      const material = count > 8 ? new THREE.MeshBasicMaterial(light) : new THREE.MeshLambertMaterial({ ...light, emissive: colour, emissiveIntensity: 0.35 });
      const pair = new THREE.Group();
      pair.name = name;
      for (const geometry of [shaft, tip]) {
        const mesh = new Copies(geometry, material, count);
        mesh.renderOrder = 2;
        pair.add(mesh);
      }
      scene.add(pair);
      return pair;
    };
    const pulls = arrows(PULL, "normal forces"), rubs = arrows(RUB, "friction forces");
    const heat = (x) => new THREE.Color().setHSL(0.66 - 0.66 * x, 0.85, 0.35 + 0.2 * x);
    const spotGrid = grid((u, v) => round(v, 0)(u), around, across, [1, 1], [heat(0), heat(0)], false);
    const tints = spotGrid.getAttribute("color"), places = spotGrid.getAttribute("position");
    for (let i = 0; i < tints.count; i++) {
      const r = Math.min(1, Math.hypot(places.getX(i), places.getY(i))), c = heat(Math.sqrt(1 - r * r));
      tints.setXYZ(i, c.r, c.g, c.b);
    }
    const spots = new Copies(spotGrid, new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide, transparent: true, opacity: 0.9, depthTest: false }), count);
    spots.name = "spots";
    spots.renderOrder = 1;
    scene.add(spots);
    const TRACTIONS = 64;
    const tractionLines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: "#101418", depthTest: false }));
    tractionLines.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(18 * TRACTIONS), 3));
    tractionLines.frustumCulled = false;
    tractionLines.renderOrder = 3;
    scene.add(tractionLines);

    // Lengths of arrows: in proportion to the force up to the one that is usual, and by its
    // logarithm above, so that an impact does not dwarf a weight.
    const forces = contacts.flatMap((c) => Array.from({ length: c.at.length }, (_, i) => c.numbers[9 * i]).filter((x) => x > 0)).sort((a, b) => a - b);
    const usual = forces[Math.floor(0.7 * forces.length)] || 1;
    // The more of them there are, the smaller they are drawn.
    const crowd = Math.min(1, 2 / Math.sqrt(count));
    const arrowLength = (force) => 0.45 * crowd * head.scale * (force <= usual ? force / usual : 1 + Math.log10(force / usual));
    const axesSorted = contacts.flatMap((c) => Array.from({ length: c.at.length }, (_, i) => c.numbers[9 * i + 7]).filter((x) => x > 0)).sort((a, b) => a - b);
    const usualAxis = axesSorted[Math.floor(0.7 * axesSorted.length)] || head.scale;

    // ---- State ---------------------------------------------------------------------------------

    const state = { t: head.start, playing: false, speed: 1, camera: "orbit", body: Math.max(0, motions.findIndex((m) => m.at.length > 2)), contact: -1, dirty: true };
    const orbit = { target: middle.clone(), azimuth: 0.9, height: 0.35, distance: 3 * head.scale };
    const base = up.clone().cross(Math.abs(up.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0)).normalize();
    const side = up.clone().cross(base);
    const shown = {};
    const layers = [
      ["bodies", "bodies", true], ["ground", "ground", true], ["trails", "trails", motions.length <= 40],
      ["normal", "normal forces", true], ["friction", "friction forces", true], ["spots", "spots", true],
      ["traction", "traction in the spot", true], ["axes", head.asked ? "axes" : "axes of the bodies", Boolean(head.asked)], ["wires", "wire frames", false],
    ].map(([key, text, on], i) => {
      const label = document.createElement("label"), box = document.createElement("input");
      box.type = "checkbox";
      box.id = `layer-${key}`;
      box.checked = shown[key] = on;
      box.addEventListener("change", () => { shown[key] = box.checked; state.dirty = true; });
      label.append(box, `${text} (${i + 1})`);
      byId("layers").append(label);
      return box;
    });
    const choose = (id, names, first) => {
      if (first) byId(id).append(new Option(first, -1));
      names.forEach((name, i) => byId(id).append(new Option(name, i)));
    };
    choose("body", head.bodies.map((body) => body.name));
    choose("contact", contacts.map((contact) => contact.name), "of the largest force");
    byId("body").value = state.body;
    byId("body").addEventListener("change", () => { state.body = +byId("body").value; state.dirty = true; });
    byId("contact").addEventListener("change", () => { state.contact = +byId("contact").value; state.dirty = true; });
    byId("magnify").addEventListener("input", () => { state.dirty = true; });
    const speeds = [1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.03, 0.1, 0.2, 0.5, 1, 2, 5, 10, 100, 1000];
    for (const speed of speeds) byId("speed").append(new Option(`${speed}×`, speed));
    // A run takes between three and thirty seconds at first.
    const wanted = span > 30 ? span / 30 : span < 3 ? span / 5 : 1;
    state.speed = speeds.reduce((best, x) => Math.abs(Math.log(x / wanted)) < Math.abs(Math.log(best / wanted)) ? x : best);
    byId("speed").value = state.speed;
    byId("speed").addEventListener("change", () => { state.speed = +byId("speed").value; });

    // Touches that a lift follows soon: there, time can go slower.
    const impacts = [];
    const open = new Map();
    events.time.forEach((t, i) => {
      if (events.touch[i]) open.set(events.contact[i], t);
      else if (open.has(events.contact[i])) {
        const start = open.get(events.contact[i]), length = t - start;
        if (length > 0 && length < 0.01 * span) impacts.push([start - length, t + length]);
        open.delete(events.contact[i]);
      }
    });
    byId("slow").disabled = impacts.length === 0;
    const pace = (t) => {
      if (!byId("slow").checked) return state.speed;
      const here = impacts.find(([start, end]) => t >= start && t <= end);
      return here ? Math.min(state.speed, (here[1] - here[0]) / 2) : state.speed;
    };

    function seek(t) {
      state.t = clamp(t, head.start, head.end);
      state.dirty = true;
    }
    function play(on) {
      if (on && state.t >= head.end) seek(head.start);
      state.playing = on;
      byId("play").textContent = on ? "❚❚" : "▶";
      state.dirty = true;
    }
    function step(direction) {
      const e = 1e-12 * Math.max(1, Math.abs(head.end));
      if (direction > 0) seek(events.time.find((t) => t > state.t + e) ?? head.end);
      else seek([...events.time].reverse().find((t) => t < state.t - e) ?? head.start);
      play(false);
    }
    function faster(direction) {
      const at = clamp(speeds.indexOf(state.speed) + direction, 0, speeds.length - 1);
      byId("speed").value = state.speed = speeds[at];
    }
    function setCamera(kind) {
      if (kind === "fit") {
        kind = "orbit";
        orbit.target.copy(middle);
        orbit.distance = (asked ? 1.9 : 1.5) * Math.max(head.scale, travel) * Math.max(1, 1 / camera.aspect);
      } else if (kind === "orbit" && state.camera !== "orbit" && motions.length) {
        motions[state.body].place(state.t, orbit.target);
      }
      if (kind === "ride" && state.camera !== "ride") orbit.distance = Math.min(orbit.distance, 4 * head.scale);
      state.camera = kind;
      for (const button of byId("cameras").children) button.setAttribute("aria-pressed", button.dataset.camera === kind);
      state.dirty = true;
    }
    for (const button of byId("cameras").children) button.addEventListener("click", () => setCamera(button.dataset.camera));
    const dark = (on) => {
      document.documentElement.dataset.theme = on ? "dark" : "light";
      scene.background = new THREE.Color(on ? "#12161d" : "#e9ecf1");
      for (const material of [flat, glass]) material.color.set(on ? "#6f7887" : "#ffffff");
      state.dirty = true;
    };
    byId("theme").addEventListener("click", () => dark(document.documentElement.dataset.theme !== "dark"));
    dark(matchMedia("(prefers-color-scheme: dark)").matches);
    byId("play").addEventListener("click", () => play(!state.playing));
    byId("before").addEventListener("click", () => step(-1));
    byId("next").addEventListener("click", () => step(1));
    byId("time").addEventListener("input", () => seek(head.start + span * byId("time").value));
    byId("fold").addEventListener("click", () => byId("panel").classList.toggle("folded"));
    if (innerWidth < 640) byId("panel").classList.add("folded");

    // ---- Keys and pointers ---------------------------------------------------------------------

    const nextBody = () => {
      if (!motions.length) return;
      byId("body").value = state.body = (state.body + 1) % motions.length;
      state.dirty = true;
    };
    const keys = {
      " ": () => play(!state.playing), ",": () => step(-1), ".": () => step(1), "-": () => faster(-1), "+": () => faster(1), "=": () => faster(1),
      Home: () => seek(head.start), End: () => seek(head.end), o: () => setCamera("orbit"), f: () => setCamera("follow"), r: () => setCamera("ride"),
      0: () => setCamera("fit"), b: nextBody, d: () => byId("theme").click(), p: () => byId("fold").click(),
      ArrowLeft: (event) => seek(state.t - span * (event.shiftKey ? 0.1 : 1 / 300)), ArrowRight: (event) => seek(state.t + span * (event.shiftKey ? 0.1 : 1 / 300)),
    };
    layers.forEach((box, i) => { keys[i + 1] = () => box.click(); });
    addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
      if (event.target.tagName === "BUTTON" && event.key === " ") event.target.blur();
      const act = keys[event.key];
      if (!act) return;
      event.preventDefault();
      act(event);
    });
    const stage = byId("stage"), fingers = new Map();
    let pinch = 0;
    const move = (dx, dy) => {
      const scaleOf = orbit.distance / stage.clientHeight;
      const right = p.set(1, 0, 0).applyQuaternion(camera.quaternion).clone(), above = p.set(0, 1, 0).applyQuaternion(camera.quaternion).clone();
      if (state.camera !== "orbit") return;
      orbit.target.addScaledVector(right, -dx * scaleOf).addScaledVector(above, dy * scaleOf);
    };
    stage.addEventListener("pointerdown", (event) => {
      stage.setPointerCapture(event.pointerId);
      stage.focus({ preventScroll: true });
      fingers.set(event.pointerId, event);
      pinch = 0;
    });
    stage.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
      fingers.set(event.pointerId, event);
      if (fingers.size === 2) {
        const [a, b] = [...fingers.values()], apart = Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
        if (pinch) orbit.distance = clamp(orbit.distance * pinch / apart, 1e-4 * head.scale, 1e3 * head.scale);
        pinch = apart;
        move(dx / 2, dy / 2);
      } else if (event.shiftKey || event.buttons & 6) move(dx, dy);
      else {
        orbit.azimuth -= 0.007 * dx;
        orbit.height = clamp(orbit.height + 0.007 * dy, -1.55, 1.55);
      }
      state.dirty = true;
    });
    for (const name of ["pointerup", "pointercancel"]) stage.addEventListener(name, (event) => { fingers.delete(event.pointerId); pinch = 0; });
    stage.addEventListener("contextmenu", (event) => event.preventDefault());
    stage.addEventListener("wheel", (event) => {
      event.preventDefault();
      orbit.distance = clamp(orbit.distance * Math.exp(0.001 * event.deltaY), 1e-4 * head.scale, 1e3 * head.scale);
      state.dirty = true;
    }, { passive: false });
    const seenAt = (event) => {
      const ray = new THREE.Raycaster();
      ray.setFromCamera(new THREE.Vector2(2 * event.clientX / stage.clientWidth - 1, 1 - 2 * event.clientY / stage.clientHeight), camera);
      return ray.intersectObjects([...groups, ...crowds], true).find((hit) => hit.object.isMesh);
    };
    // A point of a limit surface tells its slip.
    const mark = new THREE.Mesh(new THREE.SphereGeometry(0.025, 12, 8), new THREE.MeshBasicMaterial({ color: "#101418", depthTest: false }));
    mark.visible = false;
    if (asked) scene.add(mark);
    stage.addEventListener("click", (event) => {
      const hit = asked && seenAt(event);
      if (!hit) return;
      const places = hit.object.geometry.getAttribute("position"), at = [hit.face.a, hit.face.b, hit.face.c];
      const [k] = at.sort((i, j) => p.fromBufferAttribute(places, i).distanceTo(hit.point) - q3.fromBufferAttribute(places, j).distanceTo(hit.point));
      const [x, y, w] = asked.slip.slice(3 * k, 3 * k + 3), [fx, fy, torque] = asked.wrench.slice(3 * k, 3 * k + 3), speed = Math.hypot(x, y);
      mark.position.fromBufferAttribute(places, k);
      mark.visible = state.dirty = true;
      const short = (value) => Math.abs(value) < 1e-12 ? "0" : value.toPrecision(4);
      byId("figures").textContent = `force ${short(fx)}, ${short(fy)} N, torque ${short(torque)} N m\n` +
        (speed < 1e-12 ? "spin alone" : `slip towards ${(180 / Math.PI * Math.atan2(y, x)).toFixed(1)}°, centre ${w ? (1e3 * speed / Math.abs(w)).toPrecision(3) + " mm from the middle" : "infinitely far: no spin"}`);
    });
    stage.addEventListener("dblclick", (event) => {
      const hit = seenAt(event);
      if (!hit) return;
      const group = hit.object.userData.of ? hit.object.userData.of[Math.floor(hit.faceIndex / hit.object.faces)].group : hit.object.parent;
      byId("body").value = state.body = group.userData.body;
      setCamera("follow");
    });

    // ---- Charts --------------------------------------------------------------------------------

    const second = Math.max(0, ["Inclination of the axis", "Speed"].map((title) => head.charts.findIndex((chart) => chart.title === title)).find((at) => at >= 0) ?? 0);
    const strips = head.charts.map((chart, i) => {
      const label = document.createElement("label"), box = document.createElement("input");
      box.type = "checkbox";
      box.checked = i === 0 || i === second;
      box.addEventListener("change", () => { resize(); });
      label.append(box, `${chart.title} [${chart.unit}]`);
      byId("strips").append(label);
      const lines = chart.lines.map((line) => ({ name: line.name, at: array(line.at), values: array(line.values) }));
      let low = Infinity, high = -Infinity;
      for (const line of lines) for (const value of line.values) { low = Math.min(low, value); high = Math.max(high, value); }
      return { ...chart, lines, box, low, high };
    });
    const HEIGHT = 74, LEFT = 10;
    const brief = (x) => { const a = Math.abs(x); return a && (a < 1e-2 || a >= 1e5) ? x.toExponential(1) : String(+x.toPrecision(3)); };
    function paintCharts() {
      const wide = byId("charts").clientWidth, visible = strips.filter((strip) => strip.box.checked), ratio = devicePixelRatio;
      byId("charts").style.height = `${visible.length * HEIGHT}px`;
      const canvas = byId("charts");
      canvas.width = wide * ratio;
      canvas.height = visible.length * HEIGHT * ratio;
      byId("cursor").style.height = `${visible.length * HEIGHT}px`;
      byId("cursor").replaceChildren(...visible.map(() => document.createElement("span")));
      const pen = canvas.getContext("2d"), style = getComputedStyle(document.documentElement);
      pen.scale(ratio, ratio);
      pen.font = "11px system-ui, sans-serif";
      visible.forEach((strip, k) => {
        const top = k * HEIGHT, x = (t) => LEFT + (wide - 2 * LEFT) * t / (span || 1), y = (v) => top + HEIGHT - 8 - (HEIGHT - 26) * (v - strip.low) / (strip.high - strip.low);
        pen.fillStyle = style.getPropertyValue("--card");
        pen.fillRect(0, top, wide, HEIGHT - 3);
        pen.fillStyle = style.getPropertyValue("--faint");
        pen.fillText(`${strip.title} [${strip.unit}]  ${brief(strip.low)} to ${brief(strip.high)}`, LEFT, top + 12);
        let along = wide - LEFT;
        strip.lines.forEach((line, n) => {
          pen.strokeStyle = pen.fillStyle = PALETTE[n % PALETTE.length];
          along -= pen.measureText(line.name).width + 12;
          pen.fillText(line.name, along, top + 12);
          pen.beginPath();
          for (let i = 0; i < line.at.length; i++) pen.lineTo(x(line.at[i]), y(line.values[i]));
          pen.stroke();
        });
      });
      const ticks = byId("ticks");
      ticks.width = ticks.clientWidth * ratio;
      ticks.height = ticks.clientHeight * ratio;
      const mark = ticks.getContext("2d");
      events.time.forEach((t, i) => {
        mark.fillStyle = events.touch[i] ? "#d43a3a" : "#2f7fd1";
        mark.fillRect((t - head.start) / (span || 1) * (ticks.width - 2), events.touch[i] ? 0 : ticks.height * 0.75, Math.max(1, ratio), ticks.height * 0.25);
      });
    }
    function paintCursor(readable) {
      const visible = strips.filter((strip) => strip.box.checked);
      if (!visible.length) return;
      const wide = byId("charts").clientWidth, t = state.t - head.start, x = LEFT + (wide - 2 * LEFT) * t / (span || 1);
      byId("cursor").style.transform = `translateX(${x.toFixed(1)}px)`;
      if (!readable) return;
      byId("cursor").classList.toggle("left", x > 0.7 * wide);
      visible.forEach((strip, k) => {
        const words = strip.lines.map((line) => { const i = locate(line.at, t, 0), s = share(line.at, i, t); return brief(line.values[i] + s * ((line.values[i + 1] ?? line.values[i]) - line.values[i])); }).join("  ");
        byId("cursor").children[k].textContent = words;
      });
    }
    const scrub = (event) => {
      if (event.buttons & 1) seek(head.start + span * clamp((event.offsetX - LEFT) / (byId("charts").clientWidth - 2 * LEFT), 0, 1));
    };
    byId("charts").addEventListener("pointerdown", scrub);
    byId("charts").addEventListener("pointermove", scrub);

    // ---- Drawing -------------------------------------------------------------------------------

    const matrix = new THREE.Matrix4(), scaling = new THREE.Vector3(), one = new THREE.Vector3(1, 1, 1), turn = new THREE.Quaternion(), z = new THREE.Vector3(0, 0, 1);
    const u = new THREE.Vector3(), v = new THREE.Vector3();
    function addArrow(pair, point, direction, length) {
      const [line, top] = pair.children, thick = 0.5 * crowd * head.scale;
      if (!(length > 0)) return;
      const i = pair.userData.count++;
      turn.setFromUnitVectors(z, direction);
      const head_ = Math.min(0.14 * thick, 0.6 * length);
      line.set(i, matrix.compose(point, turn, scaling.set(thick, thick, length - head_)));
      const wide = head_ / 0.14;
      top.set(i, matrix.compose(u.copy(direction).multiplyScalar(length - head_).add(point), turn, scaling.set(wide, wide, wide)));
    }
    function chosen() {
      if (state.contact >= 0) return contacts[state.contact];
      let best = null;
      for (const contact of contacts) if (!contact.open && (!best || contact.values[0] > best.values[0])) best = contact;
      return best;
    }
    const magnification = () => 0.09 * crowd * head.scale / usualAxis * 10 ** byId("magnify").value;

    // Friction at a place of the spot, against the slip there, with the pressure; the slip in m/s.
    function traction(contact, x, y) {
      const f = contact.values, a = f[7], b = f[8], vx = f[4] - f[6] * y * b, vy = f[5] + f[6] * x * a, speed = Math.hypot(vx, vy);
      return { speed, pressure: Math.sqrt(Math.max(0, 1 - x * x - y * y)), x: speed > 0 ? -vx / speed : 0, y: speed > 0 ? -vy / speed : 0 };
    }
    const inside = [];
    for (let i = -4; i <= 4; i++) for (let j = -4; j <= 4; j++) if (Math.hypot(i, j) <= 4.2) inside.push([i / 4.6, j / 4.6]);
    const rubbing = (contact) => Math.hypot(contact.values[1], contact.values[2]) + Math.abs(contact.values[3]) > 0;
    // Slower than this at all places of the spot, friction sticks: a millionth of the largest slip.
    const slowest = 1e-6 * Math.max(head.forces[4], 1e-12);

    const ellipse = { by: 0, image: null };
    const warmth = Uint32Array.from({ length: 256 }, (_, i) => {
      const c = heat(i / 255), byte = (x) => Math.round(255 * x);
      return (255 << 24 | byte(c.b) << 16 | byte(c.g) << 8 | byte(c.r)) >>> 0;
    });
    function paintSpot(contact) {
      const canvas = byId("spot"), pen = canvas.getContext("2d", { willReadFrequently: true }), wide = canvas.width, high = canvas.height;
      pen.clearRect(0, 0, wide, high);
      if (!contact || contact.open) {
        if (!asked) byId("figures").textContent = contacts.length ? "open" : "";
        return;
      }
      const f = contact.values, a = f[7], b = f[8], unit = 0.42 * Math.min(wide, high * a / Math.max(b, 1e-300)) / 1, ax = Math.min(unit, 0.45 * wide), by = ax * b / a;
      // One picture of the pressure serves all spots of nearly the same shape.
      if (Math.abs(by - ellipse.by) > 0.2 || !ellipse.image) {
        ellipse.by = by;
        ellipse.image = pen.createImageData(wide, high);
        const pixels = new Uint32Array(ellipse.image.data.buffer);
        for (let row = 0; row < high; row++) for (let col = 0; col < wide; col++) {
          const x = (col + 0.5 - wide / 2) / ax, y = -(row + 0.5 - high / 2) / by, r = x * x + y * y;
          if (r <= 1) pixels[row * wide + col] = warmth[Math.round(255 * Math.sqrt(1 - r))];
        }
      }
      pen.putImageData(ellipse.image, 0, 0);
      const arrow = (x, y, dx, dy, colour) => {
        const x0 = wide / 2 + x * ax, y0 = high / 2 - y * by, x1 = x0 + dx, y1 = y0 - dy, angle = Math.atan2(y1 - y0, x1 - x0);
        pen.strokeStyle = colour;
        pen.beginPath();
        pen.moveTo(x0, y0); pen.lineTo(x1, y1);
        pen.moveTo(x1 - 4 * Math.cos(angle - 0.5), y1 - 4 * Math.sin(angle - 0.5)); pen.lineTo(x1, y1);
        pen.lineTo(x1 - 4 * Math.cos(angle + 0.5), y1 - 4 * Math.sin(angle + 0.5));
        pen.stroke();
      };
      let largest = 0;
      for (const [x, y] of inside) largest = Math.max(largest, traction(contact, x, y).speed);
      const sticks = largest < slowest;
      pen.lineWidth = 1.2;
      const lines = clamp(Math.floor(by / 12), 1, 4), reach = clamp(0.7 * by / (lines + 0.6), 4, 16);
      if (rubbing(contact) && !sticks) for (let i = -5; i <= 5; i++) for (let j = -lines; j <= lines; j++) {
        const x = i / 5.6, y = j / (lines + 0.6), here = traction(contact, x, y);
        if (here.pressure > 0.2) arrow(x, y, reach * here.pressure * here.x, reach * here.pressure * here.y, "#ffffff");
      }
      // The centre of rotation, where nothing slips.
      let words = sticks ? "sticks" : "slips";
      if (!sticks && f[6]) {
        const x = -f[5] / (f[6] * a), y = f[4] / (f[6] * b);
        if (x * x + y * y < 1) {
          pen.strokeStyle = "#ffffff";
          pen.lineWidth = 2;
          pen.beginPath();
          pen.arc(wide / 2 + x * ax, high / 2 - y * by, 5, 0, 2 * Math.PI);
          pen.stroke();
          words = "slips about a centre inside";
        }
      }
      const area = Math.PI * a * b;
      byId("figures").textContent = `${contact.name}: ${words}\n${(1e6 * a).toPrecision(4)} × ${(1e6 * b).toPrecision(4)} µm, drawn ${magnification().toPrecision(2)} times\n` +
        `force ${f[0].toPrecision(4)} N, friction ${Math.hypot(f[1], f[2]).toPrecision(3)} N\npressure up to ${(area > 0 ? 1.5 * f[0] / area / 1e6 : 0).toPrecision(3)} MPa\n` +
        `slip ${Math.hypot(f[4], f[5]).toPrecision(3)} m/s, spin ${f[6].toPrecision(3)} rad/s`;
    }

    function paintTraction(contact) {
      const places = tractionLines.geometry.getAttribute("position");
      let n = 0;
      if (contact && !contact.open && shown.traction && shown.spots && rubbing(contact)) {
        const zoom = magnification(), a = zoom * contact.values[7], b = zoom * contact.values[8], length = 0.22 * a;
        const set = (x, y) => { u.set(x, y, 0).applyQuaternion(contact.frame).add(contact.point); places.setXYZ(n++, u.x, u.y, u.z); };
        for (const [x, y] of inside) {
          const here = traction(contact, x, y), k = length * here.pressure, x0 = x * a, y0 = y * b, x1 = x0 + k * here.x, y1 = y0 + k * here.y;
          if (here.speed < slowest || n + 6 > places.count) continue;
          set(x0, y0); set(x1, y1);
          for (const flip of [-1, 1]) { set(x1, y1); set(x1 - 0.35 * k * (here.x + 0.6 * flip * here.y), y1 - 0.35 * k * (here.y - 0.6 * flip * here.x)); }
        }
      }
      tractionLines.geometry.setDrawRange(0, n);
      places.needsUpdate = true;
    }

    function drawForces() {
      pulls.userData.count = rubs.userData.count = 0;
      let closed = 0;
      const zoom = magnification();
      for (const contact of contacts) {
        contact.place(state.t);
        if (contact.open) continue;
        const f = contact.values, rub = Math.hypot(f[1], f[2]);
        if (shown.normal) addArrow(pulls, contact.point, v.set(0, 0, contact.on).applyQuaternion(contact.frame), arrowLength(f[0]));
        if (shown.friction && rub > 0) addArrow(rubs, contact.point, v.set(f[1], f[2], 0).multiplyScalar(contact.on / rub).applyQuaternion(contact.frame), arrowLength(rub));
        if (shown.spots) spots.set(closed++, matrix.compose(contact.point, contact.frame, scaling.set(zoom * f[7], zoom * f[8], 1)));
      }
      for (const pair of [pulls, rubs]) for (const mesh of pair.children) mesh.finish(pair.userData.count);
      spots.finish(closed);
    }

    function drawBodies() {
      groups.forEach((group, i) => motions[i].place(state.t, group.position, group.quaternion));
      groups.forEach((group) => { group.visible = shown.bodies; });
      for (const mesh of crowds) {
        if (shown.bodies) mesh.userData.of.forEach(({ group, pose }, i) => mesh.set(i, matrix.compose(group.position, group.quaternion, one).multiply(pose)));
        mesh.finish(shown.bodies ? mesh.userData.of.length : 0);
      }
      trails.visible = trailEnds.visible = shown.trails;
      if (!shown.trails) return;
      const ends = trailEnds.geometry.getAttribute("position");
      trails.children.forEach((line, i) => {
        const { motion, group } = line.userData, keys = motion.i;
        line.geometry.setDrawRange(0, keys + 1);
        ends.setXYZ(2 * i, motion.position[3 * keys], motion.position[3 * keys + 1], motion.position[3 * keys + 2]);
        ends.setXYZ(2 * i + 1, group.position.x, group.position.y, group.position.z);
      });
      ends.needsUpdate = true;
    }

    function draw(now = performance.now()) {
      drawBodies();
      drawForces();
      axesOf.forEach((lines) => { lines.visible = shown.axes; });
      ground.visible = shown.ground;
      soft.wireframe = shown.wires;
      const contact = chosen();
      paintTraction(contact);
      // Figures that one reads need not change with every frame.
      const readable = !state.playing || now - drawn.words > 120;
      if (readable) {
        drawn.words = now;
        paintSpot(contact);
      }

      if (state.camera !== "orbit" && motions.length) motions[state.body].place(state.t, orbit.target, q);
      u.copy(base).multiplyScalar(Math.cos(orbit.azimuth)).addScaledVector(side, Math.sin(orbit.azimuth)).multiplyScalar(Math.cos(orbit.height)).addScaledVector(up, Math.sin(orbit.height));
      camera.up.copy(up);
      if (state.camera === "ride") { u.applyQuaternion(q); camera.up.applyQuaternion(q); }
      camera.position.copy(orbit.target).addScaledVector(u, orbit.distance);
      camera.near = 0.01 * orbit.distance;
      camera.far = 20 * (orbit.distance + travel + 5 * head.scale);
      camera.lookAt(orbit.target);
      camera.updateProjectionMatrix();
      lamp.position.copy(camera.position).addScaledVector(up, orbit.distance);
      lamp.target.position.copy(orbit.target);
      renderer.render(scene, camera);
      byId("time").value = span ? (state.t - head.start) / span : 0;
      byId("clock").textContent = `${state.t.toFixed(clamp(4 - Math.floor(Math.log10(Math.max(span, 1e-9))), 0, 12))} s`;
      paintCursor(readable);
      drawn.frames += 1;
    }

    const drawn = { frames: 0, words: 0, slow: 0 };
    // Pixels for each of the screen. What moves is drawn with fewer if that takes too long, and what
    // stands still with more where the processor draws, in place of smoothed edges.
    const coarse = [1, 0.75, 0.5];
    let level = 0, still = false;
    const ratio = () => {
      const usual = software ? 1 : Math.min(devicePixelRatio, 2);
      return still ? (software ? Math.min(2, Math.max(1, Math.sqrt(5e6 / (innerWidth * innerHeight)))) : usual) : coarse[level] * usual;
    };
    function sharpen(on) {
      still = on;
      if (ratio() !== renderer.getPixelRatio()) renderer.setPixelRatio(ratio());
    }
    function resize() {
      paintCharts();
      const high = Math.max(80, innerHeight - document.querySelector("footer").offsetHeight);
      byId("panel").style.maxHeight = `${high - 16}px`;
      stage.style.height = `${high}px`;
      renderer.setPixelRatio(ratio());
      renderer.setSize(innerWidth, high, false);
      camera.aspect = innerWidth / high;
      state.dirty = true;
    }
    addEventListener("resize", resize);
    byId("theme").addEventListener("click", resize);
    resize();
    setCamera("fit");
    if (travel > 6 * head.scale && motions.length) {
      orbit.distance = 3 * head.scale * Math.max(1, 1 / camera.aspect);
      setCamera("follow");
    }
    let last = performance.now(), changed = last;
    function frame(now) {
      if (state.playing) {
        const took = now - last;
        drawn.slow = took > 40 ? drawn.slow + 1 : Math.max(0, drawn.slow - 1);
        if (drawn.slow > 15 && level + 1 < coarse.length) { level += 1; drawn.slow = 0; }
        seek(state.t + pace(state.t) * Math.min(0.1, took / 1e3));
        if (state.t >= head.end) play(false);
      }
      last = now;
      if (state.dirty) {
        state.dirty = false;
        changed = now;
        sharpen(false);
        draw(now);
      } else if (!still && now - changed > 200) {
        sharpen(true);
        draw(now);
      }
      requestAnimationFrame(frame);
    }
    requestAnimationFrame(frame);
    window.contensou = { scene, camera, renderer, groups, contacts, events, state, head, drawn, seek, play, setCamera, draw, crowds, settled: () => still && !state.dirty };
  }

  page.show(main);
})();
