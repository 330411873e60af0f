// The steps that all charts of a panel show, and the one under the cursor.

const SHORTEST_SPAN = 10; // steps on the whole width
// widths at first, so that it does not grow with each step
const FIRST_SPANS = [100, 200, 400, 600, 1000];

/**
 * Emits "cursor", and "axis" when other steps are shown, with whether that is for new rows alone.
 */
export class StepAxis {
  constructor(context) {
    this.context = context;
    this.count = 0; // steps that there are
    this.follows = true;
    this.end = null;
    this.cursor = null; // a step
    this.toNewest();
    context.on("shown", () => this.grow());
    context.on("looking", () => this.see(context.looking));
    context.on("reset", () => this.follow());
    context.on("local", (name) => name == "window" && this.follow());
  }

  /** How many steps it follows; 0 = all. */
  get window() {
    return this.context.local.window;
  }

  grow() {
    const { store, last, looking, marked } = this.context;
    const count = Math.min(store.count, last + 1); // no further than picture and numbers
    if (count == this.count && marked == this.end) return;
    if (this.cursor >= count) this.cursor = null; // it was reset
    this.count = count;
    if (this.follows && looking === null) this.toNewest(true);
  }

  /** Bring the step that is looked at into view, and stay there; null = follow again. */
  see(k) {
    if (k === null) return this.follow();
    this.follows = false;
    const half = (this.last - this.first) / 2;
    if (k < this.first || k > this.last) this.holdAt(k - half, k + half);
    else this.context.emit("axis");
  }

  toNewest(isGrowth = false) {
    const whole = FIRST_SPANS.find((steps) => steps >= this.count) ?? this.count - 1;
    const span = this.window ? Math.min(this.window, whole) : whole;
    this.end = this.context.marked; // where a trace is played back
    const last = Math.max(span, this.end ?? this.count - 1);
    this.show(last - span, last, isGrowth);
  }

  show(first, last, isGrowth = false) {
    this.first = first;
    this.last = last;
    this.context.emit("axis", isGrowth);
  }

  follow() {
    this.follows = true;
    this.toNewest();
  }

  hold() {
    this.follows = false;
    this.context.emit("axis");
  }

  /** Hold, and show the steps from `first` to `last`, as far as that makes sense. */
  holdAt(first, last) {
    const whole = Math.max(this.count - 1, FIRST_SPANS[0]);
    const span = Math.min(Math.max(last - first, SHORTEST_SPAN), 1.2 * whole);
    const middle = Math.min(Math.max((first + last) / 2, 0), whole);
    this.follows = false;
    this.show(middle - span / 2, middle + span / 2);
  }

  zoom(about, factor) {
    const whole = 1.2 * Math.max(this.count - 1, FIRST_SPANS[0]);
    const span = Math.min(Math.max((this.last - this.first) * factor, SHORTEST_SPAN), whole);
    const first = about - ((about - this.first) / (this.last - this.first)) * span;
    this.holdAt(first, first + span);
  }

  pan(steps) {
    this.holdAt(this.first + steps, this.last + steps);
  }

  /** Put the cursor on a step, or away; `isKept`: where it can be seen. */
  point(k, isKept = false) {
    const isOff = k === null || !this.count;
    const cursor = isOff ? null : Math.min(Math.max(Math.round(k), 0), this.count - 1);
    if (cursor === this.cursor) return;
    this.cursor = cursor;
    if (isKept && cursor !== null && (cursor < this.first || cursor > this.last)) {
      const half = (this.last - this.first) / 2;
      this.holdAt(cursor - half, cursor + half);
    }
    this.context.emit("cursor");
  }
}
