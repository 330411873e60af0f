#!/usr/bin/env bash
# Gradescope runs this once, as root, when it builds the image of the autograder.
set -euo pipefail
root="${AUTOGRADER:-/autograder}"
source="$root/source"
export DEBIAN_FRONTEND=noninteractive

# robsim needs Python 3.11; Ubuntu 22.04 has it in addition to its default.
find_python() {
  for python in python3.14 python3.13 python3.12 python3.11 python3; do
    if "$python" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
      command -v "$python"
      return
    fi
  done
  return 1
}
if ! find_python >/dev/null; then
  apt-get update
  apt-get install -y python3.11 python3.11-venv || apt-get install -y python3 python3-venv
fi
"$(find_python)" -m venv "$root/venv"
cd "$source"
"$root/venv/bin/pip" install --no-cache-dir -r requirements.txt
# Unpacked files may be readable for all users, but a key must not be.
chmod -R go-rwx "$source"
"$root/venv/bin/robsim" grade --check-isolation
