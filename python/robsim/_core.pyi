"""
The C++ core of robsim. robsim re-exports its public part.
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
__all__: list[str] = ['Arrival', 'Blob', 'CameraFaults', 'CaptureDevice', 'ColorClass', 'Controller', 'Detection', 'DriveAround', 'Estimate', 'ExternalWorld', 'Frame', 'Grabber', 'HaltedError', 'Intrinsics', 'Laboratory', 'LaboratoryCamera', 'LeastSquaresFit', 'Limits', 'Line', 'LineCounts', 'LineError', 'Loop', 'MarkerLayout', 'Measurement', 'MessageSocket', 'MissedDetections', 'MotorEvent', 'MotorLink', 'MotorReceiver', 'Observation', 'PlaneMap', 'PythonCamera', 'RaisedRobot', 'ReceivedInput', 'RecursiveLeastSquares', 'RemoteRobot', 'RemoteWorld', 'Renderer', 'Replay', 'RobotModel', 'RobotParameters', 'Sample', 'Scene', 'SharedFrames', 'Sights', 'SimulatedWorld', 'Spin', 'Step', 'StreamedCamera', 'TraceGroup', 'Unicycle', 'VisualNoise', 'Warp', 'World', 'WorldState', 'atan2', 'check_mean_interval', 'classify', 'close_default', 'color_histograms', 'cos', 'cpu_path', 'cpu_paths', 'detect', 'detection_reasons', 'exp', 'expected_signal_to_noise', 'find_blobs', 'fitting_roles', 'force_cpu_path', 'frame_noise', 'hypot', 'is_whole_jpeg', 'least_squares', 'locate', 'log', 'marker_roles', 'model_steps', 'parse_line', 'path_sensitivities', 'pixel_formats', 'random_normal', 'random_uniform', 'rank_tolerance', 'reduced', 'regression', 'relative_masks', 'rgb_to_yuv', 'second_order_recursion', 'simulated_path', 'sin', 'small_markers_remark', 'surrounding_chroma', 'to_line', 'to_rgb', 'trace_schema', 'trusted_width', 'view_warp', 'wrap_angle']
class Intrinsics:
    """
    A camera's focal lengths, principal point and distortion, from a calibration of its lens.
    
    Parameters
    ----------
    matrix : array (3, 3)
        The camera matrix ``[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]``: focal lengths and principal point
        (px; an integer is a pixel's centre).
    distortion : array (5,), optional
        The coefficients k1, k2, p1, p2, k3. Default: none, an ideal lens.
    
    Raises
    ------
    TypeError, ValueError
        If the shapes are wrong, a number is not finite, or a focal length is not above 0.
    
    Notes
    -----
    Let an ideal lens show a point at x = (u - cx) / fx, y = (v - cy) / fy, with r^2 = x^2 + y^2. The
    real lens shows it at ::
    
        x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
        y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
    
    as long as this grows with r. Beyond this limit the lens would fold the picture over, and both
    directions of the conversion give NaN. Source: D. C. Brown, Close-range camera calibration,
    Photogrammetric Engineering 37(8), 1971; ``cv2.calibrateCamera`` gives the coefficients in the same
    order.
    
    Examples
    --------
    >>> matrix = [[800, 0, 319.5], [0, 800, 239.5], [0, 0, 1]]
    >>> lens = robsim.vision.Intrinsics(matrix, (-0.12, 0.02, 0, 0, 0))
    >>> robsim.vision.PlaneMap(intrinsics=lens).to_world((0, 0)).round(1)  # of the corner
    array([-10. ,  -7.5])
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, matrix: numpy.typing.ArrayLike, distortion: numpy.typing.ArrayLike | None = None) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    def distorted(self, pixels: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the frame pixels for pixels of an ideal lens.
        
        Parameters
        ----------
        pixels : array (2,) or (N, 2)
            Ideal pixels (u, v).
        
        Returns
        -------
        array (2,) or (N, 2)
            Pixels (u, v) of the frames; NaN where the lens shows nothing.
        """
    def ideal(self, pixels: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the pixels of an ideal lens for frame pixels.
        
        Parameters
        ----------
        pixels : array (2,) or (N, 2)
            Pixels (u, v) of the frames.
        
        Returns
        -------
        array (2,) or (N, 2)
            Ideal pixels (u, v); NaN where the lens shows nothing.
        """
    @property
    def distortion(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (5,): k1, k2, p1, p2, k3.
        """
    @property
    def matrix(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (3, 3): the camera matrix (px).
        """
class PlaneMap:
    """
    Map between frame pixels (u right, v down; integers are centres) and positions on the work area.
    
    Parameters
    ----------
    matrix : array (3, 3), optional
        Homography that takes (u, v, 1) to (x, y, 1) times a number. Default: the identity.
    intrinsics : Intrinsics, optional
        The camera's intrinsics: its lens first maps (u, v) to the ideal pixel, which the homography
        maps further. Default: the pixels are ideal.
    
    Raises
    ------
    TypeError, ValueError
        If the matrix is not finite or has no inverse.
    
    Examples
    --------
    >>> seen = [(102, 80), (541, 77), (630, 455), (12, 460)]
    >>> corners = [(0, 0), (1199, 0), (1199, 1199), (0, 1199)]
    >>> plane_map = robsim.vision.PlaneMap.from_points(seen, corners)
    >>> plane_map.to_world((541, 77)).round(3)
    array([1199.,    0.])
    """
    @staticmethod
    def from_points(pixels: numpy.typing.ArrayLike, positions: numpy.typing.ArrayLike, intrinsics: Intrinsics | None = None) -> PlaneMap:
        """
        Return the map of a camera that looks at the work area from any direction.
        
        Parameters
        ----------
        pixels : array (N, 2)
            Pixels (u, v) of four or more points on the floor; of four, no three on a line.
        positions : array (N, 2)
            Positions (x, y) of these points on the work area, in the same order (work-area px).
        intrinsics : Intrinsics, optional
            The camera's intrinsics. Default: no lens distortion.
        
        Returns
        -------
        PlaneMap
            For four points, the only homography that takes each pixel to its position; for more, the one
            with the least squared distances. ``plane_map.to_world(pixels) - positions`` is its error.
        
        Raises
        ------
        TypeError, ValueError
            If the shapes are wrong, too many points lie on a line, the positions are in another order
            than the pixels, or the lens shows nothing at a pixel.
        
        Examples
        --------
        >>> seen = [(102, 80), (541, 77), (630, 455), (12, 460)]
        >>> corners = [(0, 0), (1199, 0), (1199, 1199), (0, 1199)]
        >>> plane_map = robsim.vision.PlaneMap.from_points(seen, corners)
        >>> plane_map.to_world((541, 77)).round(3) + 0.0
        array([1199.,    0.])
        """
    @staticmethod
    def scaled(resolution: tuple[int, int], area: tuple[float, float]) -> PlaneMap:
        """
        Return the map of a camera that sees the whole area.
        
        Parameters
        ----------
        resolution : tuple of int
            Width and height of the frame (px).
        area : tuple of float
            Width and height of the area (work-area px).
        """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, matrix: numpy.typing.ArrayLike | None = None, intrinsics: Intrinsics | None = None) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    def at_height(self, height: float) -> PlaneMap:
        """
        Return the map of a plane above the floor, such as the plane of a robot's markers.
        
        Parameters
        ----------
        height : float
            Height above the plane of this map (work-area px).
        
        Returns
        -------
        PlaneMap
            Map between the pixels of points at this height and the positions vertically below them.
        
        Raises
        ------
        TypeError, ValueError
            If the map has no intrinsics, or the camera is not above that height.
        
        Notes
        -----
        The floor's homography to ideal pixels is K [r1 r2 t], times a number that makes r1 and r2 unit
        vectors. Measured r1 and r2 differ in length, so the number is the mean of their scales. At the
        height h the homography is K [r1 r2 t + h n], where n = +- r1 x r2 points to the camera. Source: Z.
        Zhang, A flexible new technique for camera calibration, PAMI 22(11), 2000.
        """
    def to_pixel(self, positions: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the pixels of positions.
        
        Parameters
        ----------
        positions : array (2,) or (N, 2)
            Positions (x, y) in work-area px.
        
        Returns
        -------
        array (2,) or (N, 2)
            Pixels (u, v); NaN where the lens shows nothing.
        """
    def to_world(self, pixels: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the positions of pixels.
        
        Parameters
        ----------
        pixels : array (2,) or (N, 2)
            Pixels (u, v).
        
        Returns
        -------
        array (2,) or (N, 2)
            Positions (x, y) in work-area px; NaN where the lens shows nothing.
        """
    @property
    def intrinsics(self) -> Intrinsics | None:
        """
        Intrinsics or None: the camera's.
        """
    @property
    def matrix(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (3, 3): the homography from pixels, ideal ones with intrinsics, to the work area.
        """
class Frame:
    """
    A camera image with its time: the only data about the world for the robot's software.
    
    The pixels are RGB. OpenCV's pixels are BGR: use `Frame.from_bgr` for these. Otherwise the red and
    the blue marker are swapped, and the measured pose has the wrong direction and position.
    
    Parameters
    ----------
    image : array (H, W, 3) of uint8
        RGB pixels. With ``copy=False``, any buffer of this type and shape is accepted.
    copy : bool
        False: use the array's own memory, such as shared memory. The frame keeps the array alive and
        always shows its current content. Overwriting the memory changes the frame, its hash and its
        equality.
    t : float, optional
        Time (s), of the exposure if the camera knows it. None: the frame has no time.
    t_arrival : float, optional
        Arrival at this computer, by the clock of `t` (s).
    epoch : float, optional
        ``time.monotonic()`` when `t` was 0 (s).
    index : int
        Number of the frame.
    plane_map : PlaneMap, optional
        Pixels to work area. Default: the identity.
    headings : int, optional
        Number of drawn headings of the robot, at whole pixels, as in frames of a simulation. This
        rounding limits the accuracy of a measured pose, and the covariance includes it. By default any
        heading is possible, as in a real camera's frames. A frame made only from the pixels of a
        simulated frame needs this number.
    
    Examples
    --------
    A frame of shared memory keeps that memory open. Here a ``bytearray`` has its place:
    
    >>> memory = bytearray(480 * 640 * 3)
    >>> frame = robsim.Frame(memoryview(memory).cast("B", (480, 640, 3)), copy=False, t=0.2)
    >>> memory[0] = 255
    >>> frame.image[0, 0].tolist(), frame.t
    ([255, 0, 0], 0.2)
    """
    @staticmethod
    def from_bgr(image: numpy.typing.NDArray[numpy.uint8], *, t: float | None = None, t_arrival: float | None = None, epoch: float | None = None, index: int = 0, plane_map: PlaneMap = ..., headings: int | None = None) -> Frame:
        """
        Return the frame of an image in BGR, OpenCV's order: a copy.
        
        Parameters
        ----------
        image : array (H, W, 3) of uint8
            BGR pixels, as from ``cv2.imread`` and ``cv2.VideoCapture``.
        t, t_arrival, epoch, index, plane_map, headings
            As for `Frame`.
        
        Examples
        --------
        >>> blue = np.uint8([[[255, 0, 0]]])
        >>> robsim.Frame.from_bgr(blue).image[0, 0].tolist()
        [0, 0, 255]
        """
    def __array__(self, dtype: typing.Any = None, copy: typing.Any = None) -> typing.Any:
        """
        Return the image, so that numpy and matplotlib accept a frame as its pixels.
        """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, image: numpy.typing.NDArray[numpy.uint8], *, copy: bool = True, t: float | None = None, t_arrival: float | None = None, epoch: float | None = None, index: int = 0, plane_map: PlaneMap = ..., headings: int | None = None) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    def _repr_png_(self) -> tuple[bytes, dict[str, int]]:
        """
        Return the image as a PNG file and its displayed width: notebooks display a frame.
        """
    @property
    def epoch(self) -> float | None:
        """
        float or None: ``time.monotonic()`` when `t` was 0 (s).
        """
    @property
    def headings(self) -> int | None:
        """
        int or None: number of drawn headings of the robot.
        """
    @property
    def image(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        array (H, W, 3) of uint8: RGB, read-only. Without ``copy=False`` it is C-contiguous and
        never overwritten while you hold it.
        """
    @property
    def index(self) -> int:
        """
        int: number of the frame.
        """
    @property
    def plane_map(self) -> PlaneMap:
        """
        PlaneMap: pixels <-> work area.
        """
    @property
    def t(self) -> float | None:
        """
        float or None: time (s).
        """
    @property
    def t_arrival(self) -> float | None:
        """
        float or None: arrival at this computer, by the clock of `t` (s).
        """
class Warp:
    """
    Makes an image from another by moving each pixel.
    """
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def apply(self, image: numpy.typing.NDArray[numpy.uint8]) -> numpy.typing.NDArray[numpy.uint8]:
        ...
class CaptureDevice:
    """
    A camera for a grabber. Users take robsim.Camera.
    """
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class PythonCamera(CaptureDevice):
    """
    A camera in Python, called in the grabber's thread.
    
    Parameters
    ----------
    camera : object
        With ``open()`` and ``close()``, called in turn any number of times, and ``read()``. ``read()``
        returns None if no frame came within 0.1 s or so, or a pair (image, exposed). The image is a
        uint8 array (H, W, 3), or None if it was torn; exposed is the time of its exposure
        (``time.monotonic()``, s), or None if unknown. Three numbers may follow: the time of its arrival
        (the same clock, s), the number of complete images skipped before this one, and of torn ones.
        All three methods raise CaptureError.
    bgr : bool
        Whether the images are in OpenCV's order; otherwise they are RGB.
    """
    def __init__(self, camera: typing.Any, *, bgr: bool = False) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class StreamedCamera(CaptureDevice):
    """
    A camera that another process reads: open() of its object returns the descriptor of a socket for the frames, and close() ends the process.
    """
    def __init__(self, camera: typing.Any) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class Grabber:
    """
    The thread that reads a camera. Users take robsim.Camera.
    """
    def __call__(self, timeout: float) -> Frame | None:
        """
        Return the newest frame if it was not taken yet, else None.
        """
    def __init__(self, device: CaptureDevice, *, every: int = 1, frame_timeout: float = 1.0, reopen: bool = False, interval: float | None = None, plane_map: PlaneMap | None = None, area: tuple[int, int] | None = None, size: tuple[int, int] | None = None, headings: int | None = None) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def close(self, patience: float = 1.0) -> None:
        """
        End the thread; abandon it if it hangs for `patience` s.
        """
    def wait_for_size(self, timeout: float) -> tuple[int, int] | None:
        """
        Return (width, height) of the first frame; None without a frame.
        """
    @property
    def counts(self) -> typing.Annotated[list[int], "FixedSize(6)"]:
        """
        list of int: grabbed, delivered, dropped, torn, timeouts, reopened.
        """
    @property
    def kept_rate(self) -> tuple[float, float] | None:
        """
        The actual and the promised frame rate (1/s); None: they are equal.
        """
    @property
    def newest(self) -> Frame | None:
        """
        Frame or None: the last taken frame.
        """
class RobotParameters:
    """
    The physical parameters of the robot; the defaults come from the original program.
    
    Parameters
    ----------
    mass : float
        Mass m (kg).
    inertia : float
        Moment of inertia I (kg m^2).
    linear_friction, angular_friction : float
        Viscous friction Fv (N s/m) and Fw (N m s/rad).
    wheel_radius, wheel_base : float
        Wheel radius r and distance of the wheels L (m).
    motor_gain : tuple of two floats
        Torque per voltage alpha of the left and the right motor (N m/V).
    motor_offset : tuple of two floats
        Torque at 0 V beta of the left and the right motor (N m).
    dt : float
        Sample time T (s).
    
    Raises
    ------
    ValueError
        If a value is not physical; the message names the value and the reason.
    
    Examples
    --------
    >>> light, heavy = (robsim.RobotParameters(mass=mass) for mass in (0.3, 0.6))
    >>> [float(robsim.RobotModel(p).theta[0, 2].round(3)) for p in (light, heavy)]
    [0.208, 0.108]
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, *, mass: float = 0.3, inertia: float = 0.1, linear_friction: float = 0.1, angular_friction: float = 0.1, wheel_radius: float = 0.03, wheel_base: float = 0.11, motor_gain: numpy.typing.ArrayLike = (0.05, 0.05), motor_offset: numpy.typing.ArrayLike = (1e-06, 1e-06), dt: float = 0.2) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def angular_friction(self) -> float:
        """
        float: viscous friction of the heading (N m s/rad).
        """
    @property
    def dt(self) -> float:
        """
        float: sample time (s).
        """
    @property
    def inertia(self) -> float:
        """
        float: moment of inertia (kg m^2).
        """
    @property
    def linear_friction(self) -> float:
        """
        float: viscous friction of the position (N s/m).
        """
    @property
    def mass(self) -> float:
        """
        float: mass (kg).
        """
    @property
    def motor_gain(self) -> tuple[float, float]:
        """
        tuple of float: torque per voltage, left and right (N m/V).
        """
    @property
    def motor_offset(self) -> tuple[float, float]:
        """
        tuple of float: torque at 0 V, left and right (N m).
        """
    @property
    def wheel_base(self) -> float:
        """
        float: distance of the wheels (m).
        """
    @property
    def wheel_radius(self) -> float:
        """
        float: wheel radius (m).
        """
class RobotModel:
    """
    One-step predictor of a differential-drive robot, linear in its 15 parameters.
    
    Per axis: x(k) = a1 x(k-1) + a2 x(k-2) + (b1 u1(k-1) + b2 u2(k-1) + d1) cos heading(k-1), with sin
    for y and 1 for the heading. The equations allow the robot to slide sideways.
    
    Parameters
    ----------
    parameters : RobotParameters, optional
        The physical robot.
    
    Raises
    ------
    ValueError
        If the predictor would be unstable: a1 must lie between 0 and 2.
    
    Notes
    -----
    Source: Pereira et al., Data-Based Dynamical Modelling of Externally Observed Actuators-Only
    Robots, IEEE Trans. SMC A 30(4), 2000.
    
    Examples
    --------
    >>> robsim.RobotModel().theta.round(3)  # rows X, Y, heading: -a1, -a2, b1, b2, d1
    array([[ 1.938, -0.938,  0.208,  0.208,  0.   ],
           [ 1.938, -0.938,  0.208,  0.208,  0.   ],
           [ 1.833, -0.833,  0.031, -0.031,  0.   ]])
    """
    @staticmethod
    def from_theta(theta: numpy.typing.ArrayLike, *, dt: float = 0.2) -> RobotModel:
        """
        Return the model with these predictor parameters.
        
        Parameters
        ----------
        theta : array (3, 5)
            Rows X, Y, P (heading), columns a1, a2, b1, b2, d1.
        dt : float
            Sample time (s).
        """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, parameters: RobotParameters = ...) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    def jacobian(self, pose_1: numpy.typing.ArrayLike, pose_2: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the derivatives of the pose of step k by the two previous poses.
        
        Parameters
        ----------
        pose_1, pose_2 : array (3,) or (N, 3)
            Poses of steps k-1 and k-2: x, y (work-area px), heading (rad).
        u : array (2,) or (N, 2)
            Input of step k-1 (V).
        
        Returns
        -------
        array (3, 6) or (N, 3, 6)
            Columns 0..2: the derivatives by x, y and heading of `pose_1`; 3..5: of `pose_2`.
        
        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type or shape, or is not finite.
        """
    def predict(self, pose_1: numpy.typing.ArrayLike, pose_2: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, unwrapped: bool = False) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the pose of step k, or the poses of N steps.
        
        Parameters
        ----------
        pose_1, pose_2 : array (3,) or (N, 3)
            Poses of steps k-1 and k-2: x, y (work-area px), heading (rad).
        u : array (2,) or (N, 2)
            Input of step k-1 (V).
        unwrapped : bool
            Use the headings unchanged, without a jump by a full turn, and do not wrap the result's heading.
        
        Returns
        -------
        array (3,) or (N, 3)
            The pose, with a heading in (-pi, pi]. An argument with a single row applies to all N steps.
        
        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type or shape, or is not finite.
        """
    def steps_in(self, dt: float) -> int:
        """
        Return the number of the model's steps in a time: several if frames were lost.
        
        Parameters
        ----------
        dt : float
            The time between two poses (s), such as ``step.dt``.
        
        Raises
        ------
        ValueError
            If the time is not a positive multiple of the model's dt, with a tolerance of a quarter of that
            dt.
        """
    @property
    def dt(self) -> float:
        """
        float: sample time (s).
        """
    @property
    def theta(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (3, 5): rows X, Y, P (heading), columns a1, a2, b1, b2, d1.
        """
class Scene:
    """
    The floor and the robot of a Renderer; immutable, so that any number of renderers can share it.
    
    Parameters
    ----------
    floor, home : tuple of two arrays (H, W, 3) of uint8
        The floor that repeats around the work area, and the work area itself: each lit and in the
        shadow, in camera pixels.
    shadow_left : int
        First column of the shadow in the view (px).
    shadow_factor : float
        Brightness of the robot in the shadow relative to the light.
    sprite : array (h, w, 4) of uint8
        The robot's image, RGBA.
    centre : array (2,)
        The robot's centre in the sprite (sprite px).
    unit : float
        Work-area px per sprite pixel.
    alignment : float
        Clockwise rotation of the sprite that makes the robot face +x (rad).
    headings : int
        Number of drawn headings of the robot, at whole pixels; 0 = any heading and position.
    area : tuple of int
        Width and height of the work area (px).
    
    Examples
    --------
    >>> floor = (np.full((80, 100, 3), 150, np.uint8), np.full((80, 100, 3), 120, np.uint8))
    >>> red = np.full((21, 21, 4), (250, 0, 0, 255), np.uint8)
    >>> scene = robsim.simulation.Scene(floor=floor, home=floor, shadow_left=66, shadow_factor=0.8,
    ...     sprite=red, centre=(10, 10), unit=1, alignment=0, headings=0, area=(100, 80))
    >>> scene.nbytes  # four images of 100 x 80 px, 3 bytes each
    96000
    """
    def __init__(self, *, floor: tuple[numpy.typing.NDArray[numpy.uint8], numpy.typing.NDArray[numpy.uint8]], home: tuple[numpy.typing.NDArray[numpy.uint8], numpy.typing.NDArray[numpy.uint8]], shadow_left: int, shadow_factor: float, sprite: numpy.typing.NDArray[numpy.uint8], centre: numpy.typing.ArrayLike, unit: float, alignment: float, headings: int, area: tuple[int, int]) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    @property
    def nbytes(self) -> int:
        """
        int: memory of the four images of the floor.
        """
class Renderer:
    """
    Draws the ceiling camera's view, without noise.
    
    Parameters
    ----------
    scene : Scene
        The scene to draw; other renderers may share it.
    
    Examples
    --------
    >>> floor = (np.full((80, 100, 3), 150, np.uint8), np.full((80, 100, 3), 120, np.uint8))
    >>> red = np.full((21, 21, 4), (250, 0, 0, 255), np.uint8)
    >>> scene = robsim.simulation.Scene(floor=floor, home=floor, shadow_left=66, shadow_factor=0.8,
    ...     sprite=red, centre=(10, 10), unit=1, alignment=0, headings=0, area=(100, 80))
    >>> view = robsim.simulation.Renderer(scene).render((70, 40, 0))
    >>> view[40, [20, 60, 80, 99]].tolist()  # floor, robot, robot in the shadow, its floor
    [[150, 150, 150], [250, 0, 0], [200, 0, 0], [120, 120, 120]]
    """
    def __init__(self, scene: Scene) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def render(self, pose: numpy.typing.ArrayLike, pan: tuple[int, int] = (0, 0), *, out: numpy.typing.NDArray[numpy.uint8] | None = None) -> numpy.typing.NDArray[numpy.uint8]:
        """
        Return the image of the robot at a pose.
        
        Parameters
        ----------
        pose : array (3,)
            x, y (work-area px), heading (rad).
        pan : tuple of int
            Shift of the view (camera px).
        out : array (H, W, 3) of uint8, optional
            Array for the image. Default: memory of the renderer.
        
        Returns
        -------
        array (H, W, 3) of uint8
            `out`, if given. Otherwise a read-only image, which stays unchanged while you hold a reference.
        
        Raises
        ------
        TypeError, ValueError
            If `pose` is not a pose, or if `out` has the wrong type or shape or is read-only.
        """
    @property
    def scene(self) -> Scene:
        """
        Scene: the drawn scene, for other renderers.
        """
class VisualNoise:
    """
    Noise of the camera. Users take robsim.GaussianNoise or UniformNoise.
    """
    def __init__(self, *, gaussian: float = 0.0, uniform: float = 0.0) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def add(self, image: numpy.typing.NDArray[numpy.uint8], seed: int, index: int = 0, *, out: numpy.typing.NDArray[numpy.uint8] | None = None) -> numpy.ndarray:
        """
        See robsim.GaussianNoise.add.
        """
class ColorClass:
    """
    A named colour: a pixel belongs to the colour if the pixel's Y, U and V lie within the ranges.
    
    Parameters
    ----------
    name : str
        Name of the colour.
    y, u, v : tuple of two ints
        Lower and upper end of the range, both included, within 0..255.
    
    Examples
    --------
    >>> red = robsim.ColorClass("red", u=(60, 125), v=(180, 255))
    >>> y, u, v = robsim.vision.rgb_to_yuv(np.uint8([[[200, 30, 40]]]))[0, 0]
    >>> bool(red.u[0] <= u <= red.u[1] and red.v[0] <= v <= red.v[1])
    True
    """
    @staticmethod
    def from_histograms(histograms: numpy.typing.ArrayLike, *, name: str, percentile: float = 33.0, margin: int = 52, limit_y: bool = False, around: numpy.typing.ArrayLike | None = None) -> ColorClass:
        """
        Return the colour class of regions with these histograms, which add up over images.
        
        Parameters
        ----------
        histograms : array (3, 256)
            As from `color_histograms`, or a sum of several.
        name, percentile, margin, limit_y
            As for `from_region`.
        around : array (2, 2), optional
            Medians and spreads of U and V around the regions, as from `surrounding_chroma`. Default: not
            known. A colour then counts if its distance from grey is at least 16 levels, or 1/4 of its luma
            if that is less.
        """
    @staticmethod
    def from_region(image: Frame | numpy.typing.NDArray[numpy.uint8], region: collections.abc.Sequence[int], *, name: str, percentile: float = 33.0, margin: int = 52, limit_y: bool = False) -> ColorClass:
        """
        Return the colour class of a region of an image, such as a marker's.
        
        Parameters
        ----------
        image : Frame or array (H, W, 3) of uint8
            RGB, preferably with little noise.
        region : tuple of four ints
            (left, top, right, bottom), all included, as in `Blob.bounding_box`. Most of the region must
            have the colour.
        name : str
            Name of the colour: 1 to 40 letters, digits, spaces, - and _.
        percentile : float
            Percentage of the pixels outside the range found in a channel, at each end.
        margin : int
            Widening of the ranges found (levels).
        limit_y : bool
            Whether the class limits Y, too. Light and shadow change Y, so by default any Y belongs.
        
        Raises
        ------
        TypeError, ValueError
            For an image or a region of the wrong type or shape, a region outside the image, or options out
            of range. Also raised for a grey region, which only Y can distinguish: see `limit_y`.
        
        Notes
        -----
        Shadow, and noise clipped at black and white, move U and V towards neutral (128), never away from
        it. So a range on one side of neutral is open at its far end. In the channel farthest from neutral,
        the range stays 26 levels away from neutral, or half of the colour's distance if that is less. So
        greys do not belong to the class, even with a large margin. A weak colour counts under two
        conditions. First, the median of the region is farther from grey than the rest of the image. The
        difference is at least 4 standard deviations of the mean of 7 x 7 pixels, and at least 3 levels.
        Second, the distance from grey itself is at least as large, and at least 16 levels or 1/8 of the
        luma, whichever is less.
        """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, name: str, *, y: tuple[int, int] = (0, 255), u: tuple[int, int] = (0, 255), v: tuple[int, int] = (0, 255)) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    def widened(self, margin: int) -> ColorClass:
        """
        Return the class with wider ranges.
        
        Parameters
        ----------
        margin : int
            Outward shift of each limit (levels); a negative shift is inward. Limits at 0 and 255 are open
            and do not move.
        
        Raises
        ------
        ValueError
            If a range becomes empty.
        """
    @property
    def name(self) -> str:
        """
        str: name of the colour.
        """
    @property
    def u(self) -> tuple[int, int]:
        """
        tuple of int: blue minus luma, 128 = neutral.
        """
    @property
    def v(self) -> tuple[int, int]:
        """
        tuple of int: red minus luma, 128 = neutral.
        """
    @property
    def y(self) -> tuple[int, int]:
        """
        tuple of int: luma.
        """
class MarkerLayout:
    """
    The two markers of a robot, their colours and positions, which turn a pair of blobs into a pose.
    
    A marker has a role, which gives its position on the robot, and a colour, by which vision finds it.
    The roles here are ``"right"`` and ``"left"``: the line between the two markers is perpendicular to
    the heading. See `from_markers` and `from_positions` for markers one behind the other (``"front"``
    and ``"back"``) and for other arrangements.
    
    Parameters
    ----------
    distance : float
        Distance between the centroids of the two markers (work-area px).
    offset : float
        Distance from the midpoint of the markers forward to the robot's centre (work-area px).
    distance_tolerance : float
        Maximum deviation of a pair's distance, as a fraction of the distance.
    area_tolerance : float
        Maximum ratio between a blob's area and the marker's or, where the marker areas are not known,
        between the areas of a pair.
    maximum_blobs : int
        Number of considered blobs of a colour, the largest first.
    colors : dict of str to str, optional
        By role, the colour classes' names, such as ``{"right": "green", "left": "orange"}``, as in a
        colour file. Default: the right or front marker is red, the other one blue.
    
    Examples
    --------
    >>> markers = robsim.vision.MarkerLayout(distance=43, offset=12)
    >>> markers.colors
    {'right': 'red', 'left': 'blue'}
    """
    @staticmethod
    def from_markers(markers: collections.abc.Mapping[str, numpy.typing.ArrayLike], *, distance_tolerance: float = 0.12, area_tolerance: float = 2.5, maximum_blobs: int = 64, colors: collections.abc.Mapping[str, str] | None = None) -> MarkerLayout:
        """
        Return the layout of these markers, with their areas.
        
        Parameters
        ----------
        markers : dict of str to array (N, 2)
            By role, ``"right"`` and ``"left"``, or ``"front"`` and ``"back"``: the marker's corners in the
            robot's frame: forward, right (work-area px from its centre).
        distance_tolerance, area_tolerance, maximum_blobs, colors
            As for `MarkerLayout`.
        
        Raises
        ------
        ValueError
            If the roles are unknown or contradict the positions, or if a polygon is invalid.
        """
    @staticmethod
    def from_positions(positions: collections.abc.Mapping[str, numpy.typing.ArrayLike], *, areas: collections.abc.Mapping[str, float | None] | None = None, distance_tolerance: float = 0.12, area_tolerance: float = 2.5, maximum_blobs: int = 64, polygons: collections.abc.Mapping[str, numpy.typing.ArrayLike] | None = None, colors: collections.abc.Mapping[str, str] | None = None) -> MarkerLayout:
        """
        Return the layout of markers at these positions.
        
        Parameters
        ----------
        positions : dict of str to array (2,)
            By role, ``"right"`` and ``"left"``, or ``"front"`` and ``"back"``: the marker's centroid in the
            robot's frame: forward, right (work-area px from its centre).
        areas : dict of str to float, optional
            By role, their areas (px^2); an omitted area, or None, is not known. Default: not known.
        distance_tolerance, area_tolerance, maximum_blobs, colors
            As for `MarkerLayout`.
        polygons : dict of str to array (N, 2), optional
            By role, their corners, in the same frame. Default: not known, which makes measurements less
            exact.
        
        Raises
        ------
        ValueError
            If the roles are unknown, or contradict the positions.
        """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, distance: float, offset: float, *, distance_tolerance: float = 0.12, area_tolerance: float = 2.5, maximum_blobs: int = 64, colors: collections.abc.Mapping[str, str] | None = None) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    def width_in(self, frame: Frame) -> float:
        """
        Return the width of the smaller marker in the middle of a frame.
        
        Parameters
        ----------
        frame : Frame
            The frame; its plane map gives the scale.
        
        Returns
        -------
        float
            The side of a square of its area (px of the frame); NaN if no area is known. Poses are reliable
            from a width of 4.5 px on.
        """
    @property
    def area_tolerance(self) -> float:
        """
        float: ratio.
        """
    @property
    def areas(self) -> dict[str, float]:
        """
        dict of str to float: by role, px^2, NaN = unknown.
        """
    @property
    def colors(self) -> dict[str, str]:
        """
        dict of str to str: by role, the names of the markers' colours.
        """
    @property
    def distance(self) -> float:
        """
        float: distance between the markers' centroids (work-area px).
        """
    @property
    def distance_tolerance(self) -> float:
        """
        float: fraction.
        """
    @property
    def maximum_blobs(self) -> int:
        """
        int: blobs considered per colour.
        """
    @property
    def offset(self) -> float:
        """
        float: distance from the markers' midpoint forward to the centre (px).
        """
    @property
    def polygons(self) -> dict[str, numpy.typing.NDArray[numpy.float64]] | None:
        """
        dict of str to array (N, 2) or None: by role, the corners, forward and right of the centre
        (px); None = unknown, as from `from_positions`.
        """
    @property
    def positions(self) -> dict[str, numpy.typing.NDArray[numpy.float64]]:
        """
        dict of str to array (2,): by role, forward and right of the robot's centre (px).
        """
    @property
    def roles(self) -> tuple[str, str]:
        """
        tuple of 2 str: ``("right", "left")`` or ``("front", "back")``: the markers' roles, by their places. All dicts of markers have this order.
        """
class Blob:
    """
    A connected component (8 neighbours) of pixels of one colour class, in pixels of its frame.
    
    Parameters
    ----------
    color : str
        Name of the colour class.
    area : int
        Number of pixels.
    centroid : array (2,)
        Mean (u, v) of its pixels.
    bounding_box : tuple of int
        (u_min, v_min, u_max, v_max), all included.
    at_border : bool
        Whether it touches the edge of the frame and may continue beyond it.
    
    Examples
    --------
    >>> frame = robsim.Simulation(seed=1).step().frame
    >>> blob = robsim.find_blobs(frame, robsim.load_colors())["blue"][0]
    >>> blob.area, blob.centroid.round(1), blob.at_border
    (558, array([586. , 578.5]), False)
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, color: str, *, area: int, centroid: numpy.typing.ArrayLike, bounding_box: collections.abc.Sequence[int], at_border: bool = False) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def area(self) -> int:
        """
        int: number of pixels.
        """
    @property
    def at_border(self) -> bool:
        """
        bool: it touches the edge of the frame and may continue beyond it.
        """
    @property
    def bounding_box(self) -> tuple[int, int, int, int]:
        """
        tuple of int: (u_min, v_min, u_max, v_max), all included.
        """
    @property
    def centroid(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (2,): mean (u, v) of its pixels.
        """
    @property
    def color(self) -> str:
        """
        str: name of the colour class.
        """
class Measurement:
    """
    The pose of a detected robot, and its accuracy. A frame without a detection gives None instead.
    
    Parameters
    ----------
    pose : array (3,)
        x, y (work-area px), heading (rad, not degrees). The heading is wrapped to (-pi, pi].
    covariance : array (3, 3), optional
        Of x, y (work-area px) and heading (rad). Default: not known.
    misfit : float, optional
        Factor on the variance, because the residuals of the markers' fit contain more than noise: 1 =
        only noise. In frames without noise the rendering causes a misfit of up to 2. A larger misfit
        means that the markers differ from their outlines: they are moved, compressed or partly hidden.
        The `misfit` of a `Detection` is a different number, which refers to the pair of blobs.
    signal_to_noise : float, optional
        Ratio of the markers' edges to the noise. A pose is reliable if the ratio is at least 4; below 3
        no pose is reported.
    seen : dict of str to Blob, optional
        The seen markers of the robot, by role, ``"right"`` and ``"left"``, or ``"front"`` and
        ``"back"``: for a `BlobMarker` its blob. Its colour is its identity.
    
    Raises
    ------
    ValueError
        If the pose is not finite, if the covariance is invalid, or if a figure is below 0 or not
        finite.
    
    Examples
    --------
    >>> noise = robsim.GaussianNoise(10)
    >>> sim = robsim.Simulation(measure=True, headings=None, noise=noise, seed=1)
    >>> np.sqrt(np.diag(sim.step().measurement.covariance)).round(2)  # px, px, rad
    array([0.03, 0.04, 0.  ])
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, pose: numpy.typing.ArrayLike, *, covariance: numpy.typing.ArrayLike | None = None, misfit: float | None = None, signal_to_noise: float | None = None, seen: collections.abc.Mapping[str, Blob] | None = None) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def covariance(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        array (3, 3) or None: covariance of x, y (work-area px) and heading (rad); None = not
        known.
        """
    @property
    def misfit(self) -> float | None:
        """
        float or None: factor on the variance, 1 if the fit's residuals are only noise.
        """
    @property
    def pose(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (3,): x, y (work-area px), heading (rad, in (-pi, pi]).
        """
    @property
    def seen(self) -> dict[str, Blob] | None:
        """
        dict of str to Blob or None: the markers' blobs, by role.
        """
    @property
    def signal_to_noise(self) -> float | None:
        """
        float or None: ratio of the markers' edges to the noise; from 4 on a pose is reliable.
        """
class Detection:
    """
    The result of `detect`: the pair of blobs that fits the markers best, its misfit, and its pose.
    
    The misfit is the sum of three squared deviations. The deviation of the distance is divided by the
    markers' ``distance_tolerance``. The deviations of the logarithms of the two areas are divided by
    the logarithm of ``area_tolerance``. In an accepted pair, each squared deviation is at most 1.
    
    Examples
    --------
    >>> markers = robsim.load_robot("lab").marker_layout()
    >>> robsim.vision.detect({"red": [], "blue": []}, markers).reason
    'no blobs'
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def by_second_chance(self) -> bool:
        """
        bool: the pair was found only with colours relative to brightness. The limits of a colour
        then apply to U - 128 and V - 128, divided by the largest of R, G and B. A limit of 26
        levels is a saturation of 29 %. Under coloured light, the floor is taken as grey. Dim or
        uneven light and faded markers change the levels, but not the fractions.
        """
    @property
    def distance(self) -> float:
        """
        float: distance between the two blobs (work-area px); NaN without a pair.
        """
    @property
    def explanation(self) -> str:
        """
        str: a sentence on the result, with the decisive numbers.
        """
    @property
    def false_alarms(self) -> float:
        """
        float: expected number of pairs of the other blobs that fit as well by chance, for random
        positions; a pair is accepted up to 0.005.
        """
    @property
    def measurement(self) -> Measurement | None:
        """
        Measurement or None: None = not detected, see `reason`.
        """
    @property
    def misfit(self) -> float:
        """
        float: misfit of the pair, from 0 = perfect; inf without a pair. The misfit of the fit to
        the edges is in the measurement.
        """
    @property
    def reason(self) -> str | None:
        """
        str or None: reason for a missing measurement: ``"no blobs"``, ``"no red blob"``,
        ``"no blue blob"`` or other colours' names, ``"at the border"``, ``"distance"``,
        ``"areas"``, ``"ambiguous"``, ``"by chance"``, ``"noise"`` or ``"shape"``. If the frame
        shows the cause, the reason is ``"dark"``, ``"overexposed"`` or ``"small markers"``.
        """
    @property
    def runner_up(self) -> float:
        """
        float: misfit of the second best accepted pair; inf without such a pair. If the value is
        close to the misfit, the choice is ambiguous.
        """
    @property
    def seen(self) -> dict[str, Blob] | None:
        """
        dict of str to Blob or None: the markers' blobs, by role; if no pair is accepted,
        the most similar blobs.
        """
class MissedDetections:
    """
    The steps of a run in which the default measurement detected no robot, for the same reason.
    
    Examples
    --------
    >>> sim = robsim.Simulation(measure=True, area=(200, 200), start=(5, 100, 0), seed=1)
    >>> sim.run(3).seen.any()
    np.False_
    >>> [(missed.reason, missed.steps) for missed in sim.missed_detections]
    [('at the border', 3)]
    """
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    @property
    def first(self) -> Detection:
        """
        Detection: in the first step.
        """
    @property
    def first_k(self) -> int:
        """
        int: the first of these steps.
        """
    @property
    def reason(self) -> str:
        """
        str: the reason, as in `Detection`.
        """
    @property
    def steps(self) -> int:
        """
        int: number of these steps.
        """
class RecursiveLeastSquares:
    """
    Recursive least squares with forgetting, for one or more parallel filters.
    
    Parameters
    ----------
    n_parameters : int
        Number of parameters of a filter.
    n_filters : int
        Number of filters: 3 for the axes of a robot, 3 R for R runs.
    forgetting : float
        Forgetting factor, within 1e-10..1; 1 = no forgetting.
    initial_covariance : float
        The initial P is this times the identity matrix, at most 1e50; the initial theta is 0.
    
    Raises
    ------
    ValueError
        For values outside these ranges.
    RuntimeError
        If the estimator is read, updated or reset while a run in another thread uses it.
        ``sim.trace.parameters`` can be read meanwhile.
    
    Notes
    -----
    theta minimises the sum of forgetting^(N-k) (y(k) - phi(k) theta)^2 over the samples k = 1..N,
    plus ``forgetting^N |theta|^2 / initial_covariance``. The covariance is kept as P = U D U' (Bierman,
    Factorization Methods for Discrete Sequential Estimation, 1977, ch. V), so that rounding cannot make
    P asymmetric or indefinite, for any number of samples.
    
    Without excitation, as with a constant input, forgetting lets P grow without bound. The filter
    limits the trace of P to 1e9 per parameter, or to its initial value if that is larger. The variances
    D of single columns of U are limited accordingly. The limit adds information along these columns
    only. The estimates do not change, and excited directions are forgotten as before. When excitation
    returns, the filter adapts like a new filter. Below the limit, the filter is the textbook filter.
    With a forgetting of 1 a filter follows a change of the parameters more and more slowly as samples
    accumulate.
    
    Examples
    --------
    >>> rls = robsim.RecursiveLeastSquares(2)
    >>> for phi, y in [((1, 0), 1.0), ((0, 1), 2.0), ((1, 1), 3.3)]:
    ...     theta = rls.update([phi], [y])
    >>> theta.round(3)
    array([[1.1, 2.1]])
    """
    __hash__: typing.ClassVar[None]  # type: ignore[assignment]
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __init__(self, n_parameters: int, *, n_filters: int = 1, forgetting: float = 1.0, initial_covariance: float = 1000000000.0) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    def reset(self) -> None:
        """
        Return to the initial state.
        """
    def update(self, phi: numpy.typing.ArrayLike, y: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Update every filter with one sample, or with N samples in sequence.
        
        Parameters
        ----------
        phi : array (n_parameters,) or (N, n_parameters); for several filters (n_filters, n_parameters) or \\
        (N, n_filters, n_parameters)
            Regressors. A filter with NaN in its regressors or its output skips the update.
        y : array, shaped as phi without its last dimension
            Outputs.
        
        Returns
        -------
        array, shaped as phi
            The estimates after each sample. A skipped update leaves them unchanged.
        
        Raises
        ------
        TypeError, ValueError
            For wrong shapes and for numbers beyond 1e50; the filters then stay unchanged.
        """
    @property
    def P(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (n_parameters, n_parameters), for several filters (n_filters, n_parameters, n_parameters):
        covariance of the estimates in units of the variance of the output noise.
        """
    @property
    def forgetting(self) -> float:
        """
        float: forgetting factor.
        """
    @property
    def initial_covariance(self) -> float:
        """
        float: the initial P is this times the identity matrix.
        """
    @property
    def n_samples(self) -> int | numpy.typing.NDArray[numpy.int64]:
        """
        int, or array (n_filters,) of int: number of samples used, without skipped updates.
        """
    @property
    def standard_errors_unscaled(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array, shaped as theta: standard errors of the estimates in units of the standard
        deviation of the output noise, the square roots of the diagonal of P.
        """
    @property
    def theta(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (n_parameters,) or (n_filters, n_parameters): the estimates.
        """
class LeastSquaresFit:
    """
    Result of `least_squares`.
    
    Examples
    --------
    >>> fit = robsim.estimation.least_squares([[1, 0], [0, 1], [1, 1]], [1, 2, 3.3])
    >>> fit.theta.round(3), fit.standard_errors.round(3)
    (array([1.1, 2.1]), array([0.141, 0.141]))
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def condition(self) -> float:
        """
        float: condition number of the regressors, scaled to length 1.
        """
    @property
    def rank(self) -> int:
        """
        int: number of independent regressors.
        """
    @property
    def residual_rms(self) -> float:
        """
        float: root mean square of y - phi theta.
        """
    @property
    def standard_errors(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (n,): standard errors of theta, with the noise estimated from the residuals.
        """
    @property
    def standard_errors_unscaled(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (n,): standard errors of theta in units of the standard deviation of the noise;
        inf if the samples do not determine them.
        """
    @property
    def theta(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (n,): the parameters, NaN if the samples do not determine them.
        """
class TraceGroup:
    """
    Columns of a trace that are recorded together.
    """
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    @property
    def description(self) -> str:
        """
        str: description in one line.
        """
    @property
    def in_recorded(self) -> bool:
        """
        bool: required in the trace of external frames.
        """
    @property
    def in_simulated(self) -> bool:
        """
        bool: required in the trace of a simulated run.
        """
    @property
    def is_flag(self) -> bool:
        """
        bool: a number above 0 means true.
        """
    @property
    def missing(self) -> float:
        """
        float: value of steps without a record.
        """
    @property
    def name(self) -> str:
        """
        str: name of the group.
        """
    @property
    def shape(self) -> tuple[int, ...]:
        """
        tuple of int: shape of the numbers of a step.
        """
    @property
    def units(self) -> dict[str, str]:
        """
        dict of str to str: unit of each column, in the order of a row.
        """
class Estimate:
    """
    The result of a state estimator in a step.
    
    Parameters
    ----------
    pose : array (3,)
        x, y (work-area px), heading (rad).
    covariance : array (3, 3)
        Its covariance.
    state : array (n,), optional
        Any further state, n the same at every step.
    
    Examples
    --------
    >>> estimate = robsim.Estimate((600, 500, 0.1), np.diag([4, 4, 0.01]))
    >>> np.sqrt(np.diag(estimate.covariance))  # px, px, rad
    array([2. , 2. , 0.1])
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, pose: numpy.typing.ArrayLike, covariance: numpy.typing.ArrayLike, state: numpy.typing.ArrayLike | None = None) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def covariance(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (3, 3): covariance of the pose.
        """
    @property
    def pose(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (3,): x, y (work-area px), heading (rad).
        """
    @property
    def state(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (n,): any further state.
        """
class Sample:
    """
    One sample for the parameter estimator: y = sum(phi * theta, axis=1).
    
    Parameters
    ----------
    phi : array (3, 5)
        Regressors of the axes X, Y and P (heading).
    y : array (3,)
        Outputs x, y (work-area px) and heading (rad).
    k : int
        The step of the output y.
    
    Examples
    --------
    >>> phi = np.tile([10.0, 9.0, 0.5, 0.5, 1.0], (3, 1))
    >>> sample = robsim.estimation.Sample(phi, y=(10.8, 10.8, 10.8), k=2)
    >>> sample.phi.shape, sample.k
    ((3, 5), 2)
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, phi: numpy.typing.ArrayLike, y: numpy.typing.ArrayLike, k: int) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def k(self) -> int:
        """
        int: the step of the output y.
        """
    @property
    def phi(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (3, 5): regressors of the axes X, Y and P (heading).
        """
    @property
    def y(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (3,): outputs x, y (work-area px) and heading (rad).
        """
class Observation:
    """
    An item of the `frames` of an `Experiment`, with more data than a plain frame.
    
    Parameters
    ----------
    frame : Frame, optional
        The camera's frame. None = no frame in this step.
    t : float, optional
        Time of the step (s). Default: the frame's time, or one sample time after the previous step.
    last_u : array (2,), optional
        The input that the robot really got since the last step (V), if different from the controller's.
    measurement : Measurement or array (3,), optional
        The robot's pose, if measured externally: ``measure=True`` keeps it unchanged.
    sample : Sample, optional
        The sample for the parameter estimator, if made externally.
    interrupted : bool
        The robot was stopped since the last step: no sample spans the stop.
    
    Examples
    --------
    >>> dark = robsim.Frame(np.zeros((480, 640, 3), np.uint8))
    >>> seen = robsim.Observation(dark, t=0.2, measurement=(600, 500, 0.1))
    >>> seen.measurement.pose.tolist()
    [600.0, 500.0, 0.1]
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, frame: Frame | None = None, *, t: float | None = None, last_u: numpy.typing.ArrayLike | None = None, measurement: Measurement | numpy.typing.ArrayLike | None = None, sample: Sample | None = None, interrupted: bool = False) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def frame(self) -> Frame | None:
        """
        Frame or None: the camera's frame.
        """
    @property
    def interrupted(self) -> bool:
        """
        bool: the robot was stopped since the last step.
        """
    @property
    def last_u(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        array (2,) or None: the input since the last step (V).
        """
    @property
    def measurement(self) -> Measurement | None:
        """
        Measurement or None: the measured pose.
        """
    @property
    def sample(self) -> Sample | None:
        """
        Sample or None: the sample for the parameter estimator.
        """
    @property
    def t(self) -> float | None:
        """
        float or None: time of the step (s).
        """
class Step:
    """
    The data of a step for the robot's software, read-only. Each stage adds its result.
    
    A step that you create yourself can test a callback without a simulation. A copy contains the frame,
    if it still exists, but no `estimator`. Steps with the same numbers are equal; frames are not
    compared.
    
    Parameters
    ----------
    k : int
        Number of the step.
    t : float, optional
        Time (s). Default: k dt.
    dt : float
        Time since the previous step (s).
    last_u : array (2,)
        The input of the previous step (V).
    frame : Frame, optional
        What the camera sees.
    measurement : Measurement or array (3,), optional
        Where the robot was seen.
    estimate : Estimate, optional
        The result of the state estimator.
    parameters : array (3, 5), optional
        The estimated parameters.
    sample : Sample, optional
        The sample for the parameter estimator.
    u : array (2,), optional
        The input of this step (V).
    colors : list of ColorClass
        The colours used to find `blobs`.
    markers : MarkerLayout, optional
        The robot's markers and their positions.
    
    Examples
    --------
    >>> step = robsim.Step(k=3, measurement=(600, 500, 0.1))
    >>> [round(float(u), 3) for u in robsim.GoToPoint(900, 300)(step)]
    [0.037, 1.0]
    """
    __hash__: typing.ClassVar[None]  # type: ignore[assignment]
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __init__(self, *, k: int = 0, t: float | None = None, dt: float = 0.2, last_u: numpy.typing.ArrayLike = (0.0, 0.0), frame: Frame | None = None, measurement: Measurement | numpy.typing.ArrayLike | None = None, estimate: Estimate | None = None, parameters: numpy.typing.ArrayLike | None = None, sample: Sample | None = None, u: numpy.typing.ArrayLike | None = None, colors: collections.abc.Sequence[ColorClass] = [], markers: MarkerLayout | None = None) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def blobs(self) -> dict[str, list[Blob]]:
        """
        dict of str to list of Blob: per colour the blobs in the frame, the largest first.
        """
    @property
    def colors(self) -> list[ColorClass]:
        """
        list of ColorClass: the colours used to find blobs.
        """
    @property
    def detection(self) -> Detection | None:
        """
        Detection or None: the result of the default measurement, also with the reason for a missing
        pose. None before the measurement, in a step without a frame, and if a callback measures the
        pose.
        """
    @property
    def dt(self) -> float:
        """
        float: time since the previous step (s); if the robot was stopped in between,
        rounded to sample times of the model.
        """
    @property
    def estimate(self) -> Estimate | None:
        """
        Estimate or None: the result of the state estimator.
        """
    @property
    def estimator(self) -> typing.Any:
        """
        The object from init_parameter_estimator.
        """
    @property
    def frame(self) -> Frame | None:
        """
        Frame or None: the camera's frame. None if no frame came in this step.
        """
    @property
    def k(self) -> int:
        """
        int: number of the step, from 0.
        """
    @property
    def last_u(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (2,): the input of the previous step, u1 left and u2 right (V).
        """
    @property
    def markers(self) -> MarkerLayout:
        """
        MarkerLayout: the robot's markers and their positions.
        """
    @property
    def measurement(self) -> Measurement | None:
        """
        Measurement or None: the measured pose. None before the measurement.
        """
    @property
    def parameters(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        array (3, 5) or None: the parameters estimated so far.
        """
    @property
    def sample(self) -> Sample | None:
        """
        Sample or None: the newest complete sample. It is None at the start, and if a bounce or a
        missing measurement interrupts the record.
        """
    @property
    def t(self) -> float:
        """
        float: time (s).
        """
    @property
    def u(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (2,): the input of this step, as sent to the motors (V). RuntimeError before the controller.
        """
class LineError(OSError):
    """
    A line to a robot cannot be opened, read or written.
    """
class HaltedError(RuntimeError):
    """
    An input was refused, since the robot was halted.
    """
class MotorEvent:
    """
    A message on a line to a robot, or an action of the robot itself.
    
    Examples
    --------
    >>> with robsim.lab.MotorReceiver() as robot:
    ...     with robsim.lab.UdpMotors("127.0.0.1", robot.port) as motors:
    ...         sent_at = motors((0.5, -0.25))
    >>> [(event.kind, event.u.tolist()) for event in motors.events if event.kind != "repeat"][:2]
    [('input', [0.5, -0.25]), ('stop', [0.0, 0.0])]
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def kind(self) -> str:
        """
        str: "input", a new input; "repeat", the same again; "stop"; "failure", a line that could not be written; "timeout", the robot stopped without a line; "silence", a robot that answered before has not for a second.
        """
    @property
    def t(self) -> float:
        """
        float: when (s, clock of time.monotonic).
        """
    @property
    def u(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (2,): the input (V), 0 for a stop.
        """
class LineCounts:
    """
    Numbers of lines that a robot has received.
    
    Examples
    --------
    >>> import socket, time
    >>> with robsim.lab.MotorReceiver() as robot, socket.socket(type=socket.SOCK_DGRAM) as sender:
    ...     size = sender.sendto(b"0.5 V" + bytes([10]), ("127.0.0.1", robot.port))
    ...     while not robot.counts.damaged:
    ...         time.sleep(0.01)
    ...     print(robot.counts)
    LineCounts(valid=0, damaged=1, old=0, foreign=0)
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def damaged(self) -> int:
        """
        int: lines that were damaged, too long, or outside the protocol.
        """
    @property
    def foreign(self) -> int:
        """
        int: lines of another sender than the current one.
        """
    @property
    def old(self) -> int:
        """
        int: lines that arrived after a newer one.
        """
    @property
    def valid(self) -> int:
        """
        int: obeyed lines.
        """
class Limits:
    """
    Limits of the inputs of a robot's motors.
    
    Both inputs are scaled by the same factor, so that the robot drives the same curve more slowly.
    Separate limits would change the curve. The change from one input to the next is scaled in the same
    way. Stopping is never slowed down: an input of 0, 0 passes immediately.
    
    Parameters
    ----------
    voltage : float, optional
        Largest size of the input of a motor (V). Default: no limit.
    slew_rate : float, optional
        Largest change of the input of a motor in a second (V/s). Default: no limit.
    
    Raises
    ------
    ValueError
        If a limit is not above 0.
    
    Examples
    --------
    >>> limits = robsim.lab.Limits(voltage=1.0)
    >>> limits.applied((2.0, 1.0), (0.0, 0.0), 0.2)
    array([1. , 0.5])
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, *, voltage: float | None = None, slew_rate: float | None = None) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    def applied(self, u: numpy.typing.ArrayLike, before: numpy.typing.ArrayLike, dt: float) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the input within the limits.
        
        Parameters
        ----------
        u : array (2,)
            The wanted input (V).
        before : array (2,)
            The present input of the motors (V).
        dt : float
            Duration of the present input (s).
        
        Returns
        -------
        array (2,)
            The input (V).
        """
    @property
    def slew_rate(self) -> float | None:
        """
        float or None: largest change of the input of a motor in a second (V/s).
        """
    @property
    def voltage(self) -> float | None:
        """
        float or None: largest size of the input of a motor (V).
        """
class Line:
    """
    One end of a line to a robot.
    """
    @staticmethod
    def of_descriptor(descriptor: int, name: str) -> Line:
        ...
    @staticmethod
    def udp_to(host: str, port: int) -> Line:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class MotorLink:
    """
    The sender's end of a line to a robot. Users take robsim.lab.UdpMotors or SerialMotors.
    """
    def __call__(self, u: numpy.typing.ArrayLike) -> float:
        """
        Send an input, and return its time.
        
        The interpreter continues meanwhile. The link repeats the input until the next one.
        
        Parameters
        ----------
        u : array (2,)
            Voltages of the left and the right motor (V), sent to 0.1 mV.
        
        Returns
        -------
        float
            Time of writing it to the line (s, clock of time.monotonic).
        
        Raises
        ------
        LineError
            If the line cannot be written within 50 ms, or failed since the last input; the link then sends
            stops to the robot for 2 s.
        HaltedError
            If the robot was halted, for example because a frame was late.
        ValueError
            If an input is beyond 1000 V.
        """
    def __init__(self, line: Line, *, ttl: float, hold: float) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def _check_stop(self) -> None:
        """
        Raise LineError, once, if the last stop was not sent.
        """
    def close(self) -> None:
        """
        Stop the robot and close the line; a second call does nothing.
        
        Raises
        ------
        LineError
            If the line failed since the last input: the robot may not have received the stop.
        """
    def halt(self) -> None:
        """
        Stop the robot, and refuse inputs until `resume` is called; raises nothing.
        """
    def resume(self) -> None:
        """
        Accept inputs again after `halt`.
        """
    def stop(self) -> float:
        """
        Stop the robot: send a stop at once, and repeat it for 2 s, five times in the first 0.1 s.
        
        Returns
        -------
        float
            Time of the first stop (s, clock of time.monotonic).
        
        Raises
        ------
        LineError
            If the line cannot be written; the link tries again.
        """
    @property
    def events(self) -> list[MotorEvent]:
        """
        list of MotorEvent: the sent lines; the newest 100 000.
        """
    @property
    def hold(self) -> float:
        """
        float: the link stops the robot if no input is sent for so long (s).
        """
    @property
    def is_closed(self) -> bool:
        """
        bool: True after `close`.
        """
    @property
    def is_halted(self) -> bool:
        """
        bool: True if the link refuses inputs.
        """
    @property
    def is_silent(self) -> bool:
        """
        bool: whether lines are sent, and a robot that answered before has not answered for a second.
        """
    @property
    def name(self) -> str:
        """
        str: name of the line in errors.
        """
    @property
    def round_trip_times(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (N,): from a line to its answer (s), the newest 1000; empty if the robot does not answer.
        """
    @property
    def ttl(self) -> float:
        """
        float: the robot stops if it receives nothing for so long (s).
        """
class ReceivedInput:
    """
    The inputs received by a robot.
    """
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def mean(self, start: float, end: float) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the mean input of the robot's motors between two times.
        
        Parameters
        ----------
        start, end : float
            The times (s, clock of time.monotonic).
        
        Returns
        -------
        array (2,)
            The input (V); 0 while the robot stood. For equal times, the input at this time.
        
        Raises
        ------
        ValueError
            If a time is not finite.
        """
class MotorReceiver(ReceivedInput):
    """
    The robot's end of a motor line: a separate thread reads inputs by the protocol of PROTOCOL.md.
    
    The receiver replaces a robot in rehearsals and tests. It stops the motors if it receives no valid
    line within the time to live set by the sender.
    
    Parameters
    ----------
    port : int
        UDP port to listen on; 0 = any free port, see `port`.
    host : str
        Address to listen on.
    descriptor : int, optional
        A file descriptor to read instead of UDP, such as an end of a pseudo-terminal. It is copied, and
        made non-blocking.
    actuation_delay : float
        Delay from receiving an input to acting on it (s).
    answers : bool
        Whether to answer each valid line, so that the sender knows the round trip time.
    
    Raises
    ------
    LineError
        If the port is in use, or the address does not exist.
    
    Examples
    --------
    >>> with robsim.lab.MotorReceiver() as robot:
    ...     print(robot.input, robot.counts)
    [0. 0.] LineCounts(valid=0, damaged=0, old=0, foreign=0)
    """
    def __enter__(self) -> typing.Any:
        ...
    def __exit__(self, kind: typing.Any, error: typing.Any, traceback: typing.Any) -> None:
        ...
    def __init__(self, port: int = 0, *, host: str = '127.0.0.1', descriptor: int | None = None, actuation_delay: float = 0.0, answers: bool = True) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def close(self) -> None:
        """
        Stop listening; the robot stops at the end of the time to live.
        """
    @property
    def actuation_delay(self) -> float:
        """
        float: delay from receiving an input to acting on it (s).
        """
    @property
    def counts(self) -> LineCounts:
        """
        LineCounts: numbers of received lines.
        """
    @property
    def events(self) -> list[MotorEvent]:
        """
        list of MotorEvent: received lines and its own stops; the newest 100 000.
        """
    @property
    def input(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (2,): the present input of the motors (V).
        """
    @property
    def is_closed(self) -> bool:
        """
        bool: True after `close`.
        """
    @property
    def name(self) -> str:
        """
        str: name of the line.
        """
    @property
    def port(self) -> int:
        """
        int: the port to listen on; 0 for a descriptor.
        """
class WorldState:
    """
    The argument of the callback `evaluate_model`. A state that you create yourself can test a callback
    without a simulation.
    
    Parameters
    ----------
    pose_1, pose_2 : array (3,)
        The poses of steps k-1 and k-2: x, y (work-area px), heading (rad).
    last_u : array (2,)
        Mean input of the motors since step k-1 (V).
    model : RobotModel, optional
        The model that this world follows. Default: the default robot's.
    k : int
        Number of the step.
    t, dt : float, optional
        Time and sample time (s). Default: k dt, and the dt of the model.
    
    Examples
    --------
    >>> world = robsim.simulation.WorldState((601, 500, 0), (600, 500, 0), last_u=(0, 0))
    >>> robsim.Unicycle()(world).round(2)
    array([601.94, 500.  ,   0.  ])
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, pose_1: numpy.typing.ArrayLike, pose_2: numpy.typing.ArrayLike, last_u: numpy.typing.ArrayLike, model: RobotModel | None = None, *, k: int = 1, t: float | None = None, dt: float | None = None) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def dt(self) -> float:
        """
        float: sample time (s).
        """
    @property
    def k(self) -> int:
        """
        int: number of the step.
        """
    @property
    def last_u(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (2,): mean input of the motors since step k-1 (V), with noise and delay if enabled.
        """
    @property
    def model(self) -> RobotModel:
        """
        RobotModel: the model of this world.
        """
    @property
    def pose_1(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (3,): the pose of step k-1: x, y (work-area px), heading (rad).
        """
    @property
    def pose_2(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (3,): the pose of step k-2.
        """
    @property
    def t(self) -> float:
        """
        float: time (s).
        """
class World:
    """
    A world half, for the loop.
    """
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class SimulatedWorld(World):
    """
    The simulated world half. Users take robsim.Simulation.
    """
    def __init__(self, *, area: tuple[int, int], resolution: tuple[int, int], boundary: str) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def draw(self, k: int, pose_true: numpy.typing.ArrayLike, view: numpy.typing.ArrayLike = (0.0, 0.0), hidden: typing.Annotated[collections.abc.Sequence[float], "FixedSize(1)"] = [0.0], noise: numpy.typing.ArrayLike = (0.0, 0.0), out: numpy.typing.NDArray[numpy.uint8] | None = None) -> Frame:
        """
        Return the frame of an earlier step, or write it to `out`.
        """
    def draw_newest(self, out: numpy.typing.NDArray[numpy.uint8] | None = None) -> Frame:
        """
        Return the newest frame, or write it to `out`.
        """
    def option_names(self) -> list[str]:
        """
        Return the names for `set_option`.
        """
    def set_disturbance(self, pose_factor: numpy.typing.ArrayLike, input_sigma: numpy.typing.ArrayLike) -> None:
        ...
    def set_dropout(self, probability: float, steps: int) -> None:
        ...
    def set_evaluate_model(self, value: typing.Any) -> None:
        ...
    def set_frame_memory(self, images: collections.abc.Sequence[typing.Any]) -> None:
        """
        Draw the newest frames on one of these arrays (H, W, 3), even if it is in use.
        """
    def set_make_scene(self, make: typing.Any, makes_at_start: bool) -> None:
        ...
    def set_noise_keys(self, keys: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64]) -> None:
        """
        Draw the noise of each frame from a separate key, array (steps,) of uint64; empty: no longer.
        """
    def set_option(self, name: str, value: typing.Any) -> None:
        ...
    def set_seeds(self, *, noise: int, dropout: int, disturbance: int) -> None:
        ...
    def set_start(self, start: numpy.typing.ArrayLike) -> None:
        ...
    def set_true_model(self, draw: typing.Any) -> None:
        ...
    @property
    def model(self) -> RobotModel | None:
        """
        RobotModel or None: the model that the robot follows; None before the start.
        """
    @property
    def pose(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (3,): pose of the robot: x, y (work-area px), heading (rad).
        """
    @property
    def scene(self) -> Scene:
        """
        Scene or None: the camera's scene; None before its first use.
        """
class Arrival:
    """
    An answer of a source of frames instead of a frame.
    
    Members:
    
      NOTHING_YET
    
      END
    """
    END: typing.ClassVar[Arrival]
    NOTHING_YET: typing.ClassVar[Arrival]
    __members__: typing.ClassVar[dict[str, Arrival]]
    @typing.overload
    def __eq__(self, other: Arrival) -> bool:
        ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> int:
        ...
    def __hash__(self) -> int:
        ...
    def __index__(self) -> int:
        ...
    def __int__(self) -> int:
        ...
    @typing.overload
    def __ne__(self, other: Arrival) -> bool:
        ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    def __str__(self) -> str:
        ...
    @property
    def name(self) -> str:
        ...
    @property
    def value(self) -> int:
        ...
class ExternalWorld(World):
    """
    The external world half. Users take robsim.Experiment.
    """
    def __init__(self, *, frames: typing.Any, motors: typing.Any, frame_timeout: float, limits: Limits | None, longest_timeout: float) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class Unicycle:
    """
    The robot on wheels that do not slip sideways: a ready `evaluate_model` in native code.
    
    The robot has the constants of the `RobotModel`. It drives straight and turns like this model, but
    in a curve it always drives along its heading. The object can be called like a callback:
    ``pose = unicycle(world)``.
    
    Notes
    -----
    s(k) = -a2X s(k-1) + b1X u1(k-1) + b2X u2(k-1) + d1X is the distance driven in a step, and
    x(k) = x(k-1) + s(k) cos heading(k-1), y(k) = y(k-1) + s(k) sin heading(k-1).
    
    Examples
    --------
    >>> drive = {"control": robsim.DriveAround(), "seed": 1}
    >>> model = robsim.Simulation(**drive).run(100)
    >>> unicycle = robsim.Simulation(evaluate_model=robsim.Unicycle(), **drive).run(100)
    >>> np.abs(unicycle.pose_true - model.pose_true).max(axis=0).round(1)
    array([89.4, 32.2,  0. ])
    """
    def __call__(self, world: WorldState) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the pose of a step: array (3,).
        """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
class Controller:
    """
    A predefined controller in native code, which can be called like a callback: ``u = spin(step)``.
    
    Examples
    --------
    >>> robsim.Spin()(robsim.Step(k=0))
    array([ 0.05, -0.05])
    """
    def __call__(self, step: Step) -> numpy.typing.NDArray[numpy.float64]:
        """
        Return the input of a step: array (2,), V.
        """
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class Spin(Controller):
    """
    Turns on the spot: (+voltage, -voltage).
    
    Parameters
    ----------
    voltage : float
        Voltage of the left motor (V); at 0.05 V the default robot turns by 1.05 degrees a step.
    
    Examples
    --------
    >>> trace = robsim.Simulation(control=robsim.Spin(), seed=1).run(50)
    >>> abs(trace.pose_true[-1] - trace.pose_true[0]).round(2)  # px, px, rad
    array([0.  , 0.  , 0.81])
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, voltage: float = 0.05) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def voltage(self) -> float:
        """
        float: voltage of the left motor (V).
        """
class DriveAround(Controller):
    """
    Drives around: each motor gets a random voltage, which is held for some steps.
    
    Parameters
    ----------
    low, high : float
        The voltages are uniform in [low, high) (V).
    hold : int
        Steps for which a voltage is held.
    
    Examples
    --------
    >>> trace = robsim.Simulation(control=robsim.DriveAround(), seed=1).run(100)
    >>> len(np.unique(trace.u, axis=0))  # each input lasts some steps
    10
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, *, low: float = -0.5, high: float = 1.5, hold: int = 10) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def high(self) -> float:
        """
        float: highest voltage (V).
        """
    @property
    def hold(self) -> int:
        """
        int: number of steps for which a voltage is held.
        """
    @property
    def low(self) -> float:
        """
        float: lowest voltage (V).
        """
class Replay(Controller):
    """
    Repeats recorded inputs: step k gets the input of row k.
    
    Parameters
    ----------
    u : array (N, 2)
        The voltages of the left and the right motor (V), one row a step, such as ``trace.u``.
    
    Raises
    ------
    IndexError
        If it is called for a step without a row.
    
    Examples
    --------
    >>> sim = robsim.Simulation(control=robsim.Replay([(0.2, 0.2), (0.2, -0.2)]), seed=1)
    >>> sim.run(2).u
    array([[ 0.2,  0.2],
           [ 0.2, -0.2]])
    """
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Any:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, u: numpy.typing.ArrayLike) -> None:
        ...
    def __reduce__(self) -> tuple[typing.Any, tuple[type], typing.Any]:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Any) -> None:
        ...
    @property
    def u(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        array (N, 2): the voltages (V), read-only.
        """
class MessageSocket:
    """
    One end of a stream socket between two processes that send messages in turn.
    """
    def __init__(self, descriptor: int, limits: typing.Any) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def exchange(self, kind: int, parts: typing.Any, patience: float) -> tuple[int, bytes]:
        ...
class RemoteRobot:
    """
    A robot half in another process: a value for its slots. exchange(message, pixels or None, slot, k) returns the answer; refuse(slot, k, what) raises.
    """
    def __init__(self, exchange: typing.Any, refuse: typing.Any, *, slots: collections.abc.Sequence[str], world: World, sends_frames: bool, sends_samples: bool, measures_first: bool, has_standard_errors: bool, largest_input: float) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class SharedFrames:
    """
    Frames in memory that another process writes, mapped read-only.
    """
    def __init__(self, descriptor: int, slots: int, slot_bytes: int, resolution: tuple[int, int]) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class RemoteWorld(World):
    """
    The world half in another process: exchange(answer) sends the answer, unless it is empty, and returns the next message, None at the end.
    """
    def __init__(self, exchange: typing.Any, *, slots: collections.abc.Sequence[str], frames: SharedFrames | None, resolution: tuple[int, int]) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class Sights:
    """
    Frames and detections of a run, for other runs.
    """
    def __init__(self) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class Loop:
    """
    The loop. Users take robsim.Simulation or robsim.Experiment.
    """
    def __init__(self, *, world: World, colors: collections.abc.Sequence[ColorClass], markers: MarkerLayout, smoothing: int | None, identify_from: str, controller_seed: int) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def check_thread(self) -> None:
        """
        Raise RuntimeError while another thread runs the loop.
        """
    def columns(self) -> dict[str, numpy.typing.NDArray[numpy.float64]]:
        """
        Return the columns of the trace: name -> array (rows, width).
        """
    def reset(self) -> None:
        """
        Return to the start.
        """
    def run(self, steps: int, progress: typing.Any = None, stops_robot: bool = True) -> bool:
        """
        Run `steps` steps; progress(done) is called every 50 ms or so. True = the world has ended.
        """
    def set_controller_seed(self, seed: int) -> None:
        ...
    def set_given(self, given: str, samples: bool) -> None:
        """
        Limit the callbacks to this data, from the next step on.
        """
    def set_observer(self, observer: typing.Any) -> None:
        """
        Call observer(step, u, measurement, detection, t_arrival, t_sent, interrupted) after each step, with None for missing values; observer None = no observer.
        """
    def set_slot(self, slot: str, value: typing.Any) -> None:
        """
        Put a callable or a native component into a slot; None = the default.
        """
    def set_vision(self, colors: collections.abc.Sequence[ColorClass], markers: MarkerLayout, smoothing: int | None) -> None:
        """
        Look for other markers, in other colours, from the next step on.
        """
    def share(self, sights: Sights) -> None:
        """
        Let the next runs use the sights of other runs with the same world and seed.
        """
    def start(self) -> None:
        """
        Do the actions at the start, unless they are done.
        """
    def step_stage(self, progress: typing.Any = None) -> str | None:
        """
        Do the next enabled stage and return its name; None = the world has ended.
        """
    def stop(self) -> bool:
        """
        End the current run; False without a run.
        """
    def stop_robot(self) -> None:
        """
        Send the stop input, if set.
        """
    @property
    def doubts(self) -> list[str]:
        """
        list of str: implausible results of stages, each kind once per run.
        """
    @property
    def estimator(self) -> typing.Any:
        ...
    @property
    def has_started(self) -> bool:
        ...
    @property
    def is_running(self) -> bool:
        ...
    @property
    def last_frame(self) -> Frame | None:
        """
        Frame or None: the newest step's frame, even if callbacks do not get it.
        """
    @property
    def last_step(self) -> Step:
        ...
    @property
    def maximum_count(self) -> int:
        """
        int: maximum number of blobs of a colour.
        """
    @property
    def minimum_area(self) -> int:
        """
        int: minimum area of blobs in the newest frame (px).
        """
    @property
    def missed_detections(self) -> list[MissedDetections]:
        """
        list of MissedDetections: the most frequent reason first.
        """
    @property
    def model(self) -> RobotModel:
        ...
    @property
    def rows(self) -> int:
        """
        int: number of recorded steps.
        """
    @property
    def smoothing(self) -> int:
        """
        int: window of the newest frame (px); 1 = off.
        """
    @property
    def stage(self) -> str:
        """
        str: the current or next stage.
        """
class Laboratory:
    """
    The simulated world in real time. Users take robsim.lab.SimulatedLab.
    """
    def __init__(self, world: World, model: RobotModel, input: ReceivedInput) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def close(self) -> None:
        ...
    def plug_in(self) -> None:
        ...
    def stall(self, seconds: float) -> None:
        ...
    def start(self) -> None:
        ...
    def ticks(self) -> tuple[int, numpy.typing.NDArray[numpy.float64]]:
        ...
    def unplug(self) -> None:
        ...
    @property
    def is_elsewhere(self) -> bool:
        """
        bool: True in a forked process, where it does not work.
        """
    @property
    def skipped(self) -> int:
        """
        int: frames skipped because they were late.
        """
class CameraFaults:
    """
    Faults of a simulated camera. Users take robsim.lab.CameraFaults.
    """
    def __init__(self, *, late: float, lateness: float, dropped: float, repeated: float, torn: float, stall: tuple[float, float], unplugged: tuple[float, float], drift: float, drift_period: float, seed: int) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class LaboratoryCamera(CaptureDevice):
    """
    The camera of a laboratory, for a grabber. Users take robsim.lab.SimulatedLab.
    """
    def __init__(self, laboratory: Laboratory, scene: Scene, *, warp: Warp | None, top: Warp | None, noise: VisualNoise, noise_seed: int, delay: float, faults: CameraFaults) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
class RaisedRobot:
    """
    A robot's top above the floor, as seen by an oblique camera.
    """
    def __init__(self, scene: Scene, warp: Warp) -> None:
        ...
    def __reduce_ex__(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        ...
    def drawn(self, floor: numpy.typing.NDArray[numpy.uint8], pose: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.uint8]:
        """
        Return a frame of the floor with the robot.
        """
def atan2(y: float, x: float) -> float:
    """
    Return the angle of the point (x, y) from the x axis (rad), in [-pi, pi].
    """
def check_mean_interval(time: float, n_steps: int, dt: float) -> None:
    """
    Raise ValueError if so many steps in a time (s), 10 or more, are not dt long on average.
    """
def classify(image: Frame | numpy.typing.NDArray[numpy.uint8], colors: collections.abc.Sequence[ColorClass], *, markers: MarkerLayout | None = None, smoothing: int | None = None) -> dict[str, numpy.typing.NDArray[numpy.bool]]:
    """
    Return the pixels of each colour class: the masks for `find_blobs`.
    
    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB; rows of any stride.
    colors : list of ColorClass
        The colours; a pixel may belong to several.
    markers : MarkerLayout, optional
        The markers to find, from which `smoothing` follows as in `find_blobs`.
    smoothing : int, optional
        Width of the window whose mean classifies a pixel, as in `find_blobs`; 1 = off. Default: 1, or
        the default of `find_blobs` for the markers.
    
    Returns
    -------
    dict of str to array (H, W) of bool
        Per colour, True for its pixels.
    
    Raises
    ------
    TypeError, ValueError
        For an image of the wrong type or shape, duplicate colour names, and options out of range.
    
    Examples
    --------
    >>> frame = robsim.Simulation(seed=1).step().frame
    >>> masks = robsim.vision.classify(frame, robsim.load_colors())
    >>> {color: int(mask.sum()) for color, mask in masks.items()}  # pixels
    {'blue': 558, 'red': 3694}
    """
def close_default(slot: str) -> None:
    """
    Refuse robsim's own measurement or parameter estimator from now on.
    """
def color_histograms(image: Frame | numpy.typing.NDArray[numpy.uint8], region: collections.abc.Sequence[int]) -> numpy.typing.NDArray[numpy.int64]:
    """
    Return the number of pixels of a region with each value of Y, U and V.
    
    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB.
    region : tuple of four ints
        (left, top, right, bottom), all included.
    
    Returns
    -------
    array (3, 256) of int64
        Rows Y, U, V. Add them up over several images.
    
    Raises
    ------
    TypeError, ValueError
        For an image or a region of the wrong type or shape, or a region outside the image.
    
    Examples
    --------
    >>> image = np.full((4, 5, 3), 128, np.uint8)
    >>> counts = robsim.vision.color_histograms(image, (0, 0, 2, 1))
    >>> counts.argmax(axis=1), int(counts.max())  # Y, U, V; number of pixels
    (array([128, 128, 128]), 6)
    """
def cos(x: numpy.typing.ArrayLike) -> typing.Any:
    """
    Return the cosine of an angle (rad), or of each in an array.
    """
def cpu_path() -> str:
    """
    Return the instruction set of the hot loops: "baseline", "avx2" or "avx512".
    """
def cpu_paths() -> list[str]:
    """
    Return the paths available on this processor, the fastest last.
    """
def detect(blobs: collections.abc.Mapping[str, collections.abc.Sequence[Blob]], markers: MarkerLayout, *, plane_map: PlaneMap | None = None, image: Frame | numpy.typing.NDArray[numpy.uint8] | None = None, colors: collections.abc.Sequence[ColorClass] | None = None) -> Detection:
    """
    Search the blobs for the markers of a robot; report the misfit, or the reason for a missing pair.
    
    The pair has a blob of each of the two colours, and is chosen based on the blobs' distance and
    areas. Blobs at the border of the frame are not used, because they may be cut off. Noise and other
    objects may cause many blobs that resemble the markers. A pair is then accepted only if a pair of
    other blobs would rarely fit as well by chance [1]_. So if the floor shows only noise, a pose is
    reported in at most one or two of 100 frames.
    
    Parameters
    ----------
    blobs : dict of str to list of Blob
        From `find_blobs`; the two `MarkerLayout.colors` are used.
    markers : MarkerLayout
        The positions of the markers on the robot.
    plane_map : PlaneMap, optional
        Map from pixels of the blobs' frame to the work area. Default: the map of `image`, if it is a
        Frame; otherwise the identity.
    image : Frame or array (H, W, 3) of uint8, optional
        The image of the blobs. With an image the pose is fitted to the edges of the markers, as in
        `locate`. Without a measurement the image is examined for the cause, such as darkness.
    colors : list of ColorClass, optional
        The colours used to find the blobs. With colours and the image, a frame without a pair gets a
        second chance, as in the default measurement: the search is repeated with the same colours
        relative to brightness, see `Detection.by_second_chance`.
    
    Returns
    -------
    Detection
        Its measurement, misfit and reason.
    
    Raises
    ------
    TypeError, ValueError
        For an image of the wrong type or shape, and for `colors` without an image.
    
    References
    ----------
    .. [1] A. Desolneux, L. Moisan, J.-M. Morel, "Meaningful alignments", International Journal of
       Computer Vision 40 (2000): the number of false alarms.
    
    Examples
    --------
    >>> frame = robsim.Simulation(seed=1).step().frame
    >>> blobs = robsim.find_blobs(frame, robsim.load_colors())
    >>> detection = robsim.vision.detect(blobs, robsim.load_robot("lab").marker_layout())
    >>> detection.explanation
    'red and blue blobs 43.0 px of the work area apart fit the markers (misfit 0.01)'
    """
def detection_reasons(colors: typing.Annotated[collections.abc.Sequence[str], "FixedSize(2)"] = ['red', 'blue']) -> list[str]:
    """
    The reasons of a Detection, in the order of their numbers from 1.
    """
def exp(x: numpy.typing.ArrayLike) -> typing.Any:
    """
    Return e to the power of a number, or of each in an array.
    """
def expected_signal_to_noise(width: float, noise: float) -> float:
    """
    The signal-to-noise figure of markers of a width (frame px) at a noise (grey levels), in
    good light.
    """
def find_blobs(image: Frame | numpy.typing.NDArray[numpy.uint8], colors: collections.abc.Sequence[ColorClass], *, markers: MarkerLayout | None = None, minimum_area: int | None = None, maximum_count: int | None = None, smoothing: int | None = None, region: collections.abc.Sequence[int] | None = None) -> dict[str, list[Blob]]:
    """
    Find the blobs of every colour class in one pass over an image.
    
    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB; rows of any stride.
    colors : list of ColorClass
        The colours to find; a pixel may belong to several.
    markers : MarkerLayout, optional
        The markers to find: the other options then default to values that find these markers, also in
        noise. For an array, the layout's lengths are in px of the array; for a Frame, the plane map
        converts them.
    minimum_area : int, optional
        Smaller blobs are dropped (px). Default: 12 without `markers`, otherwise 1/8 of the smaller
        marker's area.
    maximum_count : int, optional
        Maximum number of blobs of a colour, the largest first. Default: 64 without `markers`, otherwise
        their `maximum_blobs`.
    smoothing : int, optional
        Width of the window whose mean classifies a pixel, against noise: 3, 5, ... 15 px, between 1/4
        and 3/4 of a marker's width; 1 = off. Default: 1 without `markers`, otherwise 0.28 of the
        smaller marker's width, limited to 3..7. For a marker below 7 px, this default is 3 in images
        with noise and 1 in others.
    region : tuple of int, optional
        (left, top, right, bottom) in px, all four included, as in a blob's bounding box: only these
        pixels are searched, as if the image ended there. Positions refer to the whole image.
    
    Returns
    -------
    dict of str to list of Blob
        Per colour the blobs, the largest first.
    
    Raises
    ------
    TypeError, ValueError
        For an image of the wrong type or shape, duplicate colour names, and options out of range.
    
    Examples
    --------
    >>> frame = robsim.Simulation(seed=1).step().frame
    >>> blobs = robsim.find_blobs(frame, robsim.load_colors())
    >>> {color: [blob.area for blob in found] for color, found in blobs.items()}
    {'blue': [558], 'red': [3136, 558]}
    """
def fitting_roles(one: numpy.typing.ArrayLike, other: numpy.typing.ArrayLike) -> tuple[str, str]:
    """
    The roles of markers at two places, forward and right of the robot's centre.
    """
def force_cpu_path(path: str) -> None:
    """
    Use other instructions from now on. The results are identical, bit for bit.
    
    Parameters
    ----------
    path : str
        One of `cpu_paths`.
    
    Raises
    ------
    ValueError
        If the path is not available on this processor.
    """
def frame_noise(frame: Frame) -> float:
    """
    Standard deviation of the noise of a frame's channels (grey levels).
    """
def hypot(x: float, y: float) -> float:
    """
    Return the length of the vector (x, y).
    """
def is_whole_jpeg(data: bytes) -> bool:
    """
    Return whether a JPEG image has all of its blocks, and its end.
    """
def least_squares(phi: numpy.typing.ArrayLike, y: numpy.typing.ArrayLike) -> LeastSquaresFit:
    """
    Return the theta that minimises the sum of squares of y - phi theta.
    
    Parameters
    ----------
    phi : array (N, n)
        Regressors, one sample a row.
    y : array (N,)
        Outputs.
    
    Returns
    -------
    LeastSquaresFit
        theta, rank, condition, residual_rms, standard_errors_unscaled, standard_errors.
    
    Notes
    -----
    The method is Householder QR of blocks of rows, followed by QR with column pivoting of the triangle
    (Golub and Van Loan, Matrix Computations, 5.2.2 and 5.4.2). The standard errors assume white noise
    in y.
    
    Examples
    --------
    >>> robsim.estimation.least_squares([[1, 0], [0, 1], [1, 1]], [1, 2, 3.3])
    <LeastSquaresFit: theta [1.1 2.1], rank 2, condition 1.73, residual rms 0.1>
    """
def locate(blobs: collections.abc.Mapping[str, collections.abc.Sequence[Blob]], markers: MarkerLayout, plane_map: PlaneMap | None = None, *, image: Frame | numpy.typing.NDArray[numpy.uint8] | None = None, colors: collections.abc.Sequence[ColorClass] | None = None) -> Measurement | None:
    """
    Return the pose of the robot whose markers are among the blobs.
    
    The pair has a blob of each of the two colours, and is chosen based on the blobs' distance and
    areas. Blobs at the border of the frame are not used, because they may be cut off. With the image,
    the pose is then fitted to the pixels around the edges of the markers, by weighted least squares
    [1]_. The error is then half to two thirds of the centroids' error with noise, and a fifth without
    noise. For markers with unknown outlines, pixels at the edge are weighted by their colour.
    
    Parameters
    ----------
    blobs : dict of str to list of Blob
        From `find_blobs`; the two `MarkerLayout.colors` are used.
    markers : MarkerLayout
        The positions of the markers on the robot; from `MarkerLayout.from_markers` also their outlines.
    plane_map : PlaneMap, optional
        Map from pixels of the blobs' frame to the work area. Default: the map of `image`, if it is a
        Frame; otherwise the identity.
    image : Frame or array (H, W, 3) of uint8, optional
        The image of the blobs. By default, the pose comes from the blobs' centroids. Pass the Frame,
        ``step.frame``, not its pixels. An array has no plane map and no number of drawn headings, so
        the covariance would omit the rounding of the headings.
    colors : list of ColorClass, optional
        The colours used to find the blobs: a frame without a pair then gets a second chance, as in
        `detect`.
    
    Returns
    -------
    Measurement or None
        The pose; with the image, also its covariance, misfit and signal-to-noise ratio. None = not
        detected: no pair fits, two pairs fit equally well, or the markers are not distinguishable from
        the noise. `robsim.vision.detect` gives the reason.
    
    References
    ----------
    .. [1] R. Hartley, A. Zisserman, "Multiple View Geometry in Computer Vision", 2nd edition, 2003,
       appendix 6: Gauss-Newton iteration; chapter 5: its covariance.
    
    Examples
    --------
    >>> frame = robsim.Simulation(headings=None, seed=1).step().frame
    >>> blobs = robsim.find_blobs(frame, robsim.load_colors())
    >>> markers = robsim.load_robot("lab").marker_layout()
    >>> robsim.locate(blobs, markers, image=frame).pose.round(1) + 0.0  # px, px, rad
    array([600., 600.,   0.])
    """
def log(x: numpy.typing.ArrayLike) -> typing.Any:
    """
    Return the natural logarithm of a number, or of each in an array.
    """
def marker_roles() -> tuple[tuple[str, str], tuple[str, str]]:
    """
    The pairs of roles that two markers can have: right and left, front and back.
    """
def model_steps(time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], dt: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    Return the number of steps of a model with this dt (s) in each time (s); see RobotModel.steps_in.
    """
def parse_line(line: bytes) -> typing.Any:
    """
    Return the parts of a line, without its line break; None if damaged.
    """
def path_sensitivities(theta: numpy.typing.ArrayLike, path: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
    """
    Return the derivatives of a simulated path.
    
    Parameters
    ----------
    theta : array (3, 5)
        The parameters.
    path : array (n, 3)
        The path simulated with these parameters.
    u : array (n, 2)
        Inputs (V).
    
    Returns
    -------
    array (n, 3, 21)
        Derivatives by the first two values of x, of y and of the heading, and by the 15 parameters.
    """
def pixel_formats() -> list[tuple[str, str, int, str]]:
    """
    Return the cameras' pixel formats: name, coding, rank on FireWire (0: no rank), name in GenICam (empty: no name), for GenICam in the order of rank.
    """
def random_normal(seed: int, counter: int) -> float:
    """
    Return the standard normal number at a place in the stream of a seed.
    """
def random_uniform(seed: int, counter: int) -> float:
    """
    Return the number in [0, 1) at a place in the stream of a seed.
    """
def reduced(frame: Frame, width: int) -> numpy.typing.NDArray[numpy.uint8]:
    """
    Return a frame's pixels, reduced by whole factors to not less than a width; incomplete pixels at the right and below are dropped.
    """
def regression(poses: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    Return the samples of the robot model's predictor in an unbroken record.
    
    Parameters
    ----------
    poses : array (N, 3)
        Poses of N steps in a row: x, y (work-area px), heading (rad), wrapped or not.
    u : array (N, 2)
        The inputs given at these steps (V).
    
    Returns
    -------
    phi : array (N - 2, 3, 5)
        Regressors of steps 2..N-1 for the axes X, Y and P (heading).
    y : array (N - 2, 3)
        Outputs; y = sum(phi * theta, axis=2) for the true theta.
    
    Examples
    --------
    >>> trace = robsim.Simulation(control=robsim.DriveAround(), seed=1).run(50)
    >>> phi, y = robsim.estimation.regression(trace.pose_true, trace.u)
    >>> np.allclose((phi * robsim.RobotModel().theta).sum(axis=2), y)
    True
    """
def relative_masks(image: Frame | numpy.typing.NDArray[numpy.uint8], colors: collections.abc.Sequence[ColorClass], smoothing: int, gains: typing.Annotated[collections.abc.Sequence[float], "FixedSize(3)"], least_chroma: float) -> dict[str, numpy.typing.NDArray[numpy.bool]]:
    """
    The pixels of each colour relative to brightness: the masks of the second chance.
    """
def rgb_to_yuv(image: numpy.typing.NDArray[numpy.uint8]) -> numpy.typing.NDArray[numpy.uint8]:
    """
    Return Y, U and V of every pixel, as for the colour classes.
    
    Full-range BT.601 in coefficients of 7 bits, rounded down: Y = (38 R + 75 G + 15 B)/128,
    U = 128 + (-22 R - 42 G + 64 B)/128, V = 128 + (64 R - 54 G - 10 B)/128.
    
    Parameters
    ----------
    image : array (H, W, 3) of uint8
        RGB.
    
    Returns
    -------
    array (H, W, 3) of uint8
        Y, U, V.
    
    Examples
    --------
    >>> robsim.vision.rgb_to_yuv(np.uint8([[[255, 0, 0], [128, 128, 128]]]))[0]
    array([[ 75,  84, 255],
           [128, 128, 128]], dtype=uint8)
    """
def second_order_recursion(a1: float, a2: float, force: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
    """
    Return s(k) = a1 s(k-1) + a2 s(k-2) + force(k), column by column; s = 0 before the first.
    
    Parameters
    ----------
    a1, a2 : float
        The parameters.
    force : array (n,) or (n, m)
        The driving term.
    
    Returns
    -------
    array, shaped as force
        The path s.
    """
def simulated_path(theta: numpy.typing.ArrayLike, first: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
    """
    Return the path of the robot model with any parameters, stable or not.
    
    Parameters
    ----------
    theta : array (3, 5)
        Rows X, Y, P (heading), columns a1, a2, b1, b2, d1.
    first : array (2, 3)
        The first two poses.
    u : array (n, 2)
        Inputs (V), n >= 2.
    
    Returns
    -------
    array (n, 3)
        The poses; headings are not wrapped.
    """
def sin(x: numpy.typing.ArrayLike) -> typing.Any:
    """
    Return the sine of an angle (rad), or of each in an array.
    """
def small_markers_remark(width: float, noise: float) -> str | None:
    """
    A remark on markers too small for the noise; None for large enough ones.
    """
def surrounding_chroma(image: Frame | numpy.typing.NDArray[numpy.uint8]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Return U and V of most of an image, which is the floor around the markers.
    
    Parameters
    ----------
    image : Frame or array (H, W, 3) of uint8
        RGB.
    
    Returns
    -------
    array (2, 2)
        From the means over blocks of 7 x 7 pixels: the medians of U and V, and their spreads, half the
        distance between the 16th and the 84th percentile (levels).
    
    Raises
    ------
    TypeError, ValueError
        For an image of the wrong type or shape.
    
    Examples
    --------
    >>> frame = robsim.Simulation(seed=1).step().frame
    >>> medians, spreads = robsim.vision.surrounding_chroma(frame)
    >>> medians.round()
    array([125., 128.])
    """
def to_line(kind: str, number: int, u: numpy.typing.ArrayLike, time_to_live: int) -> bytes:
    """
    Return a line of the protocol to a robot.
    """
def to_rgb(raw: numpy.typing.ArrayLike, width: int, height: int, format: str, bits: int = 16) -> numpy.typing.NDArray[numpy.uint8]:
    """
    Return the pixels of a camera as RGB.
    
    Parameters
    ----------
    raw : buffer of bytes
        The rows, without gaps.
    width, height : int
        Size of the frame (px).
    format : str
        The camera's pixel format: a name in `pixel_formats`.
    bits : int
        Number of used bits of the 16 in ``"mono16"``.
    
    Returns
    -------
    array (H, W, 3) of uint8
        The image, read-only.
    
    Raises
    ------
    TypeError, ValueError
        If there are too few bytes, or the format does not have that size.
    """
def trace_schema() -> list[TraceGroup]:
    """
    Return the groups of columns of a trace, without `state` and `blobs_<color>`, whose widths vary.
    
    Returns
    -------
    list of TraceGroup
        The groups in the order of the documentation.
    """
def trusted_width(noise: float) -> float:
    """
    Smallest reliable width of markers (frame px) at a noise (grey levels).
    """
def view_warp(scene: Scene, size: tuple[int, int], plane_map: PlaneMap) -> Warp:
    """
    Return the warp from a scene to the frames of an oblique camera.
    """
def wrap_angle(angle: numpy.typing.ArrayLike) -> typing.Any:
    """
    Return the angle in (-pi, pi], equal up to full turns.
    
    Parameters
    ----------
    angle : float or array
        Angle (rad).
    
    Returns
    -------
    float or array
        Wrapped angle (rad), of the same shape.
    
    Examples
    --------
    >>> robsim.wrap_angle(np.radians([190, -190])).round(3)
    array([-2.967,  2.967])
    """
rank_tolerance: float = 1e-10
