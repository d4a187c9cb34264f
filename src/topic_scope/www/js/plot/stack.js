/** Stack of plots over a common time axis. */

import { clamp, rounded } from "../base/numbers.js";
import { numbersOf } from "../state/states.js";
import { axisName, axisParts, chosenOf, plotCount } from "../state/traces.js";
import { Plot } from "./dygraph_view.js";

/** All plots. */
export class Plots {
  /**
   * @param {HTMLElement} element to draw in
   * @param {import("../state/store.js").State} state
   * @param {function(string): string} colourOf gives the colour of a field
   */
  constructor(element, state, colourOf) {
    this.element = element;
    this.state = state;
    this.colourOf = colourOf;
    this.listeners = [];
    this.shown = null; // latest drawn sweep
    this.list = [new Plot(element, state, 1, colourOf)];
    this.isArranged = false;
    state.on(["fields", "hidden", "traces"], () => { this.isArranged = false; });
    state.on(["fields", "right", "traces"], () => this.list.forEach((plot) => plot.forgetRanges()));
    state.on(["theme"], () => this.list.forEach((plot) => plot.restyle()));
  }

  /**
   * Call a function after each drawing.
   * @param {function(): void} listener
   */
  onDrawn(listener) {
    this.listeners.push(listener);
  }

  /** Add or remove plots, and assign the traces to theirs. */
  arrange() {
    const { list, state } = this;
    const count = plotCount(state.values);
    const isOther = count !== list.length;
    while (list.length > count) list.pop().remove();
    while (list.length < count) {
      list.push(new Plot(this.element, state, list.length + 1, this.colourOf));
    }
    if (isOther) list.forEach((plot) => plot.resize()); // the heights have changed
    for (const plot of list) {
      plot.fields = numbersOf(state.shown).filter((field) => chosenOf(state.values, field).plot === plot.number);
    }
    this.isArranged = true;
  }

  /**
   * Draw.
   * @param {{buffer: import("../state/buffer.js").TraceBuffer, reference: number, from: number,
   *   to: number}} shown
   */
  draw(shown) {
    this.shown = shown;
    if (!this.isArranged) this.arrange();
    for (const plot of this.list) plot.prepare(shown);
    const widths = this.list.length > 1 ? this.widths() : null;
    for (const plot of this.list) plot.draw(widths);
    for (const listener of this.listeners) listener();
  }

  /** Redraw. */
  redraw() {
    for (const plot of this.list) plot.redraw();
  }

  /** Widths of both axes' labels that align all plots; 0 for no axis. */
  widths() {
    const widest = (side, plots) => Math.max(0, ...plots.map((plot) => plot.widths[side]));
    return {
      y: widest("y", this.list.filter((plot) => !plot.onlyRight)),
      y2: widest("y2", this.list.filter((plot) => plot.hasRight)),
    };
  }

  /** From the first plot to the last one: x, y, w and h in the element [pixels]. */
  get area() {
    const [first] = this.list;
    const { x, y, w, h } = first.area;
    if (this.list.length === 1) return { x, y, w, h };
    const last = this.list[this.list.length - 1];
    const { y: below, h: height } = last.area;
    return { x, y, w, h: last.element.offsetTop + below + height - first.element.offsetTop - y };
  }

  /**
   * Return the position of a plot in the area of all plots.
   * @param {string} axis name of one of its axes
   * @returns {{low: number, high: number}} fractions of the total height, from below
   */
  spanOf(axis) {
    if (this.list.length === 1) return { low: 0, high: 1 };
    const all = this.area;
    const plot = this.plotOf(axis);
    const { y, h } = plot.area;
    const top = plot.element.offsetTop - this.list[0].element.offsetTop + y - all.y;
    return { low: 1 - (top + h) / all.h, high: 1 - top / all.h };
  }

  /** Plot of an axis. */
  plotOf(axis) {
    return this.list[axisParts(axis)[1] - 1] || this.list[0];
  }

  /**
   * Find the plot that is nearest to a pointer.
   * @param {PointerEvent} event
   * @returns {Plot}
   */
  under(event) {
    const beside = (plot) => Math.abs(plot.at(event).up - 0.5);
    return this.list.reduce((best, plot) => (beside(plot) < beside(best) ? plot : best));
  }

  /**
   * Return the vertical axis of a field.
   * @param {string} field
   * @returns {string} its name, see traces.js
   */
  axisOf(field) {
    const { values } = this.state;
    return axisName(values.right.has(field) ? "y2" : "y", chosenOf(values, field).plot);
  }

  /**
   * Return the ends of a vertical axis.
   * @param {string} axis its name
   * @returns {[number, number]}
   */
  range(axis) {
    return this.plotOf(axis).range(axisParts(axis)[0]);
  }

  /**
   * Return the position of a value.
   * @param {string} axis name of its axis
   * @param {number} value
   * @returns {?number} position in the area of all plots, 0 to 1 from below; null outside of its plot
   */
  placeOf(axis, value) {
    const [low, high] = this.range(axis);
    const part = (value - low) / (high - low);
    const span = this.spanOf(axis);
    return part >= -1e-6 && part <= 1 + 1e-6 ? span.low + part * (span.high - span.low) : null;
  }

  /**
   * Return the value at a position; outside of the plot, the nearest value in it.
   * @param {string} axis name of the axis
   * @param {number} place position in the area of all plots, 0 to 1 from below
   * @returns {number} rounded to the resolution of the screen
   */
  valueAt(axis, place) {
    const [low, high] = this.range(axis);
    const span = this.spanOf(axis);
    const inside = clamp((place - span.low) / (span.high - span.low), 0, 1);
    return rounded(low + inside * (high - low), high - low);
  }

  /** Ends of the time axis, relative to its reference [s]. */
  get times() {
    return this.list[0].times;
  }

  /** The canvases with grid and traces, the lowest first. */
  get canvases() {
    return this.list.flatMap((plot) => plot.canvases);
  }
}
