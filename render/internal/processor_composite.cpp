#include "render/internal/processor_composite.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <span>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vector_relational.hpp>

#include "render/internal/draw_count.h"
#include "render/internal/real_radiance.h"
#include "render/real_sun.h"
#include "render/relit_pixel.h"

namespace pleinair {
namespace {

template <typename Value>
Value TexelOf(const LayerPart<Value>& part, const glm::ivec2& place) {
  return part.rect.Holds(place) ? part.values[part.rect.Index(place)] : Value(0.0f);
}

// Between the four texels around a place in a layer of that size, at its edge the edge's own.
template <typename Value>
Value Bilinear(const LayerPart<Value>& part, const glm::vec2& place, const glm::ivec2& size) {
  const glm::vec2 from_centre = place - 0.5f;
  const glm::vec2 lower = glm::floor(from_centre);
  const glm::vec2 weight = from_centre - lower;
  const auto texel = [&](int dx, int dy) {
    return TexelOf(part,
                   glm::clamp(glm::ivec2(lower) + glm::ivec2(dx, dy), glm::ivec2(0), size - 1));
  };
  return (1.0f - weight.y) * ((1.0f - weight.x) * texel(0, 0) + weight.x * texel(1, 0)) +
         weight.y * ((1.0f - weight.x) * texel(0, 1) + weight.x * texel(1, 1));
}

glm::ivec2 SizeOfLayers(const LayerLookup& lookup) {
  return {lookup.Undistorted().width_px, lookup.Undistorted().height_px};
}

glm::vec2 PlaceInLayers(const LayerLookup& lookup, int x, int y) {
  return lookup.IsIdentity() ? glm::vec2(x, y) + 0.5f : lookup.PlaceOf(x, y);
}

bool IsInside(const glm::ivec2& size, const glm::vec2& place) {
  return place.x > 0.0f && place.y > 0.0f && place.x < static_cast<float>(size.x) &&
         place.y < static_cast<float>(size.y);
}

class PixelByPixel {
 public:
  PixelByPixel(const CompositeInput& input,
               const ProcessorLayers& layers,
               const CompositeLight& light,
               float gain)
      : input_(input),
        layers_(layers),
        change_(input.irradiance_change),
        hidden_sun_(layers.hidden_sun),
        light_(light),
        to_sun_(light.to_sun),
        has_sun_(light.sun_irradiance != glm::vec3(0.0f)),
        gain_(gain),
        layer_size_(SizeOfLayers(layers.lookup)) {
    if (change_ != nullptr) {
      const RgbImage& image = change_->irradiance_rgb;
      change_rect_ = {{change_->x_px, change_->y_px},
                      {change_->x_px + image.width, change_->y_px + image.height}};
    }
    if (hidden_sun_ != nullptr) {
      const GrayImage& image = hidden_sun_->hidden;
      hidden_rect_ = {{hidden_sun_->x_px, hidden_sun_->y_px},
                      {hidden_sun_->x_px + image.width, hidden_sun_->y_px + image.height}};
      blurred_rect_ =
          layers_.shadow_blur.Spread(hidden_rect_, input_.view.Width(), input_.view.Height());
    }
  }

  const PixelRect& ChangeRect() const { return change_rect_; }
  PixelRect ShadowRect() const { return UnionOf(layers_.mask_rect, blurred_rect_); }

  void Put(int x, int y, Composite& result) const {
    const float in_shadow = ShadowAt(x, y);
    const glm::vec3 change = ChangeAt(x, y);
    const glm::vec4 object = ObjectAt(x, y);
    const bool is_covered = object.a > 0.0f;
    const bool may_be_relit = in_shadow > 0.0f || change != glm::vec3(0.0f);
    if (!is_covered && !may_be_relit) return;
    const std::size_t pixel = result.radiance.Index(x, y);
    const glm::vec3 camera = gain_ * input_.camera_radiance.pixels[pixel];
    const bool is_known = IsKnownRadiance(camera);
    RelitRadiance real{camera, false};
    if (may_be_relit && is_known) real = Relight(x, y, camera, in_shadow, change);
    if (is_covered) {
      // The value of a broken camera pixel must not show through an object's edge.
      const glm::vec3 of_object(object);
      real.radiance =
          is_known ? of_object + (1.0f - object.a) * real.radiance : of_object / object.a;
    } else if (!real.is_changed) {
      return;
    }
    result.radiance.pixels[pixel] = real.radiance * (1.0f / gain_);
    result.change.pixels[pixel] =
        static_cast<std::uint8_t>(is_covered ? PixelChange::kCovered : PixelChange::kScaled);
  }

 private:
  // See the pass's shaders.
  float ShadowAt(int x, int y) const {
    if (hidden_sun_ != nullptr && !hidden_rect_.Empty()) {
      return blurred_rect_.Holds({x, y}) ? BlurredHiddenAt(x, y) : 0.0f;
    }
    return layers_.mask_rect.Holds({x, y}) ? ShadowByMask(layers_.mask, layers_.lookup, x, y)
                                           : 0.0f;
  }

  float HiddenAt(int x, int y) const {
    return hidden_rect_.Holds({x, y})
               ? hidden_sun_->hidden.At(x - hidden_sun_->x_px, y - hidden_sun_->y_px)
               : 0.0f;
  }

  bool IsHiddenAlikeAround(int x, int y, int reach) const {
    const float own = HiddenAt(x, y);
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        if (HiddenAt(x + dx, y + dy) != own) return false;
      }
    }
    return true;
  }

  float BlurredHiddenAt(int x, int y) const {
    const int reach = layers_.shadow_blur.ReachPx();
    if (IsHiddenAlikeAround(x, y, reach)) return HiddenAt(x, y);
    const std::span<const float> weights = layers_.shadow_blur.Weights();
    const glm::ivec2 last(input_.view.Width() - 1, input_.view.Height() - 1);
    float sum = 0.0f;
    float whole = 0.0f;
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const glm::ivec2 at = glm::clamp(glm::ivec2(x + dx, y + dy), glm::ivec2(0), last);
        const float weight = weights[static_cast<std::size_t>(std::abs(dx))] *
                             weights[static_cast<std::size_t>(std::abs(dy))] *
                             (1.0f - ObjectAt(at.x, at.y).a);
        sum += weight * HiddenAt(at.x, at.y);
        whole += weight;
      }
    }
    return whole > 1e-4f ? sum / whole : HiddenAt(x, y);
  }

  glm::vec3 ChangeAt(int x, int y) const {
    if (!change_rect_.Holds({x, y})) return glm::vec3(0.0f);
    return change_->irradiance_rgb.At(x - change_->x_px, y - change_->y_px);
  }

  glm::vec4 ObjectAt(int x, int y) const {
    if (!layers_.object_rect.Holds({x, y})) return glm::vec4(0.0f);
    if (layers_.lookup.IsIdentity()) return TexelOf(layers_.object, {x, y});
    const glm::vec2 place = PlaceInLayers(layers_.lookup, x, y);
    return IsInside(layer_size_, place) ? Bilinear(layers_.object, place, layer_size_)
                                        : glm::vec4(0.0f);
  }

  RelitRadiance Relight(
      int x, int y, const glm::vec3& camera, float in_shadow, const glm::vec3& change) const {
    const SurfaceView& view = input_.view;
    const std::size_t pixel = view.region.Index(x, y);
    const glm::vec3& normal = view.normal_world.pixels[pixel];
    if (normal == glm::vec3(0.0f)) return {camera, false};  // There is no surface.
    // Unneeded data is not read: the speed is that of memory.
    glm::vec3 indirect(0.0f);
    for (std::size_t k = 0; k < light_.sky_irradiance.size(); ++k) {
      indirect += light_.sky_irradiance[k] * view.sky_response[k].pixels[pixel];
    }
    glm::vec3 direct(0.0f);
    if (has_sun_) {
      indirect += light_.sun_irradiance * view.sun_bounce.pixels[pixel];
      direct = light_.sun_irradiance * std::max(glm::dot(normal, to_sun_), 0.0f);
    }
    const bool is_clipped = !input_.clipped.Empty() && input_.clipped.pixels[pixel] != 0;
    float s_without = 0.0f;
    if (direct != glm::vec3(0.0f)) {
      const glm::vec3 to_radiance = ToRadiance(pixel);
      s_without = SunSeenWithout({.observed = camera,
                                  .clipped = is_clipped,
                                  .lit = to_radiance * (indirect + direct),
                                  .shaded = to_radiance * indirect,
                                  .model_visibility = view.sun_visibility.pixels[pixel],
                                  .edge_distance_px = view.edge_distance_px.pixels[pixel],
                                  .albedo_measured = view.albedo_measured.pixels[pixel] != 0},
                                 {input_.camera_radiance, input_.clipped, view, gain_},
                                 x,
                                 y);
    }
    const float s_with = (1.0f - in_shadow) * s_without;
    const glm::vec3 before = indirect + s_without * direct;
    // Hidden light is gathered with other rays than all of it: the difference may fall below zero.
    const glm::vec3 after = glm::max(indirect + gain_ * change, glm::vec3(0.0f)) + s_with * direct;
    return Relit({.camera = camera,
                  .clipped = is_clipped,
                  .albedo = view.albedo_rgb.pixels[pixel],
                  .albedo_measured = view.albedo_measured.pixels[pixel] != 0,
                  .irradiance_before = before,
                  .irradiance_after = after});
  }

  glm::vec3 ToRadiance(std::size_t pixel) const {
    return std::numbers::inv_pi_v<float> * input_.view.albedo_rgb.pixels[pixel];
  }

  const CompositeInput& input_;
  const ProcessorLayers& layers_;
  const IrradianceChange* change_;
  const RealSunShare* hidden_sun_;
  const CompositeLight& light_;
  glm::vec3 to_sun_;
  bool has_sun_;
  float gain_;
  glm::ivec2 layer_size_;
  PixelRect change_rect_;
  PixelRect hidden_rect_;
  PixelRect blurred_rect_;
};

}  // namespace

float ShadowByMask(const LayerPart<float>& mask, const LayerLookup& lookup, int x, int y) {
  const glm::ivec2 size = SizeOfLayers(lookup);
  const glm::vec2 place = PlaceInLayers(lookup, x, y);
  float sum = 0.0f;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const glm::vec2 at = place + glm::vec2(dx, dy);
      if (!IsInside(size, at)) continue;
      const float weight = (dx == 0 ? 0.5f : 0.25f) * (dy == 0 ? 0.5f : 0.25f);
      sum +=
          weight * (lookup.IsIdentity() ? TexelOf(mask, glm::ivec2(at)) : Bilinear(mask, at, size));
    }
  }
  return sum;
}

void CompositeByProcessor(const CompositeInput& input,
                          const ProcessorLayers& layers,
                          const CompositeLight& light,
                          float gain,
                          Composite& result) {
  const PixelByPixel pixels(input, layers, light, gain);
  // Passes, though none of OpenGL's.
  for (const PixelRect& rect : {layers.object_rect, pixels.ShadowRect(), pixels.ChangeRect()}) {
    if (!rect.Empty()) CountDraw();
  }
  const PixelRect rect =
      UnionOf(layers.object_rect, UnionOf(pixels.ShadowRect(), pixels.ChangeRect()));
  tbb::parallel_for(rect.lower.y, rect.upper.y, [&](int y) {
    for (int x = rect.lower.x; x < rect.upper.x; ++x) pixels.Put(x, y, result);
  });
}

}  // namespace pleinair
