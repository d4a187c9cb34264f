/** Timestamp source of a trace, which follows an @ in the name of the field. */

import { make, options, setText } from "../base/dom.js";
import { bare, inTopic } from "../base/names.js";
import { withField } from "../state/references.js";
import { isComputed } from "../state/traces.js";

const LIKE_A_TIME = /(time|stamp)[^/]*$/;

/**
 * Split a name into the field and its timestamp source.
 * @param {string} name
 * @returns {[string, string]} the field, and the source, empty if the scope chooses
 */
export function splitSource(name) {
  const at = bare(name).indexOf("@");
  return at < 0 ? [name, ""] : [name.slice(0, at), name.slice(at + 1)];
}

/**
 * List the timestamp sources that the messages of a topic have.
 * @param {Array<{field: string, datatype: string, topic: string}>} available
 * @param {string} topic
 * @returns {string[]}
 */
export function sourcesOf(available, topic) {
  const own = available
    .filter(({ field, datatype, topic: other }) => other === topic &&
      (datatype === "time" || (datatype === "float64" && LIKE_A_TIME.test(field))))
    .map(inTopic);
  return ["received", ...own.map((name) => (name === "header/stamp" ? "stamp" : name))];
}

/** Name of a trace with another timestamp source. */
const withSource = (name, source) => splitSource(name)[0] + (source && `@${source}`);

const controlOf = (name) => `timestamp ${name}`;

/**
 * Set the timestamp source of a trace, keeping its other settings.
 * @param {import("../state/store.js").State} state
 * @param {string} name
 * @param {string} source empty to leave it to the scope
 */
export function setSource(state, name, source) {
  const next = withSource(name, source);
  const { fields, hidden, right, colours, traces, trigger, levels, chart, measures, references } = state.values;
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
    references: references.map((one) => (one.field === name ? withField(one, next) : one)),
  };
  if (trigger.field === name) state.setTrigger({ field: next }, changes);
  else state.set(changes);
}

const CLOCK = "clock of "; // no timestamp source starts with it

/**
 * Make the list of timestamp sources of a trace, and of clocks for its stamps.
 * @param {import("../state/store.js").State} state
 * @param {string} name of the trace
 * @param {function(string, string): void} chooseClock takes the topic of the trace, and the topic
 *   whose clock it follows, empty to let the scope estimate it
 * @returns {{element: HTMLSelectElement, show: function(Object, string[]): void}} show takes the
 *   measurements of the trace, and a topic of each estimated clock
 */
export function timestampChoice(state, name, chooseClock) {
  const isFixed = isComputed(name); // its timestamps are those of its fields
  const chosen = isFixed ? "" : splitSource(name)[1];
  const auto = make("option", { value: "" }, "auto");
  let topic = "";
  let clock = ""; // text of the clock that the user has chosen
  const choose = (value) => {
    if (value.startsWith(CLOCK)) chooseClock(topic, value.slice(CLOCK.length));
    else if (clock) chooseClock(topic, "");
    if (value.startsWith(CLOCK)) return;
    setSource(state, name, value);
    const control = controlOf(withSource(name, value));
    // The row was replaced by one with the new name.
    if (!element.isConnected) document.querySelector(`[data-control="${CSS.escape(control)}"]`)?.focus();
  };
  const element = make("select", {
    "aria-label": `timestamp source of ${name}`,
    "data-control": controlOf(name),
    title: "timestamp source",
    disabled: isFixed,
    change: () => choose(element.value),
  }, auto, ...options(chosen ? [chosen] : []));
  element.value = chosen;

  function show(measured, clocks) {
    topic = measured.topic;
    if (!chosen) setText(auto, `auto (${measured.timestamp})`);
    if (isFixed) return;
    clock = measured.clock ? `${CLOCK}${measured.clock}` : "";
    const isStamped = !chosen && measured.timestamp !== "received";
    const others = clocks.filter((one) => isStamped && one !== topic).map((one) => `${CLOCK}${one}`);
    const wanted = [...sourcesOf(state.values.available, topic), ...others, ...(clock ? [clock] : [])];
    for (const one of [...element.options]) {
      if (one.value.startsWith(CLOCK) && !wanted.includes(one.value)) one.remove();
    }
    const listed = [...element.options].map(({ value }) => value);
    element.append(...options([...new Set(wanted)].filter((one) => !listed.includes(one))));
    if (element.value !== (clock || chosen)) element.value = clock || chosen; // also after a rejected choice
  }
  return { element, show };
}
