// @ts-check
// Elements, and painting once per animation frame.

/** Make an element with attributes (`on...` handlers are properties) and children. */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
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
