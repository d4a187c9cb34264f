/** Choice of measurements, of their time span, and of the reference trace. */

import { byId, make, options } from "../base/dom.js";
import { figure, measuredText } from "../base/numbers.js";
import { numbersOf } from "../state/states.js";

const LONGEST = 20; // letters of a state in the table; its tooltip has the whole text

/** Keys of the figures, their heads in the table, and descriptions. */
export const FIGURES = [
  ["rate", "rate, Hz", "samples per second"],
  ["value", "value", "the latest value"],
  ["min", "min", "minimum"],
  ["max", "max", "maximum"],
  ["vpp", "Vpp", "peak to peak"],
  ["mean", "mean", "mean"],
  ["rms", "RMS", "root mean square"],
  ["deviation", "σ", "standard deviation"],
  ["frequency", "freq., Hz", "frequency"],
  ["rise", "rise, s", "rise time, from 10 % to 90 %"],
  ["overshoot", "over, %", "overshoot, in % of the step"],
  ["settling", "settled, s", "settling time, to within 2 % of the step"],
  ["duty", "duty, %", "duty cycle, above the middle of the levels"],
  ["cycle_mean", "cycle mean", "mean over whole periods"],
  ["cycle_rms", "cycle RMS", "root mean square over whole periods"],
  ["phase", "phase, °", "phase, relative to the trace chosen below"],
  ["latency", "latency, s", "latency: from the stamp to reception, median"],
  ["latency_max", "latency max, s", "greatest latency"],
];
/** Figures whose digits depend on the spread of the trace. */
export const VALUES = ["value", "min", "max", "mean", "rms", "cycle_mean", "cycle_rms"];

const SHAPES = ["rise", "overshoot", "settling", "duty", "cycle_mean", "cycle_rms"];
const LATENCIES = ["latency", "latency_max"];
const SOON_MS = 100; // while a cursor is dragged, nothing is sent more often

/**
 * Describe the uncertainty of a measurement, or why it is missing.
 * @param {Object} measured measurements of a trace
 * @param {string} key of the figure
 * @returns {string} empty for an exact or missing figure
 */
export function certainty(measured, key) {
  if (measured.state !== undefined) return key === "value" ? measured.state : "not measurable: a state has no numbers";
  const { uncertainty, unmeasurable } = measured;
  const reason = unmeasurable?.[key];
  if (reason) return `not measurable: ${reason}`;
  const unsure = measuredText(measured[key], uncertainty?.[key]).uncertainty;
  return unsure && `± ${unsure}`;
}

const shortened = (text) => (text.length > LONGEST ? `${text.slice(0, LONGEST)}…` : text);

/**
 * Format a figure with the digits that its uncertainty, or the spread of its trace, requires.
 * @param {Object} measured measurements of a trace
 * @param {string} key of the figure
 * @returns {string}
 */
export function figureText(measured, key) {
  if (key === "value" && measured.state) return shortened(measured.state);
  if (measured.uncertainty?.[key] > 0) return measuredText(measured[key], measured.uncertainty[key]).value;
  return figure(measured[key], 5, VALUES.includes(key) ? measured.vpp : null);
}

/** The visible figures, in order. */
export const shownFigures = ({ measures }) => FIGURES.filter(([key]) => measures.figures.includes(key));

/**
 * Make the request for measurements.
 * @param {Object} values of the state
 * @param {?number} reference zero of the cursors' times, since the epoch [s]; null: the present
 * @returns {Object} the request
 */
export function wantedMeasures({ measures, cursors, fields }, reference) {
  const { figures, against, between } = measures;
  const span = between && cursors
    ? { start: cursors.a, end: cursors.b, reference } : { start: null, end: null, reference: null };
  return {
    type: "measure",
    shapes: SHAPES.some((key) => figures.includes(key)),
    over_time: measures.overTime || 0,
    latency: LATENCIES.some((key) => figures.includes(key)),
    against: figures.includes("phase") ? (numbersOf(fields).includes(against) && against) || numbersOf(fields)[0] || "" : "",
    ...span,
  };
}

/**
 * Set up the dialog, and send its changes to the server.
 * @param {import("../state/store.js").State} state
 * @param {import("../state/sweep.js").Sweep} sweep
 * @param {import("../plot/stack.js").Plots} plot
 * @param {import("../page/requests.js").Requests} requests
 * @returns {function(): void} opens the dialog
 */
export function startMeasures(state, sweep, plot, requests) {
  const rows = byId("measures-figures");
  const against = byId("measures-against");
  const between = byId("measures-between");
  const overTime = byId("measures-over-time");
  const change = (changes) => state.change("measures", changes);

  function row([key, , text]) {
    const { figures } = state.values.measures;
    const box = make("input", {
      type: "checkbox",
      "data-figure": key,
      checked: figures.includes(key),
      change: () => change({ figures: FIGURES.map(([one]) => one).filter((one) =>
        (one === key ? box.checked : state.values.measures.figures.includes(one))) }),
    });
    return make("label", {}, box, make("span", {}, text));
  }

  function fill() {
    const { measures } = state.values;
    const fields = numbersOf(state.values.fields);
    rows.replaceChildren(...FIGURES.map(row));
    against.replaceChildren(...options(fields));
    against.value = fields.includes(measures.against) ? measures.against : fields[0] || "";
    between.checked = measures.between;
    overTime.checked = Boolean(measures.overTime);
  }

  let timer = null;
  function sendSoon() {
    if (timer !== null) return;
    timer = setTimeout(() => {
      timer = null;
      const isPaused = state.values.end !== null || sweep.held;
      const message = wantedMeasures(state.values, isPaused ? plot.shown?.reference ?? null : null);
      requests.sendMeasure(message);
    }, SOON_MS);
  }

  against.addEventListener("change", () => change({ against: against.value }));
  between.addEventListener("change", () => change({ between: between.checked }));
  const restartCount = () => change({ overTime: (state.values.measures.overTime || 0) + 1 });
  overTime.addEventListener("change", () => (overTime.checked ? restartCount() : change({ overTime: 0 })));
  byId("over-time-restart").addEventListener("click", restartCount);
  plot.onDrawn(sendSoon);
  state.on(["measures", "cursors"], sendSoon);
  return () => {
    fill();
    byId("measures").showModal();
  };
}
