/** Two fingers on the plot zoom it: in time, or vertically where they are one above the other. */

import { axisParts, verticals } from "./traces.js";
import { startTwoFingers } from "./two_fingers.js";

/**
 * @param {HTMLElement} stage
 * @param {import("./plots.js").Plots} plots
 * @param {import("./view.js").View} view
 */
export function startPinch(stage, plots, view) {
  startTwoFingers(stage, ({ factor, x, y, across, upright }) => {
    const middle = { clientX: x, clientY: y };
    const plot = plots.under(middle);
    const place = plot.at(middle);
    if (!upright) {
      view.zoomX(1 / factor, place.across);
      if (view.state.values.end !== null) view.panX(-across / plot.area.w);
      return;
    }
    const axes = verticals(view.state.values).filter((axis) => axisParts(axis)[1] === plot.number);
    for (const axis of axes) view.zoomY(axis, 1 / factor, place.up);
  });
}
