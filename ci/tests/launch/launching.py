"""Loader of launch files by roslaunch, without starting nodes."""

import os
import pathlib
import random
import shlex
import subprocess
from typing import Any, Dict, List
from xml.etree import ElementTree

from roslaunch.config import ROSLaunchConfig
from roslaunch.core import Node, local_machine, setup_env
from roslaunch.node_args import create_local_process_args
from roslaunch.xmlloader import XmlLoader

#: Folder of the packages.
SOURCES = pathlib.Path(__file__).resolve().parents[3] / "src"
#: All launch files that users start.
FILES = sorted(str(path.relative_to(SOURCES)) for path in SOURCES.glob("*/launch/**/*.launch"))
#: Arguments without which a file cannot be loaded.
REQUIRED = {"basic_comms/launch/features/arg.launch": ["text:=x"]}


def load(name: str, *arguments: str) -> ROSLaunchConfig:
    """Return roslaunch's configuration of a file.

    :param name: file, relative to src
    :param arguments: the words typed after its name
    """
    config = ROSLaunchConfig()
    loader = XmlLoader()
    loader.ignore_unset_args = False
    random.seed(1)  # for reproducible names of $(anon)
    argv = [*REQUIRED.get(name, []), *arguments]
    loader.load(str(SOURCES / name), config, argv=argv, verbose=False)
    assert config.config_errors == []
    return config


def defaults(name: str) -> Dict[str, str]:
    """Return the optional arguments of a file, with their defaults."""
    tags = ElementTree.parse(str(SOURCES / name)).getroot().findall("arg")
    return {tag.attrib["name"]: tag.attrib["default"] for tag in tags if "default" in tag.attrib}


def settings(config: ROSLaunchConfig) -> Dict[str, Any]:
    """Return the parameters by name."""
    return {name: parameter.value for name, parameter in config.params.items()}


def whole(config: ROSLaunchConfig) -> Any:
    """Return a launch's complete configuration, for comparison."""
    nodes = [node.xmlattrs() + [node.remap_args, node.env_args] for node in config.nodes]
    return nodes, settings(config)


def command_line(node: Node) -> List[str]:
    """Return the words that a node's program receives, through any shell."""
    words = create_local_process_args(node, local_machine())
    program = len(shlex.split(node.launch_prefix or ""))
    words[program : program + 1] = ["printf", "%s\\0"]
    variables = setup_env(node, local_machine(), "http://localhost:11311", dict(os.environ))
    printed = subprocess.run(words, env=variables, stdout=subprocess.PIPE, check=True).stdout
    return printed.decode().split("\0")[:-1]
