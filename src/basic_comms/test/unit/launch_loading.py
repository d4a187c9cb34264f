"""Read launch files as roslaunch does, without starting anything."""

import os
import shlex
import subprocess
from typing import Dict, List, Tuple

import rospkg
from roslaunch.config import ROSLaunchConfig
from roslaunch.core import Node
from roslaunch.xmlloader import XmlLoader

from nodekit.testing.launch_files import load_launch

#: The folder of the launch files.
LAUNCH = os.path.join(rospkg.RosPack().get_path("basic_comms"), "launch")


def load(command: str, *more: str) -> ROSLaunchConfig:
    """Return the nodes that roslaunch would start.

    :param command: file and arguments, as in ``cw1.launch ns:=robot``
    :param more: further arguments, not split at blanks
    """
    name, *arguments = shlex.split(command)
    config = load_launch("basic_comms", name, *arguments, *more)
    config.assign_machines()
    return config


def words_from_prefix(node: Node) -> List[str]:
    """Return the arguments that the shell in a node's launch-prefix adds to the command."""
    command = shlex.split(node.launch_prefix) + ["printf", "%s\n"]
    printed = subprocess.run(command, env=dict(node.env_args), stdout=subprocess.PIPE, check=True)
    return printed.stdout.decode().splitlines()


def listed_arguments(name: str) -> Dict[str, Tuple[str, str]]:
    """Return doc and default of each argument that ``roslaunch --ros-args`` lists.

    :param name: file, relative to the folder of the launch files
    """
    loader = XmlLoader(resolve_anon=False, args_only=True)
    loader.load(os.path.join(LAUNCH, name), ROSLaunchConfig(), argv=[], verbose=False)
    listed: Dict[str, Tuple[str, str]] = loader.root_context.resolve_dict.get("arg_doc", {})
    return listed
