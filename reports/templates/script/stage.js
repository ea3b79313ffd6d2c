// The mechanism on a canvas.

const TEXT = "14px system-ui, sans-serif", BOLD = "600 14px system-ui, sans-serif", SMALL = "12px system-ui, sans-serif";

const BAND = 0.1;  // of the follower's length: how far the largest stress reaches from the arm
const COILS = 8;  // of a drawn spring
const FORCE = [44, 26];  // length of the arrow of the tool's force, px, on a wide and on a narrow page
const ARROW = -2.35;  // where on the crank's circle the way of turning stands, rad

/** Whether the page is laid out for printing. */
const onPaper = () => "print" in document.documentElement.dataset;

/** A canvas made sharp for screen or paper; its context in CSS pixels, with width and height. */
function fitted(canvas) {
  const ratio = onPaper() ? 3 : Math.max(1, window.devicePixelRatio || 1);
  const { clientWidth: width, clientHeight: height } = canvas;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.lineJoin = context.lineCap = "round";
  return { context, width, height };
}

/** The page's colour of a name, e.g. "ink". */
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const palette = () => Object.fromEntries(["ink", "soft", "faint", "line", "ground", "quick", "quick-ink", "quick-wash", "stress"].map((name) => [name, colour(name)]));

class Stage {
  constructor(canvas, engineColour) {
    this.canvas = canvas;
    this.engineColour = engineColour;  // of a name
    this.kept = {};  // label -> the candidate that it had, so that labels do not jump
  }

  /** What stays while the mechanism moves; `engines` in the order in which they are drawn. */
  show(motion, engines, factor, looks, stress = null) {
    Object.assign(this, { motion, engines: engines.filter((name) => motion.hasShape(name)), factor, looks, stress });
    this.bounds = motion.bounds(this.engines, factor);
    this.kept = {};
    this.colours = palette();
  }

  transform(width, height) {
    const [left, right, low, high] = this.bounds;
    const sides = width < 500 ? 30 : 54, above = width < 500 ? 26 : 34;
    const scale = Math.min((width - 2 * sides) / (right - left), (height - 2 * above) / (high - low));
    const x0 = (width - scale * (right + left)) / 2, y0 = (height + scale * (high + low)) / 2;
    return { scale, place: ([x, y]) => [x0 + scale * x, y0 - scale * y] };
  }

  draw(at) {
    const { context: pen, width, height } = fitted(this.canvas);
    if (!this.motion || width === 0) return;
    const { scale, place } = this.transform(width, height);
    const { motion, colours } = this;
    const { crank, pivot, quick, follower, tip, spring } = motion.scene;
    const O = place([0, 0]), P = place([pivot, 0]), radius = scale * crank;
    const angle = motion.crankAngle(at), C = place(motion.slider(angle));
    const compact = width < 500;

    stroke(pen, colours.line, 1, () => pen.arc(...O, radius, 0, 2 * Math.PI));
    if (quick !== null) stroke(pen, colours.quick, 8, () => pen.arc(...O, radius, -quick, quick), "butt");
    this.arrow(pen, O, radius, motion.turning);

    const lines = this.engines.map((name) => motion.line(name, at, this.factor).map(place));
    const chord = Math.atan2(C[1] - P[1], C[0] - P[0]);
    const end = [P[0] + scale * follower * Math.cos(chord), P[1] + scale * follower * Math.sin(chord)];
    stroke(pen, colours.soft, 1, () => { pen.moveTo(...P); pen.lineTo(...end); }, "butt", [5, 4]);
    this.trail(pen, at, place);
    const banded = this.stress ? this.engines.indexOf(this.stress.engine) : -1;
    const edges = banded >= 0 ? this.band(pen, lines[banded], scale, height, compact) : [];
    this.engines.forEach((name, k) => {
      const { width: broad, dash, offset } = this.looks[name];
      stroke(pen, this.engineColour(name), broad, () => smooth(pen, lines[k]), "butt", dash, offset);
      if (tip) this.tipBody(pen, lines[k], this.engineColour(name), broad);
    });

    const force = lines.length ? this.force(pen, lines[lines.length - 1], angle, FORCE[compact ? 1 : 0]) : [];

    const springs = [];
    if (spring && lines.length) {
      const line = lines[lines.length - 1], k = spring.part * (line.length - 1), from = Math.min(Math.floor(k), line.length - 2);
      const held = between(line[from], line[from + 1], k - from), anchor = place(spring.anchor);
      springs.push([anchor, held]);
      support(pen, anchor, colours);
      stroke(pen, colours.soft, 1.5, () => coil(anchor, held, compact ? 3 : 4).forEach((point) => pen.lineTo(...point)));
    }
    support(pen, O, colours);
    support(pen, P, colours);
    stroke(pen, colours.ink, compact ? 5 : 7, () => { pen.moveTo(...O); pen.lineTo(...C); });
    this.sliderBox(pen, C, chord, colours, compact ? 0.8 : 1, motion.scene.rollers);
    for (const joint of [O, P, C]) dot(pen, joint, compact ? 3.5 : 4.5, colours.ground, colours.ink, 2);
    this.bar(pen, width, height, scale, colours);
    this.labels(pen, { O, P, C, radius, quick, lines, edges, springs, force, width, height, compact });
  }

  /** The way of turning, on the crank's circle. */
  arrow(pen, [x, y], radius, turning) {
    const angle = ARROW, [tx, ty] = [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
    pen.save();
    pen.translate(tx, ty);
    pen.rotate(angle + (turning > 0 ? -Math.PI / 2 : Math.PI / 2));
    pen.fillStyle = this.colours.soft;
    pen.beginPath(); pen.moveTo(7, 0); pen.lineTo(-5, 5); pen.lineTo(-5, -5); pen.fill();
    pen.restore();
  }

  /** An arrow to the tip where the tool's force acts at a crank angle; its two ends, or none. */
  force(pen, line, crankAngle, length) {
    const { follows, ways } = this.motion.scene.force ?? { ways: [null] }, turn = crankAngle / (2 * Math.PI);
    const way = ways[Math.round((turn - Math.floor(turn)) * ways.length) % ways.length];
    if (way === null) return [];
    const [before, tip] = line.slice(-2), angle = (follows ? Math.atan2(tip[1] - before[1], tip[0] - before[0]) : 0) - way;
    const tail = [tip[0] - length * Math.cos(angle), tip[1] - length * Math.sin(angle)];
    stroke(pen, this.colours.ink, 1.5, () => { pen.moveTo(...tail); pen.lineTo(...between(tail, tip, 0.8)); }, "butt");
    pen.save();
    pen.translate(...tip);
    pen.rotate(angle);
    pen.fillStyle = this.colours.ink;
    pen.beginPath(); pen.moveTo(0, 0); pen.lineTo(-10, 4); pen.lineTo(-10, -4); pen.fill();
    pen.restore();
    return [tail, tip];
  }

  /** Where the leading engine's tip came from. */
  trail(pen, at, place) {
    const engine = this.engines.includes(this.motion.lead) ? this.motion.lead : this.engines[0];
    if (!engine) return;
    const length = 0.3 * this.motion.span * (this.motion.span > 360.5 || this.motion.span < 359.5 ? Math.min(1, 0.4 / this.motion.duration) : 1);
    const closed = this.motion.span > 359.5 && this.motion.span < 360.5;
    let before = null;
    for (let k = 0; k <= 40; k++) {
      let then = at - length * (1 - k / 40);
      if (then < 0) { if (!closed) continue; then += this.motion.span; }
      const line = this.motion.line(engine, then, this.factor), here = place(line[line.length - 1]);
      if (before) {
        pen.globalAlpha = 0.75 * k / 40;
        stroke(pen, this.colours.soft, 1.2, () => { pen.moveTo(...before); pen.lineTo(...here); });
      }
      before = here;
    }
    pen.globalAlpha = 1;
  }

  /** Least and greatest stress of the turn across the arm, as a light band along it, and how much its width means; gives its edges. */
  band(pen, line, scale, height, compact) {
    const { low, high, largest, at, engine } = this.stress, unit = BAND * scale * this.motion.scene.follower / largest;
    const places = alongLine(line, low.length), edge = (values) => places.map(([x, y, nx, ny], k) => [x + unit * values[k] * nx, y + unit * values[k] * ny]);
    const upper = edge(high), lower = edge(low), tone = this.colours.stress;
    pen.globalAlpha = 0.2;
    pen.fillStyle = tone;
    pen.beginPath(); [...upper, ...lower.toReversed()].forEach((point, k) => k ? pen.lineTo(...point) : pen.moveTo(...point)); pen.fill();
    pen.globalAlpha = 1;
    for (const side of [upper, lower]) stroke(pen, tone, 1, () => side.forEach((point, k) => k ? pen.lineTo(...point) : pen.moveTo(...point)));
    if (at !== null) {
      const k = Math.round(at * (places.length - 1));
      stroke(pen, tone, 2, () => { pen.moveTo(...upper[k]); pen.lineTo(...lower[k]); }, "butt");
    }
    const round = roundBelow(largest), length = unit * round, x = 18, y = height - 16;
    stroke(pen, tone, 2, () => { pen.moveTo(x, y); pen.lineTo(x + length, y); }, "butt");
    pen.font = SMALL; pen.textAlign = "left"; pen.textBaseline = "bottom"; pen.fillStyle = this.colours.soft;
    pen.fillText(`${written(round)} ${this.stress.unit}${compact ? "" : `, stress over the turn by ${engine}`}`, x, y - 3);
    return [upper, lower];
  }

  tipBody(pen, line, fill, broad) {
    const [a, b] = line.slice(-2), angle = Math.atan2(b[1] - a[1], b[0] - a[0]);
    pen.save();
    pen.translate(...b);
    pen.rotate(angle);
    const size = 10 + broad;
    stroke(pen, fill, broad / 2 + 2, () => { pen.moveTo(0, -size); pen.lineTo(0, size); }, "butt");
    pen.restore();
  }

  /** The slider; with a joint that gives way its two rollers, apart from the arm where they have clearance, a softer one dashed. */
  sliderBox(pen, C, angle, colours, size, rollers) {
    pen.save();
    pen.translate(...C);
    pen.rotate(angle);
    pen.globalAlpha = 0.9;
    pen.fillStyle = colours.ground;
    pen.beginPath(); pen.roundRect(-15 * size, -10 * size, 30 * size, 20 * size, 3); pen.fill();
    pen.globalAlpha = 1;
    pen.strokeStyle = colours.ink; pen.lineWidth = 2; pen.stroke();
    const away = size * (rollers?.free ? 15 : 11);
    rollers?.soft.forEach((soft, k) => stroke(pen, colours.ink, 1.5, () => pen.arc(0, k ? -away : away, 4.5 * size, 0, 2 * Math.PI), "butt", soft ? [3, 2] : []));
    pen.restore();
  }

  /** A length to compare with. */
  bar(pen, width, height, scale, colours) {
    const { factor, unit } = DATA.length, length = roundBelow(0.2 * this.motion.scene.follower * factor) / factor, x = width - 18 - scale * length, y = height - 16;
    stroke(pen, colours.soft, 2, () => { pen.moveTo(x, y); pen.lineTo(x + scale * length, y); }, "butt");
    pen.font = SMALL; pen.textAlign = "center"; pen.textBaseline = "bottom"; pen.fillStyle = colours.soft;
    pen.fillText(`${Number((factor * length).toPrecision(6))} ${unit}`, x + scale * length / 2, y - 3);
  }

  /** Names, each at the first of its places where it covers nothing; it stays there as long as it can. */
  labels(pen, { O, P, C, radius, quick, lines, edges, springs, force, width, height, compact }) {
    const { colours } = this, middle = lines.length ? lines[lines.length - 1] : [P, C], [before, nose] = middle.slice(-2);
    const chord = direction(P, C), arm = direction(O, C), end = direction(before, nose), across = ([x, y]) => [-y, x], back = ([x, y]) => [-x, -y];
    const sides = (point, normal, gap) => [[point, normal, gap], [point, back(normal), gap]];
    const [down, up, right, left] = [[0, 1], [0, -1], [1, 0], [-1, 0]], diagonal = [[0.7, -0.7], [-0.7, -0.7], [-0.7, 0.7], [0.7, 0.7]];
    const wanted = [  // name, font, and places: a point, a direction away from it, and the gap
      ["O", BOLD, [[O, down, 18], [O, left, 12], ...diagonal.map((way) => [O, way, 12]), [O, right, 13], [O, up, 8]]],
      ["P", BOLD, [[P, down, 18], [P, right, 10]]],
      ["tip", BOLD, [[nose, end, 8], ...sides(nose, across(end), 20), [nose, left, 14], [nose, up, 24], [nose, down, 24]]],
      ["slider", TEXT, [...sides(C, across(chord), 12), ...sides(C, across(arm), 12), ...diagonal.map((way) => [C, way, 14]), [C, up, 16], [C, down, 16]]],
      ["crank", TEXT, [0.5, 0.62, 0.4, 0.75].flatMap((part) => sides(between(O, C, part), across(arm), 5))],
      [compact ? "follower" : "flexible follower", TEXT, [3, 4, 2, 5].flatMap((k) => sides(middle[Math.min(k, middle.length - 1)], across(chord), 7))],
    ];
    if (force.length) wanted.push(["force", TEXT, [[force[0], direction(force[1], force[0]), 3], ...sides(force[0], across(direction(...force)), 4)]]);
    if (quick !== null) {
      const radial = [0.6, -0.6, 0.9, -0.9, 0.3, -0.3, 1.2, -1.2].map((angle) => [Math.cos(angle), Math.sin(angle)]);
      wanted.push(["quick return", BOLD, radial.map((way) => [[O[0] + radius * way[0], O[1] + radius * way[1]], way, 7])]);
    }
    const taken = [...lines, ...edges, ...springs, ...(force.length ? [force] : []), [O, C], [P, [P[0] + 2 * (C[0] - P[0]), P[1] + 2 * (C[1] - P[1])]]].flatMap(sampled).map((point) => around(point, 3, 3));
    taken.push(...[O, P].map(([x, y]) => around([x, y + 5], 12, 12)), around(C, 15, 12), ...lines.map((line) => around(line[line.length - 1], 9, 14)));
    if (quick !== null) for (let k = -12; k <= 12; k++) taken.push(around([O[0] + radius * Math.cos(quick * k / 12), O[1] + radius * Math.sin(quick * k / 12)], 5, 5));
    if (edges.length) taken.push([0, height - 36, compact ? 90 : 260, height]);
    taken.push([width - 150, height - 36, width, height], around([O[0] + radius * Math.cos(ARROW), O[1] + radius * Math.sin(ARROW)], 7, 7));
    pen.textAlign = "center"; pen.textBaseline = "middle";
    for (const [text, font, places] of wanted) {
      pen.font = font;
      const half = pen.measureText(text).width / 2 + 2;
      const centres = places.map(([[x, y], [nx, ny], gap]) => { const away = Math.abs(nx) * half + Math.abs(ny) * 8 + gap; return [x + nx * away, y + ny * away]; });
      const free = (centre) => { const box = around(centre, half, 8); return box[0] > 0 && box[1] > 0 && box[2] < width && box[3] < height && !taken.some((other) => overlap(box, other)); };
      const kept = this.kept[text], found = kept !== undefined && free(centres[kept]) ? kept : centres.findIndex(free);
      if (found < 0) continue;  // better no name than one that covers something
      this.kept[text] = found;
      taken.push(around(centres[found], half, 8));
      pen.fillStyle = text === "quick return" ? colours["quick-ink"] : colours.ink;
      pen.fillText(text, ...centres[found]);
    }
  }
}

const between = (from, to, part) => [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])];
/** A spring's zigzag between two points, a tenth of it straight at either end. */
const coil = (from, to, half) => {
  const [dx, dy] = direction(from, to), turns = Array.from({ length: 2 * COILS - 1 }, (_, k) => {
    const [x, y] = between(from, to, 0.1 + 0.8 * (k + 1) / (2 * COILS)), side = k % 2 ? -half : half;
    return [x - side * dy, y + side * dx];
  });
  return [from, between(from, to, 0.1), ...turns, between(from, to, 0.9), to];
};
const around = ([x, y], w, h) => [x - w, y - h, x + w, y + h];
const direction = ([x, y], [toX, toY]) => { const length = Math.hypot(toX - x, toY - y) || 1; return [(toX - x) / length, (toY - y) / length]; };
const overlap = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];

/** So many places evenly along a polyline, each with the normal there: across the line to its left as it is seen. */
function alongLine(line, count) {
  const parts = line.length - 1;
  return Array.from({ length: count }, (_, k) => {
    const along = k / (count - 1) * parts, n = Math.min(Math.floor(along), parts - 1), part = along - n;
    const [a, b] = [line[n], line[n + 1]], [dx, dy] = direction(a, b);
    return [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]), dy, -dx];
  });
}

/** Points along a polyline, some pixels apart. */
function sampled(line) {
  return line.slice(1).flatMap(([x, y], k) => {
    const [px, py] = line[k], parts = Math.max(1, Math.ceil(Math.hypot(x - px, y - py) / 8));
    return Array.from({ length: parts }, (_, part) => [px + (x - px) * part / parts, py + (y - py) * part / parts]);
  });
}

function stroke(pen, style, width, path, cap = "round", dash = [], offset = 0) {
  pen.strokeStyle = style; pen.lineWidth = width; pen.lineCap = cap;
  pen.setLineDash(dash); pen.lineDashOffset = offset;
  pen.beginPath(); path(); pen.stroke();
  pen.setLineDash([]);
}

/** A smooth line through points. */
function smooth(pen, points) {
  pen.moveTo(...points[0]);
  for (let k = 0; k < points.length - 1; k++) {
    const [a, b, c, d] = [points[Math.max(0, k - 1)], points[k], points[k + 1], points[Math.min(points.length - 1, k + 2)]];
    pen.bezierCurveTo(b[0] + (c[0] - a[0]) / 6, b[1] + (c[1] - a[1]) / 6, c[0] - (d[0] - b[0]) / 6, c[1] - (d[1] - b[1]) / 6, ...c);
  }
}

function dot(pen, [x, y], radius, fill, edge, width) {
  pen.beginPath(); pen.arc(x, y, radius, 0, 2 * Math.PI);
  pen.fillStyle = fill; pen.fill();
  pen.strokeStyle = edge; pen.lineWidth = width; pen.stroke();
}

/** A bearing that is fixed to the ground. */
function support(pen, [x, y], colours) {
  pen.beginPath(); pen.moveTo(x, y); pen.lineTo(x + 10, y + 16); pen.lineTo(x - 10, y + 16); pen.closePath();
  pen.fillStyle = colours.faint; pen.fill();
  pen.strokeStyle = colours.soft; pen.lineWidth = 1; pen.stroke();
  stroke(pen, colours.soft, 1.5, () => { pen.moveTo(x - 14, y + 16); pen.lineTo(x + 14, y + 16); });
}
