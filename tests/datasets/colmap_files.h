// COLMAP's files, written for tests.
#pragma once

#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/gtc/quaternion.hpp>

#include "tests/scene/temporary_folder.h"

namespace pleinair {

struct ColmapCamera {
  std::uint32_t id = 1;
  std::int32_t model = 1;
  std::string model_name = "PINHOLE";
  std::uint64_t width = 640;
  std::uint64_t height = 480;
  std::vector<double> parameters = {500.0, 501.0, 320.5, 240.25};
};

struct ColmapImage {
  std::uint32_t id = 1;
  glm::dquat camera_from_model{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 translation{0.0};
  std::uint32_t camera = 1;
  std::string name = "one.jpg";
  struct Seen {
    double x;
    double y;
    std::uint64_t point;  // ~0: none.
  };
  std::vector<Seen> seen;
};

struct ColmapPoint {
  std::uint64_t id = 1;
  glm::dvec3 position{0.0};
  std::uint8_t r = 128;
  std::uint8_t g = 128;
  std::uint8_t b = 128;
};

struct ColmapModel {
  std::vector<ColmapCamera> cameras;
  std::vector<ColmapImage> images;
  std::vector<ColmapPoint> points;
};

template <typename Number>
void AppendBytes(Number value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

inline void WriteColmapBinary(const ColmapModel& model, const TemporaryFolder& folder) {
  std::string cameras;
  AppendBytes<std::uint64_t>(model.cameras.size(), cameras);
  for (const ColmapCamera& camera : model.cameras) {
    AppendBytes(camera.id, cameras);
    AppendBytes(camera.model, cameras);
    AppendBytes(camera.width, cameras);
    AppendBytes(camera.height, cameras);
    for (const double p : camera.parameters) AppendBytes(p, cameras);
  }
  std::string images;
  AppendBytes<std::uint64_t>(model.images.size(), images);
  for (const ColmapImage& image : model.images) {
    AppendBytes(image.id, images);
    const glm::dquat& q = image.camera_from_model;
    for (const double v : {q.w, q.x, q.y, q.z}) AppendBytes(v, images);
    for (int c = 0; c < 3; ++c) AppendBytes(image.translation[c], images);
    AppendBytes(image.camera, images);
    images.append(image.name.c_str(), image.name.size() + 1);
    AppendBytes<std::uint64_t>(image.seen.size(), images);
    for (const ColmapImage::Seen& seen : image.seen) {
      AppendBytes(seen.x, images);
      AppendBytes(seen.y, images);
      AppendBytes(seen.point, images);
    }
  }
  std::string points;
  AppendBytes<std::uint64_t>(model.points.size(), points);
  for (const ColmapPoint& point : model.points) {
    AppendBytes(point.id, points);
    for (int c = 0; c < 3; ++c) AppendBytes(point.position[c], points);
    for (const std::uint8_t c : {point.r, point.g, point.b}) AppendBytes(c, points);
    AppendBytes(0.5, points);
    AppendBytes<std::uint64_t>(1, points);
    AppendBytes<std::uint64_t>(0, points);
  }
  folder.Write("cameras.bin", cameras);
  folder.Write("images.bin", images);
  folder.Write("points3D.bin", points);
}

inline void WriteColmapText(const ColmapModel& model, const TemporaryFolder& folder) {
  std::string cameras = "# Camera list\n";
  for (const ColmapCamera& camera : model.cameras) {
    cameras +=
        fmt::format("{} {} {} {}", camera.id, camera.model_name, camera.width, camera.height);
    for (const double p : camera.parameters) cameras += fmt::format(" {}", p);
    cameras += "\n";
  }
  std::string images = "# Image list\n";
  for (const ColmapImage& image : model.images) {
    const glm::dquat& q = image.camera_from_model;
    const glm::dvec3& t = image.translation;
    images += fmt::format("{} {} {} {} {} {} {} {} {} {}\n",
                          image.id,
                          q.w,
                          q.x,
                          q.y,
                          q.z,
                          t.x,
                          t.y,
                          t.z,
                          image.camera,
                          image.name);
    for (const ColmapImage::Seen& seen : image.seen) {
      images += fmt::format("{} {} {} ", seen.x, seen.y, static_cast<std::int64_t>(seen.point));
    }
    images += "\n";
  }
  std::string points = "# 3D point list\n";
  for (const ColmapPoint& p : model.points) {
    points += fmt::format("{} {} {} {} {} {} {} 0.5 1 0\n",
                          p.id,
                          p.position.x,
                          p.position.y,
                          p.position.z,
                          p.r,
                          p.g,
                          p.b);
  }
  folder.Write("cameras.txt", cameras);
  folder.Write("images.txt", images);
  folder.Write("points3D.txt", points);
}

// Two pictures of three points; the second has none.
inline ColmapModel SmallColmapModel() {
  ColmapModel model;
  model.cameras.push_back({});
  ColmapImage first;
  first.camera_from_model = glm::normalize(glm::dquat(0.9, 0.1, -0.2, 0.3));
  first.translation = {0.25, -1.5, 3.0};
  first.name = "a walk/one.jpg";
  first.seen = {{10.5, 20.25, 7}, {30.0, 40.0, ~std::uint64_t{0}}, {50.0, 60.0, 3}};
  ColmapImage second;
  second.id = 2;
  second.name = "two.jpg";
  model.images = {first, second};
  model.points = {{7, {1.0, 2.0, 3.0}, 255, 0, 51}, {3, {-1.0, 0.5, 9.0}}, {4, {0.0, 0.0, 1.0}}};
  return model;
}

}  // namespace pleinair
