/** Persistence: earlier triggered sweeps stay visible, so that jitter shows as a band. */

/** Numbers of earlier sweeps that may stay visible. */
export const KEPT = [0, 4, 8, 16, 32, 64];

/**
 * @typedef {Object} Line
 * @property {Float64Array} points time from the trigger [s], and value in turn; NaN where the line ends
 * @property {boolean} steps whether the trace is stepped
 */

/**
 * Return the line of a trace in a time span.
 * @param {import("./buffer.js").TraceBuffer} buffer
 * @param {string} field
 * @param {number} zero zero of the times, since the epoch [s]
 * @param {number} from s from there
 * @param {number} to s from there
 * @returns {Line}
 */
export function lineOf(buffer, field, zero, from, to) {
  const isPoint = ([at, value]) => value !== null && at >= from && at <= to;
  const points = new Float64Array(buffer.rows([field], zero).filter(isPoint).flat());
  return { points, steps: buffer.lasts.has(field) };
}

/** Completed sweeps, the oldest first. */
export class Persistence {
  /**
   * @param {import("./store.js").State} state
   */
  constructor(state) {
    this.most = 0;
    this.sweeps = []; // lines of each sweep, by field
    state.on(["persistence"], ({ persistence }) => {
      this.most = persistence;
      this.forgetOldest();
    });
  }

  /**
   * Add a sweep that is about to be replaced.
   * @param {{buffer: import("./buffer.js").TraceBuffer, time: number}} held with the time of its trigger [s]
   * @param {number} from start of its visible part, s from its trigger
   * @param {number} to end of its visible part [s]
   */
  keep({ buffer, time }, from, to) {
    if (!this.most) return;
    const more = (to - from) / 10; // so that lines reach the edges
    const line = (field) => [field, lineOf(buffer, field, time, from - more, to + more)];
    this.sweeps.push(new Map([...buffer.traces.keys()].map(line)));
    this.forgetOldest();
  }

  forgetOldest() {
    this.sweeps.splice(0, this.sweeps.length - this.most);
  }

  /** Drop all sweeps: the next sweeps show other data. */
  forget() {
    this.sweeps = [];
  }
}
