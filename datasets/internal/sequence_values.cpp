#include "datasets/internal/sequence_values.h"

#include <cmath>
#include <stdexcept>
#include <system_error>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "calib/timed_pose.h"
#include "datasets/internal/sequence_folder.h"
#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

// Row-major in the file, columns in glm.
glm::dmat4 ReadAffine(const JsonCursor& at) {
  glm::dmat4 matrix(1.0);
  const auto rows = at.List(4, 4);
  for (int row = 0; row < 4; ++row) {
    const auto entries = rows[row].List(4, 4);
    for (int column = 0; column < 4; ++column) matrix[column][row] = entries[column].Number();
    if (row == 3 && glm::dvec4(matrix[0][3], matrix[1][3], matrix[2][3], matrix[3][3]) !=
                        glm::dvec4(0.0, 0.0, 0.0, 1.0)) {
      rows[row].Fail("the row 0, 0, 0, 1");
    }
  }
  return matrix;
}

}  // namespace

glm::dvec2 ReadVector2(const JsonCursor& at) {
  const auto entries = at.List(2, 2);
  return {entries[0].Number(), entries[1].Number()};
}

glm::dmat4 ReadRigid(const JsonCursor& at) {
  const glm::dmat4 matrix = ReadAffine(at);
  if (const std::string fault = FaultOfPose(matrix); !fault.empty()) at.Fail(fault);
  return matrix;
}

glm::dmat4 ReadInvertible(const JsonCursor& at) {
  const glm::dmat4 matrix = ReadAffine(at);
  const glm::dmat3 linear(matrix);
  // Relative to the volume that the columns' lengths would span: scale does not matter.
  const double volume = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
  if (!(std::abs(glm::determinant(linear)) > 1e-9 * volume)) at.Fail("an invertible transform");
  return matrix;
}

UtcTime ReadTime(const JsonCursor& at) {
  try {
    return ParseUtcTime(at.Text());
  } catch (const std::invalid_argument&) {
    at.Fail("a UTC time such as 2005-06-21T09:50:00.25Z");
  }
}

std::vector<std::string> ReadTexts(const JsonCursor& at) {
  std::vector<std::string> texts;
  for (const JsonCursor& entry : at.List(0, kAnyCount)) texts.push_back(entry.Text());
  return texts;
}

std::optional<double> ReadPoseStddevRad(const JsonCursor& camera) {
  const auto uncertain = camera.Optional("pose_uncertain_deg");
  if (!uncertain) return std::nullopt;
  return RadFromDeg(uncertain->NumberIn(0.0, 180.0));
}

CameraIntrinsics ReadIntrinsics(const JsonCursor& at) {
  at.CheckKeys({"width",
                "height",
                "fx",
                "fy",
                "cx",
                "cy",
                "pose_uncertain_deg",
                "distortion",
                "distortion_model",
                "pixel_centers",
                "camera_from_world"});
  CameraIntrinsics camera;
  camera.width_px = at.Required("width").IntegerIn(1, kMaxImageSidePx);
  camera.height_px = at.Required("height").IntegerIn(1, kMaxImageSidePx);
  camera.fx_px = at.Required("fx").PositiveNumber();
  camera.fy_px = at.Required("fy").PositiveNumber();
  camera.cx_px = at.Required("cx").NumberIn(-1e6, 1e6);
  camera.cy_px = at.Required("cy").NumberIn(-1e6, 1e6);
  if (const auto distortion = at.Optional("distortion")) {
    const auto coefficients = distortion->List(5, 5);
    for (std::size_t i = 0; i < 5; ++i) camera.distortion[i] = coefficients[i].Number();
  }
  if (const auto model = at.Optional("distortion_model")) model->OneOf({"opencv"});
  if (const auto centers = at.Optional("pixel_centers")) centers->OneOf({"integer"});
  return camera;
}

Weather ReadWeather(const JsonCursor& at) {
  return WeatherNamed(at.OneOf({"overcast", "broken", "clear"})).value();
}

std::filesystem::path ReadPathInside(const JsonCursor& at, const std::filesystem::path& folder) {
  const std::string text = at.Text();
  const auto inside = ResolveInside(folder, text);
  if (!inside) at.Fail(inside.error());
  return std::filesystem::path(text).lexically_normal();
}

std::filesystem::path ReadExistingFile(const JsonCursor& at, const std::filesystem::path& folder) {
  std::filesystem::path path = ReadPathInside(at, folder);
  std::error_code error;
  if (!std::filesystem::is_regular_file(folder / path, error)) {
    at.Fail("the path of an existing file");
  }
  return path;
}

}  // namespace pleinair
