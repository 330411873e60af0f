// @ts-check
// What has to be said about the picture: that it is a past one, that the robot was not seen.
import { make, say } from "../base/dom.js";
import { text } from "../base/texts.js";

export function makeBadges(context) {
  const words = text("past_step.title");
  const past = make("button",
    { type: "button", name: "past_step", title: words, ariaLabel: words });
  past.className = "robsim-chip robsim-active";
  past.onclick = () => context.look(null);
  const missed = make("div", { className: "robsim-chip robsim-warning" });
  const tell = (element, words) => {
    say(element, words);
    element.hidden = !words;
  };
  const show = () => {
    const { frame } = context;
    tell(past, frame?.past ? text("past_step", { k: frame.k }) : "");
    tell(missed, frame ? pictureRemark(frame) : "");
  };
  context.on("frame", show);
  show();
  return make("div", { className: "robsim-camera-badges" }, past, missed);
}

function pictureRemark({ picture, missed }) {
  if (!picture) return text("no_frame");
  return missed ? text("not_seen", { why: missed }) : "";
}
