// @ts-check
// The main panel: its parts, and what is done with messages.
import { asPicture } from "./base/buffers.js";
import { make } from "./base/dom.js";
import { makeFlow } from "./base/flow.js";
import { makeParameterCharts } from "./charts/parameters.js";
import { makeTraces } from "./charts/traces.js";
import { makeCallbacks } from "./parts/callbacks.js";
import { makeCamera } from "./parts/camera.js";
import { makeControls } from "./parts/controls.js";
import { makeInspector } from "./parts/inspector.js";
import { makeKeyboard } from "./parts/keyboard.js";
import { makeNotes } from "./parts/notes.js";
import { makeResult } from "./parts/result.js";
import { makeTabs } from "./parts/tabs.js";
import { makeTimeline } from "./parts/timeline.js";
import { makeTitle } from "./parts/title.js";
import { makeToolPlace } from "./parts/tool_place.js";
import { makeTransport } from "./parts/transport.js";
import { makeTrouble } from "./parts/trouble.js";
import { makeRunContext } from "./run.js";

export function renderPanel({ el, send }) {
  const context = makeRunContext(el, send);
  makeFlow(context, () => begin());
  const camera = makeCamera(context);
  const place = makeToolPlace(context);
  el.append(...layOut(context, camera, place));

  let newest = null; // the head of the last frame that has come
  const arrived = (head) => {
    if (head.type == "frame") newest = head;
    if (head.type == "tool") place.arrived(head.message);
  };
  // While one was decoded a newer one of the same kind has come: it is late already.
  const isLate = (head) => head.type == "frame" && head != newest && head.past == newest.past;
  const receive = async (head, buffers) => {
    if (head.type == "setup") context.setup = head;
    if (head.type == "state") takeState(context, head);
    if (head.type == "rows" || head.type == "frame") takeRows(context, head, buffers);
    if (isLate(head)) return head.rows.length && context.emit("rows", head, buffers);
    if (head.type == "frame") return takeFrame(context, head, buffers);
    if (head.type == "tool") return place.receive(head.message, buffers);
    context.emit(head.type, head, buffers);
  };
  const begin = () => {
    send({ type: "hello", width: camera.width() });
    if (context.looking != null) context.look(context.looking); // hello shows the newest
  };
  return { arrived, receive, begin, end: context.end };
}

function layOut(context, camera, place) {
  const transport = makeTransport(context);
  const timeline = makeTimeline(context);
  const trouble = makeTrouble(context, transport.press);
  const tabs = makeTabs(context, {
    traces: makeTraces(context),
    parameters: makeParameterCharts(context),
    callbacks: makeCallbacks(context),
    inspector: makeInspector(context),
    result: makeResult(context),
  });
  const view = make("div", { className: "robsim-view" }, camera.element, trouble.element);
  const left = [makeTitle(context), { element: view }, transport, timeline, makeControls(context)];
  const over = [makeKeyboard(context, transport, timeline).element, makeNotes(context).element,
    trouble.lost];
  const panel = make("div", { className: "robsim-panel", tabIndex: -1 },
    make("div", { className: "robsim-left robsim-column" }, ...left.map((part) => part.element)),
    make("div", { className: "robsim-right robsim-column" },
      make("div", { className: "robsim-right-top" }, tabs.list, place.buttons), tabs.sheets));
  return [panel, place.element, ...over]; // what lies over it is seen beside a tool, too
}

function takeState(context, head) {
  const isAnew = head.resets != context.state.resets;
  context.state = head;
  context.newest = head.k;
  context.el.dataset.state = head.state;
  if (isAnew) context.emit("reset");
  if (isAnew && context.looking != null) context.look(null);
}

function takeRows(context, { rows, type }, buffers) {
  context.store.take(rows, buffers, type == "frame" ? 1 : 0);
  // Whoever looks back gets no new frames, but rows.
  const counts = rows.map(({ column }) => context.store.get(column).count);
  context.newest = Math.max(context.newest, ...counts.map((count) => count - 1));
}

async function takeFrame(context, head, buffers) {
  if (!head.past) context.newest = head.k;
  head.picture = buffers[0].byteLength ? await asPicture(buffers[0], "image/jpeg") : null;
  context.frame?.picture?.close();
  context.frame = head;
  context.emit("frame", head, buffers);
  if (head.rows.length) context.emit("rows", head, buffers);
}
