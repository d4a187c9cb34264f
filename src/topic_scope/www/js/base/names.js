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
 * Make a test of whether a text has all the words of a search.
 * @param {string} search
 * @returns {{words: string[], fits: function(string): boolean}}
 */
export function searchFor(search) {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  return { words, fits: (text) => words.every((word) => text.toLowerCase().includes(word)) };
}
