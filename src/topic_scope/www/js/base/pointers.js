/** Mouse wheel and pinch gestures. */

import { clamp } from "./numbers.js";

const ZOOM_PER_PIXEL = 0.0015;
const LINE = 33; // pixels per line, for wheels that report lines
const MOST = 300; // largest accepted movement of one event, pixels

/**
 * Return the zoom factor of a wheel event.
 * @param {WheelEvent} event
 * @param {number} [turned] its movement, if not vertical
 * @returns {number} above 1: farther away
 */
export function wheelFactor({ deltaMode, deltaY }, turned = deltaY) {
  const pixels = turned * (deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE : 1);
  return Math.exp(clamp(pixels, -MOST, MOST) * ZOOM_PER_PIXEL);
}

/**
 * Call a function while two fingers are on an element; other listeners do not get these events.
 * @param {HTMLElement} element
 * @param {function({factor: number, x: number, y: number, across: number, upright: boolean}): void}
 *   stretch factor: ratio of the fingers' distance to the previous distance; x, y: the middle between
 *   them on the screen; across: its movement to the right [pixels]; upright: whether they
 *   started one above the other
 */
export function startTwoFingers(element, stretch) {
  const fingers = new Map(); // id of the pointer -> its position
  let upright = false;

  /** Middle and distance of both fingers. */
  function pair() {
    const [a, b] = [...fingers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, wide: Math.abs(a.x - b.x), high: Math.abs(a.y - b.y) };
  }

  element.addEventListener("pointerdown", (event) => {
    if (event.pointerType !== "touch") return;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (fingers.size !== 2) return;
    event.stopPropagation();
    const { wide, high } = pair();
    upright = high > wide;
  }, true);
  element.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    const before = fingers.size === 2 ? pair() : null;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (!before) return;
    event.stopPropagation();
    const { x, y, wide, high } = pair();
    const factor = upright ? high / before.high : wide / before.wide;
    if (Number.isFinite(factor) && factor > 0) stretch({ factor, x, y, across: x - before.x, upright });
  }, true);
  for (const end of ["pointerup", "pointercancel"]) {
    element.addEventListener(end, (event) => fingers.delete(event.pointerId), true);
  }
}
