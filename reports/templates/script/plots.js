// What is drawn in the chapters that are open: charts, and all signals of the run that is shown.

const charts = new Map();

/** All signals of the run, one below the other; a zoom is that of all. */
function drawSignals(holder) {
  for (const section of document.querySelectorAll(".of-run")) section.hidden = section.dataset.run !== state.run;
  const names = drawnOrder(), panels = [];
  const list = keyOf(names.map((name) => ({ name, of: name, line: true, marked: false })));
  holder.replaceChildren(list);
  for (const signal of Object.keys(DATA.signals).filter((each) => names.some((name) => each in motion.tables[name]))) {
    const { label } = DATA.signals[signal], panel = textOf("figure", "", "panel"), values = textOf("p", "", "values"), canvas = document.createElement("canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${label} of ${runOf(state.run).title}`);
    panel.append(textOf("figcaption", label), values, canvas);
    holder.append(panel);
    const curve = new Curve(canvas, engineColour, () => tellValues(values, curve, curve.hover), (at) => { pause(); moveTo(at); });
    curve.show(motion, names, looks, signalOf(signal));
    curve.redraw = () => curve.draw(null);
    curve.zoomed = (window) => { for (const other of panels) { other.window = window; other.redraw(); } };
    layOutValues(values, curve);
    panels.push(curve);
  }
  for (const curve of panels) curve.redraw();
  holder.setAttribute("aria-label", `All signals of ${runOf(state.run).title} over the crank angle. ${element("apart").textContent}`);
}

document.getElementById("signals-csv")?.addEventListener("click", () => save(`${state.run}.csv`, signalTable(Object.keys(DATA.signals))));

/** Draw anew what is in sight and was drawn for other engines, colours, another run or width. */
function drawOpened() {
  for (const table of document.querySelectorAll("details[open] .scroll")) table.classList.toggle("more", table.scrollWidth > table.clientWidth + 1);
  for (const holder of document.querySelectorAll(".drawn, #signals")) {
    const key = [holder.id && state.run, state.engines, isDark(), holder.clientWidth].join();
    if (!holder.clientWidth || holder.dataset.shown === key || !motion) continue;  // without a width it is in a chapter that is closed
    holder.dataset.shown = key;
    if (holder.id) { drawSignals(holder); continue; }
    if (!charts.has(holder)) charts.set(holder, new Chart(holder, JSON.parse(holder.previousElementSibling.textContent)));
    charts.get(holder).draw();
  }
}
showPlots = drawOpened;
