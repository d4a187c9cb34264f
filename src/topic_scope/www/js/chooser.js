/** The dialog to choose traces from all numeric fields on the graph. */

import { byId, make, say } from "./dom.js";

const MOST = 500; // listed at once; the search finds the rest
const TYPED = "as typed";
const FUNCTIONS = ["derivative", "difference", "unwrap"];
const NAME = /^\/[\w/[\]]+(\.[a-z]+)?(@[\w/[\]]+)?$/; // of one field, with what is computed, and its time

/**
 * Make the dialog work.
 * @param {import("./state.js").State} state
 * @returns {function(): void} opens it
 */
export function startChooser(state) {
  const dialog = byId("chooser");
  const search = byId("chooser-search");
  const list = byId("chooser-list");

  function choose(field, wanted) {
    const others = state.values.fields.filter((other) => other !== field);
    state.set({ fields: wanted ? [...others, field] : others });
  }

  function row({ field, datatype }) {
    const box = make("input", { type: "checkbox", change: () => choose(field, box.checked) });
    box.checked = state.values.fields.includes(field);
    const computed = make("select", {
      "aria-label": `what is computed of ${field}`,
      title: "what is computed of it",
      change: () => {
        choose(`${field}.${computed.value}`, true);
        computed.value = "";
      },
    }, make("option", { value: "" }, "…"), ...FUNCTIONS.map((name) => make("option", { value: name }, name)));
    return make("label", {}, box, make("span", {}, field), make("span", { class: "type" }, datatype),
      field.includes(".") || datatype === TYPED ? null : computed);
  }

  function fill() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const found = state.values.available.filter(({ field, datatype }) => {
      const text = `${field} ${datatype}`.toLowerCase();
      return words.every((word) => text.includes(word));
    });
    const typed = search.value.trim();
    const isTyped = NAME.test(typed) && !found.some(({ field }) => field === typed);
    const rows = [...found.slice(0, MOST), ...(isTyped ? [{ field: typed, datatype: TYPED }] : [])];
    list.replaceChildren(...rows.map(row));
    const total = state.values.available.length;
    say(byId("chooser-count"), `${found.length} of ${total} numeric fields` +
      (found.length > MOST ? `, the first ${MOST} are listed` : ""));
  }

  function moveFocus(step) {
    const boxes = [...list.querySelectorAll("input")];
    const place = boxes.indexOf(document.activeElement) + step;
    (place < 0 ? search : boxes[Math.min(place, boxes.length - 1)] || search).focus();
  }

  search.addEventListener("input", fill);
  dialog.addEventListener("keydown", (event) => {
    if (event.target.matches("select")) return;
    if (event.key === "ArrowDown") moveFocus(1);
    else if (event.key === "ArrowUp") moveFocus(-1);
    else if (event.key === "Enter") {
      const box = document.activeElement === search ? list.querySelector("input") : document.activeElement;
      if (box?.type === "checkbox") box.click();
    } else if (event.key === "Escape") dialog.close(); // a search field would only clear itself
    else return;
    event.preventDefault();
  });
  state.on(["available"], () => {
    if (dialog.open && !list.contains(document.activeElement)) fill();
  });

  return () => {
    search.value = "";
    fill();
    dialog.showModal();
    search.focus();
  };
}
