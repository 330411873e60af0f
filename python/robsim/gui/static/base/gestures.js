// Pointers, the wheel: clicks, drags, pinches, on a canvas.
import { distance } from "./geometry.js";

const WHEEL_UNITS = [1, 30, 400]; // px for deltaMode: pixel, line, page
const CLICK_SLOP = { mouse: 4, pen: 6, touch: 10 }; // px on the screen that a click may move

/** Whether the wheel would scroll something, so that it is not ours. */
function canScroll(element, amount) {
  for (let at = element.parentElement; at; at = at.parentElement) {
    const room = amount > 0 ? at.scrollHeight - at.clientHeight - at.scrollTop : at.scrollTop;
    const isRoot = at == document.scrollingElement;
    if (room > 1 && (isRoot || /auto|scroll/.test(getComputedStyle(at).overflowY))) return true;
  }
  return false;
}

/**
 * Call handlers for gestures on a canvas: `click`, `doubleClick`, `dragStart`, `drag` (from,
 * to), `dragEnd`, `giveUp` (a drag turns into something else), `hover` (a point, or null), `zoom`
 * (at, factor), `slide` (by, to the right). All handlers are optional. Points are px on the screen
 * times `ratio()`; `takesWheel()` returns whether the canvas always takes the wheel.
 */
export function watchGestures(canvas, handlers) {
  const pointers = new Map(); // pointers that are down -> where
  let pressed = null; // where a click or a drag began, with what
  let isDrag = false;

  const point = (event) => {
    const { left, top } = canvas.getBoundingClientRect();
    const ratio = handlers.ratio?.() ?? 1;
    return [(event.clientX - left) * ratio, (event.clientY - top) * ratio];
  };
  const end = (dropped) => {
    if (isDrag) dropped?.();
    isDrag = false;
    pressed = null;
  };
  const pinch = (event, to) => {
    const other = [...pointers].find(([id]) => id != event.pointerId)[1];
    const from = pointers.get(event.pointerId);
    handlers.zoom(other, distance(other, to) / Math.max(distance(other, from), 1));
  };
  canvas.onpointerdown = (event) => {
    if (event.button) return;
    canvas.dataset.pointer = event.pointerType; // fingers are thick
    try {
      canvas.setPointerCapture(event.pointerId);
    } catch {
      return; // it has gone already
    }
    pointers.set(event.pointerId, point(event));
    if (pointers.size > 1) end(handlers.giveUp);
    else {
      const slop = (handlers.ratio?.() ?? 1) * (CLICK_SLOP[event.pointerType] ?? 4);
      pressed = { at: point(event), slop };
    }
  };
  canvas.onpointermove = (event) => {
    const to = point(event);
    handlers.hover(to);
    const from = pointers.get(event.pointerId);
    if (!from) return;
    if (pointers.size == 2) pinch(event, to);
    if (pressed && !isDrag && distance(pressed.at, to) > pressed.slop) {
      isDrag = true;
      handlers.dragStart?.(pressed.at);
    }
    if (isDrag) handlers.drag(from, to);
    pointers.set(event.pointerId, to);
  };
  canvas.onpointerup = (event) => {
    if (!pointers.delete(event.pointerId)) return;
    if (pressed && !isDrag) handlers.click(pressed.at);
    end(handlers.dragEnd);
  };
  canvas.onpointercancel = (event) => {
    pointers.delete(event.pointerId);
    end(handlers.giveUp);
  };
  canvas.onpointerleave = (event) => pointers.has(event.pointerId) || handlers.hover(null);
  canvas.ondblclick = (event) => handlers.doubleClick(point(event));
  const wheel = (event) => {
    const isOurs = event.ctrlKey || handlers.takesWheel() || document.activeElement == canvas;
    if (!isOurs && canScroll(canvas, event.deltaY)) return;
    event.preventDefault();
    const unit = WHEEL_UNITS[event.deltaMode];
    const isSideways = Math.abs(event.deltaX) > Math.abs(event.deltaY);
    if (handlers.slide && isSideways) return handlers.slide(event.deltaX * unit);
    const speed = event.ctrlKey ? 0.01 : 0.0015; // a pinch on a touch pad comes in small numbers
    handlers.zoom(point(event), Math.exp(-speed * unit * event.deltaY));
  };
  canvas.addEventListener("wheel", wheel, { passive: false });
}

/** Where the arrow keys lead, to the right and down. */
export const ARROWS =
  { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** Return how far an arrow key leads, with Shift ten times as far; undefined for other keys. */
export const arrowStep = ({ key, shiftKey }) =>
  ARROWS[key]?.map((side) => side * (shiftKey ? 10 : 1));

/**
 * Handle keys on an element: `act(event)` returns false for an unknown key. Escape also reaches the
 * panel, which then stops the robot.
 */
export function listenToKeys(element, act) {
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || act(event) === false) return;
    event.preventDefault();
    if (event.key != "Escape") event.stopPropagation();
  });
}

/** Handle drags: `begin(event)` returns the dragged thing, {move(event), drop()}, or null. */
export function listenToDrags(element, begin) {
  let held = null;
  element.addEventListener("pointerdown", (event) => {
    held = event.button ? null : begin(event);
    if (held) element.setPointerCapture(event.pointerId);
  });
  element.addEventListener("pointermove", (event) => held?.move(event));
  for (const type of ["pointerup", "pointercancel"])
    element.addEventListener(type, () => {
      held?.drop?.();
      held = null;
    });
}
