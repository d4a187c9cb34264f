/** From a topic to its traces. */

import { isUseful } from "./choices.js";
import { notify } from "../base/link.js";

const AT_ONCE = 6; // of more fields than so many the user chooses

/**
 * @param {import("../state/state.js").State} state
 * @param {function(string): void} openChooser with a text to search for
 * @returns {function(string): void} plots a topic
 */
export function startTopicPlot(state, openChooser) {
  return (topic) => {
    const { available, fields } = state.values;
    const found = available.filter((choice) => choice.topic === topic && isUseful(choice)).map(({ field }) => field);
    if (!found.length) {
      notify(`There are no numbers in ${topic} to plot.`);
      return;
    }
    state.set({ view: "scope" });
    if (found.length > AT_ONCE) openChooser(topic);
    else state.set({ fields: [...new Set([...fields, ...found])] });
  };
}
