/** The graph of nodes and topics, redrawn when it changes. */

import { byId, draw, setText } from "../base/dom.js";
import { byName, namespaceOf } from "../base/names.js";
import { figure } from "../base/numbers.js";
import { BACK, layOut } from "./layout.js";
import { GraphZoom } from "./zoom.js";

const CHARACTER = 7.4; // width, pixels

const shortName = (name) => name.slice(namespaceOf(name).length + 1) || name;

/** Items of the layout: nodes and topics, and the edges between them. */
function itemsOf(graph, all) {
  const heard = new Set(graph.edges.filter(({ to }) => to).map(({ topic }) => topic));
  const nodes = [...graph.nodes].sort(byName).map((name) => ({
    id: `n${name}`, kind: "node", name, group: namespaceOf(name), text: shortName(name),
    width: 44 + CHARACTER * shortName(name).length, height: 42,
  }));
  const ownerOf = (topic) => nodes.find(({ name }) => topic.startsWith(`${name}/`));
  const topics = graph.topics.filter(({ name }) => all || heard.has(name) || !ownerOf(name))
    .sort((a, b) => byName(a.name, b.name)).map(({ name, datatype }) => {
      const owner = ownerOf(name);
      const group = owner?.group ?? namespaceOf(name); // private topics are grouped with their node
      const text = owner ? `~${name.slice(owner.name.length + 1)}` : name.slice(group.length + 1);
      const width = 20 + Math.max(CHARACTER * text.length, 6 * datatype.length);
      return { id: `t${name}`, kind: "topic", name, group, datatype, text, width, height: 38 };
    });
  const known = new Set([...nodes, ...topics].map(({ id }) => id));
  const links = new Map(); // each edge once, although several connections of a topic share it
  for (const { from, to, topic, rate } of graph.edges) {
    for (const [a, b] of [[`n${from}`, `t${topic}`], [`t${topic}`, `n${to}`]]) {
      if (known.has(a) && known.has(b)) links.set(`${a} ${b}`, { from: a, to: b, rate });
    }
  }
  return { items: [...nodes, ...topics], links: [...links.values()] };
}

/** Lower edge of all items between two items. */
function floorBetween(a, b, others) {
  const between = others.filter(({ x }) => x >= Math.min(a.x, b.x) && x <= Math.max(a.x, b.x));
  return Math.max(...between.map(({ y, height }) => y + height / 2));
}

/** Path of a forward edge, straight within columns and curved between them. */
function pathForward(stops) {
  let text = "";
  stops.forEach((stop, place) => {
    const { x, y, width, column } = stop;
    if (!place) {
      text = `M${x + width / 2} ${y} H${x + column / 2}`;
      return;
    }
    const before = stops[place - 1];
    const start = before.x + before.column / 2;
    const end = x - column / 2;
    const middle = (start + end) / 2;
    const last = place === stops.length - 1;
    text += ` C${middle} ${before.y} ${middle} ${y} ${end} ${y} H${last ? x - width / 2 : x + column / 2}`;
  });
  return text;
}

/** Path of a backward edge, below all items in between. */
function pathBack(a, b, others) {
  const y1 = a.y + a.height / 2;
  const y2 = b.y + b.height / 2;
  // A cubic Bézier curve reaches three quarters of the distance to its control points.
  const low = floorBetween(a, b, others) + BACK;
  return `M${a.x} ${y1} C${a.x} ${low} ${b.x} ${low} ${b.x} ${y2}`;
}

function nodeShape({ name, text }, { x, y, width, height }, { edges }) {
  const list = (topics) => [...new Set(topics)].sort(byName).join(", ") || "nothing";
  const published = list(edges.filter(({ from }) => from === name).map(({ topic }) => topic));
  const heard = list(edges.filter(({ to }) => to === name).map(({ topic }) => topic));
  const label = `node ${name}, publishes ${published}, subscribes to ${heard}`;
  return draw("g", { class: "node", "data-name": name, role: "img", "aria-label": label },
    draw("title", {}, name), draw("ellipse", { cx: x, cy: y, rx: width / 2, ry: height / 2 }), draw("text", { x, y }, text));
}

function topicShape({ name, text, datatype }, { x, y, width, height }, { plot }) {
  const isKey = ({ key }) => key === "Enter" || key === " ";
  return draw("g", {
    class: "topic", "data-name": name, role: "button", tabindex: 0, "aria-label": `plot ${name}, ${datatype}`,
    click: () => plot(name),
    keydown: (event) => {
      if (!isKey(event)) return;
      event.preventDefault();
      event.stopPropagation();
      plot(name);
    },
  }, draw("title", {}, `${name}, ${datatype}`),
    draw("rect", { x: x - width / 2, y: y - height / 2, width, height, rx: 4 }),
    draw("text", { x, y: y - 7 }, text), draw("text", { class: "type", x, y: y + 9 }, datatype));
}

function groupShape({ name, x, y, width, height }) {
  return draw("g", { class: "group" }, draw("rect", { x, y, width, height, rx: 8 }),
    draw("text", { x: x + 10, y: y + 13 }, name));
}

/** Shows the graph. */
export class Graph {
  /**
   * @param {import("../state/store.js").State} state
   * @param {function(string): void} plot plots a topic
   */
  constructor(state, plot) {
    this.plot = plot;
    this.sheet = byId("graph");
    this.zoom = new GraphZoom(this.sheet, state);
    this.all = byId("graph-all");
    this.latest = { nodes: [], topics: [], edges: [] };
    this.drawn = "";
    this.rates = new Map();
    this.all.addEventListener("change", () => this.show(this.latest));
  }

  /**
   * @param {{nodes: string[], topics: Object[], edges: Object[]}} graph as the server sends it
   */
  show(graph) {
    this.latest = graph;
    const { items, links } = itemsOf(graph, this.all.checked);
    const shape = JSON.stringify([items, links.map(({ from, to }) => [from, to])]);
    if (shape !== this.drawn) this.draw(items, links);
    this.drawn = shape;
    byId("graph-empty").hidden = items.length > 0;
    for (const { from, to, rate } of links) {
      const text = this.rates.get(`${from} ${to}`);
      setText(text, rate === null ? "" : `${rate ? figure(rate, rate < 10 ? 2 : 3) : 0} Hz`);
    }
  }

  draw(items, links) {
    const { places, routes, groups, width, height } = layOut(items, links);
    this.rates.clear();
    const arrow = draw("marker", {
      id: "arrow", viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 7, markerHeight: 7, orient: "auto",
    }, draw("path", { d: "M0 0.5 L8 4 L0 7.5 z" }));
    const groupOf = new Map(items.map(({ id, group }) => [id, group]));
    const edges = links.map(({ from, to }) => {
      const [a, b] = [places.get(from), places.get(to)];
      const others = items.filter(({ group }) => group === groupOf.get(from) || group === groupOf.get(to))
        .map(({ id }) => places.get(id));
      const forward = b.x > a.x;
      const stops = [a, ...(routes.get(`${from} ${to}`) || []), b];
      const next = stops[1]; // the rate is shown in the first gap
      const middle = { x: (a.x + a.column / 2 + next.x - next.column / 2) / 2, y: (a.y + next.y) / 2 - 8 };
      const text = draw("text", forward ? middle : { x: a.x, y: a.y + a.height / 2 + 12 });
      this.rates.set(`${from} ${to}`, text);
      const path = forward ? pathForward(stops) : pathBack(a, b, others);
      const ends = { "data-from": from.slice(1), "data-to": to.slice(1) };
      return draw("g", { class: "edge", "aria-hidden": "true", ...ends },
        draw("path", { d: path, "marker-end": "url(#arrow)" }), text);
    });
    const focused = document.activeElement?.dataset?.name;
    const others = { edges: this.latest.edges, plot: this.plot };
    this.sheet.replaceChildren(
      draw("defs", {}, arrow), ...groups.map(groupShape), ...edges,
      ...items.map((item) => (item.kind === "node" ? nodeShape : topicShape)(item, places.get(item.id), others)),
    );
    this.zoom.resize(width, height);
    if (focused) this.sheet.querySelector(`.topic[data-name="${CSS.escape(focused)}"]`)?.focus();
  }
}
