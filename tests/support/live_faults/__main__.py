"""Runs rounds in processes of their own, and prints the table."""

import argparse
import faulthandler
import json
import signal
import subprocess
import sys
import tempfile
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor

from . import cameras, wired

HARD_LIMIT = 300  # s, for a round


def work(arguments):
    """Run rounds in this process; a line of JSON after each."""
    from .rounds import play

    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it
    options = arguments.seed, arguments.slack
    warm_up = [*((k, cameras.SOFTWARE) for k in (16, 17, 18, 20)), *((0, [k]) for k in wired.CAN)]
    for number, kinds in warm_up:  # so that what is made once is there
        if {*kinds} & {*arguments.cameras}:
            play(number, *options, kinds, patience=1)
    for number in arguments.only:
        faulthandler.dump_traceback_later(HARD_LIMIT, exit=True)
        print(json.dumps(play(number, *options, arguments.cameras)), flush=True)
        faulthandler.cancel_dump_traceback_later()


def run_rounds(left, arguments, results):
    """Run rounds in a process; where that dies, the round is a failure, and another one goes on."""

    def note(result):
        results.append(result)
        for failure in result["failures"]:
            print("FAILED round {round} ({fault}; {kind}):".format(**result), failure, flush=True)

    environment = wired.with_bus() if "firewire" in arguments.cameras else None
    command = [sys.executable, "-m", "live_faults", "--seed", str(arguments.seed)]
    command += ["--slack", str(arguments.slack), "--cameras", *arguments.cameras, "--work"]
    while left:
        words = [*command, "--only", *map(str, left)]
        with tempfile.TemporaryFile("w+") as errors:
            pipes = {"stdout": subprocess.PIPE, "stderr": errors, "text": True}
            with subprocess.Popen(words, env=environment, **pipes) as process:
                for line in process.stdout:
                    left.pop(0)
                    note(json.loads(line))
            errors.seek(0)
            died = f"the process died with {process.returncode}: {errors.read()[-6000:]}"
        if left:
            note({"round": left.pop(0), "fault": "?", "kind": "?", "failures": [died]})


def print_table(results):
    rows = defaultdict(list)
    for result in results:
        rows[result["fault"]].append(result)
    width = max(map(len, rows))
    print(f"{'fault':{width}} rounds  worst lateness (s)  failures")
    for fault, those in sorted(rows.items()):
        worst = max(one.get("late") or float("-inf") for one in those)
        failed = [one["round"] for one in those if one["failures"]]
        print(f"{fault:{width}} {len(those):6}  {worst:+18.3f}  {len(failed)}", *failed)


def main():
    parser = argparse.ArgumentParser(prog="live_faults")
    parser.add_argument("--rounds", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--slack", type=float, default=0.5, help="s that the machine may be late")
    parser.add_argument("--only", type=int, nargs="+", help="numbers of rounds to repeat")
    parser.add_argument(
        "--cameras", nargs="+", choices=cameras.CAN, default=cameras.SOFTWARE,
        help="kinds of them; firewire is the virtual bus, gige a server on loopback",
    )  # fmt: skip
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--work", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.work:
        work(arguments)
        return
    numbers, results = list(arguments.only or range(arguments.rounds)), []
    shares = [numbers[i :: arguments.workers] for i in range(arguments.workers)]
    with ThreadPoolExecutor(arguments.workers) as pool:
        list(pool.map(lambda share: run_rounds(share, arguments, results), shares))
    print_table(results)
    failed = sum(bool(result["failures"]) for result in results)
    print(f"{len(results)} rounds, {failed} failed")
    sys.exit(failed > 0 or len(results) < len(numbers))


if __name__ == "__main__":
    main()
