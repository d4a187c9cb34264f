/** CSV and PNG of what is visible. */

import { make } from "./dom.js";

const BELOW = 26; // pixels for the legend of a picture

/**
 * The address of the samples that are visible, at full resolution.
 * @param {string[]} fields
 * @param {{from: number, to: number}} shown since the epoch, s
 * @returns {string}
 */
export function csvAddress(fields, { from, to }) {
  const query = new URLSearchParams(fields.map((field) => ["field", field]));
  query.append("start", from);
  query.append("end", to);
  return `/data.csv?${query}`;
}

/** Write the labels that dygraphs has put beside its canvas. */
function drawLabels(context, box, element) {
  for (const label of element.querySelectorAll(".dygraph-axis-label, .dygraph-label")) {
    const place = label.getBoundingClientRect();
    const style = getComputedStyle(label);
    const upright = label.classList.contains("dygraph-ylabel") ? -1 : label.classList.contains("dygraph-y2label") ? 1 : 0;
    context.save();
    context.fillStyle = style.color;
    context.font = `${style.fontSize} ${style.fontFamily}`;
    context.translate(place.left - box.left + place.width / 2, place.top - box.top + place.height / 2);
    context.rotate((upright * Math.PI) / 2);
    context.textAlign = upright ? "center" : style.textAlign === "right" ? "right" : style.textAlign === "left" ? "left" : "center";
    const shift = context.textAlign === "right" ? place.width / 2 : context.textAlign === "left" ? -place.width / 2 : 0;
    context.textBaseline = "middle";
    context.fillText(label.textContent, shift, 0);
    context.restore();
  }
}

function drawLegend(context, fields, colourOf, top, style) {
  let left = 12;
  context.font = `12px ${style.fontFamily}`;
  context.textBaseline = "middle";
  for (const field of fields) {
    context.fillStyle = colourOf(field);
    context.fillRect(left, top + 5, 14, 4);
    context.fillStyle = style.color;
    context.fillText(field, left + 20, top + 7);
    left += context.measureText(field).width + 40;
  }
}

/**
 * Make a picture of the plot with its axes and a legend.
 * @param {import("./plots.js").Plots} plot
 * @param {string[]} fields
 * @param {function(string): string} colourOf
 * @returns {HTMLCanvasElement}
 */
export function picture(plot, fields, colourOf) {
  const box = plot.element.getBoundingClientRect();
  const scale = window.devicePixelRatio || 1;
  const canvas = make("canvas", {
    width: Math.round(box.width * scale),
    height: Math.round((box.height + BELOW) * scale),
  });
  const context = canvas.getContext("2d");
  context.scale(scale, scale);
  context.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--screen");
  context.fillRect(0, 0, box.width, box.height + BELOW);
  for (const layer of plot.canvases) {
    const { left, top, width, height } = layer.getBoundingClientRect();
    context.drawImage(layer, left - box.left, top - box.top, width, height);
  }
  drawLabels(context, box, plot.element);
  drawLegend(context, fields, colourOf, box.height + 4, getComputedStyle(document.body));
  return canvas;
}

/**
 * Have the browser save a picture.
 * @param {HTMLCanvasElement} canvas
 * @param {string} name of the file
 */
export function save(canvas, name) {
  canvas.toBlob((blob) => {
    const address = URL.createObjectURL(blob);
    make("a", { href: address, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(address), 10000);
  });
}
