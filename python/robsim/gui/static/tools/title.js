// @ts-check
// The top line of a tool: what it is, whose pictures it shows; the looks of this view.
import { isPage, make } from "../base/dom.js";
import { icon } from "../base/icons.js";
import { makeLooks } from "../base/looks.js";
import { text } from "../base/texts.js";

export function makeToolTitle(context, tool) {
  const name = make("span", { className: "robsim-title-name robsim-clipped" });
  const source = make("span", { className: "robsim-quiet robsim-tool-source robsim-clipped" });
  context.on("setup", () => {
    name.textContent = text(`tool_title.${tool}`);
    if (isPage()) document.title = `${name.textContent} – robsim`;
  });
  context.on("state", ({ mode, name: drawn }) => {
    const shown = mode == "draw" ? drawn : context.setup.title;
    if (source.title != shown) source.textContent = source.title = shown;
  });
  return make("header", { className: "robsim-title" }, icon("robot"), name, source,
    makeLooks(context));
}
