// Buttons and groups of them.
import { isPage, make, set, text } from "./dom.js";
import { listenToKeys } from "./gestures.js";
import { icon } from "./icons.js";

const THEMES = ["auto", "light", "dark"];

/** A button with an icon, its text, and a longer description. */
export function makeButton(name, kind, onclick) {
  const button = make("button", { type: "button", className: `robsim-button ${kind}`, onclick });
  showButton(button, name);
  return button;
}

/** A button of words alone; their name in the texts, if it is another one than the button's. */
export function makeTextButton(name, kind, onclick, words = name) {
  const title = text(`${words}.title`, {}, "");
  const about = { type: "button", className: `robsim-button ${kind}`, name, title, onclick };
  return make("button", { ...about, textContent: text(words) });
}

/** Let a button be another one. */
export function showButton(button, name) {
  if (button.name == name) return;
  button.name = name;
  button.title = text(`${name}.title`, {}, text(name));
  button.setAttribute("aria-label", text(name));
  const label = make("span.robsim-button-text", text(name));
  button.replaceChildren(icon(name), ...(button.classList.contains("robsim-icon") ? [] : [label]));
}

/** Make a radio group: a click or an arrow key calls `choose(value)`. */
export function makeRadios(className, ariaLabel, choose) {
  const element = make("div", { className, role: "radiogroup", ariaLabel });
  moveByArrows(element, ({ ariaDisabled, value }) => ariaDisabled == "true" || choose(value));
  const makeOne = ({ value }) =>
    make("button", { type: "button", role: "radio", value, onclick: () => choose(value) });
  let [names, all] = ["", ""]; // that are shown
  /** Show some options, {value, textContent, ...}; `chosen` is the value of the checked one. */
  const show = (options, chosen) => {
    const [oldNames, old] = [names, all];
    names = options.map(({ value }) => value).join("\n");
    all = JSON.stringify([options, chosen]);
    if (all == old) return;
    const losesFocus = names != oldNames && element.matches(":focus-within");
    if (names != oldNames) element.replaceChildren(...options.map(makeOne));
    options.forEach((option, i) => set(element.children[i], option));
    markChosen(element, "aria-checked", (button) => button.value == chosen);
    if (losesFocus) element.querySelector("[aria-checked=true]")?.focus();
  };
  return { element, show };
}

/** Let the arrow keys, Home and End move between the buttons of a group; one of them takes Tab. */
export function moveByArrows(group, choose) {
  const ways = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 };
  listenToKeys(group, (event) => {
    const buttons = [...group.children];
    const at = buttons.indexOf(document.activeElement);
    const ends = { Home: 0, End: buttons.length - 1 };
    const to = ends[event.key] ?? (at + ways[event.key] + buttons.length) % buttons.length;
    if (at < 0 || Number.isNaN(to)) return false;
    buttons[to].focus();
    choose(buttons[to]);
  });
}

/** Mark one button of a group as the chosen one, by an attribute such as aria-checked. */
export function markChosen(group, attribute, isChosen) {
  const buttons = [...group.children];
  const chosen = buttons.find(isChosen);
  for (const button of buttons) {
    button.setAttribute(attribute, String(button == chosen));
    button.tabIndex = button == (chosen ?? buttons[0]) ? 0 : -1;
  }
}

/** Switches for the looks, and further buttons. */
export function makeLooks(context, ...others) {
  const { local } = context;
  const palette = makeButton("palette", "robsim-plain robsim-icon", () =>
    context.choose("palette", local.palette == "distinct" ? "historical" : "distinct"));
  const theme = makeButton(local.theme, "robsim-plain robsim-icon", () =>
    context.choose("theme", THEMES[(THEMES.indexOf(local.theme) + 1) % THEMES.length]));
  theme.hidden = !isPage();
  const show = () => {
    palette.setAttribute("aria-pressed", String(local.palette == "distinct"));
    showButton(theme, local.theme);
  };
  context.on("local", show);
  show();
  return make("span.robsim-title-looks", palette, theme, ...others);
}
