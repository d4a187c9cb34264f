/** Line over the plot that can be dragged, or moved with the arrow keys. */

import { make } from "../base/dom.js";
import { clamp } from "../base/numbers.js";

const STEP = 0.005; // of the axis, with an arrow key
const LARGE_STEP = 0.05; // the same with shift

/** One line, across or along the plot. */
export class Handle {
  /**
   * @param {HTMLElement} overlay
   * @param {{kind: "cursor"|"level"|"level-cursor", name: string, label: string,
   *   move: function(number): void}} options kind: cursor is a vertical line, the others are
   *   horizontal; name: for screen readers; label: its text; move: takes the new
   *   position, 0 to 1 from the left or from below
   */
  constructor(overlay, options) {
    this.overlay = overlay;
    this.options = options;
    this.upright = options.kind === "cursor";
    this.label = make("b", {}, options.label);
    this.part = 0;
    this.element = make("div", {
      class: `handle ${options.kind}`,
      role: "slider",
      tabindex: 0,
      "aria-label": options.name,
      "aria-orientation": this.upright ? "horizontal" : "vertical",
      hidden: true,
      keydown: (event) => this.onKey(event),
      pointerdown: (event) => {
        this.element.setPointerCapture(event.pointerId);
        this.element.focus();
        event.stopPropagation();
      },
      pointermove: (event) => {
        if (this.element.hasPointerCapture(event.pointerId)) this.onDrag(event);
      },
    }, this.label);
    overlay.append(this.element);
  }

  /**
   * Set the position of the line.
   * @param {?number} part 0 to 1 from the left or from below; null, or outside: hidden
   * @param {number} value
   * @param {string} text the value as text
   */
  place(part, value, text) {
    this.element.hidden = part === null || !(part >= -1e-6 && part <= 1 + 1e-6);
    if (this.element.hidden) return;
    this.part = part;
    const percent = `${100 * (this.upright ? part : 1 - part)}%`;
    this.element.style[this.upright ? "left" : "top"] = percent;
    this.element.setAttribute("aria-valuenow", value);
    this.element.setAttribute("aria-valuetext", text);
  }

  onDrag(event) {
    const box = this.overlay.getBoundingClientRect();
    const part = this.upright
      ? (event.clientX - box.left) / box.width
      : (box.bottom - event.clientY) / box.height;
    this.options.move(clamp(part, 0, 1));
  }

  onKey(event) {
    const more = this.upright ? "ArrowRight" : "ArrowUp";
    const less = this.upright ? "ArrowLeft" : "ArrowDown";
    if (event.key !== more && event.key !== less) return;
    event.preventDefault();
    event.stopPropagation();
    const step = (event.shiftKey ? LARGE_STEP : STEP) * (event.key === more ? 1 : -1);
    this.options.move(clamp(this.part + step, 0, 1));
  }
}
