"""Board that returns each ping at once, or sends numbers through a line that damages bytes.

Usage: serial_board.py LINK|TCP_PORT [NOISE]. NOISE is the share of damaged bytes of the numbers,
which are sent at 500 Hz, each with a check value, the first 500 undamaged.
"""

import signal
import sys
import threading
import time

from serial_link.board.simulation import Faults, SimulatedBoard
from serial_link.board.transports import PtyTransport, TcpTransport, Transport
from serial_link.device.rosserial_device import Device, Endpoint
from serial_link.negotiation.payloads import PUBLISHER, SUBSCRIBER, ParameterValues
from std_msgs.msg import UInt32

NUMBERS_HZ, UNDAMAGED = 500.0, 500
#: Factor of a number for its check value: an odd one, far from a power of 2.
CHECK = 40503


class Sketch:
    """Publishes ``pong``, or ``number``.

    :param noise: share of damaged bytes; 0 without numbers
    """

    topics = tuple(
        Endpoint(kind, name, UInt32._type, UInt32._md5sum)
        for kind, name in ((PUBLISHER, "pong"), (PUBLISHER, "number"), (SUBSCRIBER, "ping"))
    )

    def __init__(self, noise: float) -> None:
        self.noise = noise
        self.count = 0
        self._next_at = 0.0

    def on_message(self, device: Device, now: float, name: str, payload: bytes) -> None:
        """Return a ping."""
        device.publish("pong", payload)

    def on_parameter(self, device: Device, now: float, values: ParameterValues) -> None:
        """Ignore it: the sketch requests none."""

    def loop(self, device: Device, now: float) -> None:
        """Send the next number."""
        if self.noise and device.is_configured and now >= self._next_at:
            self._next_at = max(self._next_at + 1.0 / NUMBERS_HZ, now)
            self.count += 1
            number = self.count & 0xFFFF
            value = number << 16 | number * CHECK & 0xFFFF
            device.publish("number", value.to_bytes(4, "little"))

    def next_due(self, now: float) -> float:
        """Return when the next number is due [s]."""
        return self._next_at if self.noise else now + 1.0


def answer(transport: Transport, sketch: Sketch) -> None:
    """Run a board without a simulated line, whose delays would count as the host's latency."""
    device = Device(sketch)
    while True:
        if not transport.is_plugged:
            transport.plug()
        transport.wait(0.1)
        now = time.monotonic()
        device.receive(now, transport.read())
        device.loop(now)
        transport.write(device.output())


def main(place: str, noise: str = "0") -> None:
    """Run until Ctrl-C."""
    sketch = Sketch(float(noise))
    transport = TcpTransport("localhost", int(place)) if place.isdigit() else PtyTransport(place)
    if not sketch.noise:
        threading.Thread(target=answer, args=(transport, sketch), daemon=True).start()
        signal.sigwait([signal.SIGINT])
        transport.unplug()
        return
    board = SimulatedBoard(transport, 0, lambda _now: Device(sketch))
    board.start()
    while not signal.sigtimedwait([signal.SIGINT], 0.1):
        if sketch.count > UNDAMAGED:
            board.faults = Faults(noise=sketch.noise)
    board.close()


if __name__ == "__main__":
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    main(*sys.argv[1:])
