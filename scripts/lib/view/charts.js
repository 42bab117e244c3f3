// Charts of the quantities of a run, one below the other, with a cursor that runs along.
(() => {
  "use strict";

  const { byId, clamp, PALETTE, locate, share } = page;
  const HEIGHT = 74, LEFT = 10;
  const brief = (x) => { const a = Math.abs(x); return a && (a < 1e-2 || a >= 1e5) ? x.toExponential(1) : String(+x.toPrecision(3)); };

  // `changed` is called when strips come or go, `seek` with the time of a click.
  class Charts {
    constructor(head, array, events, changed, seek) {
      this.start = head.start;
      this.span = head.end - head.start;
      this.events = events;
      const second = Math.max(0, ["Inclination of the axis", "Speed"].map((title) => head.charts.findIndex((chart) => chart.title === title)).find((at) => at >= 0) ?? 0);
      this.strips = head.charts.map((chart, i) => {
        const label = document.createElement("label"), box = document.createElement("input");
        box.type = "checkbox";
        box.checked = i === 0 || i === second;
        box.addEventListener("change", changed);
        label.append(box, `${chart.title} [${chart.unit}]`);
        byId("strips").append(label);
        const lines = chart.lines.map((line) => ({ name: line.name, at: array(line.at), values: array(line.values) }));
        let low = Infinity, high = -Infinity;
        for (const line of lines) for (const value of line.values) { low = Math.min(low, value); high = Math.max(high, value); }
        return { ...chart, lines, box, low, high };
      });
      this.visible = [];
      this.wide = 0;
      const scrub = (event) => {
        if (event.buttons & 1) seek(this.start + this.span * clamp((event.offsetX - LEFT) / (this.wide - 2 * LEFT), 0, 1));
      };
      byId("charts").addEventListener("pointerdown", scrub);
      byId("charts").addEventListener("pointermove", scrub);
    }

    x(t) {
      return LEFT + (this.wide - 2 * LEFT) * t / (this.span || 1);
    }

    paint() {
      const canvas = byId("charts"), ratio = devicePixelRatio;
      this.visible = this.strips.filter((strip) => strip.box.checked);
      this.wide = canvas.clientWidth;
      canvas.style.height = byId("cursor").style.height = `${this.visible.length * HEIGHT}px`;
      canvas.width = this.wide * ratio;
      canvas.height = this.visible.length * HEIGHT * ratio;
      byId("cursor").replaceChildren(...this.visible.map(() => document.createElement("span")));
      const pen = canvas.getContext("2d"), style = getComputedStyle(document.documentElement);
      pen.scale(ratio, ratio);
      pen.font = "11px system-ui, sans-serif";
      this.visible.forEach((strip, k) => {
        const top = k * HEIGHT, y = (v) => top + HEIGHT - 8 - (HEIGHT - 26) * (v - strip.low) / (strip.high - strip.low);
        pen.fillStyle = style.getPropertyValue("--card");
        pen.fillRect(0, top, this.wide, HEIGHT - 3);
        pen.fillStyle = style.getPropertyValue("--faint");
        pen.fillText(`${strip.title} [${strip.unit}]  ${brief(strip.low)} to ${brief(strip.high)}`, LEFT, top + 12);
        let along = this.wide - LEFT;
        strip.lines.forEach((line, n) => {
          pen.strokeStyle = pen.fillStyle = PALETTE[n % PALETTE.length];
          along -= pen.measureText(line.name).width + 12;
          pen.fillText(line.name, along, top + 12);
          pen.beginPath();
          for (let i = 0; i < line.at.length; i++) pen.lineTo(this.x(line.at[i]), y(line.values[i]));
          pen.stroke();
        });
      });
      this.paintTicks(ratio);
    }

    // Touches and lifts, on the slider of time.
    paintTicks(ratio) {
      const ticks = byId("ticks"), { time, touch } = this.events;
      ticks.width = ticks.clientWidth * ratio;
      ticks.height = ticks.clientHeight * ratio;
      const pen = ticks.getContext("2d");
      time.forEach((t, i) => {
        pen.fillStyle = touch[i] ? "#d43a3a" : "#2f7fd1";
        pen.fillRect((t - this.start) / (this.span || 1) * (ticks.width - 2), touch[i] ? 0 : ticks.height * 0.75, Math.max(1, ratio), ticks.height * 0.25);
      });
    }

    // The cursor at a time, with the values there if they can be read.
    point(time, readable) {
      if (!this.visible.length) return;
      const t = time - this.start, x = this.x(t), cursor = byId("cursor");
      cursor.style.transform = `translateX(${x.toFixed(1)}px)`;
      if (!readable) return;
      cursor.classList.toggle("left", x > 0.7 * this.wide);
      this.visible.forEach((strip, k) => {
        cursor.children[k].textContent = strip.lines.map((line) => {
          const i = locate(line.at, t, 0), value = line.values[i];
          return brief(value + share(line.at, i, t) * ((line.values[i + 1] ?? value) - value));
        }).join("  ");
      });
    }
  }

  Object.assign(page, { Charts });
})();
