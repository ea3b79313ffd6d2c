// Charts of the chapters as SVG, from their description (reports/page/chapter.py): points and lines over two axes, or rows of points.

/** A number on an axis: powers of ten beyond 0.001 and a million. */
function onAxis(value) {
  const power = Math.log10(Math.abs(value));
  if (value === 0 || (power > -3.5 && power < 6)) return written(value, 4);
  const digits = value / 10 ** Math.floor(power + 1e-9), raised = String(Math.floor(power + 1e-9)).replaceAll(/./g, (sign) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)]);
  return Math.abs(digits - 1) < 1e-9 ? `10${raised}` : `${written(digits, 3)}·10${raised}`;
}

/** One axis: from values to pixels, with its ticks. */
class Axis {
  /** @param pixels of the lowest and the highest value; a twentieth of the range is left free at both ends. */
  constructor(values, logarithmic, pixels, most) {
    let [low, high] = [Math.min(...values), Math.max(...values)];
    if (logarithmic) {
      const free = Math.max(1.15, (high / low) ** 0.04);
      [low, high] = [low / free, high * free];
    } else {
      const free = 0.05 * (high - low || 1);
      [low, high] = [low - free, high + free];
    }
    Object.assign(this, { low, high, logarithmic, pixels });
    const round = ticks(low, high, most), whole = values.every(Number.isInteger) ? round.filter(Number.isInteger) : round, powers = logarithmic ? this.decades(most) : [];
    this.ticks = powers.length > 2 ? powers : whole;
  }

  place(value) {
    const { low, high, pixels: [from, to] } = this;
    const part = this.logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
    return from + part * (to - from);
  }

  decades(most) {
    const powers = (step) => Array.from({ length: 40 }, (_, k) => 10 ** ((k - 20) * step)), inside = (found) => found.filter((value) => value >= this.low && value <= this.high);
    const fine = inside(powers(1).flatMap((value) => [value, 2 * value, 5 * value]));
    if (this.high / this.low < 200 && fine.length <= most) return fine;
    return [1, 2, 3, 4].map((step) => inside(powers(step))).find((found) => found.length <= most) ?? inside(powers(5));
  }
}

/** The parts of a line between its gaps. */
function unbroken(points) {
  const parts = [[]];
  for (const point of points) if (point) parts.at(-1).push(point); else parts.push([]);
  return parts.filter((part) => part.length);
}

class Chart {
  constructor(holder, plot) {
    Object.assign(this, { holder, plot });
  }

  draw() {
    const width = this.holder.clientWidth;
    // engines that are not on the first screen cannot be switched off
    const shown = this.plot.series.filter(({ of, x }) => x.length && (!DATA.engines.includes(of) || state.engines.includes(of)));
    this.marks = [];
    const picture = shown.length ? this.plot.categories.length ? this.rows(shown, width) : this.axes(shown, width) : svg("svg");
    picture.append(this.ring = svg("circle", { r: 9, fill: "none", stroke: colour("accent"), "stroke-width": 2, visibility: "hidden" }));
    for (const [name, value] of [["tabindex", 0], ["role", "application"], ["aria-label", "Chart. Left and right go along a series, up and down to another one."]]) picture.setAttribute(name, value);
    for (const event of ["pointermove", "pointerdown"]) picture.addEventListener(event, (about) => this.point(about, picture));
    picture.addEventListener("keydown", (about) => this.key(about));
    picture.addEventListener("pointerleave", (about) => { if (about.pointerType === "mouse") this.tell(null); });
    const take = textOf("button", "SVG", "take");
    take.type = "button";
    take.title = "Save this picture";
    take.addEventListener("click", () => save(`${this.plot.file.replace(/\.csv$/, "")}.svg`, new XMLSerializer().serializeToString(picture), "image/svg+xml"));
    this.told = textOf("p", "", "reading");
    this.told.setAttribute("role", "status");
    this.holder.replaceChildren(keyOf(shown), picture, this.told, take);
    this.tell(null);
  }

  /** The nearest mark tells what it is. */
  point(event, picture) {
    const box = picture.getBoundingClientRect(), [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const near = (found) => Math.hypot(found.x - x, found.y - y);
    const nearest = this.marks.reduce((best, found) => !best || near(found) <= near(best) ? found : best, null);
    this.tell(nearest && near(nearest) < (event.pointerType === "mouse" ? 24 : 40) ? nearest : null);
  }

  /** Left and right go along a series, up and down to the nearest mark of another one. */
  key(event) {
    const along = { ArrowRight: 1, ArrowLeft: -1 }[event.key], across = { ArrowDown: 1, ArrowUp: -1 }[event.key], { found, marks } = this;
    if (!(along || across) || !marks.length) return;
    event.preventDefault();
    if (!found) { this.tell(marks[0]); return; }
    const all = [...new Set(marks.map(({ series }) => series))], next = all[(all.indexOf(found.series) + (across ?? 0) + all.length) % all.length];
    const its = marks.filter(({ series }) => series === next), far = ({ x, y }) => Math.hypot(x - found.x, y - found.y);
    this.tell(along ? its[its.indexOf(found) + along] ?? found : its.reduce((best, other) => far(other) < far(best) ? other : best));
  }

  tell(found) {
    this.found = found;
    if (found) for (const [name, value] of [["cx", found.x], ["cy", found.y]]) this.ring.setAttribute(name, value);
    this.ring.setAttribute("visibility", found ? "visible" : "hidden");
    this.told.textContent = found ? [found.series.name, found.series.text[found.index]].filter(Boolean).join(": ") : "Point at a mark or a line, or touch it, or use the arrow keys, to read what it is.";
  }

  frame(width, height) {
    return svg("svg", { class: "chart", width, height, viewBox: `0 0 ${width} ${height}` }, svg("rect", { width, height, fill: colour("ground") }));
  }

  /** Points and lines over two axes. */
  axes(shown, across) {
    const { plot } = this, width = across, height = width < 500 ? 320 : 380;
    const [above, below] = [30, 44], named = width >= 760;
    const marked = (axis) => shown.flatMap((series) => series[axis ? "y" : "x"].filter((value) => value !== null));
    const vertical = new Axis(marked(1), plot.log.includes("y"), [height - below, above], 7);
    const left = 14 + Math.max(...vertical.ticks.map((value) => wide(onAxis(value)))), right = named ? 24 + Math.max(...shown.map(({ name }) => wide(name, NAME))) : 14;
    const horizontal = new Axis(marked(0), plot.log.includes("x"), [left, width - right], Math.floor((width - left - right) / 60));
    const made = this.frame(width, height);
    this.grid(made, horizontal, width, above, height - below);
    for (const value of vertical.ticks) {
      const y = vertical.place(value);
      made.append(svg("line", { x1: left, x2: width - right, y1: y, y2: y, stroke: colour("faint") }), words(left - 6, y + 4, onAxis(value), { anchor: "end" }));
    }
    if (plot.below && plot.below > vertical.low) {
      const top = Math.max(above, vertical.place(Math.min(plot.below, vertical.high)));
      made.append(svg("rect", { x: left, y: top, width: width - left - right, height: height - below - top, fill: colour("soft"), "fill-opacity": 0.16 }));
    }
    made.append(svg("path", { d: `M${left} ${above}V${height - below}H${width - right}`, fill: "none", stroke: colour("soft") }));
    made.append(words(4, 16, plot.y, { anchor: "start", fill: colour("ink"), size: NAME }));
    made.append(words((left + width - right) / 2, height - 6, plot.x, { fill: colour("ink"), size: NAME }));
    const places = new Map(shown.map((series) => [series, series.x.map((x, k) => x === null ? null : [horizontal.place(x), vertical.place(series.y[k])])]));
    const inOrder = [...shown].sort((a, b) => b.broad - a.broad || lookOf(a.of).order - lookOf(b.of).order);
    for (const series of inOrder) {
      const points = places.get(series), group = svg("g", { "data-series": series.name, "data-of": series.of }), about = series.broad
        ? { fill: "none", stroke: colour("line"), "stroke-width": 14, "stroke-linecap": "round", "stroke-linejoin": "round" } : strokeOf(series.of);
      if (series.line || series.broad) for (const path of unbroken(points)) group.append(svg("polyline", { points: path.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" "), ...about }));
      if (!series.broad) {
        points.forEach((point, index) => {
          if (!point) return;
          const [x, y] = point;
          if (series.marked) group.append(mark(series.of, x, y, 5, series.hollow));
          this.marks.push({ x, y, series, index });
        });
      }
      made.append(group);
    }
    const taken = this.marks.map(({ x, y }) => around([x, y], 7, 7));
    if (named) this.name(made, shown.filter((series) => !series.broad), places, taken, [0, 20, width, height - below]);
    return made;
  }

  /** Names at the lines' ends, as far as they cover no mark and no other name and no other end is nearer: the legend has them all. */
  name(made, shown, places, taken, inside) {
    const endOf = (series) => places.get(series).findLast(Boolean), ends = shown.map(endOf);
    for (const series of shown) {
      const [x, y] = endOf(series), half = wide(series.name, NAME) / 2, centres = [[9, 0], [9, -13], [9, 13], [-half, -15], [-half, 18]].map(([dx, dy]) => [x + dx + half, y + dy]);
      this.write(made, series.name, centres, taken, inside, (box, centre) => {
        const far = ([endX, endY]) => Math.hypot(Math.max(box[0] - endX, 0, endX - box[2]), endY - centre[1]);
        return ends.every((end) => far(end) >= far([x, y]));
      });
    }
  }

  /** A text about the first of some centres where it covers nothing that is taken; it is left out where there is none. */
  write(made, text, centres, taken, [left, top, right, bottom], fits = () => true) {
    const half = wide(text, NAME) / 2 + 2, found = centres.find((centre) => {
      const box = around(centre, half, 8);
      return box[0] >= left && box[1] > top && box[2] < right && box[3] < bottom && fits(box, centre) && !taken.some((other) => overlap(box, other));
    });
    if (!found) return;
    taken.push(around(found, half, 8));
    made.append(words(found[0], found[1] + 4.5, text, { fill: colour("ink"), size: NAME, stroke: colour("ground"), "stroke-width": 3, "paint-order": "stroke" }));
  }

  grid(made, horizontal, width, top, bottom) {
    for (const value of horizontal.ticks) {
      const x = horizontal.place(value), half = wide(onAxis(value)) / 2 + 1, zero = value === 0 && !horizontal.logarithmic;
      made.append(svg("line", { x1: x, x2: x, y1: top, y2: bottom, stroke: colour(zero ? "soft" : "faint") }), words(Math.min(Math.max(x, half), width - half), bottom + 17, onAxis(value)));
    }
  }

  /** A row of points for each category; in it each series has a lane, so that none hides another. */
  rows(shown, width) {
    const { plot } = this, narrow = width < 700, many = Math.max(...shown.map(({ x }) => x.length)) > 6 * plot.categories.length;
    const lane = many ? 40 : 13, row = lane * shown.length + (narrow ? 32 : 12), above = plot.limit ? 24 : 8, height = above + row * plot.categories.length + 44;
    const left = narrow ? 10 : 16 + Math.max(...plot.categories.map((text) => wide(text, NAME))), right = 16;
    const numbers = shown.flatMap(({ y }) => y), logarithmic = plot.log.includes("y");
    const horizontal = new Axis(plot.limit ? [...numbers, (logarithmic ? 2 : 1) * plot.limit[0]] : numbers, logarithmic, [left, width - right], Math.floor((width - left - right) / 60));
    const made = this.frame(width, height), bottom = height - 44;
    this.grid(made, horizontal, width, above, bottom);
    if (plot.limit) {
      const x = horizontal.place(plot.limit[0]);
      made.append(svg("rect", { x, y: above, width: width - right - x, height: bottom - above, fill: colour("bad-wash") }));
      made.append(svg("line", { x1: x, x2: x, y1: above, y2: bottom, stroke: colour("bad"), "stroke-width": 2 }), words(Math.min(x, width - 4 - wide(plot.limit[1], NAME) / 2), 16, plot.limit[1], { fill: colour("bad"), size: NAME }));
    }
    const groups = new Map(shown.map((series) => [series, svg("g", { "data-series": series.name, "data-of": series.of })]));
    plot.categories.forEach((category, k) => {
      const top = above + k * row;
      made.append(svg("line", { x1: narrow ? 0 : left, x2: width - right, y1: top, y2: top, stroke: colour("line") }));
      made.append(narrow ? words(left, top + 17, category, { anchor: "start", fill: colour("ink"), size: NAME }) : words(left - 8, top + row / 2 + 4, category, { anchor: "end", fill: colour("ink"), size: NAME }));
      shown.forEach((series, each) => {
        const middle = top + row - 6 - lane * (shown.length - each - 0.5), found = series.x.map((name, index) => ({ index, x: horizontal.place(series.y[index]), name })).filter(({ name }) => name === category);
        for (const { index, x, y } of many ? besideEachOther(found, middle, lane) : found.map((point) => ({ ...point, y: middle }))) {
          groups.get(series).append(mark(series.of, x, y, many ? 3 : 5.5, series.hollow, many ? { "fill-opacity": 0.45, "stroke-width": 0.8 } : {}));
          this.marks.push({ x, y, series, index });
        }
      });
    });
    made.append(...groups.values(), svg("line", { x1: left, x2: width - right, y1: bottom, y2: bottom, stroke: colour("soft") }));
    made.append(words((left + width - right) / 2, height - 6, plot.y, { fill: colour("ink"), size: NAME }));
    return made;
  }
}

/** Points of a lane moved up and down so that they lie beside each other, as far as there is room. */
function besideEachOther(points, middle, lane) {
  const placed = [], steps = Array.from({ length: 13 }, (_, k) => (k % 2 ? 1 : -1) * Math.ceil(k / 2) * (lane / 2 - 4) / 6);
  for (const point of [...points].sort((a, b) => a.x - b.x)) {
    const near = placed.filter((other) => point.x - other.x < 6), free = (y) => near.every((other) => Math.hypot(point.x - other.x, y - other.y) >= 5);
    const step = steps.find((dy) => free(middle + dy)) ?? steps[placed.length % steps.length];
    placed.push({ ...point, y: middle + step });
  }
  return placed;
}
