/** The order of names as people count: group2 before group10. */

const { compare } = new Intl.Collator("en", { numeric: true });

/**
 * Compare two names of ROS, part by part, so that what is in a namespace stands together.
 * @param {string} a
 * @param {string} b
 * @returns {number} below 0 where a comes first
 */
export function byName(a, b) {
  const [one, other] = [a.split("/"), b.split("/")];
  const place = one.findIndex((part, index) => part !== other[index]);
  if (place < 0) return one.length - other.length;
  if (place >= other.length) return 1;
  return compare(one[place], other[place]) || (one[place] < other[place] ? -1 : 1);
}
