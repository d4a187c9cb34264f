/** Camera: metres to pixels, with one scale for both axes and y upwards. */

import { clamp } from "../base/numbers.js";

const SCALES = [0.5, 20000]; // pixels per metre

/** Looks straight down at a place. */
export class Camera {
  constructor() {
    this.x = 0; // in the middle of the picture, m
    this.y = 0;
    this.scale = 80; // pixels per metre
    this.width = 1; // pixels
    this.height = 1;
  }

  /**
   * Return the position of a place in the picture.
   * @returns {[number, number]} pixels from the top left corner
   */
  toPicture(x, y) {
    return [(x - this.x) * this.scale + this.width / 2, this.height / 2 - (y - this.y) * this.scale];
  }

  /**
   * Return the place at a point of the picture.
   * @returns {[number, number]} m
   */
  toWorld(across, down) {
    return [
      this.x + (across - this.width / 2) / this.scale,
      this.y + (this.height / 2 - down) / this.scale,
    ];
  }

  /**
   * Zoom around a point of the picture.
   * @param {number} factor above 1: closer
   */
  zoom(factor, across = this.width / 2, down = this.height / 2) {
    const [x, y] = this.toWorld(across, down);
    this.scale = clamp(this.scale * factor, ...SCALES);
    const [newX, newY] = this.toWorld(across, down);
    this.x += x - newX;
    this.y += y - newY;
  }

  /** Move the picture by some pixels. */
  pan(across, down) {
    this.x -= across / this.scale;
    this.y += down / this.scale;
  }

  /**
   * Fit places into the picture.
   * @param {[number, number][]} places m
   */
  fit(places) {
    if (!places.length) return;
    const bounds = [0, 1].map((axis) => {
      const values = places.map((place) => place[axis]);
      return [Math.min(...values), Math.max(...values)];
    });
    [this.x, this.y] = bounds.map(([low, high]) => (low + high) / 2);
    const [wide, high] = bounds.map(([from, to]) => Math.max(to - from, 2) * 1.15);
    this.scale = clamp(Math.min(this.width / wide, this.height / high), ...SCALES);
  }
}
