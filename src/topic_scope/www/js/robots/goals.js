/** Sends robots to places: by a click on the picture, or by numbers. */

import { byId, setPressed, setText } from "../base/dom.js";
import { readNumber, typed } from "../base/numbers.js";

const DEGREES = 180 / Math.PI;

/** Setting of goals; shows the last goal until another goal is published. */
export class Goals {
  /**
   * @param {function(Object): void} send takes messages for the server
   * @param {function(): ?Object} chosen returns the robot for the goals
   * @param {function(): void} refresh redraws the picture
   */
  constructor(send, chosen, refresh) {
    this.send = send;
    this.chosen = chosen;
    this.refresh = refresh;
    this.picking = false;
    this.mark = null; // {topic, x, y, heading}: being drawn out, or sent
    this.published = "";
    byId("goal-pick").addEventListener("click", () => this.setPicking(!this.picking));
    byId("goal-send").addEventListener("click", () => this.sendTyped());
  }

  setPicking(on) {
    this.picking = on;
    setPressed(byId("goal-pick"), on);
    byId("robot-canvas").dataset.picking = on;
  }

  /** A goal is being dragged. */
  aim(goal) {
    this.mark = goal && { ...this.completed(goal), topic: byId("goal-topic").value };
    this.refresh();
  }

  /** A goal is set in the picture. */
  pick(goal) {
    this.setPicking(false);
    const { x, y, heading } = this.completed(goal);
    byId("goal-x").value = typed(x, 3);
    byId("goal-y").value = typed(y, 3);
    byId("goal-heading").value = typed(heading * DEGREES, 3);
    this.go(x, y, heading);
  }

  sendTyped() {
    const [x, y, heading] = ["x", "y", "heading"].map((name) => readNumber(byId(`goal-${name}`).value));
    if (![x, y].every(Number.isFinite) || Number.isNaN(heading)) {
      setText(byId("goal-state"), "x, y and heading must be numbers, in m and degrees.");
      return;
    }
    this.go(x, y, heading === null ? this.completed({ x, y, heading }).heading : heading / DEGREES);
  }

  /** Without a given heading, a goal points away from the robot. */
  completed({ x, y, heading }) {
    const robot = this.chosen();
    return { x, y, heading: heading ?? (robot ? Math.atan2(y - robot.y, x - robot.x) : 0) };
  }

  go(x, y, heading) {
    const topic = byId("goal-topic").value;
    const frame = this.chosen()?.frame || "odom";
    this.send({ type: "goal", topic, frame, x, y, heading });
    this.mark = { topic, x, y, heading };
    setText(byId("goal-state"), "…");
    this.refresh();
  }

  /** @param {{topic: string}} message the server has sent it */
  onSent({ topic }) {
    setText(byId("goal-state"), `Sent on ${topic}.`);
  }

  /** Published goals replace the goal that was sent from here. */
  onGoals(goals) {
    const text = JSON.stringify(goals);
    if (this.published && text !== this.published) this.mark = null;
    this.published = text;
  }

  /** The goals to draw. */
  shown(goals) {
    return this.mark ? [...goals, { ...this.mark, isFaint: true }] : goals;
  }
}
