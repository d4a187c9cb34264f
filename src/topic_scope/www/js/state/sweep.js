/** Shown sweep: the running trace, a paused span, or a triggered sweep. */

import { TraceBuffer } from "./buffer.js";
import { Persistence } from "./persistence.js";
import { scalingOf } from "./traces.js";

const SPARE_S = 0.5; // kept beyond the window, because a sweep is complete only after the next frame

/** Fraction of the window after the trigger. */
export const after = ({ position = 0.5 }) => 1 - position;

/** Receiver of frames and triggers; provides the sweep to draw. */
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
    this.ahead = 0; // lead of the server's clock over the page's, s
    state.on(["trigger"], ({ trigger }) => {
      const mode = trigger.mode + trigger.field + trigger.edge + trigger.position;
      this.pending = [];
      if (mode !== this.armed) this.release();
      this.armed = mode;
    });
    let scaling = "";
    state.on(["fields", "traces"], (values) => {
      const now = JSON.stringify([values.fields, scalingOf(values)]);
      if (now !== scaling) this.release(); // the held sweep has the old scale
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

  /** Time of the server's clock, also without frames, since the epoch [s]. */
  get now() {
    return this.state.values.playing ? performance.now() / 1000 + this.ahead : this.live.now;
  }

  /**
   * The sweep to draw: bins, earlier sweeps, zero of the times, and both edges, since the
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
