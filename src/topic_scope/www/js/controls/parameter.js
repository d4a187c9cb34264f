/** Parameter of a node: its control, its help, and the reason for a rejected value. */

import { make, nameText, options, setText } from "../base/dom.js";
import { readNumber, short, typed } from "../base/numbers.js";
import { allowed, isPoor, travel } from "./slider.js";

const EVERY_MS = 60; // between two sets while a slider moves
const ANSWER_MS = 1000; // from a set to its value in force, at most

/** Row of a parameter on a panel. */
export class Parameter {
  /**
   * @param {Object} parameter as the server describes it
   * @param {boolean} readonly
   * @param {function(*): void} set sends a value
   */
  constructor(parameter, readonly, set) {
    this.parameter = parameter;
    this.inForce = parameter.value;
    this.set = set;
    this.sent = parameter.value;
    this.lastSent = -Infinity;
    this.later = null;
    this.settled = null;
    this.refused = false; // whether the typed value was rejected
    this.numeric = parameter.kind === "float" || parameter.kind === "int";
    this.refusal = make("p", { class: "refusal", role: "alert", hidden: true });
    this.control = readonly ? make("output", { class: "value" }) : this.makeControl();
    this.control.setAttribute("aria-label", parameter.name);
    this.slider = this.numeric && !readonly && !parameter.labels.length ? this.makeSlider() : null;
    this.ends = this.slider && make("div", { class: "travel" }, make("i"), this.slider, make("i"));
    const range = allowed(parameter);
    this.element = make(
      "div", { class: "parameter", "data-name": parameter.name },
      make("div", { class: "row" },
        make("label", { title: parameter.name }, nameText(parameter.name)),
        this.control.type === "checkbox" ? make("label", { class: "tick" }, this.control) : this.control,
        make("span", { class: "unit" }, parameter.unit || "")),
      this.ends,
      make("p", { class: "help" }, [parameter.help, range && `(${range})`].filter(Boolean).join(" ")),
      this.refusal,
    );
    this.show();
  }

  makeControl() {
    const { kind, choices, labels } = this.parameter;
    if (kind === "bool") {
      return make("input", { type: "checkbox", change: () => this.want(this.control.checked) });
    }
    if (kind === "enum") {
      return make("select", { change: () => this.want(this.control.value) }, ...options(choices));
    }
    if (labels.length) {
      const words = options(labels.map(([value, word]) => [typed(value, 7), word]));
      return make("select", { change: () => this.want(Number(this.control.value)) }, ...words);
    }
    return make("input", {
      type: "text",
      class: this.numeric ? "value" : "value text",
      inputmode: this.numeric ? "decimal" : false,
      change: () => this.wantTyped(this.control.value),
      keydown: (event) => {
        if (event.key === "Escape") this.giveUp();
      },
    });
  }

  makeSlider() {
    const slider = make("input", {
      type: "range",
      "aria-label": `${this.parameter.name}, slider`,
      pointerdown: () => { this.held = true; },
      input: () => this.wantSoon(Number(slider.value)),
      change: () => {
        this.held = false;
        this.want(Number(slider.value));
      },
    });
    for (const end of ["pointerup", "pointercancel"]) {
      slider.addEventListener(end, () => { this.held = false; });
    }
    return slider;
  }

  wantTyped(text) {
    const number = this.numeric ? readNumber(text) : null;
    // Text that is not a number is sent unchanged: the node replies with the valid range.
    this.want(this.numeric && Number.isFinite(number) ? number : text);
  }

  wantSoon(value) {
    this.control.value = typed(value);
    clearTimeout(this.later);
    const wait = this.lastSent + EVERY_MS - performance.now();
    if (wait <= 0) this.send(value);
    else this.later = setTimeout(() => this.send(value), wait);
  }

  want(value) {
    clearTimeout(this.later);
    this.send(value);
  }

  send(value) {
    this.sent = value;
    this.lastSent = performance.now();
    this.clear();
    this.set(value);
  }

  clear() {
    this.refused = false;
    this.refusal.hidden = true;
    setText(this.refusal, "");
    this.element.classList.remove("refused");
  }

  /** Restore the value in force. */
  giveUp() {
    if (this.refused) this.send(this.inForce); // otherwise the rejected value is retried with the next change
    this.show();
  }

  /**
   * Show the value in force. If other values were set meanwhile, it is the answer to an earlier
   * one, and the control does not return to it.
   * @param {*} value
   */
  update(value) {
    const isNews = value !== this.inForce;
    this.inForce = value;
    clearTimeout(this.settled);
    if (this.refused && (!isNews || document.activeElement === this.control)) return; // the user is correcting it
    if (isNews) this.clear();
    const wait = value === this.sent ? 0 : this.lastSent + ANSWER_MS - performance.now();
    if (wait > 0) this.settled = setTimeout(() => this.update(this.inForce), wait);
    else if (!this.held) this.show();
  }

  /**
   * Show why a value was rejected. Typed text is kept for correction; other controls return to the value
   * in force.
   * @param {string} text
   * @param {boolean} kept whether it is retried with the next value of the node
   */
  refuse(text, kept) {
    const isText = this.control.matches("input[type=text]");
    const again = kept ? " It will be tried again together with the next value that is set here." : "";
    const back = isText ? ` In force: ${asText(this.inForce)}; Escape restores it.` : "";
    setText(this.refusal, `${text}.${again}${back}`);
    this.refused = isText;
    this.refusal.hidden = false;
    this.element.classList.add("refused");
    if (!isText) this.show();
    else if (this.slider && typeof this.inForce === "number") this.showSlider(this.inForce);
  }

  show() {
    const { kind } = this.parameter;
    const value = this.inForce;
    const text = this.numeric && typeof value === "number" ? typed(value, 7) : asText(value);
    this.control.title = asText(value); // a number with all its digits
    if (this.control.tagName === "OUTPUT") this.control.value = text;
    else if (kind === "bool") this.control.checked = Boolean(value);
    else this.control.value = text;
    if (this.slider && typeof value === "number") this.showSlider(value);
  }

  showSlider(value) {
    const wanted = travel(this.parameter, value);
    if (!this.travel || isPoor(this.travel, wanted, value)) {
      this.travel = wanted;
      Object.assign(this.slider, { min: wanted.low, max: wanted.high, step: wanted.step });
      setText(this.ends.firstChild, short(wanted.low));
      setText(this.ends.lastChild, short(wanted.high));
    }
    this.slider.value = value;
  }
}

const asText = (value) => (typeof value === "string" ? value : JSON.stringify(value ?? ""));
