/** WebSocket to the server, which reconnects automatically. */

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 5000;
// The server sends a message immediately, and then each second; otherwise it is not a scope. On a slow link a large
// message may take longer, so the page waits longer after each lost connection.
const SILENT_MS = 10000;
const LONGEST_SILENT_MS = 60000;

/** Connection that sends and receives objects; reconnects after a loss, with increasing delays. */
export class Connection {
  /**
   * @param {string} url of the WebSocket
   * @param {function(Object): void} onMessage takes each message of the server
   * @param {function("connecting"|"connected"|"lost", number, string): void} onChange takes the
   *   new state, and for "lost" the wait until the next attempt [ms], and the server's reason,
   *   if any
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

  /** Connect now. */
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
    let isWelcome = false; // a server with too many pages closes the connection without a message
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

  /** Treat a silent connection as lost: the browser may notice the loss much later. */
  giveUp() {
    const former = this.socket;
    this.socket = null;
    former.close();
    if (this.expectsMore) this.patience = Math.min(2 * this.patience, LONGEST_SILENT_MS);
    this.retryLater("The scope does not answer");
  }

  retryLater(reason) {
    clearTimeout(this.timer);
    const wait = this.wait * (1 + Math.random() / 4); // so that many pages do not reconnect together
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
