// @ts-check
// Numbers that are typed in: what is none is marked, and changes nothing.
import { text } from "../../base/texts.js";

/** The number in a field; null if it is empty, `instead` if it is none: that is marked. */
export function readNumber(field, instead = undefined) {
  const words = field.value.trim();
  const found = Number(words.replace(",", ".").replace("\u2212", "-"));
  const isNumber = Number.isFinite(found);
  field.ariaInvalid = String(!isNumber);
  field.title = isNumber ? "" : text("no_number");
  if (!isNumber) return instead;
  return words ? found : null;
}

/** Whether something that is no number stands in a field. */
export const isWrong = (field) => field.ariaInvalid == "true";
