// OpenSfM's reconstruction.json.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "calib/json_cursor.h"
#include "datasets/internal/json_vectors.h"
#include "datasets/reconstruction/internal/reconstruction_builder.h"
#include "datasets/reconstruction/reconstruction_file.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr std::size_t kMost = static_cast<std::size_t>(-1);
constexpr double kLargestNumber = 1e9;

double NumberOr(const JsonCursor& at, std::string_view key, double otherwise) {
  const auto found = at.Optional(key);
  return found ? found->NumberIn(-kLargestNumber, kLargestNumber) : otherwise;
}

// Lengths are in units of the picture's longer side, from its middle.
CameraIntrinsics ReadCamera(const JsonCursor& at) {
  CameraIntrinsics camera;
  camera.width_px = at.Required("width").IntegerIn(1, 65536);
  camera.height_px = at.Required("height").IntegerIn(1, 65536);
  const double unit_px = std::max(camera.width_px, camera.height_px);
  const std::string type =
      at.Required("projection_type").OneOf({"perspective", "simple_radial", "radial", "brown"});
  const bool one_focal_length = type == "perspective";
  camera.fx_px = unit_px * at.Required(one_focal_length ? "focal" : "focal_x").PositiveNumber();
  camera.fy_px = unit_px * at.Required(one_focal_length ? "focal" : "focal_y").PositiveNumber();
  camera.cx_px = unit_px * NumberOr(at, "c_x", 0.0) + 0.5 * (camera.width_px - 1);
  camera.cy_px = unit_px * NumberOr(at, "c_y", 0.0) + 0.5 * (camera.height_px - 1);
  camera.distortion = {NumberOr(at, "k1", 0.0),
                       NumberOr(at, "k2", 0.0),
                       NumberOr(at, "p1", 0.0),
                       NumberOr(at, "p2", 0.0),
                       NumberOr(at, "k3", 0.0)};
  return camera;
}

// An axis times an angle, and a translation.
glm::dmat4 ReadPose(const JsonCursor& at) {
  const glm::dvec3 turn = ReadVector3(at.Required("rotation"));
  const double angle = glm::length(turn);
  glm::dmat4 pose(1.0);
  if (angle > 0.0) pose = glm::mat4_cast(glm::angleAxis(angle, turn / angle));
  pose[3] = glm::dvec4(ReadVector3(at.Required("translation")), 1.0);
  return pose;
}

std::int64_t IdOf(const std::string& key, std::size_t index) {
  const bool is_number =
      !key.empty() && key.size() <= 18 &&
      std::all_of(key.begin(), key.end(), [](char c) { return c >= '0' && c <= '9'; });
  // OpenSfM counts points; merged reconstructions may name them as they like.
  return is_number ? std::stoll(key) : -1 - static_cast<std::int64_t>(index);
}

std::optional<Site> ReadReference(const JsonCursor& at) {
  const auto lla = at.Optional("reference_lla");
  if (!lla) return std::nullopt;
  Site site;
  site.latitude_rad = RadFromDeg(lla->Required("latitude").NumberIn(-90.0, 90.0));
  site.longitude_rad = RadFromDeg(lla->Required("longitude").NumberIn(-360.0, 360.0));
  site.height_m = lla->Required("altitude").NumberIn(-1000.0, 1e5);
  return site;
}

}  // namespace

Reconstruction ReadOpenSfm(const std::filesystem::path& file) {
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  const std::vector<JsonCursor> all = root.List(1, kMost);
  std::size_t biggest = 0;
  std::size_t most = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t pictures = all[i].Required("shots").Entries().size();
    if (pictures > most) {
      most = pictures;
      biggest = i;
    }
  }
  const JsonCursor& chosen = all[biggest];
  const auto where = [&](const char* key, const std::string& name) {
    std::string text = file.string() + ": ";
    text += chosen.Path() + "." + key + "." + name;
    return text;
  };
  ReconstructionBuilder builder;
  for (const auto& [name, at] : chosen.Required("cameras").Entries()) {
    builder.AddCamera(where("cameras", name), name, ReadCamera(at));
  }
  for (const auto& [name, at] : chosen.Required("shots").Entries()) {
    builder.AddPicture(where("shots", name), name, at.Required("camera").Text(), ReadPose(at));
  }
  std::size_t index = 0;
  for (const auto& [name, at] : chosen.Required("points").Entries()) {
    builder.AddPoint(where("points", name),
                     IdOf(name, index++),
                     ReadVector3(at.Required("coordinates")),
                     ReadVector3(at.Required("color")));
  }
  Reconstruction read = builder.Finish(file.string());
  read.enu_at = ReadReference(chosen);
  if (all.size() > 1) {
    read.notes.push_back("the biggest of " + std::to_string(all.size()) +
                         " reconstructions is used: " + std::to_string(most) + " pictures");
  }
  return read;
}

Reconstruction ReadReconstruction(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::is_regular_file(path, error)) return ReadOpenSfm(path);
  for (const char* name : {"cameras.bin", "cameras.txt"}) {
    if (fs::exists(path / name, error)) return ReadColmap(path);
  }
  if (fs::exists(path / "reconstruction.json", error)) {
    return ReadOpenSfm(path / "reconstruction.json");
  }
  throw std::runtime_error(
      path.string() +
      ": expected a folder with COLMAP's cameras, images and points3D (.bin or .txt), or OpenSfM's "
      "reconstruction.json" +
      (fs::exists(path, error) ? "" : ", found nothing"));
}

}  // namespace pleinair
