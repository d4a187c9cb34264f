/** Buffer of the bins of all traces on their common grid. */

import { isThere, PLACES, tabulated } from "./rows.js";

/** Return the next non-empty bin, starting at one; null if the line ends before. */
function nextFilled(values, from, way) {
  let bin = from;
  while (values[2 * bin] === null) bin += way;
  return isThere(values[2 * bin]) ? bin : null;
}

/** Return one value as a reading; null without one. */
const one = (value, uncertainty = 0) => (value === null ? null : { low: value, high: value, uncertainty });

/**
 * Return how far a line through some points may be, at a time, from that through their samples, whose
 * times are rounded.
 */
function uncertaintyAt(points, time, rounding) {
  const rises = points.slice(1).map(([end, to], index) => {
    const [start, from] = points[index];
    if (time < start - rounding || time > end + rounding) return 0;
    return Math.abs(to - from) * Math.min(1, rounding / Math.max(end - start - 2 * rounding, rounding));
  });
  return Math.max(0, ...rises);
}

/** Return the value at a time on the line through some points; null beyond a step from its ends. */
function onLine(points, time) {
  const after = points.findIndex(([at]) => at >= time);
  if (after > 0) {
    const [[start, from], [end, to]] = points.slice(after - 1, after + 1);
    return end > start ? from + (to - from) * (time - start) / (end - start) : to;
  }
  if (!points.length) return null;
  const inwards = after === 0 ? points : [...points].reverse();
  const [[end, value]] = inwards;
  const [next] = inwards.find(([at]) => at !== end) ?? [end];
  return Math.abs(time - end) <= Math.abs(next - end) ? value : null;
}

/** Minimum and maximum of each bin, for a moving range of bins. */
export class TraceBuffer {
  constructor() {
    this.bin = 0; // length of a bin, s
    this.first = 0; // index of the first bin
    this.count = 0; // number of bins
    this.now = 0; // time of the last frame, since the epoch, s
    // field -> [min0, max0, min1, max1, …], null where a bin is empty, NaN where a line ends
    this.traces = new Map();
    this.places = new Map(); // field -> position of each of these in its bin, or -1
    this.counts = new Map(); // field -> number of samples in each bin; 0 if unknown
    this.lasts = new Map(); // field -> the last value of each bin, for stepped traces
    this.states = null; // latest message about the states, see states.js
  }

  /**
   * Add a frame.
   * @param {{now: number, bin: number, reset: boolean, first: number,
   *   traces: Object<string, Array<?number>>, places: ?Object<string, number[]>,
   *   counts: ?Object<string, number[]>,
   *   lasts: ?Object<string, Array<?number>>}} frame
   * @param {number} span history to keep [s]
   */
  apply(frame, span) {
    const fields = Object.keys(frame.traces);
    this.now = frame.now;
    if (frame.reset || frame.bin !== this.bin || frame.first > this.first + this.count) {
      this.traces.clear();
      this.places.clear();
      this.counts.clear();
      this.lasts.clear();
      this.bin = frame.bin;
      this.first = frame.first;
      this.count = 0;
    }
    if (!fields.length) return;
    const offset = Math.max(0, frame.first - this.first);
    this.count = offset + frame.traces[fields[0]].length / 2;
    for (const field of fields) {
      const values = this.traces.get(field) || new Array(2 * offset).fill(null);
      values.length = 2 * offset;
      for (const value of frame.traces[field]) values.push(value === false ? NaN : value);
      this.traces.set(field, values);
      const places = this.places.get(field) || new Array(2 * offset).fill(-1);
      places.length = 2 * offset;
      places.push(...(frame.places?.[field] || frame.traces[field].map(() => -1)));
      this.places.set(field, places);
      const counts = this.counts.get(field) || new Array(offset).fill(0);
      counts.length = offset;
      counts.push(...(frame.counts?.[field] || new Array(frame.traces[field].length / 2).fill(0)));
      this.counts.set(field, counts);
    }
    for (const [field, values] of Object.entries(frame.lasts || {})) {
      const before = this.lasts.get(field) || new Array(offset).fill(null);
      before.length = offset;
      before.push(...values);
      this.lasts.set(field, before);
    }
    this.forget(this.count - Math.ceil(span / this.bin) - 2);
  }

  forget(surplus) {
    if (surplus <= 0) return;
    for (const values of this.traces.values()) values.splice(0, 2 * surplus);
    for (const places of this.places.values()) places.splice(0, 2 * surplus);
    for (const map of [this.lasts, this.counts]) for (const values of map.values()) values.splice(0, surplus);
    this.first += surplus;
    this.count -= surplus;
  }

  /**
   * Return a copy that further frames do not change.
   * @param {string[]} [fields] all by default
   * @param {function(string): string} [nameOf] returns the name of a field in the copy; the same by default
   * @returns {TraceBuffer}
   */
  copy(fields = [...this.traces.keys()], nameOf = (field) => field) {
    const some = (map) => new Map(fields.filter((field) => map.has(field))
      .map((field) => [nameOf(field), map.get(field).slice()]));
    const [traces, places, counts, lasts] = [this.traces, this.places, this.counts, this.lasts].map(some);
    return Object.assign(new TraceBuffer(), this, { traces, places, counts, lasts });
  }

  /**
   * Tabulate traces for dygraphs, see rows.js.
   * @param {string[]} fields
   * @param {number} reference zero of the times, since the epoch [s]
   * @param {Array<Array<?number>>} [rows] result of an earlier call, to reuse
   * @returns {Array<Array<?number>>} never empty
   */
  rows(fields, reference, rows = []) {
    const traces = fields.map((field) => ({
      values: this.traces.get(field) || [],
      places: this.places.get(field) || [],
      lasts: this.lasts.get(field),
    }));
    return tabulated(traces, this.count, (part) => (this.first + part) * this.bin - reference, rows);
  }

  /**
   * Return the minimum and maximum of some traces.
   * @param {string[]} fields
   * @param {number} from since the epoch [s]
   * @param {number} to since the epoch [s]
   * @returns {[number, number]} infinite and reversed without values
   */
  extent(fields, from, to) {
    let low = Infinity;
    let high = -Infinity;
    const start = Math.max(0, Math.floor(from / this.bin) - this.first);
    const end = Math.min(this.count, Math.ceil(to / this.bin) - this.first);
    for (const field of fields) {
      const values = this.traces.get(field) || [];
      for (let index = 2 * start; index < 2 * end; index += 1) {
        const value = values[index];
        if (!isThere(value)) continue;
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    return [low, high];
  }

  /**
   * Return the number of non-empty bins of a trace.
   * @param {string} field
   * @returns {number}
   */
  filled(field) {
    let count = 0;
    const values = this.traces.get(field) || [];
    for (let index = 0; index < values.length; index += 2) if (isThere(values[index])) count += 1;
    return count;
  }

  /**
   * Return the value of a trace at a time, as drawn: interpolated between two samples, the last value
   * of a stepped trace, or the minimum and maximum of a bin with more samples than are drawn. After its
   * end, a line has no value, except that its last sample is valid for one step.
   * @param {string} field
   * @param {number} time since the epoch [s]
   * @returns {?{low: number, high: number, uncertainty: ?number, count: ?number}} low and high are equal
   *   for one value, which has an uncertainty; otherwise the range of count samples; null without a value
   */
  at(field, time) {
    const values = this.traces.get(field) || [];
    const middle = Math.floor(time / this.bin) - this.first;
    if (middle < 0 || middle >= this.count) return null;
    if (this.lasts.has(field)) return one(this.heldAt(field, middle));
    if (Number.isNaN(values[2 * middle])) return null;
    const places = this.places.get(field) || [];
    const [low, high] = [values[2 * middle], values[2 * middle + 1]];
    if (isThere(low) && low !== high && !(places[2 * middle] >= 0)) {
      return { low, high, count: this.counts.get(field)?.[middle] };
    }
    const before = nextFilled(values, middle - 1, -1);
    const after = nextFilled(values, middle + 1, 1);
    // At the end of the line, its last two samples.
    const further = (bin, way) => nextFilled(values, bin + way, way) ?? bin;
    let [start, end] = [before ?? middle, after ?? middle];
    if (before === null && after !== null) end = further(after, 1);
    if (after === null && before !== null) start = further(before, -1);
    const part = { values: values.slice(2 * start, 2 * end + 2), places: places.slice(2 * start, 2 * end + 2) };
    const timeAt = (place) => (this.first + start + place) * this.bin;
    const points = tabulated([part], end - start + 1, timeAt, []).filter(([, value]) => isThere(value));
    const isPlaced = part.places.every((place, index) => place >= 0 || !isThere(part.values[index]));
    const rounding = this.bin / (isPlaced ? 2 * PLACES : 2);
    return one(onLine(points, time), uncertaintyAt(points, time, rounding));
  }

  /** Return the value that holds in a bin; null after the end of its line. */
  heldAt(field, bin) {
    const values = this.traces.get(field) || [];
    const lasts = this.lasts.get(field);
    for (let index = bin; index >= 0; index -= 1) {
      if (isThere(lasts[index])) return lasts[index];
      if (Number.isNaN(values[2 * index])) return null;
    }
    return null;
  }
}
