"""Check in sysfs whether a port is native USB, which ignores the baud rate, or a serial line."""

import os
from typing import Dict, List

#: Folder of the serial devices in sysfs.
SYSTEM = "/sys/class/tty"
#: Serial converters that use the driver of native USB ports: product ids by vendor id; empty means
#: all products. The Arduino ids are from its boards.txt (Uno and Mega).
_CONVERTERS: Dict[str, List[str]] = {
    "2341": "0001 0010 003f 0042 0043 0044 006a 0210 0242 0243".split(),
    "2a03": "0010 003f 0042 0043 0044 0057".split(),
    "0483": "374b 374e 374f 3752 3753 3754".split(),  # ST-LINK
    "0d28": [],  # DAPLink
    "1a86": [],  # WCH
}


def has_line(name: str, system: str = SYSTEM) -> bool:
    """Return whether a port has a serial line, whose baud rate limits it.

    A native USB port (Leonardo, Teensy, Pico) ignores the baud rate and runs at USB speed. A port
    that sysfs does not describe counts as a serial line.

    :param name: path of the port; links are followed
    :param system: folder of the serial devices
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
