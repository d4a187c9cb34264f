/** Says how the connection is, and what the server could not do. */

import { byId, say } from "./dom.js";

const NOTICE_MS = 8000;
let leaving = null;

/**
 * Show the state of the connection.
 * @param {"connecting"|"connected"|"lost"} state
 * @param {number} wait until the next attempt, ms
 */
export function showLink(state, wait) {
  const link = byId("link");
  const banner = byId("banner");
  link.dataset.state = state;
  say(link, state);
  if (state === "connected") banner.hidden = true;
  if (state !== "lost") return;
  banner.hidden = false;
  const seconds = Math.max(1, Math.round(wait / 1000));
  say(byId("banner-text"), `The connection to the scope is lost. Trying again in ${seconds} s.`);
}

/**
 * Show a sentence at the foot of the page for a while.
 * @param {string} text
 */
export function notify(text) {
  clearTimeout(leaving);
  say(byId("notice"), text);
  leaving = setTimeout(() => say(byId("notice"), ""), NOTICE_MS);
}
