/** Puts the page together. */

import { startAlternative } from "./alternative.js";
import { startAxes } from "./axes.js";
import { startCharts } from "./charts.js";
import { startChooser } from "./chooser.js";
import { colourOf, startTheme } from "./colours.js";
import { Connection } from "./connection.js";
import { Cursors } from "./cursors.js";
import { byId, press } from "./dom.js";
import { Fleet } from "./fleet.js";
import { startGestures } from "./gestures.js";
import { Graph } from "./graph.js";
import { Hover } from "./hover.js";
import { startKeys } from "./keys.js";
import { keyList } from "./key_list.js";
import { Legend } from "./legend.js";
import { Managed } from "./managed.js";
import { Panels } from "./panels.js";
import { startMeasures } from "./measures.js";
import { startPinch } from "./pinch.js";
import { Playback } from "./playback.js";
import { Plots } from "./plots.js";
import { Requests } from "./requests.js";
import { RobotView } from "./robot_view.js";
import { startScreen } from "./screen.js";
import { Setup } from "./setup.js";
import { State } from "./state.js";
import { Sweep } from "./sweep.js";
import { startTools } from "./tools.js";
import { startTopicPlot } from "./topic_plot.js";
import { startTraceDialog } from "./trace_dialog.js";
import { keepArranged } from "./traces.js";
import { Trigger } from "./trigger.js";
import { startTriggerMore } from "./trigger_more.js";
import { ValueCursors } from "./value_cursors.js";
import { View } from "./view.js";
import { showLink, showMaster, notify } from "./link.js";

const state = new State();
keepArranged(state);
const sweep = new Sweep(state);
startTheme(state, byId("theme"));
const colour = (field) => colourOf(state, field);
const plot = new Plots(byId("plot"), state, colour);
const view = new View(state, sweep, plot);
const cursors = new Cursors(byId("overlay"), state, plot);
new ValueCursors(byId("overlay"), state, plot);
const trigger = new Trigger(byId("overlay"), state, plot);
const legend = new Legend(state, plot, cursors, startTraceDialog(state));
new Hover(byId("stage"), byId("overlay"), state, plot, (field) => legend.spreads.get(field));
const graph = new Graph(state, (topic) => plotTopic(topic));
const screen = startScreen(state, sweep, plot);
const describe = startAlternative(state);

const connection = new Connection(
  `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/ws`,
  (message) => handlers[message.type]?.(message),
  showLink,
);
const setup = new Setup(state);
const requests = new Requests(state, plot, connection, setup);
const charts = startCharts(state, requests, colour);
const send = (message) => connection.send(message);
const panels = new Panels(state, send);
const managed = new Managed(state, send);
const robots = new RobotView(state, send);
const fleet = new Fleet();
const playback = new Playback(state, sweep, send, () => robots.trails.clear());

const handlers = {
  hello: (message) => {
    playback.onHello(message, !requests.welcome && !setup.chosen);
    requests.onHello(message);
    robots.onHello();
  },
  fields: ({ fields, types }) => state.set({ available: fields, types }),
  selected: ({ fields }) => state.set({ fields }), // what a topic alone stands for
  frame: (frame) => {
    sweep.onFrame(frame);
    screen.refresh();
  },
  spectrum: (message) => charts.onSpectrum(message),
  xy: (message) => charts.onXy(message),
  stats: ({ traces }) => {
    legend.showStats(traces);
    describe(traces);
  },
  trigger: (message) => {
    if (message.number !== state.values.trigger.number) return; // of before the latest change
    trigger.showLamp(message.state);
    sweep.onTrigger(message);
  },
  panels: (message) => panels.show(message.panels),
  managed: (message) => managed.show(message),
  lamps: (message) => panels.onLamps(message),
  value: (message) => panels.onValue(message),
  refused: (message) => panels.onRefused(message),
  called: (message) => panels.onCalled(message),
  graph: (message) => graph.show(message),
  robots: (message) => robots.showRobots(message),
  scenery: (message) => robots.showScenery(message),
  targets: (message) => robots.showTargets(message),
  steering: (message) => robots.wheel.onSteering(message),
  sent: (message) => robots.goals.onSent(message),
  fleet: (message) => fleet.show(message),
  master: showMaster,
  playback: (message) => playback.onState(message),
  error: ({ text }) => notify(text),
};

const open = {
  chooser: startChooser(state),
  axes: startAxes(state),
  measures: startMeasures(state, sweep, plot, requests),
};
const plotTopic = startTopicPlot(state, open.chooser);
startGestures(byId("stage"), plot, view);
startPinch(byId("stage"), plot, view);
startTools(state, view, plot, sweep, open, charts.chart);
startTriggerMore(state, trigger);
startKeys(keyList({ state, view, cursors, trigger, open }));
byId("reconnect").addEventListener("click", () => connection.connect());
state.on(["view"], ({ view: shown }) => {
  for (const name of ["scope", "graph", "robots"]) {
    byId(`${name}-view`).hidden = name !== shown;
    press(byId(`show-${name}`), name === shown);
  }
});
setup.restoreAddress();
connection.connect();
