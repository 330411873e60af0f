"""Write signatures and docstrings from the rows of options and slots: `python write_options.py`.

These are the marked regions of `Simulation` and `Experiment`. In docstrings, also of `Scenario`,
they are the entries of options and slots; in the docstring of `Camera`, the codings of pixels.
"""

import re
import textwrap
from pathlib import Path

import robsim
from robsim.lab.cameras._devices import firewire, gige
from robsim.simulation.options import OPTIONS
from robsim.simulation.slots import SLOTS, AllCallbacks

FOLDER = Path(__file__).parents[2] / "python" / "robsim"
OF_SIMULATION = [name for name in OPTIONS if name not in SLOTS]
#: Options of an experiment with the same type and default as in a simulation.
OF_EXPERIMENT = ("robot", "seed", "colors", "markers", "smoothing", "model")
WIDTH, INDENT = 100 - 4, 4 * " "  # in a class


def annotation_of(slot):
    return f"slots.{AllCallbacks.__annotations__[slot].__forward_arg__}"


def arguments(names, default=None):
    """Return lines of a signature; without a common default, each option has its own."""
    own = {name: repr(OPTIONS[name].default) if default is None else default for name in names}
    return [f"{name}: {OPTIONS[name].annotation} = {own[name]}," for name in names]


def slot_arguments(names, defaults):
    return [f"{name}: {annotation_of(name)} = {defaults.get(name)}," for name in names]


def call(function, names):
    """Return a call that hands on arguments, in full lines."""
    lines = textwrap.wrap(" ".join(f"{name}={name}," for name in names), WIDTH - 8)
    return [f"{function}(", *(f"    {line}" for line in lines), ")  # fmt: skip"]


def entry(name, kind, doc):
    """Return the documentation of an argument."""
    lines = textwrap.wrap(doc, WIDTH - 4, break_on_hyphens=False)
    return [f"{name} : {kind}", *(f"    {line}" for line in lines)]


def option_entry(option):
    kind = option.kind or option.type_names
    kind += f" within {option.limits}" if option.limits else ""
    kind += ", optional" if option.default is None else " or None" if option.takes_none else ""
    return entry(option.name, kind, option.doc)


def slot_entry(slot):
    kind = "callable or bool" if slot.is_switch else "callable"
    return entry(slot.name, f"{kind}, optional", f"{slot.call}, {slot.doc}")


def live_property(name):
    """Return the property of an option that may change in the middle of a run."""
    option = OPTIONS[name]
    return [
        "@property",
        f"def {name}(self) -> {option.annotation}:",
        *textwrap.wrap(f'"""{option.doc}', WIDTH, initial_indent=INDENT, subsequent_indent=INDENT),
        "",
        "    A change applies from the next step on.",
        '    """',
        f"    return self._scenario.{name}",
        "",
        f"@{name}.setter",
        f"def {name}(self, {name}: {option.annotation}) -> None:",
        f"    self._change({name}={name})",
        "",
    ]


def documented(options=(), slots=()):
    entries = [option_entry(OPTIONS[name]) for name in options]
    entries += [slot_entry(SLOTS[name]) for name in slots]
    return [line for one in entries for line in one]


def with_region(text, name, lines):
    """Replace the lines after the mark of a region, up to its end."""
    pattern = re.compile(rf"^( *)# {name}: written by \./run stubs\n.*?^ *# end\n", re.M | re.S)
    (found,) = pattern.finditer(text)
    indent = found[1]
    marked = [f"# {name}: written by ./run stubs", *lines, "# end"]
    region = "".join(f"{indent}{line}".rstrip() + "\n" for line in marked)
    return text[: found.start()] + region + text[found.end() :]


def with_entries(text, first, after, lines):
    """Replace entries of a docstring: from one to another, or to the end of their section."""
    start = text.index(f"\n    {first} : ") + 1
    end = text.index(f"    {after} : " if after else "\n    Raises", start)
    return text[:start] + textwrap.indent("\n".join(lines) + "\n", "    ") + text[end:]


def simulation(text):
    stages = {name: "_SAME" for name in SLOTS if name in OPTIONS}
    text = with_entries(text, "robot", "time_limit", documented(OF_SIMULATION))
    text = with_entries(text, "define_model", None, documented(slots=SLOTS))
    text = with_region(text, "options", arguments(OF_SIMULATION, "_SAME"))
    text = with_region(text, "slots", slot_arguments(SLOTS, stages))
    live = [line for name in OPTIONS if OPTIONS[name].is_live for line in live_property(name)]
    text = with_region(text, "live", live)
    return with_region(text, "given", call("given = _given", [*OF_SIMULATION, *SLOTS]))


def experiment(text):
    own = robsim.Experiment.SLOTS
    text = with_entries(text, "robot", "area", documented(["robot"]))
    text = with_entries(text, "define_model", None, documented(slots=own))
    text = with_region(text, "options", arguments(OF_EXPERIMENT))
    text = with_region(text, "slots", slot_arguments(own, {"measure": True}))
    return with_region(text, "filled", call("self._fill_slots", own))


def scenario(text):
    return with_entries(text, "robot", None, documented(OPTIONS))


def camera(text):
    first, second = (", ".join(f'``"{name}"``' for name in bus.CODINGS) for bus in (firewire, gige))
    doc = (
        f"The camera's pixel coding: on FireWire one of {first}; on GigE one of {second}. "
        "Default: the first of these codings that the camera supports at its frame rate. ``raw8`` "
        "comes from behind a Bayer filter."
    )
    return with_entries(text, "coding", "features", entry("coding", "str, optional", doc))


def written(folder):
    """Return the new text of each file below the folder of the package."""
    makers = (simulation, experiment, scenario)
    files = {folder / "simulation" / f"{make.__name__}.py": make for make in makers}
    files[folder / "lab" / "cameras" / "camera.py"] = camera
    return {file: make(file.read_text()) for file, make in files.items()}


if __name__ == "__main__":
    for path, content in written(FOLDER).items():
        path.write_text(content)
