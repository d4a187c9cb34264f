/** Topics with images, and the one that the page shows. */

const TYPES = ["sensor_msgs/Image", "sensor_msgs/CompressedImage"]; // as on the server

/** Names of the topics with images, in alphabetical order. */
export const imageTopics = ({ types }) =>
  Object.keys(types).filter((topic) => TYPES.includes(types[topic])).sort();

/**
 * Return the topic whose images are shown.
 * @param {Object} values of the state
 * @returns {string} empty without such a topic, or while the panel is hidden
 */
export function imageTopic(values) {
  const { images, view } = values;
  if (!images.shown || view !== "scope") return "";
  return images.topic || imageTopics(values)[0] || "";
}
