// The source of a callback, with the line that failed.
import { makeTextButton } from "../base/buttons.js";
import { make, text } from "../base/dom.js";

/** `ask(slot, asker)` shows a source; the focus goes back to who asked. */
export function makeSource(context) {
  const title = make("span.robsim-card-title");
  const file = make("span.robsim-code.robsim-quiet.robsim-clipped");
  const copy = makeCopyButton(() => shown?.text ?? "");
  const close = makeTextButton("close_source", "", () => hide(), "close");
  const lines = make("ol.robsim-code.robsim-lines", { tabIndex: 0 });
  const head = make("div.robsim-source-head.robsim-row", title, file, copy, close);
  const element = make("div.robsim-source.robsim-column.robsim-surface",
    { role: "dialog", hidden: true }, head, lines);
  let shown = null;
  let asker = null;
  let errors = new Map(); // slot -> the line that failed

  const hide = () => {
    element.hidden = true;
    asker?.focus();
  };
  element.onkeydown = (event) => event.key == "Escape" && hide();
  const fill = () => {
    const rows = shown.text.replace(/\n$/, "").split("\n");
    lines.replaceChildren(...rows.map((row) => make("li", { textContent: row || "\u200b" })));
    lines.style.setProperty("--robsim-first", String(shown.first - 1));
    const failed = lines.children[errors.get(shown.slot) - shown.first];
    failed?.classList.add("robsim-failed");
    failed?.scrollIntoView({ block: "center" });
  };
  context.on("callbacks", ({ slots }) => {
    errors = new Map(slots.map(({ slot, error }) => [slot, error?.line]));
  });
  context.on("source", (source) => {
    shown = source;
    title.textContent = text(`slot.${source.slot}`);
    file.textContent = source.file ?? "";
    element.setAttribute("aria-label", title.textContent);
    element.hidden = false;
    element.parentElement.scrollTop = 0; // it covers what there is to see
    context.choose("tab", "callbacks");
    fill();
    close.focus();
  });
  const ask = (slot, by) => {
    asker = by;
    context.send({ type: "source", slot });
  };
  return { element, ask };
}

/** A button that copies a text, and says so for a while. */
export function makeCopyButton(what) {
  const press = async () => {
    const isDone = await copied(what());
    button.textContent = text(isDone ? "copied" : "copy_refused");
    setTimeout(() => (button.textContent = text("copy")), 1500);
  };
  const button = makeTextButton("copy", "", press);
  return button;
}

/** Copy a text; return whether that was allowed. Without https there is no clipboard at all. */
async function copied(words) {
  try {
    await navigator.clipboard.writeText(words);
    return true;
  } catch {
    return false;
  }
}
