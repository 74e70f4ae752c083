#include "render/internal/motion_blur.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/lens.h"

namespace pleinair {
namespace {

// Within a hundredth.
template <typename Value>
bool AreAlike(const Value& a, const Value& b, const Value& c) {
  const Value apart = glm::max(a, glm::max(b, c)) - glm::min(a, glm::min(b, c));
  const Value most = 0.01f * glm::abs(b);
  return glm::all(glm::lessThanEqual(glm::vec3(apart), glm::vec3(most)));
}

}  // namespace

MotionBlur::MotionBlur(const MotionInPicture& input,
                       const SurfaceView& view,
                       const LayerLookup& lookup,
                       const glm::dvec3& to_sun,
                       std::span<const VirtualObject> objects)
    : input_(input),
      motion_(input.motion),
      view_(view),
      lookup_(lookup),
      world_from_camera_(glm::inverse(view.camera.camera_from_world)),
      surfaces_(input.motion, view, to_sun, objects) {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const SteadyMotion& own = motion_.objects[i];
    if (std::none_of(groups_.begin(), groups_.end(), [&](const Group& group) {
          return group.motion == own || (!group.motion.Moves() && !own.Moves());
        })) {
      Group& group = groups_.emplace_back();
      group.motion = own;
      group.camera_from_camera = CameraFromCamera(own);
    }
  }
}

ExposedRows MotionBlur::CameraFromCamera(const SteadyMotion& motion) const {
  return OverRows(motion_, view_.Height(), [&](double seconds) {
    return view_.camera.camera_from_world * glm::inverse(motion_.camera.After(seconds)) *
           motion.After(seconds) * world_from_camera_;
  });
}

double MotionBlur::CameraRowOf(const glm::ivec2& layer_pixel) const {
  if (!(motion_.readout_s > 0.0)) return 0.0;
  if (lookup_.IsIdentity()) return layer_pixel.y;
  const CameraIntrinsics& layers = lookup_.Undistorted();
  const auto pixel = ProjectToPixel(view_.camera.intrinsics,
                                    {(layer_pixel.x - layers.cx_px) / layers.fx_px,
                                     (layer_pixel.y - layers.cy_px) / layers.fy_px,
                                     1.0});
  return pixel ? pixel->y : 0.0;
}

// Shift in the picture of a point at that place of the layers, at depth z.
glm::dvec2 MotionBlur::OffsetOf(const glm::dmat4& camera_from_camera,
                                const glm::dvec2& at,
                                double z) const {
  const CameraIntrinsics& layers = lookup_.Undistorted();
  const glm::dvec2 focal(layers.fx_px, layers.fy_px);
  const glm::dvec2 centre(layers.cx_px, layers.cy_px);
  const glm::dvec4 moved = camera_from_camera * glm::dvec4(z * (at - centre) / focal, z, 1.0);
  // A point that comes up to the camera leaves the picture far away.
  constexpr double kNearest = 1e-2;  // Share of the depth before.
  if (!(moved.z > kNearest * z)) return glm::dvec2(0.0);
  return focal * glm::dvec2(moved) / moved.z + centre - at;
}

// The pixels that a group may pass through.
void MotionBlur::FindReach(Group& group) const {
  const ObjectDepths& depths = input_.objects;
  glm::ivec2 lower(std::numeric_limits<int>::max());
  glm::ivec2 upper(std::numeric_limits<int>::min());
  for (int y = 0; y < depths.object.height; ++y) {
    for (int x = 0; x < depths.object.width; ++x) {
      const std::int32_t object = depths.object.At(x, y);
      if (object == ObjectDepths::kNone) continue;
      const SteadyMotion& own = motion_.objects[static_cast<std::size_t>(object)];
      if (own != group.motion && (own.Moves() || group.motion.Moves())) continue;
      const glm::ivec2 pixel(depths.x_px + x, depths.y_px + y);
      const std::size_t row = group.camera_from_camera.IndexOf(CameraRowOf(pixel));
      for (const glm::dmat4* transform :
           {&group.camera_from_camera.start[row], &group.camera_from_camera.end[row]}) {
        const glm::dvec2 offset = OffsetOf(*transform, pixel, double{depths.depth_m.At(x, y)});
        lower = glm::min(lower, glm::ivec2(glm::floor(glm::min(offset, 0.0))) + pixel);
        upper = glm::max(upper, glm::ivec2(glm::ceil(glm::max(offset, 0.0))) + pixel);
      }
    }
  }
  group.rect = {};
  if (upper.x < lower.x) return;
  constexpr int kMargin = 2;  // For edges between pixels, and for rows with another exposure.
  const CameraIntrinsics& layers = lookup_.Undistorted();
  group.rect = ClippedTo({lower - kMargin, upper + kMargin + 1}, layers.width_px, layers.height_px);
}

void MotionBlur::FindDepths(Group& group) const {
  const ObjectDepths& depths = input_.objects;
  const PixelRect& rect = group.rect;
  group.shows.assign(rect.Count(), 0);
  group.depth.assign(rect.Count(), 0.0f);
  cv::Mat1b none(rect.Height(), rect.Width(), std::uint8_t{1});
  for (int y = rect.lower.y; y < rect.upper.y; ++y) {
    for (int x = rect.lower.x; x < rect.upper.x; ++x) {
      const glm::ivec2 place(x - depths.x_px, y - depths.y_px);
      if (!depths.object.Contains(place.x, place.y)) continue;
      const std::int32_t object = depths.object.At(place.x, place.y);
      if (object == ObjectDepths::kNone) continue;
      const SteadyMotion& own = motion_.objects[static_cast<std::size_t>(object)];
      if (own != group.motion && (own.Moves() || group.motion.Moves())) continue;
      const std::size_t index = rect.Index({x, y});
      group.shows[index] = 1;
      group.depth[index] = depths.depth_m.At(place.x, place.y);
      none(y - rect.lower.y, x - rect.lower.x) = 0;
    }
  }
  cv::Mat1f distance;
  cv::Mat1i label;
  cv::distanceTransform(none, distance, label, cv::DIST_L2, 5, cv::DIST_LABEL_PIXEL);
  std::vector<float> of_label;
  const std::size_t count = rect.Count();
  const auto* labels = label.ptr<std::int32_t>();
  for (std::size_t i = 0; i < count; ++i) {
    if (group.shows[i] == 0) continue;
    const auto own = static_cast<std::size_t>(labels[i]);
    if (own >= of_label.size()) of_label.resize(own + 1, 0.0f);
    of_label[own] = group.depth[i];
  }
  for (std::size_t i = 0; i < count; ++i) {
    group.depth[i] = of_label[static_cast<std::size_t>(labels[i])];
  }
}

void MotionBlur::FindPaths(Group& group) const {
  const PixelRect& rect = group.rect;
  group.paths.rect = rect;
  group.paths.ends.resize(rect.Count());
  ForPixels(rect, [&](const glm::ivec2& pixel) {
    const std::size_t row = group.camera_from_camera.IndexOf(CameraRowOf(pixel));
    // Where the point is that comes to this pixel: depths hardly vary over such a way.
    const auto source = [&](const glm::dmat4& transform) {
      constexpr int kRounds = 3;
      glm::dvec2 at(pixel);
      for (int i = 0; i < kRounds; ++i) {
        const glm::ivec2 nearest =
            glm::clamp(NearestPixel(glm::vec2(at)), rect.lower, rect.upper - 1);
        at = glm::dvec2(pixel) - OffsetOf(transform, at, double{group.depth[rect.Index(nearest)]});
      }
      return glm::vec2(at - glm::dvec2(pixel));
    };
    const glm::vec2 start = source(group.camera_from_camera.start[row]);
    const glm::vec2 end = source(group.camera_from_camera.end[row]);
    group.paths.ends[rect.Index(pixel)] = {start, end};
  });
}

// Depth from which an object is certainly behind the real surface: a pixel's middle is not exactly
// where the surface meets an object.
void MotionBlur::FindRealDepths() {
  real_depth_.assign(rect_.Count(), std::numeric_limits<float>::infinity());
  const CameraIntrinsics& layers = lookup_.Undistorted();
  const glm::dmat4& camera_from_world = view_.camera.camera_from_world;
  const bool moves = motion_.camera.Moves();
  real_paths_ = {rect_, {}};
  const ExposedRows of_real = CameraFromCamera({});
  if (moves) real_paths_.ends.assign(rect_.Count(), glm::vec4(0.0f));
  ForPixels(rect_, [&](const glm::ivec2& pixel) {
    const glm::dvec3 ray(
        (pixel.x - layers.cx_px) / layers.fx_px, (pixel.y - layers.cy_px) / layers.fy_px, 1.0);
    glm::ivec2 at = pixel;
    if (!lookup_.IsIdentity()) {
      const auto seen = ProjectToPixel(view_.camera.intrinsics, ray);
      if (!seen) return;
      at = NearestPixel(glm::vec2(*seen));
    }
    if (!view_.region.Contains(at.x, at.y)) return;
    const std::size_t index = view_.region.Index(at.x, at.y);
    if (view_.region.pixels[index] == SurfaceView::kNoRegion) return;
    const glm::dvec4 place(view_.position_world_m.pixels[index], 1.0);
    const double depth = (camera_from_world * place).z;
    const glm::dvec3 normal =
        glm::dmat3(camera_from_world) * glm::dvec3(view_.normal_world.pixels[index]);
    // Depth of a plane is 1 / (a x + b y + c): what it grows by over a pixel and a half.
    const double facing = std::abs(glm::dot(normal, ray));
    const double per_px = std::abs(normal.x) / layers.fx_px + std::abs(normal.y) / layers.fy_px;
    constexpr double kPixels = 1.5;
    constexpr double kRounding = 1e-4;
    const double share = kPixels * per_px / std::max(facing, 1e-6) + kRounding;
    real_depth_[rect_.Index(pixel)] = static_cast<float>(depth * (1.0 + share));
    if (!moves) return;
    const std::size_t row = of_real.IndexOf(at.y);
    real_paths_.ends[rect_.Index(pixel)] =
        -glm::vec4(glm::vec2(OffsetOf(of_real.start[row], pixel, depth)),
                   glm::vec2(OffsetOf(of_real.end[row], pixel, depth)));
  });
}

float MotionBlur::RealDepthAt(const glm::ivec2& layer_pixel) const {
  return rect_.Holds(layer_pixel) ? real_depth_[rect_.Index(layer_pixel)]
                                  : std::numeric_limits<float>::infinity();
}

LayerPart<glm::vec4> MotionBlur::MoveObjects(LayerPart<glm::vec4> layer) {
  layer_ = std::move(layer);
  rect_ = {};
  for (Group& group : groups_) {
    FindReach(group);
    rect_ = UnionOf(rect_, group.rect);
  }
  // Where no ray met an object, at edges, the layer has some of it, too.
  LayerPart<glm::vec4> moved{UnionOf(rect_, layer_.rect), {}};
  FindRealDepths();
  for (Group& group : groups_) {
    if (group.rect.Empty()) continue;
    FindDepths(group);
    group.hidden.assign(group.rect.Count(), 0);
    ForPixels(group.rect, [&](const glm::ivec2& pixel) {
      const std::size_t index = group.rect.Index(pixel);
      const bool is_hidden = group.shows[index] != 0 && group.depth[index] > RealDepthAt(pixel);
      group.hidden[index] = is_hidden ? 1 : 0;
    });
    FindPaths(group);
  }
  moved.values.resize(moved.rect.Count());
  ForPixels(moved.rect, [&](const glm::ivec2& pixel) {
    moved.values[moved.rect.Index(pixel)] = OverExposure(pixel);
  });
  return moved;
}

MotionBlur::Tap MotionBlur::TapAt(const glm::ivec2& layer_pixel, float time) const {
  struct Seen {
    glm::vec4 value;
    float depth;
    int unknown;
  };
  constexpr std::size_t kMostGroups = 8;  // Groups that meet in a pixel; those in front.
  std::array<Seen, kMostGroups> seen;
  std::size_t count = 0;
  float real_depth = -1.0f;  // Not looked up yet.
  for (std::size_t g = 0; g < groups_.size() && count < kMostGroups; ++g) {
    const Group& group = groups_[g];
    if (!group.rect.Holds(layer_pixel)) continue;
    const glm::vec2 at = glm::vec2(layer_pixel) + Along(group.paths.At(layer_pixel), time);
    const glm::ivec2 nearest = NearestPixel(at);
    if (!group.rect.Holds(nearest)) continue;
    const std::size_t source = group.rect.Index(nearest);
    const glm::vec4 value = Cubic(at, [&](const glm::ivec2& texel) {
      if (!layer_.rect.Holds(texel)) return glm::vec4(0.0f);
      // An edge's pixel may lie beside the nearest ray that meets the object.
      const bool is_others = groups_.size() > 1 && group.rect.Holds(texel) &&
                             group.shows[group.rect.Index(texel)] == 0 &&
                             std::any_of(groups_.begin(), groups_.end(), [&](const Group& other) {
                               return &other != &group && other.rect.Holds(texel) &&
                                      other.shows[other.rect.Index(texel)] != 0;
                             });
      return is_others ? glm::vec4(0.0f) : layer_.values[layer_.rect.Index(texel)];
    });
    const glm::ivec2 first(glm::floor(at));
    const glm::ivec2 last(glm::ceil(at));
    const auto is_hidden = [&](int x, int y) {
      return group.rect.Holds({x, y}) && group.hidden[group.rect.Index({x, y})] != 0;
    };
    const bool is_unknown = is_hidden(first.x, first.y) || is_hidden(last.x, first.y) ||
                            is_hidden(first.x, last.y) || is_hidden(last.x, last.y);
    if (!(value.a != 0.0f) && !is_unknown) continue;
    if (real_depth < 0.0f) {
      const glm::ivec2 real =
          real_paths_.ends.empty()
              ? layer_pixel
              : NearestPixel(glm::vec2(layer_pixel) + Along(real_paths_.At(layer_pixel), time));
      real_depth = RealDepthAt(real);
    }
    if (group.depth[source] > real_depth) continue;
    seen[count++] = {value, group.depth[source], is_unknown ? static_cast<int>(g) + 1 : 0};
  }
  const auto visible = std::span(seen).first(count);
  std::sort(visible.begin(), visible.end(), [](const Seen& a, const Seen& b) {
    return a.depth < b.depth;
  });
  Tap tap;
  for (const Seen& one : visible) {
    if (one.unknown != 0) {
      tap.unknown = one.unknown;
      break;
    }
    tap.value += (1.0f - tap.value.a) * one.value;
  }
  return tap;
}

glm::vec4 MotionBlur::OverExposure(const glm::ivec2& layer_pixel) const {
  int steps = 0;
  for (const Group& group : groups_) {
    if (group.rect.Holds(layer_pixel)) {
      steps = std::max(steps, StepsFor(group.paths.At(layer_pixel)));
    }
  }
  if (steps == 0) {
    return layer_.rect.Holds(layer_pixel) ? layer_.values[layer_.rect.Index(layer_pixel)]
                                          : glm::vec4(0.0f);
  }
  glm::vec4 sum(0.0f);
  int unknown = 0;
  for (int step = 0; step < steps; ++step) {
    const Tap tap = TapAt(layer_pixel, TimeOf(step, steps));
    sum += tap.value;
    unknown += tap.unknown != 0 ? 1 : 0;
  }
  if (unknown > 0 && sum.a > 0.0f) {
    const float most = static_cast<float>(steps) / sum.a;
    sum *= std::min(1.0f + static_cast<float>(unknown) / sum.a, most);
  }
  sum /= static_cast<float>(steps);
  constexpr float kLeastCoverage = 1.0f / 512.0f;  // A quarter of a code value in white.
  if (sum.a < kLeastCoverage) return glm::vec4(0.0f);
  sum.a = std::min(sum.a, 1.0f);
  return sum;
}

template <typename Value>
void MotionBlur::MoveOnSurfaces(int& x_px,
                                int& y_px,
                                Image<Value>& image,
                                SurfacePaths::Carried carried) const {
  if (image.Empty()) return;
  const glm::ivec2 lower(x_px, y_px);
  const PixelPaths paths =
      surfaces_.Over({lower, lower + glm::ivec2(image.width, image.height)}, carried);
  const auto texel = [&](const glm::ivec2& pixel) {
    const glm::ivec2 place = pixel - lower;
    return image.Contains(place.x, place.y) ? image.At(place.x, place.y) : Value(0.0f);
  };
  // The loss of sky light has no edges.
  const bool is_smooth = carried == SurfacePaths::Carried::kOtherLight;
  const float px_per_step = is_smooth ? 3.0f : 1.0f;
  Image<Value> moved(paths.rect.Width(), paths.rect.Height());
  ForPixels(paths.rect, [&](const glm::ivec2& pixel) {
    const glm::vec4& ends = paths.At(pixel);
    const int steps = StepsFor(ends, px_per_step);
    const glm::ivec2 in_layers =
        lookup_.IsIdentity() ? pixel : glm::ivec2(glm::floor(lookup_.PlaceOf(pixel.x, pixel.y)));
    const bool may_be_covered = rect_.Holds(in_layers);
    const glm::ivec2 first = NearestPixel(glm::vec2(pixel) + Along(ends, 0.0f));
    const glm::ivec2 last = NearestPixel(glm::vec2(pixel) + Along(ends, 1.0f));
    if (is_smooth && AreAlike(texel(first), texel(pixel), texel(last))) {
      moved.pixels[paths.rect.Index(pixel)] = texel(pixel);
      return;
    }
    const bool stays =
        surfaces_.IsOnSurfaceOf(pixel, first) && surfaces_.IsOnSurfaceOf(pixel, last);
    Value sum(0.0f);
    float weights = 0.0f;
    for (int step = 0; step < steps; ++step) {
      const float time = TimeOf(step, steps);
      const glm::vec2 at = glm::vec2(pixel) + Along(ends, time);
      if (!stays && !surfaces_.IsOnSurfaceOf(pixel, NearestPixel(at))) continue;
      const Value value = is_smooth ? Linear(at, texel) : Cubic(at, texel);
      // While an object covers the pixel, its surface is not visible.
      const float covered = may_be_covered ? TapAt(in_layers, time).value.a : 0.0f;
      const float seen = 1.0f - std::clamp(covered, 0.0f, 1.0f);
      sum += seen * value;
      weights += seen;
    }
    const float least = 1e-3f * static_cast<float>(steps);
    moved.pixels[paths.rect.Index(pixel)] = weights > least ? sum * (1.0f / weights) : texel(pixel);
  });
  x_px = paths.rect.lower.x;
  y_px = paths.rect.lower.y;
  image = std::move(moved);
}

RealSunShare MotionBlur::Moved(const RealSunShare& share) const {
  RealSunShare moved = share;
  MoveOnSurfaces(moved.x_px, moved.y_px, moved.hidden, SurfacePaths::Carried::kSunShadow);
  return moved;
}

IrradianceChange MotionBlur::Moved(const IrradianceChange& change) const {
  IrradianceChange moved = change;
  MoveOnSurfaces(moved.x_px, moved.y_px, moved.irradiance_rgb, SurfacePaths::Carried::kOtherLight);
  return moved;
}

}  // namespace pleinair
