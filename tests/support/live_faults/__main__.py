"""Runs rounds in processes of their own, and prints the table."""

import argparse
import faulthandler
import json
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import defaultdict

from . import cameras, wired

HARD_LIMIT = 300  # s, for a round


def work(numbers, seed, slack, kinds):
    """Run rounds in this process; a line of JSON before and after each."""
    from . import children, rounds

    # What a shell starts in the background ignores it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if not all(map(children.is_turn, numbers)):
        for number in range(16, 20):
            rounds.play(number, seed, slack, patience=1)  # so that what is made once is there
        for kind in set(kinds) & set(wired.KINDS):
            rounds.play(0, seed, slack, [kind], patience=1)
    for number in numbers:
        print(json.dumps({"begins": number}), flush=True)
        faulthandler.dump_traceback_later(HARD_LIMIT, exit=True)
        play = children.play if children.is_turn(number) else rounds.play
        print(json.dumps(play(number, seed, slack, kinds)), flush=True)
        faulthandler.cancel_dump_traceback_later()


class Worker(threading.Thread):
    """Rounds in a process; where that dies, the round is a failure, and another one goes on."""

    def __init__(self, numbers, arguments, results):
        super().__init__()
        self.left, self.arguments, self.results = list(numbers), arguments, results
        self.start()

    def run(self):
        while self.left:
            with tempfile.TemporaryFile("w+") as errors:
                self.run_process(errors)

    def run_process(self, errors):
        command = [sys.executable, "-m", "live_faults", "--seed", str(self.arguments.seed)]
        command += ["--slack", str(self.arguments.slack), "--only", *map(str, self.left), "--work"]
        command += ["--cameras", *self.arguments.cameras]
        begun = None
        pipes = {"stdout": subprocess.PIPE, "stderr": errors, "text": True}
        with subprocess.Popen(command, env=self.arguments.environment, **pipes) as process:
            for line in process.stdout:
                said = json.loads(line)
                if "begins" in said:
                    begun = said["begins"]
                    continue
                self.left.remove(said["round"])
                self.note(said)
                begun = None
        if self.left:
            errors.seek(0)
            text = errors.read()[-6000:]
            number = self.left.pop(0) if begun is None else begun
            if number in self.left:
                self.left.remove(number)
            trouble = f"the process died with {process.returncode}: {text}"
            self.note({"round": number, "fault": "?", "kind": "?", "failures": [trouble]})

    def note(self, result):
        self.results.append(result)
        for failure in result["failures"]:
            title = f"round {result['round']} ({result['fault']}; {result['kind']})"
            print(f"FAILED {title}: {failure}", flush=True)


def table(results):
    rows = defaultdict(list)
    for result in results:
        rows[result["fault"]].append(result)
    width = max(map(len, rows))
    titles = "rounds  worst lateness (s)  overtaken  not reached  failures"
    print(f"{'fault':{width}} {titles}")
    for fault, those in sorted(rows.items()):
        late = [result["late"] for result in those if result.get("late") is not None]
        worst = f"{max(late):+.3f}" if late else "-"
        overtaken = sum(bool(result.get("overtaken")) for result in those)
        missed = sum(not result.get("reached", True) for result in those)
        failed = [result["round"] for result in those if result["failures"]]
        numbers = " ".join(map(str, [len(failed), *failed]))
        print(f"{fault:{width}} {len(those):6}  {worst:>18}  {overtaken:9}  {missed:11}  {numbers}")


def main():
    parser = argparse.ArgumentParser(prog="live_faults")
    parser.add_argument("--rounds", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--slack", type=float, default=0.5, help="s, by which the machine may be late"
    )
    parser.add_argument("--only", type=int, nargs="+", help="numbers of rounds to repeat")
    parser.add_argument(
        "--cameras",
        nargs="+",
        choices=cameras.KINDS,
        default=cameras.SOFTWARE,
        help="kinds of them; firewire is the virtual bus, gige a server on loopback",
    )
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--work", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    numbers = range(arguments.rounds) if arguments.only is None else arguments.only
    if arguments.work:
        work(numbers, arguments.seed, arguments.slack, arguments.cameras)
        return
    arguments.environment = wired.with_bus() if "firewire" in arguments.cameras else None
    start, results = time.monotonic(), []
    workers = [
        Worker(list(numbers)[i :: arguments.workers], arguments, results)
        for i in range(arguments.workers)
    ]
    for worker in workers:
        worker.join()
    table(results)
    failed = sum(bool(result["failures"]) for result in results)
    print(f"{len(results)} rounds in {time.monotonic() - start:.0f} s, {failed} failed")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
