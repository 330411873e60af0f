"""`FloorPanel`: the users' side of the panel that calibrates a floor."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path

from numpy.typing import ArrayLike

from robsim.base.checks import check_float, check_kind
from robsim.base.text import quoted
from robsim.gui.tools.floor.view import FloorView
from robsim.gui.tools.panel import ToolPanel
from robsim.lab.calibration.floor import checked_places
from robsim.lab.calibration.floor_report import FloorCalibration
from robsim.lab.calibration.lens_report import LensCalibration
from robsim.lab.calibration.patterns.boards import Charuco, Chessboard
from robsim.vision.imaging.calibration import Calibration


class FloorPanel(ToolPanel):
    """The panel that calibrates a floor; `robsim.gui.floor_panel` makes it.

    What its mouse does can be done by its methods, from any thread. A context closes it at its end;
    what it looked at stays open.
    """

    _maker = "robsim.gui.floor_panel"
    _view: FloorView

    @property
    def value(self) -> Calibration:
        """The calibration as it is now; a ValueError says what is missing. It can be set.

        Set, its lens and its work area are taken, and its floor until points are placed.
        """
        return self._view.ask(self._view.calibration)

    @value.setter
    def value(self, calibration: Calibration) -> None:
        check_kind("value", calibration, Calibration)

        def take() -> None:
            self._view.points.clear()
            self._view.use("points")
            self._view.take(calibration)

        self._change(take)

    @property
    def report(self) -> FloorCalibration:
        """How well each point fits; a ValueError says what is missing."""
        return self._view.ask(self._view.fit_report)

    # Points.

    def add(
        self,
        pixel: tuple[float, float],
        position: tuple[float, float] | None = None,
        *,
        reach: float = 0.0,
    ) -> int:
        """Add a point.

        Parameters
        ----------
        pixel : tuple of float
            Where it is in the picture: (u, v).
        position : tuple of float, optional
            Where it is on the floor, from the top left corner of the work area, x to the right and
            y down as the camera sees it (mm). Default: not known yet; see `place`.
        reach : float
            If there is a corner, such as of a tile, or a dot within so many pixels, it is put
            there, to a tenth of a pixel.

        Returns
        -------
        int
            Its number.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type; nothing is changed then.
        """
        reach = check_float("reach", reach, "px", minimum=0)
        return self._change(lambda: self._view.add(pixel, position, reach))

    def put(self, pixels: ArrayLike, positions: ArrayLike) -> None:
        """Place points in place of all that there are.

        Parameters
        ----------
        pixels : array (N, 2)
            Where they are in the picture: (u, v).
        positions : array (N, 2)
            Where they are on the floor (mm), as in `add`.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type or shape; nothing is changed then.
        """

        def put() -> None:
            self._view.points.put(pixels, positions)
            self._view.use("points")

        self._change(put)

    def move(self, point: int, pixel: tuple[float, float]) -> None:
        """Move a point.

        Parameters
        ----------
        point : int
            Its number.
        pixel : tuple of float
            Where it is in the picture: (u, v).

        Raises
        ------
        TypeError, ValueError
            If there is no such point, or an argument has the wrong type.
        """
        self._change(lambda: self._view.points.move(point, pixel))

    def snap(self, point: int, *, reach: float = 12.0) -> None:
        """Move a point to the nearest corner, such as of a tile, or dot.

        Parameters
        ----------
        point : int
            Its number.
        reach : float
            Up to how far off it is looked for (px).

        Raises
        ------
        TypeError, ValueError
            If there is no such point, or no corner.
        """
        self._change(lambda: self._view.snap(point, reach))

    def place(self, point: int, position: tuple[float, float] | None) -> None:
        """Say where a point is on the floor.

        Parameters
        ----------
        point : int
            Its number.
        position : tuple of float or None
            x and y (mm), as in `add`; None = not known.

        Raises
        ------
        TypeError, ValueError
            If there is no such point, or an argument has the wrong type.
        """
        self._change(lambda: self._view.points.place(point, position))

    def remove(self, point: int) -> None:
        """Remove a point.

        Parameters
        ----------
        point : int
            Its number.

        Raises
        ------
        TypeError, ValueError
            If there is no such point.
        """
        self._change(lambda: self._view.points.remove(point))

    def clear(self) -> None:
        """Remove all points."""
        self._change(self._view.points.clear)

    def fill(self, step: float) -> int:
        """Add the corners that the picture has where those of a regular grid are expected.

        Parameters
        ----------
        step : float
            Side of its squares, such as of tiles (mm); a corner is in the origin of the work area.

        Returns
        -------
        int
            How many were found.

        Raises
        ------
        TypeError, ValueError
            If there are too few points yet to tell where they are expected, or none was found.
        """
        return self._change(lambda: self._view.fill(step))

    def adjust(
        self,
        *,
        area: tuple[int, int] | None = None,
        mm_per_px: float | None = None,
        marker_height: float | None = None,
    ) -> None:
        """Set the work area, and how high the markers are; what is not given stays.

        Parameters
        ----------
        area : tuple of int, optional
            Width and height of the work area (px).
        mm_per_px : float, optional
            A px of the work area on the floor (mm).
        marker_height : float, optional
            How high above the floor the robot's markers are (mm); needs a lens.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type, or is out of range.
        """
        adjust = self._view.points.adjust
        self._change(lambda: adjust(area=area, mm_per_px=mm_per_px, marker_height=marker_height))

    # Sheets.

    def find_sheets(
        self, *, mark: float | None = None, places: Mapping[int, tuple[float, float]] | None = None
    ) -> FloorCalibration:
        """Calibrate by the floor sheets that the picture shows; return how well each sheet fits.

        Parameters
        ----------
        mark : float, optional
            Side of a mark on the sheets, measured on the print (mm). Default: as it is; at first
            80.
        places : mapping of int to tuple of float, optional
            Where the cross of a sheet lies (mm), by its number. Default: as
            `robsim.lab.calibrate_floor_by_sheets` has it.

        Raises
        ------
        ImportError
            If OpenCV is not installed.
        TypeError, ValueError
            If an argument has the wrong type, or there is no sheet.
        """
        where = checked_places(places)

        def find() -> FloorCalibration:
            sheets = self._view.sheets
            if mark is not None:
                sheets.adjust(mark)
            self._view.find_sheets()
            for number, (x, y) in where.items():
                sheets.place(number, x, y)
            return self._view.fit_report()

        return self._change(find)

    # The lens.

    def take_board(self, board: Chessboard | Charuco | None = None) -> int:
        """Take the picture that is shown for the calibration of the lens.

        Parameters
        ----------
        board : Chessboard or Charuco, optional
            What it shows. Default: as it is; at first the default chessboard. If only the side of
            its squares is another one than before, the pictures that were taken count as before.

        Returns
        -------
        int
            How many corners it shows.

        Raises
        ------
        ImportError
            If OpenCV is not installed.
        TypeError, ValueError
            If an argument has the wrong type, there is no board in the picture, or those that were
            taken have another size, or show another board: see `drop_boards`.
        """
        if not (board is None or isinstance(board, (Chessboard, Charuco))):
            raise TypeError(f"board must be a Chessboard or a Charuco, got {quoted(board)}")
        lens = self._view.lens

        def take() -> int:
            if board is not None:
                lens.begin(board)
            return lens.take_now()

        return self._view.ask(take)

    def drop_boards(self, picture: int | None = None) -> None:
        """Forget pictures of the board.

        Parameters
        ----------
        picture : int, optional
            Which one, by its place among those that were taken, from 0. Default: all.

        Raises
        ------
        TypeError, ValueError
            If there is no such picture.
        """
        self._view.ask(lambda: self._view.lens.drop(picture))

    def calibrate_lens(self) -> LensCalibration:
        """Calibrate the lens by the pictures that were taken; return how well it fits each.

        The floor is calibrated through it.

        Raises
        ------
        ValueError
            If fewer than four pictures were taken.
        """
        lens = self._view.lens

        def fit() -> LensCalibration:
            found = lens.fit_now()
            self._view.take(found.calibration)
            return found

        return self._view.ask(fit)

    # The picture.

    def save(self, path: str | PathLike[str] | None = None) -> Path:
        """Write the calibration into a file, as ``robsim calibrate`` does.

        Parameters
        ----------
        path : path, optional
            The file. Default: that of the panel.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        OSError
            If it cannot be written.
        TypeError, ValueError
            If `path` is no path to a ``.toml`` file, or something is missing. If the file exists:
            if it is no calibration, is unknown to this panel, or has another lens.
        """
        return self._view.ask(lambda: self._view.save(path))

    def __repr__(self) -> str:
        count = len(self._view.points.draft.points)
        return f"<robsim.gui.FloorPanel: {count} points>"
