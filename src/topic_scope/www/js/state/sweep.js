/** Shown sweep: the running trace, a paused span, or one held by the trigger. */

import { TraceBuffer } from "./buffer.js";
import { Persistence } from "./persistence.js";
import { scalingOf } from "./traces.js";

const SPARE_S = 0.5; // kept besides the window, as a sweep is complete only when a frame says so

/** The part of the window behind the trigger. */
export const after = ({ position = 0.5 }) => 1 - position;

/** Takes frames and triggers; holds what is to be drawn. */
export class Sweep {
  /**
   * @param {import("./store.js").State} state
   */
  constructor(state) {
    this.state = state;
    this.live = new TraceBuffer();
    this.held = null; // {buffer, time} of the last complete sweep of the trigger
    this.persistence = new Persistence(state);
    this.pending = []; // times of crossings whose sweeps are not complete
    this.armed = "";
    this.ahead = 0; // of the server's clock over this page's, s
    state.on(["trigger"], ({ trigger }) => {
      const mode = trigger.mode + trigger.field + trigger.edge + trigger.position;
      this.pending = [];
      if (mode !== this.armed) this.release();
      this.armed = mode;
    });
    let scaling = "";
    state.on(["fields", "traces"], (values) => {
      const now = JSON.stringify([values.fields, scalingOf(values)]);
      if (now !== scaling) this.release(); // what is held is scaled otherwise
      scaling = now;
    });
  }

  /** Drop the sweep that the trigger holds. */
  release() {
    this.held = null;
    this.persistence.forget();
    this.pending = [];
  }

  /**
   * @param {Object} frame as the server sends it
   */
  onFrame(frame) {
    const { window, trigger, end } = this.state.values;
    this.live.apply(frame, window + SPARE_S);
    this.ahead = frame.now - performance.now() / 1000;
    if (!this.pending.length || frame.now < this.pending[0] + window * after(trigger)) return;
    const time = this.pending.shift();
    if (end !== null) return;
    if (this.held) this.persistence.keep(this.held, window * (after(trigger) - 1), window * after(trigger));
    this.held = { buffer: this.live.copy(), time };
    if (trigger.mode === "single") this.state.set({ end: time + window * after(trigger), reference: time });
  }

  /**
   * @param {{state: string, time: number}} message
   */
  onTrigger(message) {
    const { trigger, end } = this.state.values;
    if (message.state === "armed" && trigger.mode === "auto" && end === null) this.held = null;
    if (message.state === "triggered") this.pending = [...this.pending.slice(-1), message.time];
  }

  /** What the server's clock shows, also while no frames come, since the epoch [s]. */
  get now() {
    return this.state.values.playing ? performance.now() / 1000 + this.ahead : this.live.now;
  }

  /**
   * What is to be drawn: bins, earlier sweeps, what times count from, and both edges, since the
   * epoch [s].
   * @returns {{buffer: TraceBuffer, earlier: Map<string, import("./persistence.js").Line>[],
   *   reference: number, from: number, to: number}}
   */
  get shown() {
    const { window, end, reference } = this.state.values;
    const earlier = this.held ? this.persistence.sweeps : [];
    if (end !== null) {
      return { buffer: this.live, earlier, reference: reference ?? end, from: end - window, to: end };
    }
    if (this.held) {
      const { buffer, time } = this.held;
      const to = time + window * after(this.state.values.trigger);
      return { buffer, earlier, reference: time, from: to - window, to };
    }
    const { now } = this.live;
    return { buffer: this.live, earlier, reference: now, from: now - window, to: now };
  }
}
