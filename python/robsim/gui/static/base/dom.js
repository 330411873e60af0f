// Elements, and painting once per animation frame.

/** Make an element, "tag.class.class", with attributes, if there are such, and children. */
export function make(what, ...content) {
  const [tag, ...classes] = what.split(".");
  const element = document.createElement(tag);
  element.classList.add(...classes);
  if (content[0]?.constructor == Object) set(element, content.shift());
  element.append(...content);
  return element;
}

/** Set attributes of an element; `on...` handlers are properties. */
export function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
}

/** Let an element say something; it is not touched if it says that already. */
export function say(element, words) {
  if (element.textContent != words) element.textContent = words;
}

/** Let an element say something; it is hidden while it says nothing. */
export function sayOrHide(element, words) {
  say(element, words);
  element.hidden = !words;
}

/** Give a canvas the pixels of its box; return whether it had others. */
export function fitCanvas(canvas) {
  const { width, height } = canvas.getBoundingClientRect();
  const sides = [width - canvas.offsetWidth + canvas.clientWidth,
    height - canvas.offsetHeight + canvas.clientHeight].map((side) =>
    Math.max(1, Math.round(side * devicePixelRatio)));
  if (sides[0] == canvas.width && sides[1] == canvas.height) return false;
  [canvas.width, canvas.height] = sides;
  return true;
}

/** Return a function that requests a paint in the next animation frame, at most once. */
export function painter(paint) {
  let asked = 0;
  return () => {
    asked ||= requestAnimationFrame(() => {
      asked = 0;
      paint();
    });
  };
}

/** Let a file be chosen, and `take` it. */
export function pickFile(accept, take) {
  const input = make("input", { type: "file", accept });
  input.onchange = () => take(input.files[0]);
  input.click();
}

/** Whether this is the standalone page, not a notebook. */
export const isPage = () => document.body.classList.contains("robsim-page");

/** Return a text of texts.json by its name, with {fields} filled in; without one `instead`. */
export function text(name, fields = {}, instead = name) {
  // eslint-disable-next-line no-undef
  const found = TEXTS[name] ?? instead;
  return found.replace(/\{(\w+)\}/g, (_, field) => fields[field]);
}
