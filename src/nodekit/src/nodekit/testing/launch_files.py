"""Read launch files as roslaunch does, without starting anything."""

from typing import Any, Dict, List

from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

from nodekit.testing.launching import launch_file


def load_launch(package: str, name: str, *arguments: str) -> ROSLaunchConfig:
    """Return what roslaunch would start.

    :param package: the package whose launch file it is
    :param name: path in its folder launch
    :param arguments: as they are typed, e.g. ``ns:=robot``
    :raises roslaunch.RLException: if roslaunch would refuse it
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

    :param config: what :func:`load_launch` has returned
    :param node: global name of the node
    """
    prefix = node + "/"
    return {
        key[len(prefix) :]: parameter.value
        for key, parameter in config.params.items()
        if key.startswith(prefix) and key != prefix + "managed"
    }
