/** Run, pause, zoom and pan of the view. */

import { clamp } from "../base/numbers.js";
import { after } from "./sweep.js";

const SHORTEST_S = 0.002;

/** Changes of the view, relative to the visible sweep, so that nothing jumps. */
export class View {
  /**
   * @param {import("./store.js").State} state
   * @param {import("./sweep.js").Sweep} sweep
   * @param {import("../plot/stack.js").Plots} plot
   */
  constructor(state, sweep, plot) {
    this.state = state;
    this.sweep = sweep;
    this.plot = plot;
    this.kept = Infinity; // start of the span shown since the pause, which the scope keeps, s
    state.on(["window", "end"], ({ window, end }) => {
      this.kept = end === null ? Infinity : Math.min(this.kept, end - window);
    });
  }

  /** Pause the view. */
  pause() {
    if (this.state.values.end !== null) return;
    const { to, reference } = this.sweep.shown;
    this.state.set({ end: to, reference });
  }

  /** Resume; a single trigger is armed again. */
  run() {
    this.sweep.release();
    this.state.set({ end: null, reference: null });
    if (this.state.values.trigger.mode === "single") this.state.setTrigger({});
  }

  /** Pause or resume. */
  toggle() {
    if (this.state.isRunning) this.pause();
    else this.run();
  }

  /**
   * Choose the length of the time axis.
   * @param {number} window s
   */
  choose(window) {
    this.state.set({ baseWindow: window, window });
  }

  /**
   * Zoom the time axis around a position.
   * @param {number} factor below 1: closer
   * @param {number} at 0 at the left edge, 1 at the right edge
   */
  zoomX(factor, at) {
    const { window, end, history } = this.state.values;
    const next = clamp(window * factor, SHORTEST_S, history);
    const change = { window: next };
    if (end !== null) change.end = end + (next - window) * (1 - at);
    this.state.set(change);
  }

  /**
   * Move the time axis; pauses.
   * @param {number} part fraction of its length, positive to later times
   */
  panX(part) {
    this.pause();
    const { window, end, history } = this.state.values;
    const latest = this.sweep.now + window / 2;
    const earliest = Math.min(this.sweep.now - history, this.kept + window);
    this.state.set({ end: clamp(end + part * window, earliest, latest) });
  }

  /**
   * Zoom a vertical axis around a position.
   * @param {string} axis its name, see traces.js
   * @param {number} factor below 1: closer
   * @param {number} at 0 at the lower edge, 1 at the upper edge
   */
  zoomY(axis, factor, at) {
    const [low, high] = this.plot.range(axis);
    const place = low + at * (high - low);
    this.state.setAxis(axis, {
      low: place - (place - low) * factor,
      high: place + (high - place) * factor,
    });
  }

  /**
   * Move a vertical axis.
   * @param {string} axis its name, see traces.js
   * @param {number} part fraction of its length, positive to higher values
   */
  panY(axis, part) {
    const [low, high] = this.plot.range(axis);
    const shift = part * (high - low);
    this.state.setAxis(axis, { low: low + shift, high: high + shift });
  }

  /** Reset: selected window, automatic vertical axes, a paused view at its time of pause. */
  reset() {
    const { baseWindow, end, reference, trigger } = this.state.values;
    const centred = end !== null && trigger.mode !== "off" && this.sweep.held;
    const axes = { ...this.state.values.axes };
    for (const name of Object.keys(axes)) {
      if (name !== "x") axes[name] = { ...axes[name], low: null, high: null };
    }
    const change = { window: baseWindow, axes };
    if (end !== null) change.end = centred ? reference + baseWindow * after(trigger) : reference;
    this.state.set(change);
  }
}
