// Signals from their packed form (reports/page/packing.py).

/** The bytes of an element that holds deflated content in base64. */
async function inflated(id) {
  const text = document.getElementById(id).textContent.trim();
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Engine -> column -> values of one run. */
async function unpack(id, layouts) {
  const bytes = await inflated(id);
  const tables = {};
  let at = 0;
  for (const [engine, { rows, columns }] of Object.entries(layouts)) {
    tables[engine] = {};
    for (const [name, low, step, planes] of columns) {
      tables[engine][name] = columnOf(bytes, at, rows, low, step, planes);
      at += rows * planes;
    }
  }
  return tables;
}

function columnOf(bytes, at, rows, low, step, planes) {
  const mask = 2 ** (8 * planes) - 1;
  const values = new Float64Array(rows);
  let second = 0, first = 0, value = 0;  // sums of the third differences
  for (let row = 0; row < rows; row++) {
    let zigzag = 0;
    for (let plane = planes - 1; plane >= 0; plane--) zigzag = zigzag * 256 + bytes[at + plane * rows + row];
    second = (second + ((zigzag >>> 1) ^ -(zigzag & 1))) & mask;
    first = (first + second) & mask;
    value = (value + first) & mask;
    values[row] = low + step * value;
  }
  return values;
}
