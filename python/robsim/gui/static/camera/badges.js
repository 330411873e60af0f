// @ts-check
// What has to be said about the picture: that it is a past one, that the robot was not seen.
import { make } from "../base/dom.js";
import { text } from "../base/texts.js";

export function makeBadges(context) {
  const words = text("past_step.title");
  const past = make("button",
    { type: "button", name: "past_step", title: words, ariaLabel: words });
  past.className = "robsim-chip robsim-active";
  past.onclick = () => context.look(null);
  const missed = make("div", { className: "robsim-chip robsim-warning" });
  const say = (element, content) => {
    if (element.textContent != content) element.textContent = content;
    if (element.hidden == Boolean(content)) element.hidden = !content;
  };
  const show = () => {
    const { frame } = context;
    say(past, frame?.past ? text("past_step", { k: frame.k }) : "");
    say(missed, frame ? pictureRemark(frame) : "");
  };
  context.on("frame", show);
  show();
  return make("div", { className: "robsim-camera-badges" }, past, missed);
}

function pictureRemark({ picture, missed }) {
  if (!picture) return text("no_frame");
  return missed ? text("not_seen", { why: missed }) : "";
}
