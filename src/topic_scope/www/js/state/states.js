/** Traces that are states: texts over time, as the server sends them. */

const SEVERAL = -1; // place of the text where many states change in a short time

/** Whether the name of a trace is that of a state. */
export const isState = (field) =>
  !field.startsWith("=") && /\.state(@[^@]*)?$/.test(field.replace(/"[^"]*"|\[[^\]]*\]/g, ""));

/** Those of some fields that are numbers. */
export const numbersOf = (fields) => fields.filter((field) => !isState(field));

/**
 * @typedef {Object} Span
 * @property {number} from since the epoch [s]
 * @property {number} to until when this is known [s]
 * @property {boolean} isOpen whether it goes on
 * @property {boolean} isEarlier whether it may have begun before
 * @property {string} text of the state, or how many there are
 * @property {boolean} isSeveral whether these are several
 */

/**
 * Return the spans of a state.
 * @param {?{until: number, traces: Object<string, Object>}} states latest message of the server
 * @param {string} field
 * @returns {Span[]} in the order of time
 */
export function spansOf(states, field) {
  const told = states?.traces[field];
  if (!told) return [];
  return told.spans.map(([from, end, place, count], index) => ({
    from,
    to: end ?? states.until,
    isOpen: end === null,
    isEarlier: index === 0 && told.earlier,
    text: place === SEVERAL ? `${count} states` : told.texts[place],
    isSeveral: place === SEVERAL,
  }));
}

/** Return the span at a time; undefined where nothing is known. */
export const spanAt = (spans, time) =>
  spans.find(({ from, to, isOpen }) => time >= from && (time < to || (isOpen && time === to)));

/**
 * Return the place of a text's colour: always the same one.
 * @param {string} text
 * @returns {number} from 0
 */
export function placeOf(text) {
  let place = 0;
  for (const letter of text) place = (Math.imul(place, 31) + letter.codePointAt(0)) >>> 0;
  return place;
}
