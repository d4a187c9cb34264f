/** Names on the graph: namespaces, sorting and search. */

const { compare } = new Intl.Collator("en", { numeric: true });

/** Namespace of a name: "" for "/talker", "/a/b" for "/a/b/talker". */
export const namespaceOf = (name) => name.slice(0, Math.max(0, name.lastIndexOf("/")));

/**
 * Compare two names part by part, so that namespaces are grouped, in natural order:
 * group2 before group10.
 * @param {string} a
 * @param {string} b
 * @returns {number} negative if a comes first
 */
export function byName(a, b) {
  const [one, other] = [a.split("/"), b.split("/")];
  const place = one.findIndex((part, index) => part !== other[index]);
  if (place < 0) return one.length - other.length;
  if (place >= other.length) return 1;
  return compare(one[place], other[place]) || (one[place] < other[place] ? -1 : 1);
}

/**
 * Split a name where a line may break: before a slash, bracket, point or @, and after "_".
 * @param {string} name
 * @returns {string[]}
 */
export const partsOf = (name) => name.match(/[/[.@]?[^/[.@_]*_*/g).filter(Boolean);

/**
 * Mask the contents of quotes and brackets, which may have any characters; the length stays.
 * @param {string} name of a trace, such as "/ORB-SLAM"/pose/x or /diagnostics/status[name=a@b]/level
 * @returns {string}
 */
export const bare = (name) => name.replace(/"\/[^"]*"|\[[^\]]*\]/g, (part) =>
  (part.startsWith("[") ? "" : "/").padEnd(part.length, "_"));

/**
 * Return the name of a field in the messages of its topic.
 * @param {{field: string, topic: string}} choice a topic is in quotes in the name if necessary
 * @returns {string} the whole name if the topic is unknown
 */
export const inTopic = ({ field, topic }) =>
  (topic && field.slice(topic.length + (field.startsWith('"') ? 3 : 1))) || field;

/**
 * Make a test of whether a text has all the words of a search.
 * @param {string} search
 * @returns {{words: string[], fits: function(string): boolean}}
 */
export function searchFor(search) {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  return { words, fits: (text) => words.every((word) => text.toLowerCase().includes(word)) };
}
