/** Draws what a sweep shows with dygraphs, and knows where on the screen a value is. */

import { clockTicks, zoneText } from "./clock.js";
import { AutoRange, ticks } from "./numbers.js";

/* global Dygraph */

const STYLE_NAMES = ["grid", "axis"];
const PIXELS_PER_TICK = { x: 90, y: 46, y2: 46 };
const LABEL_WIDTH = 58;
const LETTER = 7; // pixels, of a label
const SPARSE_PIXELS = 9; // samples at least so far apart are marked
const OUTSIDE = /^\d+ points out of [XY] bounds:/;

/**
 * Draw without a word on the console about samples that lie outside of what is shown: that of
 * Debian 13 says so with each drawing, but it is what a plot is moved and magnified for.
 * @param {function(): void} drawing
 */
function drawQuietly(drawing) {
  const { warn } = console;
  console.warn = (...words) => OUTSIDE.test(words[0]) || warn.apply(console, words);
  try {
    drawing();
  } finally {
    console.warn = warn;
  }
}

/** The plot. */
export class Plot {
  /**
   * @param {HTMLElement} element to draw in
   * @param {import("./state.js").State} state
   * @param {function(string): string} colourOf tells the colour of a field
   */
  constructor(element, state, colourOf) {
    this.element = element;
    this.state = state;
    this.colourOf = colourOf;
    this.auto = { y: new AutoRange(), y2: new AutoRange() };
    this.listeners = [];
    this.shown = null; // what was drawn last
    const axis = (name) => ({
      ticker: (low, high, pixels) => ticks(low, high, pixels / PIXELS_PER_TICK[name]),
      axisLabelWidth: LABEL_WIDTH,
      drawGrid: name !== "y2",
    });
    this.graph = new Dygraph(element, [[0, null]], {
      labels: ["time", " "],
      axes: { x: { ...axis("x"), axisLabelWidth: 90, ticker: (...ends) => this.timeTicks(...ends) }, y: axis("y"), y2: axis("y2") },
      connectSeparatedPoints: true,
      gridLineWidth: 1,
      highlightCircleSize: 0,
      interactionModel: {},
      labelsKMB: false,
      legend: "never",
      rightGap: 6,
      strokeWidth: 1.5,
      pointSize: 2,
      xLabelHeight: 20,
      yLabelWidth: 20,
    });
    state.on(["fields", "right"], () => this.forgetRanges());
    state.on(["theme"], () => this.restyle());
    this.restyle();
    new ResizeObserver(() => drawQuietly(() => this.graph.resize())).observe(element);
  }

  /**
   * Have a function called after each drawing.
   * @param {function(): void} listener
   */
  onDrawn(listener) {
    this.listeners.push(listener);
  }

  forgetRanges() {
    this.auto = { y: new AutoRange(), y2: new AutoRange() };
  }

  restyle() {
    const style = getComputedStyle(document.documentElement);
    const [grid, axis] = STYLE_NAMES.map((name) => style.getPropertyValue(`--${name}`).trim());
    this.graph.updateOptions({ gridLineColor: grid, axisLineColor: axis }, true);
  }

  /**
   * Draw.
   * @param {{buffer: import("./buffer.js").TraceBuffer, reference: number, from: number,
   *   to: number}} shown
   */
  draw(shown) {
    const fields = this.state.shown;
    const { axes, right } = this.state.values;
    const onLeft = fields.filter((field) => !right.has(field));
    const onlyRight = fields.length > 0 && !onLeft.length;
    this.shown = shown;
    const ranges = {
      y: this.rangeFor("y", onLeft),
      y2: this.rangeFor("y2", fields.filter((field) => right.has(field))),
    };
    const options = {
      file: shown.buffer.rows(fields.length ? fields : [" "], shown.reference),
      labels: ["time", ...(fields.length ? fields : [" "])],
      series: this.series(fields, shown.buffer),
      // A tick at the very end would be left out.
      dateWindow: [shown.from - shown.reference, shown.to - shown.reference + 1e-9],
      axes: {
        // An axis without a trace has nothing to say: the grid is that of the other one.
        y: {
          valueRange: ranges.y,
          drawAxis: !onlyRight,
          drawGrid: !onlyRight,
          axisLabelWidth: this.labelWidth(ranges.y),
        },
        y2: {
          valueRange: ranges.y2,
          axisLabelWidth: this.labelWidth(ranges.y2),
          drawGrid: onlyRight,
          independentTicks: onlyRight,
        },
      },
      xlabel: this.timeTitle(axes.x),
      ylabel: axes.y.title || null,
      y2label: axes.y2.title || null,
    };
    this.erase();
    drawQuietly(() => this.graph.updateOptions(options));
    for (const listener of this.listeners) listener();
  }

  /**
   * Take away what is drawn. By itself dygraphs erases only where it is about to draw: of an area
   * that was larger before, as a title or wider numbers have come, an axis would stay. What it has
   * cut the canvas to has to go as well, since at broken pixels that erases by halves.
   */
  erase() {
    for (const canvas of this.canvases) {
      const context = canvas.getContext("2d");
      context.restore();
      context.clearRect(0, 0, canvas.width, canvas.height);
      context.save();
    }
  }

  series(fields, buffer) {
    const series = {};
    const most = this.area.w / SPARSE_PIXELS;
    for (const field of fields) {
      series[field] = {
        axis: this.axisOf(field),
        color: this.colourOf(field),
        drawPoints: buffer.filled(field) < most,
      };
    }
    return series;
  }

  /** Round times, by the clock or from what the axis counts from. */
  timeTicks(low, high, pixels) {
    const most = pixels / PIXELS_PER_TICK.x;
    if (!this.state.values.axes.x.clock || !this.shown) return ticks(low, high, most);
    const { reference } = this.shown;
    return clockTicks(reference + low, reference + high, most)
      .map(({ v, label }) => ({ v: v - reference, label }));
  }

  timeTitle({ title, clock }) {
    if (!clock) return title || null;
    return `${title === "time, s" ? "time" : title}, ${zoneText(this.shown.to)}`;
  }

  /** How wide the numbers of an axis are: more than usual where they need many digits. */
  labelWidth([low, high]) {
    const labels = ticks(low, high, this.area.h / PIXELS_PER_TICK.y).map(({ label }) => label.length);
    return Math.max(LABEL_WIDTH, LETTER * Math.max(0, ...labels));
  }

  rangeFor(axis, fields) {
    const { low, high } = this.state.values.axes[axis];
    const { buffer, from, to } = this.shown;
    const extent = buffer.extent(fields, from, to);
    const range = this.auto[axis].update(extent[0], extent[1], performance.now() / 1000);
    const chosen = [low ?? range[0], high ?? range[1]];
    return chosen[0] < chosen[1] ? chosen : range;
  }

  /**
   * Tell which vertical axis a field is on.
   * @param {string} field
   * @returns {"y"|"y2"}
   */
  axisOf(field) {
    return this.state.values.right.has(field) ? "y2" : "y";
  }

  /** Where the traces are: x, y, w and h in the element, pixels. */
  get area() {
    return this.graph.getArea();
  }

  /**
   * Tell the ends of a vertical axis.
   * @param {"y"|"y2"} axis
   * @returns {[number, number]}
   */
  range(axis) {
    const ranges = this.graph.yAxisRanges();
    return ranges[axis === "y2" ? ranges.length - 1 : 0];
  }

  /** The ends of the time axis, as it counts, s. */
  get times() {
    return this.graph.xAxisRange();
  }

  /** The canvases with grid and traces, the lowest first. */
  get canvases() {
    return [...this.element.querySelectorAll("canvas")];
  }
}
