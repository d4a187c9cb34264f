/** Picture for a report: the plot, its cursors and measurements. */

import { clockText, zoneText } from "../base/clock.js";
import { make, themeColour } from "../base/dom.js";

const RATIO = 2; // least number of picture pixels per page pixel
const LINE = 17; // height of a line of text, pixels
const COLUMN = 70; // width of a figure
const EDGE = 12;
const SWATCH = 30; // width of a line sample, and the space after it

const TURNED = { "dygraph-ylabel": -1, "dygraph-y2label": 1 }; // titles, quarter turns

/** Call a function while the plots are drawn at a higher resolution than the screen. */
function sharply(drawn, ratio, act) {
  const own = Object.getOwnPropertyDescriptor(window, "devicePixelRatio");
  Object.defineProperty(window, "devicePixelRatio", { value: ratio, configurable: true });
  try {
    drawn.redraw();
    act();
  } finally {
    Object.defineProperty(window, "devicePixelRatio", own);
    drawn.redraw();
  }
}

/** Draw the labels that dygraphs places beside its canvas. */
function drawLabels(context, box, element) {
  for (const label of element.querySelectorAll(".dygraph-axis-label, .dygraph-label")) {
    const place = label.getBoundingClientRect();
    const style = getComputedStyle(label);
    const upright = [...label.classList].reduce((turn, name) => TURNED[name] ?? turn, 0);
    context.save();
    context.fillStyle = style.color;
    context.font = `${style.fontSize} ${style.fontFamily}`;
    context.translate(place.left - box.left + place.width / 2, place.top - box.top + place.height / 2);
    context.rotate((upright * Math.PI) / 2);
    const shift = (!upright && { left: -place.width / 2, right: place.width / 2 }[style.textAlign]) || 0;
    context.textAlign = shift ? style.textAlign : "center";
    context.textBaseline = "middle";
    context.fillText(label.textContent, shift, 0);
    context.restore();
  }
}

/** Draw the lines over the plot: cursors, and the trigger level. */
function drawHandles(context, box, overlay) {
  const area = overlay.getBoundingClientRect();
  context.textBaseline = "middle";
  context.textAlign = "left";
  for (const handle of overlay.querySelectorAll(".handle:not([hidden])")) {
    const place = handle.getBoundingClientRect();
    const upright = handle.classList.contains("cursor");
    const [x, y] = [place.left + place.width / 2 - box.left, place.top + place.height / 2 - box.top];
    context.save();
    const colour = themeColour(handle.classList.contains("level") ? "trigger" : "cursor");
    Object.assign(context, { strokeStyle: colour, fillStyle: colour });
    context.setLineDash([4, 4]);
    context.beginPath();
    context.moveTo(upright ? x : area.left - box.left, upright ? area.top - box.top : y);
    context.lineTo(upright ? x : area.right - box.left, upright ? area.bottom - box.top : y);
    context.stroke();
    const text = handle.textContent;
    if (upright) context.fillText(text, x + 4, area.bottom - box.top - 10);
    else context.fillText(text, area.right - box.left - context.measureText(text).width - 4, y - 8);
    context.restore();
  }
}

/**
 * Break a name into lines of limited width, after a slash if possible.
 * @param {string} name
 * @param {number} most largest width
 * @param {function(string): number} widthOf
 * @returns {string[]}
 */
export function wrapped(name, most, widthOf) {
  const lines = [""];
  for (const part of name.match(/\/?[^/]+|\//g) || []) {
    if (lines[lines.length - 1] && widthOf(lines[lines.length - 1] + part) > most) lines.push("");
    for (const letter of part) {
      if (lines[lines.length - 1] && widthOf(lines[lines.length - 1] + letter) > most) lines.push("");
      lines[lines.length - 1] += letter;
    }
  }
  return lines;
}

/** Contents of the page's table: heads, and measurements of each trace. */
function tableOf(fields) {
  const cells = (row) => [...row.querySelectorAll("[data-cell]")].map((cell) => cell.textContent);
  const rows = [...document.querySelectorAll("#legend tr")].filter((row) => fields.includes(row.dataset.field));
  const heads = [...document.querySelectorAll("#legend-head .figure")].map((head) => head.textContent);
  return { heads, rows: rows.map((row) => ({ field: row.dataset.field, figures: cells(row) })) };
}

/** Break the readout of the cursors at its gaps, and otherwise like a name. */
function fitted(text, most, widthOf) {
  const lines = [];
  for (const part of text.split(/\s{3,}/)) {
    const longer = lines.length ? `${lines[lines.length - 1]}   ${part}` : "";
    if (longer && widthOf(longer) <= most) lines[lines.length - 1] = longer;
    else lines.push(...wrapped(part, most, widthOf));
  }
  return lines;
}

/**
 * Return the text below the plot: a legend with figures, the readout of the cursors, the date.
 * Figures that do not fit beside the others are placed below them, with the names repeated.
 */
function below(context, fields, width, texts, labelOf) {
  const widthOf = (text) => context.measureText(text).width;
  const { heads, rows } = tableOf(fields);
  const right = width - EDGE;
  const shown = Math.max(1, Math.min(heads.length, Math.floor((right - 190) / COLUMN)));
  const room = right - shown * COLUMN - EDGE - SWATCH - 8;
  const names = rows.map(({ field }) => wrapped(labelOf(field), room, widthOf));
  const blocks = [];
  for (let first = 0; first < Math.max(1, heads.length); first += shown) {
    const part = (cells) => cells.slice(first, first + shown);
    blocks.push({
      heads: part(heads),
      lines: rows.map(({ field, figures }, place) => ({ field, names: names[place], figures: part(figures) })),
    });
  }
  const notes = texts.flatMap((text) => fitted(text, right - EDGE, widthOf));
  const each = names.reduce((sum, lines) => sum + lines.length, 1);
  return { blocks, notes, columns: shown, height: (blocks.length * each + notes.length) * LINE + 10 };
}

function drawSample(context, y, colour, dash) {
  context.save();
  Object.assign(context, { strokeStyle: colour, lineWidth: 2.5 });
  context.setLineDash(dash);
  context.beginPath();
  context.moveTo(EDGE, y);
  context.lineTo(EDGE + SWATCH - 6, y);
  context.stroke();
  context.restore();
}

function drawBelow(context, { blocks, notes, columns }, top, width, { colourOf, dashOf }) {
  const right = width - EDGE;
  const writeFigures = (texts, y) => texts.forEach((text, place) => {
    context.textAlign = "right";
    context.fillText(text, right - (columns - 1 - place) * COLUMN, y);
  });
  let y = top - LINE / 2 + 2;
  context.textBaseline = "middle";
  for (const { heads, lines } of blocks) {
    y += LINE;
    context.fillStyle = themeColour("muted");
    writeFigures(heads, y);
    for (const { field, names, figures } of lines) {
      y += LINE;
      drawSample(context, y, colourOf(field), dashOf(field));
      context.fillStyle = themeColour("text");
      writeFigures(figures, y);
      context.textAlign = "left";
      names.forEach((name, place) => context.fillText(name, EDGE + SWATCH, y + place * LINE));
      y += (names.length - 1) * LINE;
    }
  }
  context.fillStyle = themeColour("muted");
  context.textAlign = "left";
  for (const note of notes) {
    y += LINE;
    context.fillText(note, EDGE, y);
  }
}

/**
 * Make a picture of the plot with its axes, cursors, legend, measurements and date.
 * @param {import("../plot/stack.js").Plots|import("../plot/canvas_chart.js").Chart} drawn
 * @param {string[]} fields that are shown
 * @param {{colourOf: function(string): string, dashOf: function(string): number[],
 *   labelOf: function(string): string, notes: string[]}} style of fields, and additional notes
 * @param {number} until the right edge of the view, since the epoch [s]
 * @returns {HTMLCanvasElement}
 */
export function picture(drawn, fields, style, until) {
  const ratio = Math.max(RATIO, window.devicePixelRatio || 1);
  const box = drawn.element.getBoundingClientRect();
  const overlay = document.getElementById("overlay");
  const readouts = overlay.hidden ? [] : [...overlay.querySelectorAll(".readout:not([hidden])")];
  const date = new Date(until * 1000).toLocaleDateString("sv"); // year first
  const texts = [...readouts.map(({ textContent }) => textContent), ...style.notes];
  texts.push(`${date}, ${clockText(until, 0.1)}, ${zoneText(until)}`);
  const canvas = make("canvas", {});
  const context = canvas.getContext("2d");
  context.font = `12px ${getComputedStyle(document.body).fontFamily}`;
  const table = below(context, fields, box.width, texts, style.labelOf);
  const bands = drawn.canvases.length > 1 ? document.getElementById("bands") : null;
  const plots = box.height + (bands?.offsetHeight || 0);
  const height = plots + table.height;
  sharply(drawn, ratio, () => {
    Object.assign(canvas, { width: Math.round(box.width * ratio), height: Math.round(height * ratio) });
    context.scale(ratio, ratio);
    context.fillStyle = themeColour("screen");
    context.fillRect(0, 0, box.width, height);
    for (const layer of [...drawn.canvases, ...(bands?.querySelectorAll("canvas") || [])]) {
      const place = layer.getBoundingClientRect();
      context.drawImage(layer, place.left - box.left, place.top - box.top, place.width, place.height);
    }
    drawLabels(context, box, drawn.element);
    context.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    if (!overlay.hidden) drawHandles(context, box, overlay);
    drawBelow(context, table, plots, box.width, style);
  });
  return canvas;
}
