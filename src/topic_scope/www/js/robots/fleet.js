/** Status tiles, one for each robot. */

import { byId, make } from "../base/dom.js";
import { figure } from "../base/numbers.js";

const MODES = ["idle", "moving", "working", "charging", "error"]; // of RobotStatus
const READINGS = [["battery", "V"], ["inside", "°C"], ["obstacle", "m"]];

function tile({ topic, name, mode, readings, age }) {
  const text = MODES[mode] ?? `mode ${mode}`;
  const rows = readings.map((value, place) => {
    const [label, unit] = READINGS[place] ?? [`reading ${place}`, ""];
    return [make("dt", {}, label), make("dd", {}, `${figure(value, 4)} ${unit}`)];
  }).flat();
  return make("li", { class: "tile", "data-mode": text, "data-topic": topic, title: topic },
    make("h3", {}, name || topic), make("span", { class: "mode" }, text), make("dl", {}, ...rows),
    age === null ? null : make("p", { class: "answer bad" }, `no data for ${age} s`));
}

let shown = "";

/**
 * Show the tiles; rebuild them only if they differ.
 * @param {{robots: Object[]}} message as the server sends it
 */
export function showFleet({ robots }) {
  const rounded = robots.map((robot) => ({ ...robot, age: robot.age && Math.round(robot.age) }));
  const text = JSON.stringify(rounded);
  if (text === shown) return;
  shown = text;
  byId("fleet").replaceChildren(...rounded.map(tile));
  byId("fleet-part").hidden = robots.length === 0;
}
