/** Redraws the plots after changes, at most once per screen frame. */

import { byId, setText } from "../base/dom.js";
import { figure } from "../base/numbers.js";

const CHANGES = ["fields", "hidden", "right", "colours", "traces", "window", "end", "axes", "persistence",
  "references", "theme", "view"];

/**
 * Redraw whenever the sweep or the state changes.
 * @param {import("../state/store.js").State} state
 * @param {import("../state/sweep.js").Sweep} sweep
 * @param {import("./stack.js").Plots} plot
 * @returns {{refresh: function(): void}} refresh: draw with the next frame
 */
export function startScreen(state, sweep, plot) {
  const overlay = byId("overlay");
  let frames = []; // times of the frames of the last second, ms
  let waiting = false;

  function drawNow(now) {
    waiting = false;
    if (state.values.view !== "scope") return;
    plot.draw(sweep.shown);
    frames.push(now);
  }

  function refresh() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(drawNow);
  }

  function place() {
    const { x, y, w, h } = plot.area;
    const box = { left: plot.element.offsetLeft + x, top: plot.element.offsetTop + y, width: w, height: h };
    for (const [name, pixels] of Object.entries(box)) overlay.style[name] = `${pixels}px`;
  }

  function showFoot() {
    const { end, window, fields } = state.values;
    byId("empty").hidden = fields.length > 0;
    frames = frames.filter((time) => time > performance.now() - 1000);
    setText(byId("foot-frames"), `${frames.length} frames/s`);
    const until = end === null ? "now" : new Date(end * 1000).toISOString().slice(11, 23);
    setText(byId("foot-view"), `${figure(window, 4)} s until ${until}` +
      `, bins of ${figure(sweep.live.bin * 1000, 3)} ms`);
  }

  plot.onDrawn(place);
  new ResizeObserver(refresh).observe(plot.element);
  state.on(CHANGES, refresh);
  setInterval(showFoot, 500);
  return { refresh };
}
