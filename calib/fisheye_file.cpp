#include "calib/fisheye_file.h"

#include <stdexcept>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "calib/json_cursor.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

glm::dmat3 ReadMatrix(const JsonCursor& at) {
  glm::dmat3 matrix(1.0);
  const auto rows = at.List(3, 3);
  for (int row = 0; row < 3; ++row) {
    const auto entries = rows[row].List(3, 3);
    for (int column = 0; column < 3; ++column) matrix[column][row] = entries[column].Number();
  }
  return matrix;
}

// Converts one camera's colours to another's: white stays light. Single factors may be below 0.
glm::dmat3 ReadColourMatrix(const JsonCursor& at) {
  constexpr double kLargestFactor = 1e25;  // Between colours that FitColourTie takes.
  const auto rows = at.List(3, 3);
  for (const JsonCursor& row : rows) {
    double of_white = 0.0;
    for (const JsonCursor& entry : row.List(3, 3)) {
      of_white += entry.NumberIn(-kLargestFactor, kLargestFactor);
    }
    if (!(of_white >= 1.0 / kLargestFactor)) {
      row.Fail("numbers whose sum is above 0, as white light stays light");
    }
  }
  return ReadMatrix(at);
}

glm::dmat3 ReadOrthogonal(const JsonCursor& at) {
  constexpr double kTolerance = 1e-5;  // Written with six digits or more.
  const glm::dmat3 matrix = ReadMatrix(at);
  const glm::dmat3 product = glm::transpose(matrix) * matrix;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      if (!(std::abs(product[a][b] - (a == b ? 1.0 : 0.0)) <= kTolerance)) {
        at.Fail("an orthogonal matrix (a rotation, or a mirrored one)");
      }
    }
  }
  const glm::dvec3 axis = glm::normalize(matrix[2]);
  const glm::dvec3 right = glm::normalize(matrix[0] - glm::dot(matrix[0], axis) * axis);
  const glm::dvec3 down = glm::cross(axis, right);
  return {right, glm::determinant(matrix) < 0.0 ? -down : down, axis};
}

Json FromMatrix(const glm::dmat3& matrix) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) {
    rows.push_back({matrix[0][row], matrix[1][row], matrix[2][row]});
  }
  return rows;
}

constexpr int kMaxSidePx = 65536;

}  // namespace

FisheyeCalibration ReadFisheyeCalibration(const std::filesystem::path& file) {
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  root.CheckKeys({"format",
                  "version",
                  "model",
                  "width",
                  "height",
                  "fx",
                  "fy",
                  "cx",
                  "cy",
                  "distortion",
                  "fov_deg",
                  "orientation_world_from_camera",
                  "room_from_fisheye_rgb",
                  "rms_px"});
  root.Required("format").OneOf({"pleinair-fisheye"});
  root.Required("version").IntegerIn(1, 1);
  FisheyeCalibration calibration;
  FisheyeIntrinsics& lens = calibration.intrinsics;
  lens.model = *FisheyeModelFromName(
      root.Required("model").OneOf({"equidistant", "equisolid", "stereographic", "opencv"}));
  lens.width_px = root.Required("width").IntegerIn(1, kMaxSidePx);
  lens.height_px = root.Required("height").IntegerIn(1, kMaxSidePx);
  lens.fx_px = root.Required("fx").PositiveNumber();
  lens.fy_px = root.Required("fy").PositiveNumber();
  lens.cx_px = root.Required("cx").NumberIn(-1e6, 1e6);
  lens.cy_px = root.Required("cy").NumberIn(-1e6, 1e6);
  if (lens.model == FisheyeModel::kOpenCv) root.Required("distortion");
  if (const auto distortion = root.Optional("distortion")) {
    const auto coefficients = distortion->List(4, 4);
    for (std::size_t i = 0; i < 4; ++i) {
      lens.distortion[i] = coefficients[i].Number();
      if (lens.model != FisheyeModel::kOpenCv && lens.distortion[i] != 0.0) {
        coefficients[i].Fail("0, as the model has no distortion");
      }
    }
  }
  lens.max_angle_rad = 0.5 * RadFromDeg(root.Required("fov_deg").NumberIn(1e-3, 360.0));
  if (const auto at = root.Optional("orientation_world_from_camera")) {
    calibration.world_from_camera = ReadOrthogonal(*at);
  }
  if (const auto at = root.Optional("room_from_fisheye_rgb")) {
    calibration.room_from_fisheye_rgb = ReadColourMatrix(*at);
  }
  if (const auto at = root.Optional("rms_px")) calibration.rms_px = at->NumberIn(0.0, 1e9);
  try {
    FisheyeLens{lens};
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
  return calibration;
}

std::string FisheyeCalibrationText(const FisheyeCalibration& calibration) {
  const FisheyeIntrinsics& lens = calibration.intrinsics;
  Json json = {{"format", "pleinair-fisheye"},
               {"version", 1},
               {"model", FisheyeModelName(lens.model)},
               {"width", lens.width_px},
               {"height", lens.height_px},
               {"fx", lens.fx_px},
               {"fy", lens.fy_px},
               {"cx", lens.cx_px},
               {"cy", lens.cy_px}};
  if (lens.model == FisheyeModel::kOpenCv) json["distortion"] = lens.distortion;
  json["fov_deg"] = DegFromRad(2.0 * lens.max_angle_rad);
  if (calibration.world_from_camera) {
    json["orientation_world_from_camera"] = FromMatrix(*calibration.world_from_camera);
  }
  if (calibration.room_from_fisheye_rgb) {
    json["room_from_fisheye_rgb"] = FromMatrix(*calibration.room_from_fisheye_rgb);
  }
  if (calibration.rms_px) json["rms_px"] = *calibration.rms_px;
  return json.dump(1) + "\n";
}

}  // namespace pleinair
