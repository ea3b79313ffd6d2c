// One run's motion: where everything is at a cursor. Lengths in m; the cursor is the crank's turn in degrees, or the time in s.

const PLACES = 12;  // parts of the follower between the places whose deflection is known
const SHAPE = Array.from({ length: PLACES - 1 }, (_, k) => `shape_${String(k + 1).padStart(2, "0")}`);
const STEPS = [1, 2, 5];
const SHOWN = 0.15;  // of the follower's length: the magnified deflection is at most that
const STRAIGHT = 1e-6;  // of the follower's length: less is no bending

/** The largest of 1, 2, 5, 10, ... times a power of ten that does not exceed a value. */
function roundBelow(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  return Math.max(...STEPS.map((step) => step * decade).filter((round) => round <= value * (1 + 1e-12)));
}

/** The index of the last of rising values that does not exceed one, and how far that is on the way to the next, 0 to 1. */
function placeIn(values, wanted) {
  let low = 0, high = values.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= wanted) low = middle; else high = middle;
  }
  const step = values[high] - values[low];
  return { row: low, part: step > 0 ? Math.min(1, Math.max(0, (wanted - values[low]) / step)) : 0 };
}

function valueAt(values, { row, part }) {
  return values[row] * (1 - part) + values[Math.min(row + 1, values.length - 1)] * part;
}

class Motion {
  constructor(run, tables, axis) {
    this.cyclic = axis === "crank_angle";
    this.scene = run.scene;
    this.tables = tables;
    this.cursors = {};
    for (const [engine, columns] of Object.entries(tables)) {
      const raw = columns[axis];
      this.cursors[engine] = raw.map((value) => this.cyclic ? Math.abs(value - raw[0]) * 180 / Math.PI : value - raw[0]);
    }
    this.engines = Object.keys(tables);
    const lead = this.engines.includes("reference") ? "reference" : this.engines[0];
    this.lead = lead;
    const first = tables[lead]?.crank_angle;
    this.begin = first ? (first[0] * 180 / Math.PI % 360 + 360) % 360 : 0;
    this.turning = first && first[first.length - 1] < first[0] ? -1 : 1;
    this.span = lead ? this.cursors[lead][this.cursors[lead].length - 1] : 1;
    const time = tables[lead]?.time;
    this.duration = time ? time[time.length - 1] - time[0] : 1;
    this.turnSeconds = first ? this.duration * 2 * Math.PI / Math.abs(first[first.length - 1] - first[0]) : 0;
  }

  value(engine, column, at, place = placeIn(this.cursors[engine], at)) {
    return valueAt(this.tables[engine][column], place);
  }

  /** Time since the start of the cycle or trajectory, by the leading engine; and the cursor at a time. */
  timeAt(at) {
    return this.value(this.lead, "time", at) - this.tables[this.lead].time[0];
  }

  cursorAt(time) {
    const times = this.tables[this.lead].time;
    return valueAt(this.cursors[this.lead], placeIn(times, times[0] + time));
  }

  /** Between which cursors the follower swings back; null where that is not known, or the motion is no cycle. */
  get quickReturn() {
    const { quick } = this.scene;
    return this.cyclic && quick !== null ? [180 - quick * 180 / Math.PI, 180 + quick * 180 / Math.PI] : null;
  }

  crankAngle(at) {
    return this.value(this.lead, "crank_angle", at);
  }

  slider(angle) {
    return [this.scene.crank * Math.cos(angle), this.scene.crank * Math.sin(angle)];
  }

  hasShape(engine) {
    return SHAPE.every((name) => name in this.tables[engine]);
  }

  /** The centre line's places along and across the straight line from P through the slider, and that line's angle. */
  chordwise(engine, at) {
    const place = placeIn(this.cursors[engine], at);
    const read = (column) => this.value(engine, column, at, place);
    const [x, y] = this.slider(read("crank_angle"));
    const chord = Math.atan2(y, x - this.scene.pivot);
    const turn = read("follower_angle") - chord;
    const W = [0, ...SHAPE.map(read), read("tip_deflection")];
    const h = this.scene.follower / PLACES;
    let along = 0;
    const points = W.map((w, k) => {
      if (k) along += Math.sqrt(Math.max(0, h * h - (w - W[k - 1]) ** 2));  // the follower does not stretch
      return [along * Math.cos(turn) - w * Math.sin(turn), along * Math.sin(turn) + w * Math.cos(turn)];
    });
    return { chord, points };
  }

  /** The centre line in the frame of O, its distance from the straight line magnified. */
  line(engine, at, factor) {
    const { chord, points } = this.chordwise(engine, at);
    const [c, s] = [Math.cos(chord), Math.sin(chord)];
    return points.map(([along, across]) => [this.scene.pivot + along * c - factor * across * s, along * s + factor * across * c]);
  }

  /** Instants spread over the motion. */
  * instants(count = 120) {
    for (let k = 0; k <= count; k++) yield this.span * k / count;
  }

  /** A round factor by which the largest deflection is well seen; 1 where nothing bends. */
  factor(engines) {
    if (this.scene.rigid) return 1;
    let largest = 0;
    for (const engine of engines.filter((name) => this.hasShape(name)))
      for (const at of this.instants()) for (const [, across] of this.chordwise(engine, at).points) largest = Math.max(largest, Math.abs(across));
    const length = this.scene.follower;
    return largest > STRAIGHT * length ? Math.max(1, roundBelow(SHOWN * length / largest)) : 1;
  }

  /** What all instants reach: least and greatest x and y. */
  bounds(engines, factor) {
    const { crank, pivot, spring } = this.scene, [x, y] = spring?.anchor ?? [0, 0];
    let [left, right, low, high] = [Math.min(-crank, x), Math.max(pivot, crank, x), Math.min(-crank, y), Math.max(crank, y)];
    for (const engine of engines.filter((name) => this.hasShape(name)))
      for (const at of this.instants(60))
        for (const [x, y] of this.line(engine, at, factor))
          [left, right, low, high] = [Math.min(left, x), Math.max(right, x), Math.min(low, y), Math.max(high, y)];
    return [left, right, low, high];
  }
}
