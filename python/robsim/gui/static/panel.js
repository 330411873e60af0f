// The main panel: its parts, and its handlers of messages.
import { markChosen, moveByArrows } from "./base/buttons.js";
import { make, set, text } from "./base/dom.js";
import { makeFlow } from "./base/flow.js";
import { makeParameterCharts } from "./charts/parameters.js";
import { makeTraces } from "./charts/traces.js";
import { makeCallbacks } from "./parts/callbacks.js";
import { makeCamera } from "./parts/camera.js";
import { makeChallenge } from "./parts/challenge.js";
import { makeControls } from "./parts/controls.js";
import { makeInspector } from "./parts/inspector.js";
import { makeKeyboard } from "./parts/keyboard.js";
import { makeNotes } from "./parts/notes.js";
import { makeResult } from "./parts/result.js";
import { makeScenario } from "./parts/scenario.js";
import { makeShare } from "./parts/share.js";
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

  const arrived = (head) => {
    context.arrived(head);
    if (head.type == "tool") place.arrived(head.message);
  };
  const receive = async (head, buffers) => {
    if (head.type == "tool") return place.receive(head.message, buffers);
    if (head.type == "rows") takeRows(context, head, buffers);
    if (head.type != "frame") return context.receive(head, buffers);
    takeRows(context, head, buffers.slice(1));
    if (!head.past) context.newest = head.k;
    await context.receive(head, buffers);
    if (head.rows.length) context.emit("rows", head, buffers);
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
  const share = makeShare(context);
  const trouble = makeTrouble(context, transport.press);
  const challenge = makeChallenge(context);
  const tabs = makeTabs(context, {
    traces: makeTraces(context),
    parameters: makeParameterCharts(context),
    callbacks: makeCallbacks(context),
    inspector: makeInspector(context),
    result: makeResult(context),
    scenario: makeScenario(context),
    scores: challenge.sheet,
  });
  const view = make("div.robsim-view.robsim-surface", camera.element, trouble.element);
  const left = [makeTitle(context), { element: view }, transport, timeline,
    challenge, makeControls(context)];
  const over = [makeKeyboard(context, transport, timeline).element, makeNotes(context).element,
    share.element];
  const panel = make("div.robsim-panel", { tabIndex: -1 },
    make("div.robsim-left.robsim-column", ...left.map((part) => part.element)),
    make("div.robsim-right.robsim-column",
      make("div.robsim-right-top", tabs.list, place.buttons, share.button), tabs.sheets));
  return [panel, place.element, ...over]; // overlays are visible beside a tool, too
}

function takeRows(context, { rows }, buffers) {
  context.store.take(rows, buffers);
  // A view of a past step gets rows, but no new frames.
  const counts = rows.map(({ column }) => context.store.get(column).count);
  context.newest = Math.max(context.newest, ...counts.map((count) => count - 1));
}

/** The tabs of the right side; `sheets`: {name of the tab: its part}. */
function makeTabs(context, sheets) {
  const names = Object.keys(sheets);
  const choose = (name) => context.choose("tab", name);
  const tabs = names.map((name) => {
    const [id, sheet] = ["tab", "sheet"].map((what) => `robsim-${context.id}-${name}-${what}`);
    set(sheets[name].element, { id: sheet, tabIndex: 0, role: "tabpanel", "aria-labelledby": id });
    const about = { type: "button", role: "tab", id, value: name, "aria-controls": sheet };
    return make("button", { ...about, onclick: () => choose(name) }, text(name));
  });
  const about = { role: "tablist", ariaLabel: text("tabs") };
  const list = make("div.robsim-tabs.robsim-cut", about);
  const elements = names.map((name) => sheets[name].element);
  moveByArrows(list, (button) => choose(button.value));

  const show = () => {
    const isThere = [...list.children].some(({ value }) => value == context.local.tab);
    const chosen = isThere ? context.local.tab : names[0];
    markChosen(list, "aria-selected", (button) => button.value == chosen);
    names.forEach((name, i) => (elements[i].hidden = name != chosen));
  };
  context.on("local", (name) => name == "tab" && show());
  const callbacks = tabs[names.indexOf("callbacks")];
  context.on("state", ({ error }) => (callbacks.dataset.mark = error ? "bad" : ""));
  const offer = (isThere) => {
    list.replaceChildren(...tabs.filter(({ value }) => isThere[value] ?? true));
    show();
  };
  context.on("setup", ({ has_options: hasOptions, challenge }) =>
    offer({ scenario: Boolean(hasOptions), scores: Boolean(challenge) }));
  context.on("result", ({ again }) => again || choose("result")); // not one from before
  offer({ scenario: false, scores: false }); // until the setup names them
  return { list, sheets: make("div.robsim-sheets", ...elements) };
}
