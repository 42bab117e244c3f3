// Surfaces as triangles, signs, and many copies of one shape.
(() => {
  "use strict";

  const { clamp } = page;

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
        const grids = [put(f, n, Math.max(4, n / 2), [n % 6 ? 4 : 6, high - low < 1 ? 1 : 2])];
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
        const [low, high] = surface.ends || [-length / 2, length / 2];
        const grids = [put((u, v) => round(s.radius, low + v * (high - low))(u), n, 4, [6, 2])];
        if (!inside) grids.push(disc(s.radius, high, true), disc(s.radius, low, false));
        return grids;
      }
      case "cone": {
        const [low, high] = surface.ends || [0, surface.length || scale], slope = Math.tan(s.half_angle);
        const f = (u, v) => { const z = low + v * (high - low); return round(z * slope, z)(u); };
        const grids = [put(f, n, 4, [6, 1])];
        if (!inside) grids.push(disc(high * slope, high, true));
        if (!inside && low > 0) grids.push(disc(low * slope, low, false));
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
  // takes as long for each thing as for hundreds of triangles. Those that turn their back are left
  // out here, as they, too, take their time there.
  class Copies extends THREE.Mesh {
    constructor(shape, material, most) {
      const geometry = new THREE.BufferGeometry(), each = shape.getAttribute("position").count, index = shape.index.array;
      super(geometry, material);
      this.shape = shape;
      this.each = each;
      this.matrices = new Float32Array(16 * most);
      this.frustumCulled = false;
      const repeated = (array, add) => {
        const all = new array.constructor(array.length * most);
        for (let i = 0; i < most; i++) for (let k = 0; k < array.length; k++) all[i * array.length + k] = array[k] + i * add;
        return all;
      };
      geometry.setIndex(new THREE.BufferAttribute(repeated(Uint32Array.from(index), each), 1));
      for (const name of material.isMeshLambertMaterial ? ["position", "normal"] : ["position"]) {
        geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * each * most), 3).setUsage(THREE.DynamicDrawUsage));
      }
      if (shape.getAttribute("color")) geometry.setAttribute("color", new THREE.BufferAttribute(repeated(shape.getAttribute("color").array, 0), 3));
      if (material.side === THREE.FrontSide) this.planes = facets(shape);
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

    // So many of them there are now, seen from `eye`.
    finish(count, eye) {
      const { index } = this.geometry;
      this.visible = count > 0;
      this.count = count;
      const used = this.planes ? this.facing(count, eye) : count * this.shape.index.count;
      this.geometry.setDrawRange(0, used);
      this.geometry.boundingSphere = null;
      const changed = (attribute, size) => {
        if (!attribute) return;
        attribute.clearUpdateRanges();
        attribute.addUpdateRange(0, size);
        attribute.needsUpdate = true;
      };
      for (const name of ["position", "normal"]) changed(this.geometry.getAttribute(name), 3 * this.each * count);
      if (this.planes) changed(index, used);
    }

    // Choose the triangles that turn their front to the eye; the length of their list.
    facing(count, eye) {
      const into = this.geometry.index.array, from = this.shape.index.array, { planes, each } = this, at = new THREE.Vector3(), back = new THREE.Matrix4();
      let used = 0;
      for (let i = 0; i < count; i++) {
        const { x, y, z } = at.copy(eye).applyMatrix4(back.fromArray(this.matrices, 16 * i).invert()), first = i * each;
        for (let k = 0, n = 0; k < from.length; k += 3, n += 4) {
          if (planes[n] * x + planes[n + 1] * y + planes[n + 2] * z <= planes[n + 3]) continue;
          into[used] = from[k] + first;
          into[used + 1] = from[k + 1] + first;
          into[used + 2] = from[k + 2] + first;
          used += 3;
        }
      }
      return used;
    }

    // Which copy a triangle belongs to that a ray has met.
    which(hit) {
      return Math.floor(hit.face.a / this.each);
    }
  }

  // The planes of the triangles of a shape: normals and distances.
  function facets(shape) {
    const places = shape.getAttribute("position"), index = shape.index.array, planes = new Float32Array(4 * index.length / 3);
    const [a, b, c] = [0, 1, 2].map(() => new THREE.Vector3());
    for (let k = 0, n = 0; k < index.length; k += 3, n += 4) {
      a.fromBufferAttribute(places, index[k]);
      b.fromBufferAttribute(places, index[k + 1]).sub(a);
      c.fromBufferAttribute(places, index[k + 2]).sub(a);
      b.cross(c).normalize();
      planes.set([b.x, b.y, b.z, b.dot(a)], n);
    }
    return planes;
  }

  Object.assign(page, { grid, round, shapeGrids, planeGrid, sign, Copies });
})();
