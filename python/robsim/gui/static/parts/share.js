// Share: a clip of the last ten seconds, and a file from which the run is run again.
import { asBytes } from "../base/buffers.js";
import { makeButton, showButton } from "../base/buttons.js";
import { make, text } from "../base/dom.js";

const KINDS = { webm: "video/webm", gif: "image/gif" };

export function makeShare(context) {
  const urls = []; // of the clip and the file
  const forget = () => urls.splice(0).forEach((url) => URL.revokeObjectURL(url));
  const urlOf = (buffer, type) => {
    urls.push(URL.createObjectURL(new Blob([asBytes(buffer)], { type })));
    return urls.at(-1);
  };
  const button = makeButton("share", "robsim-share", () => {
    button.disabled = true;
    showButton(button, "sharing");
    button.ariaBusy = "true";
    context.send({ type: "share" });
  });
  const rest = () => {
    button.disabled = button.hidden;
    showButton(button, "share");
    button.ariaBusy = "false";
  };
  const close = makeButton("close", "robsim-plain robsim-icon", () => dialog.close());
  const top = make("div.robsim-keys-top.robsim-row",
    make("h3.robsim-card-title", text("share")), close);
  const body = make("div.robsim-column");
  const dialog = make("dialog.robsim-share-dialog.robsim-surface.robsim-afloat.robsim-card",
    { ariaLabel: text("share"), onclose: forget }, top, body);
  dialog.onkeydown = (event) => event.key == "Escape" || event.stopPropagation(); // no shortcuts
  const show = ({ name, lacks, clip }, [film, file]) => {
    rest();
    forget();
    body.replaceChildren(...(clip ? makeFilm(clip, urlOf(film, KINDS[clip.split(".")[1]])) : []),
      makeDownload(name, urlOf(file, "application/octet-stream")),
      make("p.robsim-quiet", lacks ? text("share.lacks", { lacks }) : text("share.exact")));
    if (!dialog.open) dialog.showModal();
  };
  context.on("shared", show);
  context.on("note", ({ level }) => level == "error" && rest());
  context.on("setup", ({ can_share: canShare }) => (button.hidden = !canShare));
  context.onEnd(forget);
  return { button, element: dialog };
}

function makeFilm(name, url) {
  const label = text("share.clip");
  const about = { src: url, ariaLabel: label, autoplay: true, loop: true, muted: true };
  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const film = name.endsWith("gif") ? make("img", { src: url, alt: label })
    : make("video", { ...about, autoplay: !calm, controls: true });
  return [film, makeDownload(name, url)];
}

const makeDownload = (name, url) => make("a.robsim-button", { href: url, download: name },
  text("share.save", { name, what: text(`share.${name.split(".")[1]}`) }));
