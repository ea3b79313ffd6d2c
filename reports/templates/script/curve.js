// A signal of all engines over the cursor, on a canvas: with the cursor, values under the pointer, a zoom.

class Curve {
  /**
   * @param canvas where.
   * @param pointed called with the cursor under the pointer, or null when it has left.
   * @param chosen called with the cursor that was clicked.
   */
  constructor(canvas, engineColour, pointed, chosen) {
    Object.assign(this, { canvas, engineColour, pointed, chosen, hover: null, drag: null, window: null });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerleave", () => { this.hover = null; pointed(null); });
    canvas.addEventListener("pointerdown", (event) => { this.drag = [this.cursorUnder(event), event.pointerType]; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointerup", (event) => this.release(event));
    canvas.addEventListener("pointercancel", () => { this.drag = null; });
    canvas.addEventListener("dblclick", () => this.zoom(null));
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey) return;  // the page scrolls
      event.preventDefault();
      this.zoomBy(event.deltaY > 0 ? 1.25 : 0.8, this.cursorUnder(event));
    }, { passive: false });
  }

  show(motion, engines, looks, signal, names) {
    if (motion !== this.motion) this.window = null;
    Object.assign(this, { motion, looks, signal, names, engines: engines.filter((name) => signal.name in motion.tables[name]) });
    this.colours = palette();
    this.series = Object.fromEntries(this.engines.map((name) => [name, motion.tables[name][signal.name].map((value) => value * signal.factor)]));
  }

  get range() {
    return this.window ?? [0, this.motion.span];
  }

  /** Show a part of the axis; null: all of it. */
  zoom(window) {
    const least = this.motion.span / 500;
    if (window) {
      const size = Math.max(least, window[1] - window[0]), low = Math.min(Math.max(0, window[0]), this.motion.span - size);
      window = size >= this.motion.span ? null : [low, low + size];
    }
    this.window = window;
    this.redraw?.();
    this.zoomed?.(window);
  }

  zoomBy(factor, about) {
    const [low, high] = this.range;
    this.zoom([about - (about - low) * factor, about + (high - about) * factor]);
  }

  cursorUnder(event) {
    const box = this.canvas.getBoundingClientRect(), [low, high] = this.range;
    const part = (event.clientX - box.left - this.left) / (box.width - this.left - this.right);
    return low + (high - low) * Math.min(1, Math.max(0, part));
  }

  move(event) {
    const at = this.cursorUnder(event);
    if (this.drag && this.drag[1] === "touch") { this.chosen(at); return; }
    this.hover = at;
    this.pointed(at);
    this.redraw?.();
  }

  release(event) {
    if (!this.drag) return;
    const [from, type] = this.drag, at = this.cursorUnder(event);
    this.drag = null;
    const [low, high] = this.range;
    if (type !== "touch" && Math.abs(at - from) > 0.02 * (high - low)) this.zoom([Math.min(from, at), Math.max(from, at)]);
    else this.chosen(at);
  }

  /** With the cursor at a place; null: without. */
  draw(at) {
    const { context: pen, width, height } = fitted(this.canvas);
    if (!this.motion || width === 0) return;
    const { colours, motion } = this, compact = width < 500;
    const [left, right, above, below] = [this.left = compact ? 42 : 56, this.right = 14, 10, 38];
    const [from, to] = this.range, [low, high] = this.limits(from, to);
    const x = (cursor) => left + (width - left - right) * (cursor - from) / (to - from);
    const y = (value) => height - below - (height - above - below) * (value - low) / (high - low);
    pen.save();
    pen.beginPath(); pen.rect(left, 0, width - left - right, height); pen.clip();
    const quick = motion.quickReturn;
    if (quick) {
      pen.fillStyle = colours["quick-wash"]; pen.fillRect(x(quick[0]), above, x(quick[1]) - x(quick[0]), height - above - below);
    }
    if (this.drag && this.hover !== null && this.drag[1] !== "touch") {
      pen.globalAlpha = 0.15; pen.fillStyle = colours.ink;
      pen.fillRect(x(Math.min(this.drag[0], this.hover)), above, Math.abs(x(this.hover) - x(this.drag[0])), height - above - below);
      pen.globalAlpha = 1;
    }
    pen.restore();
    this.axes(pen, { x, y, left, right, above, below, width, height, from, to, low, high, compact });
    pen.save();
    pen.beginPath(); pen.rect(left, above - 4, width - left - right, height - above - below + 8); pen.clip();
    for (const engine of this.engines) {
      const { width: broad, dash, offset } = this.looks[engine], cursor = motion.cursors[engine], values = this.series[engine];
      stroke(pen, this.engineColour(engine), Math.max(1.4, 0.85 * broad), () => {
        for (let k = 0; k < values.length; k++) {
          if (cursor[Math.min(k + 1, values.length - 1)] < from || cursor[Math.max(0, k - 1)] > to) continue;
          pen.lineTo(x(cursor[k]), y(values[k]));
        }
      }, "butt", dash, offset);
    }
    if (quick) {
      pen.font = "600 12px system-ui, sans-serif"; pen.textAlign = "left";
      const begin = Math.max(x(quick[0]), left) + 5, end = begin + pen.measureText("quick return").width;
      let [highest, lowest] = [height - below, above];  // of the curves there
      for (const engine of this.engines) this.series[engine].forEach((value, k) => {
        const across = x(motion.cursors[engine][k]);
        if (across > begin - 4 && across < end + 4) [highest, lowest] = [Math.min(highest, y(value)), Math.max(lowest, y(value))];
      });
      const under = height - below - lowest >= highest - above, place = [begin, under ? height - below - 4 : above + 4];
      pen.textBaseline = under ? "bottom" : "top";
      pen.strokeStyle = colours["quick-wash"]; pen.lineWidth = 5; pen.strokeText("quick return", ...place);
      pen.fillStyle = colours["quick-ink"]; pen.fillText("quick return", ...place);
    }
    if (at !== null) stroke(pen, colours.ink, 1.3, () => { pen.moveTo(x(at), above); pen.lineTo(x(at), height - below); }, "butt");
    if (this.hover !== null) stroke(pen, colours.soft, 1, () => { pen.moveTo(x(this.hover), above); pen.lineTo(x(this.hover), height - below); }, "butt", [3, 3]);
    const where = this.hover ?? at;
    if (where !== null) for (const engine of this.engines) {
      dot(pen, [x(where), y(this.signal.factor * motion.value(engine, this.signal.name, where))], 3.5, this.engineColour(engine), colours.ground, 1);
    }
    pen.restore();
  }

  /** Round limits of the values that are in sight. */
  limits(from, to) {
    let [low, high] = [Infinity, -Infinity];
    for (const engine of this.engines) {
      const cursor = this.motion.cursors[engine], values = this.series[engine];
      for (let k = 0; k < values.length; k++) if (cursor[k] >= from && cursor[k] <= to) { low = Math.min(low, values[k]); high = Math.max(high, values[k]); }
    }
    if (!(high > low)) { const middle = Number.isFinite(low) ? low : 0, margin = Math.abs(middle) * 0.1 || 1; [low, high] = [middle - margin, middle + margin]; }
    const margin = 0.07 * (high - low);
    return [low - margin, high + margin];
  }

  axes(pen, { x, y, left, right, above, below, width, height, from, to, low, high, compact }) {
    const { colours, motion } = this;
    pen.font = SMALL; pen.fillStyle = colours.soft;
    pen.textAlign = "right"; pen.textBaseline = "middle";
    for (const value of ticks(low, high, height < 220 ? 4 : 6)) {
      stroke(pen, Math.abs(value) < 1e-12 ? colours.soft : colours.faint, 1, () => { pen.moveTo(left, y(value)); pen.lineTo(width - right, y(value)); }, "butt");
      pen.fillText(written(value), left - 6, y(value));
    }
    pen.textBaseline = "top";
    for (const cursor of this.ticksOfCursor(from, to, compact)) {
      stroke(pen, colours.faint, 1, () => { pen.moveTo(x(cursor), above); pen.lineTo(x(cursor), height - below); }, "butt");
      pen.textAlign = x(cursor) > width - 24 ? "right" : "center";
      pen.fillText(this.cursorText(cursor), Math.min(x(cursor), width - 2), height - below + 4);
    }
    pen.textAlign = "center"; pen.textBaseline = "bottom";
    pen.fillText(motion.cyclic ? "crank angle" : "time", (left + width - right) / 2, height - 2);
    pen.textAlign = "left";
    pen.fillText(this.signal.unit, 6, height - 2);
  }

  ticksOfCursor(from, to, compact) {
    if (!this.motion.cyclic) return ticks(from, to, compact ? 4 : 8);
    const step = [90, 45, 30, 15, 10, 5, 2, 1, 0.5, 0.2, 0.1].findLast((size) => (to - from) / size <= (compact ? 4 : 8)) ?? 90;
    return Array.from({ length: Math.floor(to / step + 1e-9) - Math.ceil(from / step - 1e-9) + 1 }, (_, k) => (Math.ceil(from / step - 1e-9) + k) * step);
  }

  cursorText(cursor) {
    return this.motion.cyclic ? angleText(this.motion.begin + this.motion.turning * cursor) : `${written(cursor)} s`;
  }
}

/** Round values within limits, at most so many. */
function ticks(low, high, most) {
  const raw = (high - low) / most, decade = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((round) => round * decade).find((round) => round >= raw * (1 - 1e-12));
  return Array.from({ length: Math.floor(high / step + 1e-9) - Math.ceil(low / step - 1e-9) + 1 }, (_, k) => (Math.ceil(low / step - 1e-9) + k) * step);
}

/** A crank angle from 0 to 360 degrees: 451 is 91°. */
const angleText = (degrees) => `${written(degrees >= 0 && degrees <= 360 ? degrees : (degrees % 360 + 360) % 360)}°`;

/** A number as people write it. */
function written(value, digits = 6) {
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}
