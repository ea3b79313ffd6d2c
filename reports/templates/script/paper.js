// Printing: the page laid out for a sheet.

let opened = [];  // for printing

/** On paper everything is laid out for its width, in light colours: the chapters that are open, or all of them; what is folded in them stays so. */
window.addEventListener("beforeprint", () => {
  if (onPaper()) return;
  pause();
  document.documentElement.dataset.print = "";
  const printed = chapters().some((chapter) => chapter.open) ? chapters().filter((chapter) => chapter.open) : chapters();
  opened = printed.filter((chapter) => !chapter.open);
  for (const found of opened) found.open = true;
  if (motion) show();
  if (motion?.engines.length) stills();
});
window.addEventListener("afterprint", () => {
  for (const found of opened) found.open = false;
  delete document.documentElement.dataset.print;
  if (motion) show();
});

/** On paper nothing moves: four instants of the motion instead. */
function stills() {
  element("stills").replaceChildren(...[0, 1, 2, 3].map(() => document.createElement("canvas")));
  for (const [k, canvas] of [...element("stills").children].entries()) {
    canvas.style.cssText = "width:420px;height:240px";
    const still = new Stage(canvas, engineColour), at = motion.span * k / 4;
    document.body.append(canvas);  // a canvas that is not laid out has no size
    still.show(motion, drawnOrder(), factor, looks, state.stress ? runOf(state.run).stress : null);
    still.draw(at);
    canvas.setAttribute("aria-label", curve.cursorText(at));
    element("stills").append(canvas);
    canvas.style.cssText = "";
  }
}
