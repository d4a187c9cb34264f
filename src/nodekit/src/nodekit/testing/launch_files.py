"""Launch files, loaded as roslaunch does without starting nodes."""

from typing import Any, Dict, List

from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

from nodekit.testing.launching import launch_file


def load_launch(package: str, name: str, *arguments: str) -> ROSLaunchConfig:
    """Return the configuration that roslaunch would start.

    :param package: package of the launch file
    :param name: path in its folder launch
    :param arguments: arguments as on the command line, e.g. ``ns:=robot``
    :raises roslaunch.RLException: if roslaunch would reject it
    """
    config, loader = ROSLaunchConfig(), XmlLoader()
    loader.ignore_unset_args = False
    path = launch_file(package, name)
    loader.load(path, config, argv=list(arguments), verbose=False)
    assert config.config_errors == [], config.config_errors
    return config


def node_names(config: ROSLaunchConfig) -> List[str]:
    """Return the names of the nodes, in order."""
    return sorted(node.namespace + node.name for node in config.nodes)


def private_parameters(config: ROSLaunchConfig, node: str) -> Dict[str, Any]:
    """Return the private parameters of a node by name, without ``managed``.

    :param config: result of :func:`load_launch`
    :param node: global name of the node
    """
    prefix = node + "/"
    return {
        key[len(prefix) :]: parameter.value
        for key, parameter in config.params.items()
        if key.startswith(prefix) and key != prefix + "managed"
    }
