"""Access rules."""

from typing import Optional

import pytest

from topic_scope.web.access import is_known_name, is_same_origin, names_of

NAMES = names_of("Lab-7.uni.example", "lab-7.uni.example", "scope.example")


@pytest.mark.parametrize(
    "host",
    [
        "localhost",
        "localhost:8080",
        "LOCALHOST:80",
        "127.0.0.1:8080",
        "[::1]:8080",
        "10.0.0.7",
        "lab-7.uni.example:1",
        "lab-7.local:8080",
        "LAB-7.LOCAL",
        "scope.example",
    ],
)
def test_names_of_this_machine_are_known(host: str) -> None:
    assert is_known_name(host, NAMES)


@pytest.mark.parametrize(
    "host",
    [
        "",
        "example.com",
        "localhost.example.com:8080",
        "127.0.0.1.example.com",
        "a@b",
        "[",
        "x:y:z",
        "lab-8.local",
    ],
)
def test_other_names_are_rejected(host: str) -> None:
    assert not is_known_name(host, NAMES)


@pytest.mark.parametrize("origin", [None, "http://localhost:8080", "https://LOCALHOST:8080"])
def test_page_of_this_server_may_connect(origin: Optional[str]) -> None:
    assert is_same_origin(origin, "localhost:8080")


@pytest.mark.parametrize(
    "origin",
    [
        "",
        "null",
        "http://localhost",
        "http://localhost:8081",
        "http://127.0.0.1:8080",
        "http://example.com",
        "file://localhost:8080",
        "http://localhost:8080.example.com",
        "http://[",
    ],
)
def test_page_of_another_site_may_not_connect(origin: str) -> None:
    assert not is_same_origin(origin, "localhost:8080")
