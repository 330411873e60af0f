"""The lens, from pictures of a board taken one after the other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from robsim.base.checks import check_bool, check_int
from robsim.base.text import quoted
from robsim.gui.tools.pictures import Picture, Pictures
from robsim.gui.tools.tool import Acts
from robsim.lab.calibration.lens_report import LensCalibration
from robsim.lab.calibration.patterns.boards import Charuco, Chessboard
from robsim.lab.calibration.patterns.pattern import Corners
from robsim.lab.calibration.patterns.unseen import why_unseen
from robsim.lab.calibration.taking import BoardPictures, BoardTaker
from robsim.vision.imaging import images

if TYPE_CHECKING:
    from robsim.gui.tools.floor.view import FloorView

_MOST = 60  # pictures
_MOST_OF_A_FILM = 40  # neighbours in a video are similar

Board = Chessboard | Charuco
_PATTERNS: dict[str, type[Chessboard] | type[Charuco]] = {
    "chessboard": Chessboard,
    "charuco": Charuco,
}


class LensPictures:
    """Takes a view's pictures of a board, and calibrates the lens; long work has its own thread."""

    def __init__(self, view: FloorView) -> None:
        self.taken = BoardPictures(Chessboard())
        self.report: LensCalibration | None = None
        self.watches = False
        self._view = view
        self._taker: BoardTaker | None = None
        self._asked: Picture | None = None
        self._film: Pictures | None = None
        self._waiting: list[int] = []  # numbers of its pictures that still wait
        self._fitted = self.taken
        self._wrong = ""
        self._finding = view.beside("robsim board")
        self._fitting = view.beside("robsim lens")

    def acts(self) -> Acts:
        """Return the actions of messages."""
        return {
            "board": lambda m: self.choose(m["pattern"], m["columns"], m["rows"], m["square"]),
            "take": lambda _: self.take(),
            "take_all": lambda _: self.take_all(),
            "watch": lambda m: self.watch(m["on"]),
            "drop": lambda m: self.drop(m["picture"]),
            "use_lens": lambda _: self.use(),
        }

    def message(self) -> dict[str, Any]:
        """Return the data for the browsers."""
        report = self.report
        known = {} if report is None else {one.name: one for one in report.pictures}
        return {
            "type": "board",
            "pattern": "charuco" if isinstance(self.board, Charuco) else "chessboard",
            "columns": self.board.columns,
            "rows": self.board.rows,
            "square": self.board.square,
            "watches": self.watches,
            "busy": self.is_busy,
            "pictures": [
                {
                    "name": name,
                    "corners": len(seen.pixels),
                    "rms": known[name].rms if name in known else None,
                    "used": known[name].is_used if name in known else True,
                }
                for name, seen in self.taken.corners.items()
            ],
            "pixels": [
                pixel for one in self.taken.corners.values() for pixel in one.pixels.tolist()
            ],
            "empty": self.taken.empty_parts,
            "rms": None if report is None else report.rms,
            "verdict": None if report is None else report.verdict,
            "problems": self._problems(),
        }

    @property
    def is_busy(self) -> bool:
        return self._finding.is_busy or self._fitting.is_busy or bool(self._waiting)

    @property
    def board(self) -> Board:
        return self.taken.board

    # Changes.

    def choose(self, pattern: str, columns: int, rows: int, square: float) -> None:
        """Set the board, like `begin`, from its pattern and sizes."""
        if pattern not in _PATTERNS:
            raise ValueError(
                f"pattern must be one of {', '.join(_PATTERNS)}, got {quoted(pattern)}"
            )
        try:
            self.begin(_PATTERNS[pattern](columns, rows, square=square))
        finally:
            self._tell()  # the current board

    def begin(self, board: Board) -> None:
        """Set the board; ValueError if taken pictures show another board.

        If only the side of the squares differs, the pictures remain valid.
        """
        before, self.taken = self.taken, self.taken.of(board)
        if not before.may_show(board):
            self._taker, self._waiting = None, []
        self._changed()

    def take_now(self) -> int:
        """Take the displayed picture, and wait; return its number of corners."""
        picture = self._view.shown
        self._refuse_more()
        found = self.board.find(picture.frame.image)
        if found is None:
            why = why_unseen(self.board, picture.frame.image)
            raise ValueError(f"no board in {picture.name}: {why}")
        self._keep(picture, found, self.board)
        return len(found.pixels)

    def fit_now(self) -> LensCalibration:
        """Return the lens from the taken pictures, without waiting for other threads."""
        if self.report is None or self._fitted is not self.taken:
            found = self._fit(self.taken)
            self._fitted = self.taken
            self.report = found if isinstance(found, LensCalibration) else None
            self._wrong = found if isinstance(found, str) else ""
            self._tell()
        if self.report is None:
            raise ValueError("; ".join(self._problems()))
        return self.report

    def take(self) -> None:
        """Take the displayed picture."""
        picture = self._view.shown
        self._refuse_more()
        if self._finding.is_busy:
            self._asked = picture  # the next picture to process
        else:
            self._look_at(picture)
        self._tell()

    def take_all(self) -> None:
        """Take the pictures of a recording: all, or an evenly spread selection of many."""
        count = self._view.source.count
        if not count:
            raise ValueError("these pictures are not a recording: take them one by one")
        self._refuse_more()
        self._film = self._view.source
        self._waiting = [*range(0, count, math.ceil(count / _MOST_OF_A_FILM))]
        self._next()
        self._tell()

    def watch(self, on: bool) -> None:
        """Take live pictures automatically, whenever the board rests in a new position."""
        self.watches = False
        try:
            if check_bool("on", on):
                self._refuse_more()
            if on and not self._view.source.is_live:
                raise ValueError("these pictures are not live: take them one by one")
            self.watches = on
        finally:
            self._tell()

    def drop(self, number: int | None) -> None:
        """Forget a picture, by its position in the list, from 0; None = all."""
        if number is None:
            self.taken = BoardPictures(self.board)
        else:
            number = check_int("picture", number, minimum=0, maximum=_MOST)
            if number >= len(self.taken):
                raise ValueError(f"unknown picture {number}")
            self.taken = self.taken.without(number)
        if not self.taken:
            self._taker, self._waiting = None, []
        self._changed()

    def use(self) -> None:
        """Use this lens for the calibration of the floor."""
        if self.report is None or self._fitted is not self.taken:
            raise ValueError(self._wrong or "; ".join(self._problems()) or "it is not ready yet")
        self._view.take(self.report.calibration)

    def changed_picture(self) -> None:
        """Look at a new picture, if boards are taken automatically."""
        picture = self._view.picture
        is_watched = self.watches and not self._view.is_replaced
        if is_watched and picture is not None and not self.is_busy:
            self._look_at(picture, is_asked=False)

    # How.

    def _refuse_more(self) -> None:
        if len(self.taken) >= _MOST:
            raise ValueError(f"there are already {_MOST} pictures, the maximum")

    def _look_at(self, picture: Picture, *, is_asked: bool = True) -> None:
        board, image = self.board, picture.frame.image
        if not is_asked:
            self._taker = self._taker or BoardTaker(board, images.frame_size(image))
            board = self._taker.board
        look = board.find if is_asked or self._taker is None else self._taker.look

        def find() -> Corners | str | None:
            try:
                found = look(image)
                if found is None and is_asked:
                    return f"no board in {picture.name}: {why_unseen(board, image)}"
                return found
            except ImportError as error:
                return str(error)

        def take(found: Corners | str | None) -> None:
            if self.taken.may_show(board):
                self._take(picture, found, board, is_asked=is_asked)
            asked, self._asked = self._asked, None
            if asked is not None:
                self._look_at(asked)
            elif self._waiting:
                self._next()

        self._finding.begin(find, take)

    def _take(
        self, picture: Picture, found: Corners | str | None, board: Board, *, is_asked: bool
    ) -> None:
        if isinstance(found, Corners):
            try:
                self._keep(picture, found, board)
            except ValueError as error:
                if is_asked:
                    self._waiting = []
                else:
                    self.watches = False
                self._view.note(str(error))
                self._tell()
            return
        if isinstance(found, str):
            self.watches = self.watches and is_asked
            self._view.note(found)
        if is_asked or found is not None:
            self._tell()

    def _keep(self, picture: Picture, found: Corners, board: Board) -> None:
        """Take a picture with its corners; ValueError if it does not fit the other pictures."""
        self._refuse_more()
        size = images.frame_size(picture.frame.image)
        self.taken = self.taken.with_picture(picture.name, size, found, board)
        self._changed()

    def _next(self) -> None:
        if self._waiting and self._film is not None and not self._finding.is_busy:
            k = self._waiting.pop(0)
            try:
                self._look_at(self._film.at(k))
            except (OSError, ValueError, IndexError) as error:
                self._waiting = []
                self._view.note(str(error))

    def _changed(self) -> None:
        self._fit_soon()
        self._tell()

    def _fit_soon(self) -> None:
        taken = self.taken
        if self._fitting.is_busy or taken is self._fitted:
            return
        if taken.lacking:
            self.report, self._wrong, self._fitted = None, "", taken
            return

        def done(found: LensCalibration | str | None) -> None:
            if self._fitted is self.taken:  # `fit_now` was faster
                self._tell()
                return
            self._fitted = taken
            self.report = found if isinstance(found, LensCalibration) else None
            self._wrong = found if isinstance(found, str) else ""
            self._changed()

        self._fitting.begin(lambda: self._fit(taken), done)

    def _fit(self, taken: BoardPictures) -> LensCalibration | str:
        """Return the lens from pictures, or the reason for its absence; any thread."""
        try:
            return "" if taken.lacking else taken.lens()
        except ValueError as error:
            return str(error)

    def _problems(self) -> list[str]:
        if lacking := self.taken.lacking:
            return [lacking]
        if self.report is None:
            return [self._wrong] if self._wrong else []
        return [one.sentence for one in self.report.problems]

    def _tell(self) -> None:
        self._view.send(self.message())
