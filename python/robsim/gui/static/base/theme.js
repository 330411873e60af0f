// @ts-check
// The colours, which stand in css/theme.css; light or dark follows the host, or a choice of the
// view.

/** Return the value of a custom property such as "--robsim-true", for a canvas. */
export const color = (el, name) => getComputedStyle(el).getPropertyValue(name).trim();

/** Whether the host is dark: JupyterLab, VS Code and Colab each say so in a way of their own. */
function isHostDark(media) {
  const { body, documentElement: root } = document;
  if (body.dataset.jpThemeLight) return body.dataset.jpThemeLight == "false";
  if (body.dataset.vscodeThemeKind) return !body.dataset.vscodeThemeKind.includes("light");
  if (root.hasAttribute("theme")) return root.getAttribute("theme") == "dark";
  return media.matches;
}

/**
 * Keep the theme and the palette of `el` as the host and `local` have them: `theme` "auto", "light"
 * or "dark", and `palette`; call `changed` after a change.
 */
export function watchTheme(el, local, changed) {
  const media = matchMedia("(prefers-color-scheme: dark)");
  const follow = () => {
    const dark = local.theme == "auto" ? isHostDark(media) : local.theme == "dark";
    const [theme, palette] = [dark ? "dark" : "light", local.palette];
    if (el.dataset.theme == theme && el.dataset.palette == palette) return;
    Object.assign(el.dataset, { theme, palette });
    changed();
  };
  const observer = new MutationObserver(follow);
  media.addEventListener("change", follow);
  observer.observe(document.body, { attributes: true });
  observer.observe(document.documentElement, { attributes: true });
  follow();
  const end = () => {
    media.removeEventListener("change", follow);
    observer.disconnect();
  };
  return { follow, end };
}
