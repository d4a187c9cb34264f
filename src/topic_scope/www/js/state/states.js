/** Traces that are states: texts over time, as the server sends them. */

import { bare } from "../base/names.js";

const SEVERAL = -1; // index of the text for many short states

/** Whether a name denotes a state. */
export const isState = (field) => !field.startsWith("=") && /\.state(@[^@]*)?$/.test(bare(field));

/** Return the numeric fields. */
export const numbersOf = (fields) => fields.filter((field) => !isState(field));

/**
 * @typedef {Object} Span
 * @property {number} from since the epoch [s]
 * @property {number} to its end, or the time up to which it is known [s]
 * @property {boolean} isOpen whether it continues
 * @property {boolean} isEarlier whether it may have begun before
 * @property {string} text text of the state, or the number of states
 * @property {boolean} isSeveral whether these are several states
 */

/**
 * Return the spans of a state.
 * @param {?{until: number, traces: Object<string, Object>}} states latest message of the server
 * @param {string} field
 * @returns {Span[]} in time order
 */
export function spansOf(states, field) {
  const trace = states?.traces[field];
  if (!trace) return [];
  return trace.spans.map(([from, end, place, count], index) => ({
    from,
    to: end ?? states.until,
    isOpen: end === null,
    isEarlier: index === 0 && trace.earlier,
    text: place === SEVERAL ? `${count} states` : trace.texts[place],
    isSeveral: place === SEVERAL,
  }));
}

/** Return the span at a time; undefined if unknown. */
export const spanAt = (spans, time) =>
  spans.find(({ from, to, isOpen }) => time >= from && (time < to || (isOpen && time === to)));

/**
 * Return the palette index of a text's colour, always the same.
 * @param {string} text
 * @returns {number} from 0
 */
export function placeOf(text) {
  let place = 0;
  for (const letter of text) place = (Math.imul(place, 31) + letter.codePointAt(0)) >>> 0;
  return place;
}
