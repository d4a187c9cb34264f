/**
 * Persistence: earlier sweeps behind the latest one, paler the older they are.
 *
 * There may be a million points. A canvas path of that size takes seconds, so pixels are set individually.
 */

const FAINTEST = 0.15; // of the colour
const BOLDEST = 0.6;

/**
 * Extend the range of traces to include their earlier sweeps.
 * @param {[number, number]} extent minimum and maximum of the latest sweep
 * @param {Map<string, import("../state/persistence.js").Line>[]} sweeps
 * @param {string[]} fields
 * @param {number} from on the time axis [s]
 * @param {number} to on the time axis [s]
 * @returns {[number, number]}
 */
export function widened([low, high], sweeps, fields, from, to) {
  for (const sweep of sweeps) {
    for (const { points } of fields.map((field) => sweep.get(field)).filter(Boolean)) {
      for (let place = 0; place < points.length; place += 2) {
        if (points[place] < from || points[place] > to) continue;
        const value = points[place + 1];
        if (value < low) low = value; // never true for NaN
        if (value > high) high = value;
      }
    }
  }
  return [low, high];
}

/** Layer behind the traces of one plot. */
export class EarlierSweeps {
  constructor() {
    this.canvas = document.createElement("canvas");
  }

  /**
   * Draw.
   * @param {CanvasRenderingContext2D} context
   * @param {{x: number, y: number, w: number, h: number}} area where traces are
   * @param {Map<string, import("../state/persistence.js").Line>[]} sweeps the oldest first
   * @param {string[]} fields
   * @param {{colourOf: function(string): string, across: function(number): number,
   *   up: function(string, number): number}} plot colour of a field, #rrggbb; position of a time, and
   *   of a field's value
   */
  draw(context, area, sweeps, fields, { colourOf, across, up }) {
    const ratio = context.getTransform().a; // screen pixels per page pixel
    const [width, height] = [Math.round(area.w * ratio), Math.round(area.h * ratio)];
    if (width < 1 || height < 1) return;
    const image = new ImageData(width, height);
    const raster = { pixels: new Uint32Array(image.data.buffer), width, height };
    const scaleOf = (place, begin) => [(place(0) - begin) * ratio, (place(1) - place(0)) * ratio];
    const time = scaleOf(across, area.x);
    const looks = fields.map((field) => ({
      field, value: scaleOf((number) => up(field, number), area.y), colour: colourOf(field),
    }));
    sweeps.forEach((sweep, place) => {
      const bold = FAINTEST + ((BOLDEST - FAINTEST) * (place + 1)) / sweeps.length;
      for (const { field, value, colour } of looks) {
        if (sweep.has(field)) drawTrace(raster, sweep.get(field), time, value, pixelOf(colour, bold));
      }
    });
    Object.assign(this.canvas, { width, height });
    this.canvas.getContext("2d").putImageData(image, 0, 0);
    context.drawImage(this.canvas, area.x, area.y, area.w, area.h);
  }
}

/** Colour as bytes of an image: red first. */
function pixelOf(colour, bold) {
  const [red, green, blue] = [1, 3, 5].map((place) => parseInt(colour.slice(place, place + 2), 16));
  return ((Math.round(255 * bold) << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}

function drawTrace(raster, { points, steps }, [left, perSecond], [top, perUnit], pixel) {
  let x = NaN; // position of the line; NaN initially, and after its end
  let y = NaN;
  for (let place = 0; place < points.length; place += 2) {
    const nextX = left + points[place] * perSecond;
    const nextY = top + points[place + 1] * perUnit;
    if (!Number.isNaN(y) && steps) drawLine(raster, x, y, nextX, y, pixel);
    if (!Number.isNaN(y) && !Number.isNaN(nextY)) drawLine(raster, steps ? nextX : x, y, nextX, nextY, pixel);
    x = nextX;
    y = nextY;
  }
}

/** Set the pixels of a line to the right, up or down, two pixels wide. */
function drawLine({ pixels, width, height }, x, y, nextX, nextY, pixel) {
  const slope = nextX > x ? (nextY - y) / (nextX - x) : 0;
  const last = Math.min(width - 1, Math.floor(nextX));
  for (let column = Math.max(0, Math.floor(x)); column <= last; column += 1) {
    const from = column > x ? y + slope * (column - x) : y;
    const to = column + 1 < nextX ? y + slope * (column + 1 - x) : nextY;
    const low = Math.min(height - 1, Math.floor(Math.max(from, to)) + 1);
    for (let row = Math.max(0, Math.floor(Math.min(from, to))); row <= low; row += 1) {
      pixels[row * width + column] = pixel;
      if (column + 1 < width) pixels[row * width + column + 1] = pixel;
    }
  }
}
