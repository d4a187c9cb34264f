/** The dialog with titles and ranges of the axes. */

import { byId, make } from "../base/dom.js";
import { notify } from "../base/link.js";
import { readNumber, typed } from "../base/numbers.js";
import { axisName, axisOf, axisParts, plotCount } from "../state/traces.js";

const SIDES = { x: "time", y: "left", y2: "right" };

/** Name of an axis; axes of the first plot are named by side only. */
function called(name) {
  const [side, plot] = axisParts(name);
  return `${SIDES[side]} axis${plot === 1 ? "" : ` of plot ${plot}`}`;
}

/**
 * Make the dialog work.
 * @param {import("../state/store.js").State} state
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
      "aria-label": `title of the ${called(name)}`,
      value: axisOf(state.values, name).title,
      input: () => state.setAxis(name, { title: input.value }),
    });
    return input;
  }

  /** Field for a number; "act" takes the number, null for an empty field. */
  function numberField(label, value, act) {
    const input = make("input", {
      type: "text",
      inputmode: "decimal",
      placeholder: "auto",
      "aria-label": label,
      value: value === null ? "" : typed(value),
      change: () => act(readNumber(input.value)),
    });
    return input;
  }

  function boundField(name, bound) {
    const label = `${called(name)}, ${bound === "low" ? "from" : "to"}`;
    return numberField(label, axisOf(state.values, name)[bound], (number) => {
      if (Number.isNaN(number)) {
        fill();
        return;
      }
      state.setAxis(name, { [bound]: number });
      const { low, high } = axisOf(state.values, name);
      if (low !== null && high !== null && low >= high) {
        notify(`The ${called(name)} cannot go from ${typed(low)} to ${typed(high)}: its range is automatic.`);
      }
    });
  }

  function windowField() {
    return numberField("length of the time axis, s", state.values.window, (seconds) => {
      const window = Math.min(seconds, state.values.history);
      if (seconds > 0) state.set({ window, baseWindow: window });
      fill();
    });
  }

  function clockField() {
    const box = make("input", {
      type: "checkbox",
      "aria-label": "show the time of day",
      checked: state.values.axes.x.clock,
      change: () => state.setAxis("x", { clock: box.checked }),
    });
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
    const vertical = (name) => [
      make("span", {}, called(name).replace(/ axis( of plot)?/, "")), titleField(name),
      boundField(name, "low"), boundField(name, "high"), auto(name),
    ];
    const plots = Array.from({ length: plotCount(state.values) }, (_, index) => index + 1);
    rows.replaceChildren(
      head("axis"), head("title"), head("from"), head("to"), head(""),
      ...plots.flatMap((plot) => [...vertical(axisName("y", plot)), ...vertical(axisName("y2", plot))]),
      make("span", {}, "time"), titleField("x"),
      windowField(), make("span", { class: "muted" }, "s long"), clockField(),
    );
  }

  return () => {
    fill();
    dialog.showModal();
  };
}
