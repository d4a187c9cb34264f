/** Numbers: rounding, ticks and formatting. */

/**
 * Round up to 1, 2 or 5 times a power of ten.
 * @param {number} value above 0
 * @returns {number}
 */
export function niceStep(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  const step = [1, 2, 5, 10].find((candidate) => lead <= candidate * (1 + 1e-9));
  return step * power;
}

/**
 * Format a number of an axis, with the decimals that its step needs.
 * @param {number} value
 * @param {number} step distance of the ticks
 * @returns {string}
 */
export function tickText(value, step) {
  if (Math.abs(value) < step * 1e-6) return "0";
  if (Math.abs(value) >= 1e6 || step < 1e-5) {
    const digits = Math.max(0, Math.floor(Math.log10(Math.abs(value))) - Math.floor(Math.log10(step)));
    return minus(value.toExponential(Math.min(digits, 15)));
  }
  const places = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return minus(value.toFixed(places));
}

/**
 * Round to the resolution of a screen.
 * @param {number} value
 * @param {number} span from one end of the axis to the other
 * @returns {number}
 */
export function rounded(value, span) {
  const step = 10 ** Math.floor(Math.log10(span / 500));
  return Number((Math.round(value / step) * step).toPrecision(10));
}

/**
 * List round places between two bounds.
 * @param {number} low
 * @param {number} high
 * @param {number} most maximum number
 * @returns {{v: number, label: string}[]} as dygraphs takes them
 */
export function ticks(low, high, most) {
  const step = niceStep((high - low) / Math.max(1, most));
  const list = [];
  if (!(step > 0) || !Number.isFinite(step)) return list;
  for (let index = Math.ceil(low / step - 1e-9); index * step <= high + step * 1e-9; index += 1) {
    list.push({ v: index * step, label: tickText(index * step, step) });
  }
  return list;
}

/**
 * Format a measured number with some significant digits, and with more if its trace varies by
 * less than their resolution.
 * @param {?number} value
 * @param {number} [digits]
 * @param {?number} [spread] from the least to the greatest value of the trace
 * @returns {string} a dash without a number
 */
export function figure(value, digits = 5, spread = null) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (spread > 0 && spread < size * 10 ** (3 - digits)) {
    const places = 2 - Math.floor(Math.log10(spread));
    const most = 15 - Math.floor(Math.log10(size)); // precision of a float
    return minus(value.toFixed(Math.max(0, Math.min(places, most, 15))));
  }
  if (size !== 0 && (size >= 1e7 || size < 1e-4)) return minus(value.toExponential(digits - 2));
  const order = Math.floor(Math.log10(size)) + 1; // number of digits before the point
  const before = size === 0 || size >= 0.01 ? Math.max(order, 1) : order + 2;
  return minus(value.toFixed(Math.max(0, digits - before)));
}

/**
 * Format a reading of a line: one value, with an uncertainty that is larger than its last digit, or the
 * minimum and maximum of a pixel.
 * @param {?{low: number, high: number, uncertainty: ?number, count: ?number}} reading
 * @param {?number} spread as of {@link figure}
 * @returns {{value: string, uncertainty: string}} a dash without a value; the latter may be empty
 */
export function readingText(reading, spread) {
  if (!reading) return { value: figure(null), uncertainty: "" };
  const { low, high, uncertainty, count } = reading;
  const [from, to] = [low, high].map((value) => figure(value, 5, spread));
  if (low !== high) return { value: `${count ? `${count} samples, ` : ""}${from} … ${to}`, uncertainty: "" };
  const [digits, exponent = 0] = from.split("e");
  const lastDigit = 10 ** (exponent - (digits.split(".")[1] ?? "").length);
  return uncertainty > lastDigit ? measuredText(low, uncertainty) : { value: from, uncertainty: "" };
}

/**
 * Format a measured number and its uncertainty: two significant digits of the uncertainty decide the
 * decimals of both.
 * @param {?number} value
 * @param {number} uncertainty in the same unit; 0 for an exact number
 * @returns {{value: string, uncertainty: string}} the latter is empty for an exact number
 */
export function measuredText(value, uncertainty) {
  if (!Number.isFinite(value) || !(uncertainty > 0) || !Number.isFinite(uncertainty)) {
    return { value: figure(value), uncertainty: "" };
  }
  const [, exponent] = uncertainty.toExponential(1).split("e");
  const places = 1 - Number(exponent); // after the point
  const largest = Math.max(Math.abs(value), uncertainty);
  if (largest >= 1e7 || places > 9) {
    const digits = (number) => Math.floor(Math.log10(Math.abs(number) || uncertainty)) + places;
    const text = (number) => minus(number.toExponential(Math.max(0, Math.min(digits(number), 15))));
    return { value: text(value), uncertainty: uncertainty.toExponential(1) };
  }
  const step = 10 ** -Math.min(places, 0);
  const text = (number) => minus((Math.round(number / step) * step).toFixed(0));
  const fixed = (number) => (places > 0 ? minus(number.toFixed(places)) : text(number));
  return { value: fixed(value), uncertainty: fixed(uncertainty) };
}

/**
 * Format a value as a user would type it.
 * @param {number} value
 * @param {number} [digits] maximum number
 * @returns {string}
 */
export function typed(value, digits = 12) {
  return String(Number(value.toPrecision(digits)));
}

/**
 * Format a bound in few characters.
 * @param {number} value
 * @returns {string}
 */
export function short(value) {
  const digits = Number(value.toPrecision(4));
  const long = Math.abs(digits) >= 1e5;
  return minus(long ? digits.toExponential().replace("e+", "e") : String(digits));
}

/**
 * Parse a number that a user typed.
 * @param {string} text with a decimal point; a comma would be ambiguous
 * @returns {?number} null for no text, NaN for something else
 */
export function readNumber(text) {
  const trimmed = text.trim().replace("−", "-");
  return trimmed === "" ? null : Number(trimmed);
}

/**
 * Explain why a number with a comma is rejected.
 * @param {string} text typed text
 * @returns {string} a sentence; empty without a comma
 */
export const ambiguity = (text) => (text.includes(",")
  ? `${text.trim()} is ambiguous: write numbers without commas, such as 1000 or 2.5.` : "");

/** Clamp a number to two bounds. */
export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

const minus = (text) => text.replace(/^-/, "−");

/**
 * Return the range of an axis with a set end; set ends in the wrong order are ignored.
 * @param {?number} low set lower end; null: automatic
 * @param {?number} high set upper end
 * @param {[number, number]} range the automatic one; a set end beyond it keeps its length
 * @returns {[number, number]}
 */
export function rangeWith(low, high, [from, to]) {
  const length = Math.max(to - from, Math.abs(low ?? high ?? 0) * 1e-9);
  if (high === null) return low === null || low < to ? [low ?? from, to] : [low, low + length];
  if (low === null) return [from < high ? from : high - length, high];
  return low < high ? [low, high] : [from, to];
}

const SHRINK_AFTER_S = 2.5;

/** Automatic range with round ends; it grows immediately and shrinks with a delay. */
export class AutoRange {
  constructor() {
    this.range = null;
    this.roomy = null; // time since when the values have needed much less
  }

  /**
   * @param {number} low smallest value; infinite without values
   * @param {number} high largest value
   * @param {number} now s
   * @returns {[number, number]}
   */
  update(low, high, now) {
    if (!(low <= high)) return this.range || [-1, 1];
    const [from, to] = this.range || [Infinity, -Infinity];
    const edge = 0.015 * (high - low);
    const fits = low - edge >= from && high + edge <= to;
    if (!fits || (high - low) * 2.5 > to - from) this.roomy = null;
    else if (this.roomy === null) this.roomy = now;
    if (fits && (this.roomy === null || now - this.roomy < SHRINK_AFTER_S)) return this.range;
    const span = high - low || Math.abs(high) * 0.2 || 2;
    const margin = high > low ? 0.04 * span : 0.5 * span;
    const step = niceStep(span / 10);
    this.roomy = null;
    this.range = [Math.floor((low - margin) / step) * step, Math.ceil((high + margin) / step) * step];
    return this.range;
  }
}
