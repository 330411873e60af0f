#include <algorithm>
#include <cmath>

#include "python/interpreter.hpp"
#include "python/signature.hpp"
#include "robsim/world/scene.hpp"
#include "robsim/world/visual_noise.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

Layer layer_from(const std::pair<PixelArray, PixelArray>& images, const std::string& name) {
  return {copy_of(image_view(images.first, name + "[0]")),
          copy_of(image_view(images.second, name + "[1]"))};
}

Sprite sprite_from(const PixelArray& value) {
  if (!py::isinstance<py::array_t<std::uint8_t>>(value)) {
    throw py::type_error("sprite must be a uint8 RGBA array, got " + describe(value));
  }
  const auto array = py::array_t<std::uint8_t, py::array::c_style>::ensure(value);
  if (!array || array.ndim() != 3 || array.shape(2) != 4 || array.size() == 0) {
    throw py::value_error("sprite must be a uint8 RGBA array of shape (H, W, 4), got " +
                          describe(value));
  }
  return premultiplied(array.data(), static_cast<int>(array.shape(1)),
                       static_cast<int>(array.shape(0)));
}

std::shared_ptr<Scene> make_scene(const std::pair<PixelArray, PixelArray>& floor,
                                  const std::pair<PixelArray, PixelArray>& home, int shadow_left,
                                  double shadow_factor, const PixelArray& sprite,
                                  const Point& centre, double unit, double alignment, int headings,
                                  std::pair<int, int> area) {
  if (shadow_left < 0) throw py::value_error("shadow_left must be at least 0 px");
  if (area.first < 1 || area.second < 1) throw py::value_error("area must be above 0");
  if (!std::isfinite(alignment)) throw py::value_error("alignment must be finite (rad)");
  Background background(layer_from(floor, "floor"), layer_from(home, "home"), shadow_left,
                        shadow_factor);
  const PlaneMap camera =
      PlaneMap::scaled(background.width(), background.height(), area.first, area.second);
  RobotImage robot(sprite_from(sprite), centre, unit, alignment, headings, camera);
  return std::make_shared<Scene>(std::move(background), std::move(robot), camera);
}

py::array_t<std::uint8_t> rendered(Renderer& self, const Pose& pose, std::pair<int, int> pan,
                                   const std::optional<PixelArray>& out) {
  const Pan moved{pan.first, pan.second};
  if (!out) return to_array(self.render(pose, moved));
  const WritableView view = writable_view(*out, "out");
  const std::shared_ptr<const Scene> scene = self.scene();
  if (view.width != scene->width() || view.height != scene->height()) {
    throw py::value_error("out must have the size of the frames, " +
                          std::to_string(scene->width()) + " x " + std::to_string(scene->height()) +
                          " px, got " + describe(*out));
  }
  {
    const WithoutInterpreter native;
    scene->draw(pose, moved, view);
  }
  return py::reinterpret_borrow<py::array_t<std::uint8_t>>(*out);
}

py::array with_noise(const VisualNoise& self, const PixelArray& image, std::uint64_t seed,
                     std::uint64_t index, const std::optional<PixelArray>& out) {
  const ImageView clean = image_view(image, "image");
  Image noisy;
  if (!out) noisy = Image(clean.width, clean.height);
  const WritableView to = !out ? noisy.writable_view() : writable_view(*out, "out");
  if (to.width != clean.width || to.height != clean.height) {
    throw py::value_error("out must have the shape of image, " + describe(image) + ", got " +
                          describe(*out));
  }
  const bool is_in_place = to.data == clean.data && to.stride == clean.stride;
  if (out && !is_in_place &&
      py::module_::import("numpy").attr("may_share_memory")(image, *out).cast<bool>()) {
    throw py::value_error("out must be image itself, or share no memory with image");
  }
  {
    const WithoutInterpreter native;
    self.add(clean, seed, index, to);
  }
  return !out ? py::array(to_array(noisy)) : py::array(*out);
}

}  // namespace

void bind_scene(py::module_& module) {
  Class<Scene, std::shared_ptr<Scene>>(public_in(module, "robsim.simulation"), "Scene", R"(
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
)")
      .def(py::init(&make_scene), py::kw_only(), "floor"_a, "home"_a, "shadow_left"_a,
           "shadow_factor"_a, "sprite"_a, "centre"_a, "unit"_a, "alignment"_a, "headings"_a,
           "area"_a)
      .def_property_readonly(
          "nbytes",
          [](const Scene& self) { return std::int64_t{4 * 3} * self.width() * self.height(); },
          "int: memory of the four images of the floor.")
      .def("__repr__", [](const Scene& self) {
        return py::str("<Scene: {} x {} px>").format(self.width(), self.height());
      });

  Class<Renderer>(public_in(module, "robsim.simulation"), "Renderer", R"(
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
)")
      .def(py::init([](std::shared_ptr<Scene> scene) { return Renderer(std::move(scene)); }),
           "scene"_a.none(false))
      .def_property_readonly(
          "scene",
          [](const Renderer& self) { return std::const_pointer_cast<Scene>(self.scene()); },
          "Scene: the drawn scene, for other renderers.")
      .def("render", &rendered, "pose"_a, "pan"_a = std::make_pair(0, 0), py::kw_only(),
           "out"_a = py::none(), R"(
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
)");

  Class<VisualNoise>(public_in(module, "robsim._core"), "VisualNoise",
                     "Noise of the camera. Users take robsim.GaussianNoise or UniformNoise.")
      .def(py::init(
               [](double gaussian, double uniform) { return VisualNoise({gaussian, uniform}); }),
           py::kw_only(), "gaussian"_a = 0.0, "uniform"_a = 0.0)
      .def("add", &with_noise, "image"_a, "seed"_a, "index"_a = 0, py::kw_only(),
           "out"_a = py::none(), "See robsim.GaussianNoise.add.");
}
