// What SVG charts are made of: texts, lines and marks with the looks of names (reports/line_styles.py), and legends.

const SVG = Object.assign(document.createElement("div"), { innerHTML: "<svg></svg>" }).firstChild.namespaceURI;
const FONT = "system-ui, \"DejaVu Sans\", sans-serif";
const [TICK, NAME] = [12, 13];  // letters, px
const measuring = document.createElement("canvas").getContext("2d");

/** How wide a text is, px. */
function wide(text, size = TICK) {
  measuring.font = `${size}px ${FONT}`;
  return measuring.measureText(text).width;
}

/** An SVG element. */
function svg(tag, attributes = {}, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** A text at a place. */
function words(x, y, text, { anchor = "middle", fill = colour("soft"), size = TICK, ...more } = {}) {
  return svg("text", { x, y, "text-anchor": anchor, fill, "font-size": size, "font-family": FONT, ...more }, text);
}

/** Corners on a circle of radius 1, the first one above its centre or turned from there; every other one may lie further in. */
const corners = (count, turned, inner = 1) => Array.from({ length: count }, (_, k) => {
  const angle = 2 * Math.PI * (k / count + turned), radius = k % 2 ? inner : 1;
  return [radius * Math.sin(angle), -radius * Math.cos(angle)];
});
const plus = [[-0.35, -1], [0.35, -1], [0.35, -0.35], [1, -0.35], [1, 0.35], [0.35, 0.35], [0.35, 1], [-0.35, 1], [-0.35, 0.35], [-1, 0.35], [-1, -0.35], [-0.35, -0.35]];
/** Outlines of marks by their name; a circle has no corners. */
const MARKS = {
  circle: null, square: corners(4, 1 / 8), diamond: corners(4, 0), triangle: corners(3, 0), "triangle-down": corners(3, 1 / 2), "triangle-left": corners(3, 3 / 4),
  "triangle-right": corners(3, 1 / 4), pentagon: corners(5, 0), hexagon: corners(6, 0), star: corners(10, 0, 0.45), plus, cross: plus.map(([x, y]) => [0.8 * (x - y), 0.8 * (x + y)]),
};

/** A mark of a look at a place; a hollow one is filled with the ground. */
function mark(name, x, y, radius, hollow, more = {}) {
  const look = lookOf(name), outline = MARKS[look.marker], fill = hollow ? colour("ground") : look.colour;
  const about = { fill, stroke: look.colour, "stroke-width": 1.4, ...more };
  if (!outline) return svg("circle", { cx: x, cy: y, r: 0.9 * radius, ...about });
  return svg("polygon", { points: outline.map(([dx, dy]) => `${(x + radius * dx).toFixed(1)},${(y + radius * dy).toFixed(1)}`).join(" "), ...about });
}

/** The look of a name, with its colour on the page as it is now. */
function lookOf(name) {
  return { marker: "circle", width: 2, dash: [], offset: 0, order: 0, ...looks[name], colour: engineColour(name) };
}

/** The attributes of a look's line, thinner than on the first screen where marks say the same. */
function strokeOf(name) {
  const look = lookOf(name);
  return { fill: "none", stroke: look.colour, "stroke-width": Math.max(1.5, 0.7 * look.width), "stroke-dasharray": look.dash.join(" ") || "none", "stroke-dashoffset": look.offset };
}

/** A legend: every name with its line and mark. */
function keyOf(entries) {
  const list = textOf("ul", "", "key");
  for (const { name, of, line, hollow = false, marked = true, broad = false, columns = false } of entries) {
    const item = textOf("li", ""), sample = svg("svg", { width: 40, height: 14, "aria-hidden": "true" });
    if (broad) sample.append(svg("line", { x1: 4, x2: 36, y1: 7, y2: 7, stroke: colour("line"), "stroke-width": 12, "stroke-linecap": "round" }));
    else if (columns) sample.append(svg("rect", { x: 14, y: 1, width: 12, height: 12, fill: lookOf(of).colour }));
    else if (line) sample.append(svg("line", { x1: 0, x2: 40, y1: 7, y2: 7, ...strokeOf(of), "stroke-dashoffset": 0 }));
    if (marked && !broad) sample.append(mark(of, 20, 7, 5, hollow));
    item.dataset.of = of;
    item.append(sample, name);
    list.append(item);
  }
  return list;
}
