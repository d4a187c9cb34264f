/** The WebSocket to the server, which comes back by itself. */

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 5000;
const WELCOME_MS = 10000; // a server says something at once: one that does not by then is none

/** Sends and receives objects; connects again after a loss, each time after a longer wait. */
export class Connection {
  /**
   * @param {string} url of the WebSocket
   * @param {function(Object): void} onMessage takes each message of the server
   * @param {function("connecting"|"connected"|"lost", number, string): void} onChange takes the
   *   new state, and for "lost" the wait until the next attempt, ms, and what the server said, if
   *   it did
   */
  constructor(url, onMessage, onChange) {
    this.url = url;
    this.onMessage = onMessage;
    this.onChange = onChange;
    this.wait = FIRST_WAIT_MS;
    this.socket = null;
    this.timer = null;
  }

  /** Connect, now. */
  connect() {
    clearTimeout(this.timer);
    this.onChange("connecting", 0, "");
    const former = this.socket;
    const socket = new WebSocket(this.url);
    this.socket = socket;
    former?.close();
    this.timer = setTimeout(() => socket.close(), WELCOME_MS);
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
    });
    socket.addEventListener("close", (event) => {
      if (socket === this.socket) this.retryLater(event.reason);
    });
  }

  retryLater(reason) {
    clearTimeout(this.timer);
    const wait = this.wait * (1 + Math.random() / 4); // not all pages of a class at once
    this.wait = Math.min(this.wait * 2, LONGEST_WAIT_MS);
    this.timer = setTimeout(() => this.connect(), wait);
    this.onChange("lost", wait, reason);
  }

  /**
   * Send a message, if connected; what is lost is sent again by whoever restores the state.
   * @param {Object} message
   */
  send(message) {
    if (this.socket && this.socket.readyState === WebSocket.OPEN) {
      this.socket.send(JSON.stringify(message));
    }
  }
}
