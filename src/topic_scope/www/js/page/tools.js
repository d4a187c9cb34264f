/** Tool bar above the plot. */

import { byId, download, options, setPressed } from "../base/dom.js";
import { typed } from "../base/numbers.js";
import { colourOf, dashOf } from "../state/colours.js";
import { referenceText } from "../state/references.js";
import { labelOf } from "../state/traces.js";
import { picture } from "../measure/picture.js";

const NARROW = "(max-width: 860px), (max-height: 500px)"; // as in phone.css
const ADDRESS_MS = 500;
const WINDOWS = [0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600];

const windowText = (window) => (window < 1 ? `${typed(window * 1000)} ms` : `${typed(window)} s`);

/**
 * Return the URL of the visible samples, at full resolution.
 * @param {string[]} fields
 * @param {{from: number, to: number}} shown since the epoch [s]
 * @returns {string}
 */
function csvAddress(fields, { from, to }) {
  const query = new URLSearchParams(fields.map((field) => ["field", field]));
  query.append("start", Math.max(0, from)); // negative without samples
  query.append("end", to);
  return `/data.csv?${query}`;
}

/**
 * Set up the bar.
 * @param {import("../state/store.js").State} state
 * @param {import("../state/view.js").View} view
 * @param {import("../plot/stack.js").Plots} plot
 * @param {import("../state/sweep.js").Sweep} sweep
 * @param {{chooser: function(): void, axes: function(): void,
 *   measures: function(): void}} open opens the dialogs
 * @param {import("../plot/canvas_chart.js").Chart} chart
 */
export function startTools(state, view, plot, sweep, open, chart) {
  const run = byId("run");
  const select = byId("window");
  const clicks = {
    run: () => view.toggle(),
    "playback-run": () => view.toggle(),
    reset: () => view.reset(),
    add: () => open.chooser(),
    "show-axes": open.axes,
    "show-measures": open.measures,
    "show-help": () => byId("help").showModal(),
    "show-setup": () => byId("setup").showModal(),
    "show-scope": () => state.set({ view: "scope" }),
    "show-graph": () => state.set({ view: "graph" }),
    png: () => {
      const isPlot = state.values.chart.kind === "time";
      const shown = state.values.references.filter(({ field }) => isPlot && state.shown.includes(field));
      const until = sweep.shown.to || Date.now() / 1000;
      const style = {
        colourOf: (field) => colourOf(state, field),
        dashOf: (field) => dashOf(state, field),
        labelOf: (field) => labelOf(state.values, field),
        notes: shown.map(referenceText),
      };
      picture(isPlot ? plot : chart, state.shown, style, until).toBlob((blob) => download(blob, "scope.png"));
    },
  };
  for (const [id, act] of Object.entries(clicks)) byId(id).addEventListener("click", act);
  select.addEventListener("change", () => view.choose(Number(select.value)));

  const controls = byId("show-controls");
  controls.addEventListener("click", () => {
    const isUnfolded = document.body.classList.toggle("unfolded");
    controls.setAttribute("aria-expanded", isUnfolded);
  });

  const panels = byId("show-panels");
  panels.addEventListener("click", () => state.set({ panels: !state.values.panels }));
  state.on(["panels"], ({ panels: shown }) => {
    byId("scope-view").classList.toggle("wide", !shown);
    setPressed(panels, shown);
  });
  if (matchMedia(NARROW).matches) state.set({ panels: false }); // initially, leave the space to the plot

  const csv = byId("csv");
  const address = () => { csv.href = csvAddress(state.shown, sweep.shown); };
  for (const before of ["pointerdown", "focus", "keydown", "click"]) csv.addEventListener(before, address);
  setInterval(address, ADDRESS_MS); // users may copy it without pressing the button

  function showWindows({ window, history }) {
    const lengths = WINDOWS.filter((length) => length <= history);
    if (!lengths.includes(window)) lengths.push(window);
    lengths.sort((a, b) => a - b);
    select.replaceChildren(...options(lengths.map((length) =>
      [length, windowText(Number(length.toPrecision(3)))])));
    select.value = String(window);
  }

  state.on(["window", "history"], showWindows);
  state.on(["end", "playing"], () => {
    for (const button of [run, byId("playback-run")]) {
      setPressed(button, state.isRunning);
      button.textContent = state.isRunning ? "Pause" : "Run";
    }
  });
  state.on(["readonly"], ({ readonly }) => { byId("readonly").hidden = !readonly; });
}
