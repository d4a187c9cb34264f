/** List of the keys and their actions. */

import { byId } from "../base/dom.js";
import { verticals } from "../state/traces.js";
import { KINDS } from "../plot/kinds.js";

const CLOSER = 0.8;

/**
 * List the keys of the page.
 * @param {{state: import("../state/store.js").State, view: import("../state/view.js").View,
 *   cursors: import("../measure/cursors.js").Cursors, trigger: import("../measure/trigger.js").Trigger,
 *   open: {chooser: function(): void, axes: function(): void,
 *   measures: function(): void}}} parts
 * @returns {import("../base/keys.js").Key[]}
 */
export function keyList({ state, view, cursors, trigger, open }) {
  const vertical = (act) => verticals(state.values).forEach(act);
  const key = (keys, shown, help, act) => ({ keys, shown, help, act });
  const pair = (shown, help, pairs) => pairs.map(([keys, act], index) => (
    { keys, act, shown: index ? "" : shown, help: index ? "" : help }));
  const click = (id) => () => byId(id).click();
  return [
    key([" "], "Space", "run or pause; arms a single trigger again", () => view.toggle()),
    key(["a"], "a", "choose traces", open.chooser),
    key(["t"], "t", "trigger off, normal, auto, single", () => trigger.cycle()),
    key(["l"], "l", "set the trigger level to 50 %", () => trigger.halve()),
    key(["c"], "c", "time cursors; the arrow keys move the one with the focus", () => cursors.toggle()),
    key(["v"], "v", "level cursors, on each axis in turn", click("level-cursors")),
    ...pair("+ −", "zoom in time", [
      [["+", "="], () => view.zoomX(CLOSER, 0.5)],
      [["-"], () => view.zoomX(1 / CLOSER, 0.5)],
    ]),
    ...pair("← →", "move in time", [
      [["ArrowLeft"], () => view.panX(-0.1)],
      [["ArrowRight"], () => view.panX(0.1)],
    ]),
    ...pair("Shift ↑ ↓", "move vertically", [
      [["Shift+ArrowUp"], () => vertical((axis) => view.panY(axis, -0.1))],
      [["Shift+ArrowDown"], () => vertical((axis) => view.panY(axis, 0.1))],
    ]),
    ...pair("[ ]", "zoom vertically", [
      [["]"], () => vertical((axis) => view.zoomY(axis, CLOSER, 0.5))],
      [["["], () => vertical((axis) => view.zoomY(axis, 1 / CLOSER, 0.5))],
    ]),
    key(["0"], "0", "reset the view", () => view.reset()),
    key(["x"], "x", "ranges and titles of the axes", open.axes),
    key(["m"], "m", "choose measurements, and their time span", open.measures),
    key(["k"], "k", "plot over time, spectrum, XY", () => {
      const place = KINDS.findIndex(([kind]) => kind === state.values.chart.kind);
      state.change("chart", { kind: KINDS[(place + 1) % KINDS.length][0] });
    }),
    key(["p"], "p", "show or hide the panels", click("show-panels")),
    key(["i"], "i", "show or hide the images", click("show-images")),
    key(["g"], "g", "scope or graph; there, / finds, + − 0 zoom", () =>
      state.set({ view: state.values.view === "scope" ? "graph" : "scope" })),
    key(["r"], "r", "scope or robots; there, arrow keys move, f follows a robot", () =>
      state.set({ view: state.values.view === "robots" ? "scope" : "robots" })),
    key(["s"], "s", "save or load a set-up", click("show-setup")),
    key(["d"], "d", "light or dark", click("theme")),
    key(["?"], "?", "these keys", click("show-help")),
    key([], "Wheel", "zoom in time; with Shift or over a vertical axis, zoom that", null),
    key([], "Drag", "move in time; with Shift or on a vertical axis, move that", null),
    key([], "Double\u00a0click", "reset the view", null),
  ];
}
