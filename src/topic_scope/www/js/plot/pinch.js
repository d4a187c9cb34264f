/** Two fingers on a plot zoom it: in time, or vertically where they are one above the other. */

import { axisParts, verticals } from "../state/traces.js";
import { startTwoFingers } from "../base/two_fingers.js";

/**
 * @param {HTMLElement} stage
 * @param {import("./plots.js").Plots} plots
 * @param {import("../state/view.js").View} view
 */
export function startPinch(stage, plots, view) {
  startTwoFingers(stage, ({ factor, x, y, across, upright }) => {
    const point = { clientX: x, clientY: y };
    const plot = plots.under(point);
    const place = plot.at(point);
    const { values } = view.state;
    if (!upright) {
      view.zoomX(1 / factor, place.across);
      if (values.end !== null) view.panX(-across / plots.area.w);
      return;
    }
    for (const axis of verticals(values)) {
      if (axisParts(axis)[1] === plot.number) view.zoomY(axis, 1 / factor, place.up);
    }
  });
}
