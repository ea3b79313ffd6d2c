// Plots of the chapters, by the plotting library, which is unpacked when the first of them is seen.

let library = null;

function plotting() {
  library ??= inflated("bokeh").then((bytes) => new Promise((done, failed) => {
    const script = document.createElement("script");
    script.src = URL.createObjectURL(new Blob([bytes], { type: "text/javascript" }));
    script.onload = () => done(window.Bokeh);
    script.onerror = failed;
    document.head.append(script);
  }));
  return library;
}

/** An empty figure in the page's colours. */
function figure(Bokeh, about) {
  const made = Bokeh.Plotting.figure({ sizing_mode: "stretch_width", height: 360, tools: "pan,box_zoom,wheel_zoom,reset,save", toolbar_location: "above", ...about });
  const [ink, soft, faint, ground] = ["ink", "soft", "faint", "ground"].map(colour);
  Object.assign(made, { background_fill_color: ground, border_fill_color: ground, outline_line_color: faint });
  made.toolbar.logo = null;
  made.toolbar.active_scroll = null;
  for (const axis of [...made.xaxis, ...made.yaxis]) Object.assign(axis, {
    axis_label_text_color: ink, major_label_text_color: soft, axis_line_color: soft, major_tick_line_color: soft, minor_tick_line_color: null,
    axis_label_text_font_style: "normal", axis_label_text_font_size: "13px", major_label_text_font_size: "12px",
  });
  for (const grid of [...made.xgrid, ...made.ygrid]) grid.grid_line_color = faint;
  return made;
}

const lineOf = (name) => {
  const { width = 2, dash = [] } = looks[name] ?? {};
  return { line_color: engineColour(name), line_width: Math.max(1.4, 0.85 * width), line_dash: [...dash] };
};
const others = ["accent", "quick-ink", "bad", "soft"];
const markers = ["circle", "square", "triangle", "diamond"];

/** Limits around values, with a part of the axis left over on the right for names. */
function spread(values, logarithmic, room) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  return logarithmic ? [low / 1.6, high * (1.6 * high / low) ** (room / (1 - room))] : [low - 0.06 * (high - low || 1), high + room / (1 - room) * (high - low || 1)];
}

/** How far each name at a line's end is moved up or down, so that it covers no other; places in pixels. */
function shifts(places) {
  const taken = [];
  return places.map(([x, y]) => {
    const shift = [0, -13, 13, -26, 26, -39, 39].find((dy) => !taken.some(([ox, oy]) => Math.abs(ox - x) < 90 && Math.abs(oy - y - dy) < 13)) ?? 0;
    taken.push([x, y + shift]);
    return shift;
  });
}

/** A plot that Python described (reports/page/plot.py). */
function draw(Bokeh, holder, plot) {
  if (plot.categories.length) holder.style.minWidth = "620px";
  const kind = (axis) => plot.log.includes(axis) ? "log" : "linear", about = { x_axis_label: plot.x, y_axis_label: plot.y, x_axis_type: kind("x"), y_axis_type: kind("y") };
  if (plot.categories.length) { about.y_range = [...plot.categories].reverse(); about.y_axis_type = "auto"; about.x_axis_label = plot.y; about.y_axis_label = null; about.height = 90 + 34 * plot.categories.length; }
  about.x_range = spread(plot.series.flatMap((series) => plot.categories.length ? series.y : series.x), plot.log.includes("x"), plot.categories.length ? 0.1 : Math.min(0.4, 140 / holder.clientWidth));
  const made = figure(Bokeh, about);
  // engines that are not on the first screen cannot be switched off
  const shown = plot.series.filter((series) => !DATA.engines.includes(series.engine) || state.engines.includes(series.engine));
  const heights = shown.flatMap((series) => series.y), part = (value, low, high, axis) => plot.log.includes(axis) ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  const lowest = Math.min(...heights), highest = Math.max(...heights);
  const pixel = (series, i) => [(holder.clientWidth - 80) * part(series.x.at(i), ...about.x_range, "x"), -290 * part(series.y.at(i), lowest, highest, "y")];
  const ends = shown.map((series) => plot.categories.length || !series.x.length ? [0, 0] : pixel(series, -1)), moved = shifts(ends);
  // a name stands behind the marks of others at its height
  const marks = plot.categories.length ? [] : shown.flatMap((series) => series.x.map((_, i) => pixel(series, i)));
  const aside = ends.map(([x, y], k) => Math.max(...marks.filter((mark) => mark[0] < x + 30 && Math.abs(mark[1] - y - moved[k]) < 10).map((mark) => mark[0] - x), 0));
  if (plot.below) made.add_layout(new Bokeh.BoxAnnotation({ top: plot.below, fill_color: colour("soft"), fill_alpha: 0.16, line_color: null }));
  shown.forEach((series, k) => {
    const across = plot.categories.length ? series.y : series.x, up = plot.categories.length ? series.x : series.y;
    if (series.broad) { made.line({ field: "x" }, { field: "y" }, { source: new Bokeh.ColumnDataSource({ data: { x: across, y: up } }), line_color: colour("line"), line_width: 14, line_cap: "round", line_join: "round" }); return; }
    const look = series.engine ? { ...lineOf(series.engine), line_width: 2 } : { line_color: colour(others[k % others.length]), line_width: 2 };
    const source = new Bokeh.ColumnDataSource({ data: { x: across, y: up, text: series.text.length ? series.text : across.map(() => ""), name: across.map(() => series.name) } });
    if (series.line) made.line({ field: "x" }, { field: "y" }, { source, ...look, ...(series.engine ? {} : { legend_label: series.name }) });
    const dots = made.scatter({ field: "x" }, { field: "y" }, {
      source, size: 9, marker: markers[shown.filter((each) => !each.broad).indexOf(series) % markers.length],
      line_color: look.line_color, line_width: 1.5, fill_color: series.hollow ? colour("ground") : look.line_color, ...(series.engine ? {} : { legend_label: series.name }),
    });
    made.add_tools(new Bokeh.HoverTool({ renderers: [dots], tooltips: [["", "@name"], ["", "@text"]], toggleable: false }));
    if (series.engine && series.line) made.add_layout(new Bokeh.Label({ x: across.at(-1), y: up.at(-1), text: series.name, x_offset: 7 + aside[k], y_offset: -6 - moved[k], text_color: look.line_color, text_font_size: "13px" }));
  });
  if (made.legend) Object.assign(made.legend, { background_fill_color: colour("ground"), label_text_color: colour("ink"), border_line_color: colour("faint"), click_policy: "hide", location: plot.legend });
  holder.replaceChildren();
  return Bokeh.Plotting.show(made, holder);
}

/** All signals of the run that is shown, over the crank's turn. */
async function drawSignals(holder) {
  for (const section of document.querySelectorAll(".of-run")) section.hidden = section.dataset.run !== state.run;
  const key = [state.run, state.engines, isDark(), holder.clientWidth].join();
  if (!holder.closest("details").open || holder.dataset.shown === key) return;
  holder.dataset.shown = key;
  const Bokeh = await plotting();
  holder.replaceChildren();
  const figures = [], against = motion.cyclic && motion.turning < 0; // time runs to the right, whichever way the crank turns
  for (const signal of Object.keys(DATA.signals)) {
    const names = drawnOrder().filter((name) => signal in motion.tables[name]), { label, unit, factor: scale } = DATA.signals[signal];
    if (!names.length) continue;
    const made = figure(Bokeh, { height: 250, x_axis_label: motion.cyclic ? "crank angle [°]" : "time [s]", y_axis_label: `${label} [${unit}]`, ...(figures.length ? { x_range: figures[0].x_range } : against ? { x_range: new Bokeh.DataRange1d({ flipped: true }) } : {}) });
    if (motion.cyclic) for (const axis of [...made.xaxis, ...made.xgrid]) axis.ticker = new Bokeh.AdaptiveTicker({ mantissas: [1.5, 3, 4.5, 9], desired_num_ticks: 8 });
    for (const name of names) {
      const x = Array.from(motion.cursors[name], (turned) => motion.begin + motion.turning * turned);
      const source = new Bokeh.ColumnDataSource({ data: { x, y: Array.from(motion.tables[name][signal], (value) => value * scale), name: x.map(() => name) } });
      const line = made.line({ field: "x" }, { field: "y" }, { source, ...lineOf(name) });
      made.add_tools(new Bokeh.HoverTool({ renderers: [line], mode: "vline", toggleable: false, tooltips: [["", `@name @y{0.0000} ${unit}`], ["at", `@x{0.0} ${motion.cyclic ? "°" : "s"}`]] }));
    }
    figures.push(made);
  }
  holder.setAttribute("aria-label", `All signals of ${runOf(state.run).title} over the crank angle. ${element("apart").textContent}`);
  if (figures.length) await Bokeh.Plotting.show(Bokeh.Plotting.gridplot(figures.map((made) => [made]), { sizing_mode: "stretch_width", toolbar_location: "above" }), holder);
}

document.getElementById("signals-csv")?.addEventListener("click", () => save(`${state.run}.csv`, signalTable(Object.keys(DATA.signals))));

async function drawOpened() {
  for (const holder of document.querySelectorAll("details[open] .drawn:not([hidden])")) {
    const key = [state.engines, isDark()].join();
    if (holder.dataset.shown === key) continue;
    holder.dataset.shown = key;
    draw(await plotting(), holder, JSON.parse(holder.dataset.plot));
  }
  const signals = document.getElementById("signals");
  if (signals && motion) await drawSignals(signals);
}
showPlots = () => { drawOpened(); };

// One plot of several in a figure.
for (const choice of document.querySelectorAll(".choice")) choice.addEventListener("change", (event) => {
  choice.parentElement.querySelectorAll(".drawn").forEach((holder, k) => { holder.hidden = k !== Number(event.target.value); });
  showPlots();
});
