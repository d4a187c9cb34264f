/** Choice of a trace's plot: in its row, or by dragging its name onto a plot. */

import { byId, make, options } from "../base/dom.js";
import { choose, chosenOf, plotCount, PLOTS } from "../state/traces.js";

const FAR = 6; // pixels of movement that start a drag

/** Number for a new plot; null if a trace cannot have one. */
function nextPlot(values, field) {
  const { plot } = chosenOf(values, field);
  const isAlone = !values.fields.some((other) => other !== field && chosenOf(values, other).plot === plot);
  const next = plotCount(values) + 1;
  return isAlone || next > PLOTS ? null : next;
}

/**
 * Make the list of plots that a trace can be in.
 * @param {import("../state/store.js").State} state
 * @param {string} field
 * @returns {HTMLSelectElement}
 */
export function plotChoice(state, field) {
  const next = nextPlot(state.values, field);
  const numbers = Array.from({ length: plotCount(state.values) }, (_, index) => index + 1);
  const select = make("select", {
    class: "plots",
    "aria-label": `plot of ${field}`,
    "data-control": `plot ${field}`,
    title: "plot of this trace",
    change: () => choose(state, field, { plot: Number(select.value) }),
  }, ...options([...numbers, ...(next ? [[next, "new"]] : [])]));
  select.value = String(chosenOf(state.values, field).plot);
  return select;
}

/**
 * Make a trace draggable to another plot, or to a new one.
 * @param {HTMLElement} handle the element to drag
 * @param {import("../state/store.js").State} state
 * @param {string} field
 */
export function startDrag(handle, state, field) {
  let from = null; // position where the pointer was pressed
  let isDragging = false;

  const stage = byId("stage");
  const room = byId("new-plot");

  /** Number of the plot under the pointer; null outside of all plots. */
  function target({ clientX: x, clientY: y }) {
    const isIn = (element) => {
      const box = element.getBoundingClientRect();
      return x >= box.left && x <= box.right && y >= box.top && y <= box.bottom;
    };
    if (!room.hidden && isIn(room)) return nextPlot(state.values, field);
    const index = isIn(stage) ? [...stage.querySelectorAll(".pane")].findIndex(isIn) : -1;
    return index < 0 ? null : index + 1;
  }

  function end() {
    from = null;
    isDragging = false;
    room.hidden = true;
    document.documentElement.classList.remove("dragging");
    stage.querySelectorAll(".pane.over").forEach((pane) => pane.classList.remove("over"));
    room.classList.remove("over");
  }

  handle.addEventListener("pointerdown", (event) => {
    // A finger scrolls the table; touch users have the list in the row.
    if (event.button !== 0 || event.pointerType === "touch" || state.values.chart.kind !== "time") return;
    from = event;
    handle.setPointerCapture(event.pointerId);
    // On the document, because the row may be rebuilt meanwhile.
    document.addEventListener("lostpointercapture", end, { once: true });
  });
  handle.addEventListener("pointermove", (event) => {
    if (!from) return;
    if (!isDragging && Math.hypot(event.clientX - from.clientX, event.clientY - from.clientY) < FAR) return;
    isDragging = true;
    document.documentElement.classList.add("dragging");
    room.hidden = nextPlot(state.values, field) === null;
    const over = target(event);
    stage.querySelectorAll(".pane").forEach((pane, index) => pane.classList.toggle("over", over === index + 1));
    room.classList.toggle("over", over !== null && over > plotCount(state.values));
  });
  handle.addEventListener("pointerup", (event) => {
    const plot = isDragging ? target(event) : null;
    end();
    if (plot !== null) choose(state, field, { plot });
  });
}
