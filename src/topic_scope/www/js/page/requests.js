/** Requests to the server, repeated after a lost connection. */

import { clamp } from "../base/numbers.js";
import { imageTopic } from "../state/image_topics.js";
import { scalingOf } from "../state/traces.js";

const EVERY_MS = 50; // between two views while the wheel turns

/** Sender of requests when the state changes. */
export class Requests {
  /**
   * @param {import("../state/store.js").State} state
   * @param {import("../plot/stack.js").Plots} plot
   * @param {import("../base/connection.js").Connection} connection
   * @param {import("./setup.js").Setup} setup
   */
  constructor(state, plot, connection, setup) {
    this.state = state;
    this.setup = setup;
    this.plot = plot;
    this.connection = connection;
    this.welcome = false; // whether a hello has been received
    this.picked = false; // whether the user has chosen fields; otherwise the server decides
    this.greeting = false;
    this.sent = {}; // type -> latest request
    this.timer = null;
    this.chart = { type: "chart", kind: "time" };
    state.on(["fields"], () => {
      this.picked = this.picked || !this.greeting;
      this.sendSelect();
    });
    state.on(["fields", "hidden"], () => this.sendHidden());
    state.on(["window", "end"], () => this.sendViewSoon());
    state.on(["fields", "traces", "available"], () => this.sendScaling());
    state.on(["trigger"], () => this.sendTrigger());
    state.on(["images", "types", "view"], () => this.sendImages());
    state.on(["view"], () => {
      this.sendShown();
      this.sendViewSoon();
    });
    new ResizeObserver(() => this.sendViewSoon()).observe(plot.element);
  }

  /**
   * Take the server's defaults on the first connection; after a loss, restore the user's choices. The server
   * sends another hello when it finds more of the fields of its command line.
   * @param {{readonly: boolean, history: number, fields: string[], defaults: {window: number},
   *   setup: ?Object}} message
   */
  onHello({ readonly, history, fields, defaults, setup }) {
    this.sent = {};
    this.greeting = true;
    const { window } = defaults;
    this.state.set({ readonly, history, ...(this.picked ? {} : { fields }) });
    const fresh = !this.welcome && !this.setup.chosen;
    if (fresh) this.state.set({ window, baseWindow: window });
    this.welcome = true;
    this.greeting = false;
    if (fresh && setup) this.setup.restore(JSON.stringify(setup));
    if (fresh || !this.picked) this.setup.rememberGiven();
    this.sendSelect();
    this.sendHidden();
    this.sendScaling();
    this.sendView();
    this.sendTrigger();
    this.sendChart(this.chart);
    this.sendShown();
    this.sendImages();
  }

  /**
   * Send a message, if it differs from the latest of its type.
   * @param {Object} message
   * @param {boolean} [isDefault] whether it is the server's initial state
   */
  send(message, isDefault = false) {
    const text = JSON.stringify(message);
    const before = this.sent[message.type];
    if (!this.welcome || before === text || (isDefault && !before)) return;
    this.sent[message.type] = text;
    this.connection.send(message);
  }

  sendSelect() {
    if (this.picked) this.send({ type: "select", fields: this.state.values.fields });
  }

  sendHidden() {
    const { fields, hidden } = this.state.values;
    const message = { type: "hide", fields: fields.filter((field) => hidden.has(field)) };
    this.send(message, !message.fields.length);
  }

  sendScaling() {
    const message = scalingOf(this.state.values);
    this.send(message, !Object.keys(message.traces).length);
  }

  sendViewSoon() {
    if (this.timer !== null) return;
    this.timer = setTimeout(() => this.sendView(), EVERY_MS);
  }

  sendView() {
    clearTimeout(this.timer);
    this.timer = null;
    if (this.state.values.view !== "scope") return; // the hidden plot does not have a size
    const { window, end } = this.state.values;
    const width = clamp(Math.round(this.plot.area.w), 50, 4000);
    this.send({ type: "view", window, width, end });
  }

  sendTrigger() {
    const { trigger } = this.state.values;
    this.send({ type: "trigger", ...trigger }, trigger.mode === "off");
  }

  /** @param {Object} message the requested chart */
  sendChart(message) {
    this.chart = message;
    this.send(message, message.kind === "time");
  }

  /** @param {Object} message the requested measurements */
  sendMeasure(message) {
    const { shapes, latency, against, start, over_time: overTime } = message;
    this.send(message, !shapes && !latency && !against && start === null && !overTime);
  }

  /** Request the images of the shown topic. */
  sendImages() {
    const topic = imageTopic(this.state.values);
    this.send({ type: "images", topic }, !topic);
  }

  /** Request the messages of the graph or the robots while they are shown. */
  sendShown() {
    for (const type of ["graph", "robots"]) {
      const on = this.state.values.view === type;
      this.send({ type, on }, !on);
    }
  }
}
