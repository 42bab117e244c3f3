// Springs as coils between their points, or around it where both are at one place, and their forces.
(() => {
  "use strict";

  const TURNS = 8, EACH = 10;

  class Coils extends THREE.LineSegments {
    // `size` is the width of a coil [m].
    constructor(springs, size, colour) {
      super(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: colour }));
      this.springs = springs;
      this.size = size;
      this.name = "springs";
      this.frustumCulled = false;
      this.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(6 * (TURNS * EACH + 2) * springs.length), 3).setUsage(THREE.DynamicDrawUsage));
      this.along = new THREE.Vector3();
      this.across = new THREE.Vector3();
      this.third = new THREE.Vector3();
      this.p = new THREE.Vector3();
      this.before = new THREE.Vector3();
    }

    // Bring the coils to where the springs are.
    update() {
      const places = this.geometry.getAttribute("position"), { along, across, third, p, before } = this;
      let n = 0;
      const to = (point) => {
        places.setXYZ(n++, before.x, before.y, before.z);
        places.setXYZ(n++, point.x, point.y, point.z);
        before.copy(point);
      };
      for (const { ends: [first, second] } of this.springs) {
        along.subVectors(second, first);
        // Points that are closer than a coil is wide have one about their middle, the more along z
        // the closer they are, so that it does not turn with what is left between them.
        along.z += Math.max(this.size - along.length(), 0);
        if (along.length() < 1e-3 * this.size) along.set(1e-3 * this.size, 0, 0);
        const drawn = along.length();
        along.divideScalar(drawn);
        across.set(0, 0, 1).cross(along);
        if (across.lengthSq() < 1e-6) across.set(1, 0, 0);
        third.crossVectors(along, across.normalize());
        before.copy(first);
        for (let k = 0; k <= TURNS * EACH; k++) {
          const s = k / (TURNS * EACH), turn = 2 * Math.PI * TURNS * s, wide = 0.5 * this.size * Math.sin(Math.PI * s) ** 0.25;
          p.addVectors(first, second).multiplyScalar(0.5).addScaledVector(along, drawn * (0.8 * s - 0.4));
          p.addScaledVector(across, wide * Math.cos(turn)).addScaledVector(third, wide * Math.sin(turn));
          to(p);
        }
        to(second);
      }
      places.needsUpdate = true;
    }
  }

  Object.assign(page, { Coils });
})();
