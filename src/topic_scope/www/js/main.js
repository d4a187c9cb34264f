/** Entry point: connects the parts of the page. */

import { Connection } from "./base/connection.js";
import { byId, setPressed } from "./base/dom.js";
import { startKeys } from "./base/keys.js";
import { isReadable, notify, showLink, showMaster } from "./base/link.js";
import { ambiguity } from "./base/numbers.js";
import { colourOf, startTheme } from "./state/colours.js";
import { keepReference, startReferences } from "./state/references.js";
import { State } from "./state/store.js";
import { Sweep } from "./state/sweep.js";
import { keepArranged } from "./state/traces.js";
import { View } from "./state/view.js";
import { startAxes } from "./plot/axes.js";
import { Bands } from "./plot/bands.js";
import { startCharts } from "./plot/kinds.js";
import { startGestures } from "./plot/gestures.js";
import { Plots } from "./plot/stack.js";
import { startScreen } from "./plot/redraw.js";
import { startAlternative } from "./measure/text_alternative.js";
import { Cursors } from "./measure/cursors.js";
import { Hover } from "./measure/hover.js";
import { Images } from "./measure/images.js";
import { LevelCursors } from "./measure/level_cursors.js";
import { startMask } from "./measure/mask.js";
import { startMeasures } from "./measure/statistics.js";
import { startOverTime } from "./measure/statistics_history.js";
import { Trigger } from "./measure/trigger.js";
import { plotTopic, startChooser } from "./choose/field_dialog.js";
import { Legend } from "./choose/legend.js";
import { startTraceDialog } from "./choose/trace_dialog.js";
import { startManaged } from "./controls/managed.js";
import { Panels } from "./controls/panels.js";
import { Graph } from "./graph/topology.js";
import { showFleet } from "./robots/fleet.js";
import { SceneView } from "./robots/scene_view.js";
import { keyList } from "./page/key_list.js";
import { startOverlays } from "./page/overlays.js";
import { Playback } from "./page/playback.js";
import { Requests } from "./page/requests.js";
import { Setup } from "./page/setup.js";
import { startTools } from "./page/tools.js";

const state = new State();
keepArranged(state);
startReferences(state);
const sweep = new Sweep(state);
startTheme(state, byId("theme"));
const colour = (field) => colourOf(state, field);
const plot = new Plots(byId("plot"), state, colour);
const view = new View(state, sweep, plot);
new Bands(byId("bands"), state, plot);
const cursors = new Cursors(byId("overlay"), state, plot);
new LevelCursors(byId("overlay"), state, plot);
const trigger = new Trigger(byId("overlay"), state, plot);
const openTrace = startTraceDialog(state, (field) => keepReference(state, plot.shown, field, legend.figuresOf(field)));
const legend = new Legend(state, plot, cursors, (field) => {
  mask.choose(field);
  openTrace(field);
}, (topic, leader) => send({ type: "clock", topic, leader }));
new Hover(byId("stage"), byId("overlay"), state, plot, (field) => legend.spreads.get(field));
new Images(state, sweep);
const graph = new Graph(state, (topic) => plotTopic(state, open.chooser, topic));
const screen = startScreen(state, sweep, plot);
const describe = startAlternative(state);
const showOverTime = startOverTime(state);

const connection = new Connection(
  `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/ws`,
  (message) => isReadable(message) && handlers[message.type]?.(message),
  showLink,
);
const setup = new Setup(state);
const requests = new Requests(state, plot, connection, setup);
const charts = startCharts(state, requests, colour);
const send = (message) => connection.send(message);
const mask = startMask(state, send);
const panels = new Panels(state, send);
const showManaged = startManaged(state, send);
const showOverlays = startOverlays(view, sweep, send);
const robots = new SceneView(state, send);
const playback = new Playback(state, sweep, send, () => robots.trails.clear());

const handlers = {
  hello: (message) => {
    connection.expectMore();
    playback.onHello(message, !requests.welcome && !setup.chosen);
    requests.onHello(message);
    robots.onHello();
    mask.onHello();
  },
  fields: ({ fields, types }) => state.set({ available: fields, types }),
  selected: ({ fields }) => state.set({ fields }), // the fields of a topic
  frame: (frame) => {
    sweep.onFrame(frame);
    screen.refresh();
  },
  states: (message) => {
    sweep.live.states = message;
    screen.refresh();
  },
  spectrum: (message) => charts.onChart(message),
  xy: (message) => charts.onChart(message),
  stats: ({ traces, clocks }) => {
    legend.showStats(traces, clocks);
    showOverTime(traces);
    describe(traces);
  },
  trigger: (message) => {
    if (message.number !== state.values.trigger.number) return; // from before the latest change
    trigger.showStatus(message.state);
    sweep.onTrigger(message);
  },
  panels: (message) => panels.show(message.panels),
  managed: showManaged,
  statuses: (message) => panels.onStatuses(message),
  value: (message) => panels.onValue(message),
  refused: (message) => panels.onRefused(message),
  called: (message) => panels.onCalled(message),
  graph: (message) => graph.show(message),
  robots: (message) => robots.showRobots(message),
  scenery: (message) => robots.showScenery(message),
  targets: (message) => robots.showTargets(message),
  steering: (message) => robots.wheel.onSteering(message),
  sent: (message) => robots.goals.onSent(message),
  fleet: showFleet,
  master: showMaster,
  overlays: showOverlays,
  playback: (message) => playback.onState(message),
  mask: (message) => mask.onResult(message),
  formula: (message) => chooser.onFormula(message),
  error: ({ text }) => notify(text),
};

const chooser = startChooser(state, send);
const open = {
  chooser: chooser.open,
  axes: startAxes(state),
  measures: startMeasures(state, sweep, plot, requests),
};
startGestures(byId("stage"), plot, view);
startTools(state, view, plot, sweep, open, charts.chart);
startKeys(keyList({ state, view, cursors, trigger, open }));
byId("reconnect").addEventListener("click", () => connection.connect());
state.on(["view"], ({ view: shown }) => {
  document.body.dataset.view = shown;
  for (const name of ["scope", "graph", "robots"]) {
    byId(`${name}-view`).hidden = name !== shown;
    setPressed(byId(`show-${name}`), name === shown);
  }
});
// In the capture phase, before the field is restored to its previous number.
document.addEventListener("change", ({ target }) => {
  const problem = target.inputMode === "decimal" ? ambiguity(target.value) : "";
  if (problem) notify(problem);
}, true);
setup.restoreAddress(location.hash);
connection.connect();
