/** Two time cursors. */

import { clockText } from "../base/clock.js";
import { byId, make, setPressed, setText } from "../base/dom.js";
import { figure } from "../base/numbers.js";
import { Handle } from "../plot/handle.js";

/** Two movable vertical lines, and the time between them. */
export class Cursors {
  /**
   * @param {HTMLElement} overlay of the plot
   * @param {import("../state/store.js").State} state
   * @param {import("../plot/stack.js").Plots} plot
   */
  constructor(overlay, state, plot) {
    this.state = state;
    this.plot = plot;
    this.lastAxis = null; // left edge, length and reference of the axis when last drawn
    this.own = null; // the cursors as set on a visible axis; null for cursors of a set-up
    this.readout = make("output", { class: "readout", hidden: true });
    overlay.append(this.readout);
    this.handles = ["a", "b"].map((key) => [key, new Handle(overlay, {
      kind: "cursor",
      name: `time cursor ${key.toUpperCase()}`,
      label: key.toUpperCase(),
      move: (part) => this.moveTo(key, part),
    })]);
    const button = byId("cursors");
    button.addEventListener("click", () => this.toggle());
    state.on(["cursors"], ({ cursors }) => {
      setPressed(button, cursors !== null);
      this.place();
    });
    plot.onDrawn(() => this.place());
  }

  /** Show the cursors in the view, or hide them. */
  toggle() {
    const [from, to] = this.plot.times;
    const cursors = { a: from + (to - from) * 0.35, b: from + (to - from) * 0.65 };
    this.set(this.state.values.cursors ? null : cursors);
  }

  moveTo(key, part) {
    const [from, to] = this.plot.times;
    const moved = { [key]: from + part * (to - from) };
    this.set({ ...this.state.values.cursors, ...moved });
  }

  set(cursors) {
    this.own = cursors;
    this.state.set({ cursors });
  }

  place() {
    const [from, to] = this.plot.times;
    this.stay(from, to);
    const { cursors } = this.state.values;
    this.readout.hidden = !cursors;
    for (const [key, handle] of this.handles) {
      const time = cursors ? cursors[key] : null;
      handle.place(time === null ? null : (time - from) / (to - from), time, `${figure(time)} s`);
    }
    if (!cursors) return;
    const apart = cursors.b - cursors.a;
    const text = (time) => (this.state.values.axes?.x.clock
      ? clockText(this.plot.shown.reference + time, (to - from) / 500) : `${figure(time)} s`);
    setText(this.readout, `A ${text(cursors.a)}   B ${text(cursors.b)}   ` +
      `Δt ${figure(apart)} s   1/Δt ${figure(apart ? 1 / Math.abs(apart) : null)} Hz`);
  }

  /** Keep their positions on the screen when the reference of the axis changes. */
  stay(from, to) {
    const { cursors, trigger } = this.state.values;
    const before = this.lastAxis;
    const { shown } = this.plot;
    const reference = shown?.reference;
    this.lastAxis = { from, length: to - from, reference };
    if (!cursors || !shown) return;
    if (cursors !== this.own) {
      // Cursors of a set-up refer to the axis of its trigger, even before it fires.
      if (trigger.mode === "off" || reference !== shown.to) this.own = cursors;
      return;
    }
    if (!before || before.reference === reference) return;
    const shift = from - before.from;
    if (Math.abs(to - from - before.length) > 1e-9 || Math.abs(shift) < 1e-9) return;
    this.set({ a: cursors.a + shift, b: cursors.b + shift });
  }

  /**
   * Return the readings of a trace at both cursors.
   * @param {string} field
   * @returns {?{a: ?Reading, b: ?Reading, difference: ?Reading}} null without cursors
   */
  valuesOf(field) {
    const { shown } = this.plot;
    return shown && this.valuesBy((time) => shown.buffer.at(field, shown.reference + time));
  }

  /**
   * Return the readings of a function of time at both cursors.
   * @param {function(number): ?Reading} valueAt returns the reading at a time on the axis
   * @returns {?{a: ?Reading, b: ?Reading, difference: ?Reading}} null without cursors
   */
  valuesBy(valueAt) {
    const { cursors } = this.state.values;
    if (!cursors) return null;
    const [a, b] = [cursors.a, cursors.b].map(valueAt);
    const difference = a && b
      ? { low: b.low - a.high, high: b.high - a.low, uncertainty: a.uncertainty + b.uncertainty } : null;
    return { a, b, difference };
  }
}
