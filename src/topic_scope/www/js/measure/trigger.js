/** The trigger: its controls, its line on the plot, and its status. */

import { byId, make, options, setText } from "../base/dom.js";
import { figure, readNumber, rounded, typed } from "../base/numbers.js";
import { KEPT } from "../state/persistence.js";
import { numbersOf } from "../state/states.js";
import { TRIGGER_EDGES, TRIGGER_MODES } from "../state/store.js";
import { Handle } from "../plot/handle.js";

/** Inputs of the dialog: input, key of the trigger, unit, maximum. */
const MORE = [
  ["trigger-hysteresis", "hysteresis", 1, Infinity],
  ["trigger-holdoff", "holdoff", 1, 3600],
  ["trigger-position", "position", 100, 100], // in %
];

/** Trigger controls. */
export class Trigger {
  /**
   * @param {HTMLElement} overlay of the plot
   * @param {import("../state/store.js").State} state
   * @param {import("../plot/stack.js").Plots} plot
   */
  constructor(overlay, state, plot) {
    this.state = state;
    this.plot = plot;
    this.mode = byId("trigger-mode");
    this.field = byId("trigger-field");
    this.edge = byId("trigger-edge");
    this.level = byId("trigger-level");
    this.status = byId("trigger-state");
    this.line = new Handle(overlay, {
      kind: "level",
      name: "trigger level",
      label: "T",
      move: (part) => this.moveTo(part),
    });
    this.arrow = make("button", {
      type: "button", class: "beyond", hidden: true, title: "set the level to 50 %",
      click: () => this.halve(),
    });
    overlay.append(this.arrow);
    this.mode.append(...options(TRIGGER_MODES));
    this.edge.append(...options(TRIGGER_EDGES));
    this.mode.addEventListener("change", () => this.change({ mode: this.mode.value }));
    this.field.addEventListener("change", () => this.change({ field: this.field.value }));
    this.edge.addEventListener("change", () => this.change({ edge: this.edge.value }));
    this.level.addEventListener("change", () => {
      const level = readNumber(this.level.value);
      if (Number.isFinite(level)) this.change({ level });
      else this.show();
    });
    this.startDialog();
    state.on(["fields", "trigger"], () => this.show());
    plot.onDrawn(() => this.placeLine());
    this.show();
  }

  /** Set up the dialog with the other settings of the trigger. */
  startDialog() {
    const fill = () => {
      for (const [id, name, scale] of MORE) byId(id).value = typed(this.state.values.trigger[name] * scale);
      byId("trigger-persistence").value = String(this.state.values.persistence);
    };
    for (const [id, name, scale, most] of MORE) {
      byId(id).addEventListener("change", () => {
        const value = readNumber(byId(id).value);
        if (value !== null && value >= 0 && value <= most) this.change({ [name]: value / scale });
        fill();
      });
    }
    const kept = byId("trigger-persistence");
    kept.append(...options(KEPT.map((count) => [count, count || "off"])));
    kept.addEventListener("change", () => this.state.set({ persistence: Number(kept.value) }));
    byId("trigger-half").addEventListener("click", () => this.halve());
    byId("show-trigger").addEventListener("click", () => {
      fill();
      byId("trigger-more").showModal();
    });
  }

  /** Choose the next mode. */
  cycle() {
    const next = TRIGGER_MODES.indexOf(this.state.values.trigger.mode) + 1;
    this.change({ mode: TRIGGER_MODES[next % TRIGGER_MODES.length] });
  }

  change(changes) {
    const trigger = { ...this.state.values.trigger, ...changes };
    if (!trigger.field) [trigger.field = ""] = numbersOf(this.state.values.fields);
    if (!trigger.field) trigger.mode = "off";
    // Any change arms a single trigger again.
    const again = this.state.values.end !== null && ("mode" in changes || trigger.mode === "single");
    this.state.setTrigger(trigger, again ? { end: null, reference: null } : {});
  }

  /** Set the level to the middle of the visible minimum and maximum. */
  halve() {
    const { trigger } = this.state.values;
    const fields = numbersOf(this.state.values.fields);
    const { buffer, from, to } = this.plot.shown;
    const [low, high] = buffer.extent([trigger.field || fields[0]], from, to);
    if (low < high) this.change({ level: rounded((low + high) / 2, high - low) });
  }

  moveTo(part) {
    const axis = this.plot.axisOf(this.state.values.trigger.field);
    this.change({ level: this.plot.valueAt(axis, part) });
  }

  show() {
    const { trigger } = this.state.values;
    const fields = numbersOf(this.state.values.fields);
    if (trigger.field && !fields.includes(trigger.field)) {
      this.state.setTrigger({ field: "", mode: "off" });
      return;
    }
    this.field.replaceChildren(...options(fields));
    this.field.value = trigger.field || fields[0] || "";
    this.mode.value = trigger.mode;
    this.edge.value = trigger.edge;
    if (document.activeElement !== this.level) this.level.value = typed(trigger.level);
    for (const control of [this.field, this.edge, this.level]) {
      control.disabled = trigger.mode === "off";
    }
    if (trigger.mode === "off") this.showStatus("off");
  }

  /**
   * Show the server's state of the trigger.
   * @param {"off"|"armed"|"triggered"} text
   */
  showStatus(text) {
    this.status.dataset.state = text;
    this.status.value = text;
  }

  placeLine() {
    const { trigger, hidden } = this.state.values;
    const shown = trigger.mode !== "off" && trigger.field && !hidden.has(trigger.field);
    const axis = this.plot.axisOf(trigger.field);
    const [, high] = this.plot.range(axis);
    const place = shown ? this.plot.placeOf(axis, trigger.level) : null;
    this.line.place(place, trigger.level, figure(trigger.level));
    // An arrow points to a level outside of the view.
    this.arrow.hidden = !shown || place !== null;
    if (this.arrow.hidden) return;
    const isAbove = trigger.level > high;
    const span = this.plot.spanOf(axis);
    this.arrow.classList.toggle("above", isAbove);
    this.arrow.style.top = isAbove ? `calc(${100 * (1 - span.high)}% + 4px)` : "auto";
    this.arrow.style.bottom = isAbove ? "auto" : `calc(${100 * span.low}% + 4px)`;
    setText(this.arrow, `${isAbove ? "▲" : "▼"} T ${figure(trigger.level)}`);
  }
}
