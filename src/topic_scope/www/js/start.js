/**
 * Loads the page again if a part of it has not come: a browser gives up what it is loading when a
 * network of its computer comes or goes, and nothing else of the page would run. It is not a
 * module, as modules are what may be missing.
 */

{
  const FIRST_WAIT_MS = 500;
  const MOST_TRIES = 6; // after that the wait grows no more
  const KEY = "tries";
  const tries = Math.min(Number(sessionStorage.getItem(KEY)) || 0, MOST_TRIES);
  let isMissing = false;

  /** Load the page again, as soon as the server answers. */
  const loadAgain = () => {
    fetch(window.location.href, { method: "HEAD" }).then(
      () => window.location.reload(),
      () => setTimeout(loadAgain, FIRST_WAIT_MS),
    );
  };

  window.addEventListener("error", ({ target }) => {
    if (isMissing || !(target instanceof HTMLScriptElement || target instanceof HTMLLinkElement)) return;
    isMissing = true;
    sessionStorage.setItem(KEY, tries + 1);
    setTimeout(loadAgain, FIRST_WAIT_MS * 2 ** tries);
  }, true); // on its way down: it goes to the element alone

  window.addEventListener("load", () => {
    if (!isMissing) sessionStorage.removeItem(KEY);
  });
}
