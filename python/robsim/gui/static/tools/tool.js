// @ts-check
// The frame of all tools: a picture with hands, parts below and next to the picture, messages,
// keys and files.
import { asPicture } from "../base/buffers.js";
import { makeContext } from "../base/context.js";
import { make } from "../base/dom.js";
import { makeFlow } from "../base/flow.js";
import { makePicture } from "../camera/picture.js";
import { makeNotes } from "../parts/notes.js";
import { makeFilm } from "./film.js";
import { makeHistory } from "./history.js";
import { makeLoad } from "./load.js";
import { makeToolTitle } from "./title.js";

const TYPING = "textarea, input:not([type=range], [type=checkbox])";

/**
 * Render a tool. `build({context, picture, film, history})` returns its `hands`, as camera/hands.js
 * has them, and elements: lists `over` the picture, at its `foot` and `beside` it, and one
 * `below` it.
 */
export function renderTool({ el, send }, name, build) {
  const context = makeContext(el, send);
  makeFlow(context, () => begin());
  const hands = [];
  const picture = makePicture(context, { label: `${name}_picture`, hands });
  const [film, history] = [makeFilm(context), makeHistory(context)];
  const made = build({ context, picture, film, history });
  hands.push(...made.hands);
  el.append(layOut(context, name, picture, made));

  let newest = null; // the head of the last frame that has come
  const arrived = (head) => {
    if (head.type == "frame") newest = head;
  };
  const receive = async (head, buffers) => {
    if (head.type == "setup") context.setup = head;
    if (head.type == "state") takeToolState(context, head);
    if (head.type == "frame" && !(await takePictures(context, head, buffers, () => newest)))
      return;
    context.emit(head.type, head, buffers);
  };
  const begin = () => send({ type: "hello", width: picture.width() });
  return { arrived, receive, begin, end: context.end };
}

function layOut(context, name, picture, { over = [], foot = [], below, beside }) {
  const load = makeLoad(context);
  const view = make("div", { className: "robsim-camera" }, picture.canvas,
    make("div", { className: "robsim-camera-bar" }, picture.whole), ...over,
    make("div", { className: "robsim-camera-foot" }, ...foot));
  const left = make("div", { className: "robsim-left robsim-column" }, makeToolTitle(context, name),
    make("div", { className: "robsim-view" }, view), load.element, below);
  const right = make("div",
    { className: "robsim-right robsim-column robsim-tool-side" }, ...beside);
  const about = { className: `robsim-panel robsim-tool robsim-tool-${name}`, tabIndex: -1 };
  const panel = make("div", about, left, right, makeNotes(context).element);
  panel.addEventListener("keydown", (event) =>
    event.target.matches(TYPING) && event.stopPropagation()); // typed keys are no shortcuts
  load.listen(panel);
  return panel;
}

function takeToolState(context, head) {
  context.state = head;
  context.el.dataset.state = head.state;
}

/** Take the picture and the mask of a frame; false if a newer one has come meanwhile. */
async function takePictures(context, head, [picture, mask], newest) {
  if (head != newest()) return false;
  head.picture = await asPicture(picture, "image/jpeg");
  head.mask = mask?.byteLength ? await asPicture(mask, "image/png") : null;
  context.frame?.picture?.close();
  context.frame?.mask?.close();
  context.frame = head;
  return true;
}
