"""The slots of a simulation or an experiment, and their callbacks."""

from __future__ import annotations

import functools
import inspect
from abc import ABC
from collections.abc import Callable, Iterable
from os import PathLike
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, ParamSpec, Self, SupportsIndex

from numpy.typing import ArrayLike

from robsim import _core
from robsim._core import Step
from robsim.base.spelling import check_names, closest, no_attribute, with_article
from robsim.simulation import slots as table
from robsim.simulation.callbacks.checks import check_callback
from robsim.simulation.callbacks.signatures import CallTimes
from robsim.simulation.callbacks.slot import Slot
from robsim.simulation.slots import ROBOT, SLOTS, RobotSlots
from robsim.simulation.time_limit import TimeLimit
from robsim.trace import Trace

if TYPE_CHECKING:
    from robsim.simulation.callback_folder import CallbackFolder, Callbacks

P = ParamSpec("P")

#: Components that run in C++.
_NATIVE = tuple(kind for slot in SLOTS.values() for kind in slot.native)


class Slotted(RobotSlots, ABC):
    """An object with slots: given callbacks, their defaults, and a folder of callbacks."""

    #: The available slots.
    SLOTS: ClassVar[tuple[str, ...]] = table.names(half=ROBOT)

    #: How another one of the same kind is made, for messages.
    _AGAIN: ClassVar[str]

    _core: _core.Loop

    def __init__(self, time_limit: float | None) -> None:
        self._time_limit = None if time_limit is None else TimeLimit(time_limit)
        self._folder: CallbackFolder | None = None
        self._from_folder: Callbacks = {}
        self._call_times: CallTimes | None = None
        self._callbacks: dict[str, Any] = dict.fromkeys(self.SLOTS)
        self._given: dict[str, Any] = dict(self._callbacks)

    def _fill_slots(self, **given: Any) -> None:
        """Fill the slots with their given values, or the defaults."""
        self._given = {slot: given.get(slot) for slot in self.SLOTS}
        for slot, value in self._given.items():
            # A user's estimator has switched estimate_parameters on by then.
            if value is not None or self._callbacks[slot] is None:
                self._set_slot(slot, value)

    @classmethod
    def from_folder(
        cls,
        folder: str | PathLike[str],
        *,
        slots: str | Iterable[str] | None = None,
        **options: Any,
    ) -> Self:
        """Return a runner with the callbacks of a folder, as written by ``robsim new``.

        After a change of a file in the folder, the next run or reset reloads all files. If a file
        fails, the runner is unchanged. A callback given here for a slot, or ``"default"``,
        overrides the file; True does not: it applies if the file is missing or has ``ENABLED =
        False``.

        Parameters
        ----------
        folder : path
            The folder: ``control.py``, ``measure.py`` and so on, named after the slots.
        slots : str or iterable of str, optional
            The slots that the folder may fill; files for other slots are not even executed.
            Default: all slots of the class.
        **options
            The options of the class.

        Raises
        ------
        FileNotFoundError
            If the folder does not exist.
        ValueError
            If the folder has no callback files, a file does not define its callback, or a slot is
            unknown.
        SyntaxError
            If a file is not valid Python; the message has its name and the line.
        """
        from robsim.simulation.callback_folder import CallbackFolder

        wanted = cls.SLOTS if slots is None else table.checked_slots(slots, cls.SLOTS)
        runner = cls(**options)
        runner._folder = CallbackFolder(folder, wanted)
        runner._use(runner._folder.load())
        return runner

    def _use(self, callbacks: Callbacks) -> None:
        """Fill the slots with the callbacks of the folder."""
        for slot in self.SLOTS:
            is_fixed = slot in table.AT_START and self._core.has_started
            is_open = self._given[slot] is None or self._given[slot] is True
            if slot in self._from_folder | callbacks.keys() and is_open and not is_fixed:
                # A file that is switched off counts as missing.
                callback = callbacks.get(slot, False)
                self._set_slot(slot, self._given[slot] if callback is False else callback)
        self._from_folder = callbacks

    def _choose(self, slot: str, value: Any) -> None:
        """Fill a slot with a value that a changed file of the folder does not override."""
        self._set_slot(slot, value)
        self._given[slot] = table.DEFAULT if value is True else value

    def _choose_file(self, slot: str) -> None:
        """Fill a slot with the folder's callback, from now on."""
        self._set_slot(slot, self._from_folder[slot])
        self._given[slot] = None

    def _reload_folder(self) -> None:
        """Fill the slots again if a file of the folder has changed."""
        if self._folder is None or self._core.is_running or not (changed := self._folder.changed):
            return
        late = changed.intersection(table.AT_START)
        if late and self._core.has_started:
            raise RuntimeError(
                f"{min(late)}.py has changed, but the file runs only at the start of a simulation: "
                "call sim.reset() first, or press Reset in a panel"
            )
        self._use(self._folder.load_saved())

    def __setattr__(self, name: str, value: Any) -> None:
        descriptor = getattr(type(self), name, None)
        is_known = name.startswith("_") or isinstance(descriptor, Slot)
        if isinstance(descriptor, property):
            if descriptor.fset is None:
                raise AttributeError(f"{name} cannot be set{_ADVICE.get(name, '')}")
            is_known = True
        if "_core" in self.__dict__ and not is_known:
            raise AttributeError(self._why_not_set(name, is_method=callable(descriptor)))
        super().__setattr__(name, value)

    def _why_not_set(self, name: str, *, is_method: bool) -> str:
        """Return the message for an attribute that cannot be set."""
        kind = type(self).__name__
        if name in inspect.signature(type(self)).parameters:
            return f"{name} is fixed: set it in {kind}({name}=...)"
        if is_method:
            return f"{name} is a method of {kind} and cannot be set: call sim.{name}(...)"
        settable = [
            known
            for known in dir(type(self))
            if isinstance(one := getattr(type(self), known), property) and one.fset
        ]
        meant = None if name in SLOTS else closest(name, (*self.SLOTS, *settable))
        hint = f"did you mean {meant!r}?" if meant else f"known: {', '.join(self.SLOTS)}"
        return f"{kind} has no slot {name!r}: {hint}"

    def __getattr__(self, name: str) -> Any:
        # Only for missing attributes. Python itself looks up underscored names.
        kind = type(self)
        if name.startswith("_") or hasattr(kind, name):
            # A property that raised AttributeError itself raises it again.
            return object.__getattribute__(self, name)
        public = [known for known in dir(kind) if not known.startswith("_")]
        for place, other in (("sim.last_step.", Step), ("sim.trace.", Trace)):
            if hasattr(other, name):
                hint = f"did you mean {place}{name}?"
                raise no_attribute(f"{kind.__name__} has no attribute {name!r}: {hint}")
        said = f"{kind.__name__} has no attribute {name!r}"
        if hasattr(Trace, f"{name}_true"):
            raise no_attribute(f"{said}; did you mean 'sim.trace.{name}_true'?")
        raise no_attribute(said, name, public)

    def __reduce_ex__(self, protocol: SupportsIndex) -> NoReturn:
        kind = type(self).__name__
        raise TypeError(
            f"{with_article(kind)} cannot be copied or pickled, because its callbacks and its run "
            f"belong to this process: make another {kind}, {self._AGAIN}"
        )

    def _set_slot(self, slot: str, callback: Any) -> None:
        if slot in table.AT_START and self._core.has_started:
            raise RuntimeError(
                f"{slot} runs only at the start of a simulation: call sim.reset() first"
            )
        asks_for_default = table.is_default(slot, callback)
        value = self._default(slot) if callback is None or asks_for_default else callback
        if asks_for_default and SLOTS[slot].is_switch:
            value = True
        check_callback(slot, value)
        self._put(slot, value)
        self._callbacks[slot] = value
        self._slots_changed()
        update = self._callbacks["estimate_parameters"]
        if slot == "init_parameter_estimator" and value and (update is None or update is True):
            # An estimator of the user's is meant to be used.
            self._set_slot("estimate_parameters", True)

    def _slots_changed(self) -> None:
        """Forget the data that depends on the slots."""

    def _is_on(self, slot: str) -> bool:
        """Return whether a slot is filled, and not off."""
        value = self._callbacks[slot]
        return value is not None and value is not False

    def _default(self, slot: str) -> Any:
        """Return the default of an empty slot; None = the core's own default."""
        return None

    def _put(self, slot: str, value: Any) -> None:
        self._core.set_slot(slot, self._called(slot, self._stage(slot, value)))

    def _stage(self, slot: str, callback: Any) -> Any:
        """Return the stage that the C++ core gets for a callback."""
        is_users = slot == "estimate_parameters" and self._callbacks["init_parameter_estimator"]
        if callback is True and is_users and (self._time_limit or self._call_times):
            return _update_estimator  # in Python, where it is limited and timed
        return callback

    def _called(self, slot: str, callback: Any) -> Any:
        """Return a callback ready to call: with the time limit, and timed."""
        if not is_code(callback):  # native stages need neither
            return callback
        if self._time_limit is not None:
            callback = self._time_limit.limited(callback, slot)
        return self._call_times.timed(slot, callback) if self._call_times else callback

    def _time_calls(self, times: CallTimes | None) -> None:
        """Have the calls of all callbacks timed; None = no longer."""
        self._call_times = times
        self._put_again()

    def _limit_calls(self, limit: TimeLimit | None) -> None:
        """Have the calls of all callbacks limited; None = no longer."""
        self._time_limit = limit
        self._put_again()

    def _put_again(self) -> None:
        for slot, value in self._callbacks.items():
            is_over = slot in table.AT_START and self._core.has_started
            if not is_over and (value is True or is_code(value)):
                self._put(slot, value)


#: Alternatives to setting a property.
_ADVICE = {"model": ": fill define_model, then call sim.reset()"}


def suggests_names(init: Callable[P, None]) -> Callable[P, None]:
    """Return an ``__init__`` that suggests the closest known name for an unknown one."""
    known = [*inspect.signature(init).parameters][1:]

    @functools.wraps(init)
    def checked(*args: P.args, **options: P.kwargs) -> None:
        check_names(f"{type(args[0]).__name__} has no option", options, known, TypeError)
        init(*args, **options)

    return checked


def is_code(value: Any) -> bool:
    return callable(value) and type(value) not in _NATIVE


def _update_estimator(step: Step) -> ArrayLike | None:
    """Update the user's estimator: the stage estimate_parameters=True in Python."""
    if step.sample is None:
        return None
    update: ArrayLike = step.estimator.update(step.sample.phi, step.sample.y)
    return update
