/** WebSocket to the server, which reconnects automatically. */

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 5000;
// A server says something at once, and then each second: one that does not is not a scope. On a slow link a large
// message may take longer, so the page waits longer each time that it was cut off.
const SILENT_MS = 10000;
const LONGEST_SILENT_MS = 60000;

/** Sends and receives objects; connects again after a loss, each time after a longer wait. */
export class Connection {
  /**
   * @param {string} url of the WebSocket
   * @param {function(Object): void} onMessage takes each message of the server
   * @param {function("connecting"|"connected"|"lost", number, string): void} onChange takes the
   *   new state, and for "lost" the wait until the next attempt [ms], and what the server said, if
   *   it did
   */
  constructor(url, onMessage, onChange) {
    this.url = url;
    this.onMessage = onMessage;
    this.onChange = onChange;
    this.wait = FIRST_WAIT_MS;
    this.patience = SILENT_MS;
    this.socket = null;
    this.timer = null;
    this.expectsMore = false;
  }

  /** Connect, now. */
  connect() {
    clearTimeout(this.timer);
    this.onChange("connecting", 0, "");
    const former = this.socket;
    const socket = new WebSocket(this.url);
    this.socket = socket;
    former?.close();
    this.expectsMore = false;
    const expect = () => {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.giveUp(), this.patience);
    };
    expect();
    let isWelcome = false; // a server that has no place for this page closes without a message
    socket.addEventListener("message", (event) => {
      if (socket !== this.socket) return;
      if (!isWelcome) {
        isWelcome = true;
        clearTimeout(this.timer);
        this.wait = FIRST_WAIT_MS;
        this.onChange("connected", 0, "");
      }
      this.onMessage(JSON.parse(event.data));
      if (this.expectsMore) expect();
    });
    socket.addEventListener("close", (event) => {
      if (socket === this.socket) this.retryLater(event.reason);
    });
  }

  /** Expect a message each second from now on: the server has started to send. */
  expectMore() {
    this.expectsMore = true;
  }

  /** Take a connection over which nothing comes for lost: the browser may notice that much later. */
  giveUp() {
    const former = this.socket;
    this.socket = null;
    former.close();
    if (this.expectsMore) this.patience = Math.min(2 * this.patience, LONGEST_SILENT_MS);
    this.retryLater("The scope does not answer");
  }

  retryLater(reason) {
    clearTimeout(this.timer);
    const wait = this.wait * (1 + Math.random() / 4); // not all pages of a class at once
    this.wait = Math.min(this.wait * 2, LONGEST_WAIT_MS);
    this.timer = setTimeout(() => this.connect(), wait);
    this.onChange("lost", wait, reason);
  }

  /**
   * Send a message, if connected; the code that restores the state sends lost messages again.
   * @param {Object} message
   */
  send(message) {
    if (this.socket && this.socket.readyState === WebSocket.OPEN) {
      this.socket.send(JSON.stringify(message));
    }
  }
}
