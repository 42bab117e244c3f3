// Shows a run of contensou: what scripts/view has packed, drawn by three.js. SI units throughout.
(() => {
  "use strict";

  const { byId, clamp, PALETTE, problem, unpack, Motion, Contact, Spring, Charts } = page;
  const { grid, round, shapeGrids, planeGrid, sign, Copies, heat, SpotPicture, TractionLines, Coils } = page;
  const PULL = "#d43a3a", RUB = "#1f8f4d", SPRING = "#8a4fb0";
  // Of more bodies than this those that look alike are drawn at once.
  const CROWD = 40;

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
    const springs = (head.springs || []).map((spring) => new Spring(spring, data));
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
    const fine = curved > 400 ? 6 : curved > 40 ? 12 : curved > 12 ? 20 : curved > 4 ? 24 : 36;
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

    const coils = new Coils(springs, 0.05 * head.scale, SPRING);
    scene.add(coils);

    // Arrows of the forces and spots, one of each for a contact.
    const count = Math.max(contacts.length, 1), many = count > 400, sides = many ? 3 : count > 100 ? 4 : count > 8 ? 6 : 10, [around, across] = many ? [6, 1] : count > 100 ? [8, 2] : count > 8 ? [16, 4] : [32, 8];
    // Where there are many, an arrow is but a spike.
    const shaft = new THREE.CylinderGeometry(many ? 0 : 0.018, many ? 0.035 : 0.018, 1, sides, 1, true).translate(0, 0.5, 0).rotateX(Math.PI / 2);
    const tip = new THREE.ConeGeometry(0.05, 0.14, sides, 1, count > 100).translate(0, 0.07, 0).rotateX(Math.PI / 2);
    const arrows = (colour, name, count) => {
      const light = { color: colour, depthTest: false };
      const material = count > 8 ? new THREE.MeshBasicMaterial(light) : new THREE.MeshLambertMaterial({ ...light, emissive: colour, emissiveIntensity: 0.35 });
      const pair = new THREE.Group();
      pair.name = name;
      for (const geometry of many ? [shaft] : [shaft, tip]) {
        const mesh = new Copies(geometry, material, count);
        mesh.renderOrder = 2;
        pair.add(mesh);
      }
      scene.add(pair);
      return pair;
    };
    const pulls = arrows(PULL, "normal forces", count), rubs = arrows(RUB, "friction forces", count), stretches = arrows(SPRING, "forces of springs", Math.max(springs.length, 1));
    const spotGrid = grid((u, v) => round(v, 0)(u), around, across, [1, 1], [heat(0), heat(0)], false);
    const tints = spotGrid.getAttribute("color"), places = spotGrid.getAttribute("position");
    for (let i = 0; i < tints.count; i++) {
      const r = Math.min(1, Math.hypot(places.getX(i), places.getY(i))), c = heat(Math.sqrt(1 - r * r));
      tints.setXYZ(i, c.r, c.g, c.b);
    }
    const spots = new Copies(spotGrid, new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide, depthTest: false }), count);
    spots.name = "spots";
    spots.renderOrder = 1;
    scene.add(spots);
    // Slower than this at all places of the spot, friction sticks: a millionth of the largest slip.
    const slowest = 1e-6 * Math.max(head.forces[4], 1e-12);
    const tractionLines = new TractionLines(slowest);
    scene.add(tractionLines);

    // Lengths of arrows: in proportion to the force up to the one that is usual, and by its
    // logarithm above, so that an impact does not dwarf a weight.
    const ofSprings = springs.flatMap((spring) => Array.from(spring.at, (_, i) => Math.hypot(...spring.forces.subarray(3 * i, 3 * i + 3))).filter((x) => x > 0));
    const forces = contacts.flatMap((c) => Array.from({ length: c.at.length }, (_, i) => c.numbers[c.width * i]).filter((x) => x > 0)).sort((a, b) => a - b);
    const usual = forces[Math.floor(0.7 * forces.length)] || ofSprings.sort((a, b) => a - b)[Math.floor(0.7 * ofSprings.length)] || 1;
    // The more of them there are, the smaller they are drawn.
    const crowd = Math.min(1, 2 / Math.sqrt(count));
    const arrowLength = (force) => 0.45 * crowd * head.scale * (force <= usual ? force / usual : 1 + Math.log10(force / usual));
    const axesSorted = contacts.flatMap((c) => Array.from({ length: c.at.length }, (_, i) => c.numbers[c.width * i + 7]).filter((x) => x > 0)).sort((a, b) => a - b);
    const usualAxis = axesSorted[Math.floor(0.7 * axesSorted.length)] || head.scale;

    // ---- State ---------------------------------------------------------------------------------

    const state = { t: head.start, playing: false, speed: 1, camera: "orbit", body: Math.max(0, motions.findIndex((m) => m.at.length > 2)), contact: -1, dirty: true };
    const orbit = { target: middle.clone(), azimuth: 0.9, height: 0.35, distance: 3 * head.scale };
    const base = up.clone().cross(Math.abs(up.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0)).normalize();
    const side = up.clone().cross(base);
    const shown = {};
    const layers = [
      ["bodies", "bodies", true], ["ground", "ground", true], ["trails", "trails", motions.length <= 20],
      ["normal", "normal", true], ["friction", "friction", true], ["spots", "spots", true],
      ["traction", "traction", true], ["axes", "axes", Boolean(head.asked)], ["wires", "wire frames", false],
      ...(springs.length ? [["springs", "springs", true]] : []),
    ].map(([key, text, on], i) => {
      const label = document.createElement("label"), box = document.createElement("input");
      box.type = "checkbox";
      box.id = `layer-${key}`;
      box.checked = shown[key] = on;
      box.addEventListener("change", () => { shown[key] = box.checked; state.dirty = true; });
      label.append(box, `${text} (${i < 9 ? i + 1 : key[0]})`);
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
        // Many bodies lie flat, one may fill its box.
        orbit.distance = (asked ? 1.9 : crowds.length ? 1.1 : 1.5) * Math.max(head.scale, travel) * Math.max(1, 1 / camera.aspect);
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
    layers.forEach((box, i) => { keys[i < 9 ? i + 1 : "s"] = () => box.click(); });
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
      const group = hit.object.userData.of ? hit.object.userData.of[hit.object.which(hit)].group : hit.object.parent;
      byId("body").value = state.body = group.userData.body;
      setCamera("follow");
    });

    const charts = new Charts(head, array, events, () => resize(), seek);

    // ---- Drawing -------------------------------------------------------------------------------

    const matrix = new THREE.Matrix4(), scaling = new THREE.Vector3(), one = new THREE.Vector3(1, 1, 1), turn = new THREE.Quaternion(), z = new THREE.Vector3(0, 0, 1);
    const u = new THREE.Vector3(), v = new THREE.Vector3();
    function addArrow(pair, point, direction, length) {
      const [line, top] = pair.children, thick = 0.5 * crowd * head.scale;
      if (!(length > 0)) return;
      const i = pair.userData.count++;
      turn.setFromUnitVectors(z, direction);
      const head_ = top ? Math.min(0.14 * thick, 0.6 * length) : 0;
      line.set(i, matrix.compose(point, turn, scaling.set(thick, thick, length - head_)));
      if (!top) return;
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

    const picture = new SpotPicture(slowest, magnification);

    function drawForces() {
      pulls.userData.count = rubs.userData.count = stretches.userData.count = 0;
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
      for (const spring of springs) if (shown.springs) addArrow(stretches, spring.ends[1], v.copy(spring.force).normalize(), arrowLength(spring.force.length()));
      for (const pair of [pulls, rubs, stretches]) for (const mesh of pair.children) mesh.finish(pair.userData.count, camera.position);
      spots.finish(closed);
    }

    function drawBodies() {
      groups.forEach((group, i) => motions[i].place(state.t, group.position, group.quaternion));
      groups.forEach((group) => { group.visible = shown.bodies; });
      for (const mesh of crowds) {
        if (shown.bodies) mesh.userData.of.forEach(({ group, pose }, i) => mesh.set(i, matrix.compose(group.position, group.quaternion, one).multiply(pose)));
        mesh.finish(shown.bodies ? mesh.userData.of.length : 0, camera.position);
      }
      for (const spring of springs) spring.place(state.t, groups);
      coils.visible = springs.length > 0 && shown.springs;
      if (coils.visible) coils.update();
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

    function placeCamera() {
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
    }

    function draw(now = performance.now()) {
      placeCamera();
      drawBodies();
      drawForces();
      axesOf.forEach((lines) => { lines.visible = shown.axes; });
      ground.visible = shown.ground;
      soft.wireframe = shown.wires;
      const contact = chosen();
      tractionLines.show(shown.traction && shown.spots ? contact : null, magnification());
      // Figures that one reads need not change with every frame.
      const readable = !state.playing || now - drawn.words > 120;
      if (readable) {
        drawn.words = now;
        if (contacts.length) byId("figures").textContent = picture.paint(contact);
      }

      renderer.render(scene, camera);
      if (readable) {
        byId("time").value = span ? (state.t - head.start) / span : 0;
        byId("clock").textContent = `${state.t.toFixed(clamp(4 - Math.floor(Math.log10(Math.max(span, 1e-9))), 0, 12))} s`;
      }
      charts.point(state.t, readable);
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
      charts.paint();
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
    window.contensou = { scene, camera, renderer, groups, contacts, springs, events, state, head, drawn, seek, play, setCamera, draw, crowds, settled: () => still && !state.dirty };
  }

  page.show(main);
})();
