/** Zoom of the graph: to fit, or by the user; and search in it. */

import { byId, setText } from "../base/dom.js";
import { isForPage } from "../base/keys.js";
import { searchFor } from "../base/names.js";
import { clamp } from "../base/numbers.js";
import { startTwoFingers } from "../base/pointers.js";

const LARGEST = 1.4; // largest scale when fitting
const LIMITS = [0.05, 6];
const CLOSER = 1.25;
const ZOOM_PER_PIXEL = 0.003;

/** Zoom and search of the graph. */
export class GraphZoom {
  /**
   * @param {SVGElement} sheet
   * @param {import("../state/store.js").State} state
   */
  constructor(sheet, state) {
    this.sheet = sheet;
    this.frame = sheet.parentElement;
    this.state = state;
    this.size = { width: 0, height: 0 };
    this.scale = null; // screen pixels per pixel of the graph; null to fit
    this.search = byId("graph-search");
    byId("graph-fit").addEventListener("click", () => this.fit());
    byId("graph-closer").addEventListener("click", () => this.zoom(CLOSER));
    byId("graph-farther").addEventListener("click", () => this.zoom(1 / CLOSER));
    this.search.addEventListener("input", () => this.find());
    this.search.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.next();
    });
    this.frame.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return; // otherwise it scrolls
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * ZOOM_PER_PIXEL), event.clientX, event.clientY);
    }, { passive: false });
    startTwoFingers(this.frame, ({ factor, x, y }) => this.zoom(factor, x, y));
    document.addEventListener("keydown", (event) => this.onKey(event), true);
    new ResizeObserver(() => this.place()).observe(this.frame);
  }

  /**
   * Show a graph of another size.
   * @param {number} width
   * @param {number} height
   */
  resize(width, height) {
    this.size = { width, height };
    this.sheet.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.place();
    this.find();
  }

  /** Scale that fits the whole graph. */
  get fitting() {
    const { clientWidth, clientHeight } = this.frame;
    const { width, height } = this.size;
    return Math.min(LARGEST, clientWidth / width, Math.max(clientHeight / height, 0.6 * clientWidth / width));
  }

  place() {
    const { width, height } = this.size;
    if (!width || !this.frame.clientWidth) return;
    const scale = this.scale ?? this.fitting;
    this.sheet.style.width = `${scale * width}px`;
    this.sheet.style.height = `${scale * height}px`;
  }

  /** Show the whole graph. */
  fit() {
    this.scale = null;
    this.place();
  }

  /**
   * Zoom around a point on the screen, by default the middle.
   * @param {number} factor above 1: closer
   * @param {number} [x]
   * @param {number} [y]
   */
  zoom(factor, x, y) {
    const frame = this.frame.getBoundingClientRect();
    const before = this.sheet.getBoundingClientRect();
    const at = [x ?? frame.left + frame.width / 2, y ?? frame.top + frame.height / 2];
    const part = [(at[0] - before.left) / before.width, (at[1] - before.top) / before.height];
    const [low, high] = LIMITS;
    this.scale = clamp((this.scale ?? this.fitting) * factor, low, high);
    this.place();
    const after = this.sheet.getBoundingClientRect();
    this.frame.scrollLeft += after.left + part[0] * after.width - at[0];
    this.frame.scrollTop += after.top + part[1] * after.height - at[1];
  }

  onKey(event) {
    if (this.state.values.view !== "graph" || !isForPage(event)) return;
    const acts = {
      "+": () => this.zoom(CLOSER), "=": () => this.zoom(CLOSER), "-": () => this.zoom(1 / CLOSER),
      0: () => this.fit(), "/": () => this.search.focus(),
    };
    if (!acts[event.key]) return;
    event.preventDefault();
    event.stopPropagation();
    acts[event.key]();
  }

  /** Mark the nodes and topics that match the search. */
  find() {
    const { words, fits } = searchFor(this.search.value);
    const all = [...this.sheet.querySelectorAll(".node, .topic")];
    this.found = words.length ? all.filter((one) => fits(one.querySelector("title").textContent)) : [];
    all.forEach((one) => one.classList.toggle("found", this.found.includes(one)));
    this.sheet.classList.toggle("searched", words.length > 0);
    setText(byId("graph-found"), words.length ? `${this.found.length} of ${all.length}` : "");
    this.turn = -1;
    if (this.found.length) this.next();
  }

  /** Scroll to the next match. */
  next() {
    if (!this.found.length) return;
    this.turn = (this.turn + 1) % this.found.length;
    this.found[this.turn].scrollIntoView({ block: "nearest", inline: "nearest" });
  }
}
