// The keys. They belong to the panel only while it has the focus or the pointer, without typing.
import { makeButton } from "../base/buttons.js";
import { isPage, make, text } from "../base/dom.js";

const TYPING =
  "textarea, select, [contenteditable], .cm-editor, input:not([type=range], [type=checkbox])";
// The browser's own keys, if one of these elements has the focus. On a chosen tab or choice,
// Space would do nothing.
const NATIVE = {
  " ": "button:not([aria-selected=true], [aria-checked=true]), summary, input[type=checkbox]",
  ArrowLeft: "input",
  ArrowRight: "input",
  End: "input",
};
const LISTED = ["space", "step", "step_stage", "back", "newest", "escape", "help"];

export function makeKeyboard(context, transport, timeline) {
  const { el } = context;
  const list = makeList();
  let isOver = isPage();
  const onward = () => (context.looking == null ? transport.press("step") : timeline.move(1));
  const actions = {
    " ": transport.toggle,
    ".": () => transport.press("step"),
    ArrowRight: onward,
    ArrowLeft: () => timeline.move(-1),
    End: () => context.looking != null && context.look(null),
    s: () => transport.press("step_stage"),
    "?": () => (list.element.hidden = !list.element.hidden),
  };
  const down = (event) => {
    const { key, target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || !(isOver || el.contains(target))) return;
    if (key == "Escape") return escape();
    if (context.state.tool) return; // they are the tool's
    const isTheirs = target.closest?.(TYPING) || (NATIVE[key] && target.closest?.(NATIVE[key]));
    if (event.defaultPrevented || isTheirs || !actions[key]) return;
    event.preventDefault();
    actions[key]();
  };
  const escape = () => {
    list.element.hidden = true;
    if (context.setup?.motors) transport.press("stop");
  };

  // JupyterLab would take the keys itself; Ctrl+S and its like are to stay its own.
  const first = ({ ctrlKey, metaKey, altKey }) =>
    el.toggleAttribute("data-lm-suppress-shortcuts", !(ctrlKey || metaKey || altKey));

  addEventListener("keydown", first, { capture: true, signal: context.signal });
  addEventListener("keydown", down, { signal: context.signal });
  el.addEventListener("pointerenter", () => (isOver = true));
  el.addEventListener("pointerleave", () => (isOver = isPage()));
  el.addEventListener("click", (event) => {
    // After a click Space starts and pauses again, instead of pressing the same button again.
    const button = event.detail && event.target.closest(".robsim-button");
    const panel = el.querySelector(".robsim-panel");
    if (button && document.activeElement == button) panel.focus({ preventScroll: true });
  });
  context.on("keys", actions["?"]);
  return list;
}

function makeList() {
  const close = makeButton("close", "robsim-plain robsim-icon", () => (element.hidden = true));
  const rows = LISTED.map((name) => {
    const keys = text(`key.${name}`).split(" / ").map((key) => make("kbd", { textContent: key }));
    return make("tr", make("td", ...keys), make("td", text(`key.${name}.does`)));
  });
  const title = make("h3.robsim-card-title", text("keys"));
  const about = { role: "dialog", ariaLabel: text("keys"), hidden: true };
  const top = make("div.robsim-keys-top.robsim-row", title, close);
  const element = make("section.robsim-keys.robsim-surface.robsim-afloat.robsim-card", about, top,
    make("table", ...rows));
  return { element };
}
