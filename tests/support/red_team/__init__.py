"""The red team of the grader: submissions that try to get points, or out.

``PYTHONPATH=tests/support python -m red_team`` runs all of them, with all that shuts them in here
and with the process alone, and prints what came of each. They act in their own workers, against
the grader that has started them, and the files and ports that are made for them.
"""

from red_team.attack import HONEST, ITS_OWN, LAYERS, NOTHING, PROCESS, Attack
from red_team.calls import CALLS
from red_team.files import FILES
from red_team.process import PROCESSES
from red_team.python import PYTHON
from red_team.truth import TRUTH
from red_team.wire import WIRE

ATTACKS = {attack.name: attack for attack in (*TRUTH, *FILES, *PROCESSES, *WIRE, *PYTHON, *CALLS)}

__all__ = ["ATTACKS", "HONEST", "ITS_OWN", "LAYERS", "NOTHING", "PROCESS", "Attack"]
