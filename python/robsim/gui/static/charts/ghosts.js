// Other runs that are kept beside this one: their buttons, and their curves in the charts.
import { makeTextButton } from "../base/buttons.js";
import { make, pickFile, text } from "../base/dom.js";
import { makeSwatch } from "../base/icons.js";
import { makeSender } from "../base/sender.js";
import { Series } from "./series.js";

const ERRORS_FROM = 3; // field of the rows: a pose, then its error

/** Return the layers of the ghosts: of x (i = 0), y or the heading, or of its error. */
export function ghostLayers({ ghosts }, i, { scale, isAngle }, isError = false) {
  const field = isError ? ERRORS_FROM + i : i;
  const read = ([rows], k) => rows.get(k, field) * scale;
  return ghosts.map(({ name, ink, rows }) => ({
    name, ink, kind: "line", size: 1, isAside: true,
    series: new Series({ get: () => rows }, [name], read, isAngle && !isError ? 360 : 0),
  }));
}

/** Make the buttons: keep this run, compare with another one, and the ghosts that there are. */
export function makeGhostControls(context) {
  const keep = makeTextButton("keep", "", () => context.send({ type: "keep" }));
  const sender = makeSender(context, (about) =>
    about?.why && context.emit("note", { level: "error", text: about.why }));
  const choices = {
    reference: () => context.send({ type: "reference" }),
    file: () => pickFile(".npz", sender.send),
  };
  const option = (name) =>
    make("option", { value: name, textContent: text(`ghost.${name || "title"}`) });
  const select = make("select.robsim-select", {
    name: "compare", ariaLabel: text("ghost.title"),
    onchange: () => {
      choices[select.value]?.();
      select.value = "";
    },
  }, ...["", ...Object.keys(choices)].map(option));
  const list = make("div.robsim-ghosts", { role: "group", ariaLabel: text("ghosts") });
  const chip = ({ name, ink }) => make("span.robsim-chip",
    makeSwatch("line", `var(--robsim-${ink})`), name,
    make("button.robsim-button.robsim-plain.robsim-icon", {
      type: "button", name: `drop_${name}`, ariaLabel: text("ghost.drop", { name }),
      onclick: () => context.send({ type: "drop_ghost", name }),
    }, "\u00d7"));
  const renew = () => {
    list.replaceChildren(...context.ghosts.map(chip));
    list.hidden = !context.ghosts.length;
  };
  context.on("ghosts", renew);
  context.on("shown", () => (keep.disabled = context.last < 0));
  context.on("setup", ({ source }) => (select.options[1].hidden = source != "simulation"));
  renew();
  return [keep, select, list];
}
