// Maps between the pixels of frames and the work area, through a camera's lens.
#include <algorithm>

#include "python/values.hpp"
#include "robsim/imaging/plane_map.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

using ThreeByThree = PlaneMap::Matrix;

ThreeByThree three_by_three_from(const ArrayLike& value, const std::string& expected) {
  const Doubles m = doubles_from(value, "matrix", Shape{3, 3}, expected + ", shape (3, 3)");
  ThreeByThree values;
  std::copy_n(m.data(), 9, values.begin());
  return values;
}

Intrinsics intrinsics_from(const ArrayLike& matrix, const std::optional<ArrayLike>& distortion) {
  const std::string expected = "a camera's [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]";
  const ThreeByThree m = three_by_three_from(matrix, expected);
  if (m[1] != 0 || m[3] != 0 || m[6] != 0 || m[7] != 0 || m[8] != 1) {
    throw py::value_error("matrix must be " + expected + ", got " +
                          describe(to_array(m.data(), {3, 3}).attr("tolist")()));
  }
  Intrinsics::Distortion values{};
  if (distortion) {
    const Doubles given =
        doubles_from(*distortion, "distortion", Shape{5}, "the five numbers k1, k2, p1, p2, k3");
    std::copy_n(given.data(), values.size(), values.begin());
  }
  return Intrinsics({m[0], m[4]}, {m[2], m[5]}, values);
}

py::array_t<double> camera_matrix(const Intrinsics& self) {
  const ThreeByThree m = {
      self.focal().x, 0, self.centre().x, 0, self.focal().y, self.centre().y, 0, 0, 1};
  return to_array(m.data(), {3, 3});
}

std::optional<Intrinsics> intrinsics_in(const PlaneMap& self) {
  return self.intrinsics() ? std::optional(*self.intrinsics()) : std::nullopt;
}

PlaneMap plane_map_from(const std::optional<ArrayLike>& matrix,
                        const std::optional<Intrinsics>& intrinsics) {
  return PlaneMap(matrix ? three_by_three_from(*matrix, "a homography") : PlaneMap().matrix(),
                  intrinsics);
}

std::string repr(const PlaneMap& self) {
  std::string text;
  if (self.matrix() != PlaneMap().matrix()) {
    text = py::repr(to_array(self.matrix().data(), {3, 3}).attr("tolist")()).cast<std::string>();
  }
  if (self.intrinsics()) {
    text += (text.empty() ? "" : ", ") + std::string("intrinsics=") +
            py::repr(py::cast(*self.intrinsics())).cast<std::string>();
  }
  return "PlaneMap(" + text + ")";
}

std::vector<Point> points_from(py::handle value, const std::string& name) {
  const std::string expected = "four or more points, finite numbers of shape (N, 2)";
  const Doubles array = doubles_from(value, name, Shape{-1, 2}, expected);
  if (array.shape(0) < 4) {
    throw py::value_error(name + " must be " + expected + ", got " + describe(value));
  }
  std::vector<Point> points;
  for (py::ssize_t i = 0; i < array.shape(0); ++i)
    points.push_back({array.at(i, 0), array.at(i, 1)});
  return points;
}

// A map of points as a method that maps one point (2,) or many (N, 2), the argument `name`.
template <typename Class>
void define_map(Class& cls, const char* method, Point (Class::type::*map)(const Point&) const,
                const char* name, const char* doc) {
  const auto call = [map, name](const typename Class::type& self, const ArrayLike& value) {
    const std::string expected = "a point (2,) or points (N, 2)";
    const Doubles points = doubles_from(value, name, std::nullopt, expected);
    const py::ssize_t dimensions = points.ndim();
    if (dimensions < 1 || dimensions > 2 || points.shape(dimensions - 1) != 2) {
      throw py::value_error(name + (" must be " + expected) + ", got " + describe(value));
    }
    py::array_t<double> result(Shape(points.shape(), points.shape() + dimensions));
    const double* from = points.data();
    double* to = result.mutable_data();
    for (py::ssize_t i = 0; i < points.size(); i += 2) {
      const Point p = (self.*map)({from[i], from[i + 1]});
      to[i] = p.x;
      to[i + 1] = p.y;
    }
    return result;
  };
  cls.def(method, call, py::arg(name), doc);
}

void bind_intrinsics(py::module_& module) {
  Class<Intrinsics> intrinsics(public_in(module, "robsim.vision"), "Intrinsics", R"(
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
)");
  const auto distortion = [](const Intrinsics& self) {
    return to_array(self.distortion().data(), {5});
  };
  const Fields fields(
      &intrinsics_from, Field("matrix", &camera_matrix, "array (3, 3): the camera matrix (px)."),
      Field("distortion", distortion, "array (5,): k1, k2, p1, p2, k3.", std::nullopt));
  define_value(intrinsics, fields);
  define_repr(intrinsics, fields);
  define_map(intrinsics, "distorted", &Intrinsics::distorted, "pixels", R"(
Return the frame pixels for pixels of an ideal lens.

Parameters
----------
pixels : array (2,) or (N, 2)
    Ideal pixels (u, v).

Returns
-------
array (2,) or (N, 2)
    Pixels (u, v) of the frames; NaN where the lens shows nothing.
)");
  define_map(intrinsics, "ideal", &Intrinsics::ideal, "pixels", R"(
Return the pixels of an ideal lens for frame pixels.

Parameters
----------
pixels : array (2,) or (N, 2)
    Pixels (u, v) of the frames.

Returns
-------
array (2,) or (N, 2)
    Ideal pixels (u, v); NaN where the lens shows nothing.
)");
}

void bind_plane_map(py::module_& module) {
  Class<PlaneMap> plane_map(public_in(module, "robsim.vision"), "PlaneMap", R"(
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
)");
  const auto matrix = [](const PlaneMap& self) { return to_array(self.matrix().data(), {3, 3}); };
  define_value(
      plane_map,
      Fields(
          &plane_map_from,
          Field("matrix", matrix,
                "array (3, 3): the homography from pixels, ideal ones with intrinsics, to the "
                "work area.",
                std::nullopt),
          Field("intrinsics", &intrinsics_in, "Intrinsics or None: the camera's.", std::nullopt)));
  plane_map
      .def_static(
          "scaled",
          [](std::pair<int, int> resolution, std::pair<double, double> area) {
            if (resolution.first < 1 || resolution.second < 1) {
              throw py::value_error("resolution must be (width, height) in px, both above 0");
            }
            for (const double size : {area.first, area.second}) {
              if (!(size > 1e-3 && size < 1e9)) {
                throw py::value_error("area must be (width, height) in work-area px, both above 0");
              }
            }
            return PlaneMap::scaled(resolution.first, resolution.second, area.first, area.second);
          },
          "resolution"_a, "area"_a, R"(
Return the map of a camera that sees the whole area.

Parameters
----------
resolution : tuple of int
    Width and height of the frame (px).
area : tuple of float
    Width and height of the area (work-area px).
)")
      .def_static(
          "from_points",
          [](const ArrayLike& pixels, const ArrayLike& positions,
             const std::optional<Intrinsics>& intrinsics) {
            return PlaneMap::from_points(points_from(pixels, "pixels"),
                                         points_from(positions, "positions"), intrinsics);
          },
          "pixels"_a, "positions"_a, "intrinsics"_a = py::none(), R"(
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
)")
      .def("at_height", &PlaneMap::at_height, "height"_a, R"(
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
)");
  define_map(plane_map, "to_world", &PlaneMap::to_world, "pixels", R"(
Return the positions of pixels.

Parameters
----------
pixels : array (2,) or (N, 2)
    Pixels (u, v).

Returns
-------
array (2,) or (N, 2)
    Positions (x, y) in work-area px; NaN where the lens shows nothing.
)");
  define_map(plane_map, "to_pixel", &PlaneMap::to_pixel, "positions", R"(
Return the pixels of positions.

Parameters
----------
positions : array (2,) or (N, 2)
    Positions (x, y) in work-area px.

Returns
-------
array (2,) or (N, 2)
    Pixels (u, v); NaN where the lens shows nothing.
)");
  plane_map.def("__repr__", &repr);
}

}  // namespace

void bind_plane_maps(py::module_& module) {
  bind_intrinsics(module);
  bind_plane_map(module);
}
