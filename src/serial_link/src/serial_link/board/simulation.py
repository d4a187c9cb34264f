"""Simulation of a board: a device, a serial line, a transport, and their faults."""

import contextlib
import random
import threading
import time
from typing import Callable, NamedTuple, Optional

from serial_link.board.transports import Transport
from serial_link.device.rosserial_device import Device
from serial_link.device.serial_line import SerialLine, add_noise

#: With more bytes waiting to be sent, an Arduino's library blocks; it reads at most _RX_BUFFER.
_TX_BUFFER, _RX_BUFFER = 64, 64
#: Longest wait [s]; a change of faults takes effect after it.
_LONGEST_WAIT_S = 0.02
#: Interval of connection attempts [s].
_PLUG_EVERY_S = 0.2


class Faults(NamedTuple):
    """Faults of a board and its cable.

    :param noise: share of damaged bytes, in both directions
    :param stalls: whether the sketch hangs
    :param is_plugged: whether the cable is plugged in
    """

    noise: float = 0.0
    stalls: bool = False
    is_plugged: bool = True


#: Creates the device of a board that was switched on at the given time [s].
Factory = Callable[[float], Device]


class SimulatedBoard:
    """Simulated board that runs in a thread.

    :param end: its transport
    :param baud: bits per second of its line; 0 for a line without delay
    :param make_device: creates the device at each start
    :param boot_s: time from a reset until the sketch runs [s]
    :param seed: of the noise

    :ivar faults: current faults; replace it as a whole
    :ivar boot_s: as given
    """

    def __init__(
        self, end: Transport, baud: int, make_device: Factory, boot_s: float = 0.2, seed: int = 1
    ) -> None:
        self.faults = Faults()
        self._transport = end
        self._in, self._out = SerialLine(baud), SerialLine(baud)
        self._make_device, self.boot_s = make_device, boot_s
        self._chance = random.Random(seed)
        self._device: Optional[Device] = None
        self._starts_at = self._plugged_at = 0.0
        self._is_reset, self._is_over = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="board", daemon=True)
        #: Held while the board is switched on or off.
        self._switch = threading.Lock()

    @property
    def device(self) -> Optional[Device]:
        """The device; None while it boots."""
        return self._device

    def start(self) -> None:
        """Switch the board on, unless it was closed meanwhile: it would stay plugged in.

        :raises OSError: if the cable cannot be plugged in
        """
        with self._switch:
            if self._is_over.is_set():
                return
            self._transport.plug()
            self._starts_at = time.monotonic()
            self._thread.start()

    def reset(self) -> None:
        """Press the reset button; a message may be cut off."""
        self._is_reset.set()

    def close(self) -> None:
        """Switch the board off, and unplug it."""
        with self._switch:
            self._is_over.set()
        if self._thread.ident is not None:
            self._thread.join(2.0)
        self._transport.unplug()

    def _run(self) -> None:
        while not self._is_over.is_set():
            now = time.monotonic()
            faults = self.faults
            self._move_cable(now, faults.is_plugged)
            if self._is_reset.is_set():
                self._is_reset.clear()
                self._restart(now)
            if self._device is None and now >= self._starts_at:
                self._device = self._make_device(now)
            if self._in.waiting < _RX_BUFFER:
                self._in.put(now, add_noise(self._transport.read(), faults.noise, self._chance))
            if self._device is None:
                self._in.arrived(now)  # it does not read yet
            elif self._is_free():
                self._device.receive(now, self._in.arrived(now))
                self._device.loop(now)
                self._out.put(now, self._device.output())
            self._transport.write(add_noise(self._out.arrived(now), faults.noise, self._chance))
            self._wait(now)

    def _wait(self, now: float) -> None:
        due = min(self._out.next_due(), self._in.next_due(), now + _LONGEST_WAIT_S)
        if self._device is not None and self._is_free():
            due = min(due, self._device.next_due(now))
        timeout = max(0.0, due - time.monotonic())
        if self._in.waiting < _RX_BUFFER:
            self._transport.wait(timeout)
        else:
            time.sleep(timeout)

    def _is_free(self) -> bool:
        """Return whether the sketch runs: it blocks while its transmit buffer is full."""
        return not self.faults.stalls and self._out.waiting <= _TX_BUFFER

    def _move_cable(self, now: float, is_wanted: bool) -> None:
        if is_wanted and not self._transport.is_plugged and now >= self._plugged_at + _PLUG_EVERY_S:
            self._plugged_at = now
            self._in.clear()
            self._out.clear()
            with contextlib.suppress(OSError):  # retried
                self._transport.plug()
        elif self._transport.is_plugged and not is_wanted:
            self._transport.unplug()

    def _restart(self, now: float) -> None:
        """Deliver the bytes that have left the board, and boot again."""
        self._transport.write(self._out.arrived(now))
        self._out.clear()
        self._in.clear()
        self._device = None
        self._starts_at = now + self.boot_s
