"""`save_sheet`: a pattern as a PDF page at true scale."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike

from robsim.base.checks import check_choice
from robsim.base.files import as_path, write_whole
from robsim.base.text import one_line, quoted
from robsim.lab.calibration.patterns.boards import Charuco, Chessboard
from robsim.lab.calibration.patterns.floor_sheet import FloorSheet
from robsim.lab.calibration.patterns.pattern import Rectangle

_POINTS = 72 / 25.4  # of PDF, for one mm
_MM = 25.4 / 72


@dataclass(frozen=True)
class Text:
    """A line of text, from the left end of its base line (mm), in letters of `size` pt."""

    x: float
    y: float
    text: str
    size: float = 9.0

    @property
    def width(self) -> float:
        """Approximate width (mm)."""
        return 0.5 * self.size * len(self.text) * _MM


def pdf_page(
    size: tuple[float, float],
    rectangles: list[tuple[float, float, float, float]],
    texts: list[Text],
    title: str,
) -> bytes:
    """Return a PDF file of one page, which programs should print without scaling.

    The size is the paper's (mm). Each black rectangle has left, top, width and height (mm from the
    top left corner, y down). Texts are printable ASCII; viewers show the title.
    """
    width, height = size
    lines = ["0 g", f"{_POINTS:.10f} 0 0 {_POINTS:.10f} 0 0 cm"]  # from here on in mm
    lines += [
        f"{left:.4f} {height - top - tall:.4f} {wide:.4f} {tall:.4f} re f"
        for left, top, wide, tall in rectangles
    ]
    lines += [
        f"BT /F1 {text.size * _MM:.4f} Tf {text.x:.4f} {height - text.y:.4f} Td "
        f"({_escaped(text.text)}) Tj ET"
        for text in texts
    ]
    content = "\n".join(lines).encode("ascii")
    box = f"[0 0 {width * _POINTS:.4f} {height * _POINTS:.4f}]"
    return _file(
        [
            b"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
            b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
            f"<< /Type /Page /Parent 2 0 R /MediaBox {box} /Contents 4 0 R "
            "/Resources << /Font << /F1 5 0 R >> >> >>".encode("ascii"),
            b"<< /Length %d >>\nstream\n%s\nendstream" % (len(content), content),
            b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
            f"<< /Title ({_escaped(title)}) /Creator (robsim) >>".encode("ascii"),
        ]
    )


def _escaped(text: str) -> str:
    return text.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")


def _file(objects: list[bytes]) -> bytes:
    """Return the file of numbered objects: the first is the catalogue, the last the title."""
    content = b"%PDF-1.4\n"
    offsets = []
    for number, body in enumerate(objects, start=1):
        offsets.append(len(content))
        content += b"%d 0 obj\n%s\nendobj\n" % (number, body)
    table = b"".join(b"%010d 00000 n \n" % offset for offset in offsets)
    count = len(objects) + 1
    return (
        content
        + b"xref\n0 %d\n0000000000 65535 f \n%s" % (count, table)
        + b"trailer\n<< /Size %d /Root 1 0 R /Info %d 0 R >>\n" % (count, len(objects))
        + b"startxref\n%d\n%%%%EOF\n" % len(content)
    )


#: Width and height (mm), landscape.
PAPERS = {
    "A4": (297.0, 210.0),
    "A3": (420.0, 297.0),
    "A2": (594.0, 420.0),
    "A1": (841.0, 594.0),
    "A0": (1189.0, 841.0),
    "letter": (279.4, 215.9),
}
_EDGE = 5.0  # mm that no printer prints on
_RULER = 100.0  # mm
_THIN = 0.4
_LABELS = 11.0  # mm below the pattern, for ruler and text


def save_sheet(
    path: str | PathLike[str], pattern: Chessboard | Charuco | FloorSheet, *, paper: str = "A4"
) -> None:
    """Write a sheet to print: the pattern at true scale, and a line of 100 mm to check the print.

    Parameters
    ----------
    path : path
        The PDF file to write.
    pattern : Chessboard, Charuco or FloorSheet
        The pattern to print.
    paper : str
        ``"A4"``, ``"A3"``, ``"A2"``, ``"A1"``, ``"A0"`` or ``"letter"``; landscape.

    Raises
    ------
    ImportError
        If the pattern has marks, and OpenCV is not installed.
    OSError
        If the file cannot be written.
    TypeError, ValueError
        If an argument has another type, or the pattern does not fit on the paper.

    Examples
    --------
    >>> import pathlib
    >>> robsim.lab.save_sheet("board.pdf", robsim.lab.Chessboard(columns=8, rows=6, square=25))
    >>> pathlib.Path("board.pdf").read_bytes()[:5]
    b'%PDF-'
    """
    file = as_path(path)
    if file.suffix.lower() != ".pdf":
        raise ValueError(f"{one_line(file)}: the file name must end in .pdf")
    if not isinstance(pattern, (Chessboard, Charuco, FloorSheet)):
        raise TypeError(
            f"pattern must be a Chessboard, a Charuco or a FloorSheet, got {quoted(pattern)}"
        )
    page = PAPERS[check_choice("paper", paper, tuple(PAPERS))]
    rectangles, texts = page_of(pattern, page, paper)
    write_whole(file, pdf_page(page, rectangles, texts, f"robsim: {pattern.label}"))


def page_of(
    pattern: Chessboard | Charuco | FloorSheet, page: tuple[float, float], paper: str
) -> tuple[list[Rectangle], list[Text]]:
    """Return the black areas of a page (mm from its top left corner), and its texts."""
    (width, height), (wide, tall) = page, pattern.size
    # A white border all around, because otherwise the outermost squares are not found.
    if wide > width - 2 * _EDGE or tall > height - 2 * _EDGE - _LABELS:
        raise ValueError(
            f"pattern must fit on {paper}, at most {width - 2 * _EDGE:g} x "
            f"{height - 2 * _EDGE - _LABELS:g} mm, got {wide:g} x {tall:g} mm: take fewer or "
            "smaller squares, or a larger paper"
        )
    left, top = (width - wide) / 2, (height - _LABELS - tall) / 2
    black = [(left + x, top + y, w, h) for x, y, w, h in pattern.rectangles]
    line = height - _EDGE - 2.5  # of the ruler
    black += _ruler(_EDGE + 5, line)
    words = "this line is 100 mm long: print at 100 %, not 'fit to page', and measure it"
    texts = [
        Text(_EDGE + 5 + _RULER + 4, line + 1, words, 8),
        Text(_EDGE + 5, line - 3.5, f"robsim, {pattern.label} (mm); glue it on something flat", 8),
    ]
    if isinstance(pattern, FloorSheet):
        texts[1] = Text(
            _EDGE + 5,
            line - 3.5,
            f"robsim, {pattern.label} (mm); tape it flat on the floor. x of the floor: to the "
            "right; its place: the cross in the middle",
            8,
        )
        black += _cross(left + wide / 2, top + tall / 2)
    return black, texts


def _ruler(left: float, y: float) -> list[Rectangle]:
    """Return a line of 100 mm with ticks at each 10 mm; its ends are the outer edges."""
    ticks = [(left + mark - _THIN / 2, y - 2, _THIN, 2.0) for mark in range(10, 100, 10)]
    ends = [(left, y - 2.5, _THIN, 3.5), (left + _RULER - _THIN, y - 2.5, _THIN, 3.5)]
    return [(left, y - _THIN / 2, _RULER, _THIN), *ticks, *ends]


def _cross(x: float, y: float) -> list[Rectangle]:
    return [(x - 4, y - 0.15, 8, 0.3), (x - 0.15, y - 4, 0.3, 8)]
