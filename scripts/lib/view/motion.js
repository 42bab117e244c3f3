// The motion of bodies and what acts in contacts, between the keys that were packed.
(() => {
  "use strict";

  const { locate, share } = page;

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
  // semi-axes; where friction has a memory the share that sticks, or the directions of slip (with
  // the spin times sqrt(a b)) and of what passes.
  class Contact {
    constructor(head, data, scales) {
      this.name = head.name;
      this.on = head.on;
      this.at = data.times(head.at);
      this.closed = data.array(head.closed);
      this.positions = data.array(head.point);
      this.frames = data.array(head.frame);
      const bits = data.array(head.values);
      this.memory = head.memory;
      this.width = 9 + (head.memory ? head.memory.width : 0);
      this.numbers = Float32Array.from(bits, (b, i) => half(b) * (scales[i % this.width] ?? 1));
      this.i = 0;
      this.open = true;
      this.point = new THREE.Vector3();
      this.frame = new THREE.Quaternion();
      this.next = new THREE.Quaternion();
      this.values = new Float32Array(this.width);
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
      const w = this.width;
      for (let k = 0; k < w; k++) this.values[k] = v[w * i + k] + s * (v[w * n + k] - v[w * i + k]);
    }
  }

  // A spring between points of two bodies, or of one and the ground (-1), and its force on B.
  class Spring {
    constructor(head, data) {
      Object.assign(this, { name: head.name, kind: head.kind, bodies: head.bodies });
      this.points = head.points.map((point) => new THREE.Vector3(...point));
      this.at = data.times(head.at);
      this.forces = data.array(head.force);
      this.i = 0;
      this.ends = [new THREE.Vector3(), new THREE.Vector3()];
      this.force = new THREE.Vector3();
    }

    // `groups` are the bodies in their places.
    place(t, groups) {
      this.ends.forEach((end, k) => {
        const group = groups[this.bodies[k]];
        end.copy(this.points[k]);
        if (group) end.applyQuaternion(group.quaternion).add(group.position);
      });
      const i = this.i = locate(this.at, t, this.i), s = share(this.at, i, t), f = this.forces;
      const k = 3 * i, n = i + 1 < this.at.length ? k + 3 : k;
      this.force.set(f[k] + s * (f[n] - f[k]), f[k + 1] + s * (f[n + 1] - f[k + 1]), f[k + 2] + s * (f[n + 2] - f[k + 2]));
    }
  }

  Object.assign(page, { Motion, Contact, Spring });
})();
