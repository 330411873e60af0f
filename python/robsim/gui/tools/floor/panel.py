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
    """The panel that calibrates a floor; `robsim.gui.floor_panel` opens this panel.

    The methods have the same effects as the mouse, and any thread may call them. The end of a
    ``with`` block closes the panel, but not the camera or run that supplies the pictures.

    Examples
    --------
    >>> with robsim.gui.floor_panel() as tool:
    ...     tool.put([(230, 161), (569, 161), (634, 492), (165, 492)],
    ...              [(300, 300), (2100, 300), (2100, 2100), (300, 2100)])
    ...     print(tool.fill(300), "corners found, the fit is", tool.report.verdict)
    77 corners found, the fit is good
    """

    _maker = "robsim.gui.floor_panel"
    _view: FloorView

    @property
    def value(self) -> Calibration:
        """The current calibration; ValueError if it is incomplete. Assign to set it.

        The panel uses the lens and the work area of an assigned calibration, and also its floor
        until points are placed.
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
        """The fit of each point; ValueError if the calibration is incomplete."""
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
            Position in the picture: (u, v).
        position : tuple of float, optional
            Position on the floor (mm), from the top left corner of the work area. In the camera
            picture, x points right and y down. Default: not known yet; see `place`.
        reach : float
            If a dot or corner, for example of a tile, is within this distance (px), the point moves
            there. The accuracy is a tenth of a pixel.

        Returns
        -------
        int
            Number of the point.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type; nothing changes.
        """
        reach = check_float("reach", reach, "px", minimum=0)
        return self._change(lambda: self._view.add(pixel, position, reach))

    def put(self, pixels: ArrayLike, positions: ArrayLike) -> None:
        """Replace all points.

        Parameters
        ----------
        pixels : array (N, 2)
            Positions in the picture: (u, v).
        positions : array (N, 2)
            Positions on the floor (mm), as in `add`.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type or shape; nothing changes.
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
            New position in the picture: (u, v).

        Raises
        ------
        TypeError, ValueError
            If the point is unknown, or an argument has the wrong type.
        """
        self._change(lambda: self._view.points.move(point, pixel))

    def snap(self, point: int, *, reach: float = 12.0) -> None:
        """Move a point to the nearest dot or corner, for example of a tile.

        Parameters
        ----------
        point : int
            Its number.
        reach : float
            Largest distance of the corner (px).

        Raises
        ------
        TypeError, ValueError
            If the point is unknown, or there is no corner.
        """
        self._change(lambda: self._view.snap(point, reach))

    def place(self, point: int, position: tuple[float, float] | None) -> None:
        """Set the position of a point on the floor.

        Parameters
        ----------
        point : int
            Its number.
        position : tuple of float or None
            x and y (mm), as in `add`; None = not known.

        Raises
        ------
        TypeError, ValueError
            If the point is unknown, or an argument has the wrong type.
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
            If the point is unknown.
        """
        self._change(lambda: self._view.points.remove(point))

    def clear(self) -> None:
        """Remove all points."""
        self._change(self._view.points.clear)

    def fill(self, step: float) -> int:
        """Find the remaining corners of a regular grid in the picture, and add them.

        Parameters
        ----------
        step : float
            Side of the grid's squares, such as tiles (mm); the work area's origin is a corner.

        Returns
        -------
        int
            Number of found corners.

        Raises
        ------
        TypeError, ValueError
            If there are too few points to predict the corners, or the picture shows no corners.
        """
        return self._change(lambda: self._view.fill(step))

    def adjust(
        self,
        *,
        area: tuple[int, int] | None = None,
        mm_per_px: float | None = None,
        marker_height: float | None = None,
    ) -> None:
        """Set the work area and the height of the markers; omitted values stay unchanged.

        Parameters
        ----------
        area : tuple of int, optional
            Width and height of the work area (px).
        mm_per_px : float, optional
            Size of a work-area pixel on the floor (mm).
        marker_height : float, optional
            Height of the robot's markers above the floor (mm); requires a lens.

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
        """Calibrate with the floor sheets in the picture; return the fit of each sheet.

        Parameters
        ----------
        mark : float, optional
            Side of a mark, measured on the printed sheet (mm). Default: the current value,
            initially 80.
        places : mapping of int to tuple of float, optional
            Position of the cross of a sheet (mm), by sheet number. Default: as for
            `robsim.lab.calibrate_floor_by_sheets`.

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
        """Take the displayed picture for the calibration of the lens.

        Parameters
        ----------
        board : Chessboard or Charuco, optional
            The board in the picture. Default: the current board, initially the default chessboard.
            If a new board differs only in the side of its squares, earlier pictures remain valid.

        Returns
        -------
        int
            Number of corners in the picture.

        Raises
        ------
        ImportError
            If OpenCV is not installed.
        TypeError, ValueError
            If an argument has the wrong type, or the picture shows no board. Also raised if earlier
            pictures have another size or show another board: see `drop_boards`.
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
            Position in the list of taken pictures, from 0. Default: all.

        Raises
        ------
        TypeError, ValueError
            If the picture is unknown.
        """
        self._view.ask(lambda: self._view.lens.drop(picture))

    def calibrate_lens(self) -> LensCalibration:
        """Calibrate the lens from the taken pictures; return the fit of each picture.

        The floor is then calibrated through this lens.

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
            The file. Default: the panel's file.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        OSError
            If the file cannot be written.
        TypeError, ValueError
            If `path` is not a path to a ``.toml`` file, or something is missing. Also raised if an
            existing file is not a calibration, was not loaded here, or has another lens.
        """
        return self._view.ask(lambda: self._view.save(path))

    def __repr__(self) -> str:
        count = len(self._view.points.draft.points)
        return f"<robsim.gui.FloorPanel: {count} points>"
