"""The command line."""

from pathlib import Path
from typing import List, Optional

import pytest

from topic_scope.protocol.options import OverlayOption, is_loopback, parse


def test_the_defaults_are_of_this_machine() -> None:
    options = parse([])
    assert (options.address, options.port, options.fields) == ("127.0.0.1", 8080, ())
    assert options.is_local and options.url == "http://localhost:8080"


def test_fields_are_expanded_in_any_position() -> None:
    options = parse(["/a/x:y", "--port", "8091", "b /c", "__name:=scope", "_port:=8092"])
    assert options.fields == ("/a/x", "/a/y", "/b", "/c")
    assert options.port == 8092


def test_relative_names_are_in_the_namespace() -> None:
    assert parse(["a/x", "/b/x", "__ns:=lab"]).fields == ("/lab/a/x", "/b/x")


def test_quoted_name_is_global_and_zero_addresses_are_this_machine() -> None:
    assert parse(['"/a b"/x', "y", "__ns:=lab"]).fields == ('"/a b"/x', "/lab/y")
    assert parse(["--address", "0.0.0.0"]).url == "http://localhost:8080"
    options = parse(["_over:=a.bag", "_offset:=-1.5"])
    assert [(one.name, one.offset) for one in options.over] == [("a", -1.5)]


def test_a_formula_is_one_argument_and_its_fields_are_global() -> None:
    options = parse(["=/a/x - 2*/b", "c /d", "--below", "=sqrt(/a)", "__ns:=lab"])
    assert options.fields == ("=/a/x - 2 * /b", "/lab/c", "/d", "=sqrt(/a)")
    with pytest.raises(SystemExit):
        parse(["=/a +"])


def test_plots_below_others() -> None:
    options = parse(["/a", "/b", "--below", "/c/x:y", "/a", "--below", "/d", "--port", "8091"])
    assert options.fields == ("/a", "/b", "/c/x", "/c/y", "/d") and options.port == 8091
    plots = {"/c/x": {"plot": 2}, "/c/y": {"plot": 2}, "/d": {"plot": 3}}
    assert options.setup == {"traces": plots}
    assert parse(["/a"]).setup is None


def test_plots_are_put_into_a_set_up(tmp_path: Path) -> None:
    path = tmp_path / "setup.json"
    path.write_text('{"window": 2, "traces": {"/a": {"gain": 3}, "/b": {"gain": 4}}}')
    options = parse(["--setup", str(path), "/a", "--below", "/b"])
    assert options.setup == {
        "window": 2,
        "traces": {"/a": {"gain": 3}, "/b": {"gain": 4, "plot": 2}},
    }


def test_next_port_is_used_only_on_request() -> None:
    assert list(parse([]).ports) == [8080]
    assert list(parse(["--next-port", "--port", "9000"]).ports) == list(range(9000, 9100))
    assert list(parse(["--next-port", "--port", "65534"]).ports) == [65534, 65535]


@pytest.mark.parametrize("address", ["0.0.0.0", "10.0.0.7", "::", "lab-7", ""])
def test_other_addresses_are_not_local(address: str) -> None:
    options = parse(["_address:=" + address])
    assert options.address == address and not options.is_local


@pytest.mark.parametrize("address", ["127.0.0.1", "127.0.0.2", "::1", "localhost"])
def test_loopback_addresses_are_local(address: str) -> None:
    assert is_loopback(address)


def test_an_address_with_colons_is_put_in_brackets() -> None:
    assert parse(["--address", "fe80::1"]).url == "http://[fe80::1]:8080"


@pytest.mark.parametrize(
    "arguments",
    [
        ["--port", "0"],
        ["--below"],
        ["--below", "../x"],
        ["--below", "/a"] * 8,
        ["--port", "65536"],
        ["--port", "web"],
        ["--port", "80.5"],
        [" --open-browser"],
        ["--history", "-1"],
        ["--window", "nan"],
        ["../x"],
        ["--opener"],
        ["_port:=x"],
    ],
)
def test_invalid_arguments_are_rejected(
    arguments: list, capsys: "pytest.CaptureFixture[str]"
) -> None:
    with pytest.raises(SystemExit) as caught:
        parse(arguments)
    assert caught.value.code == 2
    assert "usage" in capsys.readouterr().err


def test_a_bag_is_named_like_any_option() -> None:
    assert parse(["--bag", "my.bag", "/a/x"]).bag == "my.bag"
    assert parse(["_bag:=my.bag"]).bag == "my.bag"
    assert parse([]).bag is None


def test_overlaid_bags_are_named_by_file_or_option(tmp_path: Path) -> None:
    over = parse(["--over", "a/run.bag", "--over", "b/run.bag:old", "--offset", "-1.5"]).over
    assert over == (OverlayOption("a/run.bag", "run", -1.5), OverlayOption("b/run.bag", "old"))
    (dated,) = parse(["_over:=2026-11-24-16-01-40.bag"]).over
    assert dated.name == "bag_2026_11_24_16_01_40"
    path = tmp_path / "a:b.bag"
    path.touch()
    assert parse(["--over", str(path)]).over == (OverlayOption(str(path), "a_b"),)
    assert parse([]).over == ()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--over", "a/run.bag", "--over", "b/run.bag"], "two bags are named run"),
        (["--over", "run.bag:2nd"], "'2nd' is not a valid bag name"),
        (["--over", "run.bag:"], "'' is not a valid bag name"),
        (["--offset", "1"], "1 --offset for 0 --over; give one for each"),
        (["--over", "run.bag", "--offset", "soon"], "'soon' is not a time in s"),
        (["--over", "run.bag", "--offset", "nan"], "'nan' is not a time in s"),
    ],
)
def test_invalid_overlay_is_rejected(
    capsys: "pytest.CaptureFixture[str]", words: List[str], said: str
) -> None:
    with pytest.raises(SystemExit) as ended:
        parse(words)
    assert ended.value.code == 2 and said in capsys.readouterr().err


def test_a_setup_is_read_from_its_file(tmp_path: Path) -> None:
    path = tmp_path / "setup.json"
    path.write_text('{"fields": ["/a/x"], "window": 2.5}')
    assert parse(["--setup", str(path)]).setup == {"fields": ["/a/x"], "window": 2.5}
    assert parse([f"_setup:={path}"]).setup == {"fields": ["/a/x"], "window": 2.5}
    assert parse([]).setup is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "No such file"),
        ("{", "not a set-up"),
        ("[1]", "not a set-up"),
        ('{"fields": 3}', "list"),
        ('{"traces": []}', "not a set-up"),
        ('{"traces": {"/a": 2}}', "not a set-up"),
    ],
)
def test_invalid_setup_is_rejected(
    tmp_path: Path, capsys: "pytest.CaptureFixture[str]", text: Optional[str], said: str
) -> None:
    path = tmp_path / "setup.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(SystemExit) as ended:
        parse(["--setup", str(path)])
    assert ended.value.code == 2
    error = capsys.readouterr().err
    assert str(path) in error and said in error


def test_too_many_fields_are_rejected(capsys: "pytest.CaptureFixture[str]") -> None:
    names = [f"/a/data[{index}]" for index in range(33)]
    assert len(parse(names[:32]).fields) == 32
    with pytest.raises(SystemExit):
        parse(names)
    assert "a page shows at most 32 traces, not 33" in capsys.readouterr().err
