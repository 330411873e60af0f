// What is wrong, or to be done first: over the picture, where the eye is.
import { makeButton } from "../base/buttons.js";
import { isPage, make, sayOrHide, text } from "../base/dom.js";
import { icon } from "../base/icons.js";

export function makeTrouble(context, press) {
  const error = makeError(context, press);
  const remark = make("p.robsim-remark.robsim-surface.robsim-afloat",
    { role: "status", hidden: true });
  const first = makeButton("first", "robsim-primary robsim-first-button robsim-afloat", () => press("start"));
  const how = make("span", text("first.hint"));
  const hint = make("div.robsim-first", { hidden: true }, first, how);
  const element = make("div.robsim-trouble", hint, remark, error.element);
  let noPicture = null; // why, and of which step
  const show = () => {
    const { state, steps, error: what } = context.state;
    error.show(what);
    hint.hidden = state != "paused" || steps > 0;
    const words = noPicture ? text("remark.no_picture", noPicture) : remarkOf(context);
    sayOrHide(remark, what ? "" : words);
  };
  context.on("state", show);
  const miss = (head) => {
    noPicture = head;
    show();
  };
  context.on("past", miss);
  context.on("frame", ({ k }) => noPicture && noPicture.k != k && miss(null));
  return { element, lost: makeLost() };
}

function remarkOf({ state: { state, stopped }, setup }) {
  if (stopped && state != "running") return text("remark.stopped");
  if (state == "ended" && setup?.source == "trace") return "";
  if (state == "closed" && isPage()) return text("remark.closed.page");
  return ["ended", "closed"].includes(state) ? text(`remark.${state}`) : "";
}

/** The error of a callback: whose, where, in which step, the line; the traceback on demand. */
function makeError(context, press) {
  const title = make("strong");
  const words = make("p.robsim-error-text");
  const place = make("span.robsim-code.robsim-quiet");
  const code = make("pre.robsim-code.robsim-error-code");
  const traceback = make("pre.robsim-code.robsim-error-traceback");
  const details = make("details", make("summary", text("traceback")), traceback);
  const edit = makeButton("edit", "", () => context.send({ type: "edit", slot: edit.value }));
  const jump = makeButton("to_callbacks", "", () => context.choose("tab", "callbacks"));
  const again = makeButton("go_on", "robsim-primary", () => press("start"));
  const element = make("section.robsim-error.robsim-surface.robsim-afloat.robsim-column",
    { role: "alert", hidden: true },
    make("div.robsim-error-title.robsim-row", icon("warning"), title, place),
    words, code, details, make("div.robsim-error-buttons", again, jump, edit));
  let slots = [];
  context.on("callbacks", (head) => (slots = head.slots));

  const show = (what) => {
    element.hidden = what == null;
    if (what == null) return;
    const { slot, k, text: message, file, line, code: source } = what;
    const failed = k == null ? "error.title.once" : "error.title";
    title.textContent = slot ? text(failed, { slot, k }) : text("error");
    words.textContent = message;
    place.textContent = file ? text("file.line", { file: file.split(/[\\/]/).pop(), line }) : "";
    place.title = file ?? "";
    code.textContent = (source ?? "").trim();
    code.hidden = !source;
    traceback.textContent = what.traceback ?? "";
    details.hidden = !what.traceback;
    edit.value = slot ?? "";
    edit.hidden = !slots.some((one) => one.slot == slot && one.can_edit);
    jump.hidden = !slot;
  };
  return { element, show };
}

/** What covers the panel when nobody answers any more; panel.css shows it. */
function makeLost() {
  const where = isPage() ? "page" : "notebook";
  const card = (state, what, todo) =>
    make(`div.robsim-surface.robsim-afloat.robsim-card.robsim-lost-${state}`,
      make("strong", text(what)), make("p", text(todo)));
  const cards = [card("lost", "lost", "lost.again"), card("gone", "gone", `gone.${where}`)];
  return make("div.robsim-lost", { role: "alert" }, ...cards);
}
