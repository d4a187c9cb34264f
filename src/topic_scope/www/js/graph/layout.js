/** Layout of the graph: layers from left to right, a band for each namespace. */

import { byName } from "../base/names.js";

const GAP_X = 74; // between layers, room for a rate
const GAP_Y = 18;
const PADDING = 16; // in the frame of a namespace
const TITLE = 16; // of a namespace
const MARGIN = 20;
const STOP = 6; // height of the space for a passing edge

/** Distance of a backward edge below the items that it connects [pixels]. */
export const BACK = 40;

/**
 * @typedef {Object} Item
 * @property {string} id
 * @property {string} group namespace, "" for none
 * @property {number} width
 * @property {number} height
 */

/**
 * @typedef {Object} Place
 * @property {number} x middle
 * @property {number} y middle
 * @property {number} width
 * @property {number} height
 * @property {number} column width of the widest of its layer
 */

/**
 * Return for each item the longest path from a source, without backward edges.
 * @param {Item[]} items
 * @param {{from: string, to: string}[]} edges
 * @returns {Map<string, number>}
 */
export function layersOf(items, edges) {
  const next = new Map(items.map(({ id }) => [id, []]));
  for (const { from, to } of edges) if (next.has(from) && next.has(to)) next.get(from).push(to);
  const order = []; // topological order, without backward edges
  const seen = new Map(); // id -> false while on the current path, true when done
  const visit = (id) => {
    seen.set(id, false);
    next.set(id, next.get(id).filter((other) => {
      if (!seen.has(other)) visit(other);
      return seen.get(other); // false: it is on the current path
    }));
    seen.set(id, true);
    order.unshift(id);
  };
  const isTarget = new Set(edges.map(({ to }) => to));
  const sourcesFirst = [...items].sort((a, b) => isTarget.has(a.id) - isTarget.has(b.id));
  for (const { id } of sourcesFirst) if (!seen.has(id)) visit(id);
  const layers = new Map(items.map(({ id }) => [id, 0]));
  for (const id of order) {
    for (const other of next.get(id)) {
      layers.set(other, Math.max(layers.get(other), layers.get(id) + 1));
    }
  }
  return layers;
}

/**
 * Split edges across several layers: a stop in each layer reserves space for the edge.
 * @returns {{stops: Item[], steps: {from: string, to: string}[], routes: Map<string, string[]>}}
 *   routes: the stops of each such edge, by "from to"
 */
function splitLongWays(items, edges, layers) {
  const groupOf = new Map(items.map(({ id, group }) => [id, group]));
  const stops = [];
  const steps = [];
  const routes = new Map();
  for (const { from, to } of edges) {
    if (!groupOf.has(from) || !groupOf.has(to)) continue;
    const route = [];
    for (let layer = layers.get(from) + 1; layer < layers.get(to); layer += 1) {
      const id = `${from} ${to} ${layer}`;
      stops.push({ id, group: groupOf.get(to), width: 0, height: STOP });
      layers.set(id, layer);
      route.push(id);
    }
    const way = [from, ...route, to];
    way.slice(1).forEach((id, place) => steps.push({ from: way[place], to: id }));
    if (route.length) routes.set(`${from} ${to}`, route);
  }
  return { stops, steps, routes };
}

/** Order the items of each layer by the positions of their neighbours, in several sweeps. */
function arrange(columns, edges) {
  const near = new Map();
  for (const { from, to } of edges) {
    near.set(from, [...(near.get(from) || []), to]);
    near.set(to, [...(near.get(to) || []), from]);
  }
  const place = new Map();
  const count = () => columns.forEach((column) => column.forEach((item, index) =>
    place.set(item.id, (index + 0.5) / column.length)));
  const middle = ({ id }) => {
    const places = (near.get(id) || []).map((other) => place.get(other)).filter((at) => at !== undefined);
    return places.length ? places.reduce((sum, at) => sum + at, 0) / places.length : place.get(id);
  };
  count();
  for (let turn = 0; turn < 6; turn += 1) {
    for (const column of turn % 2 ? [...columns].reverse() : columns) {
      const wanted = new Map(column.map((item) => [item.id, middle(item)]));
      column.sort((a, b) => wanted.get(a.id) - wanted.get(b.id));
      count();
    }
  }
}

const isWithin = (inner, outer) => inner === outer || inner.startsWith(`${outer}/`);

/**
 * Place all items.
 * @param {Item[]} items
 * @param {{from: string, to: string}[]} edges
 * @returns {{places: Map<string, Place>, routes: Map<string, Place[]>,
 *   groups: {name: string, x: number, y: number, width: number, height: number}[],
 *   width: number, height: number}} x and y are the middles of items, and corners of groups;
 *   routes: the stops of edges, by "from to"
 */
export function layOut(items, edges) {
  const layers = layersOf(items, edges);
  const { stops, steps, routes } = splitLongWays(items, edges, layers);
  const last = Math.max(0, ...layers.values());
  const widths = Array(last + 1).fill(0);
  for (const item of items) {
    const layer = layers.get(item.id);
    widths[layer] = Math.max(widths[layer], item.width);
  }
  const middles = [];
  let x = MARGIN + PADDING;
  for (const width of widths) {
    middles.push(x + width / 2);
    x += width + GAP_X;
  }
  const groupOf = new Map(items.map(({ id, group }) => [id, group]));
  const isBack = (from, to, name) =>
    groupOf.get(from) === name && layers.get(to) <= layers.get(from);
  const places = new Map();
  const groups = [];
  const names = [...new Set(items.map(({ group }) => group))].sort(byName);
  let y = MARGIN;
  const open = []; // enclosing frames of the band, outermost first
  const close = (name) => {
    while (open.length && !(name && isWithin(name, open[open.length - 1].name))) {
      y += PADDING;
      const frame = open.pop();
      groups.push(framed(frame, y, places, items));
      y += open.length ? 0 : GAP_Y;
    }
  };
  for (const name of names) {
    close(name);
    if (name) {
      open.push({ name, top: y });
      y += TITLE + PADDING;
    }
    const columns = widths.map((_, layer) =>
      [...items, ...stops].filter((item) => item.group === name && layers.get(item.id) === layer));
    arrange(columns, steps);
    y += placeBand(columns, middles, widths, y, places) + (name ? 0 : GAP_Y);
    if (edges.some(({ from, to }) => isBack(from, to, name))) y += BACK * 0.75;
  }
  close("");
  const right = Math.max(0, ...groups.map((group) => group.x + group.width),
    ...[...places.values()].map((at) => at.x + at.width / 2));
  const placed = new Map([...routes].map(([way, ids]) => [way, ids.map((id) => places.get(id))]));
  for (const { id } of stops) places.delete(id);
  return { places, routes: placed, groups: groups.reverse(), width: right + MARGIN, height: y + MARGIN };
}

/** Place the columns of a band, vertically centred. */
function placeBand(columns, middles, widths, top, places) {
  const heightOf = (column) => column.reduce((sum, item) => sum + item.height + GAP_Y, -GAP_Y);
  const height = Math.max(0, ...columns.map(heightOf));
  columns.forEach((column, layer) => {
    let y = top + (height - heightOf(column)) / 2;
    for (const { id, width, height: own } of column) {
      places.set(id, { x: middles[layer], y: y + own / 2, width, height: own, column: widths[layer] });
      y += own + GAP_Y;
    }
  });
  return height;
}

/** The frame around all items of a namespace. */
function framed({ name, top }, bottom, places, items) {
  const inside = items.filter(({ group }) => isWithin(group, name)).map(({ id }) => places.get(id));
  const depth = name.split("/").length - 1;
  const deepest = Math.max(...items.filter(({ group }) => isWithin(group, name))
    .map(({ group }) => group.split("/").length - 1));
  const space = PADDING * (0.5 + 0.5 * (deepest - depth + 1));
  const left = Math.min(...inside.map((at) => at.x - at.width / 2)) - space;
  const right = Math.max(...inside.map((at) => at.x + at.width / 2)) + space;
  const width = Math.max(right - left, 8 * name.length + 20);
  return { name, x: left, y: top, width, height: bottom - top };
}
