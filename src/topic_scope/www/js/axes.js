/** The dialog with titles and ranges of the axes. */

import { byId, make } from "./dom.js";
import { readNumber, typed } from "./numbers.js";

const NAMES = { x: "time", y: "left", y2: "right" };

/**
 * Make the dialog work.
 * @param {import("./state.js").State} state
 * @returns {function(): void} opens it
 */
export function startAxes(state) {
  const dialog = byId("axes");
  const rows = byId("axes-rows");
  const head = (text) => make("span", { class: "head" }, text);

  function titleField(name) {
    const input = make("input", {
      type: "text",
      class: "title",
      "aria-label": `title of the ${NAMES[name]} axis`,
      value: state.values.axes[name].title,
      input: () => state.setAxis(name, { title: input.value }),
    });
    return input;
  }

  function boundField(name, bound) {
    const value = state.values.axes[name][bound];
    const input = make("input", {
      type: "text",
      inputmode: "decimal",
      placeholder: "auto",
      "aria-label": `${NAMES[name]} axis, ${bound === "low" ? "from" : "to"}`,
      value: value === null ? "" : typed(value),
      change: () => {
        const number = readNumber(input.value);
        if (Number.isNaN(number)) fill();
        else state.setAxis(name, { [bound]: number });
      },
    });
    return input;
  }

  function windowField() {
    const input = make("input", {
      type: "text",
      inputmode: "decimal",
      "aria-label": "length of the time axis, s",
      value: typed(state.values.window),
      change: () => {
        const seconds = readNumber(input.value);
        const { history } = state.values;
        if (seconds > 0) state.set({ window: Math.min(seconds, history), baseWindow: Math.min(seconds, history) });
        fill();
      },
    });
    return input;
  }

  function clockField() {
    const box = make("input", {
      type: "checkbox",
      "aria-label": "the time axis shows the time of day",
      change: () => state.setAxis("x", { clock: box.checked }),
    });
    box.checked = Boolean(state.values.axes.x.clock);
    return make("label", { class: "field" }, box, "clock");
  }

  function fill() {
    const auto = (name) => make("button", {
      type: "button",
      click: () => {
        state.setAxis(name, { low: null, high: null });
        fill();
      },
    }, "Auto");
    rows.replaceChildren(
      head("axis"), head("title"), head("from"), head("to"), head(""),
      make("span", {}, "left"), titleField("y"), boundField("y", "low"), boundField("y", "high"), auto("y"),
      make("span", {}, "right"), titleField("y2"), boundField("y2", "low"), boundField("y2", "high"), auto("y2"),
      make("span", {}, "time"), titleField("x"), windowField(), make("span", { class: "muted" }, "s long"), clockField(),
    );
  }

  return () => {
    fill();
    dialog.showModal();
  };
}
