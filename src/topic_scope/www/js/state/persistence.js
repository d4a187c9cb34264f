/** Persistence: sweeps that the trigger held before the latest one stay visible, so that jitter shows as a band. */

/** How many earlier sweeps may stay visible. */
export const KEPT = [0, 4, 8, 16, 32, 64];

/**
 * @typedef {Object} Line
 * @property {Float64Array} points time from the trigger, s, and value in turn; NaN where the line ends
 * @property {boolean} steps whether a value holds until the next one
 */

/** Keeps sweeps that are over, the oldest first. */
export class Persistence {
  /**
   * @param {import("./state.js").State} state
   */
  constructor(state) {
    this.most = 0;
    this.sweeps = []; // of each its lines, by field
    state.on(["persistence"], ({ persistence }) => {
      this.most = persistence;
      this.forgetOldest();
    });
  }

  /**
   * Keep a sweep that is about to be replaced.
   * @param {{buffer: import("./buffer.js").TraceBuffer, time: number}} held with the time of its trigger, s
   * @param {number} from the first time of it that is shown, s from its trigger
   * @param {number} to the last one, s
   */
  keep({ buffer, time }, from, to) {
    if (!this.most) return;
    const more = (to - from) / 10; // so that lines reach the edges
    const isPoint = ([at, value]) => value !== null && at >= from - more && at <= to + more;
    const lineOf = (field) => ({
      points: new Float64Array(buffer.rows([field], time).filter(isPoint).flat()),
      steps: buffer.lasts.has(field),
    });
    this.sweeps.push(new Map([...buffer.traces.keys()].map((field) => [field, lineOf(field)])));
    this.forgetOldest();
  }

  forgetOldest() {
    this.sweeps.splice(0, this.sweeps.length - this.most);
  }

  /** Forget all: the next sweeps show something else. */
  forget() {
    this.sweeps = [];
  }
}
