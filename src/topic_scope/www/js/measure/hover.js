/** Readout of the time and the values under the pointer. */

import { clockText } from "../base/clock.js";
import { byId, make, nameText } from "../base/dom.js";
import { figure, readingText } from "../base/numbers.js";
import { sampleOf } from "../state/colours.js";
import { isState, spanAt, spansOf } from "../state/states.js";
import { scaledText } from "../state/traces.js";

const BESIDE = 12; // pixels from the pointer

/** Line at the pointer, with the values of the traces. */
export class Hover {
  /**
   * @param {HTMLElement} stage
   * @param {HTMLElement} overlay of the plot
   * @param {import("../state/store.js").State} state
   * @param {import("../plot/stack.js").Plots} plot
   * @param {function(string): number} spreadOf returns the peak-to-peak value of a trace
   */
  constructor(stage, overlay, state, plot, spreadOf) {
    Object.assign(this, { overlay, state, plot, spreadOf });
    this.part = null; // position as a fraction of the plot's width
    this.line = make("i", { class: "hover-line", hidden: true });
    this.box = make("div", { class: "hover", hidden: true });
    overlay.append(this.line, this.box);
    stage.addEventListener("pointermove", (event) => this.onMove(event));
    for (const name of ["pointerleave", "pointerdown"]) stage.addEventListener(name, () => this.hide());
    plot.onDrawn(() => this.show());
  }

  hide() {
    this.part = null;
    this.show();
  }

  onMove(event) {
    const { left, width, top, height } = this.overlay.getBoundingClientRect();
    const part = (event.clientX - left) / width;
    const bands = byId("bands").getBoundingClientRect(); // height 0 without states
    const bottom = Math.max(top + height, bands.bottom);
    const isIn = part >= 0 && part <= 1 && event.clientY >= top && event.clientY <= bottom;
    this.part = isIn && !event.buttons && event.pointerType !== "touch" ? part : null;
    this.show();
  }

  show() {
    const { shown } = this.plot;
    const fields = this.state.shown;
    const isShown = this.part !== null && shown !== null && fields.length > 0;
    this.line.hidden = this.box.hidden = !isShown;
    if (!isShown) return;
    const time = shown.from + this.part * (shown.to - shown.from);
    const text = (field) => {
      if (isState(field)) return this.stateText(field, time, shown);
      const { value, uncertainty } = readingText(shown.buffer.at(field, time), this.spreadOf(field));
      return uncertainty ? `${value} ± ${uncertainty}` : value;
    };
    const scaled = (field) => {
      const text = scaledText(this.state.values, field);
      return text && make("em", { class: "scaled" }, text);
    };
    this.box.replaceChildren(make("b", {}, this.timeText(time, shown)), ...fields.flatMap((field) => [
      make("i", { style: `background: ${sampleOf(this.state, field)}` }),
      make("span", {}, nameText(field), scaled(field)), make("span", { class: "figure" }, text(field)),
    ]));
    this.line.style.left = `${100 * this.part}%`;
    const isRight = this.part > 0.5;
    const beside = `calc(${100 * (isRight ? 1 - this.part : this.part)}% + ${BESIDE}px)`;
    this.box.style.left = isRight ? "auto" : beside;
    this.box.style.right = isRight ? beside : "auto";
  }

  /** Text of the state at a time, with its start and end. */
  stateText(field, time, shown) {
    const span = spanAt(spansOf(shown.buffer.states, field), time);
    if (!span) return "–";
    const since = `since ${this.timeText(span.from, shown)}${span.isEarlier ? " or earlier" : ""}`;
    return `${span.text}, ${since}, ${span.isOpen ? "still so" : `until ${this.timeText(span.to, shown)}`}`;
  }

  timeText(time, { from, to, reference }) {
    if (this.state.values.axes.x.clock) return clockText(time, (to - from) / 500);
    return `${figure(time - reference)} s`;
  }
}
