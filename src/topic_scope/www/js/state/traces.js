/** Settings of each trace other than axis and colour. */

import { bare } from "../base/names.js";
import { typed } from "../base/numbers.js";
import { isState, numbersOf } from "./states.js";

/** Most plots, one below another. */
export const PLOTS = 8;

/** Ways to draw a trace. */
export const DRAWN = ["line", "steps"];

/** Largest gain and offset; must match the server. */
export const LARGEST = 1e300;

/** Dashes and gaps of a line by name [pixels]; each is combined with all colours. */
export const DASHES = new Map([
  ["solid", []], ["dashed", [9, 4]], ["dotted", [2, 3]], ["dash-dot", [9, 3, 2, 3]],
]);

/**
 * @typedef {Object} Chosen
 * @property {number} plot number of its plot, from 1, the uppermost
 * @property {?number} slot index of its default colour and dash; null: none yet
 * @property {string} dash name of a dash, "" for the dash of its slot
 * @property {string} drawn "line", "steps", or "" for the default of the field's type
 * @property {number} gain factor of its values
 * @property {number} offset added to the product
 */
const USUAL = Object.freeze({ plot: 1, slot: null, dash: "", drawn: "", gain: 1, offset: 0 });

const FREE = Object.freeze({ title: "", low: null, high: null });

/** Name of a vertical axis of a plot; "y" or "y2" in the first plot. */
export const axisName = (side, plot) => (plot === 1 ? side : `${side}.${plot}`);

/** Side and plot of the name of a vertical axis. */
export function axisParts(name) {
  const [side, plot] = name.split(".");
  return [side, Number(plot || 1)];
}

/** Settings of a vertical axis. */
export const axisOf = ({ axes }, name) => axes[name] || FREE;

/** Settings of a trace. */
export const chosenOf = ({ traces }, field) => traces.get(field) || USUAL;

/** Number of plots. */
export const plotCount = ({ fields, traces }) =>
  Math.max(1, ...numbersOf(fields).map((field) => chosenOf({ traces }, field).plot));

/** Names of the vertical axes with settings or traces. */
export function verticals(values) {
  const names = [];
  for (let plot = 1; plot <= plotCount(values); plot += 1) {
    const inside = numbersOf(values.fields).filter((field) => chosenOf(values, field).plot === plot);
    const onRight = inside.filter((field) => values.right.has(field));
    if (onRight.length < inside.length || !inside.length) names.push(axisName("y", plot));
    if (onRight.length) names.push(axisName("y2", plot));
  }
  return names;
}

/**
 * Change the settings of a trace.
 * @param {import("./store.js").State} state
 * @param {string} field
 * @param {Partial<Chosen>} changes
 */
export function choose(state, field, changes) {
  const { traces } = state.values;
  state.set({ traces: new Map([...traces, [field, { ...chosenOf({ traces }, field), ...changes }]]) });
}

// --- Derived properties ----------------------------------------------------------------------

/** The name of the difference of two traces. */
export const differenceOf = (field, less) => `${field}-${less}`;

/** Whether a text is a formula. */
export const isFormula = (text) => text.startsWith("=");

/** Whether a name denotes a computed trace: a formula, or a difference. */
export const isComputed = (field) => isFormula(field) || bare(field).includes("-/");

const COUNTED = /^(bool|byte|char|u?int\d+)$/;
const typesOf = new WeakMap(); // list of fields -> types by field

/** Type of a listed field; all elements of an array have the type of the first. */
function typeOf({ available }, field) {
  if (!typesOf.has(available)) {
    typesOf.set(available, new Map(available.map(({ field: name, datatype }) => [name, datatype])));
  }
  const end = bare(field).search(/[.@]|$/);
  return typesOf.get(available).get(field.slice(0, end).replace(/\[\d+\]/g, "[0]"));
}

/** Whether a trace is stepped; the default for integers and Booleans. */
export function isStepped(values, field) {
  const { drawn } = chosenOf(values, field);
  const isValue = !isComputed(field) && !isState(field) && !/\.(derivative|unwrap|yaw)/.test(bare(field));
  return drawn ? drawn === "steps" : isValue && COUNTED.test(typeOf(values, field) || "");
}

/**
 * Make the request for gains, offsets and steps.
 * @param {Object} values of the state
 * @returns {Object} the request
 */
export function scalingOf(values) {
  const scales = values.fields.map((field) => {
    const { gain, offset } = chosenOf(values, field);
    return [field, { gain, offset, steps: isStepped(values, field) }];
  });
  const isOwn = ([, { gain, offset, steps }]) => gain !== 1 || offset !== 0 || steps;
  return { type: "scaling", traces: Object.fromEntries(scales.filter(isOwn)) };
}

/**
 * Describe the scale of a trace.
 * @param {Object} values of the state
 * @param {string} field
 * @returns {string} empty if it is not scaled
 */
export function scaledText(values, field) {
  const { gain, offset } = chosenOf(values, field);
  const times = gain === 1 ? "" : ` × ${typed(gain, 6)}`;
  const plus = offset === 0 ? "" : ` ${offset < 0 ? "−" : "+"} ${typed(Math.abs(offset), 6)}`;
  return times || plus ? `scaled${times}${plus}`.replace("-", "−") : "";
}

/** Name of a trace, with its scale. */
export const labelOf = (values, field) => [field, scaledText(values, field)].filter(Boolean).join(" ");

/** Settings of a new trace: in the plot of the topic that it was expanded from. */
function inherited(traces, field) {
  const whole = [...traces].find(([name]) => field.startsWith(`${name}/`));
  return whole ? { ...USUAL, plot: whole[1].plot } : USUAL;
}

/** Assign each trace its slot, or the first free slot. */
function withSlots(known) {
  const taken = new Set([...known.values()].map(({ slot }) => slot));
  return new Map([...known].map(([field, one]) => {
    let slot = one.slot ?? 0;
    if (one.slot === null) while (taken.has(slot)) slot += 1;
    taken.add(slot);
    return [field, { ...one, slot }];
  }));
}

/**
 * Remove empty plots, assign default styles, and drop removed traces; axes keep
 * their plots.
 * @param {Object} values of the state
 * @returns {{traces: Map<string, Chosen>, axes: Object}} the new values
 */
export function arranged({ fields, traces, axes }) {
  const known = new Map(fields.map((field) => [field, traces.get(field) || inherited(traces, field)]));
  const used = [...new Set(numbersOf(fields).map((field) => known.get(field).plot))].sort((a, b) => a - b);
  if (!fields.length) return { traces, axes }; // nothing to go by yet
  if (!used.length) used.push(1); // states are below all plots
  const moved = { x: axes.x };
  used.forEach((before, index) => {
    for (const side of ["y", "y2"]) {
      const axis = axes[axisName(side, before)];
      if (axis || !index) moved[axisName(side, index + 1)] = axis || FREE;
    }
  });
  const place = (one) => ({ ...one, plot: Math.max(used.indexOf(one.plot), 0) + 1 });
  const traceOf = ([field, one]) => [field, place(one)];
  return { traces: new Map([...withSlots(known)].map(traceOf)), axes: moved };
}

/**
 * Rearrange the plots after each change.
 * @param {import("./store.js").State} state rebuilt: later listeners see the plots in order
 */
export function keepArranged(state) {
  let isBusy = false;
  state.on(["fields", "traces"], (values) => {
    if (isBusy) return;
    isBusy = true;
    state.set(arranged(values));
    isBusy = false;
  });
}

// --- In a set-up -----------------------------------------------------------------------------

const isScale = (value) => Number.isFinite(value) && Math.abs(value) <= LARGEST;
const isWhole = (value, low, high) => Number.isInteger(value) && value >= low && value <= high;

const CHECKS = {
  plot: (value) => isWhole(value, 1, PLOTS),
  slot: (value) => isWhole(value, 0, 1000),
  dash: (value) => value === "" || DASHES.has(value),
  drawn: (value) => value === "" || DRAWN.includes(value),
  gain: isScale,
  offset: isScale,
};

/** Return whether the traces of a set-up are valid. */
export const isTraces = (object) => Object.values(object).every((chosen) =>
  Object.entries(chosen).every(([name, value]) => Object.hasOwn(CHECKS, name) && CHECKS[name](value)));

/** Return the settings of traces that differ from their defaults. */
export function writeTraces(traces) {
  const isPlain = [...traces.values()].every(({ slot }, index) => slot === index);
  const unusual = (chosen) => Object.fromEntries(Object.entries(chosen).filter(([name, value]) =>
    value !== USUAL[name] && !(isPlain && name === "slot")));
  return Object.fromEntries([...traces].map(([field, chosen]) => [field, unusual(chosen)])
    .filter(([, chosen]) => Object.keys(chosen).length));
}

/** Parse the output of {@link writeTraces}. */
export const readTraces = (object) => new Map(
  Object.entries(object).map(([field, chosen]) => [field, { ...USUAL, ...chosen }]));
