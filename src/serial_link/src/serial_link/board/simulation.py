"""Simulation of a board: a device, a serial line, a transport, and their faults."""

import contextlib
import random
import threading
import time
from typing import Callable, NamedTuple, Optional

from serial_link.board.transports import Transport
from serial_link.device.rosserial_device import Device
from serial_link.device.serial_line import SerialLine, add_noise

#: An Arduino's library waits with more in a message's way out than this, and reads no more at once.
_TX_BUFFER, _RX_BUFFER = 64, 64
#: Longest wait for anything [s]: faults are changed meanwhile.
_LONGEST_WAIT_S = 0.02
#: How often a connection is tried [s].
_PLUG_EVERY_S = 0.2


class Faults(NamedTuple):
    """Faults of a board and its cable.

    :param noise: share of the bytes that are damaged, either way
    :param stalls: whether the sketch stands still
    :param is_plugged: whether the cable is in
    """

    noise: float = 0.0
    stalls: bool = False
    is_plugged: bool = True


#: Makes the device of a board that is switched on at a time [s].
Factory = Callable[[float], Device]


class SimulatedBoard:
    """A board in a thread of its own.

    :param end: where it is plugged in
    :param baud: bits a second of its line; 0 where that takes no time
    :param make_device: makes the device at each start
    :param boot_s: how long it takes from a reset until the sketch runs [s]
    :param seed: of the noise

    :ivar faults: what is wrong now; to be replaced as a whole
    :ivar boot_s: as given
    """

    def __init__(
        self, end: Transport, baud: int, make_device: Factory, boot_s: float = 0.2, seed: int = 1
    ) -> None:
        self.faults = Faults()
        self._end = end
        self._in, self._out = SerialLine(baud), SerialLine(baud)
        self._make_device, self.boot_s = make_device, boot_s
        self._chance = random.Random(seed)
        self._device: Optional[Device] = None
        self._starts_at = self._plugged_at = 0.0
        self._is_reset, self._is_over = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="board", daemon=True)
        #: Held while it is switched on or off.
        self._switch = threading.Lock()

    @property
    def device(self) -> Optional[Device]:
        """The device; None while it boots."""
        return self._device

    def start(self) -> None:
        """Switch it on, unless it was closed meanwhile: it would stay plugged in.

        :raises OSError: if it cannot be plugged in
        """
        with self._switch:
            if self._is_over.is_set():
                return
            self._end.plug()
            self._starts_at = time.monotonic()
            self._thread.start()

    def reset(self) -> None:
        """Press the button that resets it: even in the middle of a message."""
        self._is_reset.set()

    def close(self) -> None:
        """Switch it off, and unplug it."""
        with self._switch:
            self._is_over.set()
        if self._thread.ident is not None:
            self._thread.join(2.0)
        self._end.unplug()

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
                self._in.put(now, add_noise(self._end.read(), faults.noise, self._chance))
            if self._device is None:
                self._in.arrived(now)  # it does not read yet
            elif self._is_free():
                self._device.receive(now, self._in.arrived(now))
                self._device.loop(now)
                self._out.put(now, self._device.output())
            self._end.write(add_noise(self._out.arrived(now), faults.noise, self._chance))
            self._wait(now)

    def _wait(self, now: float) -> None:
        due = min(self._out.next_due(), self._in.next_due(), now + _LONGEST_WAIT_S)
        if self._device is not None and self._is_free():
            due = min(due, self._device.next_due(now))
        timeout = max(0.0, due - time.monotonic())
        if self._in.waiting < _RX_BUFFER:
            self._end.wait(timeout)
        else:
            time.sleep(timeout)

    def _is_free(self) -> bool:
        """Tell whether the sketch goes on: it waits while its way out is full."""
        return not self.faults.stalls and self._out.waiting <= _TX_BUFFER

    def _move_cable(self, now: float, is_wanted: bool) -> None:
        if is_wanted and not self._end.is_plugged and now >= self._plugged_at + _PLUG_EVERY_S:
            self._plugged_at = now
            self._in.clear()
            self._out.clear()
            with contextlib.suppress(OSError):  # it is tried again
                self._end.plug()
        elif self._end.is_plugged and not is_wanted:
            self._end.unplug()

    def _restart(self, now: float) -> None:
        """Deliver what has left the board so far, and boot again."""
        self._end.write(self._out.arrived(now))
        self._out.clear()
        self._in.clear()
        self._device = None
        self._starts_at = now + self.boot_s
