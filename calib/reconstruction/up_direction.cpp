#include "calib/reconstruction/up_direction.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Eigenvalues>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/reconstruction/plane_fit.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr double kHeldLevelSigmaRad = RadFromDeg(3.0);
constexpr double kPitchSigmaRad = RadFromDeg(20.0);
constexpr double kPlaneSigmaRad = RadFromDeg(0.7);  // Stucco, mouldings, distortion of the model.
constexpr double kEdgesSigmaRad = RadFromDeg(0.5);  // Together; a rolling shutter shears pictures.

struct PictureAxes {
  glm::dvec3 right;
  glm::dvec3 down;
  glm::dvec3 forward;
};

// Of the picture as it is to be shown, in the model's frame.
PictureAxes AxesOf(const ReconstructedPicture& picture, int orientation) {
  const glm::dmat3 model_from_camera = glm::transpose(glm::dmat3(picture.camera_from_model));
  const glm::dvec3& x = model_from_camera[0];
  const glm::dvec3& y = model_from_camera[1];
  PictureAxes axes{x, y, model_from_camera[2]};
  // EXIF: 3 is stored upside down, 6 has its top at the stored right side, 8 at the left one.
  if (orientation == 3 || orientation == 4) axes = {-x, -y, axes.forward};
  if (orientation == 6 || orientation == 7) axes = {-y, x, axes.forward};
  if (orientation == 8 || orientation == 5) axes = {y, -x, axes.forward};
  return axes;
}

int OrientationOf(std::span<const int> orientations, std::size_t picture) {
  return picture < orientations.size() ? orientations[picture] : 1;
}

}  // namespace

std::vector<LevelDirection> LevelOfCameras(const Reconstruction& reconstruction,
                                           std::span<const int> orientations) {
  std::vector<LevelDirection> level;
  for (std::size_t i = 0; i < reconstruction.pictures.size(); ++i) {
    const PictureAxes axes = AxesOf(reconstruction.pictures[i], OrientationOf(orientations, i));
    level.push_back({axes.right, kHeldLevelSigmaRad});
    level.push_back({axes.forward, kPitchSigmaRad});
  }
  return level;
}

glm::dvec3 UpInPictures(const Reconstruction& reconstruction, std::span<const int> orientations) {
  glm::dvec3 up(0.0);
  for (std::size_t i = 0; i < reconstruction.pictures.size(); ++i) {
    up -= AxesOf(reconstruction.pictures[i], OrientationOf(orientations, i)).down;
  }
  return up;
}

std::vector<LevelDirection> LevelBelow(const glm::dvec3& up, double sigma_rad) {
  const glm::dvec3 other =
      std::abs(up.x) < 0.6 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  const glm::dvec3 first = glm::normalize(glm::cross(up, other));
  return {{first, sigma_rad}, {glm::cross(up, first), sigma_rad}};
}

std::vector<LevelDirection> LevelOfPlanes(const Reconstruction& reconstruction,
                                          const glm::dvec3& up,
                                          double tolerance) {
  constexpr int kMostPlanes = 8;
  constexpr double kLikelyRad = RadFromDeg(12.0);
  std::vector<glm::dvec3> points;
  for (const ReconstructedPoint& point : reconstruction.points) points.push_back(point.position);
  PlaneFitOptions options;
  options.tolerance = tolerance;
  // A plane of few points leans as its noise does.
  options.fewest = std::max<std::size_t>(30, points.size() / 25);
  std::vector<LevelDirection> level;
  for (int p = 0; p < kMostPlanes; ++p) {
    const auto fit = FitPlane(points, options);
    if (!fit) break;
    const glm::dvec3 normal = fit->plane.normal;
    const double sigma_rad = std::hypot(kPlaneSigmaRad, fit->normal_sigma_rad);
    const double from_up =
        std::atan2(glm::length(glm::cross(normal, up)), std::abs(glm::dot(normal, up)));
    if (from_up > RadFromDeg(90.0) - kLikelyRad) level.push_back({normal, sigma_rad});
    if (from_up < kLikelyRad) {
      for (const LevelDirection& in_ground : LevelBelow(normal, sigma_rad)) {
        level.push_back(in_ground);
      }
    }
    for (auto member = fit->members.rbegin(); member != fit->members.rend(); ++member) {
      points[*member] = points.back();
      points.pop_back();
    }
  }
  return level;
}

std::vector<LevelDirection> LevelOfVerticalEdges(const Gray8Image& picture,
                                                 const CameraIntrinsics& intrinsics,
                                                 const glm::dmat4& camera_from_model,
                                                 const glm::dvec3& up) {
  constexpr int kLongestSidePx = 1600;  // Edges are as straight in it, and found faster.
  constexpr double kShortest = 0.04;    // Of the picture's height.
  constexpr double kLikelyRad = RadFromDeg(8.0);
  const cv::Mat stored(
      picture.height, picture.width, CV_8UC1, const_cast<std::uint8_t*>(picture.pixels.data()));
  const double shrink =
      std::min(1.0, kLongestSidePx / static_cast<double>(std::max(picture.width, picture.height)));
  cv::Mat small;
  cv::resize(stored, small, {}, shrink, shrink, cv::INTER_AREA);
  std::vector<cv::Vec4f> segments;
  cv::createLineSegmentDetector(cv::LSD_REFINE_STD)->detect(small, segments);

  const Lens lens(intrinsics);
  const glm::dmat3 model_from_camera = glm::transpose(glm::dmat3(camera_from_model));
  const auto direction_at = [&](double x, double y) {
    return lens.DirectionFromPixel({(x + 0.5) / shrink - 0.5, (y + 0.5) / shrink - 0.5});
  };
  std::vector<LevelDirection> level;
  double sum = 0.0;
  for (const cv::Vec4f& segment : segments) {
    const double length = std::hypot(segment[2] - segment[0], segment[3] - segment[1]);
    if (length < kShortest * small.rows) continue;
    const auto begin = direction_at(segment[0], segment[1]);
    const auto end = direction_at(segment[2], segment[3]);
    if (!begin || !end) continue;
    const glm::dvec3 normal = model_from_camera * glm::normalize(glm::cross(*begin, *end));
    if (std::abs(glm::dot(normal, up)) > std::sin(kLikelyRad)) continue;
    // The horizon's edges pass through here as well where the camera looks up steeply: an upright
    // edge runs towards up, not across it.
    const glm::dvec3 along = model_from_camera * (*end - *begin);
    const glm::dvec3 middle = model_from_camera * glm::normalize(*begin + *end);
    const glm::dvec3 up_here = up - glm::dot(up, middle) * middle;
    if (std::abs(glm::dot(glm::normalize(along), up_here)) <
        std::cos(kLikelyRad) * glm::length(up_here)) {
      continue;
    }
    level.push_back({normal, kEdgesSigmaRad, length});
    sum += length;
  }
  for (LevelDirection& edge : level) edge.weight /= sum;
  return level;
}

UpEstimate EstimateUp(std::span<const LevelDirection> evidence, const glm::dvec3& sense) {
  if (evidence.empty()) throw std::invalid_argument("EstimateUp: expected some evidence");
  std::vector<double> weights(evidence.size(), 1.0);
  UpEstimate estimate;
  constexpr int kRounds = 20;
  // What is off by more counts less.
  constexpr double kWrongRad = RadFromDeg(1.5);
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const glm::dvec3& d = evidence[i].direction;
      const Eigen::Vector3d a(d.x, d.y, d.z);
      normal_matrix += weights[i] * evidence[i].weight / std::pow(evidence[i].sigma_rad, 2.0) * a *
                       a.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(normal_matrix);
    const Eigen::Vector3d up = solver.eigenvectors().col(0);
    estimate.up = {up.x(), up.y(), up.z()};
    if (glm::dot(estimate.up, sense) < 0.0) estimate.up = -estimate.up;
    estimate.sigma_rad =
        std::min(1.0 / std::sqrt(std::max(solver.eigenvalues()(1), 1e-6)), RadFromDeg(90.0));
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const double off =
          std::asin(std::clamp(glm::dot(estimate.up, evidence[i].direction), -1.0, 1.0));
      // Loose evidence (how cameras are held) is judged by its own deviation.
      const double scale = std::max(kWrongRad, evidence[i].sigma_rad);
      weights[i] = 1.0 / (1.0 + std::pow(off / scale, 2.0));
    }
  }
  return estimate;
}

}  // namespace pleinair
