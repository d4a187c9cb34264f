/** Overlaid bags, and the position of each in time. */

import { byId, make } from "../base/dom.js";
import { notify } from "../base/link.js";
import { readNumber, typed } from "../base/numbers.js";

/**
 * Set up the bar of the bags.
 * @param {import("../state/view.js").View} view
 * @param {import("../state/sweep.js").Sweep} sweep
 * @param {function(Object): void} send sends a request
 * @returns {function({bags: {name: string, file: string, begin: number, offset: number,
 *   length: number}[]}): void} shows the server's message about them
 */
export function startOverlays(view, sweep, send) {
  const bar = byId("overlays");
  const rows = new Map(); // name -> its controls

  /** Align a bag's first crossing with the trigger, and show it. */
  function align(name) {
    if (view.state.values.trigger.mode === "off") notify("Choose a trigger first: the bag is aligned at its level.");
    else if (!sweep.held) notify("Nothing has triggered yet: there is no time to align the bag with.");
    else {
      const { time } = sweep.held;
      view.pause();
      send({ type: "overlay", name, trigger: time });
    }
  }

  function rowOf({ name, file, length }) {
    const offset = make("input", {
      inputmode: "decimal",
      size: 7,
      "aria-label": `offset of ${name}, s`,
      title: "shift of the bag, s",
      change: () => {
        const number = readNumber(offset.value);
        if (Number.isFinite(number)) send({ type: "overlay", name, offset: number });
        else offset.value = typed(rows.get(name).laid);
      },
    });
    const button = (text, title, act) => make("button", {
      type: "button", title, "aria-label": `${text}: ${name}`, click: act,
    }, text);
    const element = make("div", { class: "group", role: "group", "aria-label": `bag ${name}` },
      make("strong", { title: `${file}, ${typed(length, 4)} s` }, name),
      make("label", { class: "field" }, "offset", offset, "s"),
      button("Align at the trigger", "shift the bag so that it first crosses the trigger level at the trigger",
        () => align(name)),
      button("Begin at the left edge", "shift the start of the bag to the left edge of the plot",
        () => send({ type: "overlay", name, begin: sweep.shown.from })));
    return { element, offset, laid: 0 };
  }

  return ({ bags }) => {
    bar.hidden = !bags.length;
    const names = bags.map(({ name }) => name);
    for (const name of [...rows.keys()].filter((one) => !names.includes(one))) {
      rows.get(name).element.remove(); // the page is connected to another scope now
      rows.delete(name);
    }
    for (const bag of bags) {
      if (!rows.has(bag.name)) {
        rows.set(bag.name, rowOf(bag));
        bar.append(rows.get(bag.name).element);
      }
      const row = rows.get(bag.name);
      row.laid = bag.offset;
      if (document.activeElement !== row.offset) row.offset.value = typed(bag.offset);
    }
  };
}
