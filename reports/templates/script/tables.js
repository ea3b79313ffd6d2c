// Tables: sorted by a heading, filtered by words; remarks of their cells.

for (const button of document.querySelectorAll("button.sort")) button.addEventListener("click", () => {
  const head = button.closest("th"), table = head.closest("table"), body = table.tBodies[0];
  const index = [...head.parentElement.children].indexOf(head), falling = head.getAttribute("aria-sort") === "ascending";
  for (const other of head.parentElement.children) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", falling ? "descending" : "ascending");
  const value = (row) => row.cells[index].dataset.value ?? "";
  const numeric = [...body.rows].every((row) => value(row) === "" || Number.isFinite(Number(value(row))));
  const compared = (a, b) => numeric ? Number(a) - Number(b) : a.localeCompare(b);
  const sorted = [...body.rows].sort((a, b) => {
    const [x, y] = [value(a), value(b)];
    if (x === "" || y === "") return (x === "") - (y === "");  // what is not there comes last
    return falling ? compared(y, x) : compared(x, y);
  });
  body.replaceChildren(...sorted);
});

for (const field of document.querySelectorAll("input.filter")) field.addEventListener("input", () => {
  const words = field.value.toLowerCase().replaceAll("\u00a0", " ").split(/\s*,\s*|\s{2,}/).filter(Boolean);
  const table = [...document.querySelectorAll("table")].find((found) => found.dataset.file === field.dataset.table);
  for (const row of table.tBodies[0].rows) {
    const text = row.textContent.toLowerCase().replaceAll("\u00a0", " ");
    row.hidden = !words.every((word) => text.includes(word));
  }
});

// Remarks of cells: a title shows them to a mouse alone, a click or a touch to everybody.

const remark = document.getElementById("remark");
for (const cell of document.querySelectorAll("button.remark")) cell.addEventListener("click", () => {
  remark.firstElementChild.textContent = `${cell.textContent}: ${cell.title}`;
  remark.hidden = false;
});
const closed = () => { remark.hidden = true; };
remark.querySelector("button").addEventListener("click", closed);
document.addEventListener("keydown", (event) => { if (event.key === "Escape") closed(); });
