// The menu in which the overlays are switched.
import { makeTextButton } from "../base/buttons.js";
import { make, text } from "../base/dom.js";
import { makeSwatch } from "../base/icons.js";
import { isShown } from "./overlays.js";

export function makeShowMenu(context, overlays) {
  const list = make("div.robsim-surface.robsim-afloat.robsim-card.robsim-show-list",
    { role: "group", ariaLabel: text("show") });
  const open = (isOpen) => {
    list.hidden = !isOpen;
    button.setAttribute("aria-expanded", String(isOpen));
  };
  const button = makeTextButton("show", "", () => open(list.hidden));
  const classStripes = () => {
    const colors = (context.setup?.colors ?? []).map(({ css }) => css);
    const at = (i) => `${(100 * i) / colors.length}%`;
    const stripes = colors.map((css, i) => `${css} ${at(i)} ${at(i + 1)}`);
    return `linear-gradient(to right, ${stripes.join()})`;
  };
  const entry = (overlay) => {
    const box = make("input", {
      type: "checkbox", name: `show_${overlay.name}`, checked: isShown(context, overlay),
      onchange: () =>
        context.choose("overlays", { ...context.local.overlays, [overlay.name]: box.checked }),
    });
    const colors = overlay.color ? `var(--robsim-${overlay.color})` : classStripes();
    return make("label", box, makeSwatch("box", colors), text(`overlay.${overlay.name}`));
  };
  const fill = () => {
    const there = overlays.filter(({ is }) => !context.setup || !is || is(context.setup));
    list.replaceChildren(...there.toReversed().map(entry));
  };
  open(false);
  fill();
  context.on("setup", fill);
  const element = make("div.robsim-show", button, list);
  element.onkeydown = (event) => {
    if (event.key != "Escape" || list.hidden) return;
    open(false);
    button.focus();
  };
  const outside = (event) => event.composedPath().includes(element) || open(false);
  document.addEventListener("pointerdown", outside, { signal: context.signal });
  return element;
}
