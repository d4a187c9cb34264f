/** Wheel, drag and double click on the plot. */

const ZOOM_PER_PIXEL = 0.0015;

/**
 * Tell which axis a pointer is over.
 * @returns {"x"|"y"|"y2"}
 */
function axisUnder(plot, box, event) {
  const area = plot.area;
  const x = event.clientX - box.left - area.x;
  if (x < 0) return "y";
  if (x > area.w) return "y2";
  return event.shiftKey ? "y" : "x";
}

/**
 * Zoom by the wheel, move by dragging, reset by a double click; over a vertical axis, or with
 * the shift key, vertically.
 * @param {HTMLElement} stage
 * @param {import("./plot.js").Plot} plot
 * @param {import("./view.js").View} view
 */
export function startGestures(stage, plot, view) {
  const box = () => plot.element.getBoundingClientRect();

  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    const { x, y, w, h } = plot.area;
    const { left, top } = box();
    const wheel = event.deltaY || event.deltaX; // with shift, some systems turn the wheel
    const pixels = wheel * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1);
    const factor = Math.exp(Math.min(Math.max(pixels, -300), 300) * ZOOM_PER_PIXEL);
    const axis = axisUnder(plot, box(), event);
    if (axis === "x") view.zoomX(factor, (event.clientX - left - x) / w);
    else verticals(axis, event).forEach((name) =>
      view.zoomY(name, factor, 1 - (event.clientY - top - y) / h));
  }, { passive: false });

  /** With the shift key both vertical axes move together. */
  function verticals(axis, event) {
    if (axis === "y2" || !event.shiftKey) return [axis];
    return view.state.values.right.size ? ["y", "y2"] : ["y"];
  }

  let drag = null;
  stage.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || event.target.closest(".handle, .readout, .chart-controls")) return;
    drag = { axis: axisUnder(plot, box(), event), x: event.clientX, y: event.clientY };
    stage.setPointerCapture(event.pointerId);
  });
  stage.addEventListener("pointermove", (event) => {
    if (!drag) return;
    stage.dataset.drag = drag.axis;
    const { w, h } = plot.area;
    const across = event.clientX - drag.x;
    const down = event.clientY - drag.y;
    if (drag.axis === "x" && across) view.panX(-across / w);
    if (drag.axis !== "x" && down) {
      verticals(drag.axis, event).forEach((name) => view.panY(name, down / h));
    }
    drag = { ...drag, x: event.clientX, y: event.clientY };
  });
  for (const end of ["pointerup", "pointercancel"]) {
    stage.addEventListener(end, () => {
      drag = null;
      delete stage.dataset.drag;
    });
  }
  stage.addEventListener("dblclick", (event) => {
    if (!event.target.closest(".handle, .readout")) view.reset();
  });
}
