// @ts-check
// A value that is set here and known to Python.
import { painter } from "./dom.js";

const ANSWER_TIME = 1000; // ms in which Python's answer to a value is to come

/**
 * Keep a value: what was set here last is shown, not an older one that is still on its way from
 * Python (`tell`); it is sent once per animation frame at most, by `send(value, goesOn)`: whether
 * in the same drag as before. A drag lasts from `hold` to the end of the press.
 */
export function heldValue(element, show, send) {
  let [mine, told, isHeld, waitsUntil] = [undefined, undefined, false, 0];
  let timer = 0;
  let goesOn = false;
  const sendMine = painter(() => {
    send(mine, goesOn);
    goesOn = isHeld;
  });
  const settle = () => {
    clearTimeout(timer);
    if (isHeld) return;
    const rest = waitsUntil - performance.now();
    if (rest > 0 && told != mine) timer = setTimeout(settle, rest);
    else if (told !== undefined) show((mine = told));
  };
  const hold = () => ([isHeld, goesOn] = [true, false]);
  const release = () => {
    if (!isHeld) return;
    isHeld = false;
    setTimeout(settle); // after the last change, which comes behind it
    requestAnimationFrame(() => (goesOn = false)); // after that is sent
  };
  if (element.type == "range") element.addEventListener("pointerdown", hold);
  addEventListener("pointerup", release);
  addEventListener("pointercancel", release);
  return {
    hold,
    set(value) {
      mine = value;
      waitsUntil = performance.now() + ANSWER_TIME;
      show(value);
      sendMine();
      settle();
    },
    tell(value) {
      told = value;
      if (told == mine) waitsUntil = 0;
      settle();
    },
    end() {
      clearTimeout(timer);
      sendMine.cancel();
      removeEventListener("pointerup", release);
      removeEventListener("pointercancel", release);
    },
  };
}
