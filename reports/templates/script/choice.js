// One plot of several: the reader chooses which.

for (const choices of document.querySelectorAll(".choices")) choices.addEventListener("change", (event) => {
  [...choices.querySelectorAll(":scope > div")].forEach((plot, k) => { plot.hidden = k !== Number(event.target.value); });
  showPlots();
});
