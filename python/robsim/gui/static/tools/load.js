// A picture from a file: chosen, dropped anywhere on the tool, or pasted; back from it.
import { makeButton, makeTextButton } from "../base/buttons.js";
import { isPage, make, text } from "../base/dom.js";
import { makeSender } from "../base/sender.js";
import { makeRow } from "./pieces.js";

/** `element` stands below the picture; `listen(panel)` lets files be dropped on the panel. */
export function makeLoad(context) {
  const way = makeWay(() => sender.giveUp());
  const sender = makeSender(context, way.show);
  const take = (files) => {
    if (files.length > 1) context.emit("note", { level: "info", text: text("load_one") });
    sender.send(files[0]);
  };
  const input = make("input", { type: "file", name: "picture", accept: "image/*", hidden: true });
  input.onchange = () => {
    if (input.files.length) take(input.files);
    input.value = ""; // so that the same file can be chosen again
  };
  const load = makeTextButton("load_picture", "", () => input.click());
  const back = makeTextButton("back", "", () => context.send({ type: "back" }));
  context.on("setup", ({ back: to }) => {
    back.hidden = !to;
    if (to) back.textContent = text(`back.${to}`);
  });
  const element = makeRow(load, input, back, way.element);
  const listen = (panel) => {
    panel.append(makeDropPlace(panel, take));
    listenToPaste(context, isPage() ? document : panel, take);
  };
  return { element, listen };
}

/** The progress of a file, or the reason of its refusal. */
function makeWay(giveUp) {
  const hint = make("span.robsim-quiet.robsim-load-hint", text("load_hint"));
  const bar = make("progress", { max: 1 });
  const words = make("span.robsim-load-words.robsim-clipped");
  const going = make("div.robsim-load-going.robsim-row", bar, words,
    makeTextButton("give_up", "", giveUp));
  const why = make("span");
  const refused = make("div.robsim-load-refused.robsim-row", { role: "alert" }, why,
    makeButton("close", "robsim-plain robsim-icon", () => show(null)));
  const element = make("div.robsim-load-way", hint, going, refused);
  const show = (about) => {
    const state = about?.state;
    going.hidden = state != "more" && state != "read";
    refused.hidden = state != "refused" && state != "unreadable";
    hint.hidden = !(going.hidden && refused.hidden);
    if (!going.hidden) {
      if (state == "read") bar.removeAttribute("value");
      else bar.value = about.share;
      words.textContent = text(`load.${state}`, { name: about.name,
        percent: Math.round(100 * about.share) });
    }
    if (!refused.hidden) why.textContent = about.why ?? text("load_unreadable", about);
  };
  show(null);
  return { element, show };
}

const holdsFiles = ({ dataTransfer }) => Boolean(dataTransfer?.types.includes("Files"));

/** The drop area of files: the whole panel, with a hint while a file is held over it. */
function makeDropPlace(panel, take) {
  const place = make("div.robsim-drop", { hidden: true }, make("span", text("drop_here")));
  const over = (event) => {
    if (!holdsFiles(event)) return;
    event.preventDefault();
    event.dataTransfer.dropEffect = "copy";
    place.hidden = false;
  };
  panel.addEventListener("dragenter", over);
  panel.addEventListener("dragover", over);
  panel.addEventListener("dragleave", ({ relatedTarget }) => {
    if (!panel.contains(relatedTarget)) place.hidden = true;
  });
  panel.addEventListener("drop", (event) => {
    place.hidden = true;
    if (!holdsFiles(event)) return;
    event.preventDefault();
    if (event.dataTransfer.files.length) take(event.dataTransfer.files);
  });
  return place;
}

function listenToPaste(context, target, take) {
  const paste = (event) => {
    const files = [...(event.clipboardData?.files ?? [])];
    if (!files.length) return;
    event.preventDefault();
    event.stopPropagation();
    take(files);
  };
  target.addEventListener("paste", paste, { signal: context.signal });
}

/** Stop files dropped elsewhere from replacing the page. */
export function guardFromDrops(target) {
  const guard = (event) => {
    if (event.defaultPrevented || !holdsFiles(event)) return;
    event.preventDefault();
    event.dataTransfer.dropEffect = "none";
  };
  target.addEventListener("dragover", guard);
  target.addEventListener("drop", guard);
}
