/** The table below the plot: legend, switches and measurements of each trace. */

import { byId, make, nameText, setPressed, setText, setTitle } from "../base/dom.js";
import { readingText } from "../base/numbers.js";
import { colourOf, dashOf, sampleOf } from "../state/colours.js";
import { valueOf } from "../state/references.js";
import { isState } from "../state/states.js";
import { scaledText } from "../state/traces.js";
import { certainty, figureText, shownFigures } from "../measure/statistics.js";
import { plotChoice, startDrag } from "./plot_choice.js";
import { referenceRow } from "./reference_row.js";
import { timestampChoice } from "./timestamp_source.js";

const AT_CURSORS = [["a", "at A"], ["b", "at B"], ["difference", "B − A"]];

const without = (set, item) => new Set([...set].filter((other) => other !== item));
const toggled = (set, item) => (set.has(item) ? without(set, item) : new Set([...set, item]));

/** Describe missing data, corrected stamps and jumps of a trace. */
function missing({ silent, nan, problem, correction, jumps }) {
  if (problem) return problem;
  const words = silent ? [`no data for ${Math.floor(silent)} s`] : [];
  if (correction) words.push(correction);
  if (jumps) words.push(jumps);
  if (nan > 0) words.push(`NaN ${Math.max(1, Math.round(100 * nan))} %`);
  return words.join(", ");
}

/** The legend. */
export class Legend {
  /**
   * @param {import("../state/store.js").State} state
   * @param {import("../plot/stack.js").Plots} plot
   * @param {import("../measure/cursors.js").Cursors} cursors
   * @param {function(string): void} openTrace opens the dialog of a trace
   * @param {function(string, string): void} chooseClock see timestamp_source.js
   */
  constructor(state, plot, cursors, openTrace, chooseClock) {
    this.state = state;
    this.openTrace = openTrace;
    this.chooseClock = chooseClock;
    this.cursors = cursors;
    this.rows = new Map();
    this.references = new Map(); // reference -> its row
    this.spreads = new Map(); // field -> its peak-to-peak value
    this.measured = {}; // latest measurements, by field
    this.clocks = []; // a topic of each estimated clock
    this.body = byId("legend");
    this.table = this.body.parentElement;
    this.room = this.table.parentElement;
    this.more = make("th", { scope: "col" }, byId("show-measures"));
    state.on(["fields", "hidden", "right", "colours", "traces", "references", "theme", "measures"],
      () => this.build());
    state.on(["cursors"], () => {
      if ((state.values.cursors !== null) !== this.withCursors) this.build();
    });
    plot.onDrawn(() => this.showCursors());
    new ResizeObserver(() => this.fit()).observe(this.room);
    this.build();
  }

  build() {
    const focused = document.activeElement?.dataset?.control;
    this.withCursors = this.state.values.cursors !== null;
    this.figures = shownFigures(this.state.values);
    this.columns = [...this.figures, ...(this.withCursors ? AT_CURSORS : [])];
    const head = (text, className, title) => make("th", { scope: "col", class: className, title }, text);
    this.heads = this.columns.map(([, text, title]) => head(text, "figure", title));
    byId("legend-head").replaceChildren(
      head("", ""), head("", ""), head("trace", "name"),
      ...["plot", "axis", "timestamp"].map((text) => head(text, "choice")), ...this.heads, this.more,
    );
    const before = this.rows;
    this.rows = new Map();
    for (const field of this.state.values.fields) {
      const row = this.row(field);
      this.rows.set(field, row);
      for (const [key, cell] of row.cells) {
        setText(cell, before.get(field)?.cells.get(key)?.textContent ?? "–");
      }
    }
    this.references = new Map(this.state.values.references.map((one) =>
      [one, referenceRow(this.state, one, this.columns)]));
    const all = [...this.rows.values(), ...this.references.values()];
    this.body.replaceChildren(...all.map((row) => row.element));
    this.showStats(this.measured, this.clocks); // otherwise the next figures would move buttons under the pointer
    this.fit();
    if (focused) this.body.querySelector(`[data-control="${CSS.escape(focused)}"]`)?.focus();
  }

  /** Place measurements below the names if a row is too narrow for them. */
  fit() {
    this.room.classList.remove("stacked");
    this.room.classList.toggle("stacked", this.isTooWide);
  }

  get isTooWide() {
    return this.table.offsetWidth > this.room.clientWidth;
  }

  row(field) {
    const { state } = this;
    const { hidden, right, colours } = state.values;
    const cells = new Map(this.columns.map(([key, text]) =>
      [key, make("td", { "data-cell": key, "data-head": text })]));
    const shown = make("input", {
      type: "checkbox",
      "aria-label": `show ${field}`,
      "data-control": `show ${field}`,
      checked: !hidden.has(field),
      change: () => state.set({ hidden: toggled(hidden, field) }),
    });
    const colour = isState(field) ? null : make("input", {
      type: "color",
      value: colourOf(state, field),
      "aria-label": `colour of ${field}`,
      change: () => state.set({ colours: new Map([...colours, [field, colour.value]]) }),
    });
    const axis = make("button", {
      type: "button",
      title: "left or right axis",
      "aria-label": `right axis for ${field}`,
      "data-control": `axis ${field}`,
      click: () => state.set({ right: toggled(right, field) }),
    }, right.has(field) ? "right" : "left");
    setPressed(axis, right.has(field));
    const timestamp = timestampChoice(state, field, this.chooseClock);
    const badge = make("span", { class: "badge", role: "status", hidden: true });
    const more = make("button", {
      type: "button",
      class: "quiet",
      title: "dash, steps, gain and offset of this trace",
      "aria-label": `more of ${field}`,
      "data-control": `more ${field}`,
      click: () => this.openTrace(field),
    }, "⋯");
    const remove = make("button", {
      type: "button",
      class: "quiet",
      title: "remove this trace",
      "aria-label": `remove ${field}`,
      click: () => state.set({ fields: state.values.fields.filter((other) => other !== field) }),
    }, "✕");
    const scaled = scaledText(state.values, field);
    const name = make("td", { class: "name", title: isState(field) ? field : `${field}: drag it to another plot` },
      make("i", {
        class: "sample", style: `background: ${sampleOf(state, field)}`,
        hidden: isState(field) || !dashOf(state, field).length,
      }), nameText(field), scaled && make("em", { class: "scaled" }, scaled), badge);
    if (!isState(field)) startDrag(name, state, field);
    const choice = (control) => make("td", { class: "choice" }, control);
    const element = make(
      "tr", { "data-field": field, class: hidden.has(field) ? "off" : "" },
      make("td", {}, make("label", { class: "tick" }, shown)), make("td", {}, colour), name,
      choice(isState(field) ? null : plotChoice(state, field)), choice(isState(field) ? null : axis),
      choice(timestamp.element), ...cells.values(), make("td", {}, isState(field) ? null : more, remove),
    );
    return { element, name, cells, timestamp, badge };
  }

  /** Cells of a trace in the table: key of the measurement -> text. */
  figuresOf(field) {
    const { cells } = this.rows.get(field);
    return new Map(this.figures.map(([key]) => [key, cells.get(key).textContent]));
  }

  /**
   * Show the server's measurements.
   * @param {Object<string, Object<string, ?number>>} traces
   * @param {string[]} clocks a topic of each estimated clock
   */
  showStats(traces, clocks) {
    this.measured = traces;
    this.clocks = clocks;
    for (const [field, { element, name, cells, timestamp, badge }] of this.rows) {
      const measured = traces[field] || {};
      const isGone = Boolean(measured.problem) && !measured.clock; // the choice of a clock can be undone
      element.classList.toggle("gone", isGone);
      name.colSpan = isGone ? 4 + this.columns.length : 1; // the text takes the whole row
      if (measured.topic) timestamp.show(measured, clocks);
      setText(badge, missing(measured));
      badge.hidden = !badge.textContent;
      const largest = Math.max(Math.abs(measured.min), Math.abs(measured.max));
      // A mean of 0 shows only the rounding of the sum.
      const mean = Math.abs(measured.mean) < largest * 1e-9 ? 0 : measured.mean;
      this.spreads.set(field, measured.vpp);
      for (const [key] of this.figures) {
        const figures = key === "mean" && largest ? { ...measured, mean } : measured;
        setText(cells.get(key), figureText(figures, key));
        setTitle(cells.get(key), certainty(measured, key));
      }
    }
    this.keepWidths();
    if (this.isTooWide) this.fit(); // as numbers have become longer
  }

  /** Keep each column as wide as its longest number so far: names that wrap and unwrap would move the plot. */
  keepWidths() {
    const widths = this.heads.map((one) => Math.ceil(one.getBoundingClientRect().width)); // 0 if stacked
    this.heads.forEach((one, column) => {
      if (widths[column] > parseFloat(one.style.minWidth || 0)) one.style.minWidth = `${widths[column]}px`;
    });
  }

  showCursors() {
    if (!this.withCursors) return;
    const show = (field, cells, values) => {
      for (const [key] of AT_CURSORS) {
        const spread = key === "difference" ? null : this.spreads.get(field);
        const { value, uncertainty } = readingText(values?.[key], spread);
        setText(cells.get(key), value);
        setTitle(cells.get(key), uncertainty && `± ${uncertainty}`);
      }
    };
    for (const [field, { cells }] of this.rows) show(field, cells, this.cursors.valuesOf(field));
    for (const [reference, { cells }] of this.references) {
      show(reference.field, cells, this.cursors.valuesBy((time) => valueOf(reference, time)));
    }
  }
}
