"""Headless Chromium of Debian, and access to the page in it."""

import atexit
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any, List, Tuple

from browsing.waiting import wait_until
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.remote.webelement import WebElement

WIDTH, HEIGHT = 1280, 720

#: Where Debian installs it.
_DRIVER = "/usr/bin/chromedriver"
#: Limits the interval of frames [ms]; the first after a pause is drawn immediately.
_SLOW_FRAMES = """
const native = window.requestAnimationFrame.bind(window);
let drawn = 0;
window.requestAnimationFrame = (draw) => {
  const wait = drawn + %d - performance.now();
  const next = () => native((now) => {
    drawn = now;
    draw(now);
  });
  return wait > 0 ? setTimeout(next, wait) : next();
};
"""
#: Checksum of the painted grid and traces.
_PICTURE = """
const painted = document.querySelector(arguments[0]);
const { width, height } = painted;
const copy = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
copy.drawImage(painted, 0, 0);
let sum = 0;
for (const pixel of new Uint32Array(copy.getImageData(0, 0, width, height).data.buffer)) {
  sum = (Math.imul(sum, 31) + pixel) | 0;
}
return sum;
"""
#: Ends chromedriver, and removes the profile.
_GUARD = 'read -r _; kill -KILL "$0"; sleep 1; rm -rf "$1"'
#: The first visible element of a selector.
_SEEN = """
const isSeen = (one) => one.checkVisibility({ visibilityProperty: true })
  && one.getBoundingClientRect().width > 0;
const isThere = (one) => isSeen(one.closest("select") ?? one); // an option in a list that is closed
return [...document.querySelectorAll(arguments[0])].find(isThere) ?? null;
"""
#: Clicks an element, or returns why that is impossible.
_PRESS = """
const one = document.querySelector(arguments[0]);
if (!one) return "there is no such element";
if (!one.checkVisibility({ visibilityProperty: true })) return "it cannot be seen";
if (one.matches(":disabled")) return "it is disabled";
one.focus();
one.click();
return "";
"""
#: Chooses an option, or returns why that is impossible.
_CHOOSE = """
const [selector, value] = arguments;
const one = document.querySelector(`${selector} option[value='${value}']`)?.closest("select");
if (!one) return `there is no ${value}`;
if (!one.checkVisibility({ visibilityProperty: true })) return "it cannot be seen";
if (one.matches(":disabled")) return "it is disabled";
one.focus();
one.value = value;
one.dispatchEvent(new Event("input", { bubbles: true }));
one.dispatchEvent(new Event("change", { bubbles: true }));
return "";
"""
_TEXT = (
    "return [...document.querySelectorAll(arguments[0])]"
    ".map((element) => element.innerText ?? element.textContent).join(' ')"
)


class Browser:
    """Browser with a temporary profile.

    :param width: of the page, pixels
    :param height: of the page, pixels
    :param frame_ms: shortest time between two frames [ms]; 0 for as many as the browser draws,
        which without a graphics card takes most of a core
    """

    def __init__(self, width: int = WIDTH, height: int = HEIGHT, frame_ms: int = 0) -> None:
        self._profile = tempfile.mkdtemp()
        self.downloads = Path(self._profile, "downloads")
        options = webdriver.ChromeOptions()
        options.binary_location = "/usr/bin/chromium"
        for argument in (
            "--headless=new",
            "--no-sandbox",  # required to run as root
            "--disable-dev-shm-usage",  # too small in a container
            "--remote-debugging-pipe",  # ends with chromedriver in any case
            "--hide-scrollbars",
            "--user-data-dir=" + str(Path(self._profile, "profile")),
        ):
            options.add_argument(argument)
        preferences = {"download.default_directory": str(self.downloads)}
        options.add_experimental_option("prefs", preferences)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        # Explicit path: Debian 13's selenium would use a tool that is not packaged.
        self.driver = webdriver.Chrome(service=Service(_DRIVER), options=options)
        # Reads until this process has ended, even by SIGKILL.
        self._guard = subprocess.Popen(
            ["sh", "-c", _GUARD, str(self.driver.service.process.pid), self._profile],
            stdin=subprocess.PIPE,
            start_new_session=True,
        )
        atexit.register(self.close)
        if frame_ms:
            script = {"source": _SLOW_FRAMES % frame_ms}
            self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", script)
        self.resize(width, height)

    def close(self) -> None:
        """Close the browser."""
        atexit.unregister(self.close)
        self._guard.kill()
        self._guard.communicate()
        self.driver.quit()
        shutil.rmtree(self._profile, ignore_errors=True)

    def resize(self, width: int, height: int, ratio: float = 1.0) -> None:
        """Set the size of the page, without the window decorations.

        :param width: of the page, pixels
        :param height: of the page, pixels
        :param ratio: screen pixels per page pixel
        """
        metrics = {"width": width, "height": height, "deviceScaleFactor": ratio, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)

    def open(self, url: str) -> None:
        """Open the page and wait until it is connected and shows traces."""
        self.driver.get(url)
        self.wait_connected()

    def wait_connected(self) -> None:
        """Wait until the page is connected."""
        wait_until(lambda: self.text("#link") == "connected", lambda: self.text("#link"))

    def find(self, selector: str) -> WebElement:
        """Return the first element of a CSS selector."""
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def count(self, selector: str) -> int:
        """Return the number of elements of a CSS selector."""
        return len(self.driver.find_elements(By.CSS_SELECTOR, selector))

    def wait_for(self, selector: str) -> WebElement:
        """Wait until an element is visible."""
        found: WebElement = wait_until(
            lambda: self.run(_SEEN, selector), lambda: f"no {selector} on the page"
        )
        return found

    def downloaded(self, name: str) -> Path:
        """Wait until a download is complete, and return it."""
        path = self.downloads / name
        # The browser first creates an empty file of this name.
        wait_until(
            lambda: path.exists() and path.stat().st_size > 0,
            lambda: list(self.downloads.glob("*")),
        )
        return path

    def remove_downloads(self) -> None:
        """Remove all downloads."""
        for path in self.downloads.glob("*"):
            path.unlink()

    def text(self, selector: str) -> str:
        """Return the visible text of all elements of a selector."""
        return str(self.run(_TEXT, selector))

    def value(self, selector: str) -> str:
        """Return the value of a control."""
        return str(self.find(selector).get_property("value"))

    def keys(self, *keys: str) -> None:
        """Press keys at the current focus."""
        ActionChains(self.driver).send_keys(*keys).perform()

    def press(self, selector: str) -> None:
        """Click the first element of a selector, without moving the pointer.

        This takes a twentieth of the CPU time; with :meth:`find` an element can be clicked as
        by a user, which fails if it is covered.
        """
        problem = self.run(_PRESS, selector)
        assert not problem, f"{selector}: {problem}"

    def choose(self, selector: str, value: str) -> None:
        """Choose an option of a list, without moving the pointer."""
        problem = self.run(_CHOOSE, selector, value)
        assert not problem, f"{selector}: {problem}"

    def run(self, script: str, *arguments: Any) -> Any:
        """Run JavaScript in the page."""
        return self.driver.execute_script(script, *arguments)

    def call(self, module: str, expression: str, *arguments: Any) -> Any:
        """Evaluate an expression with a module of the page.

        :param module: file name
        :param expression: JavaScript; ``module`` and ``a`` are the module and the arguments
        """
        return self.driver.execute_async_script(
            "const [path, ...rest] = arguments; const done = rest.pop(); const a = rest;"
            "import(path).then(async (module) => done({value: %s}))"
            ".catch((error) => done({error: String(error)}))" % expression,
            "/static/js/" + module,
            *arguments,
        )["value"]

    def accessible(self) -> List[Tuple[str, str, str]]:
        """Return role, name and description of all elements in the accessibility tree."""
        nodes = self.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
        return [
            (
                node["role"]["value"],
                node.get("name", {}).get("value", "").strip(),
                node.get("description", {}).get("value", ""),
            )
            for node in nodes
            if not node["ignored"]
        ]

    def picture(self, selector: str = "#plot canvas") -> int:
        """Return a checksum of the painted plot.

        :param selector: of another canvas
        """
        return int(self.run(_PICTURE, selector))

    def errors(self) -> List[str]:
        """Return the browser's errors since the last call."""
        return [
            entry["message"]
            for entry in self.driver.get_log("browser")
            if entry["level"] in ("SEVERE", "WARNING")
        ]
