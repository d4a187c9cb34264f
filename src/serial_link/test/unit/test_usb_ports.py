"""USB ports, as the system describes them."""

import pathlib

import pytest

from serial_link.hardware.usb_ports import has_line


def describe(folder: pathlib.Path, driver: str, vendor: str = "", product: str = "") -> None:
    """Write the sysfs entries of a port ttyX0."""
    usb = folder / "usb1" / "1-1"
    interface = usb / "1-1:1.0"
    (interface).mkdir(parents=True)
    (folder / "drivers" / driver).mkdir(parents=True)
    (interface / "driver").symlink_to(folder / "drivers" / driver)
    (usb / "idVendor").write_text(vendor + "\n")
    (usb / "idProduct").write_text(product + "\n")
    (folder / "ttyX0").mkdir()
    (folder / "ttyX0" / "device").symlink_to(interface)


@pytest.mark.parametrize(
    "driver, vendor, product, expected",
    [
        ("cdc_acm", "2341", "8036", False),  # Leonardo
        ("cdc_acm", "16c0", "0483", False),  # Teensy
        ("cdc_acm", "2e8a", "000a", False),  # Pico
        ("cdc_acm", "2341", "0043", True),  # Uno, through an ATmega16U2
        ("cdc_acm", "2341", "0042", True),  # Mega
        ("cdc_acm", "2a03", "0043", True),  # Uno of the other Arduino company
        ("cdc_acm", "2a03", "8036", False),  # and its Leonardo
        ("cdc_acm", "0483", "374b", True),  # ST-LINK
        ("cdc_acm", "0483", "5740", False),  # STM32's own USB port
        ("cdc_acm", "0d28", "0204", True),  # DAPLink
        ("cdc_acm", "1a86", "55d4", True),
        ("ftdi_sio", "0403", "6001", True),
    ],
)
def test_native_ports_are_those_of_cdc_acm_without_a_converter(
    tmp_path: pathlib.Path, driver: str, vendor: str, product: str, expected: bool
) -> None:
    describe(tmp_path, driver, vendor, product)
    link = tmp_path / "by-id"
    link.symlink_to("/dev/ttyX0")
    assert has_line("/dev/ttyX0", str(tmp_path)) is expected
    assert has_line(str(link), str(tmp_path)) is expected


def test_native_port_that_is_unplugged_meanwhile_has_no_line(tmp_path: pathlib.Path) -> None:
    describe(tmp_path, "cdc_acm")
    vendor = tmp_path / "usb1" / "1-1" / "idVendor"
    vendor.unlink()
    vendor.mkdir()  # an error other than that of a missing file, like ENODEV
    assert not has_line("/dev/ttyX0", str(tmp_path))


def test_port_that_the_system_does_not_describe_has_a_line(tmp_path: pathlib.Path) -> None:
    assert has_line("/dev/ttyX0", str(tmp_path))
    assert has_line("/dev/pts/0")
