/** Set-up of a page: in its address, in files, and from the command line. */

import { byId, download } from "../base/dom.js";
import { notify } from "../base/link.js";
import { KEPT } from "../state/persistence.js";
import { TRIGGER_EDGES, TRIGGER_MODES } from "../state/store.js";
import { isTraces, readTraces, writeTraces } from "../state/traces.js";
import { isChart } from "../plot/kinds.js";

const LATER_MS = 300; // delay of address updates, e.g. during a drag
const COLOUR = /^#[0-9a-f]{6}$/i;
const VIEWS = ["scope", "graph", "robots"];
const VERTICAL = /^y2?(\.[2-8])?$/; // axes of the plots

const isText = (value) => typeof value === "string";
const isBound = (value) => value === null || Number.isFinite(value);
const isList = (value) => Array.isArray(value) && value.every(isText);

/** Writer and validator of each part of a set-up. */
const PARTS = {
  fields: { ok: isList },
  hidden: { ok: isList, write: (set) => [...set], read: (list) => new Set(list) },
  right: { ok: isList, write: (set) => [...set], read: (list) => new Set(list) },
  colours: {
    ok: (value) => typeof value === "object" && Object.values(value).every((one) => COLOUR.test(one)),
    write: (map) => Object.fromEntries(map),
    read: (object) => new Map(Object.entries(object)),
  },
  traces: { ok: isTraces, write: writeTraces, read: readTraces },
  window: { ok: (value) => value > 0 && value <= 3600 },
  baseWindow: { ok: (value) => value > 0 && value <= 3600 },
  trigger: {
    ok: ({ mode, field, level, edge, hysteresis = 0, holdoff = 0, position = 0.5 }) =>
      TRIGGER_MODES.includes(mode) && TRIGGER_EDGES.includes(edge) &&
      isText(field) && Number.isFinite(level) &&
      hysteresis >= 0 && holdoff >= 0 && position >= 0 && position <= 1,
    write: ({ number, ...others }) => others,
  },
  persistence: { ok: (value) => KEPT.includes(value) },
  axes: {
    ok: ({ x, ...others }) => isText(x.title) && [undefined, false, true].includes(x.clock) &&
      others.y && others.y2 && Object.entries(others).every(([name, { title, low, high }]) =>
      VERTICAL.test(name) && isText(title) && isBound(low) && isBound(high)),
  },
  cursors: { ok: (value) => value === null || (Number.isFinite(value.a) && Number.isFinite(value.b)) },
  levels: {
    ok: (value) => value === null ||
      (isText(value.field) && Number.isFinite(value.c) && Number.isFinite(value.d)),
  },
  chart: { ok: isChart },
  measures: {
    ok: ({ figures, against, between, overTime = 0 }) =>
      isList(figures) && isText(against) && typeof between === "boolean" && Number.isInteger(overTime),
  },
  panels: { ok: (value) => typeof value === "boolean" },
  images: { ok: ({ shown, topic }) => typeof shown === "boolean" && isText(topic) },
  view: { ok: (value) => VIEWS.includes(value) },
};

/**
 * Return the set-up of a page.
 * @param {Object} values of the state
 * @returns {Object} for JSON
 */
export function written(values) {
  const write = ([name, part]) => [name, part.write ? part.write(values[name]) : values[name]];
  return Object.fromEntries(Object.entries(PARTS).map(write));
}

/**
 * Parse the output of {@link written}; missing parts stay unchanged.
 * @param {Object} setup
 * @returns {Object} values for the state
 * @throws {Error} if it is invalid; the text names the part
 */
export function read(setup) {
  if (typeof setup !== "object" || setup === null) throw new Error("a set-up must be a JSON object");
  return Object.fromEntries(Object.entries(setup).map(([name, value]) => {
    let ok = false;
    try {
      ok = PARTS[name].ok(value);
    } catch (error) { /* the part is missing or malformed */ }
    if (!ok) throw new Error(`the set-up has an invalid ${name}`);
    return [name, PARTS[name].read ? PARTS[name].read(value) : value];
  }));
}

/** Synchronises the address with the state, and loads set-ups. */
export class Setup {
  /**
   * @param {import("../state/store.js").State} state
   */
  constructor(state) {
    this.state = state;
    this.given = null; // the scope's set-up, from its command line
    this.timer = null;
    this.chosen = false; // whether the address contains a set-up
    state.on(Object.keys(PARTS), () => this.keepSoon());
    byId("setup-save").addEventListener("click", () => this.save());
    byId("setup-load").addEventListener("change", (event) => this.load(event.target));
    // Pasting an address into an open page does not reload it: only the fragment differs.
    // keepSoon may have overwritten it by then.
    window.addEventListener("hashchange", ({ newURL }) => this.restoreAddress(new URL(newURL).hash));
  }

  /**
   * Apply the set-up of an address.
   * @param {string} hash its part from "#" on
   */
  restoreAddress(hash) {
    let text = hash.slice(1);
    try {
      text = decodeURIComponent(text);
    } catch (error) { /* it was cut off, so it is not JSON either */ }
    this.chosen = this.restore(text);
  }

  /** Store the scope's defaults, which an address omits. */
  rememberGiven() {
    const shown = written(this.state.values);
    const given = this.given ? { ...JSON.parse(this.given), fields: shown.fields } : shown;
    this.given = JSON.stringify(given);
    this.keepSoon();
  }

  /**
   * Apply a set-up in JSON.
   * @param {string} text as {@link written}, in JSON
   * @returns {boolean} whether the text is a valid set-up
   */
  restore(text) {
    if (!text) return false;
    try {
      this.apply(JSON.parse(text));
      return true;
    } catch (error) {
      notify(error instanceof SyntaxError ? "the set-up is not valid JSON" : error.message);
      return false;
    }
  }

  /**
   * Apply a set-up.
   * @param {Object} setup
   */
  apply(setup) {
    const { trigger, ...others } = read(setup);
    if (trigger) this.state.setTrigger(trigger, others);
    else this.state.set(others);
  }

  keepSoon() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      const text = JSON.stringify(written(this.state.values));
      const address = text === this.given ? location.pathname : `#${encodeURIComponent(text)}`;
      history.replaceState(null, "", address);
    }, LATER_MS);
  }

  save() {
    const text = JSON.stringify(written(this.state.values), null, 2);
    download(new Blob([text], { type: "application/json" }), "scope_setup.json");
  }

  async load(input) {
    const [file] = input.files;
    if (file) this.restore(await file.text());
    input.value = ""; // so that the same file can be loaded again
  }
}
