// A session's folder whose photographs really show its shots: synthetic bounces, painted. One thread's.
#pragma once

#include <filesystem>
#include <string>

#include "tests/host/archive/written_session.hpp"

namespace strobe::web_test {

inline constexpr double kPxPerM = 1500.0;
inline constexpr int kWidth_px = 960, kHeight_px = 560;
/// Of the plate's edge on the photographs, whose left and right ends differ in height by half a pixel.
inline constexpr double kSurfaceRow_px = 460.0;

/// The rig file of such a session: its scale is the photographs'.
std::string painted_rig();

/// Fires the shot, with a photograph of it in the session's folder and the frame that its host published.
void add_painted_shot(host_test::WrittenRun& run, const std::filesystem::path& session, int shot_id);

/// What a person calls where the k-th image of the ball is: column and row.
std::string image_place(int image, int shot_id = 1);

}  // namespace strobe::web_test
