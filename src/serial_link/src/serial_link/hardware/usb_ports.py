"""USB ports of boards: with a serial line behind them, or native."""

import os
from typing import Dict, List

#: Where the system has the ports' devices.
SYSTEM = "/sys/class/tty"
#: Converters to a serial line that have no driver of their own, but that of native USB ports: by
#: vendor, the products, or none for all. Those of Arduino are in its boards.txt (Uno and Mega).
_CONVERTERS: Dict[str, List[str]] = {
    "2341": "0001 0010 003f 0042 0043 0044 006a 0210 0242 0243".split(),
    "2a03": "0010 003f 0042 0043 0044 0057".split(),
    "0483": "374b 374e 374f 3752 3753 3754".split(),  # ST-LINK
    "0d28": [],  # DAPLink
    "1a86": [],  # WCH
}


def has_line(name: str, system: str = SYSTEM) -> bool:
    """Tell whether a port has a serial line, whose baud rate limits it.

    A native USB port, as of a Leonardo, Teensy or Pico, takes what it gets at USB's pace, whatever
    baud rate is set. A port of which the system says nothing counts as a line.

    :param name: path of the port; links are followed
    :param system: folder of the ports' devices
    """
    device = os.path.join(system, os.path.basename(os.path.realpath(name)), "device")
    driver = os.path.basename(os.path.realpath(os.path.join(device, "driver")))
    if driver != "cdc_acm":
        return True
    usb = os.path.dirname(os.path.realpath(device))
    products = _CONVERTERS.get(_read(usb, "idVendor"))
    return products is not None and (not products or _read(usb, "idProduct") in products)


def _read(folder: str, name: str) -> str:
    try:
        with open(os.path.join(folder, name), encoding="ascii") as file:
            return file.read().strip().lower()
    except OSError:
        return ""
