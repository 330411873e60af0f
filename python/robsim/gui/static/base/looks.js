// @ts-check
// The looks of a view: colours for the colour-blind, and the theme, which is a notebook's own.
import { makeButton, showButton } from "./buttons.js";
import { isPage, make } from "./dom.js";

const THEMES = ["auto", "light", "dark"];

/** Switches for the looks, and further buttons. */
export function makeLooks(context, ...others) {
  const { local } = context;
  const palette = makeButton("palette", "robsim-plain robsim-icon", () =>
    context.choose("palette", local.palette == "distinct" ? "historical" : "distinct"));
  const theme = makeButton(local.theme, "robsim-plain robsim-icon", () =>
    context.choose("theme", THEMES[(THEMES.indexOf(local.theme) + 1) % THEMES.length]));
  theme.hidden = !isPage();
  const show = () => {
    palette.setAttribute("aria-pressed", String(local.palette == "distinct"));
    showButton(theme, local.theme);
  };
  context.on("local", show);
  show();
  return make("span", { className: "robsim-title-looks" }, palette, theme, ...others);
}
