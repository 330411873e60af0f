"""What is no setting of a controller is refused in its name."""

from refusals import INF, NAN, NO_COUNT, Refusal, options, refusals
from robsim import DriveAround, Spin


@refusals(
    Refusal(Spin, "voltage", (NAN, INF, None, "x", 1j)),
    options(
        DriveAround,
        {"low high": (NAN, INF, None, "x"), "hold": (0, *NO_COUNT), "low": (2,), "high": (-1,)},
    ),
)
def test_controllers(refusal):
    refusal()
