/** The dialog with what else can be chosen for a trace. */

import { byId, make, say } from "./dom.js";
import { DASHES, choose, chosenOf } from "./traces.js";

/**
 * Make the dialog work.
 * @param {import("./state.js").State} state
 * @returns {function(string): void} opens it for a field
 */
export function startTraceDialog(state) {
  const dash = byId("trace-dash");
  let field = "";
  dash.append(make("option", { value: "" }, "automatic"),
    ...[...DASHES.keys()].map((name) => make("option", { value: name }, name)));

  function fill() {
    say(byId("trace-title"), field);
    dash.value = chosenOf(state.values, field).dash;
  }

  dash.addEventListener("change", () => choose(state, field, { dash: dash.value }));
  return (name) => {
    field = name;
    fill();
    byId("trace").showModal();
  };
}
