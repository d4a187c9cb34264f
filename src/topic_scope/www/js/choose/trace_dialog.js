/** Dialog with the other settings of a trace. */

import { byId, options, setText } from "../base/dom.js";
import { readNumber, typed } from "../base/numbers.js";
import { canKeep } from "../state/references.js";
import { isState } from "../state/states.js";
import { choose, chosenOf, DASHES, differenceOf, DRAWN, isComputed, LARGEST } from "../state/traces.js";

const WORDS = { dash: byId("trace-dash"), drawn: byId("trace-drawn") };
const NUMBERS = { gain: byId("trace-gain"), offset: byId("trace-offset") };
const less = byId("trace-less");
const add = byId("trace-difference");
const keep = byId("trace-keep");

/**
 * Make the dialog work.
 * @param {import("../state/store.js").State} state
 * @param {function(string): void} keepAsIs keeps a trace as a reference
 * @returns {function(string): void} opens it for a field
 */
export function startTraceDialog(state, keepAsIs) {
  let field = "";

  function fill() {
    const chosen = chosenOf(state.values, field);
    setText(byId("trace-title"), field);
    for (const [name, select] of Object.entries(WORDS)) select.value = chosen[name];
    for (const [name, input] of Object.entries(NUMBERS)) input.value = typed(chosen[name]);
    const others = state.values.fields.filter((other) =>
      other !== field && !isComputed(other) && !isState(other));
    less.replaceChildren(...options(others));
    add.disabled = !others.length || isComputed(field);
    keep.disabled = !canKeep(state.values, field);
  }

  add.addEventListener("click", () => {
    const { fields } = state.values;
    const name = differenceOf(field, less.value);
    if (!fields.includes(name)) state.set({ fields: [...fields, name] });
  });
  keep.addEventListener("click", () => keepAsIs(field));
  WORDS.dash.append(...options([["", "automatic"], ...DASHES.keys()]));
  WORDS.drawn.append(...options([["", "automatic"], ...DRAWN]));
  for (const [name, select] of Object.entries(WORDS)) {
    select.addEventListener("change", () => choose(state, field, { [name]: select.value }));
  }
  for (const [name, input] of Object.entries(NUMBERS)) {
    input.addEventListener("change", () => {
      const number = readNumber(input.value) ?? NaN;
      if (Math.abs(number) <= LARGEST) choose(state, field, { [name]: number });
      fill(); // invalid: restore the previous number
    });
  }
  return (name) => {
    field = name;
    fill();
    byId("trace").showModal();
  };
}
