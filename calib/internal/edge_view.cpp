#include "calib/internal/edge_view.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "scene/upper_median.h"

namespace pleinair {
namespace {

constexpr double kNearestM = 0.05;
constexpr double kProfileStepPx = 0.75;
// A step of light counts from here on, in codes a pixel, and as a share of the profile's steepest.
constexpr double kLeastSlope = 1.5;
constexpr double kLeastSlopeShare = 0.25;
constexpr double kAlongShare = 0.7;  // Slope along the edge over that across it.
// Parallel edges so near match the same step of light.
constexpr double kSameStepPx = 2.0 * kNearPx;

std::string SizeText(int width_px, int height_px) {
  return std::to_string(width_px) + "x" + std::to_string(height_px);
}

}  // namespace

void RequireLensSize(const CameraIntrinsics& lens, const Rgb8Image& picture) {
  if (picture.width == lens.width_px && picture.height == lens.height_px) return;
  throw std::invalid_argument("picture: expected " + SizeText(lens.width_px, lens.height_px) +
                              " pixels, found " + SizeText(picture.width, picture.height));
}

PictureSlopes::PictureSlopes(const Rgb8Image& picture, double sigma_px)
    : tensor_(picture.height, picture.width, CV_32FC3, cv::Scalar(0.0)) {
  const cv::Mat codes(
      picture.height, picture.width, CV_8UC3, const_cast<glm::u8vec3*>(picture.pixels.data()));
  cv::Mat smooth;
  codes.convertTo(smooth, CV_32FC3);
  cv::GaussianBlur(smooth, smooth, {}, sigma_px);
  for (int y = 1; y + 1 < smooth.rows; ++y) {
    for (int x = 1; x + 1 < smooth.cols; ++x) {
      const cv::Vec3f dx = 0.5f * (smooth.at<cv::Vec3f>(y, x + 1) - smooth.at<cv::Vec3f>(y, x - 1));
      const cv::Vec3f dy = 0.5f * (smooth.at<cv::Vec3f>(y + 1, x) - smooth.at<cv::Vec3f>(y - 1, x));
      tensor_.at<cv::Vec3f>(y, x) = {dx.dot(dx), dx.dot(dy), dy.dot(dy)};
    }
  }
}

bool PictureSlopes::Holds(const glm::dvec2& at, double margin_px) const {
  return at.x >= margin_px && at.y >= margin_px && at.x <= tensor_.cols - 1 - margin_px &&
         at.y <= tensor_.rows - 1 - margin_px;
}

double PictureSlopes::Slope(const glm::dvec2& at, const glm::dvec2& direction) const {
  const int x = std::clamp(static_cast<int>(at.x), 0, tensor_.cols - 2);
  const int y = std::clamp(static_cast<int>(at.y), 0, tensor_.rows - 2);
  const float fx = static_cast<float>(std::clamp(at.x - x, 0.0, 1.0));
  const float fy = static_cast<float>(std::clamp(at.y - y, 0.0, 1.0));
  const auto* upper = tensor_.ptr<cv::Vec3f>(y) + x;
  const auto* lower = tensor_.ptr<cv::Vec3f>(y + 1) + x;
  const cv::Vec3f t = (1.0f - fy) * ((1.0f - fx) * upper[0] + fx * upper[1]) +
                      fy * ((1.0f - fx) * lower[0] + fx * lower[1]);
  const double squared = t[0] * direction.x * direction.x + 2.0 * t[1] * direction.x * direction.y +
                         t[2] * direction.y * direction.y;
  return std::sqrt(std::max(squared, 0.0));
}

double EdgePlace::NearestPx() const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const double step : steps_px) {
    if (std::abs(step) < std::abs(nearest)) nearest = step;
  }
  return nearest;
}

std::vector<double> StepsAlong(const PictureSlopes& slopes,
                               const EdgePlace& place,
                               double reach_px) {
  const int count = static_cast<int>(std::ceil(reach_px / kProfileStepPx));
  std::vector<double> profile;
  double steepest = 0.0;
  for (int i = -count - 1; i <= count + 1; ++i) {
    profile.push_back(slopes.Slope(place.pixel + i * kProfileStepPx * place.normal, place.normal));
    steepest = std::max(steepest, profile.back());
  }
  const double least = std::max(kLeastSlope, kLeastSlopeShare * steepest);
  const glm::dvec2 along(-place.normal.y, place.normal.x);
  std::vector<double> steps;
  for (std::size_t i = 1; i + 1 < profile.size(); ++i) {
    const double here = profile[i];
    if (!(here >= least && here > profile[i - 1] && here >= profile[i + 1])) continue;
    const double bend = profile[i - 1] - 2.0 * here + profile[i + 1];
    const double part = bend < 0.0 ? 0.5 * (profile[i - 1] - profile[i + 1]) / bend : 0.0;
    const double offset = (static_cast<double>(i) - count - 1 + part) * kProfileStepPx;
    if (slopes.Slope(place.pixel + offset * place.normal, along) > kAlongShare * here) continue;
    steps.push_back(offset);
  }
  return steps;
}

std::vector<EdgePlace> EdgeView::PlacesOf(const glm::dmat4& pose,
                                          const PictureSlopes& slopes,
                                          std::size_t most) const {
  const glm::dvec3 eye(glm::inverse(pose)[3]);
  std::vector<EdgePlace> places;
  for (std::size_t i = 0; i < edges_.size(); ++i) AddPlaces(i, pose, eye, slopes, places);
  if (places.size() > most) {
    std::vector<EdgePlace> fewer;
    for (std::size_t i = 0; i < most; ++i) fewer.push_back(places[i * places.size() / most]);
    places = std::move(fewer);
  }
  std::vector<EdgePlace> seen;
  for (EdgePlace& place : places) {
    const glm::dvec3 to = place.point_m - eye;
    const double distance = glm::length(to);
    // The edge's own faces end there: what stops the ray a hundredth before it stands before it.
    if (!rays_.Occluded(
            glm::vec3(eye), glm::vec3(to / distance), static_cast<float>(0.99 * distance))) {
      seen.push_back(std::move(place));
    }
  }
  return seen;
}

std::optional<glm::dvec2> EdgeView::Project(const glm::dmat4& pose, const glm::dvec3& point) const {
  const glm::dvec3 at(pose * glm::dvec4(point, 1.0));
  if (!(at.z > kNearestM)) return std::nullopt;
  return lens_.ProjectToPixel(at);
}

void EdgeView::AddPlaces(std::size_t index,
                         const glm::dmat4& pose,
                         const glm::dvec3& eye,
                         const PictureSlopes& slopes,
                         std::vector<EdgePlace>& places) const {
  const MeshEdge& edge = edges_[index];
  if (!edge.is_sharp && !edge.IsOutlineFrom(eye)) return;
  constexpr int kParts = 48;
  constexpr double kMarginPx = 4.0;
  std::optional<glm::dvec2> before;
  double since_px = 0.5 * kEdgePlaceStepPx;
  for (int part = 0; part <= kParts; ++part) {
    const double share = static_cast<double>(part) / kParts;
    const auto here = Project(pose, glm::mix(edge.from_m, edge.to_m, share));
    // A part that is longer begins beside the camera: little of it is in view.
    constexpr double kLongestPx = 4000.0;
    if (here && before && glm::distance(*before, *here) < kLongestPx) {
      const double length = glm::distance(*before, *here);
      // Places at every kEdgePlaceStepPx along the way.
      double at = kEdgePlaceStepPx - since_px;
      for (; at < length; at += kEdgePlaceStepPx) {
        const double inside = at / length;
        EdgePlace place;
        place.edge = index;
        place.point_m =
            glm::mix(edge.from_m, edge.to_m, (part - 1 + inside) / static_cast<double>(kParts));
        place.pixel = glm::mix(*before, *here, inside);
        place.normal = glm::dvec2(before->y - here->y, here->x - before->x) / length;
        if (slopes.Holds(place.pixel, kMarginPx)) places.push_back(std::move(place));
      }
      since_px = length - (at - kEdgePlaceStepPx);
    }
    before = here;
  }
}

double ShiftPx(const EdgeView& view,
               const PictureSlopes& slopes,
               const glm::dmat4& from,
               const glm::dmat4& to) {
  std::vector<double> shifts;
  for (const EdgePlace& place : view.PlacesOf(from, slopes)) {
    const auto there = view.Project(to, place.point_m);
    shifts.push_back(there ? glm::distance(place.pixel, *there)
                           : std::numeric_limits<double>::infinity());
  }
  return UpperMedian(shifts);
}

LinearErrors Linearised(const NormalErrors& errors) {
  LinearErrors linear;
  linear.residuals.resize(errors.NumResiduals());
  linear.jacobian.resize(errors.NumResiduals(), 6);
  const Motion none = Motion::Zero();
  const NormalErrorsAndJacobian linearise(errors);
  linearise(none.data(), linear.residuals.data(), linear.jacobian.data());
  return linear;
}

std::vector<EdgeMatch> MatchesOf(const std::vector<EdgePlace>& places, double scale_px) {
  std::vector<EdgeMatch> matches;
  for (const EdgePlace& place : places) {
    const double nearest = place.NearestPx();
    if (!std::isfinite(nearest)) continue;
    EdgeMatch match;
    match.edge = place.edge;
    match.match = {place.point_m, place.pixel + nearest * place.normal};
    match.normal = place.normal;
    // Geman and McClure's loss: the influence of distant places decreases.
    const double ratio = nearest / scale_px;
    match.root_weight = 1.0 / (1.0 + ratio * ratio);
    matches.push_back(match);
  }
  return matches;
}

std::vector<EdgeGroup> GroupsOf(const std::vector<EdgeMatch>& matches) {
  struct Group {
    glm::dvec2 normal;
    double low;  // Where it reaches along itself.
    double high;
    glm::dvec2 middle;
  };
  std::vector<Group> groups;
  std::vector<EdgeGroup> group_of;
  group_of.reserve(matches.size());
  std::size_t first = 0;
  const auto known_like = [&](const Group& edge) {
    constexpr double kParallel = 0.995;  // The cosine of 6 deg.
    return std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
      const glm::dvec2 along(-group.normal.y, group.normal.x);
      const double there = glm::dot(edge.middle, along);
      return std::abs(glm::dot(edge.normal, group.normal)) > kParallel &&
             std::abs(glm::dot(edge.middle - group.middle, group.normal)) < kSameStepPx &&
             there > group.low && there < group.high;
    });
  };
  while (first < matches.size()) {
    // Samples of one edge follow one another.
    std::size_t end = first;
    glm::dvec2 sum(0.0);
    for (; end < matches.size() && matches[end].edge == matches[first].edge; ++end) {
      sum += matches[end].match.pixel;
    }
    Group edge{matches[first].normal, 0.0, 0.0, sum / static_cast<double>(end - first)};
    const glm::dvec2 along(-edge.normal.y, edge.normal.x);
    edge.low = glm::dot(matches[first].match.pixel, along);
    edge.high = glm::dot(matches[end - 1].match.pixel, along);
    if (edge.low > edge.high) std::swap(edge.low, edge.high);
    const auto like = known_like(edge);
    const auto number = static_cast<std::size_t>(like - groups.begin());
    if (like == groups.end()) groups.push_back(edge);
    const double sign = glm::dot(edge.normal, groups[number].normal) < 0.0 ? -1.0 : 1.0;
    group_of.insert(group_of.end(), end - first, {number, sign});
    first = end;
  }
  return group_of;
}

}  // namespace pleinair
