// How a scene's photographs appear; sim/photograph renders them. Each struct is a table of
// the scene's file, as in scene.hpp. A key that is absent where the default is "drawn" takes another value
// for each photograph, from the range given. Plain values.
#pragma once

#include <optional>

namespace strobe::sim {

enum class PhotographFormat {
  tiff,  ///< uncompressed
  png,
  dng,     ///< the RAW file of a camera with a Bayer mosaic
  mosaic,  ///< the same numbers as a mosaic TIFF (common/image/image_files.hpp)
};
inline bool is_mosaic(PhotographFormat format) {
  return format == PhotographFormat::dng || format == PhotographFormat::mosaic;
}

/// Of a mosaic whose scene does not say.
inline constexpr int kMosaicBits = 14;

/// How a ball's surface looks apart from its line.
enum class BallSurface {
  felt,      ///< grain, seams, a logo, a little fuzz at the limb
  plain,     ///< uniform and matt
  dimples,   ///< shiny, with rows of dimples and print: a golf ball
  stitches,  ///< leather with a seam of two rows: a baseball
  band,      ///< dark glossy leather with six light rows around it: a cricket ball
  panels,    ///< twelve dark pentagons among hexagons: a football
  channels,  ///< dark channels between eight panels: a basketball
  holes,     ///< forty of them, which also notch the outline: a pickleball
  dots,      ///< two dozen dark ones, evenly spread
};

/// [photograph] The sensor behind the lens, the file, and how much light there is. "Light" below: 1 is what
/// saturates the sensor.
struct PhotographSettings {
  int width_px = 0;   ///< 16…20000; 0 (key absent): as wide as holds the view and .045 m to the right of it
  int height_px = 0;  ///< likewise, and .035 m above the view
  PhotographFormat format = PhotographFormat::tiff;  ///< key format = "tiff" | "png" | "dng" | "mosaic"
  /// 8, 12 (in 16: the largest number is 4095), 14 or 16; of a mosaic 14 (key absent), or 12 or 16.
  int bits = 8;
  double exposure = 1.0;         ///< 0.01…100; at 1 the lightest felt of one image has a light of .45
  double gamma = 1.0;            ///< 0.3…3; the number written is light to this power (.45: as on a screen)
  double full_well_e = 15000.0;  ///< 100…1e6 electrons at a light of 1: the shot noise's sd is 1/sqrt of it
  double read_noise_e = 8.0;     ///< 0…1000
  double black_level = 0.005;    ///< 0…0.2; light that a dark sensor shows
  std::optional<double> blur_px;     ///< 0…10, sd of the lens's blur; drawn: .5…1.1
  double defocus_px = 0.0;           ///< 0…10, radius of the disc of a point out of focus
  std::optional<double> vignetting;  ///< 0…0.9, light lost in the corners; drawn: .05….3
  double lamp_a_power = 1.0;         ///< 0…10; lamp A stands to the left, 0: it has failed
  double lamp_b_power = 1.0;         ///< 0…10
  double flash_power_sd = 0.02;      ///< 0…0.3, of the light from flash to flash, relative
  double second_flash = 0.0;         ///< 0…0.9, part of a flash's light that comes in a second discharge
  double second_flash_s = 30e-6;     ///< key second_flash_us 0…400: so much later; the truth is of the mean
  double ambient = 0.0;              ///< 0…0.9; light of the room while the shutter was open
  /// Key setup = "drawn" | "steady": what is drawn of lamps, lens, ball and background, anew for each
  /// photograph or once for the rig.
  bool steady = false;
};

/// [ball_appearance] The ball on the photograph.
struct BallAppearanceSettings {
  BallSurface surface =
      BallSurface::felt;                ///< key surface = "felt" | "plain" and so on; absent: of [ball] kind
  bool line = true;                     ///< whether the equator line is drawn on it; absent: likewise
  std::optional<double> albedo;         ///< 0.02…2, over the lightest felt's; 1, of band and channels less
  std::optional<double> shine;          ///< 0…2, height of a reflected lamp; drawn by the surface
  std::optional<double> line_width_m;   ///< key line_width_mm 0.3…15; drawn: 1.5…4 mm
  std::optional<double> line_contrast;  ///< 0…1, darkness over the felt's; drawn: .5….95
  std::optional<double> line_tilt_rad;  ///< key line_tilt_deg -75…75; drawn: sd 1.5, at most 5
  double line_offset = 0.0;     ///< -0.1…0.1 of the radius, of the line's plane from the ball's centre
  std::optional<double> grain;  ///< 0…0.5, relative sd of the felt's albedo; drawn: .02….1
  /// -10…1, of seams, stitches, panels, holes or dots: darker than the rest; drawn: of felt -.3 (lighter)….4
  std::optional<double> seam_contrast;
  std::optional<double> logo_contrast;   ///< -10…1; drawn: 0….8
  std::optional<double> fuzz_px;         ///< 0…5, half width of the limb's fade; drawn: 0….5
  std::optional<double> lamp_height_m;   ///< -5…5, over the view's middle; drawn: -.2….8
  std::optional<double> lamp_aside_m;    ///< 0.05…10, of each lamp from the view's middle; drawn: .5…1.6
  std::optional<double> lamp_forward_m;  ///< 0.1…20, from the balls' plane; drawn: .5…2
};

/// [background] What every flash lights besides the ball. Brightness: of the whole exposure, over that of the
/// lightest felt in one image.
struct BackgroundSettings {
  std::optional<double> wall;               ///< 0…2, brightness behind the balls; drawn: .01….1
  double wall_distance_m = 0.6;             ///< 0.1…20, behind the balls: how far shadows lie aside
  bool plate = true;                        ///< whether there is one to be seen
  std::optional<double> plate_brightness;   ///< 0…20; drawn: .4…4
  std::optional<double> plate_thickness_m;  ///< key plate_thickness_mm 1…200; drawn: 8…25 mm
  double plate_depth_m = 0.1;  ///< key plate_depth_mm 0…2000, towards the lens; seen only with a distance_m
  std::optional<double> plate_half_length_m;  ///< 0.05…5; drawn: 1.05…1.3 of the camera's half width
  double clutter = 0.3;  ///< 0…3, how much stands about: clamps, blocks, cables, reflections
  int blobs = 0;         ///< 0…20, bright things of up to a ball's size in the view
  /// 1…100,000: the brightness is that of so many flashes of both lamps, each of which adds its light; 0 (key
  /// absent): of every exposure, however many there were.
  int flashes = 0;
};

}  // namespace strobe::sim
