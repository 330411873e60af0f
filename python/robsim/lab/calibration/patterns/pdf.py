"""A page of PDF at true scale: black rectangles, lines and text, placed in mm."""

from __future__ import annotations

from dataclasses import dataclass

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
        """About how wide it is (mm)."""
        return 0.5 * self.size * len(self.text) * _MM


def pdf_page(
    size: tuple[float, float],
    rectangles: list[tuple[float, float, float, float]],
    texts: list[Text],
    title: str,
) -> bytes:
    """Return a PDF file of one page; a program that prints it is told not to scale it.

    Parameters
    ----------
    size : tuple of float
        Width and height of the paper (mm).
    rectangles : list of tuple of float
        Left, top, width and height of what is black (mm from the top left corner, y down).
    texts : list of Text
        Printable ASCII.
    title : str
        What viewers call it.
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
