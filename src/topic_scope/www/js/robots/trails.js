/** Trails of the robots since the page was opened. */

const APART = 0.02; // distance of two points, m
const JUMP = 0.5; // a larger movement between two messages starts a new line, m
const MOST = 5000; // points of a robot

/** Trails of all robots, each with one or several lines. */
export class Trails {
  constructor() {
    this.lines = new Map(); // topic -> lines of [x, y]
  }

  /**
   * Add the positions of the robots; trails of other robots are dropped.
   * @param {{topic: string, x: number, y: number}[]} robots
   */
  add(robots) {
    this.lines = new Map(robots.map(({ topic }) => [topic, this.lines.get(topic) ?? [[]]]));
    for (const { topic, x, y } of robots) {
      const lines = this.lines.get(topic);
      const line = lines[lines.length - 1];
      const last = line[line.length - 1];
      const far = last ? Math.hypot(x - last[0], y - last[1]) : 0;
      if (last && far < APART) continue;
      if (far > JUMP) lines.push([[x, y]]);
      else line.push([x, y]);
      lines[0].splice(0, lines.reduce((sum, { length }) => sum + length, -MOST) > 0 ? 1 : 0);
      if (!lines[0].length && lines.length > 1) lines.shift();
    }
  }

  /** The lines of a robot. */
  of(topic) {
    return this.lines.get(topic) ?? [];
  }

  /** Remove all trails. */
  clear() {
    this.lines.clear();
  }
}
