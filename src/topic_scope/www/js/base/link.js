/** State of the connection, and errors of the server. */

import { byId, setText } from "./dom.js";

const NOTICE_MS = 8000;
const PROTOCOL = 1; // must match the server's version
let leaving = null;
let isOutdated = false;

/** Show a banner; an empty message hides it. */
function warn(text, canRetry) {
  byId("banner").hidden = !text;
  byId("reconnect").hidden = !canRetry;
  setText(byId("banner-text"), text);
}

/**
 * Show the state of the connection.
 * @param {"connecting"|"connected"|"lost"} state
 * @param {number} wait until the next attempt [ms]
 * @param {string} reason the server's reason for closing the connection, if any
 */
export function showLink(state, wait, reason) {
  const link = byId("link");
  link.dataset.state = state;
  setText(link, state);
  if (state === "connected") warn("", false);
  if (state !== "lost") return;
  const seconds = Math.max(1, Math.round(wait / 1000));
  warn(`${reason || "The connection to the scope is lost"}. Trying again in ${seconds} s.`, true);
}

/**
 * Return whether a message can be read; report a server of another version.
 * @param {{type: string, protocol: ?number}} message
 * @returns {boolean}
 */
export function isReadable(message) {
  if (message.type === "hello") {
    isOutdated = message.protocol !== PROTOCOL;
    if (isOutdated) warn("This page is of another version than the scope: reload the page.", false);
  }
  return !isOutdated;
}

/**
 * Show or hide the problem of the ROS master.
 * @param {{text: string}} message
 */
export function showMaster({ text }) {
  warn(text, false);
}

/**
 * Show a notice at the foot of the page for a limited time.
 * @param {string} text
 */
export function notify(text) {
  clearTimeout(leaving);
  setText(byId("notice"), text);
  leaving = setTimeout(() => setText(byId("notice"), ""), NOTICE_MS);
}
