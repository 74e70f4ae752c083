// Pictures of marker boards, ray cast: a lens with distortion, antialiased.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"
#include "calib/marker_board.h"
#include "tests/calib/drawn_marker.h"

namespace pleinair {

inline CameraIntrinsics MarkerCamera() {
  CameraIntrinsics camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = 600.0;
  camera.fy_px = 602.0;
  camera.cx_px = 322.0;
  camera.cy_px = 236.0;
  camera.distortion = {-0.12, 0.05, 0.0008, -0.0005, 0.0};
  return camera;
}

// A camera at `eye` that looks at `target`; the world's z is up in its picture.
inline glm::dmat4 LookAt(const glm::dvec3& eye, const glm::dvec3& target) {
  const glm::dvec3 forward = glm::normalize(target - eye);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
  const glm::dmat3 world_from_camera(right, glm::cross(forward, right), forward);
  glm::dmat4 pose(glm::transpose(world_from_camera));
  pose[3] = glm::dvec4(-(glm::transpose(world_from_camera) * eye), 1.0);
  return pose;
}

inline BoardMarker MarkerAt(int id, double size_m, const glm::dmat4& world_from_marker) {
  BoardMarker marker{id, MarkerSquare(size_m)};
  for (glm::dvec3& corner : marker.corners_world_m) {
    corner = glm::dvec3(world_from_marker * glm::dvec4(corner, 1.0));
  }
  return marker;
}

// Two on the floor, one on a box of 0.2 m, one on a wall.
inline MarkerBoard RoomBoard() {
  MarkerBoard board{"apriltag_36h11", {}};
  const auto at = [](double x, double y, double z, double turn_rad) {
    return glm::rotate(
        glm::translate(glm::dmat4(1.0), glm::dvec3(x, y, z)), turn_rad, glm::dvec3(0, 0, 1));
  };
  board.markers.push_back(MarkerAt(3, 0.2, at(0.0, 0.0, 0.0, 0.0)));
  board.markers.push_back(MarkerAt(7, 0.2, at(0.5, 0.1, 0.0, 0.7)));
  board.markers.push_back(MarkerAt(11, 0.2, at(-0.45, 0.25, 0.2, -0.3)));
  // Stands upright, looks to -y.
  const glm::dmat4 wall =
      glm::rotate(at(0.1, 0.6, 0.25, 0.0), 0.5 * 3.14159265358979, glm::dvec3(1, 0, 0));
  board.markers.push_back(MarkerAt(20, 0.2, wall));
  return board;
}

// `board` on grey ground; noise of `noise_codes`, from `seed`. Markers may not hide each other.
inline Gray8Image RenderMarkers(const MarkerBoard& board,
                                const CameraIntrinsics& intrinsics,
                                const glm::dmat4& camera_from_world,
                                double noise_codes = 1.0,
                                unsigned seed = 1) {
  constexpr int kSub = 4;
  const Lens lens(intrinsics);
  struct Face {
    Gray8Image drawn;
    glm::dvec3 corner{0.0};
    glm::dvec3 right{0.0};  // A cell.
    glm::dvec3 down{0.0};
    glm::dvec3 normal{0.0};  // Into the face.
    double cells = 0.0;
  };
  std::vector<Face> faces;
  for (const BoardMarker& marker : board.markers) {
    Face face;
    face.drawn = DrawMarker(board.dictionary, marker.id, 1);
    const auto& c = marker.corners_world_m;
    face.cells = face.drawn.width - 2;
    face.corner = c[0];
    face.right = (c[1] - c[0]) / face.cells;
    face.down = (c[3] - c[0]) / face.cells;
    face.normal = glm::normalize(glm::cross(c[1] - c[0], c[3] - c[0]));
    faces.push_back(std::move(face));
  }
  const glm::dmat4 world_from_camera = glm::inverse(camera_from_world);
  const glm::dvec3 eye(world_from_camera[3]);
  const auto code_at = [&](double x, double y) {
    const auto direction_camera = lens.DirectionFromPixel({x, y});
    if (!direction_camera) return 120.0;
    const glm::dvec3 direction = glm::dmat3(world_from_camera) * *direction_camera;
    double nearest = 1e30;
    double code = 120.0;
    for (const Face& face : faces) {
      const double distance =
          glm::dot(face.corner - eye, face.normal) / glm::dot(direction, face.normal);
      // Seen from its front alone.
      if (!(distance > 0.0 && distance < nearest)) continue;
      if (glm::dot(direction, face.normal) < 0.0) continue;
      const glm::dvec3 off = eye + distance * direction - face.corner;
      const double u = glm::dot(off, face.right) / glm::dot(face.right, face.right) + 1.0;
      const double v = glm::dot(off, face.down) / glm::dot(face.down, face.down) + 1.0;
      if (u < 0.0 || v < 0.0 || u >= face.cells + 2.0 || v >= face.cells + 2.0) continue;
      nearest = distance;
      code = face.drawn.At(static_cast<int>(u), static_cast<int>(v)) > 127 ? 210.0 : 35.0;
    }
    return code;
  };
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, noise_codes);
  // At the pixels' corners first: where these agree, the pixel is as they are.
  Image<double> corners(intrinsics.width_px + 1, intrinsics.height_px + 1);
  for (int y = 0; y < corners.height; ++y) {
    for (int x = 0; x < corners.width; ++x) corners.At(x, y) = code_at(x - 0.5, y - 0.5);
  }
  Gray8Image picture(intrinsics.width_px, intrinsics.height_px);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      double code = corners.At(x, y);
      if (code != corners.At(x + 1, y) || code != corners.At(x, y + 1) ||
          code != corners.At(x + 1, y + 1)) {
        double sum = 0.0;
        for (int j = 0; j < kSub; ++j) {
          for (int i = 0; i < kSub; ++i) {
            sum += code_at(x + (i + 0.5) / kSub - 0.5, y + (j + 0.5) / kSub - 0.5);
          }
        }
        code = sum / (kSub * kSub);
      }
      if (noise_codes > 0.0) code += noise(random);
      picture.At(x, y) = static_cast<std::uint8_t>(std::lround(std::clamp(code, 0.0, 255.0)));
    }
  }
  return picture;
}

inline glm::dvec3 CentreOfPose(const glm::dmat4& camera_from_world) {
  return glm::dvec3(glm::inverse(camera_from_world)[3]);
}

}  // namespace pleinair
