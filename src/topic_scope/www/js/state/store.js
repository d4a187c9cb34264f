/** State of the page: one object with the user's choices, and listeners to its parts. */

import { axisOf } from "./traces.js";

/**
 * @typedef {Object} Axis
 * @property {string} title
 * @property {?number} low null: by itself
 * @property {?number} high null: by itself
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
  colours: new Map(), // field -> colour picked by hand
  traces: new Map(), // field -> what else is chosen for it, see traces.js
  history: 60,
  baseWindow: 5, // as selected
  window: 5, // as zoomed
  end: null, // right edge, since the epoch; null follows
  reference: null, // what the time axis counts from; null follows
  playing: true, // whether the scope's clock goes; that of a bag may stand
  trigger: { number: 0, mode: "off", field: "", level: 0, edge: "rising",
    hysteresis: 0, holdoff: 0, position: 0.5 }, // position: the part of the window before it
  references: [], // traces kept as they were, see references.js
  persistence: 0, // how many earlier sweeps of the trigger stay visible
  axes: { // and "y.2", "y2.2" and so on, of further plots
    x: { title: "time, s", clock: false },
    y: { title: "", low: null, high: null },
    y2: { title: "", low: null, high: null },
  },
  cursors: null, // {a, b}: time cursors, on the time axis
  levels: null, // {field, c, d}: level cursors, on the axis of this trace
  // What is plotted: over time; spectrum; xy, over the trace x, "" for the first one.
  chart: { kind: "time", x: "", window: "hann", scale: "dB", averages: 1, equal: false },
  // Which figures the table has; what phases are against, "" for the first trace; whether they are
  // of what is between the cursors; the number of the count of how they vary, 0 for none.
  measures: {
    figures: ["rate", "value", "min", "max", "mean", "rms", "frequency"], against: "", between: false,
    overTime: 0,
  },
  readonly: false,
  isBag: false, // whether a bag is shown, in place of a graph
  panels: true, // whether they are shown
  view: "scope",
  theme: "light",
};

/** Holds the state and calls listeners when it changes. */
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
   * Set a part of the trigger, or arm it again as it is. Each time it gets another number: what the
   * server sends about an older one, which may be under way, is not for this one.
   * @param {Object} changes
   * @param {Object} others values to be set with it
   */
  setTrigger(changes, others = {}) {
    const { trigger } = this.values;
    this.set({ trigger: { ...trigger, ...changes, number: trigger.number + 1 }, ...others });
  }

  /** Whether the view follows the present time. */
  get isRunning() {
    return this.values.end === null && this.values.playing;
  }

  /** The chosen fields that are shown. */
  get shown() {
    return this.values.fields.filter((field) => !this.values.hidden.has(field));
  }
}
