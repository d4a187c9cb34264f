/** The dialog to choose traces from all numbers and states on the graph. */

import { byId, make, options, setText } from "../base/dom.js";
import { notify } from "../base/link.js";
import { bare, inTopic } from "../base/names.js";
import { isFormula } from "../state/traces.js";
import { found, isUseful } from "./field_list.js";
import { FormulaEntry } from "./formula.js";

const MOST = 500; // listed fields; the search finds the rest
const OPEN = 40; // up to this number of fields, all topics are open
const TRACES = 32; // must match the server
const AT_ONCE = 6; // if a topic has more fields, the user chooses
const TYPED = "as typed";
const FORMULA = "formula";
const FUNCTIONS = ["derivative", "difference", "unwrap"];
const FIELD = "/[\\w/[\\]-]+(\\.[a-z]+)?(@[\\w/[\\]]+)?"; // with function and timestamp source
const NAME = new RegExp(`^${FIELD}(-${FIELD})?$`); // a field, or the difference of two

/**
 * Plot a topic: its fields, or a choice of the user if there are many.
 * @param {import("../state/store.js").State} state
 * @param {function(string): void} openChooser with a text to search for
 * @param {string} topic
 */
export function plotTopic(state, openChooser, topic) {
  const { available, fields } = state.values;
  const useful = available.filter((choice) => choice.topic === topic && isUseful(choice))
    .map(({ field }) => field);
  if (!useful.length) {
    notify(`${topic} has no numbers or states to plot.`);
    return;
  }
  state.set({ view: "scope" });
  if (useful.length > AT_ONCE) openChooser(topic);
  else state.set({ fields: [...new Set([...fields, ...useful])] });
}

/**
 * Make the dialog work.
 * @param {import("../state/store.js").State} state
 * @param {function(Object): void} send sends a request
 * @returns {{open: function(string=): void, onFormula: function(Object): void}} opens it, with a
 *   text to search for; takes the server's reply about a formula
 */
export function startChooser(state, send) {
  const dialog = byId("chooser");
  const search = byId("chooser-search");
  const list = byId("chooser-list");
  const all = byId("chooser-all");
  const problem = byId("chooser-note");

  /** Choose a field, or drop it; returns whether that was possible. */
  function choose(field, wanted) {
    const others = state.values.fields.filter((other) => other !== field);
    if (wanted && others.length >= TRACES) {
      setText(problem, `A page shows at most ${TRACES} traces: remove one first.`);
      return false;
    }
    setText(problem, "");
    state.set({ fields: wanted ? [...others, field] : others });
    return true;
  }

  function row({ field, datatype, topic }) {
    const box = make("input", {
      type: "checkbox",
      "aria-label": field,
      checked: state.values.fields.includes(field),
      change: () => { box.checked = choose(field, box.checked) && box.checked; },
    });
    const computed = make("select", {
      "aria-label": `derive a trace from ${field}`,
      title: "derive a trace",
      change: () => {
        choose(`${field}.${computed.value}`, true);
        computed.value = "";
      },
    }, ...options([["", "…"], ...FUNCTIONS]));
    return make("label", { title: field }, box, make("span", {}, inTopic({ field, topic })),
      make("span", { class: "type" }, datatype),
      bare(field).includes(".") || [TYPED, FORMULA].includes(datatype) ? null : computed);
  }

  function group({ topic, datatype, fields }, isOpen) {
    const chosen = fields.some(({ field }) => state.values.fields.includes(field));
    return make("details", { "data-topic": topic, "aria-label": topic, open: isOpen || chosen },
      make("summary", {}, make("span", {}, topic), make("span", { class: "type" }, datatype)),
      ...fields.map(row));
  }

  const formula = new FormulaEntry(state, send, () => fill());

  /** Show a formula in place of search results. */
  function fillFormula(text) {
    formula.ask(text);
    const { name, problem: words } = formula.answer || {};
    list.replaceChildren(...(name ? [row({ field: name, datatype: FORMULA, topic: "" })] : []), ...formula.help());
    setText(problem, words || "");
    setText(byId("chooser-count"), name ? "Enter shows it." : "");
  }

  function fill() {
    const { available, types } = state.values;
    const typed = search.value.trim();
    if (isFormula(typed)) {
      fillFormula(typed);
      return;
    }
    const { groups, count: total, hidden } = found(available, types, typed, all.checked);
    const isListed = groups.some(({ fields }) => fields.some(({ field }) => field === typed));
    const rows = [];
    let left = MOST;
    for (const one of groups) {
      if (left <= 0) break;
      rows.push(group({ ...one, fields: one.fields.slice(0, left) }, typed !== "" || total <= OPEN));
      left -= one.fields.length;
    }
    if (NAME.test(typed) && !isListed) rows.push(row({ field: typed, datatype: TYPED, topic: "" }));
    list.replaceChildren(...rows);
    setText(byId("chooser-count"), `${total} fields on ${groups.length} topics` +
      (left < 0 ? `, the first ${MOST} are listed` : "") + (hidden ? `, ${hidden} more on hidden topics` : ""));
  }

  /** Elements for the arrow keys: topics, and the fields of open topics. */
  const stops = () => [...list.querySelectorAll("summary, label input")]
    .filter((element) => element.matches("summary") || !element.closest("details:not([open])"));

  function moveFocus(step) {
    const all = stops();
    const place = all.indexOf(document.activeElement) + step;
    (place < 0 ? search : all[Math.min(place, all.length - 1)] || search).focus();
  }

  search.addEventListener("input", () => {
    setText(problem, "");
    fill();
  });
  all.addEventListener("change", fill);
  dialog.addEventListener("keydown", (event) => {
    if (event.target.matches("select")) return;
    if (event.key === "ArrowDown") moveFocus(1);
    else if (event.key === "ArrowUp") moveFocus(-1);
    else if (event.key === "Enter") {
      const focused = document.activeElement;
      if (focused !== search && !list.contains(focused)) return; // a button
      (focused === search ? stops().find((one) => one.matches("input")) : focused)?.click();
    } else if (event.key === "Escape") dialog.close(); // a search field would only clear itself
    else return;
    event.preventDefault();
  });
  state.on(["available"], () => {
    if (dialog.open && !list.contains(document.activeElement)) fill();
  });

  return {
    open: (text = "") => {
      search.value = text;
      setText(problem, "");
      fill();
      dialog.showModal();
      search.focus();
    },
    onFormula: (answer) => {
      if (dialog.open) formula.take(answer);
    },
  };
}
