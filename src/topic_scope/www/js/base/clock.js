/** Time of day in this computer's time zone, with the name of the zone. */

import { niceStep } from "./numbers.js";

const STEPS = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600]; // s

const DAY = 86400; // s

const two = (number) => String(Math.floor(number)).padStart(2, "0");

/** Offset of the time zone from UTC at a time [s]. */
const ahead = (time) => -60 * new Date(time * 1000).getTimezoneOffset();

/**
 * Write the time of day.
 * @param {number} time since the epoch [s]
 * @param {number} step resolution [s]
 * @returns {string}
 */
export function clockText(time, step) {
  const places = Math.min(6, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
  const units = Math.round((time + ahead(time)) * 10 ** places);
  const seconds = Math.floor(units / 10 ** places);
  const rest = places ? `.${String(units - seconds * 10 ** places).padStart(places, "0")}` : "";
  const ofDay = ((seconds % DAY) + DAY) % DAY; // seconds may be negative west of Greenwich in a simulation
  return `${two(ofDay / 3600)}:${two((ofDay / 60) % 60)}:${two(ofDay % 60)}${rest}`;
}

/**
 * Write the date.
 * @param {number} time since the epoch [s]
 * @returns {string}
 */
export function dateText(time) {
  const date = new Date((time + ahead(time)) * 1000);
  return date.toISOString().slice(0, 10);
}

/**
 * Return the time zone as an offset from UTC.
 * @param {number} time since the epoch [s]
 * @returns {string}
 */
export function zoneText(time) {
  const minutes = Math.abs(ahead(time)) / 60;
  return minutes ? `UTC${ahead(time) < 0 ? "−" : "+"}${two(minutes / 60)}:${two(minutes % 60)}` : "UTC";
}

/**
 * List round times of day.
 * @param {number} from since the epoch [s]
 * @param {number} to since the epoch [s]
 * @param {number} most maximum number
 * @returns {{v: number, label: string}[]}
 */
export function clockTicks(from, to, most) {
  const least = (to - from) / Math.max(1, most);
  const step = least > 0.5 ? STEPS.find((one) => one >= least) || 3600 : niceStep(least);
  const shift = ahead(from);
  const list = [];
  if (!(step > 0)) return list;
  for (let index = Math.ceil((from + shift) / step - 1e-9); index * step <= to + shift; index += 1) {
    const time = index * step - shift;
    list.push({ v: time, label: clockText(time, step) });
  }
  return list;
}
