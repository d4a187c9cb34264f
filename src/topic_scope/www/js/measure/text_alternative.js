/** Text alternative to the plot, for users who cannot see it. */

import { byId, setText } from "../base/dom.js";
import { figure } from "../base/numbers.js";
import { labelOf } from "../state/traces.js";
import { certainty, figureText } from "./statistics.js";

const KINDS = { time: "plot over time", spectrum: "spectrum", xy: "XY plot" };

/**
 * Describe a plot in words.
 * @param {Object} values of the state
 * @param {string[]} fields that are shown
 * @param {Object<string, Object>} traces their measurements
 * @returns {string}
 */
export function inWords(values, fields, traces) {
  const { window, end } = values;
  const of = (field) => {
    const measured = traces[field];
    if (!measured) return "no data yet";
    if (measured.problem) return measured.problem;
    if (measured.state !== undefined) return measured.state === null ? "no data" : `state ${measured.state}`;
    const { silent, min, max, mean, value, vpp, frequency } = measured;
    if (!Number.isFinite(min)) return silent ? `no data for ${Math.floor(silent)} s` : "no data";
    const [low, high, middle, latest] = [min, max, mean, value].map((level) => figure(level, 5, vpp));
    const sure = certainty(measured, "frequency");
    const wave = Number.isFinite(frequency) ? `, ${figureText(measured, "frequency")} ${sure} Hz`
      : sure && `, frequency ${sure}`;
    return `from ${low} to ${high}, mean ${middle}, latest ${latest}${wave}`;
  };
  const until = end === null ? "until now" : `until ${new Date(end * 1000).toISOString().slice(11, 19)} UTC, paused`;
  const head = fields.length ? `${figure(window, 3)} s ${until}.` : "No traces.";
  return [head, ...fields.map((field) => `${labelOf(values, field)}: ${of(field)}.`)].join(" ");
}

/**
 * Set up the text alternative.
 * @param {import("../state/store.js").State} state
 * @returns {function(Object<string, Object>): void} takes the measurements of the traces
 */
export function startAlternative(state) {
  const plot = byId("plot");
  state.on(["chart"], ({ chart: { kind } }) => {
    plot.setAttribute("aria-label", KINDS[kind]);
    byId("chart").setAttribute("aria-label", KINDS[kind]);
  });
  return (traces) => setText(byId("plot-text"), inWords(state.values, state.shown, traces));
}
