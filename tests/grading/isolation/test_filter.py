"""The filter of system calls, by its numbers and its instructions, on both processors."""

import re
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="filters are for Linux")

if sys.platform == "linux":
    from robsim.teach.isolation._layers.seccomp import DENIED, PROCESSORS, program_for

HEADERS = {
    "x86_64": ["/usr/include/x86_64-linux-gnu/asm/unistd_64.h", "/usr/include/asm/unistd_64.h"],
    "aarch64": ["/usr/include/asm-generic/unistd.h"],
}
SPECIAL = ("clone", "clone3", "tgkill", "prlimit64", "prctl", "fcntl", "ioctl")
ALLOW, EPERM, ENOSYS, KILL = 0x7FFF0000, 0x00050001, 0x00050026, 0x80000000
PROCESS = 4711
#: What must stay refused, whatever else is.
NAMES = """
fork vfork execve execveat setsid setpgid kill tkill rt_sigqueueinfo rt_tgsigqueueinfo
pidfd_open pidfd_send_signal pidfd_getfd ptrace process_vm_readv process_vm_writev
process_madvise process_mrelease kcmp userfaultfd migrate_pages move_pages mbind
set_mempolicy memfd_create memfd_secret socket socketpair connect bind listen accept accept4
shmget shmat shmctl shmdt semget semop semctl semtimedop msgget msgsnd msgrcv msgctl mq_open
mq_unlink mq_timedsend mq_timedreceive mq_notify mq_getsetattr chmod fchmod fchmodat
fchmodat2 chown fchown lchown fchownat utime utimes futimesat utimensat setxattr lsetxattr
fsetxattr removexattr lremovexattr fremovexattr setxattrat removexattrat file_setattr
truncate mknod mknodat setuid setgid setreuid setregid setresuid setresgid setfsuid setfsgid
setgroups capset keyctl add_key request_key personality setrlimit setpriority ioprio_set
sched_setaffinity sched_setscheduler sched_setparam sched_setattr unshare setns mount
umount2 pivot_root chroot mount_setattr move_mount open_tree open_tree_attr fsopen fsconfig
fsmount fspick statmount listmount name_to_handle_at open_by_handle_at sethostname
setdomainname quotactl quotactl_fd fanotify_init fanotify_mark inotify_init inotify_init1
inotify_add_watch inotify_rm_watch bpf perf_event_open
io_uring_setup io_uring_enter io_uring_register init_module finit_module delete_module
kexec_load kexec_file_load reboot swapon swapoff acct syslog iopl ioperm modify_ldt
lookup_dcookie settimeofday clock_settime adjtimex clock_adjtime vhangup nfsservctl uselib
"""


def verdict(program, audit, call, *arguments):
    """Run a filter as the kernel does."""
    words = [call, audit, 0, 0]
    for value in (*arguments, 0, 0, 0, 0, 0, 0)[:6]:
        words += [value & 0xFFFFFFFF, value >> 32 & 0xFFFFFFFF]
    at, loaded = 0, None
    while True:
        code, if_true, if_false, value = program[at]
        at += 1
        if code == 0x06:
            return value
        if code == 0x20:
            loaded = words[value // 4]
        else:
            tests = {0x15: loaded == value, 0x35: loaded >= value, 0x45: bool(loaded & value)}
            at += if_true if tests[code] else if_false


@pytest.mark.parametrize("machine", ["x86_64", "aarch64"])
def test_the_filter_decides_as_it_says(machine):
    p = PROCESSORS[machine]
    program = program_for(p, PROCESS)

    def says(call, *arguments, audit=p.audit):
        return verdict(program, audit, call, *arguments)

    denied = {numbers[p.column] for numbers in DENIED.values()} - {None}
    assert set(NAMES.split()) <= set(DENIED)
    special = {getattr(p, name) for name in SPECIAL}
    assert not denied & special
    for call in range(480):
        if call not in special:
            assert says(call) == (EPERM if call in denied else ALLOW), call
    assert says(0, audit=0x40000003) == KILL  # a call of a processor of 32 bits
    assert says(p.clone3) == ENOSYS
    assert says(p.clone, 0x3D0F00) == ALLOW  # what pthread_create asks for
    assert says(p.clone, 17) == EPERM
    assert says(p.clone, 0x10000 | 0x10000000) == EPERM
    assert says(p.tgkill, PROCESS, PROCESS, 6) == ALLOW
    assert says(p.tgkill, PROCESS + 1, PROCESS + 1, 6) == EPERM
    assert says(p.prlimit64, 0, 7, 0, 1 << 40) == ALLOW
    assert says(p.prlimit64, 0, 7, 1 << 40) == EPERM  # a pointer with no low bits
    assert says(p.prlimit64, 0, 7, 4096) == EPERM
    assert says(p.prctl, 15) == ALLOW
    assert says(p.prctl, 4, 1) == EPERM
    assert says(p.fcntl, 3, 1) == ALLOW
    assert says(p.fcntl, 3, 8, 1) == EPERM
    assert says(p.ioctl, 0, 0x5401) == ALLOW
    assert says(p.ioctl, 0, 0x5412) == EPERM
    if machine == "x86_64":
        assert says(0x40000000 | 39) == EPERM


@pytest.mark.parametrize("machine", ["x86_64", "aarch64"])
def test_the_numbers_are_those_of_the_headers(machine):
    found = [Path(name) for name in HEADERS[machine] if Path(name).exists()]
    if not found:
        pytest.skip("the headers of Linux are not installed")
    text = found[0].read_text()
    numbers = {
        name: int(number)
        for name, number in re.findall(r"#define __NR(?:3264)?_(\w+)\s+(\d+)", text)
    }
    p = PROCESSORS[machine]
    ours = {name: both[p.column] for name, both in DENIED.items()}
    ours |= {name: getattr(p, name) for name in SPECIAL}
    known = {name: number for name, number in ours.items() if name in numbers}
    assert len(known) > 110  # headers may be older than the newest calls
    assert known == {name: numbers[name] for name in known}
    newer = {n for name, n in ours.items() if name not in numbers and n is not None}
    assert all(number > 440 for number in newer)
