/** Plot of a sweep, drawn by dygraphs. */

import { clockTicks, dateText, zoneText } from "../base/clock.js";
import { make, themeColour } from "../base/dom.js";
import { AutoRange, rangeWith, ticks } from "../base/numbers.js";
import { dashOf } from "../state/colours.js";
import { axisName, axisOf, plotCount } from "../state/traces.js";
import { EarlierSweeps, widened } from "./earlier_sweeps.js";
import { drawReferences } from "./reference_lines.js";

/* global Dygraph */

const PIXELS_PER_TICK = { x: 90, y: 46 };
const LABEL_WIDTH = 58;
const LETTER = 7; // pixels, of a label
const TICK_PIXELS = 6; // gap of dygraphs beside labels
const RIGHT_GAP = 6; // pixels, without an axis
const BELOW = 22; // pixels below a plot without a time axis, for the lowest label of its axis
const SPARSE_PIXELS = 9; // samples at least this far apart are marked

// dygraphs of Debian 13 warns at each drawing that samples are outside of the view, which is normal
// for a zoomed plot. It also redraws by itself when its size has changed.
const OUTSIDE = /^\d+ points out of [XY] bounds:/;
const { warn } = console;
console.warn = (...words) => OUTSIDE.test(words[0]) || warn.apply(console, words);

/** One plot, with its traces. */
export class Plot {
  /**
   * @param {HTMLElement} parent of its element
   * @param {import("../state/store.js").State} state
   * @param {number} number from 1, the uppermost
   * @param {function(string): string} colourOf gives the colour of a field
   */
  constructor(parent, state, number, colourOf) {
    this.state = state;
    this.number = number;
    this.colourOf = colourOf;
    this.fields = []; // its visible fields
    this.rows = []; // reused by each drawing
    this.earlier = new EarlierSweeps();
    this.element = make("div", { class: "pane" });
    parent.append(this.element);
    this.forgetRanges();
    this.shown = null; // latest drawn sweep
    const axis = (name) => ({
      ticker: (low, high, pixels) =>
        (name === "y" && this.onlyRight ? [] : ticks(low, high, pixels / PIXELS_PER_TICK.y)),
      axisLabelWidth: LABEL_WIDTH,
      drawGrid: name === "y",
    });
    this.graph = new Dygraph(this.element, [[0, null]], {
      labels: ["time", " "],
      axes: {
        x: { axisLabelWidth: 90, drawGrid: true, ticker: (...ends) => this.timeTicks(...ends) },
        y: axis("y"),
        y2: axis("y2"),
      },
      connectSeparatedPoints: true,
      gridLineWidth: 1,
      highlightCircleSize: 0,
      interactionModel: {},
      labelsKMB: false,
      legend: "never",
      rightGap: RIGHT_GAP,
      strokeWidth: 1.5,
      underlayCallback: (context, area, graph) => this.drawBehind(context, area, graph),
      pointSize: 2,
      xLabelHeight: 20,
      yLabelWidth: 20,
    });
    this.restyle();
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(this.element);
  }

  /** Fill the available space. */
  resize() {
    this.graph.resize();
  }

  /** Redraw, which dygraphs does only if its size has changed. */
  redraw() {
    const { style, clientWidth } = this.element;
    const { width } = style;
    style.width = `${clientWidth - 1}px`;
    this.resize();
    style.width = width;
    this.resize();
  }

  /** Remove the plot. */
  remove() {
    this.observer.disconnect();
    this.graph.destroy();
    this.element.remove();
  }

  /** Reset the vertical ranges, when the traces have changed. */
  forgetRanges() {
    this.auto = { y: new AutoRange(), y2: new AutoRange() };
  }

  /** Use the colours of the page. */
  restyle() {
    this.axisColour = themeColour("axis");
    this.graph.updateOptions({ gridLineColor: themeColour("grid"), axisLineColor: this.axisColour }, true);
  }

  /**
   * Compute the ranges of the vertical axes, before drawing.
   * @param {{buffer: import("../state/buffer.js").TraceBuffer,
   *   earlier: Map<string, import("../state/persistence.js").Line>[], reference: number, from: number,
   *   to: number}} shown
   */
  prepare(shown) {
    const { right } = this.state.values;
    const onLeft = this.fields.filter((field) => !right.has(field));
    this.shown = shown;
    this.onlyRight = this.fields.length > 0 && !onLeft.length;
    this.isLowest = this.number === plotCount(this.state.values);
    this.hasRight = onLeft.length < this.fields.length;
    this.ranges = {
      y: this.rangeFor("y", onLeft),
      y2: this.rangeFor("y2", this.fields.filter((field) => right.has(field))),
    };
    this.widths = { y: this.labelWidth(this.ranges.y), y2: this.labelWidth(this.ranges.y2) };
  }

  /**
   * Draw the sweep of {@link prepare}.
   * @param {?{y: number, y2: number}} widths of the labels of both axes, for all plots to have the
   *   same edges; 0 without an axis; null for a single plot
   */
  draw(widths) {
    const { shown, fields, onlyRight, ranges } = this;
    const { axes } = this.state.values;
    const own = widths || this.widths;
    const titleOf = (side) => axisOf(this.state.values, axisName(side, this.number)).title || null;
    const options = {
      file: shown.buffer.rows(fields.length ? fields : [" "], shown.reference, this.rows),
      labels: ["time", ...(fields.length ? fields : [" "])],
      series: this.series(fields, shown.buffer),
      // dygraphs omits a tick at the very end.
      dateWindow: [shown.from - shown.reference, shown.to - shown.reference + 1e-9],
      axes: {
        // An axis without traces has no labels: use the grid of the other axis.
        y: {
          valueRange: ranges.y,
          drawAxis: !onlyRight || (widths !== null && widths.y > 0),
          axisLabelWidth: own.y,
          axisLineColor: onlyRight ? "transparent" : this.axisColour,
        },
        y2: {
          valueRange: ranges.y2,
          axisLabelWidth: own.y2,
          drawGrid: onlyRight,
          independentTicks: onlyRight,
        },
      },
      rightGap: RIGHT_GAP + (widths && widths.y2 && !this.hasRight ? widths.y2 + TICK_PIXELS : 0),
      xAxisHeight: this.isLowest ? null : BELOW,
      xlabel: this.isLowest ? this.timeTitle(axes.x) : null,
      ylabel: titleOf("y"),
      y2label: titleOf("y2"),
    };
    const { x, y, w, h } = this.area;
    this.graph.updateOptions(options);
    const now = this.area;
    if (now.x === x && now.y === y && now.w === w && now.h === h) return;
    this.erase();
    this.graph.updateOptions(options);
  }

  /**
   * Erase everything, also beside the plot. dygraphs itself erases only the area that it is about to
   * draw: an axis of a previously larger area would remain, e.g. after a title or wider labels were added.
   * Its clipping is reset, too: at fractional pixels it erases only partly.
   */
  erase() {
    for (const canvas of this.canvases) {
      const context = canvas.getContext("2d");
      context.restore();
      context.clearRect(0, 0, canvas.width, canvas.height);
      context.save();
    }
  }

  /** Draw the layers behind the traces. */
  drawBehind(context, area, graph) {
    const { earlier = [] } = this.shown || {};
    const { references, right } = this.state.values;
    const axis = (field) => (right.has(field) ? 1 : 0);
    const plot = {
      colourOf: this.colourOf,
      across: (time) => graph.toDomXCoord(time),
      up: (field, value) => graph.toDomYCoord(value, axis(field)),
    };
    if (earlier.length) this.earlier.draw(context, area, earlier, this.fields, plot);
    if (references.length) drawReferences(context, area, references, this.fields, plot);
  }

  series(fields, buffer) {
    const series = {};
    const most = this.area.w / SPARSE_PIXELS;
    for (const field of fields) {
      series[field] = {
        axis: this.state.values.right.has(field) ? "y2" : "y",
        color: this.colourOf(field),
        strokePattern: dashOf(this.state, field),
        stepPlot: buffer.lasts.has(field),
        drawPoints: buffer.filled(field) < most,
      };
    }
    return series;
  }

  /** Ticks of the time axis, by the clock or relative to its reference; labelled below the lowest plot. */
  timeTicks(low, high, pixels) {
    const most = pixels / PIXELS_PER_TICK.x;
    const { reference } = this.shown || { reference: 0 };
    const places = this.state.values.axes.x.clock && this.shown
      ? clockTicks(reference + low, reference + high, most).map(({ v, label }) => ({ v: v - reference, label }))
      : ticks(low, high, most);
    return this.isLowest ? places : places.map(({ v }) => ({ v }));
  }

  timeTitle({ title, clock }) {
    if (!clock) return title || null;
    const { to } = this.shown;
    const day = dateText(to) === dateText(Date.now() / 1000) ? "" : ` ${dateText(to)},`;
    return `${title === "time, s" ? "time" : title},${day} ${zoneText(to)}`;
  }

  /** Width of the labels of an axis: wider if they have many digits. */
  labelWidth([low, high]) {
    const labels = ticks(low, high, this.area.h / PIXELS_PER_TICK.y).map(({ label }) => label.length);
    return Math.max(LABEL_WIDTH, LETTER * Math.max(0, ...labels));
  }

  rangeFor(axis, fields) {
    const { low, high } = axisOf(this.state.values, axisName(axis, this.number));
    const { buffer, earlier = [], reference, from, to } = this.shown;
    const behind = [...earlier, ...this.state.values.references.map(({ lines }) => lines)];
    const extent = widened(buffer.extent(fields, from, to), behind, fields, from - reference, to - reference);
    const range = this.auto[axis].update(extent[0], extent[1], performance.now() / 1000);
    return rangeWith(low, high, range);
  }

  /** Area of the traces: x, y, w and h in the element [pixels]. */
  get area() {
    return this.graph.getArea();
  }

  /**
   * Return the position of a pointer.
   * @param {PointerEvent} event
   * @returns {{across: number, up: number}} fractions of the area, from the left and from below
   */
  at(event) {
    const { left, top } = this.element.getBoundingClientRect();
    const { x, y, w, h } = this.area;
    return { across: (event.clientX - left - x) / w, up: 1 - (event.clientY - top - y) / h };
  }

  /**
   * Return the ends of a vertical axis.
   * @param {"y"|"y2"} axis
   * @returns {[number, number]}
   */
  range(axis) {
    const ranges = this.graph.yAxisRanges();
    return ranges[axis === "y2" ? ranges.length - 1 : 0];
  }

  /** Ends of the time axis, relative to its reference [s]. */
  get times() {
    return this.graph.xAxisRange();
  }

  /** The canvases with grid and traces, the lowest first. */
  get canvases() {
    return [...this.element.querySelectorAll("canvas")];
  }
}
