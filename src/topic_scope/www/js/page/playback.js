/** Playback of a bag: position, speed, and the parts of the page that need a live graph. */

import { clockText, dateText, zoneText } from "../base/clock.js";
import { byId, options, setText } from "../base/dom.js";
import { notify } from "../base/link.js";
import { clamp, typed } from "../base/numbers.js";

const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
const EVERY_MS = 250; // between two updates of the position

const optionOf = (speed) => [speed, `${typed(speed)} ×`];

/** Playback bar of a bag; synchronises its clock with the view. */
export class Playback {
  /**
   * @param {import("../state/store.js").State} state
   * @param {import("../state/sweep.js").Sweep} sweep
   * @param {function(Object): void} send
   * @param {function(): void} onJump called after its clock has jumped
   */
  constructor(state, sweep, send, onJump) {
    this.state = state;
    this.sweep = sweep;
    this.onJump = onJump;
    this.send = (changes) => send({ type: "playback", ...changes });
    this.bag = null;
    this.latest = null; // latest playback state of the server
    this.follows = false; // whether the view follows a jump of the clock
    this.picked = null; // slider position that the clock has not reached yet, s
    this.place = byId("playback-place");
    this.speed = byId("playback-speed");
    this.speed.append(...options(SPEEDS.map(optionOf)));
    this.speed.addEventListener("change", () => this.send({ speed: Number(this.speed.value) }));
    this.place.addEventListener("input", () => this.pick());
    this.place.addEventListener("change", () => {
      this.pick();
      this.send({ time: this.picked });
    });
    state.on(["end"], ({ end, playing }) => {
      const goes = end === null;
      if (this.bag && !this.follows && goes !== playing) this.send({ playing: goes });
    });
    state.on(["view"], ({ view }) => {
      if (!this.bag || view !== "graph") return;
      state.set({ view: "scope" });
      notify("A bag has no nodes, so there is no graph.");
    });
    setInterval(() => this.show(), EVERY_MS);
  }

  /**
   * Handle the server's hello, which names the bag, if any.
   * @param {{bag: ?{name: string, start: number, end: number}}} message
   * @param {boolean} fresh whether the page shows the scope's defaults
   */
  onHello({ bag = null }, fresh) {
    this.bag = bag;
    this.latest = null;
    document.body.classList.toggle("bag", bag !== null);
    byId("playback").hidden = bag === null;
    this.state.set({ isBag: bag !== null, playing: bag === null });
    if (!bag) return;
    setText(byId("playback-name"), bag.name);
    this.place.max = bag.end - bag.start;
    if (fresh) this.state.setAxis("x", { clock: true });
  }

  /**
   * @param {{playing: boolean, speed: number, loading: boolean, jumps: number}} message
   */
  onState(message) {
    const jumped = this.latest && this.latest.jumps !== message.jumps;
    this.latest = message;
    this.state.set({ playing: message.playing });
    const speed = String(message.speed);
    if (![...this.speed.options].some(({ value }) => value === speed)) {
      this.speed.append(...options([optionOf(message.speed)]));
    }
    this.speed.value = speed;
    if (!message.loading) this.picked = null;
    if (jumped) {
      this.follows = true;
      this.sweep.release();
      this.state.set({ end: null, reference: null });
      this.follows = false;
      this.onJump();
    }
    this.show();
  }

  pick() {
    this.picked = this.bag.start + Number(this.place.value);
    this.show();
  }

  show() {
    if (!this.bag || !this.latest) return;
    const { start, end } = this.bag;
    const time = this.picked ?? clamp(this.sweep.live.now, start, end);
    if (this.picked === null) this.place.value = time - start;
    const at = `${dateText(time)} ${clockText(time, 0.01)} ${zoneText(time)}`;
    const text = `${at}, ${(time - start).toFixed(2)} of ${(end - start).toFixed(2)} s`;
    setText(byId("playback-time"), this.latest.loading ? `${text}, loading` : text);
    this.place.setAttribute("aria-valuetext", text);
  }
}
