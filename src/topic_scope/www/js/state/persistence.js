/** Persistence: sweeps that the trigger held before the latest one stay visible, so that jitter shows as a band. */

/** Numbers of earlier sweeps that may stay visible. */
export const KEPT = [0, 4, 8, 16, 32, 64];

/**
 * @typedef {Object} Line
 * @property {Float64Array} points time from the trigger [s], and value in turn; NaN where the line ends
 * @property {boolean} steps whether a value holds until the next one
 */

/**
 * Find how a trace goes in a stretch of time.
 * @param {import("./buffer.js").TraceBuffer} buffer
 * @param {string} field
 * @param {number} zero what times count from, since the epoch [s]
 * @param {number} from s from there
 * @param {number} to s from there
 * @returns {Line}
 */
export function lineOf(buffer, field, zero, from, to) {
  const isPoint = ([at, value]) => value !== null && at >= from && at <= to;
  const points = new Float64Array(buffer.rows([field], zero).filter(isPoint).flat());
  return { points, steps: buffer.lasts.has(field) };
}

/** Keeps sweeps that are over, the oldest first. */
export class Persistence {
  /**
   * @param {import("./store.js").State} state
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
   * @param {{buffer: import("./buffer.js").TraceBuffer, time: number}} held with the time of its trigger [s]
   * @param {number} from the first time of it that is shown, s from its trigger
   * @param {number} to the last one [s]
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

  /** Drop all sweeps: the next ones show other data. */
  forget() {
    this.sweeps = [];
  }
}
