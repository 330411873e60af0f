"""The view of the start page: it opens the run of a card, and sends films of the cards."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from robsim.gui._link import COMMON, Link, Messages, Refused, text
from robsim.gui._view import View

#: In the order of the page; `robsim.gui.start.cards` has their runs.
CARDS = ("drive", "noise", "identify", "estimate", "task", "laboratory")


class StartView(View):
    """Cards; `open_card` opens one. `kept` returns the number of steps of the kept run."""

    kind: ClassVar[str] = "start"
    messages: ClassVar[Messages] = {**COMMON, "open": {"card": text}, "resume": {}}

    def __init__(
        self, open_card: Callable[[str], None], resume: Callable[[], None], kept: Callable[[], str]
    ) -> None:
        super().__init__()
        self._open_card, self._resume, self._kept = open_card, resume, kept
        self._opening, self._filming = self.beside("robsim start"), self.beside("robsim film")
        self._films: list[tuple[Mapping[str, Any], list[bytes]]] = []

    def handlers(self) -> Mapping[str, Callable[[Link, dict[str, Any]], None]]:
        return {**super().handlers(), "open": self._open, "resume": lambda *_: self._resume()}

    def tell(self, link: Link) -> None:
        link.send({"type": "setup", "kept": self._kept()})
        for head, pictures in self._films:
            link.send(head, pictures)
        self._film()

    def parted(self) -> None:
        pass

    def snapshot(self) -> bytes:
        raise NotImplementedError("no notebook shows the start page")

    def _open(self, link: Link, message: dict[str, Any]) -> None:
        if (card := message["card"]) not in CARDS:
            raise Refused(f"card must be one of {', '.join(CARDS)}")
        if self._opening.is_busy:
            raise Refused("the previous card is still opening")

        def opened() -> str:
            try:
                self._open_card(card)
            except (OSError, ValueError, RuntimeError) as error:  # such as no free port
                return str(error)
            return ""

        self._opening.begin(opened, lambda why: self._has_opened(link, why))

    def _has_opened(self, link: Link, why: str | None) -> None:
        if why != "":
            link.send({"type": "refused"})
            link.refuse(why or "The card could not be opened")

    def _film(self) -> None:
        """Make the missing films, one after another."""
        if self._filming.is_busy or self._opening.is_busy or len(self._films) == len(CARDS):
            return
        card = CARDS[len(self._films)]

        def film() -> tuple[Mapping[str, Any], list[bytes]]:
            from robsim.gui.start.cards import film_of  # loads everything

            return film_of(card)

        self._filming.begin(film, self._take)

    def _take(self, film: tuple[Mapping[str, Any], list[bytes]] | None) -> None:
        if film is not None:
            self._films.append(film)
            self.send(film[0], *film[1])
            self._film()
