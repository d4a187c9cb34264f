/** Counts the frames that are drawn. */

/** How many frames were drawn in the last second. */
export class FrameRate {
  constructor() {
    this.times = [];
  }

  /**
   * Count one.
   * @param {number} now ms
   */
  count(now) {
    this.times.push(now);
    while (this.times[0] < now - 1000) this.times.shift();
  }

  /**
   * @param {number} now ms
   * @returns {number} frames a second
   */
  at(now) {
    return this.times.filter((time) => time > now - 1000).length;
  }
}
