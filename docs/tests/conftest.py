"""Type several pages at a time, while the tests wait for them one after another."""

import signal
from concurrent.futures import Future, ProcessPoolExecutor
from typing import Any, Dict, Iterator, List, Optional

import pytest
from changed_pages import changed_files, dependencies, pages_to_type
from pages import WORKSPACE, measures_time, texts_of_pages
from warm_python import WarmPython, warm_python

#: They wait for nodes most of the time.
PAGES_AT_A_TIME = 3


def pytest_addoption(parser: Any) -> None:
    parser.addoption(
        "--pages-changed-since",
        metavar="COMMIT",
        help="type only the pages that have changed since, or that name a package that has",
    )


def pytest_configure(config: Any) -> None:
    config.addinivalue_line(
        "markers", "real_time: measures time, so that nothing may run beside it"
    )
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)


def page_of(item: Any) -> Optional[str]:
    """Return the page that a test types, None for another test."""
    callspec = getattr(item, "callspec", None)
    return callspec.params.get("page") if callspec and hasattr(item.module, "type_page") else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: Any, items: List[Any]) -> None:
    for item in items:
        page = page_of(item)
        if page and measures_time(texts_of_pages()[page]):
            item.add_marker(pytest.mark.real_time)
    commit = config.getoption("--pages-changed-since")
    if commit is None:
        return
    pages = pages_to_type(
        texts_of_pages(), changed_files(WORKSPACE, commit), dependencies(WORKSPACE)
    )
    left_out = [item for item in items if page_of(item) not in {None, *pages}]
    config.hook.pytest_deselected(items=left_out)
    items[:] = [item for item in items if item not in left_out]


@pytest.fixture(scope="session")
def python() -> Iterator[WarmPython]:
    """Run the commands that are Python programs."""
    with warm_python() as client:
        yield client


@pytest.fixture(scope="session")
def _results(request: Any, python: WarmPython) -> Iterator[Dict[str, "Future[None]"]]:
    """Start to type the pages of all selected tests, those with most to do first."""
    selected = {item.nodeid: item for item in request.session.items if page_of(item)}
    effort = {name: item.module.effort(page_of(item)) for name, item in selected.items()}
    with ProcessPoolExecutor(PAGES_AT_A_TIME) as pool:
        futures = {
            name: pool.submit(selected[name].module.type_page, page_of(selected[name]), python)
            for name in sorted(selected, key=lambda name: -effort[name])
        }
        yield futures
        for future in futures.values():
            future.cancel()


@pytest.fixture
def typed(request: Any, _results: Dict[str, "Future[None]"]) -> "Future[None]":
    """Return what comes of typing the page of a test."""
    return _results[request.node.nodeid]
