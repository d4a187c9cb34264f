/** References behind the traces, thin and pale, each with its name at its start. */

const PALE = 0.6; // of the colour
const LABEL = 11; // height of the name, pixels

/**
 * Draw.
 * @param {CanvasRenderingContext2D} context
 * @param {{x: number, y: number, w: number, h: number}} area where traces are
 * @param {import("../state/references.js").Reference[]} references
 * @param {string[]} fields of the plot
 * @param {{colourOf: function(string): string, across: function(number): number,
 *   up: function(string, number): number}} plot colour of a field; position of a time, and of a
 *   field's value
 */
export function drawReferences(context, area, references, fields, { colourOf, across, up }) {
  context.save();
  context.beginPath();
  context.rect(area.x, area.y, area.w, area.h);
  context.clip();
  context.lineWidth = 1;
  context.lineJoin = "round";
  context.font = `${LABEL}px ${getComputedStyle(document.body).fontFamily}`;
  for (const { name, field, lines } of references.filter((one) => fields.includes(one.field))) {
    const colour = colourOf(field);
    Object.assign(context, { strokeStyle: colour, fillStyle: colour, globalAlpha: PALE });
    context.beginPath();
    const begin = follow(context, lines.get(field), across, (value) => up(field, value), area.x);
    context.stroke();
    context.globalAlpha = 1;
    if (begin) context.fillText(name, begin[0] + 3, Math.max(begin[1] - LABEL / 2, area.y + LABEL));
  }
  context.restore();
}

/** Make the path of a line, and return its first point after the left edge. */
function follow(context, { points, steps }, across, up, left) {
  let before = NaN; // height of the line; NaN initially, and after its end
  let begin = null;
  for (let place = 0; place < points.length; place += 2) {
    const [x, y] = [across(points[place]), up(points[place + 1])];
    if (!Number.isNaN(before) && steps) context.lineTo(x, before);
    if (!Number.isNaN(y)) context[Number.isNaN(before) ? "moveTo" : "lineTo"](x, y);
    if (!begin && x >= left && !Number.isNaN(y)) begin = [x, y];
    before = y;
  }
  return begin;
}
