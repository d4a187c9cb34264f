/** Robots in their world, seen from above. */

import { byId, options, setText, themeColour } from "../base/dom.js";
import { isForPage } from "../base/keys.js";
import { paletteColour } from "../state/colours.js";
import { Camera } from "./camera.js";
import { Drawing, placesOf } from "./drawing.js";
import { Goals } from "./goals.js";
import { nameOf, RobotList } from "./list.js";
import { robotsOf } from "./odometries.js";
import { startPointer } from "./pointer.js";
import { Trails } from "./trails.js";
import { Teleop } from "./teleop.js";

const CLOSER = 1.25;
const STEP = 60; // of the arrow keys, pixels
const LINE = 15; // height of a name, pixels

/** Robot view, with its controls. */
export class SceneView {
  /**
   * @param {import("../state/store.js").State} state
   * @param {function(Object): void} send takes messages for the server
   */
  constructor(state, send) {
    this.state = state;
    this.canvas = byId("robot-canvas");
    this.camera = new Camera();
    this.styles = new Map();
    const style = (name) => this.style(name);
    this.drawing = new Drawing(this.canvas.getContext("2d"), this.camera, style);
    this.robots = []; // see odometries.js
    this.scans = [];
    this.scenery = { markers: [], paths: [], goals: [] };
    this.trails = new Trails();
    this.wheel = new Teleop(send);
    this.goals = new Goals(send, () => this.chosen, () => this.refresh());
    this.list = new RobotList((topic) => this.colour(topic), (topic) =>
      this.follow(topic === this.followed ? "" : topic));
    this.followed = ""; // topic of a robot
    this.touched = false; // whether the user has moved the picture
    this.due = false;
    this.start();
  }

  start() {
    startPointer(this.canvas, {
      camera: this.camera,
      picksGoal: () => this.goals.picking,
      moved: () => this.moved(),
      aim: (goal) => this.goals.aim(goal),
      pick: (goal) => this.goals.pick(goal),
      over: (x, y) => setText(byId("robot-pointer"), `${x.toFixed(2)}, ${y.toFixed(2)} m`),
    });
    byId("show-robots").addEventListener("click", () => this.state.set({ view: "robots" }));
    byId("robot-fit").addEventListener("click", () => this.fit());
    byId("robot-closer").addEventListener("click", () => this.zoom(CLOSER));
    byId("robot-farther").addEventListener("click", () => this.zoom(1 / CLOSER));
    document.addEventListener("keydown", (event) => this.onKey(event), true);
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.state.on(["view"], ({ view }) => {
      if (view !== "robots") this.wheel.releaseWheel();
    });
    this.state.on(["theme"], () => {
      this.styles.clear();
      this.list.forget();
      this.refresh();
    });
    this.state.on(["readonly", "isBag"], ({ readonly, isBag }) => {
      byId("robot-drive").hidden = readonly || isBag;
      byId("robot-goal").hidden = readonly || isBag;
      setText(byId("robots-empty"), isBag ? "No robots: the bag has no nav_msgs/Odometry up to here." :
        "No robots: no node publishes nav_msgs/Odometry.");
    });
  }

  /** Colour of the theme; cached, because reading it is slow. */
  style(name) {
    if (!this.styles.has(name)) this.styles.set(name, themeColour(name));
    return this.styles.get(name);
  }

  /** Reset driving after a new connection. */
  onHello() {
    this.wheel.onSteering({ topic: "", datatype: "" });
  }

  // --- From the server ---

  showRobots({ robots, scans }) {
    const isFirst = !this.robots.length && robots.length > 0;
    this.robots = robotsOf(robots);
    this.scans = scans;
    this.trails.add(robots);
    byId("robots-empty").hidden = robots.length > 0;
    this.list.show(this.robots, this.followed);
    if (isFirst && !this.touched) this.fit();
    this.refresh();
  }

  showScenery(scenery) {
    this.scenery = scenery;
    this.goals.onGoals(scenery.goals);
    if (!this.touched) this.fit();
    this.refresh();
  }

  showTargets({ commands, goals }) {
    const fill = (id, topics) => {
      const select = byId(id);
      const { value } = select;
      select.replaceChildren(...options(topics));
      if (topics.includes(value)) select.value = value;
      select.disabled = !topics.length;
      byId(`${id}-none`).hidden = topics.length > 0;
    };
    fill("drive-topic", commands);
    fill("goal-topic", goals);
    byId("drive").disabled = !commands.length;
    byId("goal-send").disabled = !goals.length;
    byId("goal-pick").disabled = !goals.length;
  }

  colour(topic) {
    return paletteColour(this.state, this.robots.findIndex((robot) => robot.topic === topic));
  }

  /** The robot for goals: the followed robot, otherwise the first. */
  get chosen() {
    return this.robots.find(({ topic }) => topic === this.followed) ??
      this.robots.find(({ topic }) => topic.endsWith("/odom")) ?? this.robots[0];
  }

  follow(topic) {
    this.followed = topic;
    this.list.show(this.robots, this.followed);
    this.refresh();
  }

  // --- The picture ---

  moved() {
    this.touched = true;
    if (this.followed) this.follow("");
    this.refresh();
  }

  zoom(factor) {
    this.camera.zoom(factor);
    this.touched = true;
    this.refresh();
  }

  /** Fit everything into the view. */
  fit() {
    this.touched = false;
    const places = this.robots.map(({ x, y }) => [x, y]);
    for (const { at: [a, b, c, d, e, f], points } of this.scenery.markers) {
      places.push([e, f], ...placesOf({ points }).map(([x, y]) => [a * x + c * y + e, b * x + d * y + f]));
    }
    this.camera.fit(places);
    this.refresh();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(clientWidth * ratio);
    this.canvas.height = Math.round(clientHeight * ratio);
    Object.assign(this.camera, { width: clientWidth || 1, height: clientHeight || 1 });
    if (!this.touched) this.fit();
    this.refresh();
  }

  /** Redraw with the next frame. */
  refresh() {
    if (this.due || this.state.values.view !== "robots") return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      this.draw();
    });
  }

  draw() {
    const { drawing, camera, scenery } = this;
    const followed = this.robots.find(({ topic }) => topic === this.followed);
    if (followed) Object.assign(camera, { x: followed.x, y: followed.y });
    drawing.clear(window.devicePixelRatio || 1);
    scenery.markers.forEach((marker) => drawing.marker(marker));
    scenery.paths.forEach((path) => drawing.inside(path.at, () =>
      drawing.line(placesOf(path), this.style("good"), 2)));
    this.scans.forEach((scan) => drawing.scan(scan, this.style("bad")));
    for (const { topic, others } of this.robots) {
      const trail = (one, dash) => this.trails.of(one).forEach((line) =>
        drawing.line(line, this.colour(topic), 1.5, dash));
      others.forEach((other) => trail(other.topic, [1, 3]));
      trail(topic, [5, 3]);
    }
    this.goals.shown(scenery.goals).forEach(({ topic, isFaint, ...goal }) =>
      drawing.goal(goal, nameOf(topic), isFaint));
    for (const robot of this.robots) {
      for (const other of robot.others) drawing.robot(other, this.colour(robot.topic), true);
    }
    this.robots.forEach((robot) => drawing.robot(robot, this.colour(robot.topic), robot.silent));
    this.names();
  }

  /** Draw the names of the robots, one below another if they would overlap. */
  names() {
    const written = [];
    for (const { topic, x, y } of this.robots) {
      const [left, top] = this.camera.toPicture(x, y);
      const width = this.drawing.widthOf(nameOf(topic));
      const covers = (down) => written.some((one) =>
        left < one.left + one.width && one.left < left + width && Math.abs(top + down - one.top) < LINE);
      let down = 0;
      while (covers(down)) down += LINE;
      this.drawing.text(nameOf(topic), x, y, this.style("text"), down);
      written.push({ left, top: top + down, width });
    }
  }

  // --- Keys ---

  onKey(event) {
    if (this.state.values.view !== "robots" || !isForPage(event)) return;
    const acts = {
      "+": () => this.zoom(CLOSER), "=": () => this.zoom(CLOSER), "-": () => this.zoom(1 / CLOSER),
      0: () => this.fit(), f: () => this.followNext(), Escape: () => this.goals.setPicking(false),
      ArrowLeft: () => this.pan(STEP, 0), ArrowRight: () => this.pan(-STEP, 0),
      ArrowUp: () => this.pan(0, STEP), ArrowDown: () => this.pan(0, -STEP),
      " ": () => {},
    };
    if (event.key === " " && this.state.values.isBag) return; // plays it
    const isForWheel = this.wheel.onKey(event);
    if (!isForWheel && !acts[event.key]) return;
    event.preventDefault();
    event.stopPropagation();
    if (!isForWheel) acts[event.key]();
  }

  pan(across, down) {
    this.camera.pan(across, down);
    this.moved();
  }

  followNext() {
    const topics = ["", ...this.robots.map(({ topic }) => topic)];
    this.follow(topics[(topics.indexOf(this.followed) + 1) % topics.length]);
  }
}
