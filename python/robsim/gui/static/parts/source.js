// The source of a callback: its colours, the line that failed, the doctor's remarks.
import { makeTextButton } from "../base/buttons.js";
import { make, text } from "../base/dom.js";

/** `ask(slot, asker)` shows a source; the focus goes back to who asked. */
export function makeSource(context) {
  const title = make("span.robsim-card-title");
  const file = make("span.robsim-code.robsim-quiet.robsim-clipped");
  const copy = makeCopyButton(() => shown?.text ?? "");
  const asking = (name) => makeTextButton(name, "", () =>
    context.send({ type: name, slot: shown.slot }));
  const [mine, check] = ["make_mine", "check"].map(asking);
  check.addEventListener("click", () => fillRemarks({ said: [text("check.busy")], lines: [] }));
  const close = makeTextButton("close_source", "", () => hide(), "close");
  const lines = make("ol.robsim-code.robsim-lines", { tabIndex: 0 });
  const said = make("ul.robsim-said", { role: "status" });
  const head = make("div.robsim-source-head.robsim-row", title, file, mine, check, copy, close);
  const element = make("div.robsim-source.robsim-column.robsim-surface",
    { role: "dialog", hidden: true }, head, said, lines);
  let shown = null;
  let asker = null;
  let errors = new Map(); // slot -> the line that failed
  let slots = [];

  const hide = () => {
    element.hidden = true;
    asker?.focus();
  };
  element.onkeydown = (event) => event.key == "Escape" && hide();
  const fill = () => {
    const rows = shown.text.replace(/\n$/, "").split("\n");
    lines.replaceChildren(...rows.map((row, i) =>
      make("li", ...colored(row || "\u200b", shown.colors?.[i] ?? []))));
    fillRemarks({ said: [], lines: [] });
    showButtons();
    lines.style.setProperty("--robsim-first", String(shown.first - 1));
    const failed = lines.children[errors.get(shown.slot) - shown.first];
    failed?.classList.add("robsim-failed");
    failed?.scrollIntoView({ block: "center" });
  };
  const fillRemarks = (remarks) => {
    said.replaceChildren(...remarks.said.map((words) => make("li", words)));
    for (const old of lines.querySelectorAll(".robsim-doctor")) old.remove();
    for (const [number, words] of remarks.lines)
      lines.children[number - shown.first]?.append(make("div.robsim-doctor", words));
    lines.querySelector(".robsim-doctor")?.scrollIntoView({ block: "center" });
  };
  const showButtons = () => {
    const facts = slots.find(({ slot }) => slot == shown?.slot);
    mine.hidden = !facts?.can_make;
    check.hidden = !facts?.can_check;
  };
  context.on("remarks", (remarks) => remarks.slot == shown?.slot && fillRemarks(remarks));
  context.on("callbacks", (told) => {
    ({ slots } = told);
    showButtons();
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
  return { element, ask, askedBy: (by) => (asker = by) };
}

/** Return the parts of a line, [first, end, kind], each in its colour; the rest as it is. */
function colored(line, parts) {
  const letters = [...line]; // as Python counts them
  let at = 0;
  const made = parts.flatMap(([first, end, kind]) => {
    const before = letters.slice(at, first).join("");
    at = end;
    return [before, make(`span.robsim-code-${kind}`, letters.slice(first, end).join(""))];
  });
  return [...made, letters.slice(at).join("")];
}

/** A button that copies a text, and confirms this for a while. */
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
