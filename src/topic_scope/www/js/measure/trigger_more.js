/** The dialog with what else there is to a trigger. */

import { byId } from "../base/dom.js";
import { readNumber, typed } from "../base/numbers.js";

/** Input, what of the trigger it is, and from what it is to what. */
const FIELDS = [
  ["trigger-hysteresis", "hysteresis", 1, Infinity],
  ["trigger-holdoff", "holdoff", 1, 3600],
  ["trigger-position", "position", 100, 100], // in %
];

/**
 * Make the dialog work.
 * @param {import("../state/state.js").State} state
 * @param {import("./trigger.js").Trigger} trigger
 */
export function startTriggerMore(state, trigger) {
  function fill() {
    for (const [id, name, scale] of FIELDS) byId(id).value = typed(state.values.trigger[name] * scale);
  }
  for (const [id, name, scale, most] of FIELDS) {
    byId(id).addEventListener("change", () => {
      const value = readNumber(byId(id).value);
      if (value !== null && value >= 0 && value <= most) trigger.change({ [name]: value / scale });
      fill();
    });
  }
  byId("trigger-half").addEventListener("click", () => trigger.halve());
  byId("show-trigger").addEventListener("click", () => {
    fill();
    byId("trigger-more").showModal();
  });
}
