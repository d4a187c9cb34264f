/** Draws robots and their world on a canvas. */

import { niceStep, tickText } from "../base/numbers.js";

const GRID = 90; // pixels between lines, at least
const ROBOT = 0.14; // radius of a robot's sign, m
const LEAST = 9; // and in pixels
const FONT = "12px system-ui, sans-serif";

const colour = ([red, green, blue, alpha]) =>
  `rgba(${[red, green, blue].map((part) => Math.round(part * 255)).join()},${alpha})`;

/** Turn a flat list of coordinates into pairs. */
const pairs = (flat) => Array.from({ length: flat.length / 2 }, (_, index) =>
  [flat[2 * index], flat[2 * index + 1]]);

/** Drawing of one picture; all sizes except lines and texts are in metres. */
export class Drawing {
  /**
   * @param {CanvasRenderingContext2D} context
   * @param {import("./camera.js").Camera} camera
   * @param {function(string): string} style gives a colour of the page by its name
   */
  constructor(context, camera, style) {
    this.context = context;
    this.camera = camera;
    this.style = style;
  }

  /** Begin a picture. */
  clear(ratio) {
    const { context, camera } = this;
    const { scale, width, height, x, y } = camera;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = this.style("screen");
    context.fillRect(0, 0, width, height);
    this.grid();
    context.translate(width / 2 - x * scale, height / 2 + y * scale);
    context.scale(scale, -scale);
    this.pixel = 1 / scale;
  }

  grid() {
    const { context, camera } = this;
    const step = niceStep(GRID / camera.scale);
    const [left, top] = camera.toWorld(0, 0);
    const [right, bottom] = camera.toWorld(camera.width, camera.height);
    context.font = "11px system-ui, sans-serif";
    context.lineWidth = 1;
    const line = (value, from, to, label) => {
      context.strokeStyle = this.style(Math.abs(value) < step / 1e6 ? "axis" : "grid");
      context.beginPath();
      context.moveTo(...from);
      context.lineTo(...to);
      context.stroke();
      context.fillStyle = this.style("muted");
      context.fillText(tickText(value, step), ...label);
    };
    for (let n = Math.ceil(left / step); n * step <= right; n += 1) {
      const [across] = camera.toPicture(n * step, 0);
      line(n * step, [across, 0], [across, camera.height], [across + 3, camera.height - 4]);
    }
    for (let n = Math.ceil(bottom / step); n * step <= top; n += 1) {
      const [, down] = camera.toPicture(0, n * step);
      line(n * step, [0, down], [camera.width, down], [3, down - 3]);
    }
  }

  /** Draw in the frame of a robot, with x forward. */
  at({ x, y, heading }, draw) {
    const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
    this.inside([cos, sin, -sin, cos, x, y], draw);
  }

  /** Draw in a frame. */
  inside(at, draw) {
    this.context.save();
    this.context.transform(...at);
    draw();
    this.context.restore();
  }

  /** Draw a line through places. */
  line(places, stroke, width = 1.5, dash = []) {
    const { context } = this;
    context.beginPath();
    places.forEach(([x, y], index) => (index ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.strokeStyle = stroke;
    context.lineWidth = width * this.pixel;
    context.setLineDash(dash.map((part) => part * this.pixel));
    context.stroke();
    context.setLineDash([]);
  }

  disc(x, y, radius) {
    this.context.beginPath();
    this.context.ellipse(x, y, radius, radius, 0, 0, 2 * Math.PI);
    this.context.fill();
  }

  /** Return the width of a text [pixels]. */
  widthOf(text) {
    this.context.font = FONT;
    return this.context.measureText(text).width;
  }

  /** Draw text beside a place, upright and of constant size. */
  text(text, x, y, fill, lower = 0) {
    const { context } = this;
    context.save();
    context.translate(x, y);
    const { a, b, c, d, e, f } = context.getTransform();
    const ratio = Math.sqrt(Math.abs(a * d - b * c)) * this.pixel;
    context.setTransform(ratio, 0, 0, ratio, e, f);
    context.font = FONT;
    context.fillStyle = fill;
    context.fillText(text, 12, lower - 10);
    context.restore();
  }

  /** Draw a marker of visualization_msgs. */
  marker({ kind, at, size, points, text, colour: parts }) {
    const { context } = this;
    const [width, height] = size;
    const paint = this.readable(parts);
    context.fillStyle = paint;
    const box = (x, y) => context.fillRect(x - width / 2, y - height / 2, width, height);
    const disc = (x, y) => this.disc(x, y, width / 2);
    const each = (draw) => pairs(points).forEach(([x, y]) => draw(x, y));
    const thick = Math.max(1.5, width / this.pixel);
    const draws = {
      box: () => box(0, 0),
      disc: () => disc(0, 0),
      boxes: () => each(box),
      dots: () => each(box),
      discs: () => each(disc),
      strip: () => this.line(pairs(points), paint, thick),
      lines: () => {
        const ends = pairs(points);
        for (let n = 0; n + 1 < ends.length; n += 2) this.line(ends.slice(n, n + 2), paint, thick);
      },
      arrow: () => {
        const ends = points.length >= 4 ? pairs(points).slice(0, 2) : [[0, 0], [width, 0]];
        this.line(ends, paint, 3);
      },
      text: () => this.text(text, 0, 0, paint),
    };
    this.inside(at, draws[kind]);
  }

  /** Colour of a marker, lightened if it is as dark as the dark theme. */
  readable(parts) {
    const [red, green, blue, alpha] = parts;
    const isGrey = Math.abs(red - green) + Math.abs(green - blue) < 0.1;
    return isGrey && alpha > 0.5 ? this.style("muted") : colour(parts);
  }

  /** Draw a laser scan. */
  scan({ at, first, step, ranges }, fill) {
    this.context.fillStyle = fill;
    const size = 3 * this.pixel;
    this.inside(at, () => ranges.forEach((range, index) => {
      if (!range) return;
      const angle = first + index * step;
      const x = (range / 1000) * Math.cos(angle);
      const y = (range / 1000) * Math.sin(angle);
      this.context.fillRect(x - size / 2, y - size / 2, size, size);
    }));
  }

  /** Draw a robot: a disc with a nose; faint if it is silent, or another odometry of a robot. */
  robot(robot, fill, isFaint) {
    const { context } = this;
    const radius = Math.max(ROBOT, LEAST * this.pixel);
    context.globalAlpha = isFaint ? 0.35 : 1;
    this.at(robot, () => {
      context.fillStyle = fill;
      this.disc(0, 0, radius * 0.75);
      context.beginPath();
      context.moveTo(radius * 1.5, 0);
      context.lineTo(radius * 0.3, radius * 0.7);
      context.lineTo(radius * 0.3, -radius * 0.7);
      context.fill();
      this.line([[0, 0], [radius * 1.2, 0]], this.style("screen"), 2);
    });
    context.globalAlpha = 1;
  }

  /** Draw a goal: a cross-hair with an arrow, faint until it is published. */
  goal(goal, name, isFaint = false) {
    const { context } = this;
    const size = Math.max(ROBOT, LEAST * this.pixel);
    const paint = this.style("warn");
    context.globalAlpha = isFaint ? 0.5 : 1;
    this.at(goal, () => {
      this.line([[0, -size], [0, size]], paint, 2);
      this.line([[-size, 0], [2 * size, 0]], paint, 2);
      this.line([[1.6 * size, 0.3 * size], [2 * size, 0], [1.6 * size, -0.3 * size]], paint, 2);
    });
    this.text(name, goal.x, goal.y, paint);
    context.globalAlpha = 1;
  }
}

/** Turn the points of a path into places. */
export const placesOf = (path) => pairs(path.points);
