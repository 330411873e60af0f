"""Faults by name: what must be caught whatever else is."""

from __future__ import annotations

from pathlib import Path

from mutants.fault import Fault

#: Name, file, what stands there once, what stands there instead.
_NAMED = [
    ("watchdog off", "cpp/robsim/lab/motors/safety.cpp", "    on_expiry();\n", "\n"),
    (
        "time to live ignored",
        "cpp/robsim/lab/motors/motor_receiver.cpp",
        "now + command.time_to_live / 1000.0",
        "now + 1e9",
    ),
    (
        "voltage limit off",
        "cpp/robsim/lab/motors/safety.cpp",
        "wanted = scaled(u, voltage)",
        "wanted = u",
    ),
    (
        "a Landlock right",
        "python/robsim/teach/isolation/_layers/landlock.py",
        "_TRUNCATE if abi >= 3 else 0",
        "0",
    ),
    (
        "a seccomp number",
        "python/robsim/teach/isolation/_layers/calls.py",
        ' "process_vm_readv": (310, 270),',
        "",
    ),
    (
        "a mask off",
        "python/robsim/teach/submissions/imports.py",
        "        sys.meta_path.insert(0, finder)\n",
        "        sys.meta_path.append(finder)\n",
    ),
    (
        "the world's seed in the worker",
        "python/robsim/teach/grading/graded_run.py",
        'controller_seed=stream_number(seeds.robot, "controller")',
        'controller_seed=stream_number(seeds.world, "controller")',
    ),
    (
        "random streams swapped",
        "python/robsim/base/seeds.py",
        '"noise", "start"',
        '"start", "noise"',
    ),
    (
        "a fused product",
        "cpp/robsim/model/robot_model.cpp",
        "(value_1 * theta[0] + u.u1 * drive * theta[2])",
        "std::fma(value_1, theta[0], u.u1 * drive * theta[2])",
    ),
    (
        "fsync off",
        "python/robsim/base/files/writing.py",
        "            os.fsync(self.descriptor)\n",
        "",
    ),
    (
        "a wrap off",
        "cpp/robsim/model/robot_model.cpp",
        "pose_1.heading - wrap_angle(pose_1.heading - pose_2.heading)",
        "pose_2.heading",
    ),
    (
        "a lock off",
        "cpp/robsim/simulation/seam/thread_guard.cpp",
        "    guard.refuse(before_);\n",
        "    return;\n",
    ),
    (
        "the zip path check off",
        "python/robsim/teach/submissions/names.py",
        'if ".." in parts:',
        "if False:",
    ),
    (
        "an escape in a page off",
        "python/robsim/teach/reports/pages.py",
        "        autoescape=True,\n",
        "        autoescape=False,\n",
    ),
    (
        "a frame reused",
        "cpp/robsim/imaging/image.hpp",
        "    if (pixels_.use_count() > 1) return true;\n",
        "",
    ),
]


def named_faults(root: Path) -> list[Fault]:
    """Return the faults by name, where they stand below a root."""
    return [_fault(root, *one) for one in _NAMED]


def _fault(root: Path, name: str, file: str, old: str, new: str) -> Fault:
    content = (root / file).read_bytes()
    start = content.find(old.encode())
    if start < 0 or content.count(old.encode()) != 1:
        raise ValueError(f"{name}: {file} must have once: {old.strip()}")
    return Fault(file, start, content.count(b"\n", 0, start) + 1, old, new, name)
