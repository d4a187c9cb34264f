/** Draws what a sweep shows with dygraphs, and knows where on the screen a value is. */

import { clockTicks, dateText, zoneText } from "../base/clock.js";
import { make, themeColour } from "../base/dom.js";
import { AutoRange, ticks } from "../base/numbers.js";
import { dashOf } from "../state/colours.js";
import { axisName, axisOf, plotCount } from "../state/traces.js";
import { EarlierSweeps, widened } from "./earlier_sweeps.js";
import { drawReferences } from "./reference_lines.js";

/* global Dygraph */

const PIXELS_PER_TICK = { x: 90, y: 46 };
const LABEL_WIDTH = 58;
const LETTER = 7; // pixels, of a label
const TICK_PIXELS = 6; // that dygraphs leaves beside labels
const RIGHT_GAP = 6; // pixels, where there is no axis
const BELOW = 22; // pixels below a plot that has no time axis, for the lowest number beside it
const SPARSE_PIXELS = 9; // samples at least so far apart are marked

// That of Debian 13 says with each drawing that samples lie outside of what is shown, but that is
// what a plot is moved and magnified for. It draws by itself too, where its size has changed.
const OUTSIDE = /^\d+ points out of [XY] bounds:/;
const { warn } = console;
console.warn = (...words) => OUTSIDE.test(words[0]) || warn.apply(console, words);

/** One plot: those of the traces that are in it. */
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
    this.fields = []; // that are shown here
    this.rows = []; // used again with each drawing
    this.earlier = new EarlierSweeps();
    this.element = make("div", { class: "pane" });
    parent.append(this.element);
    this.forgetRanges();
    this.shown = null; // what was drawn last
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

  /** Fill the room that there is. */
  resize() {
    this.graph.resize();
  }

  /** Draw the same once more, which dygraphs does only where its size has changed. */
  redraw() {
    const { style, clientWidth } = this.element;
    const { width } = style;
    style.width = `${clientWidth - 1}px`;
    this.resize();
    style.width = width;
    this.resize();
  }

  /** Go away. */
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
   * Find how the vertical axes go, before drawing.
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
   * Draw what {@link prepare} was given.
   * @param {?{y: number, y2: number}} widths of the labels of both axes, for all plots to have the
   *   same edges; 0 where there is no axis; null for one plot alone
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
      // A tick at the very end would be left out.
      dateWindow: [shown.from - shown.reference, shown.to - shown.reference + 1e-9],
      axes: {
        // An axis without a trace has no numbers: the grid is that of the other one.
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
   * Erase all that is drawn, also beside the plot. By itself dygraphs erases only where it is about
   * to draw: of an area that was larger before, as a title or wider numbers have come, an axis would
   * stay. What it has cut the canvas to has to go as well: at broken pixels that erases by halves.
   */
  erase() {
    for (const canvas of this.canvases) {
      const context = canvas.getContext("2d");
      context.restore();
      context.clearRect(0, 0, canvas.width, canvas.height);
      context.save();
    }
  }

  /** Draw what is behind the traces. */
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

  /** Round times, by the clock or from what the axis counts from; written below the lowest plot. */
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

  /** Width of the numbers of an axis: wider if they need many digits. */
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
    const chosen = [low ?? range[0], high ?? range[1]];
    return chosen[0] < chosen[1] ? chosen : range;
  }

  /** Area of the traces: x, y, w and h in the element [pixels]. */
  get area() {
    return this.graph.getArea();
  }

  /**
   * Find where a pointer is.
   * @param {PointerEvent} event
   * @returns {{across: number, up: number}} parts of the area, from the left and from below
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

  /** The ends of the time axis, as it counts [s]. */
  get times() {
    return this.graph.xAxisRange();
  }

  /** The canvases with grid and traces, the lowest first. */
  get canvases() {
    return [...this.element.querySelectorAll("canvas")];
  }
}
