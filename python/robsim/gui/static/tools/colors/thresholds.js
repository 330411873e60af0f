// @ts-check
// The ranges as text, as they stand in a colour file: edited, copied, saved.
import { make } from "../../base/dom.js";
import { text } from "../../base/texts.js";
import { makeCopyButton } from "../../parts/source.js";
import { makeAct, makePart, makeRow, makeTextField, showIn } from "../pieces.js";

export function makeThresholds(context) {
  let isMine = false; // edited here, and not taken yet
  let last = ""; // what Python told; what it refuses stays, to be mended
  const take = () => {
    if (isMine) context.send({ type: "thresholds", text: area.value });
    isMine = false;
  };
  const area = make("textarea", { className: "robsim-code robsim-thresholds", name: "thresholds",
    spellcheck: false, ariaLabel: text("thresholds"),
    onchange: take, oninput: () => (isMine = true),
    onkeydown: ({ key, ctrlKey, metaKey }) => key == "Enter" && (ctrlKey || metaKey) && take() });
  const copy = makeCopyButton(() => area.value);
  const file = makeTextField("file", () => {}, { maxLength: 200, ariaLabel: text("color_file") });
  const save = makeAct(context, "save_colors", "robsim-primary", () =>
    ({ type: "save", file: file.value.trim() }));
  context.on("state", ({ text: told, file: name, classes }) => {
    if (!isMine && told != last) area.value = last = told;
    showIn(file, name);
    save.disabled = !classes.length;
  });
  const heading = make("div", { className: "robsim-card-title", textContent: text("thresholds") });
  return makePart(heading, area, makeRow(copy, file, save));
}
