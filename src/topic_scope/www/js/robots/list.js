/** Table of the robots, as text alternative to the picture and to choose one. */

import { byId, make, setPressed, setText } from "../base/dom.js";
import { typed } from "../base/numbers.js";

const DEGREES = 180 / Math.PI;

/** The name of a robot by its topic: robot1 for /robot1/odom. */
export const nameOf = (topic) => topic.replace(/^\//, "").replace(/(.)\/odom$/, "$1");

/** Distance of another odometry of a robot from the shown odometry. */
function away(robot, { x, y, heading, frame, silent }) {
  if (silent) return "silent";
  if (frame !== robot.frame) return `in the frame ${frame}`;
  const turn = heading - robot.heading;
  const turned = Math.abs(Math.atan2(Math.sin(turn), Math.cos(turn))) * DEGREES;
  return `${Math.hypot(x - robot.x, y - robot.y).toFixed(2)} m and ${turned.toFixed(0)}° away`;
}

/** Shows a row for each robot. */
export class RobotList {
  /**
   * @param {function(string): string} colour gives the colour of a robot by its topic
   * @param {function(string): void} choose takes the topic of a robot whose row is pressed
   */
  constructor(colour, choose) {
    this.colour = colour;
    this.choose = choose;
    this.rows = new Map(); // topic -> button
  }

  /** Rebuild all rows: the colours have changed. */
  forget() {
    this.rows.clear();
  }

  /**
   * @param {Object[]} robots see odometries.js
   * @param {string} chosen topic of the chosen robot
   */
  show(robots, chosen) {
    const topics = robots.map(({ topic }) => topic);
    if (topics.join() !== [...this.rows.keys()].join()) this.make(topics);
    for (const robot of robots) {
      const { topic, x, y, heading, speed, silent, others } = robot;
      const row = this.rows.get(topic);
      setPressed(row, topic === chosen);
      const place = `${x.toFixed(2)}, ${y.toFixed(2)} m, ${(heading * DEGREES).toFixed(0)}°`;
      const motion = silent ? "no data" : `${typed(speed, 2)} m/s`;
      const lines = others.map((other) => `${nameOf(other.topic)} is ${away(robot, other)}`);
      lines.unshift(`${nameOf(topic)}: ${`${place}, ${motion}`.replaceAll("-", "−")}`);
      setText(row, lines.join("\n"));
    }
  }

  make(topics) {
    this.rows = new Map(topics.map((topic) => [topic, make("button", {
      type: "button", class: "quiet", "data-topic": topic, title: `follow ${topic}`,
      click: () => this.choose(topic),
    })]));
    byId("robot-list").replaceChildren(...[...this.rows].map(([topic, row]) =>
      make("li", { style: `--robot: ${this.colour(topic)}` }, row)));
  }
}
