"""The red team of the grader: submissions that try to get points, or out.

They act in their own workers, against the grader that has started them, and the files and ports
that are made for them. Not covered by any attack here, nor by the grader:

- faults of the kernel and of the processor, side channels in time or caches;
- with the process alone (macOS; Linux without its layers): what reads or changes files, connects,
  starts processes, or signals others of the same user;
- masked modules that robsim itself needs in a worker (evaluation, vision, ...), and masked names:
  code that searches memory finds them; robsim.estimation.reference is not among them;
- samples of the truth, where an assignment lets a submission identify parameters from the truth:
  they go to submissions that fill the parameter estimator, and no other stage;
- public seeds: who knows the seed knows the noise; a copy of somebody else's solution.
"""

from red_team.attack import HONEST, LAYERS, Attack
from red_team.calls import CALLS
from red_team.files import FILES
from red_team.process import PROCESSES
from red_team.python import PYTHON
from red_team.truth import TRUTH
from red_team.wire import WIRE

ATTACKS = {attack.name: attack for attack in (*TRUTH, *FILES, *PROCESSES, *WIRE, *PYTHON, *CALLS)}

__all__ = ["ATTACKS", "HONEST", "LAYERS", "Attack"]
