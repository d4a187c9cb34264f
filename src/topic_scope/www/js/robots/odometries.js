/** Grouping of odometries by robot. */

const spaceOf = (topic) => topic.slice(0, topic.lastIndexOf("/") + 1);

/**
 * Group the odometries of a robot: odometries of one namespace with the same child frame, such as
 * wheel odometry and ground truth.
 * @param {Object[]} odometries as the server sends them
 * @returns {Object[]} for each robot the odometry named odom, or else the first, with the "others"
 */
export function robotsOf(odometries) {
  const robots = new Map();
  for (const one of odometries) {
    const key = one.body ? `${spaceOf(one.topic)} ${one.body}` : one.topic;
    robots.set(key, [...(robots.get(key) ?? []), one]);
  }
  return [...robots.values()].map((seen) => {
    const main = seen.find(({ topic }) => topic.endsWith("/odom")) ?? seen[0];
    return { ...main, others: seen.filter((other) => other !== main) };
  });
}
