/**
 * Table for dygraphs: a row for each time at which a trace has a value. A bin with one or
 * two samples has them at their positions, to an eighth of its width; a bin with more has its minimum
 * and maximum at its middle, and for stepped traces also the last value, which holds until the next.
 */

export const PLACES = 8; // positions in a bin; must match the server
const MIDDLE = PLACES; // the first of the rows at the middle
const ROWS = 2 * PLACES + 3;

/** Row index of a position in its bin; two samples may share a position. */
const rowOf = (place, turn) => 2 * place + turn + (place < PLACES / 2 ? 0 : 3);

/** Position of each row in its bin, 0 to 1. */
const PARTS = new Array(ROWS).fill(0.5);
for (let place = 0; place < PLACES; place += 1) {
  for (const turn of [0, 1]) PARTS[rowOf(place, turn)] = (place + 0.5) / PLACES;
}

/** Number of bits that are set. */
function bitCount(bits) {
  let count = 0;
  for (let left = bits; left; left &= left - 1) count += 1;
  return count;
}

const MOST = 3; // values of a trace in a bin

/** Whether a value is a number. */
export const isThere = (value) => value !== null && value !== undefined && !Number.isNaN(value);

/**
 * Return the rows of a trace, in the order of the shortest line if the order in a bin is
 * unknown. Uses typed arrays and no calls: ten traces have half a million bins per second.
 * @param {{values: Array<?number>, places: number[], lasts: ?Array<?number>}} trace
 * @param {number} count of bins
 * @returns {{rows: Int8Array, cells: Float64Array}} MOST for each bin, -1 for missing ones
 */
function laidOut({ values, places, lasts }, count) {
  const rows = new Int8Array(MOST * count).fill(-1);
  const cells = new Float64Array(MOST * count);
  let before = 0;
  for (let bin = 0, at = 0; bin < count; bin += 1, at += MOST) {
    const low = values[2 * bin] ?? null;
    if (low === null) continue;
    const high = values[2 * bin + 1];
    const atLow = places[2 * bin] ?? -1;
    const atHigh = places[2 * bin + 1] ?? -1;
    const isPlaced = atLow >= 0;
    let falls = Math.abs(before - high) < Math.abs(before - low);
    if (isPlaced && atLow !== atHigh) falls = atHigh < atLow;
    else if (isPlaced && lasts) falls = lasts[bin] === low;
    cells[at] = falls ? high : low; // NaN, too, which ends a line in dygraphs
    rows[at] = isPlaced ? rowOf(falls ? atHigh : atLow, 0) : MIDDLE;
    if (Number.isNaN(low)) continue;
    before = falls ? low : high;
    if (isPlaced && atLow === atHigh && low === high) continue;
    cells[at + 1] = before;
    rows[at + 1] = isPlaced ? rowOf(falls ? atLow : atHigh, 1) : MIDDLE + 1;
    if (isPlaced || !lasts || !isThere(lasts[bin])) continue;
    cells[at + 2] = before = lasts[bin];
    rows[at + 2] = MIDDLE + 2;
  }
  return { rows, cells };
}

/**
 * Tabulate traces.
 * @param {Array<{values: Array<?number>, places: number[], lasts: ?Array<?number>}>} traces
 * @param {number} count of bins
 * @param {function(number): number} timeAt returns the time at a position, in bins from the first
 * @param {Array<Array<?number>>} table result of an earlier call, to reuse
 * @returns {Array<Array<?number>>} never empty
 */
export function tabulated(traces, count, timeAt, table) {
  const laid = traces.map((trace) => laidOut(trace, count));
  const used = new Uint32Array(count); // bit mask of the rows with a value, for each bin
  for (const { rows } of laid) {
    for (let index = 0; index < rows.length; index += 1) {
      if (rows[index] >= 0) used[Math.floor(index / MOST)] |= 1 << rows[index];
    }
  }
  const starts = new Uint32Array(count);
  let total = 0;
  for (let bin = 0; bin < count; bin += 1) {
    starts[bin] = total;
    for (let left = used[bin]; left; left &= left - 1, total += 1) {
      const line = table[total] || (table[total] = []);
      line.length = traces.length + 1;
      line.fill(null);
      line[0] = timeAt(bin + PARTS[31 - Math.clz32(left & -left)]);
    }
  }
  table.length = total;
  laid.forEach(({ rows, cells }, column) => {
    for (let bin = 0, index = 0; bin < count; bin += 1) {
      for (let turn = 0; turn < MOST; turn += 1, index += 1) {
        if (rows[index] < 0) continue;
        const before = bitCount(used[bin] & ((1 << rows[index]) - 1));
        table[starts[bin] + before][column + 1] = cells[index];
      }
    }
  });
  if (!total) table.push([timeAt(0), ...traces.map(() => null)]);
  return table;
}
