/** Range of a slider: the part of the allowed range that suits the value. */

import { niceStep, short } from "../base/numbers.js";

const WIDEST = 40; // multiple of the value; of a wider range only a part is shown
const DEFAULT_END = 10; // without a bound or a value

/**
 * Choose the ends and the step of a slider.
 * @param {Object} parameter as the server describes it
 * @param {number} value
 * @returns {{low: number, high: number, step: number}}
 */
export function travel(parameter, value) {
  const whole = parameter.kind === "int";
  const bottom = parameter.minimum ?? parameter.above ?? -Infinity;
  const top = parameter.maximum ?? parameter.below ?? Infinity;
  const size = Math.abs(value);
  const end = size > 0 ? niceStep(2 * size) : DEFAULT_END;
  const wide = !(top - bottom <= WIDEST * (size || DEFAULT_END));
  const high = wide ? Math.min(top, Math.max(end, bottom + end)) : top;
  const low = wide ? Math.max(bottom, Math.min(-end, top - end)) : bottom;
  const step = whole ? Math.max(1, niceStep((high - low) / 400)) : niceStep((high - low) / 400);
  return {
    low: parameter.above === low ? low + step : low,
    high: parameter.below === high ? high - step : high,
    step,
  };
}

/**
 * Return whether a slider needs other ends for a value.
 * @param {{low: number, high: number}} ends in use
 * @param {{low: number, high: number}} wanted for the value
 * @param {number} value
 * @returns {boolean}
 */
export function isPoor(ends, wanted, value) {
  const reach = Math.max(Math.abs(ends.low), Math.abs(ends.high));
  const ideal = Math.max(Math.abs(wanted.low), Math.abs(wanted.high));
  const atAnEnd = value >= ends.high && wanted.high > ends.high;
  const belowAnEnd = value <= ends.low && wanted.low < ends.low;
  return atAnEnd || belowAnEnd || reach > 12 * ideal;
}

/**
 * Describe the allowed range.
 * @param {Object} parameter as the server describes it
 * @returns {string} empty if unlimited
 */
export function allowed({ minimum, maximum, above, below }) {
  const has = (bound) => bound !== null && bound !== undefined;
  const low = has(minimum) ? `from ${short(minimum)}` : has(above) ? `above ${short(above)}` : "";
  const high = has(maximum) ? `to ${short(maximum)}` : has(below) ? `below ${short(below)}` : "";
  return [low, high].filter(Boolean).join(" ");
}
