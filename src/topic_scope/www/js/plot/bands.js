/** Bands of states below the plots, coloured by text. */

import { byId, make, themeColour } from "../base/dom.js";
import { paletteColour } from "../state/colours.js";
import { isState, placeOf, spansOf } from "../state/states.js";

const ROW = 38; // height of a band and its name, pixels
const NAME = 15;
const MARGIN = 4; // between a text and the ends of its span

/** Bands of the visible states, over the time axis of the plots. */
export class Bands {
  /**
   * @param {HTMLElement} element
   * @param {import("../state/store.js").State} state
   * @param {import("./stack.js").Plots} plots
   */
  constructor(element, state, plots) {
    Object.assign(this, { element, state, plots });
    this.canvas = make("canvas", {});
    element.append(this.canvas);
    state.on(["fields", "hidden", "chart"], () => this.fit());
    plots.onDrawn(() => this.draw());
    this.fit();
  }

  /** The visible states. */
  get fields() {
    return this.state.values.chart.kind === "time" ? this.state.shown.filter(isState) : [];
  }

  /** Set the height to the number of states. */
  fit() {
    const height = ROW * this.fields.length;
    this.element.hidden = !height;
    this.element.style.height = `${height}px`;
    byId("stage").style.setProperty("--bands", `${height}px`);
  }

  draw() {
    const { element, canvas, plots, fields } = this;
    const { shown } = plots;
    if (!fields.length || !shown) return;
    const scale = window.devicePixelRatio || 1;
    const { clientWidth: width, clientHeight: height } = element;
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
    const context = canvas.getContext("2d");
    context.scale(scale, scale);
    context.font = `11.5px ${getComputedStyle(document.body).fontFamily}`;
    context.textBaseline = "middle";
    const left = plots.element.offsetLeft + plots.area.x - element.offsetLeft;
    fields.forEach((field, row) => this.drawRow(context, field, { x: left, y: row * ROW, w: plots.area.w }, shown));
  }

  drawRow(context, field, { x, y, w }, { buffer, from, to }) {
    context.fillStyle = themeColour("muted");
    context.fillText(field, x, y + NAME / 2);
    const top = y + NAME;
    const height = ROW - NAME - 3;
    const across = (time) => x + w * Math.min(Math.max((time - from) / (to - from), 0), 1);
    for (const span of spansOf(buffer.states, field)) {
      if (span.to <= from || span.from >= to) continue;
      const [start, end] = [across(span.from), across(span.to)];
      context.fillStyle = span.isSeveral ? themeColour("grid") : paletteColour(this.state, placeOf(span.text));
      context.fillRect(start, top, Math.max(end - start, 1), height);
      context.fillStyle = span.isSeveral ? themeColour("text") : themeColour("screen");
      context.fillRect(start, top, Math.min(1, (end - start) / 2), height); // neighbours may share a colour
      if (context.measureText(span.text).width + 2 * MARGIN < end - start) {
        context.fillText(span.text, start + MARGIN, top + height / 2);
      }
    }
  }
}
