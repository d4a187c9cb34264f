/** What dygraphs has to be helped with when it draws. */

const OUTSIDE = /^\d+ points out of [XY] bounds:/;

/**
 * Draw without a word on the console about samples that lie outside of what is shown: that of
 * Debian 13 says so with each drawing, but it is what a plot is moved and magnified for.
 * @param {function(): void} drawing
 */
export function drawQuietly(drawing) {
  const { warn } = console;
  console.warn = (...words) => OUTSIDE.test(words[0]) || warn.apply(console, words);
  try {
    drawing();
  } finally {
    console.warn = warn;
  }
}

/**
 * Take away what is drawn, also beside the plot. By itself dygraphs erases only where it is about
 * to draw: of an area that was larger before, as a title or wider numbers have come, an axis would
 * stay. What it has cut the canvas to has to go as well: at broken pixels that erases by halves.
 * @param {HTMLCanvasElement[]} canvases
 */
export function erase(canvases) {
  for (const canvas of canvases) {
    const context = canvas.getContext("2d");
    context.restore();
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.save();
  }
}
