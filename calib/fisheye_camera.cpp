#include "calib/fisheye_camera.h"

#include <array>
#include <cctype>
#include <cmath>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

namespace pleinair {
namespace {

struct NamedAxis {
  std::string_view axis;
  std::string_view word;
  glm::dvec3 direction;
};

const std::array<NamedAxis, 6>& NamedAxes() {
  static const std::array<NamedAxis, 6> axes{{{"+x", "east", {1.0, 0.0, 0.0}},
                                              {"-x", "west", {-1.0, 0.0, 0.0}},
                                              {"+y", "north", {0.0, 1.0, 0.0}},
                                              {"-y", "south", {0.0, -1.0, 0.0}},
                                              {"+z", "up", {0.0, 0.0, 1.0}},
                                              {"-z", "down", {0.0, 0.0, -1.0}}}};
  return axes;
}

// Lower case, split at blanks, brackets left out.
std::vector<std::string> WordsOf(std::string_view text) {
  std::vector<std::string> words(1);
  for (const char letter : text) {
    if (letter == '(' || letter == ')') continue;
    if (letter == ' ') {
      if (!words.back().empty()) words.emplace_back();
      continue;
    }
    words.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

}  // namespace

std::optional<glm::dvec3> WorldAxisFromText(std::string_view text) {
  const std::vector<std::string> words = WordsOf(text);
  if (words.empty()) return std::nullopt;
  std::optional<glm::dvec3> found;
  for (const std::string& word : words) {
    std::optional<glm::dvec3> named;
    for (const NamedAxis& axis : NamedAxes()) {
      if (word == axis.axis || word == axis.word) named = axis.direction;
    }
    if (!named || (found && *found != *named)) return std::nullopt;
    found = named;
  }
  return found;
}

std::optional<glm::dmat3> FisheyeOrientationFromAxes(const glm::dvec3& axis_world,
                                                     const glm::dvec3& image_up_world,
                                                     const glm::dvec3& image_right_world) {
  const glm::dmat3 matrix(glm::normalize(image_right_world),
                          -glm::normalize(image_up_world),
                          glm::normalize(axis_world));
  // 0.2 arc seconds, far beyond what words or a rounded file can mean.
  constexpr double kTolerance = 1e-6;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < a; ++b) {
      if (!(std::abs(glm::dot(matrix[a], matrix[b])) <= kTolerance)) return std::nullopt;
    }
  }
  return matrix;
}

FisheyePixelTable MakeFisheyePixelTable(const FisheyeCamera& camera) {
  const FisheyeLens lens(camera.intrinsics);
  const int width = camera.intrinsics.width_px;
  const int height = camera.intrinsics.height_px;
  FisheyePixelTable table{Image<glm::vec3>(width, height, glm::vec3(0.0f)),
                          Image<float>(width, height, 0.0f)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto direction = lens.DirectionFromPixel({x, y});
      if (!direction) continue;
      table.direction_world.At(x, y) = glm::vec3(camera.world_from_camera * *direction);
      table.solid_angle_sr.At(x, y) = static_cast<float>(lens.PixelSolidAngleSr({x, y}));
    }
  }
  return table;
}

}  // namespace pleinair
