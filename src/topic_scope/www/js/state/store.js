/** State of the page: one object with the user's choices, and listeners to its parts. */

import { axisOf } from "./traces.js";

/**
 * @typedef {Object} Axis
 * @property {string} title
 * @property {?number} low null: automatic
 * @property {?number} high null: automatic
 * @property {boolean} clock of the time axis: whether it shows the time of day
 */

export const TRIGGER_MODES = ["off", "normal", "auto", "single"];
export const TRIGGER_EDGES = ["rising", "falling"];

/** Initial state of a page; times in [s]. */
const INITIAL = {
  fields: [], // chosen, in order
  available: [], // {field, datatype, topic}
  types: {}, // topic -> its type
  hidden: new Set(),
  right: new Set(), // fields on the right axis
  colours: new Map(), // field -> chosen colour
  traces: new Map(), // field -> its other settings, see traces.js
  history: 60,
  baseWindow: 5, // as selected
  window: 5, // as zoomed
  end: null, // right edge, since the epoch; null follows
  reference: null, // zero of the time axis; null follows
  playing: true, // whether the scope's clock runs; a bag's clock may be paused
  trigger: { number: 0, mode: "off", field: "", level: 0, edge: "rising",
    hysteresis: 0, holdoff: 0, position: 0.5 }, // position: the fraction of the window before it
  references: [], // copies of traces, see references.js
  persistence: 0, // number of earlier sweeps that stay visible
  axes: { // and "y.2", "y2.2" and so on, for further plots
    x: { title: "time, s", clock: false },
    y: { title: "", low: null, high: null },
    y2: { title: "", low: null, high: null },
  },
  cursors: null, // {a, b}: time cursors, on the time axis
  levels: null, // {field, c, d}: level cursors, on the axis of this trace
  // Chart: time; spectrum; xy, against the trace x, "" for the first.
  chart: { kind: "time", x: "", window: "hann", scale: "dB", averages: 1, equal: false },
  // Figures of the table; reference of phases, "" for the first trace; whether they are
  // of the span between the cursors; number of the statistics over time, 0 for none.
  measures: {
    figures: ["rate", "value", "min", "max", "mean", "rms", "frequency"], against: "", between: false,
    overTime: 0,
  },
  readonly: false,
  isBag: false, // whether a bag is shown, in place of a graph
  panels: true, // whether they are shown
  images: { shown: false, topic: "" }, // topic "": the first with images
  view: "scope",
  theme: "light",
};

/** State with listeners to its changes. */
export class State {
  constructor() {
    /** Read these freely; write them with set. */
    this.values = { ...INITIAL };
    this.listeners = [];
  }

  /**
   * Call a function when one of some values is set.
   * @param {string[]} names
   * @param {function(Object): void} listener takes the values
   */
  on(names, listener) {
    this.listeners.push({ names, listener });
  }

  /**
   * Set some values.
   * @param {Object} changes
   */
  set(changes) {
    Object.assign(this.values, changes);
    for (const { names, listener } of this.listeners) {
      if (names.some((name) => name in changes)) listener(this.values);
    }
  }

  /**
   * Set parts of a value that is an object.
   * @param {string} name of the value
   * @param {Object} changes
   */
  change(name, changes) {
    this.set({ [name]: { ...this.values[name], ...changes } });
  }

  /**
   * Set a part of one axis.
   * @param {string} name "x", or of a vertical one as in traces.js
   * @param {Partial<Axis>} changes
   */
  setAxis(name, changes) {
    this.change("axes", { [name]: { ...axisOf(this.values, name), ...changes } });
  }

  /**
   * Set a part of the trigger, or arm it again. Each call assigns a new number, so that delayed
   * messages of the server about an older trigger are ignored.
   * @param {Object} changes
   * @param {Object} others values to set with it
   */
  setTrigger(changes, others = {}) {
    const { trigger } = this.values;
    this.set({ trigger: { ...trigger, ...changes, number: trigger.number + 1 }, ...others });
  }

  /** Whether the view follows the present time. */
  get isRunning() {
    return this.values.end === null && this.values.playing;
  }

  /** The chosen fields that are visible. */
  get shown() {
    return this.values.fields.filter((field) => !this.values.hidden.has(field));
  }
}
