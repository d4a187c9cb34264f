"""Tests of ci/container: commands of its page, and README's copies of commands.

Course 002-pkg-13.
"""

import pathlib
import subprocess
import sys
from typing import List

import pytest
import yaml

from .conftest import CI

WORKSPACE = CI.parent
README = (WORKSPACE / "README.md").read_text("utf-8")


def commands(page: str, section: str) -> List[str]:
    """Return the commands of a section of a page."""
    script = f"workspace='{WORKSPACE}'; source '{CI}/systems/pages.bash'; page_commands \"$@\""
    printed = subprocess.check_output(["bash", "-c", script, "bash", page, section], timeout=30)
    return printed.decode().splitlines()


def test_commands_match_those_of_the_proof() -> None:
    lines = commands("docs/container.md", "Build and run")
    assert [line.split()[:2] for line in lines] == [
        ["podman", "build"],
        ["podman", "run"],
        ["podman", "exec"],
    ]
    up, other = commands("docs/container.md", "With the oscilloscope")
    assert up == "podman-compose --file packaging/compose.yaml up"
    assert other.startswith("podman run --rm --network basic_comms ")


@pytest.mark.parametrize(
    "page, section",
    [
        ("docs/packaging.md", "Install"),
        ("docs/container.md", "Build and run"),
        ("docs/tutorials/other_packages.md", "All of it in your own workspace"),
    ],
)
def test_commands_in_the_readme_match_their_page(page: str, section: str) -> None:
    (row,) = [line for line in README.splitlines() if line.startswith("|") and f"]({page}" in line]
    first, second = commands(page, section)[:2]
    assert f"`{first}`" in row and f"`{second}`" in row


def test_only_the_page_is_published_and_the_nodes_network_is_internal() -> None:
    composed = yaml.safe_load((WORKSPACE / "packaging" / "compose.yaml").read_text("utf-8"))
    services = composed["services"]
    published = [(name, port) for name in services for port in services[name].get("ports", [])]
    assert published == [("scope", "127.0.0.1:${SCOPE_PORT:-8080}:8080")]
    assert services["course"]["networks"] == ["ros"]
    # With a master of its own, nodes would listen on localhost only.
    assert services["course"]["environment"]["ROS_HOSTNAME"] == services["course"]["hostname"]
    assert composed["networks"]["ros"] == {"name": "basic_comms", "internal": True}
    for service in services.values():
        assert service["read_only"] is True and service["cap_drop"] == ["ALL"]


@pytest.mark.parametrize(
    "options, said",
    [
        (["--only", "bake"], "unknown part 'bake'"),
        (["--base"], "--base takes a name"),
        (["--other"], "Usage: ci/container"),
    ],
)
def test_unknown_options_are_refused(options: List[str], said: str) -> None:
    result = subprocess.run(
        [str(CI / "container"), *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=60,
    )
    assert result.returncode == 125
    assert said in result.stdout.decode()


@pytest.mark.parametrize("name", ["course", "scope"])
def test_somebody_elses_container_is_left_alone(tmp_path: pathlib.Path, name: str) -> None:
    log, podman = tmp_path / "log", tmp_path / "podman"
    podman.write_text(f'#!/bin/sh\necho "$*" >>"{log}"\n[ "$*" = "container inspect {name}" ]\n')
    podman.chmod(0o755)
    done = subprocess.run(
        [sys.executable, str(CI), "packages.container_proof", str(podman), "podman-compose"],
        input="podman run it\npodman exec it\npodman-compose up\npodman run other\n",
        stderr=subprocess.PIPE,
        universal_newlines=True,
        timeout=60,
    )
    assert done.returncode == 1
    assert f"there is a container '{name}', which would be ended" in done.stderr
    assert all(line.startswith("container inspect ") for line in log.read_text().splitlines())
