/** Two level cursors: lines across one of the plots, on one of its axes. */

import { byId, make, setPressed, setText } from "../base/dom.js";
import { figure, rounded } from "../base/numbers.js";
import { numbersOf } from "../state/states.js";
import { labelOf } from "../state/traces.js";
import { Handle } from "../plot/handle.js";

/** Two movable horizontal lines, and their distance. */
export class LevelCursors {
  /**
   * @param {HTMLElement} overlay of the plot
   * @param {import("../state/store.js").State} state
   * @param {import("../plot/stack.js").Plots} plot
   */
  constructor(overlay, state, plot) {
    this.state = state;
    this.plot = plot;
    this.readout = make("output", { class: "readout of-levels", hidden: true });
    overlay.append(this.readout);
    this.handles = ["c", "d"].map((key) => [key, new Handle(overlay, {
      kind: "level-cursor",
      name: `level cursor ${key.toUpperCase()}`,
      label: key.toUpperCase(),
      move: (part) => this.moveTo(key, part),
    })]);
    byId("level-cursors").addEventListener("click", () => this.cycle());
    state.on(["levels"], () => this.place());
    state.on(["fields"], ({ fields, levels }) => {
      if (levels && fields.length && !fields.includes(levels.field)) state.set({ levels: null });
    });
    plot.onDrawn(() => this.place());
  }

  /** Show them on the next axis that has a trace, or hide them after the last one. */
  cycle() {
    const { state, plot } = this;
    const { levels } = state.values;
    const axes = new Map(); // axis -> its first trace
    for (const field of numbersOf(state.shown)) {
      if (!axes.has(plot.axisOf(field))) axes.set(plot.axisOf(field), field);
    }
    const before = levels ? [...axes.keys()].indexOf(plot.axisOf(levels.field)) : -1;
    const field = levels && before < 0 ? undefined : [...axes.values()][before + 1];
    if (field === undefined) {
      state.set({ levels: null });
      return;
    }
    const [low, high] = plot.range(plot.axisOf(field));
    const at = (part) => rounded(low + part * (high - low), high - low);
    state.set({ levels: { field, c: at(0.65), d: at(0.35) } });
  }

  moveTo(key, part) {
    const axis = this.plot.axisOf(this.state.values.levels.field);
    this.state.change("levels", { [key]: this.plot.valueAt(axis, part) });
  }

  place() {
    const { levels, fields } = this.state.values;
    const isShown = levels !== null && fields.includes(levels.field);
    setPressed(byId("level-cursors"), isShown);
    this.readout.hidden = !isShown;
    for (const [key, handle] of this.handles) {
      const value = isShown ? levels[key] : null;
      const place = isShown ? this.plot.placeOf(this.plot.axisOf(levels.field), value) : null;
      handle.place(place, value, figure(value));
    }
    if (!isShown) return;
    const { field, c, d } = levels;
    const apart = Math.abs(c - d);
    const text = (value) => figure(value, 5, apart);
    setText(this.readout, `C ${text(c)}   D ${text(d)}   C − D ${figure(c - d)}   on the axis of ` +
      labelOf(this.state.values, field));
  }
}
