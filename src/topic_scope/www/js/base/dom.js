/** Helpers to find, create and change elements, and to save files. */

import { partsOf } from "./names.js";

/**
 * Find an element by its id.
 * @param {string} id
 * @returns {HTMLElement}
 */
export const byId = (id) => document.getElementById(id);

const SVG = "http://www.w3.org/2000/svg";

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

/**
 * Make an HTML element. A function among the attributes listens to the event of that name.
 * @param {string} tag
 * @param {Object<string, *>} [attributes] true sets an empty attribute, false and null none
 * @param {...(Node|string|null)} children
 * @returns {HTMLElement}
 */
export function make(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/**
 * Make the text of a name, with line breaks only between its parts.
 * @param {string} name
 * @returns {HTMLSpanElement}
 */
export function nameText(name) {
  return make("span", {}, ...partsOf(name).flatMap((part, place) => (place ? [make("wbr"), part] : [part])));
}

/**
 * Make an SVG element; as {@link make}.
 * @param {string} tag
 * @param {Object<string, *>} [attributes]
 * @param {...(Node|string|null)} children
 * @returns {SVGElement}
 */
export function draw(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

/**
 * Set the text of an element, if it differs.
 * @param {Element} element
 * @param {string} text
 */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/**
 * Set the tooltip of an element, if it differs.
 * @param {HTMLElement} element
 * @param {string} text
 */
export function setTitle(element, text) {
  if (element.title !== text) element.title = text;
}

/**
 * Set whether a toggle button is pressed.
 * @param {Element} button
 * @param {boolean} down
 */
export function setPressed(button, down) {
  button.setAttribute("aria-pressed", String(down));
}

/**
 * Make the options of a list.
 * @param {Array<string|number|Array<string|number>>} choices values, or pairs of a value and its text
 * @returns {HTMLOptionElement[]}
 */
export function options(choices) {
  return choices.map((choice) => {
    const [value, text] = Array.isArray(choice) ? choice : [choice, choice];
    return make("option", { value }, text);
  });
}

/**
 * Return a colour of the theme.
 * @param {string} name of its property in theme.css, without the dashes
 * @returns {string}
 */
export function themeColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/**
 * Save a file through the browser.
 * @param {Blob} blob
 * @param {string} name of the file
 */
export function download(blob, name) {
  const address = URL.createObjectURL(blob);
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}
