"""``python tests/digests``: compare this machine with the numbers that robsim gives elsewhere."""

import argparse
import sys

from digest_report import compare_digests, write_expected
from robsim._core import cpu_path, cpu_paths, force_cpu_path


def main() -> int:
    """Print the comparison; return 1 if something is not as promised."""
    parser = argparse.ArgumentParser(prog="python tests/digests", description=__doc__)
    parser.add_argument(
        "--path", choices=cpu_paths(), default=cpu_path(), help="instructions that the core uses"
    )
    parser.add_argument("--json", action="store_true", help="print JSON in place of the table")
    parser.add_argument("--write", metavar="FILE", help="write what came as what is expected")
    options = parser.parse_args()
    force_cpu_path(options.path)
    if options.write:
        write_expected(options.write)
        return 0
    report = compare_digests()
    print(report.to_json() if options.json else report)
    return 0 if report.ok else 1


if __name__ == "__main__":
    sys.exit(main())
