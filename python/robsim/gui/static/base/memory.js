// @ts-check
// What the browser keeps of the choices of a view, for the next time.

const MEMORY_KEY = "robsim";

/** Return the choices of last time over these, as far as they are of the same kind. */
export function remembered(choices) {
  const known = { ...choices };
  try {
    const kept = JSON.parse(localStorage.getItem(MEMORY_KEY) ?? "{}");
    for (const [name, value] of Object.entries(kept))
      if (typeof value == typeof choices[name]) known[name] = value;
  } catch {
    // A browser may forbid it, as in a notebook of a stranger; then everything begins as it stands
    // here.
  }
  return known;
}

export function remember(choices) {
  try {
    localStorage.setItem(MEMORY_KEY, JSON.stringify(choices));
  } catch {
    // As above.
  }
}
