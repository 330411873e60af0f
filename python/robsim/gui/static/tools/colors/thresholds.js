// @ts-check
// The ranges as text, as they stand in a colour file: edited, copied, saved.
import { makeTextButton } from "../../base/buttons.js";
import { make } from "../../base/dom.js";
import { text } from "../../base/texts.js";

export function makeThresholds(context) {
  const area = make("textarea", { className: "robsim-code robsim-thresholds", name: "thresholds",
    spellcheck: false, ariaLabel: text("thresholds") });
  let isMine = false; // edited here, and not taken yet
  let last = ""; // what Python told; what it refuses stays, to be mended
  const take = () => {
    if (isMine) context.send({ type: "thresholds", text: area.value });
    isMine = false;
  };
  area.oninput = () => (isMine = true);
  area.onchange = take;
  area.onkeydown = (event) => {
    event.stopPropagation();
    if (event.key == "Enter" && (event.ctrlKey || event.metaKey)) take();
  };
  const copy = makeTextButton("copy_text", "", async () => {
    await navigator.clipboard?.writeText(area.value);
    context.emit("note", { level: "info", text: text("copied") });
  });
  const file = make("input", { className: "robsim-text-field", name: "file", maxLength: 200,
    ariaLabel: text("color_file") });
  file.onkeydown = (event) => event.stopPropagation();
  const save = makeTextButton("save_colors", "robsim-primary", () =>
    context.send({ type: "save", file: file.value.trim() }));

  context.on("state", ({ text: told, file: name, classes }) => {
    if (!isMine && told != last) area.value = last = told;
    if (document.activeElement != file) file.value = name;
    save.disabled = !classes.length;
  });
  const heading = make("div", { className: "robsim-card-title", textContent: text("thresholds") });
  return {
    element: make("div", { className: "robsim-tool-part" }, heading, area,
      make("div", { className: "robsim-tool-row" }, copy, file, save)),
  };
}
