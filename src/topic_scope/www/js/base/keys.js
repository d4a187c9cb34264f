/** The keys of the page, and the overlay that lists them. */

import { byId, make } from "./dom.js";

/**
 * @typedef {Object} Key
 * @property {string[]} keys values of KeyboardEvent.key, with the prefix "Shift+" if it is held
 * @property {string} shown text in the list
 * @property {string} help
 * @property {?function(): void} act null: handled by the browser or a control
 */

/** Whether a key is for the page: pressed alone, and unused by the control with the focus. */
export const isForPage = (event) =>
  !event.ctrlKey && !event.altKey && !event.metaKey && !isTaken(event);

/** Return whether a control with the focus uses a key itself. */
function isTaken(event) {
  const target = event.target;
  if (document.querySelector("dialog[open]")) return true;
  // A field of a dialog that was just closed keeps the focus until the next frame.
  if (target.closest("dialog")) return false;
  if (target.matches("input:not([type=checkbox]):not([type=range]), select, textarea")) return true;
  if (target.matches("input[type=range]")) return /^(Arrow|Home|End|Page)/.test(event.key);
  return event.key === " " && target.matches("button, a, summary, input");
}

/**
 * Listen to keys.
 * @param {Key[]} keys
 */
export function startKeys(keys) {
  byId("help-keys").append(...keys.filter(({ shown }) => shown).flatMap(({ shown, help }) => [
    make("dt", {}, ...shown.split(" ").map((key) => make("kbd", {}, key))),
    make("dd", {}, help),
  ]));
  const acts = new Map(keys.flatMap(({ keys: names, act }) => names.map((name) => [name, act])));
  document.addEventListener("keydown", (event) => {
    if (!isForPage(event)) return;
    const name = event.shiftKey && event.key.startsWith("Arrow") ? `Shift+${event.key}` : event.key;
    const act = acts.get(name);
    if (!act) return;
    event.preventDefault();
    act();
  });
}
