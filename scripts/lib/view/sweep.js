// Shows the table of a sweep: what scripts/view has packed. A point that is clicked tells its row.
(() => {
  "use strict";

  const { byId, clamp, PALETTE, unpack } = page;
  const WARM = ["#440154", "#3b528b", "#21918c", "#5ec962", "#fde725"].map((c) => [1, 3, 5].map((i) => parseInt(c.slice(i, i + 2), 16)));
  const NONE = "#b9bec7", TROUBLE = "#d43a3a";
  const LEFT = 68, RIGHT = 14, TOP = 12, BOTTOM = 46;

  const brief = (x) => { const a = Math.abs(x); return a && (a < 1e-3 || a >= 1e5) ? x.toExponential(2).replace(/\.?0+e/, "e") : String(+x.toPrecision(4)); };
  const quoted = (word) => /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;

  function warm(s) {
    const k = Math.min(3, Math.floor(4 * s)), f = 4 * s - k;
    return `rgb(${WARM[k].map((low, i) => Math.round(low + f * (WARM[k + 1][i] - low))).join(",")})`;
  }

  // A column as a scale from 0 to 1, by its logarithm where its values are spread so.
  class Scale {
    constructor(column) {
      this.column = column;
      const good = [];
      for (const x of column.values) if (Number.isFinite(x)) good.push(x);
      let low = Infinity, high = -Infinity;
      for (const x of good) { low = Math.min(low, x); high = Math.max(high, x); }
      this.log = Boolean(column.log) || low > 0 && high > 1000 * low;
      if (!good.length) { low = 0; high = 1; }
      if (low === high) { const by = Math.abs(low) || 1; low -= 0.5 * by; high += 0.5 * by; this.log = false; }
      this.low = low;
      this.high = high;
      const levels = [...new Set(good)].sort((a, b) => a - b).map((x) => this.plain(x));
      this.levels = levels.length;
      // What a cell of a grid takes.
      this.step = levels.slice(1).reduce((least, x, i) => Math.min(least, x - levels[i]), 1);
    }
    plain(x) {
      return this.log ? Math.log(x / this.low) / Math.log(this.high / this.low) : (x - this.low) / (this.high - this.low);
    }
    ticks(most) {
      if (this.column.words) return this.column.words.map((word, i) => [i, word]).slice(0, 12);
      if (this.log && this.high / this.low > 50) {
        const found = [];
        for (let k = Math.ceil(Math.log10(this.low) - 1e-9); k <= Math.log10(this.high) + 1e-9; k++) found.push([10 ** k, brief(10 ** k)]);
        return found;
      }
      const rough = (this.high - this.low) / most, power = 10 ** Math.floor(Math.log10(rough)), unit = power * [1, 2, 5, 10].find((m) => m * power >= rough);
      const found = [];
      for (let k = Math.ceil(this.low / unit - 1e-9); k * unit <= this.high + 1e-9 * unit; k++) found.push([k * unit, brief(k * unit)]);
      return found;
    }
  }

  const label = (column) => column.name.replaceAll("_", " ") + (column.unit && column.unit !== "1" ? ` [${column.unit}]` : "");

  async function main() {
    const { head, array } = await unpack();
    const read = (column) => ({ ...column, values: array(column.values) });
    const parameters = head.parameters.map(read), results = head.results.map(read);
    const number = array(head.number), status = array(head.status), count = number.length;
    const caseNumbers = { name: "case", unit: "", meaning: "number of the case", values: number };
    const columns = [...parameters, ...results, caseNumbers];
    document.title = head.title;
    byId("title").textContent = head.title;
    byId("about").textContent = `${head.file} · contensou ${head.program} · ${head.cases} cases` + (head.total > head.cases ? ` of ${head.total}` : "") +
      (count < head.cases ? `, of which ${count} are drawn, evenly chosen` : "");
    byId("sweep").textContent = head.about;
    byId("scene").textContent = head.scene;

    const varied = parameters.filter((column) => new Set(column.values).size > 1);
    // Two parameters with numbers span a plane; words colour a result over one.
    const shown = results[head.colour] || results[0] || caseNumbers;
    const numbers = varied.filter((column) => !column.words), word = varied.find((column) => column.words);
    const first = numbers[0] || word || caseNumbers, second = numbers[1] || shown;
    const colour = second === shown && word && word !== first ? word : shown;
    const choice = {};
    for (const [id, start] of [["x", first], ["y", second], ["c", colour]]) {
      columns.forEach((column, i) => byId(id).append(new Option(column.name, i)));
      byId(id).value = columns.indexOf(start);
      byId(id).addEventListener("change", prepare);
    }
    const state = { at: -1, frames: 0 }, canvas = byId("points");
    let x, y, c, places, cells;

    function prepare() {
      for (const id of ["x", "y", "c"]) choice[id] = columns[+byId(id).value];
      [x, y, c] = [choice.x, choice.y, choice.c].map((column) => new Scale(column));
      const grid = parameters.includes(choice.x) && parameters.includes(choice.y) && choice.x !== choice.y && x.levels * y.levels <= 1.001 * count && count > 30;
      cells = grid ? [x.step, y.step] : null;
      paint();
    }

    function paint() {
      const ratio = devicePixelRatio, wide = canvas.clientWidth, high = canvas.clientHeight, pen = canvas.getContext("2d");
      canvas.width = wide * ratio;
      canvas.height = high * ratio;
      pen.scale(ratio, ratio);
      const style = getComputedStyle(document.documentElement), ink = style.getPropertyValue("--ink"), line = style.getPropertyValue("--line");
      const padX = cells ? 0.5 * cells[0] : 0.03, padY = cells ? 0.5 * cells[1] : 0.04;
      const across = (v) => LEFT + (wide - LEFT - RIGHT) * (v + padX) / (1 + 2 * padX), along = (v) => high - BOTTOM - (high - TOP - BOTTOM) * (v + padY) / (1 + 2 * padY);
      pen.font = "11px system-ui, sans-serif";
      pen.fillStyle = ink;
      pen.strokeStyle = line;
      pen.textAlign = "center";
      for (const [value, text] of x.ticks(8)) {
        const at = across(x.plain(value));
        pen.fillText(text, at, high - BOTTOM + 16);
        pen.beginPath(); pen.moveTo(at, TOP); pen.lineTo(at, high - BOTTOM + 4); pen.stroke();
      }
      pen.fillText(label(choice.x), (LEFT + wide - RIGHT) / 2, high - 10);
      pen.textAlign = "right";
      for (const [value, text] of y.ticks(7)) {
        const at = along(y.plain(value));
        pen.fillText(text.slice(0, 14), LEFT - 6, at + 4);
        pen.beginPath(); pen.moveTo(LEFT - 4, at); pen.lineTo(wide - RIGHT, at); pen.stroke();
      }
      pen.save();
      pen.translate(12, (TOP + high - BOTTOM) / 2);
      pen.rotate(-Math.PI / 2);
      pen.textAlign = "center";
      pen.fillText(label(choice.y), 0, 0);
      pen.restore();

      places = new Float32Array(2 * count);
      const radius = count > 5000 ? 2 : count > 500 ? 3 : 5;
      const w = cells ? Math.max(1, (wide - LEFT - RIGHT) * cells[0] / (1 + 2 * padX) + 0.5) : 0, h = cells ? Math.max(1, (high - TOP - BOTTOM) * cells[1] / (1 + 2 * padY) + 0.5) : 0;
      paintLines(pen, across, along);
      for (let i = 0; i < count; i++) {
        const px = places[2 * i] = across(x.plain(choice.x.values[i])), py = places[2 * i + 1] = along(y.plain(choice.y.values[i]));
        if (!Number.isFinite(px + py)) continue;
        const value = choice.c.values[i];
        pen.fillStyle = status[i] ? TROUBLE : !Number.isFinite(value) ? NONE : choice.c.words ? PALETTE[value % PALETTE.length] : warm(clamp(c.plain(value), 0, 1));
        if (cells) pen.fillRect(px - w / 2, py - h / 2, w, h);
        else { pen.beginPath(); pen.arc(px, py, radius, 0, 7); pen.fill(); }
      }
      const ring = (i, colour, size) => {
        if (i < 0 || !Number.isFinite(places[2 * i] + places[2 * i + 1])) return;
        for (const [stroke, thick] of [["#ffffff", 5], [colour, 2.5]]) {
          pen.strokeStyle = stroke;
          pen.lineWidth = thick;
          pen.beginPath();
          pen.arc(places[2 * i], places[2 * i + 1], size, 0, 7);
          pen.stroke();
        }
        pen.lineWidth = 1;
      };
      for (const run of head.trajectories) ring(indexOf.get(run.case) ?? -1, "#e08a2e", 4);
      ring(state.at, "#111827", 8);
      paintLegend();
      state.frames += 1;
    }

    // Lines over a parameter, one for each word, where nothing else is varied.
    function paintLines(pen, across, along) {
      if (!choice.c.words || choice.x.words || cells || varied.some((column) => column !== choice.x && column !== choice.c)) return;
      const order = [...choice.x.values.keys()].sort((i, j) => choice.x.values[i] - choice.x.values[j]);
      choice.c.words.forEach((_, word) => {
        pen.strokeStyle = PALETTE[word % PALETTE.length];
        pen.beginPath();
        let drawn = false;
        for (const i of order) {
          if (choice.c.values[i] !== word) continue;
          const px = across(x.plain(choice.x.values[i])), py = along(y.plain(choice.y.values[i]));
          if (Number.isFinite(px + py)) pen[drawn ? "lineTo" : "moveTo"](px, py);
          drawn = Number.isFinite(px + py);
        }
        pen.stroke();
      });
    }

    function paintLegend() {
      const legend = byId("legend"), parts = [`colour: ${choice.c.meaning || label(choice.c)}`];
      legend.replaceChildren();
      if (!choice.c.words) {
        const bar = document.createElement("canvas"), pen = bar.getContext("2d");
        bar.width = 120;
        bar.height = 10;
        for (let i = 0; i < 120; i++) { pen.fillStyle = warm(i / 119); pen.fillRect(i, 0, 1, 10); }
        legend.append(`${label(choice.c)}: ${brief(c.low)} `, bar, ` ${brief(c.high)}${c.log ? " (logarithmic)" : ""}`);
        parts.length = 0;
      }
      const add = (tint, words) => {
        const dot = document.createElement("span");
        dot.textContent = "■ ";
        dot.style.color = tint;
        legend.append(" · ", dot, words);
      };
      if (parts.length) legend.append(...parts);
      if (choice.c.words) choice.c.words.slice(0, 12).forEach((word, i) => add(PALETTE[i % PALETTE.length], word));
      const counts = new Map();
      for (const code of status) if (code) counts.set(code, (counts.get(code) || 0) + 1);
      for (const [code, times] of counts) add(TROUBLE, `${times} ${head.meanings[code].replaceAll("_", " ")}`);
      if ([...choice.c.values].some((value, i) => !status[i] && !Number.isFinite(value))) add(NONE, "no value");
      if (head.trajectories.length) add("#e08a2e", "whole run kept");
    }

    // ---- Asking --------------------------------------------------------------------------------

    const indexOf = new Map();
    number.forEach((n, i) => indexOf.set(n, i));
    const worded = (column, i) => column.words ? column.words[column.values[i]] : column.values[i];

    // The command that runs a case, as a shell takes it.
    function commandOf(i) {
      const words = [...head.command];
      for (const column of parameters) {
        const value = worded(column, i);
        const text = column.words && !/^\.(true|false)\.$/i.test(value) ? `'${value.replaceAll("'", "''")}'` : String(value);
        for (const path of (column.meaning || column.name).split(/\s*,\s*/)) words.push("--set", `${path}=${text}`);
      }
      return [...words, "-o", `case_${number[i]}.h5`].map(quoted).join(" ");
    }

    function choose(i) {
      state.at = i;
      if (i < 0) return;
      byId("case").textContent = `Case ${number[i]}`;
      const message = head.messages[i] || "";
      byId("said").textContent = head.meanings[status[i]].replaceAll("_", " ") + (message ? `: ${message}` : "");
      byId("command").textContent = commandOf(i);
      byId("copy").hidden = false;
      byId("columns").replaceChildren(...[...parameters, ...results].flatMap((column) => {
        const term = document.createElement("dt"), value = document.createElement("dd"), x = worded(column, i);
        term.textContent = column.name.replaceAll("_", " ");
        term.title = column.meaning;
        const shown = typeof x === "string" ? x : Number.isNaN(x) ? "none" : parameters.includes(column) ? String(x) : String(+x.toPrecision(7));
        value.textContent = shown + (column.unit && column.unit !== "1" && shown !== "none" ? ` ${column.unit}` : "");
        return [term, value];
      }));
      for (const button of byId("many").children) button.setAttribute("aria-pressed", +button.dataset.case === number[i]);
      paint();
    }

    function nearest(px, py, allowed = () => true, weigh = (dx, dy) => dx * dx + dy * dy) {
      let best = -1, least = Infinity;
      for (let i = 0; i < count; i++) {
        const dx = places[2 * i] - px, dy = places[2 * i + 1] - py;
        if (!allowed(dx, dy, i)) continue;
        const far = weigh(dx, dy);
        if (far < least) { least = far; best = i; }
      }
      return best;
    }
    // A click tells the nearest case, and again one that lies at the same place.
    canvas.addEventListener("click", (event) => {
      const found = nearest(event.offsetX, event.offsetY), at = state.at;
      const together = (i, j) => i >= 0 && j >= 0 && Math.hypot(places[2 * i] - places[2 * j], places[2 * i + 1] - places[2 * j + 1]) < 1.5;
      if (!together(found, at)) { choose(found); return; }
      for (let k = 1; k <= count; k++) if (together(found, (at + k) % count)) { choose((at + k) % count); return; }
    });
    canvas.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      if (!way) return;
      event.preventDefault();
      if (state.at < 0) { choose(0); return; }
      const [sx, sy] = way, ahead = (dx, dy) => dx * sx + dy * sy, beside = (dx, dy) => Math.abs(dx * sy) + Math.abs(dy * sx);
      const next = nearest(places[2 * state.at], places[2 * state.at + 1], (dx, dy, i) => i !== state.at && ahead(dx, dy) > 0.5, (dx, dy) => ahead(dx, dy) + 4 * beside(dx, dy));
      if (next >= 0) choose(next);
    });
    byId("copy").addEventListener("click", async () => {
      const words = byId("command").textContent;
      try {
        await navigator.clipboard.writeText(words);
      } catch {
        getSelection().selectAllChildren(byId("command"));
        document.execCommand("copy");
      }
      byId("copy").textContent = "copied";
      setTimeout(() => { byId("copy").textContent = "copy the command"; }, 1500);
    });

    // ---- Trajectories --------------------------------------------------------------------------

    const runs = head.trajectories.map((run) => ({ ...run, charts: run.charts.map((chart) => ({ ...chart, lines: chart.lines.map((line) => ({ name: line.name, at: array(line.at), values: array(line.values) })) })) }));
    const titles = [...new Set(runs.flatMap((run) => run.charts.map((chart) => chart.title)))];
    byId("runs").hidden = !runs.length;
    document.body.classList.toggle("alone", !runs.length);
    for (const title of titles) byId("quantity").append(new Option(title, title));
    if (titles.includes("Inclination of the axis")) byId("quantity").value = "Inclination of the axis";
    const small = runs.map((run) => {
      const button = document.createElement("button"), picture = document.createElement("canvas"), words = document.createElement("span");
      button.type = "button";
      button.dataset.case = run.case;
      const i = indexOf.get(run.case);
      words.textContent = `case ${run.case}` + (i === undefined ? "" : `: ${varied.slice(0, 3).map((column) => { const value = worded(column, i); return `${column.name.replaceAll("_", " ")} ${typeof value === "string" ? value : brief(value)}`; }).join(", ")}`);
      button.append(picture, words);
      button.addEventListener("click", () => choose(i ?? -1));
      byId("many").append(button);
      return { run, picture };
    });
    function paintRuns() {
      const title = byId("quantity").value, charts = runs.map((run) => run.charts.find((chart) => chart.title === title));
      let low = Infinity, high = -Infinity;
      for (const chart of charts) for (const line of chart ? chart.lines : []) for (const value of line.values) { low = Math.min(low, value); high = Math.max(high, value); }
      const longest = Math.max(...runs.map((run) => run.end));
      const style = getComputedStyle(document.documentElement);
      small.forEach(({ picture }, k) => {
        const ratio = devicePixelRatio, wide = picture.clientWidth, tall = picture.clientHeight, pen = picture.getContext("2d");
        picture.width = wide * ratio;
        picture.height = tall * ratio;
        pen.scale(ratio, ratio);
        pen.font = "10px system-ui, sans-serif";
        pen.fillStyle = style.getPropertyValue("--faint");
        const chart = charts[k];
        if (!chart) { pen.fillText("constant", 4, 12); return; }
        pen.fillText(`${brief(low)} to ${brief(high)} ${chart.unit}, ${brief(longest)} s`, 4, 10);
        chart.lines.forEach((line, n) => {
          pen.strokeStyle = PALETTE[n % PALETTE.length];
          pen.beginPath();
          for (let i = 0; i < line.at.length; i++) pen.lineTo(2 + (wide - 4) * line.at[i] / (longest || 1), tall - 3 - (tall - 18) * (line.values[i] - low) / (high - low));
          pen.stroke();
        });
      });
    }
    byId("quantity").addEventListener("change", paintRuns);

    const dark = (on) => { document.documentElement.dataset.theme = on ? "dark" : "light"; };
    byId("theme").addEventListener("click", () => { dark(document.documentElement.dataset.theme !== "dark"); paint(); paintRuns(); });
    addEventListener("keydown", (event) => { if (event.key === "d" && event.target.tagName !== "SELECT" && !event.ctrlKey && !event.metaKey) byId("theme").click(); });
    dark(matchMedia("(prefers-color-scheme: dark)").matches);
    addEventListener("resize", () => { paint(); paintRuns(); });
    prepare();
    paintRuns();
    window.contensou = { head, state, choose, number, places: () => places, drawn: state, settled: () => true };
  }

  page.show(main);
})();
