// The frame of all tools: a picture with hands, parts below and next to the picture, messages,
// keys and files.
import { makeLooks, makeTextButton } from "../base/buttons.js";
import { makeContext } from "../base/context.js";
import { isPage, make, sayOrHide, text } from "../base/dom.js";
import { makeSlider, showSlider } from "../base/fields.js";
import { makeFlow } from "../base/flow.js";
import { icon } from "../base/icons.js";
import { makePicture } from "../camera/picture.js";
import { makeNotes } from "../parts/notes.js";
import { makeLoad } from "./load.js";
import { makeAct } from "./pieces.js";

const TYPING = "textarea, input:not([type=range], [type=checkbox])";

/**
 * Render a tool. `build({context, picture, film, history})` returns its `hands`, as camera/hands.js
 * has them, and elements: lists `over` the picture, at its `foot` and `beside` it, and one
 * `below` it.
 */
export function renderTool({ el, send }, name, build) {
  const context = Object.assign(makeContext(el, send), { pictures: ["picture", "mask"] });
  makeFlow(context, () => begin());
  const hands = [];
  const picture = makePicture(context, { label: `${name}_picture`, hands });
  const [film, history] = [makeFilm(context), makeHistory(context)];
  const made = build({ context, picture, film, history });
  hands.push(...made.hands);
  el.append(layOut(context, name, picture, made));

  const begin = () => send({ type: "hello", width: picture.width() });
  return Object.assign(context, { begin });
}

function layOut(context, name, picture, { over = [], foot = [], below, beside }) {
  const load = makeLoad(context);
  const view = make("div.robsim-camera", picture.canvas,
    make("div.robsim-camera-bar", picture.whole), ...over,
    make("div.robsim-camera-foot", ...foot));
  const left = make("div.robsim-left.robsim-column", makeToolTitle(context, name),
    make("div.robsim-view.robsim-surface", view), load.element, below);
  const right = make("div.robsim-right.robsim-column.robsim-tool-side", ...beside);
  const panel = make(`div.robsim-panel.robsim-tool.robsim-tool-${name}`, { tabIndex: -1 }, left,
    right, makeNotes(context).element);
  panel.addEventListener("keydown", (event) =>
    event.target.matches(TYPING) && event.stopPropagation()); // typed keys are no shortcuts
  load.listen(panel);
  return panel;
}

/** Return the buttons of undo and redo. The keys act everywhere but in text fields. */
function makeHistory(context) {
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

/** The top line: name of the tool, source of its pictures, looks of this view. */
function makeToolTitle(context, tool) {
  const name = make("span.robsim-title-name");
  const source = make("span.robsim-quiet.robsim-tool-source.robsim-clipped");
  context.on("setup", () => {
    name.textContent = text(`tool_title.${tool}`);
    if (isPage()) document.title = `${name.textContent} – robsim`;
  });
  context.on("state", ({ mode, name: drawn }) => {
    const shown = mode == "draw" ? drawn : context.setup.title;
    if (source.title != shown) source.textContent = source.title = shown;
  });
  return make("header.robsim-title", icon("robot"), name, source, makeLooks(context));
}

/** Which picture is shown: live or frozen, or one of a recording. */
function makeFilm(context) {
  const freeze = makeTextButton("freeze", "", () =>
    context.send({ type: "freeze", on: !context.state.frozen }));
  const slider = makeSlider("picture", { min: 0, max: 1, step: 1 });
  slider.setAttribute("aria-label", text("film"));
  slider.oninput = () => context.send({ type: "look", k: Number(slider.value) });
  const name = make("output.robsim-number.robsim-quiet");
  const ended = make("span.robsim-chip.robsim-warning", { hidden: true });
  const parts = [freeze, slider, name, ended];
  const element = make("div.robsim-tool-row.robsim-row.robsim-film", ...parts);
  const show = () => {
    const { setup, state } = context;
    if (!setup) return;
    freeze.hidden = !setup.is_live || Boolean(state.mode); // Capture keeps a picture there
    freeze.setAttribute("aria-pressed", String(Boolean(state.frozen)));
    slider.hidden = !(setup.count > 1);
    slider.max = String(Math.max((setup.count ?? 1) - 1, 1));
    if (state.k != null && document.activeElement != slider)
      showSlider(slider, state.k, state.name);
    element.hidden = freeze.hidden && slider.hidden;
  };
  context.on("state", ({ over }) => sayOrHide(ended, over));
  context.on("setup state", show);
  context.on("frame", (head) => (name.textContent = head.name));
  return element;
}
