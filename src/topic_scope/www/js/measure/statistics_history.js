/** Table of the statistics over time of measurements. */

import { byId, make, setText } from "../base/dom.js";
import { figure } from "../base/numbers.js";
import { labelOf } from "../state/traces.js";
import { shownFigures } from "./statistics.js";

const COLUMNS = ["mean", "sigma", "min", "max", "count"];

/**
 * Set up the table.
 * @param {import("../state/store.js").State} state
 * @returns {function(Object<string, Object>): void} takes the measurements of the traces
 */
export function startOverTime(state) {
  const section = byId("over-time");
  const body = byId("over-time-rows");
  let rows = new Map(); // names of trace and figure -> cells

  function build(wanted) {
    rows = new Map(wanted.map(([key, ...heads]) =>
      [key, [...heads.map((head) => make("th", { scope: "row", class: "name" }, head)),
        ...COLUMNS.map((column) => make("td", { "data-cell": column }))]]));
    body.replaceChildren(...[...rows].map(([key, cells]) => make("tr", { "data-row": key }, ...cells)));
  }

  let number = 0; // of the request whose figures are shown
  state.on(["measures"], ({ measures }) => {
    section.hidden = !measures.overTime;
    if (measures.overTime === number) return;
    number = measures.overTime;
    build([]); // until the first figures of this request
  });
  return (traces) => {
    if (section.hidden) return;
    const wanted = state.values.fields.flatMap((field) => shownFigures(state.values)
      .filter(([key]) => traces[field]?.over_time?.[key])
      .map(([key, head]) => [`${field} ${key}`, labelOf(state.values, field), head, field, key]));
    if (wanted.map(([key]) => key).join() !== [...rows.keys()].join()) {
      build(wanted.map(([key, label, head]) => [key, label, head]));
    }
    for (const [key, , , field, name] of wanted) {
      const summary = traces[field].over_time[name];
      const cells = rows.get(key).slice(-COLUMNS.length);
      COLUMNS.forEach((column, place) => {
        const value = summary[column];
        setText(cells[place], column === "count" ? String(value) : figure(value, 6));
      });
    }
  };
}
