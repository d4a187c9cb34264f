/** Chart of lines over any axis, such as spectra and XY plots; traces over time use dygraphs. */

import { make, themeColour } from "../base/dom.js";
import { AutoRange, figure, ticks } from "../base/numbers.js";

const SPACE = { left: 64, right: 16, top: 40, bottom: 42 }; // around the lines, pixels
const PER_TICK = { x: 90, y: 46 };

/**
 * @typedef {Object} Line
 * @property {string} field
 * @property {Array<?number>} xs
 * @property {Array<?number>} ys null ends the line
 * @property {{x: number, y: number, text: string}[]} marks
 */

/** The least and the greatest finite number. */
function extent(rows) {
  let low = Infinity;
  let high = -Infinity;
  for (const row of rows) {
    for (const value of row) {
      if (!Number.isFinite(value)) continue; // null, too
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return [low, high];
}

/** A canvas with axes. */
export class Chart {
  /**
   * @param {HTMLElement} element to draw in
   * @param {function(string): string} colourOf gives the colour of a field
   * @param {function(string): number[]} dashOf gives its dashes and gaps
   */
  constructor(element, colourOf, dashOf) {
    this.element = element;
    this.colourOf = colourOf;
    this.dashOf = dashOf;
    this.canvas = make("canvas", {});
    this.readout = make("output", { class: "readout", hidden: true });
    element.append(this.canvas, this.readout);
    this.shown = null;
    this.forget();
    element.addEventListener("pointermove", (event) => this.showPlace(event));
    element.addEventListener("pointerleave", () => { this.readout.hidden = true; });
    new ResizeObserver(() => this.redraw()).observe(element);
  }

  /** Reset the ranges of the axes. */
  forget() {
    this.auto = { x: new AutoRange(), y: new AutoRange() };
  }

  /** Redraw. */
  redraw() {
    if (this.shown) this.draw(this.shown);
  }

  /** Interface of the plot, for pictures. */
  get canvases() {
    return [this.canvas];
  }

  /**
   * Draw.
   * @param {{lines: Line[], titles: {x: string, y: string}, isEqual: boolean, exact: boolean}} shown
   *   isEqual: equal scales of both axes; exact: the horizontal axis ends with the lines
   */
  draw(shown) {
    this.shown = shown;
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!width || !height) return;
    const scale = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(width * scale);
    this.canvas.height = Math.round(height * scale);
    this.area = {
      x: SPACE.left, y: SPACE.top, w: width - SPACE.left - SPACE.right, h: height - SPACE.top - SPACE.bottom,
    };
    this.ranges = this.rangesOf(shown);
    const context = this.canvas.getContext("2d");
    context.scale(scale, scale);
    context.font = `11.5px ${getComputedStyle(document.body).fontFamily}`;
    this.drawAxes(context, shown.titles);
    context.save();
    context.beginPath();
    context.rect(this.area.x, this.area.y, this.area.w, this.area.h);
    context.clip();
    for (const line of shown.lines) this.drawLine(context, line);
    context.restore();
    for (const line of shown.lines) this.drawMarks(context, line);
  }

  rangesOf({ lines, isEqual, exact }) {
    const now = performance.now() / 1000;
    const ends = extent(lines.map(({ xs }) => xs));
    const ranges = {
      x: exact && ends[0] < ends[1] ? ends : this.auto.x.update(...ends, now),
      y: this.auto.y.update(...extent(lines.map(({ ys }) => ys)), now),
    };
    if (!isEqual) return ranges;
    const { w, h } = this.area;
    const perPixel = Math.max((ranges.x[1] - ranges.x[0]) / w, (ranges.y[1] - ranges.y[0]) / h);
    const around = ([low, high], pixels) => [
      (low + high - pixels * perPixel) / 2, (low + high + pixels * perPixel) / 2];
    return { x: around(ranges.x, w), y: around(ranges.y, h) };
  }

  /** Return the position of a point on the canvas. */
  place(x, y) {
    const { area, ranges } = this;
    return [
      area.x + ((x - ranges.x[0]) / (ranges.x[1] - ranges.x[0])) * area.w,
      area.y + area.h - ((y - ranges.y[0]) / (ranges.y[1] - ranges.y[0])) * area.h,
    ];
  }

  drawAxes(context, titles) {
    const { area, ranges } = this;
    const { x, y, w, h } = area;
    context.strokeStyle = themeColour("grid");
    context.fillStyle = themeColour("muted");
    context.beginPath();
    context.textBaseline = "top";
    context.textAlign = "center";
    for (const { v, label } of ticks(...ranges.x, w / PER_TICK.x)) {
      const [at] = this.place(v, 0);
      context.moveTo(at, y);
      context.lineTo(at, y + h);
      context.fillText(label, at, y + h + 5);
    }
    context.fillText(titles.x, x + w / 2, y + h + 22);
    context.textBaseline = "middle";
    context.textAlign = "right";
    for (const { v, label } of ticks(...ranges.y, h / PER_TICK.y)) {
      const [, at] = this.place(0, v);
      context.moveTo(x, at);
      context.lineTo(x + w, at);
      context.fillText(label, x - 6, at);
    }
    context.stroke();
    context.save();
    context.translate(9, y + h / 2);
    context.rotate(-Math.PI / 2);
    context.textAlign = "center";
    context.fillText(titles.y, 0, 0);
    context.restore();
  }

  drawLine(context, { field, xs, ys }) {
    context.strokeStyle = this.colourOf(field);
    context.setLineDash(this.dashOf(field));
    context.lineWidth = 1.5;
    context.lineJoin = "round";
    context.beginPath();
    let isDown = false;
    for (let index = 0; index < xs.length; index += 1) {
      const isThere = Number.isFinite(xs[index]) && Number.isFinite(ys[index]);
      if (isThere) context[isDown ? "lineTo" : "moveTo"](...this.place(xs[index], ys[index]));
      isDown = isThere;
    }
    context.stroke();
    context.setLineDash([]);
  }

  drawMarks(context, { field, marks }) {
    context.fillStyle = this.colourOf(field);
    context.textBaseline = "bottom";
    for (const { x, y, text } of marks) {
      const [left, top] = this.place(x, y);
      context.beginPath();
      context.arc(left, top, 3, 0, 2 * Math.PI);
      context.fill();
      const half = context.measureText(text).width / 2;
      context.textAlign = "center";
      const right = this.area.x + this.area.w - half;
      context.fillText(text, Math.min(Math.max(left, this.area.x + half), right), top - 5);
    }
  }

  /** Show the position of the pointer. */
  showPlace(event) {
    if (!this.ranges) return;
    const box = this.element.getBoundingClientRect();
    const { area, ranges } = this;
    const right = (event.clientX - box.left - area.x) / area.w;
    const up = 1 - (event.clientY - box.top - area.y) / area.h;
    this.readout.hidden = !(right >= 0 && right <= 1 && up >= 0 && up <= 1);
    const at = ([low, high], part) => figure(low + part * (high - low));
    this.readout.textContent = `${at(ranges.x, right)}, ${at(ranges.y, up)}`;
  }
}
