#include "calib/internal/marker_adjustment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/internal/pose_refinement.h"

namespace pleinair {
namespace {

constexpr double kHuberPx = 1.0;

double HuberCost(double residual_px) {
  return residual_px <= kHuberPx ? residual_px * residual_px
                                 : kHuberPx * (2.0 * residual_px - kHuberPx);
}

struct Normal {
  double cost = 0.0;
  Eigen::MatrixXd matrix;
  Eigen::VectorXd gradient;
};

class Adjustment {
 public:
  Adjustment(const Lens& lens,
             const std::array<glm::dvec3, 4>& square,
             const std::vector<const MarkerView*>& views,
             int reference_id,
             const MarkerLayout& layout)
      : lens_(lens), square_(square), views_(views) {
    for (const auto& [id, pose] : layout.world_from_marker) {
      if (id != reference_id) column_of_marker_[id] = Next();
    }
    for (const auto& [view, pose] : layout.camera_from_world) column_of_view_[view] = Next();
  }

  Eigen::Index Unknowns() const { return unknowns_; }

  // None where a corner is not before its camera.
  std::optional<Normal> Linearise(const MarkerLayout& layout) const {
    Normal normal;
    normal.matrix = Eigen::MatrixXd::Zero(unknowns_, unknowns_);
    normal.gradient = Eigen::VectorXd::Zero(unknowns_);
    for (const auto& [v, camera_from_world] : layout.camera_from_world) {
      for (const DetectedMarker& marker : views_[v]->markers) {
        const auto placed = layout.world_from_marker.find(marker.id);
        if (placed == layout.world_from_marker.end()) continue;
        if (!Add(marker, v, camera_from_world, placed->second, normal)) return std::nullopt;
      }
    }
    if (!std::isfinite(normal.cost)) return std::nullopt;
    return normal;
  }

  MarkerLayout Moved(const MarkerLayout& layout, const Eigen::VectorXd& step) const {
    MarkerLayout moved = layout;
    for (const auto& [id, column] : column_of_marker_) {
      glm::dmat4& pose = moved.world_from_marker.at(id);
      pose = MovedPose(pose, step.segment<6>(column));
    }
    for (const auto& [view, column] : column_of_view_) {
      glm::dmat4& pose = moved.camera_from_world.at(view);
      pose = MovedPose(pose, step.segment<6>(column));
    }
    return moved;
  }

 private:
  Eigen::Index Next() {
    unknowns_ += 6;
    return unknowns_ - 6;
  }

  bool Add(const DetectedMarker& marker,
           std::size_t view,
           const glm::dmat4& camera_from_world,
           const glm::dmat4& world_from_marker,
           Normal& normal) const {
    std::vector<glm::dvec3> world;
    std::vector<glm::dvec3> camera;
    for (const glm::dvec3& corner : square_) {
      world.emplace_back(world_from_marker * glm::dvec4(corner, 1.0));
      camera.emplace_back(camera_from_world * glm::dvec4(world.back(), 1.0));
      if (!(camera.back().z > 0.0)) return false;
    }
    std::vector<glm::dvec2> pixels;
    std::vector<PoseJacobian> by_camera;
    ProjectWithJacobian(lens_.Intrinsics(), camera, pixels, by_camera);
    Eigen::Matrix3d rotation;
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) rotation(row, column) = camera_from_world[column][row];
    }
    const auto of_marker = column_of_marker_.find(marker.id);
    const Eigen::Index camera_at = column_of_view_.at(view);
    for (std::size_t c = 0; c < 4; ++c) {
      const glm::dvec2 off = pixels[c] - marker.corners_px[c];
      const Eigen::Vector2d residual(off.x, off.y);
      const double size = residual.norm();
      const double weight = size > kHuberPx ? kHuberPx / size : 1.0;
      normal.cost += HuberCost(size);
      const PoseJacobian& a = by_camera[c];
      normal.matrix.block<6, 6>(camera_at, camera_at) += weight * a.transpose() * a;
      normal.gradient.segment<6>(camera_at) += weight * a.transpose() * residual;
      if (of_marker == column_of_marker_.end()) continue;
      // A world point y that moves to exp(turn) y + shift moves in the camera's frame by
      // R (turn x y + shift).
      const glm::dvec3& y = world[c];
      Eigen::Matrix<double, 3, 6> moves;
      moves << 0.0, y.z, -y.y, 1.0, 0.0, 0.0,  //
          -y.z, 0.0, y.x, 0.0, 1.0, 0.0,       //
          y.y, -y.x, 0.0, 0.0, 0.0, 1.0;
      const PoseJacobian b = a.rightCols<3>() * rotation * moves;
      const Eigen::Index marker_at = of_marker->second;
      normal.matrix.block<6, 6>(marker_at, marker_at) += weight * b.transpose() * b;
      normal.matrix.block<6, 6>(marker_at, camera_at) += weight * b.transpose() * a;
      normal.matrix.block<6, 6>(camera_at, marker_at) += weight * a.transpose() * b;
      normal.gradient.segment<6>(marker_at) += weight * b.transpose() * residual;
    }
    return true;
  }

  const Lens& lens_;
  const std::array<glm::dvec3, 4>& square_;
  const std::vector<const MarkerView*>& views_;
  std::map<int, Eigen::Index> column_of_marker_;
  std::map<std::size_t, Eigen::Index> column_of_view_;
  Eigen::Index unknowns_ = 0;
};

}  // namespace

double SumSquaresPx(const Lens& lens,
                    const std::array<glm::dvec3, 4>& square,
                    const DetectedMarker& marker,
                    const glm::dmat4& camera_from_marker) {
  double sum = 0.0;
  for (std::size_t c = 0; c < 4; ++c) {
    const auto pixel =
        lens.ProjectToPixel(glm::dvec3(camera_from_marker * glm::dvec4(square[c], 1.0)));
    if (!pixel) return std::numeric_limits<double>::infinity();
    const glm::dvec2 off = *pixel - marker.corners_px[c];
    sum += glm::dot(off, off);
  }
  return sum;
}

void AdjustMarkerLayout(const Lens& lens,
                        const std::array<glm::dvec3, 4>& square,
                        const std::vector<const MarkerView*>& views,
                        int reference_id,
                        int steps,
                        MarkerLayout& layout) {
  const Adjustment adjustment(lens, square, views, reference_id, layout);
  if (adjustment.Unknowns() == 0) return;
  auto now = adjustment.Linearise(layout);
  double damping = 1e-3;
  for (int i = 0; now && i < steps && damping < 1e12; ++i) {
    Eigen::MatrixXd damped = now->matrix;
    // An unknown that nothing holds stays where it is.
    damped.diagonal().array() *= 1.0 + damping;
    damped.diagonal().array() += std::numeric_limits<double>::min();
    const Eigen::VectorXd step = damped.ldlt().solve(-now->gradient);
    if (!step.allFinite()) break;
    MarkerLayout moved = adjustment.Moved(layout, step);
    auto next = adjustment.Linearise(moved);
    if (!next || !(next->cost < now->cost)) {
      damping *= 10.0;
      continue;
    }
    const bool done = now->cost - next->cost <= 1e-12 * now->cost;
    layout = std::move(moved);
    now = std::move(next);
    damping = std::max(1e-12, 0.1 * damping);
    if (done) break;
  }
}

}  // namespace pleinair
