/** Two fingers on the plot zoom it: in time, or vertically where they are one above the other. */

import { startTwoFingers } from "./two_fingers.js";

/**
 * @param {HTMLElement} stage
 * @param {{element: HTMLElement, area: Object}} plot
 * @param {import("./view.js").View} view
 */
export function startPinch(stage, plot, view) {
  startTwoFingers(stage, ({ factor, x, y, across, upright }) => {
    const { left, top } = plot.element.getBoundingClientRect();
    const { area } = plot;
    if (!upright) {
      view.zoomX(1 / factor, (x - left - area.x) / area.w);
      if (view.state.values.end !== null) view.panX(-across / area.w);
      return;
    }
    const axes = view.state.values.right.size ? ["y", "y2"] : ["y"];
    for (const axis of axes) view.zoomY(axis, 1 / factor, 1 - (y - top - area.y) / area.h);
  });
}
