/** Panel with the image of a topic at the time of cursor A, the end of a paused view, or now. */

import { clockText, zoneText } from "../base/clock.js";
import { byId, options, setPressed, setText } from "../base/dom.js";
import { figure } from "../base/numbers.js";
import { imageTopic, imageTopics } from "../state/image_topics.js";

const EVERY_MS = 250; // from the end of a request to the next one
const TIMEOUT_MS = 10000;
const NONE = "No topic has the type sensor_msgs/Image or sensor_msgs/CompressedImage.";

/**
 * Return the time whose image is shown.
 * @param {Object} values of the state
 * @param {{reference: number}} shown the shown sweep
 * @returns {{time: ?number, name: string}} time since the epoch [s], null for the newest image;
 *   and the name of that time
 */
export function wantedTime({ cursors, end }, { reference }) {
  if (cursors) return { time: Math.max(0, reference + cursors.a), name: "cursor A" };
  if (end !== null) return { time: Math.max(0, end), name: "the end of the view" };
  return { time: null, name: "" };
}

/**
 * Describe an image.
 * @param {{time: number, text: string, correction: ?string}} description
 * @param {{time: ?number, name: string}} wanted
 * @returns {string}
 */
export function imageText({ time, text, correction }, wanted) {
  const apart = wanted.time === null ? "" : `${figure(Math.max(0, wanted.time - time), 3)} s before ${wanted.name}`;
  return [`${clockText(time, 0.001)} ${zoneText(time)}`, apart, text, correction].filter(Boolean).join(", ");
}

/** Panel of the images; requests the next one after the last has arrived, a few times a second. */
export class Images {
  /**
   * @param {import("../state/store.js").State} state
   * @param {import("../state/sweep.js").Sweep} sweep
   */
  constructor(state, sweep) {
    this.state = state;
    this.sweep = sweep;
    this.known = ""; // the server's name of the shown image
    this.topic = ""; // its topic
    this.text = ""; // its description, without its time
    this.problem = ""; // reason why the browser does not show it
    this.picture = byId("image");
    this.select = byId("image-topic");
    this.select.addEventListener("change", () => state.change("images", { topic: this.select.value }));
    byId("show-images").addEventListener("click", () =>
      state.change("images", { shown: !state.values.images.shown }));
    this.picture.addEventListener("error", () => {
      if (!this.known) return;
      this.problem = `the browser cannot decode the image: ${this.text}`;
      this.picture.hidden = true;
      setText(byId("image-text"), this.problem);
    });
    state.on(["images", "types", "view"], () => this.show());
    this.ask();
  }

  show() {
    const { images } = this.state.values;
    setPressed(byId("show-images"), images.shown);
    byId("images").hidden = !images.shown;
    const topics = imageTopics(this.state.values);
    if (images.topic && !topics.includes(images.topic)) topics.unshift(images.topic);
    if (topics.join() !== [...this.select.options].map(({ value }) => value).join()) {
      this.select.replaceChildren(...options(topics));
    }
    this.select.hidden = !topics.length;
    const topic = imageTopic(this.state.values);
    this.select.value = images.topic || topics[0] || "";
    if (topic !== this.topic) {
      this.topic = topic;
      this.clear(topics.length ? "" : NONE);
    } else if (!topics.length) this.clear(NONE);
  }

  /** Remove the image, and show a text in its place. */
  clear(text) {
    this.known = "";
    URL.revokeObjectURL(this.picture.src);
    this.picture.hidden = true;
    this.picture.removeAttribute("src");
    setText(byId("image-text"), text);
  }

  async ask() {
    const { topic } = this;
    if (topic && !document.hidden) {
      try {
        await this.load(topic, wantedTime(this.state.values, this.sweep.shown));
      } catch (error) { /* the page shows that the connection is lost */ }
    }
    setTimeout(() => this.ask(), EVERY_MS);
  }

  /** Load the image at a time, unless it is already shown. */
  async load(topic, wanted) {
    const query = new URLSearchParams({ topic, known: this.known });
    if (wanted.time !== null) query.append("time", wanted.time);
    const reply = await fetch(`/image?${query}`, { signal: AbortSignal.timeout(TIMEOUT_MS) });
    const file = reply.status === 200 ? await reply.blob() : null;
    if (topic !== this.topic) return; // the user has chosen another topic meanwhile
    if (!reply.ok) {
      this.clear(`no image: the scope answered with status ${reply.status}`);
      return;
    }
    const description = JSON.parse(reply.headers.get("Image-Description"));
    if (description.problem) {
      this.clear(description.problem);
      return;
    }
    if (file) {
      URL.revokeObjectURL(this.picture.src);
      this.known = description.known;
      this.text = description.text;
      this.problem = "";
      this.picture.src = URL.createObjectURL(file);
      this.picture.hidden = false;
      this.picture.alt = `image of ${topic}`;
    }
    const text = imageText({ ...description, text: this.text }, wanted);
    setText(byId("image-text"), this.problem || text);
  }
}
