/** References: copies of traces at one moment, for comparison with later samples. */

import { clockText } from "../base/clock.js";
import { typed } from "../base/numbers.js";
import { lineOf } from "./persistence.js";

/** Most references. */
export const MOST = 8;

/**
 * @typedef {Object} Reference
 * @property {string} name R1, R2 and so on
 * @property {string} field its original trace; it has its plot, axis and colour, and is removed with it
 * @property {Map<string, string>} figures its figures in the table
 * @property {import("./buffer.js").TraceBuffer} buffer
 * @property {number} zero zero of its times, since the epoch [s]
 * @property {number} from its start, relative to zero [s]
 * @property {number} to its end, relative to zero [s]
 * @property {number} later its shift to the right [s]
 * @property {number} offset added to its values
 * @property {Map<string, import("./persistence.js").Line>} lines its lines, by field
 */

function withLine(one) {
  const { buffer, field, zero, from, to, later, offset } = one;
  const { points, steps } = lineOf(buffer, field, zero, from, to);
  const moved = points.map((number, place) => number + (place % 2 ? offset : later));
  return { ...one, lines: new Map([[field, { points: moved, steps }]]) };
}

/**
 * Return a reference under a new name of its trace; its samples stay.
 * @param {Reference} one
 * @param {string} field
 * @returns {Reference}
 */
export const withField = (one, field) =>
  withLine({ ...one, field, buffer: one.buffer.copy([one.field], () => field) });

/** Remove references together with their traces. */
export function startReferences(state) {
  state.on(["fields"], ({ fields, references }) => {
    const left = references.filter(({ field }) => fields.includes(field));
    if (left.length < references.length) state.set({ references: left });
  });
}

/** Whether a trace can be kept: it is visible, and the limit is not reached. */
export const canKeep = ({ hidden, references }, field) => !hidden.has(field) && references.length < MOST;

/**
 * Keep a trace as a reference.
 * @param {import("./store.js").State} state
 * @param {{buffer: import("./buffer.js").TraceBuffer, reference: number, from: number, to: number}} shown
 * @param {string} field
 * @param {Map<string, string>} figures its figures in the table
 */
export function keepReference(state, { buffer, reference: zero, from, to }, field, figures) {
  const { references } = state.values;
  const names = references.map(({ name }) => name);
  let number = 1;
  while (names.includes(`R${number}`)) number += 1;
  const one = {
    name: `R${number}`, field, figures, buffer: buffer.copy([field]), zero,
    from: from - zero, to: to - zero, later: 0, offset: 0,
  };
  state.set({ references: [...references, withLine(one)] });
}

/**
 * Move a reference.
 * @param {import("./store.js").State} state
 * @param {string} name
 * @param {{later: ?number, offset: ?number}} changes
 */
export function moveReference(state, name, changes) {
  const moved = (one) => (one.name === name ? withLine({ ...one, ...changes }) : one);
  state.set({ references: state.values.references.map(moved) });
}

/** Remove a reference. */
export function removeReference(state, name) {
  state.set({ references: state.values.references.filter((one) => one.name !== name) });
}

/**
 * Return the value of a reference, as drawn.
 * @param {Reference} one
 * @param {number} time on the time axis [s]
 * @returns {?{low: number, high: number, uncertainty: ?number, count: ?number}} as of the buffer; null
 *   where it has none
 */
export function valueOf({ buffer, field, zero, from, to, later, offset }, time) {
  const at = time - later;
  const found = at >= from && at <= to ? buffer.at(field, zero + at) : null;
  return found && { ...found, low: found.low + offset, high: found.high + offset };
}

/** Text with the time of a reference's right edge. */
export const keptText = ({ zero, to }) => `kept ${clockText(zero + to, 1)}`;

/** Describe a reference for a picture. */
export function referenceText(one) {
  const { name, field, later, offset } = one;
  const plus = offset === 0 ? "" : `, ${offset < 0 ? "−" : "+"} ${typed(Math.abs(offset), 6)}`;
  const moved = later === 0 ? "" : `, ${typed(later, 6).replace("-", "−")} s later`;
  return `${name}: ${field}, ${keptText(one)}${plus}${moved}`;
}
