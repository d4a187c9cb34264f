"""Tests of the rules for names in ROS."""

import pytest
import rosgraph.names

from nodekit.node.name_rules import (
    IllegalName,
    check_base_name,
    check_namespace,
    checked,
    is_legal_name,
)
from nodekit.node.names import Names


@pytest.mark.parametrize("name", ["/", "/a", "/a/b_1/C", "/a/", "/5", "/_a", "/a" * 5000])
def test_name_rules(name):
    assert is_legal_name(name) and rosgraph.names.is_legal_name(name)


@pytest.mark.parametrize(
    "name", ["", "a", "/a b", "/a:b", "//", "/a//b", "/a-b", "/a\n", "/~a", "/ä", "/a" * 5000 + " "]
)
def test_illegal_names_are_reported_with_the_rule(name):
    assert not is_legal_name(name)
    with pytest.raises(IllegalName) as error:
        checked(name, "topic")
    assert str(error.value) == (
        f"topic '{name}': must be letters (a-z, A-Z), digits and underscores, separated by "
        "single slashes"
    )


@pytest.mark.parametrize("name", ["talker", "t", "Talker_2"])
def test_legal_base_names(name):
    check_base_name(name)


@pytest.mark.parametrize("name", ["", "a b", "a/b", "/a", "~a", "5", "_a", "aö"])
def test_illegal_base_names(name):
    with pytest.raises(IllegalName, match=f"^node name '{name}': must be a letter"):
        check_base_name(name)


def test_namespaces():
    for namespace in ("", "/", "a", "/a/b", "a/", "5"):
        check_namespace({}, ["__ns:=" + namespace])
        check_namespace({"ROS_NAMESPACE": namespace}, [])
    for namespace in ("a b", "ä ö", "a//b", "~a", "~"):
        with pytest.raises(IllegalName, match=f"namespace.*{namespace}.*must be letters"):
            check_namespace({}, ["__ns:=" + namespace])
        with pytest.raises(IllegalName, match=f"namespace.*{namespace}.*must be letters"):
            check_namespace({"ROS_NAMESPACE": namespace}, [])


def test_invalid_node_names_are_rejected():
    node = Names.hosted("/lab", "motor")
    assert node.resolve("speed") == "/lab/speed"
    assert node.resolve("~gain") == "/lab/motor/gain"
    for name in ("a b", "~a b", "/a b"):
        with pytest.raises(IllegalName, match="a b': must be"):
            node.resolve(name)
    for namespace, base in (("/a b", "motor"), ("/lab", "a:b")):
        with pytest.raises(IllegalName, match="node name '/"):
            Names.hosted(namespace, base)


def test_member_of_a_hosted_node_is_in_the_namespace_of_that_node() -> None:
    hosting = Names.hosted("/lab", "robots")
    found = [hosting.of_member(namespace, "motor").node for namespace in ("", "arm", "/other")]
    assert found == ["/lab/motor", "/lab/arm/motor", "/other/motor"]


def test_member_of_a_process_is_in_the_namespace_of_the_process() -> None:
    assert Names("/lab/robots", False).of_member("arm", "motor").node == "/arm/motor"
