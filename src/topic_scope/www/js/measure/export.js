/** What of the visible is saved as a file. */

import { make } from "../base/dom.js";

/**
 * The address of the samples that are visible, at full resolution.
 * @param {string[]} fields
 * @param {{from: number, to: number}} shown since the epoch, s
 * @returns {string}
 */
export function csvAddress(fields, { from, to }) {
  const query = new URLSearchParams(fields.map((field) => ["field", field]));
  query.append("start", Math.max(0, from)); // which is before all time as long as there is no sample
  query.append("end", to);
  return `/data.csv?${query}`;
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
