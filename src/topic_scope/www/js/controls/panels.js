/** Panels of the nodes that describe their parameters or can be enabled and reset. */

import { byId, make, nameText, setText } from "../base/dom.js";
import { byName, searchFor } from "../base/names.js";
import { Parameter } from "./parameter.js";

const CALLS = { // texts of the buttons of a service, and their data
  SetBool: [["on", true], ["off", false]],
  Trigger: [["call", null]],
};
const WELL_KNOWN = {
  enable: [["Enable", true], ["Disable", false]],
  reset: [["Reset", null]],
};

/** Panels of all nodes. */
export class Panels {
  /**
   * @param {import("../state/store.js").State} state
   * @param {function(Object): void} send takes messages for the server
   */
  constructor(state, send) {
    this.state = state;
    this.send = send;
    this.parameters = new Map(); // "node name" -> Parameter
    this.answers = new Map(); // service -> element of its answer
    this.shown = new Map(); // node -> {shape, element}
    this.closed = new Set();
    this.statuses = {}; // node -> its status, such as running or idle
    this.filter = byId("filter");
    this.filter.addEventListener("input", () => this.applyFilter());
  }

  /**
   * Update the panels. A panel that differs only in values is kept, with the text typed there.
   * @param {Object[]} panels as the server sends them
   */
  show(panels) {
    panels.sort((a, b) => byName(a.node, b.node));
    const list = byId("panel-list");
    const nodes = panels.map(({ node }) => node);
    for (const [node, { element }] of this.shown) {
      if (nodes.includes(node)) continue;
      element.remove();
      this.shown.delete(node);
    }
    panels.forEach((panel, place) => {
      const before = this.shown.get(panel.node);
      const shape = JSON.stringify([panel, this.state.values.readonly], (key, value) =>
        (key === "value" ? undefined : value));
      if (before?.shape === shape) {
        for (const { name, value } of panel.parameters) {
          this.onValue({ node: panel.node, name, value });
        }
        return;
      }
      const element = this.panel(panel);
      this.shown.set(panel.node, { shape, element });
      before?.element.remove();
      list.insertBefore(element, list.children[place] ?? null);
    });
    byId("no-panels").hidden = panels.length > 0;
    this.filter.hidden = panels.length === 0;
    this.applyFilter();
  }

  panel({ node, parameters, services }) {
    const readonly = this.state.values.readonly;
    const rows = parameters.map((parameter) => {
      const { name } = parameter;
      const row = new Parameter(parameter, readonly, (value) =>
        this.send({ type: "set", node, name, value }));
      this.parameters.set(`${node} ${name}`, row);
      return row.element;
    });
    return make(
      "details", {
        class: "panel",
        "data-node": node,
        "aria-label": `parameters of ${node}`,
        open: !this.closed.has(node),
        toggle: (event) => {
          if (event.target.open) this.closed.delete(node);
          else this.closed.add(node);
        },
      },
      make("summary", {}, nameText(node), this.status(node)),
      make("div", { class: "body" }, readonly ? null : this.services(node, services), ...rows),
    );
  }

  status(node) {
    const state = this.statuses[node];
    return make("output", { class: "status", "data-state": state, hidden: !state }, state);
  }

  /**
   * Show the status of the nodes.
   * @param {{nodes: Object<string, string>}} message
   */
  onStatuses({ nodes }) {
    this.statuses = nodes;
    for (const [node, { element }] of this.shown) {
      const status = element.querySelector("summary .status");
      const state = nodes[node] || "";
      status.dataset.state = state;
      status.hidden = !state;
      setText(status, state);
    }
  }

  services(node, services) {
    const made = services.map((service) => this.service(node, service));
    const answers = made.map(({ answer }) => answer);
    return made.length
      ? make("div", { class: "services" }, ...made.flatMap(({ parts }) => parts), ...answers)
      : null;
  }

  /** Buttons of a service, after its name unless they are self-explanatory. */
  service(node, { name, kind }) {
    const short = name.split("/").pop();
    const own = name === `${node}/${short}`.replace("//", "/");
    const known = own && WELL_KNOWN[short] && (kind === "SetBool") === (short === "enable");
    const answer = make("p", { class: "answer", role: "status", "data-service": name });
    this.answers.set(name, answer);
    const call = (data) => {
      setText(answer, "…");
      this.send({ type: "call", service: name, ...(data === null ? {} : { data }) });
    };
    const buttons = (known ? WELL_KNOWN[short] : CALLS[kind]).map(([text, data]) => make("button", {
      type: "button",
      "aria-label": `${name}: ${text}`,
      click: () => call(data),
    }, text));
    const title = known ? [] : [make("span", { class: "name" }, nameText(own ? short : name))];
    return { parts: [...title, ...buttons], answer };
  }

  /**
   * Show the current value of a parameter.
   * @param {{node: string, name: string, value: *}} message
   */
  onValue({ node, name, value }) {
    this.parameters.get(`${node} ${name}`)?.update(value);
  }

  /**
   * @param {{node: string, name: string, text: string, kept: boolean}} message
   */
  onRefused({ node, name, text, kept }) {
    this.parameters.get(`${node} ${name}`)?.refuse(text, kept);
  }

  /**
   * @param {{service: string, success: boolean, message: string}} message
   */
  onCalled({ service, success, message }) {
    const answer = this.answers.get(service);
    if (!answer) return;
    setText(answer, message || (success ? "done" : "refused"));
    answer.classList.toggle("bad", !success);
  }

  applyFilter() {
    const { words, fits } = searchFor(this.filter.value);
    for (const panel of byId("panel-list").children) {
      let any = false;
      for (const row of panel.querySelectorAll(".parameter")) {
        row.hidden = !fits(`${panel.dataset.node} ${row.textContent}`);
        any = any || !row.hidden;
      }
      panel.hidden = words.length > 0 && !any;
    }
  }
}
