/** The time that a trace goes by: its name stands behind an @ in the name of the field. */

import { make, options, say } from "../base/dom.js";
import { isDifference } from "../state/traces.js";

const LIKE_A_TIME = /(time|stamp)[^/]*$/;

/**
 * Take the name of the time off.
 * @param {string} name
 * @returns {[string, string]} the field, and the time, empty where the scope chooses
 */
export function parted(name) {
  const at = name.indexOf("@");
  return at < 0 ? [name, ""] : [name.slice(0, at), name.slice(at + 1)];
}

/**
 * List the times that the messages of a topic have.
 * @param {Array<{field: string, datatype: string}>} available
 * @param {string} topic
 * @returns {string[]}
 */
export function timesOf(available, topic) {
  const own = available
    .filter(({ field, datatype }) => field.startsWith(`${topic}/`) &&
      (datatype === "time" || (datatype === "float64" && LIKE_A_TIME.test(field))))
    .map(({ field }) => field.slice(topic.length + 1));
  return ["received", ...own.map((name) => (name === "header/stamp" ? "stamp" : name))];
}

/**
 * Have a trace go by another time; all else of it stays.
 * @param {import("../state/state.js").State} state
 * @param {string} name
 * @param {string} time empty to leave it to the scope
 */
export function goBy(state, name, time) {
  const next = parted(name)[0] + (time && `@${time}`);
  const { fields, hidden, right, colours, traces, trigger, levels, chart, measures } = state.values;
  if (fields.includes(next)) return;
  const renamed = (other) => (other === name ? next : other);
  const changes = {
    fields: fields.map(renamed),
    hidden: new Set([...hidden].map(renamed)),
    right: new Set([...right].map(renamed)),
    colours: new Map([...colours].map(([field, colour]) => [renamed(field), colour])),
    traces: new Map([...traces].map(([field, chosen]) => [renamed(field), chosen])),
    levels: levels && { ...levels, field: renamed(levels.field) },
    chart: { ...chart, x: renamed(chart.x) },
    measures: { ...measures, against: renamed(measures.against) },
  };
  if (trigger.field === name) state.setTrigger({ field: next }, changes);
  else state.set(changes);
}

/** Shows by which time a trace goes, and lets another one be chosen. */
export class TimeChoice {
  /**
   * @param {import("../state/state.js").State} state
   * @param {string} name of the trace
   */
  constructor(state, name) {
    this.state = state;
    this.isFixed = isDifference(name); // its times are those of what it is of
    this.chosen = this.isFixed ? "" : parted(name)[1];
    this.auto = make("option", { value: "" }, "auto");
    this.element = make("select", {
      "aria-label": `time of ${name}`,
      "data-control": `time ${name}`,
      title: "the time that the trace goes by",
      disabled: this.isFixed,
      change: () => goBy(state, name, this.element.value),
    }, this.auto, ...options(this.chosen ? [this.chosen] : []));
    this.element.value = this.chosen;
  }

  /**
   * @param {string} topic of the trace
   * @param {string} time that it goes by
   */
  show(topic, time) {
    if (!this.chosen) say(this.auto, `auto (${time})`);
    if (this.isFixed) return;
    const listed = [...this.element.options].map((option) => option.value);
    const missing = timesOf(this.state.values.available, topic).filter((one) => !listed.includes(one));
    this.element.append(...options(missing));
  }
}
