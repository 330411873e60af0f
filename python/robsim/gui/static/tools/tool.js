// @ts-check
// What all tools do with messages: the newest picture, what is laid over it, the state.
import { asPicture } from "../base/buffers.js";
import { makeContext } from "../base/context.js";
import { make } from "../base/dom.js";
import { makeFlow } from "../base/flow.js";
import { makeNotes } from "../parts/notes.js";
import { makeLoad } from "./load.js";
import { makeToolTitle } from "./title.js";

/**
 * Render a tool: `parts(context)` returns `view`, the element of the picture, with its `width`,
 * what is `below`, and the elements `beside` it.
 */
export function renderTool({ el, send }, name, parts) {
  const context = makeContext(el, send);
  makeFlow(context, () => begin());
  const { view, below, width, beside } = parts(context);
  const notes = makeNotes(context);
  const load = makeLoad(context);
  const left = make("div", { className: "robsim-left" }, makeToolTitle(context, name),
    make("div", { className: "robsim-view" }, view), load.element, below);
  const right = make("div", { className: "robsim-right robsim-tool-side" }, ...beside);
  const about = { className: `robsim-panel robsim-tool robsim-tool-${name}`, tabIndex: -1 };
  const panel = make("div", about, left, right, notes.element);
  load.listen(panel);
  el.append(panel);

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
  const begin = () => send({ type: "hello", width: width() });
  return { arrived, receive, begin, end: context.end };
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
