/** Charts other than traces over time: spectra, and XY plots. */

import { byId, make, options } from "../base/dom.js";
import { figure, measuredText } from "../base/numbers.js";
import { dashOf } from "../state/colours.js";
import { numbersOf } from "../state/states.js";
import { Chart } from "./canvas_chart.js";

export const KINDS = [["time", "over time"], ["spectrum", "spectrum"], ["xy", "XY"]];
const WINDOWS = ["hann", "flattop", "blackman", "rectangular"];
const AVERAGES = [1, 2, 4, 8, 16, 32];
const FLOOR_DB = 120; // range of a spectrum below its largest line

/** Whether a chart of a set-up is valid. */
export const isChart = ({ kind, x, window, scale, averages, equal }) =>
  KINDS.some(([name]) => name === kind) && typeof x === "string" && WINDOWS.includes(window) &&
  ["dB", "linear"].includes(scale) && AVERAGES.includes(averages) && typeof equal === "boolean";

/** The horizontal field: the chosen one, if it is shown. */
const rightOf = ({ chart, fields }) =>
  (numbersOf(fields).includes(chart.x) ? chart.x : numbersOf(fields)[0] || "");

/**
 * Make the request for a chart.
 * @param {Object} values of the state
 * @returns {Object} the request
 */
export function wantedChart(values) {
  const { kind, window, averages } = values.chart;
  if (kind === "spectrum") return { type: "chart", kind, window, averages };
  const x = rightOf(values);
  return kind === "xy" && x ? { type: "chart", kind, x } : { type: "chart", kind: "time" };
}

/** Describe a peak of a spectrum, or why it is not measured. */
function peakText(frequency, uncertainty, reason, level) {
  if (uncertainty === null) return reason.startsWith("not") ? reason : `not measurable: ${reason}`;
  const text = measuredText(frequency, uncertainty);
  return `${text.value} ± ${text.uncertainty} Hz, ${level}`;
}

/**
 * Return the lines of spectra.
 * @param {Object<string, Object>} traces as the server sends them
 * @param {string[]} fields the visible fields
 * @param {string} scale dB or linear
 */
export function spectra(traces, fields, scale) {
  const shown = fields.filter((field) => traces[field]);
  const top = Math.max(0, ...shown.flatMap((field) => traces[field].values.filter(Number.isFinite)));
  const least = 20 * Math.log10(top) - FLOOR_DB;
  const level = (value) => (scale === "dB" ? Math.max(20 * Math.log10(value), least) : value);
  const lines = shown.map((field) => {
    const { first, step, values, peaks } = traces[field];
    return {
      field,
      xs: values.map((_, index) => first + index * step),
      ys: values.map((value) => (value === null ? null : level(value))),
      marks: peaks.map(([x, y, uncertainty, reason]) => ({
        x,
        y: level(y),
        text: peakText(x, uncertainty, reason, `${figure(level(y), 4)}${scale === "dB" ? " dB" : ""}`),
      })),
    };
  });
  const y = scale === "dB" ? "amplitude, dB re 1" : "amplitude";
  return { lines: top > 0 ? lines : [], titles: { x: "frequency, Hz", y }, isEqual: false, exact: true };
}

/**
 * Set up the choice of charts.
 * @param {import("../state/store.js").State} state
 * @param {import("../page/requests.js").Requests} requests
 * @param {function(string): string} colourOf
 * @returns {{onChart: function(Object): void, chart: Chart}}
 */
export function startCharts(state, requests, colourOf) {
  const chart = new Chart(byId("chart"), colourOf, (field) => dashOf(state, field));
  const kinds = byId("kind");
  kinds.append(...options(KINDS));
  const controls = make("div", { class: "chart-controls" });
  byId("chart").append(controls);
  const change = (changes) => state.change("chart", changes);
  kinds.addEventListener("change", () => change({ kind: kinds.value }));

  function select(name, label, choices, read = (text) => text) {
    const element = make("select", {
      "aria-label": label, title: label, change: () => change({ [name]: read(element.value) }),
    }, ...options(choices));
    element.value = String(name === "x" ? rightOf(state.values) : state.values.chart[name]);
    return element;
  }

  function fill() {
    const { chart: { kind, equal }, fields } = state.values;
    kinds.value = kind;
    byId("chart").hidden = kind === "time";
    byId("overlay").hidden = kind !== "time";
    if (kind === "spectrum") {
      controls.replaceChildren(
        select("window", "spectrum window", WINDOWS),
        select("scale", "spectrum scale", ["dB", "linear"]),
        select("averages", "spectrum averages", AVERAGES.map((one) =>
          [one, one > 1 ? `${one} averages` : "no averaging"]), Number),
      );
    } else if (kind === "xy") {
      const box = make("input", { type: "checkbox", checked: equal, change: () => change({ equal: box.checked }) });
      controls.replaceChildren(
        select("x", "horizontal trace", numbersOf(fields).map((field) => [field, `x: ${field}`])),
        make("label", { class: "field" }, box, "equal scales"),
      );
    }
  }

  let latest = null; // the server's latest chart for the request
  const draw = { spectrum: drawSpectra, xy: drawXy };

  function drawSpectra({ traces }) {
    chart.draw(spectra(traces, state.shown, state.values.chart.scale));
  }

  function drawXy({ x, traces }) {
    const lines = state.shown.filter((field) => traces[field]).map((field) =>
      ({ field, xs: traces[field][0], ys: traces[field][1], marks: [] }));
    const y = lines.map(({ field }) => field).join(", ");
    chart.draw({ lines, titles: { x, y }, isEqual: state.values.chart.equal, exact: false });
  }

  /** Draw the latest chart; the server sends an unchanged chart only once. */
  function redraw() {
    if (latest) draw[latest.type](latest);
    else chart.draw({ lines: [], titles: { x: "", y: "" }, isEqual: false, exact: false });
  }

  function follow() {
    fill();
    chart.forget();
    const wanted = wantedChart(state.values);
    if (JSON.stringify(wanted) !== JSON.stringify(requests.chart)) latest = null;
    redraw();
    requests.sendChart(wanted);
  }

  function onChart(message) {
    if (state.values.chart.kind !== message.type) return;
    latest = message;
    redraw();
  }

  state.on(["chart", "fields", "traces"], follow);
  fill();
  return { chart, onChart };
}
