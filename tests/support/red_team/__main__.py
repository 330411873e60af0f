"""Runs all attacks, and prints what came of each: what holds with the process alone, and why."""

from __future__ import annotations

import argparse
import tempfile
from contextlib import nullcontext
from pathlib import Path

from red_team import ATTACKS, HONEST, LAYERS, Attack
from red_team.ground import STEPS_AFTER, Ground, check_after, check_outcome, ground
from robsim.grading._isolation._processes.zygotes import close_zygotes
from small_machine import small_machine

NOT_COVERED = """\
Not covered by any attack here, nor by the grader:
- faults of the kernel and of the processor, side channels in time or caches;
- with the process alone (macOS; Linux without its layers): what reads or changes files, connects,
  starts processes, or signals others of the same user; those that would stop other processes are
  marked "not tried";
- masked modules that robsim itself needs in a worker (evaluation, vision, ...), and masked names:
  code that searches memory finds them; robsim.reference is not among them;
- samples of the truth, where an assignment lets a submission identify parameters from the truth:
  they go to submissions that fill the parameter estimator, and no other stage;
- public seeds: who knows the seed knows the noise; a copy of somebody else's solution."""


def outcome_of(attack: Attack, place: Ground, isolation: str) -> str:
    """Return what came of an attack, in a word or two."""
    if isolation == "process" and not attack.runs_bare:
        return "not tried"
    outcome = place.outcome(attack, isolation=isolation)
    try:
        check_outcome(attack, outcome, shut_in=isolation != "process")
    except AssertionError as error:
        return f"FAILS: {str(error)[:60]}"
    if isolation == "process" and outcome.reached:
        return "open"
    return "error" if outcome.error else "its own" if outcome.points else "no points"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m red_team", description=__doc__)
    parser.add_argument("--small", action="store_true", help="on half a core with 768 MB")
    parser.add_argument("names", nargs="*", help="attacks; default: all")
    options = parser.parse_args()
    chosen = [ATTACKS[name] for name in options.names] if options.names else [*ATTACKS.values()]
    with small_machine() if options.small else nullcontext("the whole machine") as machine:
        print(machine)
        try:
            show(chosen)
        finally:
            close_zygotes()
    print(NOT_COVERED)


def show(attacks: list[Attack]) -> None:
    """Run attacks, and print a line for each."""
    with tempfile.TemporaryDirectory() as folder, ground(Path(folder)) as place:
        first = {
            level: place.outcome(HONEST, isolation=level, steps=STEPS_AFTER)
            for level in ("auto", "process")
        }
        print(f"{'attack':<42}{'shut in':<12}{'process':<12}what it tries")
        for attack in attacks:
            said = {}
            for level, honest in first.items():
                before = place.left()
                said[level] = outcome_of(attack, place, level)
                if level == "process":
                    place.clear()
                assert honest.trace is not None, honest.error
                check_after(place, before, honest.trace, isolation=level)
            why = f" [{attack.why}]" if attack.held_by == LAYERS else ""
            print(f"{attack.name:<42}{said['auto']:<12}{said['process']:<12}{attack.about}{why}")


if __name__ == "__main__":
    main()
