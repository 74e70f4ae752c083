// Three houses on a lawn, and pictures of them, ray cast.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/lens.h"
#include "scene/image.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"
#include "tests/calib/marker_scene.h"

namespace pleinair {

inline void AddBox(Mesh& mesh, const glm::vec3& lower, const glm::vec3& upper) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (std::uint32_t i = 0; i < 8; ++i) {
    mesh.positions_m.emplace_back(
        i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z);
  }
  for (const glm::uvec4& face : {glm::uvec4(0, 2, 3, 1),
                                 glm::uvec4(4, 5, 7, 6),
                                 glm::uvec4(0, 1, 5, 4),
                                 glm::uvec4(2, 6, 7, 3),
                                 glm::uvec4(0, 4, 6, 2),
                                 glm::uvec4(1, 3, 7, 5)}) {
    mesh.triangles.emplace_back(first + face.x, first + face.y, first + face.z);
    mesh.triangles.emplace_back(first + face.x, first + face.z, first + face.w);
    mesh.triangle_material.insert(mesh.triangle_material.end(), 2, 0u);
  }
}

// Three houses of one material on a lawn without one's edges in view.
inline Mesh Village() {
  Mesh mesh;
  mesh.materials.resize(1);
  AddBox(mesh, {-60, -60, -1}, {60, 60, 0});
  AddBox(mesh, {-4, 4, 0}, {-1, 8, 3});
  AddBox(mesh, {0.5f, 6, 0}, {4, 9, 5});
  AddBox(mesh, {-1, 2.5f, 0}, {1, 3.5f, 0.8f});
  return mesh;
}

inline constexpr int kFiner = 2;

// The camera and its directions of sub-pixels, the same for each of its pictures.
struct FineCamera {
  explicit FineCamera(const Lens& lens) : intrinsics(lens.Intrinsics()) {
    for (int y = 0; y < intrinsics.height_px * kFiner; ++y) {
      for (int x = 0; x < intrinsics.width_px * kFiner; ++x) {
        directions.push_back(
            lens.DirectionFromPixel({(x + 0.5) / kFiner - 0.5, (y + 0.5) / kFiner - 0.5}));
      }
    }
  }
  CameraIntrinsics intrinsics;
  std::vector<std::optional<glm::dvec3>> directions;  // Row by row.
};

// Each face in a tone of its own by where it looks and whose it is, with texture, noise, and things
// that the mesh lacks.
inline Rgb8Image PictureOf(const Mesh& mesh,
                           const FineCamera& fine_camera,
                           const glm::dmat4& pose,
                           unsigned seed) {
  const CameraIntrinsics& camera = fine_camera.intrinsics;
  const RayCaster rays(mesh);
  const glm::dmat4 world_from_camera = glm::inverse(pose);
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0.0f, 3.0f);
  cv::Mat fine(camera.height_px * kFiner, camera.width_px * kFiner, CV_32FC3);
  for (int y = 0; y < fine.rows; ++y) {
    for (int x = 0; x < fine.cols; ++x) {
      cv::Vec3f& tone = fine.at<cv::Vec3f>(y, x);
      tone = {150, 180, 220};
      const auto& direction = fine_camera.directions[static_cast<std::size_t>(y * fine.cols + x)];
      if (!direction) continue;
      const auto hit = rays.Intersect(glm::vec3(world_from_camera[3]),
                                      glm::vec3(glm::dmat3(world_from_camera) * *direction));
      if (!hit) continue;
      const glm::vec3& n = hit->geometric_normal;
      const float wave = 6.0f * std::sin(9.0f * (hit->position_m.x + hit->position_m.z) +
                                         5.0f * hit->position_m.y);
      const auto box = hit->triangle / 12;
      const float light =
          90.0f + 40.0f * n.z - 30.0f * n.y + 25.0f * n.x + 9.0f * static_cast<float>(box) + wave;
      tone = {light, 0.9f * light, 0.8f * light};
    }
  }
  cv::Mat seen;
  cv::resize(fine, seen, {camera.width_px, camera.height_px}, 0, 0, cv::INTER_AREA);
  // People, a car, a shadow.
  cv::rectangle(seen, cv::Rect(90, 300, 70, 130), cv::Scalar(30, 40, 60), cv::FILLED);
  cv::ellipse(seen, {480, 400}, {120, 30}, 20, 0, 360, cv::Scalar(40, 40, 40), cv::FILLED);
  Rgb8Image picture(camera.width_px, camera.height_px);
  for (int y = 0; y < seen.rows; ++y) {
    for (int x = 0; x < seen.cols; ++x) {
      const cv::Vec3f& tone = seen.at<cv::Vec3f>(y, x);
      for (int c = 0; c < 3; ++c) {
        picture.At(x, y)[c] = cv::saturate_cast<std::uint8_t>(tone[c] + noise(random));
      }
    }
  }
  return picture;
}

inline glm::dmat4 Moved(const glm::dmat4& pose, double turn_rad, double step_m, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  const auto any = [&] {
    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
  };
  const glm::dmat4 turned = glm::rotate(glm::dmat4(1.0), turn_rad, any());
  return glm::translate(glm::dmat4(1.0), step_m * any()) * turned * pose;
}

inline CameraIntrinsics HalfSize(CameraIntrinsics camera) {
  camera.width_px /= 2;
  camera.height_px /= 2;
  camera.fx_px *= 0.5;
  camera.fy_px *= 0.5;
  camera.cx_px = 0.5 * (camera.cx_px + 0.5) - 0.5;
  camera.cy_px = 0.5 * (camera.cy_px + 0.5) - 0.5;
  return camera;
}

// Where the village is seen from.
inline const glm::dmat4 kVillagePose = LookAt({0.8, -5.0, 1.7}, {0.0, 5.0, 1.3});

}  // namespace pleinair
