// @ts-check
// Undo and redo: Python has what there was before; here are the buttons and the keys.
import { makeAct } from "./pieces.js";

/** Return both buttons. The keys act everywhere but in text fields. */
export function makeHistory(context) {
  const [undo, redo] = ["undo", "redo"].map((name) => makeAct(context, name));
  context.on("state", (state) => {
    undo.disabled = !state.can_undo;
    redo.disabled = !state.can_redo;
  });
  context.el.addEventListener("keydown", (event) => {
    const type = wayOf(event);
    if (!type) return;
    context.send({ type });
    event.preventDefault();
    event.stopPropagation();
  });
  return [undo, redo];
}

function wayOf({ ctrlKey, metaKey, altKey, shiftKey, key }) {
  if (!(ctrlKey || metaKey) || altKey) return null;
  if (key.toLowerCase() == "z") return shiftKey ? "redo" : "undo";
  return key == "y" && ctrlKey ? "redo" : null;
}
