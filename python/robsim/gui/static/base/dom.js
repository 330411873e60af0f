// @ts-check
// Elements, and painting once per animation frame.

/** Make an element with attributes and children. */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  set(element, attributes);
  element.append(...children);
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

/** Return a function that asks for a paint in the next animation frame, however often called. */
export function painter(paint) {
  let asked = 0;
  const later = () => {
    asked ||= requestAnimationFrame(() => {
      asked = 0;
      paint();
    });
  };
  later.cancel = () => cancelAnimationFrame(asked);
  return later;
}

const CALM = 100; // ms; what changes faster cannot be read, and each change lays the page out

/** As `painter`, but not oftener than ten times a second. */
export function calmPainter(paint) {
  let [last, timer] = [0, 0];
  const later = painter(() => {
    last = performance.now();
    paint();
  });
  const calm = () => {
    clearTimeout(timer);
    timer = setTimeout(later, Math.max(0, last + CALM - performance.now()));
  };
  calm.cancel = () => {
    clearTimeout(timer);
    later.cancel();
  };
  return calm;
}

/** Whether this is the page of its own, not a notebook. */
export const isPage = () => document.body.classList.contains("robsim-page");
