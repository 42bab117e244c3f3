// A spot magnified: its pressure, where it sticks, and the friction at its places.
//
// Lengths are in parts of the semi-axes, tractions in parts of f p0 on the body of surface B.
// - Dry friction: f p against the local slip; all of it sticks where that is nothing.
// - tangential = 'elastic' or 'spring': what has not slipped of late is an ellipse of the share that
//   the run tells; tractions are Cattaneo's and Mindlin's, in the direction of force and torque
//   (exact for a first shift without twist).
// - tangential = 'rolling': bristles of one flexibility on lines along which the material passes
//   (simplified theory, J. Kalker, Vehicle System Dynamics 11 (1982) 1), the flexibility such that
//   they make the force and torque of the run.
(() => {
  "use strict";

  const { byId, clamp } = page;
  const STEPS = 16, HALVINGS = 22, BLOCK = 4, FINE = 24;
  // Places of arrows in the unit circle.
  const inside = [];
  for (let i = -4; i <= 4; i++) for (let j = -4; j <= 4; j++) if (Math.hypot(i, j) <= 4.2) inside.push([i / 4.6, j / 4.6]);

  // Places and weights of means over the unit circle: Gauss's in r^2, evenly around.
  const mean = [[0.0469101, 0.1184634], [0.2307653, 0.2393143], [0.5, 0.2844444], [0.7692347, 0.2393143], [0.9530899, 0.1184634]].flatMap(([u, w]) =>
    Array.from({ length: 12 }, (_, i) => [Math.sqrt(u) * Math.cos(Math.PI * (i + 0.25) / 6), Math.sqrt(u) * Math.sin(Math.PI * (i + 0.25) / 6), w / 12]));

  const heat = (x) => new THREE.Color().setHSL(0.66 - 0.66 * x, 0.85, 0.35 + 0.2 * x);
  const bound = (x, y) => Math.sqrt(Math.max(0, 1 - x * x - y * y));

  // Bristles: traction at (x, y) of those that came in where the line begins.
  function bristle(spot, flexibility, x, y) {
    const { kx, ky, slip } = spot;
    const along = x * kx + y * ky, way = along + Math.sqrt(Math.max(0, along * along + 1 - x * x - y * y)), h = way / STEPS;
    let tx = 0, ty = 0, sticks = true;
    for (let i = 0; i < STEPS; i++) {
      const back = way - (i + 0.5) * h, mx = x - back * kx, my = y - back * ky;
      tx -= h / flexibility * (slip[0] - slip[2] * my * spot.low);
      ty -= h / flexibility * (slip[1] + slip[2] * mx * spot.wide);
      const most = bound(mx + 0.5 * h * kx, my + 0.5 * h * ky), size = Math.sqrt(tx * tx + ty * ty);
      sticks = size <= most;
      if (!sticks) { tx *= most / size; ty *= most / size; }
    }
    return { x: tx, y: ty, sticks };
  }

  // Force and torque of tractions in parts of f N and f N sqrt(a b), as one size.
  function strength(spot, flexibility) {
    let fx = 0, fy = 0, torque = 0;
    for (const [x, y, w] of mean) {
      const t = bristle(spot, flexibility, x, y);
      fx += w * t.x;
      fy += w * t.y;
      torque += w * (x * spot.wide * t.y - y * spot.low * t.x);
    }
    return 1.5 * Math.sqrt(fx * fx + fy * fy + torque * torque);
  }

  function rolling(f, memory) {
    const a = f[7], b = f[8], root = Math.sqrt(a * b), speed = Math.hypot(f[12] / a, f[13] / b);
    const spot = { kx: f[12] / a / speed, ky: f[13] / b / speed, slip: f.slice(9, 12), wide: a / root, low: b / root };
    const wanted = Math.hypot(f[1], f[2], f[3] / root) / (memory.coefficient * f[0]);
    let low = -10, high = 12;
    for (let i = 0; i < HALVINGS; i++) {
      const middle = 0.5 * (low + high);
      if (strength(spot, Math.exp(middle)) > wanted) low = middle; else high = middle;
    }
    const flexibility = Math.exp(high);
    return (x, y) => bristle(spot, flexibility, x, y);
  }

  function elastic(f, memory) {
    const a = f[7], b = f[8], radius = Math.sqrt(clamp(f[9], 0, 1)), limit = memory.coefficient * f[0];
    const fx = f[1] / limit, fy = f[2] / limit, torque = f[3] / (limit * a * b);
    // What would stick after a first shift to this force.
    const core = Math.cbrt(Math.max(0, 1 - Math.hypot(fx, fy, f[3] / (0.6 * limit * Math.sqrt(a * b)))));
    return (x, y) => {
      const dx = fx - torque * y * b, dy = fy + torque * x * a, size = Math.sqrt(dx * dx + dy * dy), r2 = x * x + y * y;
      const share = bound(x, y) - (r2 < core * core ? core * Math.sqrt(1 - r2 / (core * core)) : 0);
      return { x: size > 0 ? dx / size * share : 0, y: size > 0 ? dy / size * share : 0, sticks: r2 < radius * radius };
    };
  }

  function dry(f, slowest) {
    const slip = (x, y) => [f[4] - f[6] * y * f[8], f[5] + f[6] * x * f[7]];
    const sticks = Math.max(...inside.map(([x, y]) => Math.hypot(...slip(x, y)))) < slowest;
    const nothing = { x: 0, y: 0, sticks };
    return (x, y) => {
      const [vx, vy] = slip(x, y), speed = Math.hypot(vx, vy), most = bound(x, y);
      return speed < slowest ? nothing : { x: -most * vx / speed, y: -most * vy / speed, sticks };
    };
  }

  // The last one that was made, which serves the picture and the arrows.
  const made = { contact: null, values: null, traction: null };

  // The traction in a spot as a function of the place; slower than `slowest` nothing slips [m/s].
  function tractionOf(contact, slowest) {
    if (made.contact !== contact || made.values.some((value, i) => value !== contact.values[i])) {
      made.contact = contact;
      made.values = contact.values.slice();
      made.traction = newTraction(contact, slowest);
    }
    return made.traction;
  }

  function newTraction(contact, slowest) {
    const f = contact.values, memory = contact.memory;
    if (memory?.kind === "rolling" && Math.hypot(f[12], f[13]) > 0.5 && Math.hypot(f[9], f[10], f[11]) > 0.5) return rolling(f, memory);
    if (memory?.kind === "elastic" && f[9] > 1e-3) return elastic(f, memory);
    return dry(f, slowest);
  }

  // The largest of the tractions, in parts of which arrows are drawn.
  const largest = (traction) => Math.max(...inside.map(([x, y]) => { const t = traction(x, y); return Math.hypot(t.x, t.y); })) || 1;

  const rubs = (contact) => Math.hypot(contact.values[1], contact.values[2]) + Math.abs(contact.values[3]) > 0;

  // The share of a spot that sticks.
  function stuck(contact, traction) {
    if (contact.memory?.kind === "elastic") return clamp(contact.values[9], 0, 1);
    let share = 0;
    for (let i = 0; i < FINE; i++) for (let j = 0; j < FINE; j++) {
      const r = Math.sqrt((i + 0.5) / FINE), turn = 2 * Math.PI * (j + i / FINE) / FINE;
      if (traction(r * Math.cos(turn), r * Math.sin(turn)).sticks) share += 1 / FINE ** 2;
    }
    return share;
  }

  class SpotPicture {
    // `slowest`: see tractionOf; `drawn` tells how many times a spot is drawn.
    constructor(slowest, drawn) {
      this.slowest = slowest;
      this.drawn = drawn;
      this.by = 0;
      this.image = null;
      this.warmth = Uint32Array.from({ length: 256 }, (_, i) => {
        const c = heat(i / 255), byte = (x) => Math.round(255 * x);
        return (255 << 24 | byte(c.b) << 16 | byte(c.g) << 8 | byte(c.r)) >>> 0;
      });
    }

    // Draw the spot of a closed contact, and tell its figures.
    paint(contact) {
      const canvas = byId("spot"), pen = canvas.getContext("2d", { willReadFrequently: true }), wide = canvas.width, high = canvas.height;
      pen.clearRect(0, 0, wide, high);
      if (!contact || contact.open) return "open";
      const f = contact.values, a = f[7], b = f[8], ax = Math.min(0.42 * wide, 0.42 * high * a / Math.max(b, 1e-300)), by = ax * b / a;
      this.paintPressure(pen, ax, by);
      const traction = tractionOf(contact, this.slowest), share = rubs(contact) ? stuck(contact, traction) : 0;
      const place = (x, y) => [wide / 2 + x * ax, high / 2 - y * by];
      if (share > 0 && share < 1) this.paintStuck(pen, traction, ax, by);
      if (rubs(contact)) this.paintArrows(pen, traction, by, place);
      let words = share > 0.999 ? "sticks" : share > 0 ? `sticks in ${Math.round(100 * share)} % of the spot` : "slips";
      if (share === 0 && f[6]) {
        // The centre of rotation, where nothing slips.
        const x = -f[5] / (f[6] * a), y = f[4] / (f[6] * b);
        if (x * x + y * y < 1) {
          pen.strokeStyle = "#ffffff";
          pen.lineWidth = 2;
          pen.beginPath();
          pen.arc(...place(x, y), 5, 0, 2 * Math.PI);
          pen.stroke();
          words = "slips about a centre inside";
        }
      }
      const area = Math.PI * a * b;
      return `${contact.name}: ${words}\n${(1e6 * a).toPrecision(4)} × ${(1e6 * b).toPrecision(4)} µm, drawn ${this.drawn().toPrecision(2)} times\n` +
        `force ${f[0].toPrecision(4)} N, friction ${Math.hypot(f[1], f[2]).toPrecision(3)} N\npressure up to ${(area > 0 ? 1.5 * f[0] / area / 1e6 : 0).toPrecision(3)} MPa\n` +
        `slip ${Math.hypot(f[4], f[5]).toPrecision(3)} m/s, spin ${f[6].toPrecision(3)} rad/s`;
    }

    // One picture of the pressure serves all spots of nearly the same shape.
    paintPressure(pen, ax, by) {
      const { width: wide, height: high } = pen.canvas;
      if (Math.abs(by - this.by) > 0.2 || !this.image) {
        this.by = by;
        this.image = pen.createImageData(wide, high);
        const pixels = new Uint32Array(this.image.data.buffer);
        for (let row = 0; row < high; row++) for (let col = 0; col < wide; col++) {
          const x = (col + 0.5 - wide / 2) / ax, y = -(row + 0.5 - high / 2) / by, r = x * x + y * y;
          if (r <= 1) pixels[row * wide + col] = this.warmth[Math.round(255 * Math.sqrt(1 - r))];
        }
      }
      pen.putImageData(this.image, 0, 0);
    }

    paintStuck(pen, traction, ax, by) {
      const { width: wide, height: high } = pen.canvas;
      pen.save();
      pen.beginPath();
      pen.ellipse(wide / 2, high / 2, ax, by, 0, 0, 2 * Math.PI);
      pen.clip();
      pen.fillStyle = "rgba(255,255,255,0.4)";
      for (let top = 0; top < high; top += BLOCK) for (let left = 0; left < wide; left += BLOCK) {
        const x = (left + BLOCK / 2 - wide / 2) / ax, y = -(top + BLOCK / 2 - high / 2) / by;
        if (x * x + y * y < 1 && traction(x, y).sticks) pen.fillRect(left, top, BLOCK, BLOCK);
      }
      pen.restore();
    }

    paintArrows(pen, traction, by, place) {
      const lines = clamp(Math.floor(by / 12), 1, 4), reach = clamp(0.7 * by / (lines + 0.6), 4, 16);
      const unit = reach / largest(traction);
      pen.lineWidth = 1.2;
      pen.strokeStyle = "#ffffff";
      for (let i = -5; i <= 5; i++) for (let j = -lines; j <= lines; j++) {
        const x = i / 5.6, y = j / (lines + 0.6), here = traction(x, y), size = unit * Math.hypot(here.x, here.y);
        if (bound(x, y) <= 0.2 || size < 0.5) continue;
        const [x0, y0] = place(x, y), x1 = x0 + unit * here.x, y1 = y0 - unit * here.y, angle = Math.atan2(y1 - y0, x1 - x0), barb = Math.min(4, size);
        pen.beginPath();
        pen.moveTo(x0, y0); pen.lineTo(x1, y1);
        pen.moveTo(x1 - barb * Math.cos(angle - 0.5), y1 - barb * Math.sin(angle - 0.5)); pen.lineTo(x1, y1);
        pen.lineTo(x1 - barb * Math.cos(angle + 0.5), y1 - barb * Math.sin(angle + 0.5));
        pen.stroke();
      }
    }
  }

  // Arrows of the traction on the magnified spot among the bodies; light where it sticks.
  class TractionLines extends THREE.LineSegments {
    constructor(slowest) {
      super(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ vertexColors: true, depthTest: false }));
      for (const name of ["position", "color"]) this.geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(18 * inside.length), 3).setUsage(THREE.DynamicDrawUsage));
      this.slowest = slowest;
      this.frustumCulled = false;
      this.renderOrder = 3;
      this.p = new THREE.Vector3();
    }

    show(contact, zoom) {
      const { position, color } = this.geometry.attributes;
      let n = 0;
      if (contact && !contact.open && rubs(contact)) {
        const a = zoom * contact.values[7], b = zoom * contact.values[8], traction = tractionOf(contact, this.slowest), length = 0.22 * a / largest(traction);
        for (const [x, y] of inside) {
          const here = traction(x, y), kx = length * here.x, ky = length * here.y, x0 = x * a, y0 = y * b, x1 = x0 + kx, y1 = y0 + ky;
          if (Math.hypot(kx, ky) < 1e-3 * a) continue;
          const grey = here.sticks ? 0.95 : 0.07;
          const set = (px, py) => {
            this.p.set(px, py, 0).applyQuaternion(contact.frame).add(contact.point);
            position.setXYZ(n, this.p.x, this.p.y, this.p.z);
            color.setXYZ(n++, grey, grey, grey);
          };
          set(x0, y0); set(x1, y1);
          for (const flip of [-1, 1]) { set(x1, y1); set(x1 - 0.35 * (kx + 0.6 * flip * ky), y1 - 0.35 * (ky - 0.6 * flip * kx)); }
        }
      }
      this.geometry.setDrawRange(0, n);
      position.needsUpdate = color.needsUpdate = true;
    }
  }

  Object.assign(page, { heat, tractionOf, SpotPicture, TractionLines });
})();
