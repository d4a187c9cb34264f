/** Mask test: limits around a reference trace, sample counts, and the stop at the first failure. */

import { byId, download, options, setText } from "../base/dom.js";
import { notify } from "../base/link.js";
import { readNumber } from "../base/numbers.js";
import { numbersOf } from "../state/states.js";

const around = byId("mask-around");
const numbers = { value: byId("mask-value"), time: byId("mask-time") };
const stop = byId("mask-stop");
const begin = byId("mask-begin");
const output = byId("mask-result");
const end = byId("mask-end");

/** Save the samples around a failure, at full resolution. */
async function save(fields, from, to) {
  const query = new URLSearchParams(fields.map((field) => ["field", field]));
  query.append("start", from);
  query.append("end", to);
  try {
    download(await (await fetch(`/data.csv?${query}`)).blob(), "mask_failure.csv");
  } catch (error) {
    notify("The failure could not be saved: the scope does not answer.");
  }
}

/**
 * Make the controls of the mask work.
 * @param {import("../state/store.js").State} state
 * @param {function(Object): void} send sends a request
 * @returns {{choose: function(string): void, onResult: function(Object): void, onHello: function(): void}}
 *   choose: offers a mask for a trace
 */
export function startMask(state, send) {
  let field = "";
  let asked = null; // the current request
  let isDrawn = false; // whether its limits were shown once: a limit that the user removes is not added again
  let hasStopped = false;

  function showOrHide() {
    for (const element of [output, end]) element.hidden = asked === null;
    setText(output, asked === null ? "" : "mask: …");
  }

  function request(wanted) {
    asked = wanted;
    isDrawn = false;
    hasStopped = false;
    send({ type: "mask", ...(wanted || { field: "" }) });
    showOrHide();
  }

  /** Pause with the failure in view, and save its samples. */
  function stopAt(first, names) {
    const { window } = state.values;
    state.set({ end: first + window / 4 });
    save(names, first - window / 2, first + window / 4);
  }

  begin.addEventListener("click", () => {
    const [value, time] = Object.values(numbers).map((input) => readNumber(input.value) ?? NaN);
    if (value >= 0 && time >= 0) request({ field, reference: around.value, value, time });
    else notify("A mask needs two numbers from 0 on.");
  });
  end.addEventListener("click", () => request(null));

  return {
    choose: (name) => {
      field = name;
      const others = numbersOf(state.values.fields).filter((other) => other !== field);
      around.replaceChildren(...options(others));
      begin.disabled = !others.length;
    },
    onResult: ({ text, first, limits }) => {
      if (asked === null) return;
      const missing = limits.filter((name) => !state.values.fields.includes(name));
      if (missing.length && !isDrawn) state.set({ fields: [...state.values.fields, ...missing] });
      isDrawn = true;
      setText(output, `mask: ${text}`);
      output.dataset.state = first === null ? "triggered" : "failed";
      if (first === null || hasStopped) return;
      hasStopped = true;
      if (stop.checked) stopAt(first, [asked.field, asked.reference, ...limits]);
    },
    onHello: () => {
      if (asked !== null) request({ ...asked });
    },
  };
}
