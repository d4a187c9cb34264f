/** Managed nodes: their states, and buttons for the allowed transitions. */

import { byId, make, nameText } from "../base/dom.js";

/**
 * Make the list of managed nodes above the panels.
 * @param {import("../state/store.js").State} state
 * @param {function(Object): void} send takes messages for the server
 * @returns {function({nodes: {node: string, state: string, transitions: string[]}[]}): void}
 */
export function startManaged({ values }, send) {
  function row({ node, state, transitions }) {
    const buttons = values.readonly ? [] : transitions.map((label) => make("button", {
      type: "button",
      "aria-label": `${node}: ${label}`,
      click: () => send({ type: "transition", node, label }),
    }, label));
    return make("div", { class: "managed-node", "data-node": node },
      make("span", { class: "name" }, nameText(node)),
      make("output", { class: "status", "data-state": state }, state), ...buttons);
  }

  return ({ nodes }) => {
    const list = byId("managed-list");
    list.hidden = !nodes.length;
    const focused = document.activeElement?.getAttribute("aria-label");
    list.replaceChildren(...nodes.map(row));
    if (focused) list.querySelector(`[aria-label="${CSS.escape(focused)}"]`)?.focus();
  };
}
