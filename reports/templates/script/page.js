// The page: one state (run, engines, cursor, signal, magnification, chapter), kept in the address, and what shows it.

const element = (id) => document.getElementById(id);
const DATA = JSON.parse(element("view").textContent);
const looks = DATA.looks;
const SPEEDS = [1, 2, 5, 10, 20, 50, 100];
const state = { run: DATA.start, engines: DATA.engines, at: 0, signal: "tip_acceleration", bend: "auto", stress: true, chapter: "", section: "" };
const still = window.matchMedia("(prefers-reduced-motion: reduce)");
const dark = window.matchMedia("(prefers-color-scheme: dark)");
let motion = null, playing = false, before = 0, factor = 1, loading = 0, writing = 0;
let showPlots = () => {};  // of the chapters, where there are any: called when engines, run, colours or width change

const isDark = () => !onPaper() && (document.documentElement.dataset.theme ?? (dark.matches ? "dark" : "light")) === "dark";
const engineColour = (name) => Object.hasOwn(looks, name) ? looks[name][isDark() ? "dark" : "light"] : colour("soft");
const drawnOrder = () => state.engines.filter((name) => motion?.tables[name]).sort((a, b) => looks[a].order - looks[b].order);
const runOf = (name) => DATA.runs.find((run) => run.name === name);
const signalOf = (name) => ({ name, ...DATA.signals[name] });

const stage = new Stage(element("stage"), engineColour);
const curve = new Curve(element("curve"), engineColour, () => readOut(), (at) => { pause(); moveTo(at); });
curve.redraw = () => { if (!playing) curve.draw(state.at); };

// ---- the address

function readAddress(hash) {
  const given = new URLSearchParams(hash.slice(1));
  const wanted = { ...state };
  if (runOf(given.get("run"))) wanted.run = given.get("run");
  if (given.has("engines")) wanted.engines = DATA.engines.filter((name) => given.get("engines").split(",").includes(name));
  if (Object.hasOwn(DATA.signals, given.get("signal") ?? "")) wanted.signal = given.get("signal");
  if (given.has("at") && Number.isFinite(Number(given.get("at")))) wanted.at = Math.max(0, Number(given.get("at")));
  if (given.get("bend") === "auto" || Number(given.get("bend")) >= 1) wanted.bend = given.get("bend");
  if (given.has("stress")) wanted.stress = given.get("stress") !== "off";
  if (given.has("chapter")) wanted.chapter = chapters().some((found) => found.id === given.get("chapter")) ? given.get("chapter") : "";
  if (given.has("chapter")) wanted.section = sectionIn(wanted.chapter, given.get("section")) ? given.get("section") : "";
  return { wanted, at: given.has("at") };
}

/** Browsers take only some changes of the address in a time. */
function writeAddress() {
  clearTimeout(writing);
  writing = setTimeout(writeNow, 100);
}

function writeNow() {
  const told = new URLSearchParams({ run: state.run, engines: state.engines.join(","), at: String(Number(state.at.toFixed(3))), signal: state.signal });
  if (state.bend !== "auto") told.set("bend", state.bend);
  if (!state.stress) told.set("stress", "off");
  if (state.chapter) told.set("chapter", state.chapter);
  if (state.chapter && state.section) told.set("section", state.section);
  history.replaceState(null, "", `#${told.toString().replaceAll("%2C", ",")}`);
}

/** Where a link leads; the event tells it, for a late `writeNow` may have put the old state back into the address meanwhile. */
async function follow({ newURL }) {
  const { hash } = new URL(newURL), { wanted, at } = readAddress(hash);
  clearTimeout(writing);
  const opened = wanted.chapter !== state.chapter || wanted.section !== "";
  if (at) pause();
  await change(wanted);
  if (opened && wanted.chapter) openChapter(wanted.chapter, wanted.section);
  else if (hash.includes("run=") && !wanted.chapter && opened) window.scrollTo({ top: 0 });
}

// ---- changes

/** Change the state and show it; a run's motion is unpacked when it is first shown. */
async function change(changes) {
  const other = changes.run !== undefined && (changes.run !== state.run || motion === null);
  Object.assign(state, changes);
  if (other) {
    const run = runOf(state.run), turn = ++loading;
    run.motion ??= unpack(`motion-${DATA.runs.indexOf(run)}`, run.engines).then((tables) => new Motion(run, tables, DATA.axis));
    const found = await run.motion;
    if (turn !== loading) return;
    motion = found;
  }
  show();
}

function show() {
  const run = runOf(state.run), names = drawnOrder();
  const any = motion.engines.length > 0;
  element("nothing").hidden = any;
  for (const part of document.querySelectorAll(".transport, .signal, .bend, #stage")) part.hidden = !any;
  if (any) {
    state.at = Math.min(state.at, motion.span);
    factor = state.bend === "auto" ? motion.factor(names.length ? names : motion.engines) : Number(state.bend);
    stage.show(motion, names, factor, looks, state.stress ? run.stress : null);
    curve.show(motion, names, looks, signalOf(state.signal));
    layOutValues(element("values"), curve);
    element("at").max = motion.span;
  }
  element("bend").options[0].textContent = state.bend === "auto" ? `automatic: × ${written(factor)}` : "automatic";
  element("bend").value = state.bend;
  if (element("stress")) {
    element("stress").checked = state.stress;
    element("stressed").hidden = !run.stress;
  }
  element("signal").value = state.signal;
  const told = (length) => `${written(DATA.length.factor * length, 3)} ${DATA.length.unit}`;
  element("caption").textContent = `${run.title} · follower ${told(run.scene.follower)}, crank ${told(run.scene.crank)}${any && motion.cyclic ? `, one turn in ${written(1000 * motion.duration, 4)} ms` : ""}`;
  for (const box of document.querySelectorAll("#engines input")) {
    box.checked = state.engines.includes(box.value);
    const fact = box.closest("label").querySelector(".fact");
    if (fact) fact.textContent = run.facts[box.value] ?? "";
  }
  for (const button of document.querySelectorAll("#run-buttons button")) button.setAttribute("aria-pressed", String(button.value === state.run));
  if (element("run")) element("run").value = state.run;
  for (const answer of document.querySelectorAll(".answer")) answer.hidden = answer.dataset.run !== state.run;
  const finding = any ? apart(names) : "";
  element("apart").textContent = finding;
  element("curve").setAttribute("aria-label", `${DATA.signals[state.signal].label} of ${run.title}. ${finding}`);
  element("stage").setAttribute("aria-label", `The mechanism of ${run.title}, drawn by ${names.join(", ")}, deflection magnified ${written(factor)} times. ${finding}`);
  showPlots();
  moveTo(state.at);
}

/** How far the engines' curves lie from the leading one's, over its largest magnitude. */
function apart(names) {
  const { lead } = motion, others = names.filter((name) => name !== lead && state.signal in motion.tables[name]);
  if (!names.includes(lead) || !others.length || !(state.signal in motion.tables[lead])) return "";
  const values = motion.tables[lead][state.signal], cursor = motion.cursors[lead];
  const peak = values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  if (!peak) return "";
  const told = others.map((name) => {
    let most = 0;
    for (let k = 0; k < values.length; k++) most = Math.max(most, Math.abs(motion.value(name, state.signal, cursor[k]) - values[k]));
    return `${name} ${written(100 * most / peak, 2)} %`;
  });
  return `Largest distance from ${lead}, of its peak: ${told.join(", ")}.`;
}

function moveTo(at) {
  state.at = at;
  if (motion.engines.length) {
    stage.draw(at);
    curve.draw(at);
    readOut();
  }
  if (!playing) writeAddress();
}

/** What stands above a curve: places for the cursor and each engine's value, filled by `tellValues`. */
function layOutValues(holder, shown) {
  holder.replaceChildren(textOf("span", "", "where"), ...shown.engines.map((name) => {
    const item = textOf("span", "", "value"), mark = textOf("i", "");
    mark.style.background = engineColour(name);
    item.append(mark, `${name} `, textOf("b", ""));
    return item;
  }), textOf("span", shown.signal.unit));
}

/** The values at a cursor; null: none. */
function tellValues(holder, shown, at) {
  const [where, ...items] = holder.children, { name: column, factor: scale } = shown.signal;
  where.textContent = at === null ? "" : shown.cursorText(Number(at.toFixed(motion.cyclic ? 1 : 4)));
  shown.engines.forEach((name, k) => { items[k].lastChild.textContent = at === null ? "" : written(scale * motion.value(name, column, at), 4); });
}

function readOut() {
  tellValues(element("values"), curve, curve.hover ?? state.at);
  const range = element("at"), told = `${motion.cyclic ? `crank ${angleText(Math.round(motion.begin + motion.turning * state.at))}, ` : ""}${written(Math.round(1000 * motion.timeAt(state.at)))} ms`;
  range.value = state.at;
  element("where").textContent = told;
  if (!playing) range.setAttribute("aria-valuetext", told);
}

function textOf(tag, text, kind = "") {
  const found = document.createElement(tag);
  found.textContent = text;
  if (kind) found.className = kind;
  return found;
}

// ---- playing

function play() {
  if (playing || !motion.engines.length) return;
  playing = true;
  before = 0;
  element("play").setAttribute("aria-label", "Pause");
  element("play").textContent = "❚❚";
  requestAnimationFrame(step);
}

function pause() {
  if (!playing) return;
  playing = false;
  element("play").setAttribute("aria-label", "Play");
  element("play").textContent = "▶";
  writeAddress();
}

function step(now) {
  if (!playing) return;
  if (before && !document.hidden) {
    const passed = Math.min(100, now - before) / 1000 / Number(element("speed").value);
    moveTo(motion.cursorAt((motion.timeAt(state.at) + passed) % motion.duration));
  }
  before = now;
  requestAnimationFrame(step);
}

// ---- things to take away

function save(name, text, type = "text/csv") {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

/** Signals of the engines that are shown, each at its own instants, in SI units; what an engine does not have stays empty. */
function signalTable(signals) {
  const columns = ["time", "crank_angle", ...signals], quoted = (text) => `"${text.replaceAll('"', '""')}"`;
  const rows = drawnOrder().flatMap((name) => {
    const table = motion.tables[name], start = table.time?.[0] ?? 0;
    const value = (column, k) => !table[column] ? "" : column === "time" ? table.time[k] - start : table[column][k];
    return Array.from(motion.cursors[name], (_, k) => [quoted(name), ...columns.map((column) => value(column, k))].join(","));
  });
  return [["engine", ...columns.map((column) => `${column} [${DATA.units[column]}]`)].join(","), ...rows].join("\n") + "\n";
}

// ---- chapters

const chapters = () => [...document.querySelectorAll("details.chapter")];

/** A part of a chapter that has a name of its own; null: there is none of that name. */
const sectionIn = (chapter, id) => [...document.getElementById(chapter)?.querySelectorAll("[data-section]") ?? []].find((found) => found.id === id) ?? null;

function openChapter(id, section = "") {
  const found = chapters().find((chapter) => chapter.id === id);
  if (!found) return;
  found.open = true;
  const part = sectionIn(id, section);
  if (part?.tagName === "DETAILS") part.open = true;
  showPlots();
  (part ?? found).scrollIntoView({ block: "start" });
}

// ---- wiring

element("play").addEventListener("click", () => playing ? pause() : play());
element("at").addEventListener("input", (event) => { pause(); moveTo(Number(event.target.value)); });
element("signal").append(...Object.entries(DATA.signals).map(([name, { label }]) => new Option(label, name)));
element("signal").addEventListener("change", (event) => change({ signal: event.target.value }));
element("bend").append(new Option("automatic", "auto"), ...SPEEDS.map((times) => new Option(`× ${times}`, times)));
element("bend").addEventListener("change", (event) => change({ bend: event.target.value }));
element("stress")?.addEventListener("change", (event) => change({ stress: event.target.checked }));
element("speed").append(...SPEEDS.map((times) => new Option(times === 1 ? "as it is" : `1/${times}`, times)));
element("zoom-in").addEventListener("click", () => curve.zoomBy(0.5, state.at));
element("zoom-out").addEventListener("click", () => curve.zoomBy(2, state.at));
element("csv").addEventListener("click", () => save(`${state.run}-${state.signal}.csv`, signalTable([state.signal])));
element("theme").addEventListener("click", () => { document.documentElement.dataset.theme = isDark() ? "light" : "dark"; show(); });
element("copy").addEventListener("click", async () => {
  writeNow();
  try { await navigator.clipboard.writeText(location.href); element("copy").textContent = "Copied"; } catch { element("copy").textContent = "Copy the address"; }
  setTimeout(() => { element("copy").textContent = "Copy link"; }, 1500);
});
for (const box of document.querySelectorAll("#engines input")) box.addEventListener("change", () => {
  change({ engines: [...document.querySelectorAll("#engines input")].filter((each) => each.checked).map((each) => each.value) });
});
for (const button of document.querySelectorAll("#run-buttons button")) button.addEventListener("click", () => change({ run: button.value }));
element("run")?.addEventListener("change", (event) => change({ run: event.target.value }));
for (const chapter of chapters()) chapter.addEventListener("toggle", () => {
  if (onPaper()) return;
  if (chapter.open && state.chapter !== chapter.id) [state.chapter, state.section] = [chapter.id, ""];
  else if (!chapter.open && state.chapter === chapter.id) [state.chapter, state.section] = ["", ""];
  if (chapter.open) showPlots();
  writeAddress();
});
for (const part of document.querySelectorAll("details:not(.chapter)")) part.addEventListener("toggle", () => { if (part.open) showPlots(); });
window.addEventListener("hashchange", follow);
window.addEventListener("resize", () => { if (motion) moveTo(state.at); showPlots(); });
dark.addEventListener("change", () => show());

async function start() {
  if (!("DecompressionStream" in window)) {
    element("nothing").hidden = false;
    element("nothing").textContent = "This browser cannot unpack the motion: a browser of 2023 or later is needed. The tables below and the CSV files are complete.";
    return;
  }
  const { wanted, at } = readAddress(location.hash);
  await change(wanted);
  const wish = motion.turnSeconds ? 6 / motion.turnSeconds : 1;
  element("speed").value = SPEEDS.findLast((times) => times <= Math.max(1, wish)) ?? 1;
  if (wanted.chapter) openChapter(wanted.chapter, wanted.section);
  document.documentElement.dataset.ready = "true";
  if (!at && !still.matches) play();
}
start();
