// Problems and first steps: over the picture, in view of the user.
import { makeButton } from "../base/buttons.js";
import { make, sayOrHide, text } from "../base/dom.js";
import { icon } from "../base/icons.js";

export function makeTrouble(context, press) {
  const error = makeError(context, press);
  const stuck = makeStuck(press);
  const remark = make("p.robsim-remark.robsim-surface.robsim-afloat",
    { role: "status", hidden: true });
  const first = makeButton("first", "robsim-primary robsim-first-button robsim-afloat", () => press("start"));
  const how = make("span", text("first.hint"));
  const hint = make("div.robsim-first", { hidden: true }, first, how);
  const element = make("div.robsim-trouble", hint, remark, error.element, stuck.element);
  let noPicture = null; // reason and step
  const show = () => {
    const { state, steps, error: what } = context.state;
    error.show(what);
    stuck.show(context.state.stuck);
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
  return { element };
}

function remarkOf({ state: { state, stopped }, setup }) {
  if (stopped && state != "running") return text("remark.stopped");
  if (state == "ended" && setup?.source == "trace") return "";
  return state == "ended" ? text("remark.ended") : "";
}

/** The error of a callback: whose, where, in which step, the line; the traceback on demand. */
function makeError(context, press) {
  const words = make("p.robsim-error-text");
  const traceback = make("pre.robsim-code.robsim-error-traceback");
  const details = make("details", make("summary", text("traceback")), traceback);
  const edit = makeButton("edit", "", () => context.send({ type: "edit", slot: edit.value }));
  const jump = makeButton("to_callbacks", "", () => context.choose("tab", "callbacks"));
  const again = makeButton("go_on", "robsim-primary", () => press("start"));
  const card = makeCard(words, details, again, jump, edit);
  card.element.role = "alert";
  let slots = [];
  context.on("callbacks", (head) => (slots = head.slots));

  const show = (what) => {
    const { slot = null, k, text: message, traceback: whole } = what ?? {};
    const failed = k == null ? "error.title.once" : "error.title";
    card.show(what, slot ? text(failed, { slot, k }) : text("error"));
    words.textContent = message;
    traceback.textContent = whole ?? "";
    details.hidden = !whole;
    edit.value = slot ?? "";
    edit.hidden = !slots.some((one) => one.slot == slot && one.can_edit);
    jump.hidden = !slot;
  };
  return { element: card.element, show };
}

/** A callback that does not end: which one, since when, where; a button ends it. */
function makeStuck(press) {
  const words = make("p.robsim-stuck-text", { role: "alert" }); // seconds are not said aloud
  const end = makeButton("end", "robsim-primary", () => press("end"));
  const card = makeCard(words, "", end);
  card.element.classList.add("robsim-stuck");
  const show = (what) => {
    card.show(what, what && text("stuck", what));
    if (!what) return;
    words.textContent = text(`stuck.${what.how}`, what);
    end.hidden = what.how != "runs";
  };
  return { element: card.element, show };
}

/** A card over the picture: title, place in a file, words, that line, more, buttons. */
function makeCard(words, more, ...buttons) {
  const title = make("strong");
  const place = make("span.robsim-code.robsim-quiet");
  const code = make("pre.robsim-code.robsim-error-code");
  const element = make("section.robsim-error.robsim-surface.robsim-afloat.robsim-column",
    { hidden: true }, make("div.robsim-error-title.robsim-row", icon("warning"), title, place),
    words, code, more, make("div.robsim-error-buttons", ...buttons));
  const show = (what, heading) => {
    element.hidden = !what;
    if (!what) return;
    const { file, line, code: source } = what;
    title.textContent = heading;
    place.textContent = file ? text("file.line", { file: file.split(/[\\/]/).pop(), line }) : "";
    place.title = file ?? "";
    sayOrHide(code, (source ?? "").trim());
  };
  return { element, show };
}
