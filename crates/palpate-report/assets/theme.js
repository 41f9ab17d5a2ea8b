/** Light or dark, and tips that stay inside the window. */
(() => {
  const root = document.documentElement, key = "palpate-theme";
  // Storage can be forbidden for files; the page then follows the system each time.
  const remembered = () => { try { return localStorage.getItem(key); } catch { return null; } };
  const remember = (value) => { try { localStorage.setItem(key, value); } catch { /* see above */ } };
  const stored = remembered();
  if (stored === "light" || stored === "dark") root.dataset.theme = stored;
  document.getElementById("theme").addEventListener("click", () => {
    const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
    remember(root.dataset.theme);
  });
  for (const box of document.querySelectorAll("header .figure")) {
    const place = () => box.classList.toggle("flip", box.getBoundingClientRect().left + 290 > document.documentElement.clientWidth);
    box.addEventListener("pointerenter", place);
    box.addEventListener("focus", place);
  }
})();
