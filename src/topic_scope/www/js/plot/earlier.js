/** Draws the sweeps that stay visible behind the latest one, paler the older they are. */

const FAINTEST = 0.1; // of the colour
const BOLDEST = 0.5;

/**
 * Widen the extent of traces so that their earlier sweeps have room as well.
 * @param {[number, number]} extent the least and the greatest value of the latest sweep
 * @param {Map<string, import("../state/persistence.js").Line>[]} sweeps
 * @param {string[]} fields
 * @param {number} from on the time axis, s
 * @param {number} to on the time axis, s
 * @returns {[number, number]}
 */
export function widened([low, high], sweeps, fields, from, to) {
  for (const sweep of sweeps) {
    for (const { points } of fields.map((field) => sweep.get(field)).filter(Boolean)) {
      for (const [time, value] of points) {
        if (time < from || time > to) continue;
        if (value < low) low = value; // never true of NaN
        if (value > high) high = value;
      }
    }
  }
  return [low, high];
}

/**
 * Draw.
 * @param {CanvasRenderingContext2D} context
 * @param {{x: number, y: number, w: number, h: number}} area where traces are
 * @param {Map<string, import("../state/persistence.js").Line>[]} sweeps the oldest first
 * @param {string[]} fields
 * @param {{colourOf: function(string): string, across: function(number): number,
 *   up: function(string, number): number}} plot the colour of a field, where a time is, where a
 *   value of a field is
 */
export function drawEarlier(context, area, sweeps, fields, { colourOf, across, up }) {
  context.save();
  context.beginPath();
  context.rect(area.x, area.y, area.w, area.h);
  context.clip();
  context.lineWidth = 1.5;
  context.lineJoin = "round";
  sweeps.forEach((sweep, place) => {
    context.globalAlpha = FAINTEST + ((BOLDEST - FAINTEST) * (place + 1)) / sweeps.length;
    for (const field of fields) {
      if (!sweep.has(field)) continue;
      context.strokeStyle = colourOf(field);
      context.beginPath();
      trace(context, sweep.get(field), across, (value) => up(field, value));
      context.stroke();
    }
  });
  context.restore();
}

function trace(context, { points, steps }, across, up) {
  let before = NaN; // how high the line is; nowhere at first, and where it has ended
  for (const [time, value] of points) {
    const [x, y] = [across(time), up(value)];
    if (!Number.isNaN(before) && steps) context.lineTo(x, before);
    if (!Number.isNaN(y)) context[Number.isNaN(before) ? "moveTo" : "lineTo"](x, y);
    before = y;
  }
}
