/** Row of a reference in the table: its measurements when it was kept, and its position. */

import { make, nameText } from "../base/dom.js";
import { readNumber, typed } from "../base/numbers.js";
import { colourOf } from "../state/colours.js";
import { keptText, moveReference, removeReference } from "../state/references.js";
import { LARGEST } from "../state/traces.js";

/**
 * Make the row.
 * @param {import("../state/store.js").State} state
 * @param {import("../state/references.js").Reference} reference
 * @param {Array<[string, string]>} columns keys and heads of the figures
 * @returns {{element: HTMLTableRowElement, cells: Map<string, HTMLTableCellElement>}}
 */
export function referenceRow(state, reference, columns) {
  const { name, field, figures } = reference;
  const cells = new Map(columns.map(([key, head]) =>
    [key, make("td", { "data-cell": key, "data-head": head }, figures.get(key) ?? "–")]));
  const number = (key, words) => {
    const input = make("input", {
      inputmode: "decimal",
      value: typed(reference[key]),
      "aria-label": `${words} of ${name}`,
      "data-control": `${key} ${name}`,
      change: () => {
        const value = readNumber(input.value) ?? NaN;
        if (Math.abs(value) <= LARGEST) moveReference(state, name, { [key]: value });
        else input.value = typed(reference[key]); // invalid: restore the previous number
      },
    });
    return input;
  };
  const element = make("tr", { class: "reference", "data-reference": name },
    make("td", {}),
    make("td", {}, make("i", { class: "sample", style: `background: ${colourOf(state, field)}` })),
    make("td", { class: "name" }, make("b", {}, name), " ", nameText(field),
      make("span", { class: "muted" }, ` ${keptText(reference)}`)),
    make("td", { class: "choice", colspan: 3 },
      make("label", {}, "+ ", number("offset", "offset")),
      make("label", {}, number("later", "delay, s,"), " s later")),
    ...cells.values(),
    make("td", {}, make("button", {
      type: "button",
      class: "quiet",
      title: "remove this reference",
      "aria-label": `remove ${name}`,
      click: () => removeReference(state, name),
    }, "✕")));
  return { element, cells };
}
