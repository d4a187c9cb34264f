/** Colours and dashes of the traces, and light or dark. */

import { chosenOf, DASHES } from "./traces.js";

const LIGHT = [
  "#0b66c3", "#c8553d", "#1f8a55", "#b07a00", "#7a4fc0",
  "#00838f", "#b0307f", "#6b7a00", "#8a4b2a", "#4a5a70",
];
const DARK = [
  "#58aefc", "#ff8f73", "#5fd38d", "#f2c14e", "#bd9bff",
  "#3fd0dc", "#f783c4", "#c6d45a", "#d9996f", "#a6b6c8",
];

const slotOf = ({ values }, field) =>
  chosenOf(values, field).slot ?? Math.max(0, values.fields.indexOf(field));

/**
 * Return the colour of a trace: chosen, or the colour of its slot. Together with the dash, up to forty
 * traces differ by default.
 * @param {import("./store.js").State} state
 * @param {string} field
 * @returns {string} #rrggbb
 */
export function colourOf(state, field) {
  return state.values.colours.get(field) || paletteColour(state, slotOf(state, field));
}

/**
 * Return the dash of a trace: chosen, or the dash of its slot.
 * @param {import("./store.js").State} state
 * @param {string} field
 * @returns {number[]} dashes and gaps in turn [pixels]; empty for a solid line
 */
export function dashOf(state, field) {
  const { dash } = chosenOf(state.values, field);
  if (dash) return DASHES.get(dash);
  const patterns = [...DASHES.values()];
  return patterns[Math.floor(slotOf(state, field) / LIGHT.length) % patterns.length];
}

/**
 * Return a sample of a trace's line.
 * @param {import("./store.js").State} state
 * @param {string} field
 * @returns {string} a CSS background
 */
export function sampleOf(state, field) {
  const colour = colourOf(state, field);
  let at = 0;
  const parts = dashOf(state, field).map((length, index) => {
    at += length;
    return `${index % 2 ? "transparent" : colour} ${at - length}px ${at}px`;
  });
  return parts.length ? `repeating-linear-gradient(90deg, ${parts.join(", ")})` : colour;
}

/**
 * Return a colour of the palette.
 * @param {import("./store.js").State} state
 * @param {number} place from 0
 * @returns {string} #rrggbb
 */
export function paletteColour(state, place) {
  const palette = state.values.theme === "dark" ? DARK : LIGHT;
  return palette[place % palette.length];
}

/**
 * Follow the system's preference until the user chooses, and remember that choice.
 * @param {import("./store.js").State} state
 * @param {HTMLElement} button
 */
export function startTheme(state, button) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const preferred = () => localStorage.getItem("theme") || (system.matches ? "dark" : "light");
  const show = () => {
    const theme = preferred();
    document.documentElement.dataset.theme = theme;
    button.textContent = theme === "dark" ? "Light" : "Dark";
    state.set({ theme });
  };
  system.addEventListener("change", show);
  button.addEventListener("click", () => {
    localStorage.setItem("theme", state.values.theme === "dark" ? "light" : "dark");
    show();
  });
  show();
}
