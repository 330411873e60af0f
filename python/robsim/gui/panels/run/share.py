"""Share: a clip of the last ten seconds, and a replay file that reruns the run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from robsim._core import Frame, Step
from robsim.base.files import write_whole
from robsim.gui._link import Link, Refused
from robsim.gui.kept_runs import save
from robsim.gui.panels.part import Handlers, Part
from robsim.gui.panels.replay_file import ReplayFile, digest_of
from robsim.gui.panels.settings.owners import owners_of
from robsim.simulation import Simulation
from robsim.simulation.runner import Runner
from robsim.vision.imaging.clip import Clip

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView
    from robsim.vision.imaging.images import Pixels

_SECONDS, _LEAST_RATE, _WIDTH = 10, 15.0, 600  # of the clip: s, 1/s, px
_MOST_CHANGES = 10_000
_MOST_SENT = 24 << 20  # bytes; a page more than 32 MB behind is disconnected


class Share(Part):
    """Records the changes of a simulation, and makes files from them."""

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self._making = panel.beside("robsim share")
        self._changes: list[tuple[int, int, str, dict[str, Any]]] = []  # resets, step, stage, data
        self._unknown: set[str] = set()  # changes by code outside of the panel
        self._taken = 0, 0  # resets, steps at the last look at the files
        if isinstance(runner := panel.runner, Simulation):
            self._unknown |= {*runner._changed}
            self._start, self._known = runner.scenario, _told(runner)
            self._files = _files(runner)
            self._first_files = self._texts(self._files)
            may_fill = runner._folder._slots if runner._folder is not None else ()
            self._slots = [slot for slot in may_fill if runner._given[slot] in (None, True)]
            self._compare(runner)

    def handlers(self) -> Handlers:
        return {"share": self._share}

    def setup(self) -> dict[str, Any]:
        return {"can_share": isinstance(self.panel.runner, Runner)}

    def noted(self, message: dict[str, Any], change: Callable[[], Any]) -> Any:
        """Change something, and record the message; in the thread of the run."""
        runner = self.panel.runner
        if not isinstance(runner, Simulation) or message.get("name") == "speed":
            return change()
        self._compare(runner)
        k, stage = runner.n_steps, runner.stage
        result = change()
        self._known = _told(runner)
        self._add(k, stage, {name: message[name] for name in message if name != "id"})
        return result

    def take(self, step: Step) -> None:
        runner, n_resets = self.panel.runner, self.panel.record.n_resets
        # A chunk of steps loads files before its first step.
        k = min(step.k, self._taken[1]) if n_resets == self._taken[0] else 0
        self._taken = n_resets, runner.n_steps
        if isinstance(runner, Simulation) and (files := _files(runner)) is not self._files:
            self._files = files
            self._add(k, "world", self._texts(files))

    def _add(self, k: int, stage: str, what: dict[str, Any]) -> None:
        if len(self._changes) < _MOST_CHANGES:
            self._changes.append((self.panel.record.n_resets, k, stage, what))
        else:
            self._unknown.add("more changes than can be kept")

    def _texts(self, files: Mapping[str, bytes]) -> dict[str, str]:
        texts = {}
        for name, source in files.items():
            try:
                texts[name] = source.decode()
            except UnicodeDecodeError:
                self._unknown.add(f"{name}.py is not in UTF-8")
        return texts

    def _compare(self, runner: Simulation) -> None:
        """Record changes by other code since the panel's last change."""
        owners = owners_of(runner)
        mine = [slot for slot in runner.SLOTS if owners.of(slot) == "mine"]
        code = [slot for slot in mine if not _is_open(runner, slot)]
        self._unknown |= {f"{slot} from a cell or a script" for slot in code}
        options, folder, given = _told(runner)
        if options != self._known[0]:
            self._unknown.add("options set in Python, by a tool or in the tab Scenario")
        is_new = folder is not self._known[1]
        made = {slot for slot in mine if is_new or given[slot] is not self._known[2][slot]}
        self._unknown |= {f"{slot}.py, made during the run" for slot in made - {*code}}

    def _replay(self) -> tuple[str, bytes, str]:
        """Return name, content and missing parts of the file; in the thread of the run."""
        runner, record = self.panel.runner, self.panel.record
        lacks = ["frames of a camera"]
        if isinstance(runner, Simulation):
            self._compare(runner)
            lacks = sorted(self._unknown)
        if not lacks:
            try:
                text = ReplayFile.of_text(self._text()).to_text()
                return "run.replay", text.encode(), ""
            except ValueError as error:
                lacks = [f"a replay file: {error}"]
        with TemporaryDirectory() as folder:
            file = Path(folder, "run.npz")
            record.trace.save(file)
            return file.name, file.read_bytes(), ", ".join(lacks)

    def _text(self) -> str:
        now = (record := self.panel.record).n_resets
        changes = [
            (k, stage, what) if resets == now else (0, "world", what)
            for resets, k, stage, what in self._changes
            if k < record.n_steps or resets != now
        ]
        return ReplayFile(
            scenario=self._start.to_toml(),
            slots=self._slots,
            files=self._first_files,
            changes=changes,
            steps=record.n_steps,
            digest=digest_of(record.columns()),
        ).to_text()

    def _share(self, link: Link, message: dict[str, Any]) -> None:
        if not self.setup()["can_share"]:
            raise Refused("this run is played back from a file; share that file instead")
        if not self.panel.record.n_steps:
            raise Refused("there is nothing to share yet: press Start")
        if self._making.is_busy:
            raise Refused("the previous clip is still being made")

        def make() -> tuple[str, bytes, str, tuple[str, bytes]]:
            return *self.panel.driver.ask(self._replay), self._clip()

        self._making.begin(make, lambda made: self._made(link, made))

    def _made(self, link: Link, made: tuple[str, bytes, str, tuple[str, bytes]] | None) -> None:
        if made is None:
            link.refuse("The run could not be shared")
            return
        name, content, lacks, (clip, film) = made
        film = film if len(film) <= _MOST_SENT else b""
        if len(content) <= _MOST_SENT:
            head = {"type": "shared", "name": name, "lacks": lacks, "clip": clip if film else ""}
            link.send(head, [film, content])
            return
        try:
            file = save("shared", Path(name).suffix, lambda file: write_whole(file, content))
            where = f"it is in {file}"
        except OSError as error:
            where = f"it could not be saved: {error}"
        link.refuse(f"The run is too large for the page: {where}")

    def _clip(self) -> tuple[str, bytes]:
        """Return the name and the content of the clip; empty content without frames."""
        from robsim.plotting.images.replay import annotated_frames
        from robsim.vision.imaging.video import load_av, save_small_video

        runner, trace = self.panel.runner, self.panel.record.trace
        assert isinstance(runner, Runner)
        rate = max(_LEAST_RATE, 1 / trace.info.dt)
        trace = trace[-int(_SECONDS * rate) :]
        drawn = annotated_frames(self._frames(trace.k), trace, simulation=runner)
        pictures = [_reduced(pixels) for pixels in drawn]
        if not pictures:
            return "", b""
        with TemporaryDirectory() as folder:
            try:
                load_av("a clip")
                file = Path(folder, "run.webm")
                save_small_video(file, pictures, fps=rate)
            except ImportError:
                file = Path(folder, "run.gif")
                Clip(pictures, fps=min(60.0, rate), width=_WIDTH).save(file)
            return file.name, file.read_bytes()

    def _frames(self, ks: Any) -> Iterator[Frame | None]:
        for k in map(int, ks):
            try:
                yield self.panel.driver.ask(partial(self.panel.record.frame, k))
            except LookupError:  # the camera's frame is lost, or the run was reset
                yield None


def _reduced(pixels: Pixels) -> Pixels:
    from robsim.vision.imaging.images import resized

    height, width = pixels.shape[:2]
    scale = min(1.0, _WIDTH / max(height, width))
    return resized(pixels, round(width * scale / 2) * 2, round(height * scale / 2) * 2)


def _told(runner: Simulation) -> tuple[Any, Any, dict[str, Any]]:
    """Return options, folder and overrides of its files; only messages of the panel change them."""
    return (runner._scenario, runner._seed), runner._folder, {**runner._given}


def _is_open(runner: Simulation, slot: str) -> bool:
    """Whether a file of the folder fills a slot."""
    return slot in runner._from_folder and runner._given[slot] in (None, True)


def _files(runner: Simulation) -> Mapping[str, bytes]:
    return runner._folder.sources if runner._folder is not None else _NO_FILES


_NO_FILES: Mapping[str, bytes] = {}
