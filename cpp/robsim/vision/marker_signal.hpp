#pragma once

namespace robsim {

/// Signal-to-noise figure of the markers' edges from which a pose can be trusted, and below which
/// it is none: so much stands out of the noise anywhere.
constexpr double trusted_signal_to_noise = 4;
constexpr double least_signal_to_noise = 3;

/// The signal-to-noise figure to be expected of two round markers of this width (frame px: the side
/// of a square of the same area) in good light and a sharp picture, with noise of this standard
/// deviation in each channel (grey levels):
/// SNR^2 = sum over both of |contrast|^2 / noise^2 perimeter blur / 3.5.
/// Below 4.5 px, where a marker is all edge, it falls with the area, too.
double expected_signal_to_noise(double width, double noise);

/// The width of markers from which a pose can be trusted at this noise (frame px): that of the
/// figure 4, but no less than 2 px, below which they are hardly ever found.
double trusted_width(double noise);

}  // namespace robsim
