// @ts-check
// All texts stand in texts.json; the joined module begins with them, as TEXTS.

/** Return a text by its name, with {fields} filled in; without one `instead`. */
export function text(name, fields = {}, instead = name) {
  // eslint-disable-next-line no-undef
  const found = TEXTS[name] ?? instead;
  return found.replace(/\{(\w+)\}/g, (_, field) => fields[field]);
}
