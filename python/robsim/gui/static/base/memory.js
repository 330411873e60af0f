// @ts-check
// What the browser keeps of the choices of a view, for the next time.

const MEMORY_KEY = "robsim";

/** Return the choices of last time over these, as far as they are of the same kind. */
export function remembered(choices) {
  const known = { ...choices };
  for (const [name, value] of Object.entries(keptChoices()))
    if (typeof value == typeof choices[name]) known[name] = value;
  return known;
}

/** Keep them, beside those that other panels keep. */
export function remember(choices) {
  try {
    localStorage.setItem(MEMORY_KEY, JSON.stringify({ ...keptChoices(), ...choices }));
  } catch {
    // As below.
  }
}

function keptChoices() {
  try {
    const kept = JSON.parse(localStorage.getItem(MEMORY_KEY) ?? "{}");
    return typeof kept == "object" ? (kept ?? {}) : {};
  } catch {
    // A browser may forbid it, as in a notebook of a stranger; then everything begins as it stands
    // in the code.
    return {};
  }
}
