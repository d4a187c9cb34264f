"""What a command line names: which file, and which parameters it is to have."""

import pathlib

from pid_control.trial.target import find_in


def test_hidden_folders_are_not_looked_into(tmp_path: pathlib.Path) -> None:
    for folder in (".git/kept", "scripts", "scripts/.old"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "controller.py").write_text("")
    found = [str(tmp_path / "scripts" / "controller.py")]
    assert find_in(str(tmp_path), "controller.py") == found
