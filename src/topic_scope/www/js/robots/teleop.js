/** Teleoperation: keys, buttons and a joystick, which command only while they are held. */

import { byId, make, setPressed, setText } from "../base/dom.js";
import { notify } from "../base/link.js";
import { clamp, readNumber } from "../base/numbers.js";

const EVERY_MS = 50; // period of commands; the server stops the robot after four missing commands
const KEYS = { // key -> part of the speed and of the turn
  arrowup: [1, 0], w: [1, 0], arrowdown: [-1, 0], s: [-1, 0],
  arrowleft: [0, 1], a: [0, 1], arrowright: [0, -1], d: [0, -1],
};
const PAD = [
  ["↖", "forward and left", 1, 1], ["↑", "forward", 1, 0], ["↗", "forward and right", 1, -1],
  ["←", "turn left", 0, 1], ["■", "stop", 0, 0], ["→", "turn right", 0, -1],
  ["↙", "back, turning left", -1, 1], ["↓", "back", -1, 0], ["↘", "back, turning right", -1, -1],
];

const unit = (value) => clamp(value, -1, 1);

/** Drives a robot through a drive session of the server. */
export class Teleop {
  /**
   * @param {function(Object): void} send takes messages for the server
   */
  constructor(send) {
    this.send = send;
    this.topic = ""; // command topic of the driven robot
    this.held = new Map(); // held key or button -> [speed, turn], each from -1 to 1
    this.timer = null;
    this.button = byId("drive");
    this.select = byId("drive-topic");
    this.button.addEventListener("click", () => (this.topic ? this.releaseWheel() : this.takeWheel()));
    this.select.addEventListener("change", () => { if (this.topic) this.takeWheel(); });
    byId("drive-pad").append(...PAD.map((place) => this.padButton(...place)));
    this.startJoystick(byId("joystick"));
    const release = () => this.release();
    window.addEventListener("blur", release);
    window.addEventListener("pagehide", release);
    document.addEventListener("visibilitychange", release);
    window.addEventListener("keyup", (event) => this.drop(event.key.toLowerCase()));
    this.onSteering({ topic: "", datatype: "" });
  }

  /** Request the wheel. */
  takeWheel() {
    this.release();
    if (this.select.value) this.send({ type: "steer", topic: this.select.value });
  }

  /** Release the wheel; the robot stops. */
  releaseWheel() {
    this.release();
    if (this.topic) this.send({ type: "steer", topic: "" });
    this.onSteering({ topic: "", datatype: "" });
  }

  /**
   * @param {{topic: string, datatype: string}} message the driven topic
   */
  onSteering({ topic, datatype }) {
    this.topic = topic;
    if (!topic) this.stopTimer();
    setPressed(this.button, Boolean(topic));
    setText(this.button, topic ? "Release the wheel" : "Take the wheel");
    setText(byId("drive-state"), topic
      ? `Driving on ${topic}, ${datatype.split("/").pop()}: hold arrow keys or w a s d.` : "");
    byId("drive-controls").disabled = !topic;
  }

  /**
   * A key is pressed.
   * @returns {boolean} whether it is a driving key
   */
  onKey(event) {
    if (!this.topic) return false;
    const key = event.key.toLowerCase();
    if (key === "escape") this.releaseWheel();
    else if (key === " ") this.stop();
    else if (!KEYS[key]) return false;
    else if (!event.repeat) this.hold(key, ...KEYS[key]);
    return true;
  }

  /** A key or button is held: send commands until it is released. */
  hold(control, speed, turn) {
    if (!this.topic) {
      notify("Take the wheel first.");
      return;
    }
    this.held.set(control, [speed, turn]);
    if (this.timer === null) {
      this.timer = setInterval(() => this.command(), EVERY_MS);
      this.command();
    }
  }

  /** A key or button is released. */
  drop(control) {
    if (this.held.delete(control) && !this.held.size) this.stop();
  }

  /** Release all keys and buttons. */
  release() {
    if (this.held.size) this.stop();
  }

  stop() {
    this.stopTimer();
    if (this.topic) this.drive(0, 0);
  }

  stopTimer() {
    this.held.clear();
    clearInterval(this.timer);
    this.timer = null;
    byId("joystick").style.removeProperty("--knob");
  }

  command() {
    const parts = [...this.held.values()];
    const [speed, turn] = [0, 1].map((place) =>
      unit(parts.reduce((sum, part) => sum + part[place], 0)));
    this.drive(speed * this.limit("drive-speed"), turn * this.limit("drive-turn"));
  }

  limit(id) {
    const value = readNumber(byId(id).value);
    return Number.isFinite(value) ? clamp(value, 0, 100) : 0;
  }

  drive(speed, turn) {
    this.send({ type: "drive", speed, turn, sent: performance.now() / 1000 });
  }

  padButton(text, name, speed, turn) {
    const control = `pad ${text}`;
    const down = (event) => {
      if (event.type === "pointerdown") event.target.setPointerCapture(event.pointerId);
      if (speed || turn) this.hold(control, speed, turn);
      else this.stop();
    };
    const isPress = ({ key, repeat }) => (key === "Enter" || key === " ") && !repeat;
    const up = () => this.drop(control);
    return make("button", {
      type: "button", "aria-label": name, title: name,
      pointerdown: down, pointerup: up, pointercancel: up, lostpointercapture: up, blur: up,
      keydown: (event) => { if (isPress(event)) down(event); }, keyup: up,
      contextmenu: (event) => event.preventDefault(), // a long press on a phone
    }, text);
  }

  /** Touch joystick; the buttons are its accessible alternative. */
  startJoystick(stick) {
    const move = (event) => {
      const box = stick.getBoundingClientRect();
      const across = unit((2 * (event.clientX - box.left)) / box.width - 1);
      const up = unit(1 - (2 * (event.clientY - box.top)) / box.height);
      this.hold("stick", up, -across);
      if (this.topic) stick.style.setProperty("--knob", `${across * 32}px, ${-up * 32}px`);
    };
    stick.addEventListener("pointerdown", (event) => {
      stick.setPointerCapture(event.pointerId);
      move(event);
    });
    stick.addEventListener("pointermove", (event) => {
      if (stick.hasPointerCapture(event.pointerId) && this.held.has("stick")) move(event);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      stick.addEventListener(end, () => this.drop("stick"));
    }
  }
}
