/** List of the fields to choose from: by topic, the most useful fields first. */

import { byName, inTopic, searchFor } from "../base/names.js";

/** Types of topics that are about the nodes themselves. */
const HIDDEN = /^(dynamic_reconfigure\/|rosgraph_msgs\/(Log|TopicStatistics)$|bond\/|lifecycle_msgs\/)/;
/** Fields of a message besides its subject. */
const FORMAL = /(^|[/\]])(header\/(seq|stamp)|layout\/.*|.*covariance\[.*)$/;
const ELEMENT = /\[[\w-]+\]/g;

/**
 * Return whether a topic is hidden until the user asks for all.
 * @param {string} datatype of the topic
 * @returns {boolean}
 */
export const isHidden = (datatype) => HIDDEN.test(datatype);

/**
 * Return whether a field is the subject of its message.
 * @param {{field: string, topic: string}} choice
 * @returns {boolean}
 */
export const isUseful = (choice) => !FORMAL.test(inTopic(choice));

/** Replace the index of a field by an unlisted index in the search: /scan/ranges[0] with [200]. */
function withElements(choice, words) {
  const wanted = words.flatMap((word) => word.match(ELEMENT) || []);
  if (!wanted.length) return choice;
  let place = 0;
  const field = choice.field.replace(ELEMENT, () => wanted[Math.min(place++, wanted.length - 1)]);
  return { ...choice, field };
}

/**
 * Find the fields that match some words.
 * @param {{field: string, datatype: string, topic: string}[]} available
 * @param {Object<string, string>} types of the topics
 * @param {string} text words, each of which must be in a name or a type
 * @param {boolean} all with hidden topics
 * @returns {{groups: {topic: string, datatype: string, fields: Object[]}[], count: number, hidden: number}}
 *   count: number of listed fields, hidden: number of further fields on hidden topics
 */
export function found(available, types, text, all) {
  const { words, fits } = searchFor(text);
  const groups = new Map();
  const seen = new Set();
  let hidden = 0;
  for (const one of available) {
    const choice = withElements(one, words);
    const type = types[one.topic] || "";
    if (seen.has(choice.field) || !fits(`${choice.field} ${choice.datatype} ${type}`)) continue;
    seen.add(choice.field);
    if (!all && isHidden(type)) hidden += 1;
    else if (groups.has(one.topic)) groups.get(one.topic).push(choice);
    else groups.set(one.topic, [choice]);
  }
  const rank = (choice) => Number(!isUseful(choice));
  const listed = [...groups].map(([topic, fields]) => ({
    topic,
    datatype: types[topic] || "",
    fields: fields.sort((a, b) => rank(a) - rank(b)), // otherwise in the order of the message
  })).sort((a, b) => isHidden(a.datatype) - isHidden(b.datatype) || byName(a.topic, b.topic));
  return { groups: listed, count: seen.size - hidden, hidden };
}
