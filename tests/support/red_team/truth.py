"""Attacks on the truth: in frames of the stack, in memory, in seeds, in what is told."""

from red_team.attack import ITS_OWN, at_once, attack, kind

_LOOKS = """
NAMES = {"pose_true", "truth", "_truth", "true_pose", "world_seed", "_key"}
KINDS = {"Simulation", "GradedSimulation", "SimulatedWorld", "Scenario", "Key", "RunSeeds", "Trace"}

def look(values, what):
    for value in values:
        if type(value).__name__ in KINDS:
            reached(f"{what}: a {type(value).__name__}")

"""

looks = kind(lambda lines: _LOOKS + lines)

TRUTH = [
    looks("stack frames", "looks for the truth in the local variables of its callers")("""
def cheat(step):
    frame = sys._getframe()
    while frame is not None:
        look(frame.f_locals.values(), "a frame")
        if NAMES & set(frame.f_locals):
            reached("a name of the truth")
        frame = frame.f_back
"""),
    looks("frames of all threads", "looks in sys._current_frames()")("""
def cheat(step):
    for frame in sys._current_frames().values():
        while frame is not None:
            look(frame.f_locals.values(), "a thread")
            frame = frame.f_back
"""),
    looks("tracebacks", "raises, and looks in the frames of the traceback")("""
def cheat(step):
    try:
        1 / 0
    except ZeroDivisionError as error:
        frame = error.__traceback__.tb_frame
        while frame is not None:
            look(frame.f_locals.values(), "a traceback")
            frame = frame.f_back
"""),
    looks("garbage collector", "looks for worlds, traces and keys among all objects")("""
def cheat(step):
    if once(step):
        found, seen = gc.get_objects() + list(gc.get_referrers(step)), set()
        while found and len(seen) < 300_000:
            value = found.pop()
            if id(value) not in seen:
                seen.add(id(value))
                if not isinstance(value, type):
                    look([value], "an object")
                found += gc.get_referents(value)
"""),
    attack(
        "samples of the truth",
        "looks for the samples that parameter estimators get, and for what they were given to",
    )("""
def cheat(step):
    if step.sample is not None:
        reached("a sample of the truth")
    if step.estimator is not None and np.any(step.estimator.n_samples):
        reached("an estimator with samples")
    return None
"""),
    at_once(
        "memory by /proc", "opens the memory of its parent and of all processes that it sees"
    )("""
for number in {1, 2, *range(3, 40), os.getppid(), {grader}} - {0, os.getpid()}:
    if os.path.exists(f"/proc/{number}") or number == {grader}:
        tries("memory of another", lambda: open(f"/proc/{number}/mem", "rb"))
"""),
    at_once(
        "memory by process_vm_readv", "copies memory of its parent and of the first processes"
    )("""
own = ctypes.create_string_buffer(8)
to = struct.pack("QQ", ctypes.addressof(own), 8)
of = struct.pack("QQ", 0x400000, 8)
for number in (os.getppid(), 1, {grader}):
    tries("memory", lambda: called(libc.process_vm_readv(number, to, 1, of, 1, 0)))
"""),
    at_once("trace", "traces its parent, and the grader")("""
libc.ptrace.argtypes = [ctypes.c_long] * 4
for number in (os.getppid(), {grader}):
    if number:
        tries("trace", lambda: called(libc.ptrace(0x4206, number, 0, 0)))
"""),
    at_once(
        "address of the maps",
        "reads where the memory of its parent lies, its environment and its command",
        why="the command line of other processes is open to all users",
    )("""
for number in (os.getppid(), {grader}):
    for name in ("maps", "environ", "cmdline", "fd/0"):
        if number:
            tries(name, lambda: open(f"/proc/{number}/{name}", "rb").read())
"""),
    at_once("write to the ring", "maps the frames for writing")("""
import mmap
number = ring()
tries("a mapping", lambda: mmap.mmap(number, 4096, mmap.MAP_SHARED,
                                     mmap.PROT_READ | mmap.PROT_WRITE))
tries("a write", lambda: os.pwrite(number, b"x" * 4096, 0))
tries("a cut", lambda: os.ftruncate(number, 0))
tries("a hole", lambda: called(libc.fallocate(number, 3, ctypes.c_long(0),
                                              ctypes.c_long(4096))))
"""),
    at_once(
        "change protection of the ring",
        "makes the pages of a frame writable, by mprotect and by its own /proc/self/mem",
    )("""
where = step.frame.image.__array_interface__["data"][0] & -4096
libc.mprotect.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int]
tries("mprotect", lambda: called(libc.mprotect(where, 4096, 3)))
def write():
    with open("/proc/self/mem", "r+b", buffering=0) as memory:
        memory.seek(where)
        memory.write(b"x" * 4096)
tries("its own memory", write)
"""),
    attack(
        "clean frames in the ring",
        "looks with a thread whether a frame without noise is ever in the shared memory",
        ITS_OWN,
    )("""
import mmap
def clean(slot):
    pixels = np.frombuffer(slot, np.uint8).reshape(-1, 3)[: 240 * 240].reshape(240, 240, 3)
    steps = np.abs(np.diff(pixels.astype(int), axis=1)).mean()  # 23 with the noise of the task
    return pixels.all(axis=2).mean() > 0.9 and steps < 12
def watch():
    while not any(clean(memory[slot]) for slot in slots):
        looked.set()
    reached("a clean frame")
    looked.set()
size = -(-3 * 240 * 240 // 65536) * 65536
slots = [slice(slot * size, (slot + 1) * size) for slot in range(8)]
looked = threading.Event()
def cheat(step):
    global memory
    if step.k == 0:
        memory = mmap.mmap(ring(), 8 * size, mmap.MAP_SHARED, mmap.PROT_READ)
        threading.Thread(target=watch, daemon=True).start()
        looked.wait()
    return honest(step)
"""),
    attack(
        "guess the seed of a frame",
        "tries the noise of many small seeds on the differences of two frames",
    )("""
images = []
def cheat(step):
    if step.frame is not None:
        images.append(step.frame.image.astype(int)[:2])
    if step.k == 3 and len(images) == 4:
        base = np.full((2, 240, 3), 128, np.uint8)
        wanted = (images[1] - images[0]).ravel()
        for seed in range(300):
            for number in (seed, stream(seed)):
                noise = robsim.GaussianNoise(8)
                one, other = (noise.add(base, number, k).astype(int).ravel() for k in (0, 1))
                if np.corrcoef(other - one, wanted)[0, 1] > 0.5:
                    reached(f"the seed of the noise, {seed}")
                    return
def stream(seed):
    from robsim.base.seeds import seed_sequence, stream_number
    return stream_number(seed_sequence(seed), "noise")
"""),
    attack("the seed of the robot half", "makes the world from the seed that its half is given")("""
from robsim.teach.grading.robot_half import Setup
def setup(start):
    seen, found = set(), gc.get_objects()
    while found:
        value = found.pop()
        if type(value) is Setup: return value
        if id(value) not in seen:
            seen.add(id(value))
            found += gc.get_referents(value)
def cheat(step):
    if once(step):
        number = setup(step).controller_seed
        for seed in (number, number % 2**32, np.random.SeedSequence(number)):
            sim = robsim.Simulation(resolution=(240, 240), start="random", seed=seed, measure=True)
            sim.run(3)
            if np.hypot(*(sim.trace.pose_measured[0] - poses[0])[:2]) < 30:
                reached("the start")
    elif step.measurement is not None and not poses:
        poses.append(np.asarray(step.measurement.pose, float))
"""),
    attack(
        "dead reckoning", "measures once, then follows the public model: legal, and not enough"
    )("""
def cheat(step):
    model = robsim.RobotModel()
    if not poses:
        if step.measurement is None:
            return None
        poses.extend([np.asarray(step.measurement.pose, float)] * 2)
    else:
        poses.append(np.asarray(model.predict(poses[-1], poses[-2], step.last_u), float))
    return poses[-1]
"""),
    attack("say it by time", "sleeps as long as the robot is far to the right: nobody listens")("""
def cheat(step):
    if step.measurement is not None:
        time.sleep(0.05 * step.measurement.pose[0] / 1200)
    return None
"""),
    at_once(
        "environment and arguments", "looks for paths of the grader's in what its process was given"
    )("""
text = repr([os.environ, sys.argv, sys.orig_argv, os.getcwd(), sys.path])
for word in ("{folder}", "{secret}", "PYTEST", "pytest "):
    if word in text:
        reached(f"the name {word}")
"""),
]
