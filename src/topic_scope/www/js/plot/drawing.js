/** What dygraphs has to be helped with when it draws. */

const OUTSIDE = /^\d+ points out of [XY] bounds:/;

const { warn } = console;

// That of Debian 13 says with each drawing that samples lie outside of what is shown, but that is
// what a plot is moved and magnified for. It draws by itself too, where its size has changed.
console.warn = (...words) => OUTSIDE.test(words[0]) || warn.apply(console, words);

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
