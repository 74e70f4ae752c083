#include "calib/reconstruction/up_direction.h"

#include <algorithm>
#include <cmath>
#include <numbers>
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
constexpr double kPlaneSigmaRad = RadFromDeg(2.0);  // Stucco, mouldings, distortion of the model.
constexpr double kEdgesSigmaRad = RadFromDeg(0.5);  // Together; a rolling shutter shears pictures.

struct PictureAxes {
  glm::dvec3 right;
  glm::dvec3 down;
  glm::dvec3 forward;
};

// Axes of the picture as it is to be shown, in the model's frame.
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

constexpr double kUprightRad = RadFromDeg(2.0);

// Tukey's biweight of the sine of an angle, with its end at kUprightRad.
double WeightOf(double sine) {
  const double off = sine / std::sin(kUprightRad);
  return std::abs(off) < 1.0 ? std::pow(1.0 - off * off, 2.0) : 0.0;
}

// Length of the edges that run along `direction`, or of all; ones that nearly point there weigh
// less.
double SupportOf(std::span<const PictureEdge> edges, const std::optional<glm::dvec3>& direction) {
  double support = 0.0;
  for (const PictureEdge& edge : edges) {
    support += edge.length * (direction ? WeightOf(glm::dot(edge.normal, *direction)) : 1.0);
  }
  return support;
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

glm::dvec3 RightInPictures(const Reconstruction& reconstruction,
                           std::span<const int> orientations) {
  glm::dvec3 right(0.0);
  for (std::size_t i = 0; i < reconstruction.pictures.size(); ++i) {
    right += AxesOf(reconstruction.pictures[i], OrientationOf(orientations, i)).right;
  }
  return right;
}

std::vector<LevelDirection> LevelBelow(const glm::dvec3& up, double sigma_rad) {
  const glm::dvec3 other =
      std::abs(up.x) < 0.6 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  const glm::dvec3 first = glm::normalize(glm::cross(up, other));
  return {{first, sigma_rad}, {glm::cross(up, first), sigma_rad}};
}

std::vector<PlaneNormal> FindPlaneNormals(const Reconstruction& reconstruction, double tolerance) {
  constexpr std::size_t kMostPlanes = 8;
  std::vector<glm::dvec3> points;
  for (const ReconstructedPoint& point : reconstruction.points) points.push_back(point.position);
  PlaneFitOptions options;
  options.tolerance = tolerance;
  // A plane of few points leans as its noise does.
  options.fewest = std::max<std::size_t>(30, points.size() / 25);
  std::vector<PlaneNormal> planes;
  while (planes.size() < kMostPlanes) {
    const auto fit = FitPlane(points, options);
    if (!fit) break;
    planes.push_back({fit->plane.normal,
                      static_cast<double>(fit->members.size()) /
                          static_cast<double>(reconstruction.points.size()),
                      std::hypot(kPlaneSigmaRad, fit->normal_sigma_rad)});
    for (auto member = fit->members.rbegin(); member != fit->members.rend(); ++member) {
      points[*member] = points.back();
      points.pop_back();
    }
  }
  return planes;
}

std::vector<LevelDirection> LevelOfPlanes(std::span<const PlaneNormal> planes,
                                          const glm::dvec3& up) {
  constexpr double kLikelyRad = RadFromDeg(4.0);
  std::vector<LevelDirection> level;
  for (const PlaneNormal& plane : planes) {
    const double sine = glm::length(glm::cross(plane.normal, up));
    if (sine > std::cos(kLikelyRad)) level.push_back({plane.normal, plane.sigma_rad});
    if (sine < std::sin(kLikelyRad)) {
      for (const LevelDirection& in_ground : LevelBelow(plane.normal, plane.sigma_rad)) {
        level.push_back(in_ground);
      }
    }
  }
  return level;
}

std::vector<PictureEdge> FindEdges(const Gray8Image& picture,
                                   const CameraIntrinsics& intrinsics,
                                   const glm::dmat4& camera_from_model) {
  constexpr int kLongestSidePx = 1600;  // Edges are as straight in it, and found faster.
  constexpr double kShortest = 0.04;    // Share of the picture's height.
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
  std::vector<PictureEdge> edges;
  for (const cv::Vec4f& segment : segments) {
    const double length = std::hypot(segment[2] - segment[0], segment[3] - segment[1]) /
                          static_cast<double>(small.rows);
    if (length < kShortest) continue;
    const auto begin = direction_at(segment[0], segment[1]);
    const auto end = direction_at(segment[2], segment[3]);
    if (!begin || !end) continue;
    edges.push_back({model_from_camera * glm::normalize(glm::cross(*begin, *end)), length});
  }
  return edges;
}

std::optional<glm::dvec3> SearchUp(std::span<const PictureEdge> edges,
                                   std::span<const PlaneNormal> planes,
                                   const glm::dvec3& up,
                                   const glm::dvec3& right) {
  constexpr double kLeastSupport = 0.1;
  constexpr int kMostPitchDeg = 45;
  constexpr int kMostRollDeg = 12;
  const glm::dvec3 y = glm::normalize(up);
  const glm::dvec3 z = glm::normalize(glm::cross(right, y));
  const glm::dvec3 x = glm::cross(y, z);
  const double all_edges = SupportOf(edges, std::nullopt);
  std::optional<glm::dvec3> best;
  double most = kLeastSupport;
  for (int pitch = -kMostPitchDeg; pitch <= kMostPitchDeg; ++pitch) {
    for (int roll = -kMostRollDeg; roll <= kMostRollDeg; ++roll) {
      const glm::dvec3 candidate =
          glm::normalize(y + std::tan(RadFromDeg(pitch)) * z + std::tan(RadFromDeg(roll)) * x);
      double support = all_edges > 0.0 ? SupportOf(edges, candidate) / all_edges : 0.0;
      for (const PlaneNormal& plane : planes) {
        support +=
            plane.share * std::max(WeightOf(glm::dot(plane.normal, candidate)),
                                   WeightOf(glm::length(glm::cross(plane.normal, candidate))));
      }
      if (support <= most) continue;
      most = support;
      best = candidate;
    }
  }
  return best;
}

std::vector<LevelDirection> LevelOfEdges(std::span<const PictureEdge> edges,
                                         const glm::dvec3& up,
                                         std::size_t pictures) {
  std::vector<LevelDirection> level;
  double sum = 0.0;
  for (const PictureEdge& edge : edges) {
    if (std::abs(glm::dot(edge.normal, up)) > std::sin(kUprightRad)) continue;
    level.push_back({edge.normal, kEdgesSigmaRad, edge.length});
    sum += edge.length;
  }
  for (LevelDirection& one : level) one.weight *= static_cast<double>(pictures) / sum;
  return level;
}

std::optional<glm::dvec3> LevelEdgeDirection(std::span<const PictureEdge> edges,
                                             const glm::dvec3& up) {
  constexpr double kLeastShare = 0.1;
  constexpr double kStepRad = RadFromDeg(0.25);
  std::vector<PictureEdge> others;
  for (const PictureEdge& edge : edges) {
    if (std::abs(glm::dot(edge.normal, up)) > std::sin(kUprightRad)) others.push_back(edge);
  }
  const std::vector<LevelDirection> axes = LevelBelow(up, 1.0);
  const auto direction_at = [&](double angle) {
    return std::cos(angle) * axes[0].direction + std::sin(angle) * axes[1].direction;
  };
  std::optional<double> best;
  double most = kLeastShare * SupportOf(others, std::nullopt);
  for (double angle = 0.0; angle < 0.5 * std::numbers::pi; angle += kStepRad) {
    const double support = SupportOf(others, direction_at(angle)) +
                           SupportOf(others, direction_at(angle + 0.5 * std::numbers::pi));
    if (support <= most) continue;
    most = support;
    best = angle;
  }
  if (!best) return std::nullopt;
  // A direction is perpendicular to the planes of the edges along it: Gauss and Newton's steps on
  // the angle, robust as the support is.
  double angle = *best;
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    double gradient = 0.0;
    double curvature = 0.0;
    for (const PictureEdge& edge : others) {
      for (const double turn : {0.0, 0.5 * std::numbers::pi}) {
        const double off = glm::dot(edge.normal, direction_at(angle + turn));
        const double slope =
            glm::dot(edge.normal, direction_at(angle + turn + 0.5 * std::numbers::pi));
        const double weight = edge.length * WeightOf(off);
        gradient += weight * off * slope;
        curvature += weight * slope * slope;
      }
    }
    if (!(curvature > 0.0)) break;
    angle -= gradient / curvature;
  }
  return direction_at(angle);
}

UpEstimate EstimateUp(std::span<const LevelDirection> evidence, const glm::dvec3& sense) {
  if (evidence.empty()) throw std::invalid_argument("EstimateUp: expected some evidence");
  std::vector<double> weights(evidence.size(), 1.0);
  UpEstimate estimate;
  constexpr int kRounds = 20;
  // Evidence that differs by more has less weight.
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
