/** Entry of a formula in the search field; the server checks it while it is typed. */

import { make } from "../base/dom.js";

const LETTERS = "abcdefghijklmnopqrstuvwxyz";

/** Server's check of the formula that is being typed. */
export class FormulaEntry {
  /**
   * @param {import("../state/store.js").State} state
   * @param {function(Object): void} send sends a request
   * @param {function(): void} onAnswer called when the server has answered
   */
  constructor(state, send, onAnswer) {
    this.state = state;
    this.send = send;
    this.onAnswer = onAnswer;
    this.asked = ""; // the latest request, as text
    this.answer = null;
  }

  /**
   * Ask the server to check a formula, unless it already has.
   * @param {string} text with its =
   */
  ask(text) {
    const request = { type: "formula", text, traces: this.state.values.fields };
    const asked = JSON.stringify(request);
    if (asked === this.asked) return;
    this.asked = asked;
    this.answer = null;
    this.send(request);
  }

  /**
   * Take the server's answer, unless something else has been typed since.
   * @param {{text: string, name: string, problem: ?string, functions: string[]}} answer
   */
  take(answer) {
    if (!this.asked || answer.text !== JSON.parse(this.asked).text) return;
    this.answer = answer;
    this.onAnswer();
  }

  /** Help for the entry: the meaning of the letters, and the functions. */
  help() {
    const traces = this.state.values.fields.slice(0, LETTERS.length);
    const lines = traces.map((field, index) => `${LETTERS[index]} is ${field}`);
    if (this.answer) lines.push(`Functions: ${this.answer.functions.join(", ")}.`);
    return lines.map((text) => make("p", { class: "hint" }, text));
  }
}
