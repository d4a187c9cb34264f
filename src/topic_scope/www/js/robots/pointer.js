/** Wheel, drag, pinch and click on the picture of the world. */

import { wheelFactor } from "../base/pointers.js";

const CLICK = 5; // largest movement of a click, pixels

/**
 * Move and zoom a picture, and report clicks that set a goal.
 * @param {HTMLElement} canvas
 * @param {{camera: import("./camera.js").Camera, picksGoal: function(): boolean,
 *   moved: function(): void, aim: function(?{x: number, y: number, heading: ?number}): void,
 *   pick: function({x: number, y: number, heading: ?number}): void,
 *   over: function(number, number): void}} acts moved: the user has moved the picture; aim: a goal
 *   is being dragged; pick: it is set, with a heading if it was dragged; over: position of the
 *   pointer [m]
 */
export function startPointer(canvas, { camera, picksGoal, moved, aim, pick, over }) {
  const pointers = new Map();
  let start = null; // start of a press that sets a goal, in pixels

  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const middle = (ends) => [0, 1].map((axis) =>
    ends.reduce((sum, end) => sum + end[axis], 0) / ends.length);
  const spread = ([a, b]) => (b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 1);

  /** Goal from the start of the press to the pointer. */
  const goal = (end) => {
    const [x, y] = camera.toWorld(...start);
    const [across, down] = [end[0] - start[0], end[1] - start[1]];
    const far = Math.hypot(across, down) > CLICK;
    return { x, y, heading: far ? Math.atan2(-down, across) : null };
  };

  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    camera.zoom(1 / wheelFactor(event), ...at(event));
    moved();
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, at(event));
    start = picksGoal() && pointers.size === 1 ? at(event) : null;
  });
  canvas.addEventListener("pointermove", (event) => {
    const here = at(event);
    over(...camera.toWorld(...here));
    if (!pointers.has(event.pointerId)) return;
    const before = [...pointers.values()];
    pointers.set(event.pointerId, here);
    if (start) {
      aim(goal(here));
      return;
    }
    const after = [...pointers.values()];
    const [from, to] = [middle(before), middle(after)];
    camera.pan(to[0] - from[0], to[1] - from[1]);
    if (after.length === 2) camera.zoom(spread(after) / Math.max(spread(before), 1), ...to);
    moved();
  });
  canvas.addEventListener("pointerup", (event) => {
    pointers.delete(event.pointerId);
    if (start) pick(goal(at(event)));
    start = null;
  });
  canvas.addEventListener("pointercancel", (event) => {
    pointers.delete(event.pointerId);
    start = null;
    aim(null);
  });
}
