"""The pages of the documentation."""

import os
import re
from pathlib import Path
from typing import Dict

#: The root of the workspace, where a reader of the pages is.
WORKSPACE = Path(__file__).resolve().parents[2]


def texts_of_pages() -> Dict[str, str]:
    """Return the text of each page by its path in the workspace, README.md first."""
    paths = [WORKSPACE / "README.md", *sorted((WORKSPACE / "docs").rglob("*.md"))]
    return {str(path.relative_to(WORKSPACE)): path.read_text() for path in paths}


def measures_time(text: str) -> bool:
    """Return whether a page types commands that measure a controller or a plant in real time."""
    return re.search(r"rosrun pid_control (judge|identify|tune)\b", text) is not None


def environment_of_reader(**variables: str) -> Dict[str, str]:
    """Return the environment variables of a reader.

    :param variables: set on top of those of this process, apart from those that change how Python
        writes, which readers have not set
    """
    unusual = ("PYTHONDONTWRITEBYTECODE", "PYTHONUNBUFFERED")
    return {
        name: value for name, value in {**os.environ, **variables}.items() if name not in unusual
    }
