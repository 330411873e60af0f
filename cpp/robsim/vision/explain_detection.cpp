#include "robsim/vision/explain_detection.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "robsim/vision/marker_width.hpp"

namespace robsim {

namespace {

// A misfit of less than this is good, and one that is larger by this is much worse.
constexpr double good_misfit = 0.15;

// Lengths and areas that agree within this factor show the markers at another scale.
constexpr double same_scale = 1.25;

std::string number(double value, int decimals) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(decimals) << value;
  return text.str();
}

std::string px(double value) { return number(value, 1) + " px"; }

std::string both(const Detection& d, const char* link = " and ") {
  return d.markers.first.color + link + d.markers.second.color;
}

// The factor by which all of it is larger than the markers; 0 if that is not one factor.
double scale_of(const Detection& d) {
  const double scale = d.distance / d.markers.distance();
  const auto fits = [&](double seen, double expected) {
    const double ratio = std::sqrt(seen / expected) / scale;
    return ratio < same_scale && ratio > 1 / same_scale;  // NaN does not
  };
  const bool is_same =
      fits(d.first_area, d.markers.first.area) && fits(d.second_area, d.markers.second.area);
  return is_same ? scale : 0;
}

std::string explain_distance(const Detection& d) {
  const std::string seen = "the " + both(d) + " blobs seen are " + px(d.distance) +
                           " of the work area apart, the markers " + px(d.markers.distance());
  const double scale = scale_of(d);
  if (scale == 0) return seen + ": is it another robot?";
  return seen + ", and their areas fit markers " + number(scale, 2) +
         " times as large: is it another size of the work area, or another robot?";
}

std::string explain_area(const std::string& role, const std::string& color, double seen,
                         double expected) {
  return role + " marker (" + color + ") " + number(seen, 0) + " of " + number(expected, 0) +
         " px^2";
}

std::string explain_areas(const Detection& d) {
  const std::string pair = both(d) + " blobs " + px(d.distance) + " apart, as the markers are, ";
  const Marker &first = d.markers.first, &second = d.markers.second;
  const auto& [first_role, second_role] = names_of(d.markers.roles);
  const double first_expected = std::isnan(first.area) ? d.second_area : first.area;
  const double second_expected = std::isnan(second.area) ? d.first_area : second.area;
  const double tolerance = d.markers.area_tolerance;
  const bool is_small =
      d.first_area * tolerance < first_expected || d.second_area * tolerance < second_expected;
  const bool is_large =
      d.first_area > tolerance * first_expected || d.second_area > tolerance * second_expected;
  const std::string areas = pair + "have other areas than these: " +
                            explain_area(first_role, first.color, d.first_area, first_expected) +
                            ", " +
                            explain_area(second_role, second.color, d.second_area, second_expected);
  if (is_small && is_large) return areas + ": is it another robot?";
  if (is_small) return areas + ": are the frames darker than the colour ranges allow?";
  return areas + ": has something beside the markers their colour?";
}

std::string explain_missing(const std::string& color, const std::string& role) {
  return "no " + color + " blob was detected that could be the " + role +
         " marker: check the frame and the colours";
}

// Rounded away from what is compared with it: 4.96 is not shown as 5.0 where that is enough.
double rounded_down(double value) { return std::floor(10 * value) / 10; }
double rounded_up(double value) { return std::ceil(10 * value) / 10; }

std::string small_markers(double width, double noise) {
  return "the markers are " + px(rounded_down(width)) + " wide in the frame, and its noise is " +
         number(noise, 1) + " grey levels (" + number(noise / 2.55, 0) +
         " %): a signal-to-noise figure of " +
         number(rounded_down(expected_signal_to_noise(width, noise)), 1) +
         " in good light. Poses can be trusted from " + number(trusted_signal_to_noise, 0) +
         " on: in this noise, with markers of " + px(rounded_up(trusted_width(noise))) +
         " or more" +
         ". Give the camera more pixels, bring it nearer, make the markers larger, or give more "
         "light for less noise";
}

std::string explain_result(const Detection& d) {
  switch (d.result) {
    case DetectionResult::no_blobs:
      return "no " + both(d, " and no ") + " blob was detected: check the frame and the colours";
    case DetectionResult::no_first_blob:
      return explain_missing(d.markers.first.color, names_of(d.markers.roles)[0]);
    case DetectionResult::no_second_blob:
      return explain_missing(d.markers.second.color, names_of(d.markers.roles)[1]);
    case DetectionResult::at_border:
      return "all " + both(d, " or all ") +
             " blobs touch the border of the frame, where a marker may be cut off";
    case DetectionResult::distance:
      return explain_distance(d);
    case DetectionResult::areas:
      return explain_areas(d);
    case DetectionResult::ambiguous:
      return "two pairs of " + both(d) + " blobs fit the markers equally well (misfits " +
             number(d.misfit, 2) + " and " + number(d.runner_up, 2) + "): is something else as " +
             both(d, " or ") + "?";
    case DetectionResult::by_chance:
      return both(d) + " blobs fit the markers (misfit " + number(d.misfit, 2) +
             "), but so many others are about that " + number(d.false_alarms, 3) +
             " pairs of them fit as well by chance: is there more noise than markers of this size "
             "can bear, or much else as " +
             both(d) + "?";
    case DetectionResult::noise:
      return both(d) +
             " blobs fit the markers, but hardly stand out of the noise: signal to "
             "noise " +
             number(d.cause, 1) + ", at least " + number(least_signal_to_noise, 0) +
             " is needed. More light, less noise, or markers that are larger in the frame";
    case DetectionResult::dark:
      return "the picture is dark: mean level " + number(d.cause, 0) +
             " of 255. No robot was detected: more light, a longer exposure, or colours trained in "
             "this light";
    case DetectionResult::overexposed:
      return "the picture is overexposed: " + number(100 * d.cause, 0) +
             " % of its pixels are white. No robot was detected: less light, or a shorter exposure";
    case DetectionResult::small_markers:
      return small_markers(d.cause, d.noise);
    case DetectionResult::shape:
      return both(d) +
             " blobs fit the markers in distance and areas, but not in shape (misfit of the fit " +
             number(d.cause, 1) +
             "): is it no robot? If it is one, give more light, or train the colours in this light";
    case DetectionResult::detected:
      break;
  }
  const std::string pair = both(d) + " blobs " + px(d.distance) +
                           " of the work area apart fit the markers (misfit " +
                           number(d.misfit, 2) + ")";
  if (!d.by_second_chance) return pair;
  return pair +
         ", found at the second chance, by colours relative to brightness: the light is not that "
         "of the colour ranges, or the markers are faded; colours trained in this light find them "
         "at once";
}

}  // namespace

std::string name_of(DetectionResult result, const MarkerLayout& markers) {
  if (result == DetectionResult::no_first_blob) return "no " + markers.first.color + " blob";
  if (result == DetectionResult::no_second_blob) return "no " + markers.second.color + " blob";
  constexpr const char* names[] = {
      "detected",  "no blobs",  "",      "",     "at the border", "distance",      "areas",
      "ambiguous", "by chance", "noise", "dark", "overexposed",   "small markers", "shape"};
  return names[static_cast<std::size_t>(result)];
}

std::optional<std::string> small_markers_remark(double width, double noise) {
  return width < trusted_width(noise) ? std::optional(small_markers(width, noise)) : std::nullopt;
}

std::string explain(const Detection& detection) {
  const std::string text = explain_result(detection);
  // As in a frame whose channels are in OpenCV's order. Markers of about the same area never tell.
  const bool fits_exchanged =
      detection.exchanged < good_misfit && detection.misfit > detection.exchanged + 2 * good_misfit;
  if (!fits_exchanged) return text;
  return text + "; with " + both(detection) + " exchanged they would fit much better (misfit " +
         number(detection.exchanged, 2) +
         "): are the frames in OpenCV's order, BGR (Frame.from_bgr converts them), or the names "
         "of the colours exchanged?";
}

}  // namespace robsim
