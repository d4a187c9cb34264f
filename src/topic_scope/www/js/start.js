/**
 * Reloads the page if a part of it failed to load: a browser aborts downloads when a
 * network interface changes, and the rest of the page would not run. It is not a
 * module, because modules may be missing.
 */

{
  const FIRST_WAIT_MS = 500;
  const MOST_TRIES = 6; // after that the wait does not grow further
  const KEY = "tries";
  const tries = Math.min(Number(sessionStorage.getItem(KEY)) || 0, MOST_TRIES);
  let isMissing = false;

  /** Reload the page as soon as the server answers. */
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
  }, true); // capture phase: error events of elements do not bubble

  window.addEventListener("load", () => {
    if (!isMissing) sessionStorage.removeItem(KEY);
  });
}
