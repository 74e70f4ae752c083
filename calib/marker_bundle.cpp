#include "calib/marker_bundle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include <Eigen/Geometry>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/internal/marker_adjustment.h"
#include "calib/internal/residual_text.h"

namespace pleinair {
namespace {

// While markers are being placed, a pose need not be good: the adjustment comes later.
CameraPoseOptions Loose() {
  CameraPoseOptions options;
  options.inlier_px = 8.0;
  options.least_share = 0.0;
  options.largest_rotation_sigma_rad = std::numeric_limits<double>::infinity();
  return options;
}

std::vector<glm::dmat4> PossiblePoses(const Lens& lens, const std::vector<PointMatch>& matches) {
  std::vector<glm::dmat4> poses;
  const auto pose = FindCameraPose(lens, matches, Loose());
  if (!pose) {
    for (const PoseCandidate& one : pose.error().candidates) poses.push_back(one.camera_from_world);
    return poses;
  }
  poses.push_back(pose->camera_from_world);
  if (pose->rival) poses.push_back(pose->rival->camera_from_world);
  return poses;
}

// Squared residuals, cut off where it is wrong anyway.
double Cost(const Lens& lens, const std::vector<PointMatch>& matches, const glm::dmat4& pose) {
  constexpr double kCutOffPx = 20.0;
  double sum = 0.0;
  for (const PointMatch& match : matches) {
    const auto pixel = lens.ProjectToPixel(glm::dvec3(pose * glm::dvec4(match.point_world_m, 1.0)));
    const double off = pixel ? glm::distance(*pixel, match.pixel) : kCutOffPx;
    sum += std::pow(std::min(off, kCutOffPx), 2.0);
  }
  return sum;
}

std::optional<glm::dmat4> BestPose(const Lens& lens,
                                   const std::vector<PointMatch>& matches,
                                   double* cost) {
  std::optional<glm::dmat4> best;
  *cost = std::numeric_limits<double>::infinity();
  for (const glm::dmat4& pose : PossiblePoses(lens, matches)) {
    const double here = Cost(lens, matches, pose);
    if (here < *cost) {
      *cost = here;
      best = pose;
    }
  }
  return best;
}

double ShortestSidePx(const DetectedMarker& marker) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < 4; ++c) {
    shortest =
        std::min(shortest, glm::distance(marker.corners_px[c], marker.corners_px[(c + 1) % 4]));
  }
  return shortest;
}

// Markers placed so far, and the views of them.
class Placing {
 public:
  Placing(const Lens& lens, double size_m, std::vector<const MarkerView*> views, int reference_id)
      : lens_(lens), square_(MarkerSquare(size_m)), views_(std::move(views)) {
    layout_.world_from_marker[reference_id] = glm::dmat4(1.0);
    reference_id_ = reference_id;
  }

  // Until no view shows a placed marker together with one that is not placed.
  void PlaceAll() {
    while (const auto next = NextMarker()) {
      if (!Place(*next)) hopeless_.insert(*next);
    }
    Adjust(50);
  }

  // Camera poses from the markers placed, then all together.
  void Adjust(int steps) {
    layout_.camera_from_world.clear();
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const auto matches = MatchesOf(*views_[v]);
      if (matches.size() < 8) continue;
      double cost = 0.0;
      if (const auto pose = BestPose(lens_, matches, &cost)) layout_.camera_from_world[v] = *pose;
    }
    AdjustMarkerLayout({lens_, square_, views_}, reference_id_, steps, layout_);
  }

  const MarkerLayout& Layout() const { return layout_; }

 private:
  std::vector<PointMatch> MatchesOf(const DetectedMarker& marker, const glm::dmat4& placed) const {
    std::vector<PointMatch> matches;
    for (std::size_t c = 0; c < 4; ++c) {
      matches.push_back({glm::dvec3(placed * glm::dvec4(square_[c], 1.0)), marker.corners_px[c]});
    }
    return matches;
  }
  std::vector<PointMatch> MatchesOf(const MarkerView& view) const {
    std::vector<PointMatch> matches;
    for (const DetectedMarker& marker : view.markers) {
      const auto placed = layout_.world_from_marker.find(marker.id);
      if (placed == layout_.world_from_marker.end()) continue;
      const auto more = MatchesOf(marker, placed->second);
      matches.insert(matches.end(), more.begin(), more.end());
    }
    return matches;
  }

  // The marker that most views show together with placed ones.
  std::optional<int> NextMarker() const {
    std::map<int, int> views_of;
    for (const MarkerView* view : views_) {
      if (MatchesOf(*view).empty()) continue;
      for (const DetectedMarker& marker : view->markers) {
        if (layout_.world_from_marker.contains(marker.id) || hopeless_.contains(marker.id))
          continue;
        ++views_of[marker.id];
      }
    }
    if (views_of.empty()) return std::nullopt;
    return std::max_element(views_of.begin(),
                            views_of.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
  }

  struct Shared {
    std::vector<PointMatch> placed;
    DetectedMarker marker;
  };

  bool Place(int id) {
    constexpr std::size_t kViewsTried = 4;
    std::vector<Shared> shared;
    for (const MarkerView* view : views_) {
      std::vector<PointMatch> placed = MatchesOf(*view);
      if (placed.empty()) continue;
      for (const DetectedMarker& marker : view->markers) {
        if (marker.id == id) shared.push_back({placed, marker});
      }
    }
    // Views that show it large come first.
    std::stable_sort(shared.begin(), shared.end(), [](const Shared& a, const Shared& b) {
      return ShortestSidePx(a.marker) > ShortestSidePx(b.marker);
    });
    double best_cost = std::numeric_limits<double>::infinity();
    std::optional<glm::dmat4> best;
    for (std::size_t i = 0; i < std::min(kViewsTried, shared.size()); ++i) {
      const auto from_marker = PossiblePoses(lens_, MatchesOf(shared[i].marker, glm::dmat4(1.0)));
      for (const glm::dmat4& camera_from_world : PossiblePoses(lens_, shared[i].placed)) {
        for (const glm::dmat4& camera_from_marker : from_marker) {
          const glm::dmat4 placed = glm::inverse(camera_from_world) * camera_from_marker;
          const double cost = CostOf(shared, placed, best_cost);
          if (cost < best_cost) {
            best_cost = cost;
            best = placed;
          }
        }
      }
    }
    if (!best) return false;
    layout_.world_from_marker[id] = *best;
    Adjust(5);
    return true;
  }

  // Over all views; or, once it is more than `limit`, over the first of them.
  double CostOf(const std::vector<Shared>& shared, const glm::dmat4& placed, double limit) const {
    double sum = 0.0;
    for (const Shared& view : shared) {
      if (sum > limit) break;
      std::vector<PointMatch> matches = MatchesOf(view.marker, placed);
      matches.insert(matches.end(), view.placed.begin(), view.placed.end());
      double cost = 0.0;
      BestPose(lens_, matches, &cost);
      sum += cost;
    }
    return sum;
  }

  const Lens& lens_;
  std::array<glm::dvec3, 4> square_;
  std::vector<const MarkerView*> views_;
  int reference_id_ = 0;
  MarkerLayout layout_;
  std::set<int> hopeless_;
};

std::optional<std::string> WhyNot(const MarkerView& view) {
  std::map<int, int> count;
  for (const DetectedMarker& marker : view.markers) ++count[marker.id];
  for (const auto& [id, times] : count) {
    if (times == 1) continue;
    return "marker " + std::to_string(id) + " occurs " + std::to_string(times) +
           " times, expected each id once";
  }
  if (count.size() >= 2) return std::nullopt;
  return count.empty() ? "no marker found" : "only one marker found, expected two or more";
}

int MostSeen(const std::vector<const MarkerView*>& views) {
  std::map<int, int> count;
  for (const MarkerView* view : views) {
    for (const DetectedMarker& marker : view->markers) ++count[marker.id];
  }
  return std::max_element(count.begin(),
                          count.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

[[noreturn]] void GiveUp(const std::string& why, const std::vector<RejectedMarkerView>& rejected) {
  throw std::runtime_error(
      "marker board: " + why +
      (rejected.empty() ? "" : "; " + rejected[0].name + ": " + rejected[0].reason));
}

}  // namespace

MarkerBoardFit FitMarkerBoard(const Lens& lens,
                              const std::string& dictionary,
                              double size_m,
                              std::span<const MarkerView> views,
                              std::optional<int> reference_id) {
  if (!(size_m > 0.0) || !std::isfinite(size_m)) {
    throw std::invalid_argument("marker size: expected metres above 0, found " +
                                std::to_string(size_m));
  }
  if (!FindMarkerDictionary(dictionary)) {
    throw std::invalid_argument("marker dictionary: expected one of OpenCV's, found " + dictionary);
  }
  MarkerBoardFit fit;
  std::vector<const MarkerView*> used;
  for (const MarkerView& view : views) {
    if (const auto why = WhyNot(view)) {
      fit.rejected.push_back({view.name, *why});
    } else {
      used.push_back(&view);
    }
  }
  if (used.empty()) GiveUp("expected pictures that show two markers or more", fit.rejected);
  fit.reference_id = reference_id.value_or(MostSeen(used));

  const std::array<glm::dvec3, 4> square = MarkerSquare(size_m);
  for (;;) {
    Placing placing(lens, size_m, used, fit.reference_id);
    placing.PlaceAll();
    const MarkerLayout& layout = placing.Layout();
    if (layout.world_from_marker.size() < 2 || layout.camera_from_world.empty()) {
      GiveUp("no picture shows marker " + std::to_string(fit.reference_id) + " beside another one",
             fit.rejected);
    }
    fit.fitted.clear();
    std::map<int, std::pair<int, double>> by_marker;
    std::vector<double> rms;
    std::vector<std::size_t> indices;
    double squares = 0.0;
    std::size_t corners = 0;
    for (const auto& [v, pose] : layout.camera_from_world) {
      double in_view = 0.0;
      std::size_t markers = 0;
      for (const DetectedMarker& marker : used[v]->markers) {
        const auto placed = layout.world_from_marker.find(marker.id);
        if (placed == layout.world_from_marker.end()) continue;
        const double sum = SumSquaresPx(lens, square, marker, pose * placed->second);
        ++by_marker[marker.id].first;
        by_marker[marker.id].second += sum;
        in_view += sum;
        ++markers;
      }
      rms.push_back(std::sqrt(in_view / static_cast<double>(4 * markers)));
      indices.push_back(v);
      fit.fitted.push_back({used[v]->name, markers, rms.back()});
      squares += in_view;
      corners += 4 * markers;
    }
    fit.rms_px = std::sqrt(squares / static_cast<double>(corners));
    std::vector<double> sorted = rms;
    std::sort(sorted.begin(), sorted.end());
    const auto worst = std::max_element(rms.begin(), rms.end());
    const double median = sorted[(sorted.size() - 1) / 2];
    if (*worst > std::max(kWorstViewPx, kWorstViewShare * median) && rms.size() > 2) {
      const std::size_t out = indices[static_cast<std::size_t>(worst - rms.begin())];
      fit.rejected.push_back({used[out]->name,
                              "off by " + PixelText(*worst) +
                                  " (rms) where the median picture is off by " +
                                  PixelText(median)});
      used.erase(used.begin() + static_cast<std::ptrdiff_t>(out));
      continue;
    }
    if (!(fit.rms_px <= kHopelessViewPx)) {
      GiveUp("the pictures miss one board by " + PixelText(fit.rms_px) +
                 ": expected markers that stand still, and this camera's lens",
             fit.rejected);
    }
    for (std::size_t v = 0; v < used.size(); ++v) {
      if (layout.camera_from_world.contains(v)) continue;
      fit.rejected.push_back({used[v]->name, "no two of its markers could be placed"});
    }
    std::set<int> seen;
    for (const MarkerView* view : used) {
      for (const DetectedMarker& marker : view->markers) seen.insert(marker.id);
    }
    fit.board.dictionary = dictionary;
    for (const int id : seen) {
      const auto placed = layout.world_from_marker.find(id);
      if (placed == layout.world_from_marker.end()) {
        fit.unplaced.push_back(id);
        continue;
      }
      BoardMarker marker{id, square};
      for (glm::dvec3& corner : marker.corners_world_m) {
        corner = glm::dvec3(placed->second * glm::dvec4(corner, 1.0));
      }
      fit.board.markers.push_back(marker);
      const auto& [count, sum] = by_marker[id];
      fit.placed.push_back({id, count, std::sqrt(sum / (4.0 * std::max(count, 1)))});
    }
    return fit;
  }
}

double MoveBoardTo(const MarkerBoard& anchor, MarkerBoard& board) {
  if (anchor.dictionary != board.dictionary) {
    throw std::runtime_error("anchor: expected the dictionary " + board.dictionary + ", found " +
                             anchor.dictionary);
  }
  std::vector<glm::dvec3> from;
  std::vector<glm::dvec3> to;
  for (const BoardMarker& known : anchor.markers) {
    for (const BoardMarker& marker : board.markers) {
      if (marker.id != known.id) continue;
      from.insert(from.end(), marker.corners_world_m.begin(), marker.corners_world_m.end());
      to.insert(to.end(), known.corners_world_m.begin(), known.corners_world_m.end());
    }
  }
  if (from.empty()) throw std::runtime_error("anchor: expected a marker that the pictures show");
  const auto matrix = [](const std::vector<glm::dvec3>& points) {
    Eigen::Matrix3Xd result(3, static_cast<Eigen::Index>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i) {
      result.col(static_cast<Eigen::Index>(i)) << points[i].x, points[i].y, points[i].z;
    }
    return result;
  };
  const Eigen::Matrix3Xd target = matrix(to);
  const Eigen::Matrix3Xd source = matrix(from);
  const Eigen::Matrix4d moved_from_board = Eigen::umeyama(source, target, false);
  const auto move = [&](const Eigen::Vector3d& point) -> Eigen::Vector3d {
    return moved_from_board.topLeftCorner<3, 3>() * point + moved_from_board.topRightCorner<3, 1>();
  };
  double squares = 0.0;
  for (Eigen::Index i = 0; i < source.cols(); ++i) {
    squares += (move(source.col(i)) - target.col(i)).squaredNorm();
  }
  for (BoardMarker& marker : board.markers) {
    for (glm::dvec3& corner : marker.corners_world_m) {
      const Eigen::Vector3d moved = move({corner.x, corner.y, corner.z});
      corner = {moved.x(), moved.y(), moved.z()};
    }
  }
  return std::sqrt(squares / static_cast<double>(source.cols()));
}

}  // namespace pleinair
