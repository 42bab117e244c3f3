// What the pages of contensou share.
const page = (() => {
  "use strict";

  const byId = (id) => document.getElementById(id);
  const clamp = (x, low, high) => Math.min(high, Math.max(low, x));
  const PALETTE = ["#2f7fd1", "#e08a2e", "#3f9e58", "#c0504d", "#8064a2", "#2aa3a3", "#b0457f", "#7a8a2f"];

  function problem(text) {
    byId("problem").textContent = text;
    byId("problem").hidden = false;
  }

  // What was packed: a head, and numbers that it names.
  async function unpack() {
    const words = atob(byId("data").textContent.trim());
    const packed = Uint8Array.from(words, (c) => c.charCodeAt(0));
    byId("data").textContent = "";
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    const whole = await new Response(stream).arrayBuffer();
    const length = new DataView(whole).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(whole, 8, length)));
    const kinds = { f8: Float64Array, f4: Float32Array, i2: Int16Array, u1: Uint8Array, u2: Uint16Array, u4: Uint32Array };
    const array = ([kind, place, count]) => new kinds[kind](whole, 8 + length + place, count);
    return { head, array };
  }

  // Where t stands among times: the number of the last one not after it; `near` is where to begin.
  function locate(times, t, near) {
    const last = times.length - 1;
    if (near <= last && times[near] <= t && (near === last || t < times[near + 1])) return near;
    let low = 0, high = last;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= t) low = middle; else high = middle - 1;
    }
    return low;
  }

  const share = (times, i, t) => i + 1 < times.length ? clamp((t - times[i]) / (times[i + 1] - times[i]), 0, 1) : 0;

  function show(main) {
    if (typeof DecompressionStream === "undefined") problem("This browser is too old: it needs DecompressionStream, of 2023.");
    else main().catch((error) => problem(`The page cannot show its data: ${error.message}`));
  }

  return { byId, clamp, PALETTE, problem, unpack, locate, share, show };
})();
