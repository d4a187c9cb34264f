/** Managed nodes: their states, and buttons for the transitions that are allowed. */

import { byId, make } from "../base/dom.js";

/** Shows a row for each managed node, above the panels. */
export class Managed {
  /**
   * @param {import("../state/state.js").State} state
   * @param {function(Object): void} send takes messages for the server
   */
  constructor(state, send) {
    this.state = state;
    this.send = send;
  }

  /**
   * @param {{nodes: {node: string, state: string, transitions: string[]}[]}} message
   */
  show({ nodes }) {
    const list = byId("managed-list");
    list.hidden = !nodes.length;
    const focused = document.activeElement?.getAttribute("aria-label");
    list.replaceChildren(...nodes.map((node) => this.row(node)));
    if (focused) list.querySelector(`[aria-label="${CSS.escape(focused)}"]`)?.focus();
  }

  row({ node, state, transitions }) {
    const buttons = this.state.values.readonly ? [] : transitions.map((label) => make("button", {
      type: "button", "aria-label": `${node}: ${label}`,
      click: () => this.send({ type: "transition", node, label }),
    }, label));
    return make("div", { class: "managed-node", "data-node": node },
      make("span", { class: "name" }, node),
      make("output", { class: "status", "data-state": state }, state), ...buttons);
  }
}
