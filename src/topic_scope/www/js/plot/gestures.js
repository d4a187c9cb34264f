/** Wheel, drag, pinch and double click on the plot. */

import { startTwoFingers, wheelFactor } from "../base/pointers.js";
import { axisName, axisParts, verticals } from "../state/traces.js";

/**
 * Return the axis under a pointer.
 * @returns {string} "x", or the name of a vertical axis, see traces.js
 */
function axisUnder(plots, event) {
  const plot = plots.under(event);
  const { across } = plot.at(event);
  if (across < 0) return axisName("y", plot.number);
  if (across > 1) return axisName("y2", plot.number);
  return event.shiftKey ? axisName("y", plot.number) : "x";
}

/**
 * Zoom by the wheel, move by dragging, reset by a double click; over a vertical axis, or with
 * the shift key, vertically. Two fingers zoom, vertically if they are one above the other.
 * @param {HTMLElement} stage
 * @param {import("./stack.js").Plots} plots
 * @param {import("../state/view.js").View} view
 */
export function startGestures(stage, plots, view) {
  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    const factor = wheelFactor(event, event.deltaY || event.deltaX); // with shift, some systems swap the axes
    const axis = axisUnder(plots, event);
    const { across, up } = plots.under(event).at(event);
    if (axis === "x") view.zoomX(factor, across);
    else together(axis, event).forEach((name) => view.zoomY(name, factor, up));
  }, { passive: false });

  /** With the shift key both vertical axes of a plot move together. */
  function together(axis, event) {
    const [side, plot] = axisParts(axis);
    return side === "y2" || !event.shiftKey ? [axis] : axesOf(plot);
  }

  function axesOf(plot) {
    return verticals(view.state.values).filter((name) => axisParts(name)[1] === plot);
  }

  let drag = null;
  stage.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || event.target.closest(".handle, .readout, .chart-controls")) return;
    drag = { axis: axisUnder(plots, event), x: event.clientX, y: event.clientY };
    stage.setPointerCapture(event.pointerId);
  });
  stage.addEventListener("pointermove", (event) => {
    if (!drag) return;
    stage.dataset.drag = drag.axis;
    const { w, h } = plots.plotOf(drag.axis).area;
    const across = event.clientX - drag.x;
    const down = event.clientY - drag.y;
    if (drag.axis === "x" && across) view.panX(-across / w);
    if (drag.axis !== "x" && down) {
      together(drag.axis, event).forEach((name) => view.panY(name, down / h));
    }
    drag = { ...drag, x: event.clientX, y: event.clientY };
  });
  for (const end of ["pointerup", "pointercancel"]) {
    stage.addEventListener(end, () => {
      drag = null;
      delete stage.dataset.drag;
    });
  }
  startTwoFingers(stage, ({ factor, x, y, across, upright }) => {
    const point = { clientX: x, clientY: y };
    const plot = plots.under(point);
    const place = plot.at(point);
    if (upright) {
      axesOf(plot.number).forEach((axis) => view.zoomY(axis, 1 / factor, place.up));
      return;
    }
    view.zoomX(1 / factor, place.across);
    if (view.state.values.end !== null) view.panX(-across / plots.area.w);
  });
  stage.addEventListener("dblclick", (event) => {
    if (!event.target.closest(".handle, .readout")) view.reset();
  });
}
